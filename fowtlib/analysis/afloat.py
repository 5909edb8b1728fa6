"""How a rigid hull floats: draft, heel and trim at rest, stability about any attitude, its tanks and compartments.

Attitude: n, the vertical in the axes of the hull. With the sinkage for which the water carries the mass M, the
potential Phi(n) of weight and buoyancy has the gradient g G, G = M c - rho S: c the centre of mass, S the first moments
of what is displaced. Upright, and wherever else the hull is at rest, G is along n; the hull comes back where the second
derivative of Phi on the sphere of n is positive, and that over M g is the metacentric height. Liquids in tanks keep
their volume and their surface level, so that their centre moves with n: the free surface takes off what it does by
itself.
Source: J.M.J. Journee and W.W. Massie, Offshore Hydromechanics (2001), ch. 2; K.J. Rawson and E.C. Tupper, Basic Ship
Theory (2001), ch. 4 and 5 (lost buoyancy, free surfaces).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.platform.wetted import Wetted, WettedSurface
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]

UPRIGHT = np.array([0.0, 0.0, 1.0])
AT_REST = 1e-11  # of the size of the hull: an arm of weight and buoyancy that is none
FARTHEST = 0.2  # rad; a step of the attitude
LIMIT = 400  # steps from one attitude to that at rest


@dataclass(frozen=True, eq=False)
class Liquid:
    """A liquid in a closed tank, in the axes of the hull: volume [m^3], density [kg/m^3]; its surface stays level."""

    tank: WettedSurface
    volume: float
    density: float = 1025.0
    name: str = "tank"

    def __post_init__(self):
        room = float(self.tank.whole[0, 0])
        if not 0 <= self.volume <= room * (1 + 1e-9):
            raise ParameterError(f"{self.name}: {self.volume:.6g} m^3 do not fit; it holds 0 to {room:.6g} m^3.")

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.volume

    def at(self, normal: Floats) -> tuple[Floats, Floats]:
        """First moments (3,) [m^4] of the liquid, and their derivatives (3, 3) by the vertical."""
        whole = self.tank.whole
        if self.volume >= whole[0, 0] * (1 - 1e-12) or self.volume == 0:
            share = self.volume / whole[0, 0]
            return share * whole[0, 1:], np.zeros((3, 3))
        below = self.tank.under([level_for([(self.tank, 1.0)], self.volume, normal), *normal])
        return below.moments, _level_slopes(below.slopes)


@dataclass(frozen=True, eq=False)
class Floating:
    """A hull that floats with the vertical `normal` (3,); vectors are in its axes.

    height [m]: of its origin over the water. draft [m]: depth of its deepest point. across (3, 2): level directions, x
    and y where it is upright. second_moments (2, 2) [m^4]: of the waterplane about its centroid, along them.
    metacentric (2, 2) [m]: heights GM for leaning towards them (pitch, roll); arm (2,) [m]: of weight from buoyancy.
    """

    normal: Floats
    height: float
    draft: float
    mass: float
    volume: float
    centre_of_mass: Floats
    centre_of_buoyancy: Floats
    waterplane_area: float
    second_moments: Floats
    across: Floats
    metacentric: Floats
    arm: Floats

    @property
    def metacentric_height(self) -> float:
        """The smallest GM [m] over all directions, with what free surfaces take off."""
        return float(np.linalg.eigvalsh(self.metacentric)[0])

    @property
    def heel(self) -> float:
        """Angle [rad] between the z axis of the hull and the vertical."""
        return math.atan2(float(np.hypot(*self.normal[:2])), float(self.normal[2]))


@dataclass(frozen=True, eq=False)
class Afloat:
    """A rigid hull in still water: its surface, mass [kg] and centre of mass (3,) [m] without liquids, in its axes.

    liquids: in its tanks. flooded: compartments that are open to the sea, with their permeability: what of them is
    under water displaces nothing (lost buoyancy).
    """

    surface: WettedSurface
    mass: float
    centre: ArrayLike
    density: float = 1025.0
    gravity: float = 9.80665
    liquids: tuple[Liquid, ...] = ()
    flooded: tuple[tuple[WettedSurface, float], ...] = ()
    name: str = "the hull"
    _corners: Floats = field(init=False, repr=False)

    def __post_init__(self):
        object.__setattr__(self, "centre", np.asarray(self.centre, dtype=float))
        object.__setattr__(self, "_corners", np.unique(self.surface.triangles.reshape(-1, 3), axis=0))
        if not self.total_mass > 0:
            raise ParameterError(f"{self.name} has no mass.")

    @cached_property
    def total_mass(self) -> float:
        """Mass with liquids [kg]."""
        return self.mass + sum(liquid.mass for liquid in self.liquids)

    def with_flooded(self, *compartments: WettedSurface, permeability: float = 1.0) -> Afloat:
        """The same hull with compartments that are open to the sea."""
        return replace(self, flooded=(*self.flooded, *((one, permeability) for one in compartments)))

    # --- at an attitude ------------------------------------------------------------------------------------------

    @property
    def _pieces(self) -> list[tuple[WettedSurface, float]]:
        return [(self.surface, 1.0), *((one, -share) for one, share in self.flooded)]

    def state(self, normal: Floats) -> tuple[Wetted, float, Floats, Floats]:
        """At a vertical: what is displaced, height of the origin, gradient G (3,) [kg m], its derivatives (3, 3)."""
        wanted, room = self.total_mass / self.density, sum(share * one.whole[0, 0] for one, share in self._pieces)
        if wanted >= room:
            raise ParameterError(
                f"{self.name} sinks: it weighs {self.total_mass:.6g} kg, and all of it displaces "
                f"{room * self.density:.6g} kg; take mass off, close what is open to the sea, or make it larger."
            )
        height = level_for(self._pieces, wanted, normal)
        under = _sum(self._pieces, [height, *normal])
        moment, slopes = self.mass * np.asarray(self.centre), -self.density * _level_slopes(under.slopes)
        for liquid in self.liquids:
            first, change = liquid.at(normal)
            moment, slopes = moment + liquid.density * first, slopes + liquid.density * change
        return under, height, moment - self.density * under.moments, slopes

    def depth(self, normal: Floats, height: float) -> float:
        """Depth [m] of its deepest point with its origin at a height."""
        return float(-(height + self._corners @ normal).min())

    def potential(self, normal: ArrayLike) -> float:
        """Energy [J] of weight and buoyancy at an attitude, at the sinkage at which it floats."""
        normal = np.asarray(normal, dtype=float)
        under, height, _, _ = self.state(normal)
        moment = self.mass * np.asarray(self.centre) + sum(
            (liquid.density * liquid.at(normal)[0] for liquid in self.liquids), np.zeros(3)
        )
        return self.gravity * (self.total_mass * height + float(moment @ normal) + self.density * under.depth)

    def at(self, normal: ArrayLike = UPRIGHT) -> Floating:
        """How it floats with the vertical (3,), held at this attitude and free to heave.

        Raises ParameterError where it sinks.
        """
        normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        under, height, gradient, slopes = self.state(normal)
        across = level_axes(normal)
        lean = float(normal @ gradient)
        centre = (gradient + self.density * under.moments) / self.total_mass
        return Floating(
            normal, height, self.depth(normal, height), self.total_mass, under.volume, centre,
            under.centre, under.area, across.T @ _level_slopes(-under.slopes) @ across, across,
            (across.T @ slopes @ across - lean * np.eye(2)) / self.total_mass,
            across.T @ (centre - under.centre),
        )  # fmt: skip

    def at_rest(self, start: ArrayLike = UPRIGHT) -> Floating:
        """The stable attitude that it comes to from one that it is let go at, without moorings and wind.

        From upright, where that is unstable, the one that it turns over to. Raises ParameterError where it sinks.
        """
        n = np.asarray(start, dtype=float) / np.linalg.norm(start)
        size = float(np.cbrt(self.surface.whole[0, 0]))
        for _ in range(LIMIT):
            _, _, gradient, slopes = self.state(n)
            across = level_axes(n)
            g = across.T @ gradient / self.total_mass
            K = (across.T @ slopes @ across - float(n @ gradient) * np.eye(2)) / self.total_mass
            values, vectors = np.linalg.eigh((K + K.T) / 2)
            if np.linalg.norm(g) < AT_REST * size:
                if values[0] > -1e-9 * size:
                    return self.at(n)
                n = turned(n, across @ vectors[:, 0] * 1e-2)  # off the top of the hill
                continue
            along = vectors.T @ g
            step = vectors @ (-along / np.maximum(np.abs(values), 1e-3 * size * 1e-3))
            step *= min(1.0, FARTHEST / float(np.linalg.norm(step)))
            n = self._lower(n, across @ step, float(g @ step) * self.total_mass * self.gravity)
        raise ParameterError(f"{self.name} finds no attitude at rest; does it roll freely, with nothing to stop it?")

    def _lower(self, n: Floats, step: Floats, slope: float) -> Floats:
        """The attitude a step away, or a part of it, where the energy is lower."""
        energy = self.potential(n)
        for _ in range(30):
            after = turned(n, step)
            if self.potential(after) <= energy + 1e-4 * slope + 1e-13 * abs(energy):
                return after
            step, slope = step / 2, slope / 2
        return after


def turned(n: Floats, step: Floats) -> Floats:
    """The unit vector `step` (3,) [rad, at right angles to n] away from n on the sphere."""
    angle = float(np.linalg.norm(step))
    return n if angle == 0 else math.cos(angle) * n + math.sin(angle) / angle * step


def level_axes(normal: Floats) -> Floats:
    """Two level directions (3, 2) at right angles to the vertical; x and y of an upright hull."""
    forward = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 0.0, -np.sign(normal[0])])
    one = forward - (forward @ normal) * normal
    one /= np.linalg.norm(one)
    return np.stack([one, np.cross(normal, one)], axis=1)


def level_for(pieces: list[tuple[WettedSurface, float]], volume: float, normal: Floats) -> float:
    """The height of the origin over the water at which surfaces, with their shares, have a volume [m^3] below it."""
    heights = np.concatenate([one.triangles.reshape(-1, 3) @ normal for one, _ in pieces])
    e = max(one.half for one, _ in pieces)
    low, high = float(-heights.max()) - e, float(-heights.min()) + e  # all of it under water, nothing
    z, scale = (low + high) / 2, max(abs(volume), 1e-30)
    for _ in range(200):
        under = _sum(pieces, [z, *normal])
        miss = under.volume - volume
        if abs(miss) <= 1e-14 * scale or high - low < 1e-14 * max(abs(low), abs(high)):
            break
        low, high = (z, high) if miss > 0 else (low, z)
        slope = float(under.slopes[0, 0])
        step = -miss / slope if slope < 0 else math.inf
        if abs(step) < 1e-15 * max(abs(z), e):
            break
        z = z + step if low < z + step < high else (low + high) / 2
    return z


def _sum(pieces: list[tuple[WettedSurface, float]], u: ArrayLike) -> Wetted:
    found = [(one.under(u), share) for one, share in pieces]
    if len(found) == 1 and found[0][1] == 1.0:
        return found[0][0]
    moments = sum((share * part.moments for part, share in found), np.zeros(3))
    slopes = sum((share * part.slopes for part, share in found), np.zeros((4, 4)))
    volume, depth = (sum(share * value for value, (_, share) in zip(values, found, strict=True))
                     for values in zip(*((part.volume, part.depth) for part, _ in found), strict=True))  # fmt: skip
    return Wetted(volume, moments, depth, slopes)


def _level_slopes(slopes: Floats) -> Floats:
    """Derivatives (3, 3) of the first moments by the vertical while the volume stays."""
    by_height = slopes[0, 1:]
    if slopes[0, 0] == 0:
        return slopes[1:, 1:]
    return slopes[1:, 1:] - np.outer(by_height, by_height) / slopes[0, 0]
