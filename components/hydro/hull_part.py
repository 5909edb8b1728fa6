"""A slender upright hull of round sections, or a part of one, as strips: volumes, places, loads of waves. NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment.waves import WaveComponents
from fowtlib.components.mechanics.beam_division import gauss_points
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

SMALLEST = 1e-3  # k a below which a cylinder is a point in the wave; the inertia coefficient is 2 within 1e-5 there
NEAR = 1e-6  # m; two heights that are the same
KEPT = 2048  # strips of parts of hulls


def diffraction_coefficient(ka: ArrayLike) -> Complexes:
    """Inertia coefficient C of a fixed vertical cylinder in waves, complex, of the wave number times the radius.

    The force per length is rho pi a^2 C u', with u' the acceleration of the water at the axis as if nothing stood
    there, exp(+i omega t): C = 4 / (i pi (k a)^2 (J1'(k a) - i Y1'(k a))). Long waves: 2.
    Source: R.C. MacCamy and R.A. Fuchs, Beach Erosion Board Technical Memorandum 69 (1954).
    """
    from scipy.special import j0, j1, y0, y1

    x = np.asarray(ka, dtype=float)
    wide = x > SMALLEST
    safe = np.where(wide, x, 1.0)
    slope = j0(safe) - j1(safe) / safe - 1j * (y0(safe) - y1(safe) / safe)
    return np.where(wide, 4 / (1j * np.pi * safe**2 * slope), 2.0)


def diffraction_slope(ka: ArrayLike) -> Complexes:
    """Derivative of the logarithm of that coefficient by k a. Long waves: 0.

    With S = J1' - i Y1', and the equation of Bessel for S': -1/x + (1 - 1/x^2) (J1 - i Y1) / S.
    """
    from scipy.special import j0, j1, y0, y1

    x = np.asarray(ka, dtype=float)
    wide = x > SMALLEST
    safe = np.where(wide, x, 1.0)
    first = j1(safe) - 1j * y1(safe)
    slope = j0(safe) - 1j * y0(safe) - first / safe
    return np.where(wide, -1 / safe + (1 - 1 / safe**2) * first / slope, 0.0)


@dataclass(frozen=True, eq=False)
class HullStrips:
    """A hull between two heights as strips: a Gauss rule of the displaced volume, exact for its first moments.

    height (n,) [m] above the still water, volume (n,) [m^3], drag_area (n,) [m^2] of diameter times length.
    """

    height: Floats
    volume: Floats
    drag_area: Floats


def strip_rule(count: int) -> tuple[Floats, Floats]:
    """Points and weights, from -1 to 1, by which the volume between two marks is known to a rule of so many strips."""
    return _gauss_rule(count + 2)


def strip_marks(heights: Floats, low: float, high: float) -> Floats:
    """Heights [m] from `low` to `high` between which the diameter is linear."""
    return np.concatenate([[low], heights[(heights > low) & (heights < high)], [high]])


@cache
def _gauss_rule(count: int) -> tuple[Floats, Floats]:
    return np.polynomial.legendre.leggauss(count)


def hull_strips(heights: ArrayLike, diameters: ArrayLike, low: float, high: float, count: int) -> HullStrips:
    """The strips between `low` and `high` [m] of a hull with diameters linear between heights [m]."""
    heights, diameters = np.asarray(heights, dtype=float), np.asarray(diameters, dtype=float)
    first, last = int(np.searchsorted(heights, low, "right")) - 1, int(np.searchsorted(heights, high, "left")) + 1
    part = slice(max(first, 0), last)  # other diameters elsewhere are the same strips here
    return _strips_between(heights[part].tobytes(), diameters[part].tobytes(), float(low), float(high), count)


@lru_cache(maxsize=KEPT)
def _strips_between(heights: bytes, diameters: bytes, low: float, high: float, count: int) -> HullStrips:
    heights, diameters = np.frombuffer(heights), np.frombuffer(diameters)
    marks = strip_marks(heights, low, high)
    x, w = strip_rule(count)
    middle, half = (marks[1:] + marks[:-1]) / 2, np.diff(marks) / 2
    z, length = (middle[:, None] + half[:, None] * x).ravel(), (half[:, None] * w).ravel()
    volume = np.pi / 4 * np.interp(z, heights, diameters) ** 2 * length
    places, weights = gauss_points(z - low, volume, high - low, count)
    width = np.interp(places + low, heights, diameters)
    return HullStrips(places + low, weights, weights / (np.pi / 4 * width))


@dataclass(frozen=True, eq=False)
class HullPart:
    """What lies between `low` and `high` [m] of a hull with diameters [m] at heights [m] above the still water level.

    position (3,) [m]: of the frame that carries it, on the axis, at rest. count: number of strips. keel, waterline:
    whether it has them. added, end_added: C_a across the axis, and added mass of the keel along it over rho D^3/3.
    """

    heights: Floats
    diameters: Floats
    low: float
    high: float
    position: Floats
    count: int
    keel: bool
    waterline: bool
    added: float = 1.0
    end_added: float = 1.0

    def check(self, name: str, depth: float) -> None:
        """Raises ParameterError, which names the part, for what cannot be in water of this depth [m]."""
        heights, low, high = self.heights, self.low, self.high
        if len(heights) != len(self.diameters) or len(heights) < 2 or not (np.diff(heights) > 0).all():
            raise ParameterError(
                f"{name}: heights must go up from the keel, two or more, with as many diameters; there are "
                f"{len(heights)} and {len(self.diameters)}."
            )
        if not (heights[0] - NEAR <= low < min(high, 0.0) and high <= heights[-1] + NEAR):
            raise ParameterError(
                f"{name}: its part from {low:g} m to {high:g} m must lie on the hull, which goes from {heights[0]:g} "
                f"m to {heights[-1]:g} m, and begin below the still water level."
            )
        has = {"keel": abs(low - heights[0]) < NEAR, "waterline": high >= 0}
        for what, said in (("keel", self.keel), ("waterline", self.waterline)):
            if said != has[what]:
                raise ParameterError(
                    f"{name}.{what} is {str(said).lower()}, and the part from {low:g} m to {high:g} m "
                    f"{'has' if has[what] else 'does not have'} it; build the model with {what}: "
                    f"{str(has[what]).lower()}."
                )
        if heights[0] < -depth:
            raise ParameterError(
                f"{name}: the keel at {heights[0]:g} m is below the seabed at {-depth:g} m; change the draft, or the "
                "water_depth of the World."
            )

    @cached_property
    def wet(self) -> HullStrips:
        """Its strips."""
        return hull_strips(self.heights, self.diameters, self.low, min(self.high, 0.0), self.count)

    def width(self, height: ArrayLike) -> Floats:
        """Diameter [m] at a height [m]."""
        return np.interp(height, self.heights, self.diameters)

    @property
    def head(self) -> list[float]:
        """Volume, its centre, place of the waterline, area and moment of the waterplane, keel diameter.

        Places are along the axis of the frame, from its origin.
        """
        wet, width, origin = self.wet, float(self.width(0.0)), self.position[2]
        volume = wet.volume.sum()
        centre = wet.volume @ (wet.height - origin) / volume
        return [volume, centre, -origin, np.pi / 4 * width**2, np.pi / 64 * width**4, float(self.width(self.low))]

    @property
    def rows(self) -> Floats:
        """Place along the axis of the frame, volume and drag area of each strip, (n, 3)."""
        return np.column_stack([self.wet.height - self.position[2], self.wet.volume, self.wet.drag_area])

    @cached_property
    def places(self) -> Floats:
        """Places (k, 3) of the strips and the keel at rest, world."""
        z = np.append(self.wet.height, self.low) if self.keel else self.wet.height
        return np.column_stack([np.broadcast_to(self.position[:2], (len(z), 2)), z])

    @cached_property
    def widths(self) -> Floats:
        """Diameters (k,) [m] there."""
        return self.width(self.places[:, 2])

    def elevation(self, waves: WaveComponents) -> Complexes:
        """Elevation (n, 1) of the water at the axis, per unit amplitude."""
        return waves.elevation_transfer(self.position[:2])

    def velocity(self, waves: WaveComponents) -> Complexes:
        """Velocity (n, k, 3) of the water at the places."""
        places = self.places
        return waves.kept(("velocity", places.tobytes()), lambda: waves.velocity_transfer(places))

    def acceleration(self, waves: WaveComponents) -> Complexes:
        """Acceleration (n, k, 3) with which rho dV (1 + C_a) a is the force of MacCamy and Fuchs across the axis."""
        widths = self.widths

        def make() -> Complexes:
            coefficient = diffraction_coefficient(waves.wave_number[:, None] * widths / 2)
            acceleration = 1j * waves.omega[:, None, None] * self.velocity(waves)
            acceleration[:, :, :2] *= (coefficient / (1 + self.added))[:, :, None]
            return acceleration

        return waves.kept(("acceleration", self.places.tobytes(), widths.tobytes(), self.added), make)

    def wave_load(self, waves: WaveComponents, density: float, gravity: float) -> Complexes:
        """Load (n, 6) of waves on the part at rest about its frame, world, per unit amplitude."""
        head, rows, a = self.head, self.rows, self.acceleration(waves)
        mass = density * rows[:, 1, None] * [1 + self.added, 1 + self.added, 1]
        force, places = mass * a[:, : len(rows)], np.column_stack([np.zeros((len(rows), 2)), rows[:, 0]])
        if self.keel:
            end = density * self.end_added * head[5] ** 3 / 3
            force = np.concatenate([force, end * a[:, -1:] * [0, 0, 1]], axis=1)
            places = np.vstack([places, [0, 0, self.low - self.position[2]]])
        if self.waterline:
            lift = density * gravity * head[3] * self.elevation(waves)[:, :, None] * [0, 0, 1]
            force, places = np.concatenate([force, lift], axis=1), np.vstack([places, [0, 0, head[2]]])
        return np.concatenate([force.sum(axis=1), np.cross(places, force).sum(axis=1)], axis=1)
