"""Buoyancy of members at any draft, heel and trim, in place of the linear stiffness of a waterplane."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import WaveComponents
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.linear_loads import PlatformLoad, stiffness_with_buoyancy
from fowtlib.components.platform.member_parts import members_of
from fowtlib.components.platform.members import MemberShape
from fowtlib.components.platform.union import union
from fowtlib.components.platform.wetted import WettedSurface, wetted_function
from fowtlib.language import Component, Number, Scalar, Vector, at_start, eq, facts, outer, param, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from fowtlib.components.platform.floater import Floater


class MemberHydrostatics(PlatformLoad):
    """Buoyancy of the members of a floater as far as they are under water where they are: any draft, heel and trim.

    It stands in a Floater in the place of its `hydrostatics`, whose stiffness is that of small motions. The surface of
    what the members are together, overlaps once, is cut by the water at every instant: exact for boxes, and for round
    members as good as the polygon that stands for a circle, see `sides`. The load is the gradient of a potential, so
    that no closed path gains energy, and once continuously differentiable, see `transition`. A hull that cannot float
    upright is not refused: it turns over.

    What must not be counted twice: the buoyancy of a database (a Floater leaves it out), and with `under_waves` the
    pressure of the waves, which the excitation of a database and Morison's inertia contain; that is refused.
    With `under_waves` the water is the plane that touches the sea at the place of the frame at rest, and the pressure
    below it that of water at rest: for waves that are long against width and draft, since it does not fade with depth.
    Geometry is data of a run: a run takes other diameters. Its `sensitivities` to them come from two surfaces beside
    it, and `Design` takes differences; `gradient` has no derivative by what moves the surface, and says so.
    Source: see the module `wetted`.
    """

    sides: int = param(default=32, min=8, bound=True, doc="corners of the polygon, of equal area, of a round section")
    transition: Number = param(
        default=None, unit="m", min=1e-9, bound=True,
        doc="thickness over which the water ends; without a value: 1/1000 of the cube root of the members' volume",
    )  # fmt: skip
    under_waves: bool = param(default=False, doc="whether the surface is that of the waves; else it is the still one")

    world: World = outer(World)
    sea: Sea = outer(Sea, optional=True)

    volume: Scalar = var(unit="m^3", doc="displaced volume")
    moments: Vector = var(unit="m^4", doc="first moments of that volume in the axes of the frame")
    energy: Scalar = var(unit="J", doc="potential of the buoyancy; none out of the water")
    draft: Scalar = var(unit="m", doc="depth of the origin of the frame below the surface; negative above it")

    def equations(self):
        handle = at_start("surface", 1, "1", "surface of the hull", _surface, functions=(wetted_function(),))
        normal, level = self._water()
        r, R = self.frame.r, self.frame.R
        found = wetted_function()(surface=handle, plane=m.vertcat(-self.draft, m.mtimes(R.T, normal)))
        weight = self.world.water_density * self.world.gravity
        arm = m.mtimes(R, self.moments)
        return [
            eq(self.draft, level - m.dot(normal, r)),
            eq(self.volume, found["volume"]),
            eq(self.moments, found["moments"]),
            eq(self.energy, weight * found["depth"]),
            self.push(m.vertcat(weight * self.volume * normal, weight * m.cross(arm, normal))),
        ]

    def surface(self) -> WettedSurface:
        """The surface of the members, with the values that the parameters have now."""
        thickness = self.parameter_value("transition")
        return surface_of(
            _floater(self), int(self.parameter_value("sides")), None if thickness is None else float(thickness)
        )

    def _water(self):
        """Slopes (3,) of the height over the water in the world, and the height of its plane at the origin."""
        if not self.under_waves:
            return m.vertcat(0, 0, 1), 0
        _refuse_twice(self)
        wave = self.sea.signal(_plane, 3, "surface of the water", "", of=self)
        return m.vertcat(-wave[1], -wave[2], 1), wave[0]

    def upright(self, height: float = 0.0) -> tuple[float, np.ndarray, np.ndarray]:
        """Volume, its centre (3,) and C (6, 6) without weight, upright with the frame at a height above the water."""
        known = self.surface().under((height, 0.0, 0.0, 1.0))
        rho, gravity = (float(self.world.parameter_value(name)) for name in ("water_density", "gravity"))
        S = -known.slopes
        plane = np.zeros((6, 6))
        plane[2, 2:5] = plane[2:5, 2] = [S[0, 0], S[0, 2], -S[0, 1]]
        plane[3, 3], plane[4, 4], plane[3, 4], plane[4, 3] = S[2, 2], S[1, 1], -S[1, 2], -S[1, 2]
        return known.volume, known.centre, rho * gravity * stiffness_with_buoyancy(plane, known.volume, known.centre)

    def facts(self) -> list[facts.Fact]:
        volume, centre, stiffness = self.upright()
        return [
            facts.Number("displaced volume", np.float64(volume), "m^3"),
            facts.Number("centre of buoyancy", centre, "m"),
            facts.Loads("C", stiffness, "N/m"),
        ]


def surface_of(floater: Component, sides: int = 32, transition: float | None = None) -> WettedSurface:
    """The surface of the members of a floater, above the water too, in the axes of its frame."""
    raised = float(floater.parameter_value("raised"))
    return _kept(tuple(member.outside(raised) for member in members_of(floater)), sides, transition)


@lru_cache(maxsize=32)
def _kept(members: tuple[MemberShape, ...], sides: int, transition: float | None) -> WettedSurface:
    return WettedSurface(union(members).triangles(sides), transition)


def _surface(part: MemberHydrostatics) -> WettedSurface:
    return part.surface()


def _floater(part: MemberHydrostatics) -> Floater:
    owner = next(iter(part.enclosing()), None)
    if owner is None or not members_of(owner):
        raise ParameterError(f"{part.label} is not the hydrostatics of a Floater with members; make it a part of one.")
    return owner


def _refuse_twice(part: MemberHydrostatics) -> None:
    """ParameterError where another part has the pressure of the waves too."""
    floater = _floater(part)
    if part.sea is None:
        raise ParameterError(f"{part.label}.under_waves: the model has no Sea.")
    if floater.database is not None and floater.excitation:
        raise ParameterError(
            f"{part.label}.under_waves: the excitation of {floater.label}.database has the pressure of the waves "
            "already; take the one or the other: under_waves = false, or excitation = false."
        )
    for member in members_of(floater):
        if member.sections and member.parameter_value("added_mass_coefficient") is not None:
            raise ParameterError(
                f"{part.label}.under_waves: the inertia of the water on {member.label} has the pressure of the waves "
                "already; take the one or the other: under_waves = false, or no added_mass_coefficient."
            )


def _plane(waves: WaveComponents, part: MemberHydrostatics) -> np.ndarray:
    """Height of the plane at the origin of the world, and its slopes along x and y, per unit amplitude."""
    x, y, _ = np.asarray(_floater(part).parameter_value("position"), dtype=float)
    elevation = waves.elevation_transfer([[x, y]])[:, 0]
    along = -1j * waves.wave_number * elevation
    by_x, by_y = along * np.cos(waves.heading), along * np.sin(waves.heading)
    return np.stack([elevation - by_x * x - by_y * y, by_x, by_y], axis=1)
