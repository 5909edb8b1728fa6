"""Loads of the water on a slender upright hull of round sections, strip by strip, on one frame or on many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import h2vp

from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import WaveComponents, unit_waves
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.linear_loads import PlatformLoad
from fowtlib.components.hydro.strips import Strip, drag_loads, inertia_loads
from fowtlib.components.mechanics.beam_division import gauss_points
from fowtlib.language import Array, Component, Scalar, Vector, at_start, eq, outer, param, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]

SMALLEST = 1e-3  # k a below which a cylinder is a point in the wave; the inertia coefficient is 2 within 1e-5 there
_HEAD, _PER_STRIP = 6, 3  # numbers of a part of a hull, see _numbers; of each strip place, volume, drag area


def diffraction_coefficient(ka: ArrayLike) -> NDArray[np.complex128]:
    """Inertia coefficient C of a fixed vertical cylinder in waves, complex, of the wave number times the radius.

    The force per length is rho pi a^2 C u', with u' the acceleration of the water at the axis as if nothing stood
    there, exp(+i omega t): C = 4 / (i pi (k a)^2 (J1'(k a) - i Y1'(k a))). Long waves: 2.
    Source: R.C. MacCamy and R.A. Fuchs, Beach Erosion Board Technical Memorandum 69 (1954).
    """
    x = np.asarray(ka, dtype=float)
    wide = x > SMALLEST
    safe = np.where(wide, x, 1.0)
    return np.where(wide, 4 / (1j * np.pi * safe**2 * h2vp(1, safe)), 2.0)


@dataclass(frozen=True, eq=False)
class HullStrips:
    """A hull between two heights as strips: a Gauss rule of the displaced volume, exact for its first moments.

    height (n,) [m] above the still water, volume (n,) [m^3], drag_area (n,) [m^2] of diameter times length.
    """

    height: Floats
    volume: Floats
    drag_area: Floats


def hull_strips(heights: ArrayLike, diameters: ArrayLike, low: float, high: float, count: int) -> HullStrips:
    """The strips between `low` and `high` [m] of a hull with diameters linear between heights [m]."""
    heights, diameters = np.asarray(heights, dtype=float), np.asarray(diameters, dtype=float)
    marks = np.concatenate([[low], heights[(heights > low) & (heights < high)], [high]])
    x, w = np.polynomial.legendre.leggauss(count + 2)
    middle, half = (marks[1:] + marks[:-1]) / 2, np.diff(marks) / 2
    z, length = (middle[:, None] + half[:, None] * x).ravel(), (half[:, None] * w).ravel()
    volume = np.pi / 4 * np.interp(z, heights, diameters) ** 2 * length
    places, weights = gauss_points(z - low, volume, high - low, count)
    width = np.interp(places + low, heights, diameters)
    return HullStrips(places + low, weights, weights / (np.pi / 4 * width))


class HullCoefficients(Component):
    """Partial: what a slender hull resists the water with."""

    drag_coefficient: Scalar = param(default=0.0, min=0, doc="C_d across the axis, on the diameter")
    added_mass_coefficient: Scalar = param(default=1.0, min=0, doc="C_a across the axis, on the displaced water")
    end_drag: Scalar = param(default=0.0, min=0, doc="C_e along the axis, on the area of the keel")
    end_added_mass: Scalar = param(default=1.0, min=0, doc="added mass of the keel along the axis, over rho D^3/3")


class SlenderHullLoads(PlatformLoad, HullCoefficients):
    """What the water does to a slender upright hull of round sections, or to a part of one that is rigid.

    The hull has diameters at heights above the still water level, linear between, keel first; the frame is on its axis
    and carries it between `low` and `high`. A rigid hull is one such part; of an elastic one each rigid piece is one.

    Waves: across the axis the force of MacCamy and Fuchs at each strip for its diameter and any heading, in time and at
    frequencies the same; along it the pressure on cones and keel as if no hull were there, which is rho dV a' of the
    vertical acceleration and rho g elevation S at the water level, and the added mass of the keel times a'.
    Motion: added mass rho C_a pi D^2/4 across the axis, rho D^3/3 of a disc along it at the keel; no radiated waves.
    Drag: 1/2 rho C_d D |u| u across the axis with the velocity u of the water against the strip, C_e along it on the
    keel. Rest: each part displaces its own volume, lifted at its centre as it moves and tilts; with the waterplane this
    is the stiffness rho g V z_B + rho g I about the water level. Loads are those of the wet part at rest, at the places
    that it has in motion.

    Good for hulls many diameters deep, whose diameter changes slowly (cones of 10 deg or so), in waves of any length
    against the diameter; not for pontoons, plates or steps, nor for waves that move the water level by much of the
    draft. The moment of the vertical pressure within a section is left out (below 0.3 % of the pitch moment of a spar).
    Source: 2.4 and 3.2 in O.M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990); MacCamy and Fuchs (1954).
    """

    wave_inputs = ("extra_force", "extra_moment")

    heights: Array = param(unit="m", doc="stations of the hull above the still water level at rest, keel first")
    diameters: Array = param(unit="m", min=0, doc="outer diameters at the stations")
    low: Scalar = param(default=lambda self: _station(self, 0), unit="m", doc="height where this part begins")
    high: Scalar = param(default=lambda self: _station(self, -1), unit="m", doc="height where this part ends")
    keel: bool = param(default=True, doc="the part has the keel, at its low end")
    waterline: bool = param(default=True, doc="the part reaches through the still water level")
    strips: int = param(default=12, min=1, doc="strips of this part")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame at rest, world")
    extra_force: Vector = param(default=(0, 0, 0), unit="N", doc="force added to that of the water, world")
    extra_moment: Vector = param(default=(0, 0, 0), unit="N*m", doc="moment added to that of the water, world")

    world: World = outer(World)
    sea: Sea = outer(Sea, optional=True)

    force: Vector = var(unit="N", doc="load of the water on the part, world")
    moment: Vector = var(unit="N*m", doc="its moment about the frame, world")

    def equations(self):
        count = _HEAD + _PER_STRIP * self.strips
        numbers = at_start("strips", count, "", "buoyancy of this part of the hull, and its strips", _numbers)
        wet, lengthwise, frame = _strips(self, numbers), m.vertcat(0, 0, 1), self.frame
        force, moment = self._buoyancy(numbers, lengthwise)
        water, acceleration = (self._water(name, len(wet)) for name in ("velocity", "acceleration"))
        for push, turn in (drag_loads(frame, water, wet), inertia_loads(frame, acceleration, wet)):
            force, moment = force + push, moment + turn
        return [
            [eq(self.force, force + self.extra_force), eq(self.moment, moment + self.extra_moment)],
            self.push(m.vertcat(self.force, self.moment)),
        ]

    def _buoyancy(self, numbers, up):
        """Lift of the volume, and where the hull passes the water level the load of its waterplane."""
        R, weight = self.frame.R, self.world.water_density * self.world.gravity
        lift = weight * numbers[0] * up
        moment = m.cross(R[:, 2] * numbers[1], lift)
        if not self.waterline:
            return lift, moment
        arm = R[:, 2] * numbers[2]
        elevation = self.sea.signal(_elevation, 1, "wave at the water line", "m", of=self) if self.sea else 0
        raised = self.frame.r[2] + arm[2]
        plane = weight * numbers[3] * (elevation - raised) * up
        slope = m.vertcat(-R[1, 2], R[0, 2], 0) / R[2, 2]
        return lift + plane, moment + m.cross(arm, plane) - weight * numbers[4] * slope

    def _water(self, what, count):
        """Velocity, or acceleration as the strips feel it, of the water at the strips and the keel, (count, 3)."""
        if self.sea is None:
            return m.zeros(count, 3)
        transfer, unit = {"velocity": (_velocity, "m/s"), "acceleration": (_acceleration, "m/s^2")}[what]
        value = self.sea.signal(transfer, 3 * count, f"water {what}", unit, of=self)
        return m.horzcat(value[:count], value[count : 2 * count], value[2 * count :])

    def wave_transfer(self, omega, heading):
        """Complex load (n, 6) per unit wave amplitude on the part at rest, at omega [rad/s] and a heading [rad]."""
        density, gravity, depth = (
            float(self.world.parameter_value(name)) for name in ("water_density", "gravity", "water_depth")
        )
        waves, found = unit_waves(omega, depth, heading, gravity), _numbers(self)
        rows, (added, end) = found[_HEAD:].reshape(-1, _PER_STRIP), _added(self, found)
        a = _felt(waves, self)
        across = density * (rows[:, 1] + added)[:, None] * np.array([1, 1, 0]) + density * rows[:, 1, None] * [0, 0, 1]
        force = across * a[:, : len(rows)]
        places = np.column_stack([np.zeros((len(rows), 2)), rows[:, 0]])
        if self.keel:
            force = np.concatenate([force, density * end * a[:, -1:] * [0, 0, 1]], axis=1)
            places = np.vstack([places, [0, 0, _keel(self)]])
        if self.waterline:
            lift = density * gravity * found[3] * _elevation(waves, self)[:, None] * [[[0, 0, 1]]]
            force, places = np.concatenate([force, lift], axis=1), np.vstack([places, [0, 0, found[2]]])
        return np.concatenate([force.sum(axis=1), np.cross(places, force).sum(axis=1)], axis=1)


def _station(part: SlenderHullLoads, k: int) -> float:
    return float(np.ravel(part.parameter_value("heights"))[k])


def _numbers(part: SlenderHullLoads) -> Floats:
    """Volume, its centre, place of the waterline, area and moment of the waterplane, keel diameter; then the strips.

    Places are along the axis of the frame, from its origin.
    """
    heights, diameters, low, high, origin = _geometry(part)
    found = hull_strips(heights, diameters, low, min(high, 0.0), part.strips)
    volume, width = found.volume.sum(), float(np.interp(0.0, heights, diameters))
    rows = np.column_stack([found.height - origin, found.volume, found.drag_area])
    head = [
        volume, found.volume @ (found.height - origin) / volume, -origin, np.pi / 4 * width**2, np.pi / 64 * width**4,
        float(np.interp(low, heights, diameters)),
    ]  # fmt: skip
    return np.concatenate([head, rows.ravel()])


def _geometry(part: SlenderHullLoads) -> tuple[Floats, Floats, float, float, float]:
    """Heights, diameters, low, high, and the height of the frame at rest; checked."""
    heights, diameters = (np.ravel(part.parameter_value(name)) for name in ("heights", "diameters"))
    low, high = (float(part.parameter_value(name)) for name in ("low", "high"))
    position = np.ravel(part.parameter_value("position"))
    if len(heights) != len(diameters) or len(heights) < 2 or not (np.diff(heights) > 0).all():
        raise ParameterError(
            f"{part.label}: heights must go up from the keel, two or more, with as many diameters; there are "
            f"{len(heights)} and {len(diameters)}."
        )
    if not (heights[0] - 1e-6 <= low < min(high, 0.0) and high <= heights[-1] + 1e-6):
        raise ParameterError(
            f"{part.label}: its part from {low:g} m to {high:g} m must lie on the hull, which goes from {heights[0]:g} "
            f"m to {heights[-1]:g} m, and begin below the still water level."
        )
    for what, said, is_so in (
        ("keel", part.keel, abs(low - heights[0]) < 1e-6),
        ("waterline", part.waterline, high >= 0),
    ):
        if said != is_so:
            raise ParameterError(
                f"{part.label}.{what} is {str(said).lower()}, and the part from {low:g} m to {high:g} m "
                f"{'has' if is_so else 'does not have'} it; build the model with {what}: {str(is_so).lower()}."
            )
    depth = float(part.world.parameter_value("water_depth"))
    if heights[0] < -depth:
        raise ParameterError(
            f"{part.label}: the keel at {heights[0]:g} m is below the seabed at {-depth:g} m; change the draft, or the "
            "water_depth of the World."
        )
    return heights, diameters, low, high, float(position[2])


def _strips(part: SlenderHullLoads, numbers) -> list[Strip]:
    """The strips in symbols, and the keel."""
    rho, axis, found = part.world.water_density, (0.0, 0.0, 1.0), []
    for k in range(part.strips):
        z, volume, area = (numbers[_HEAD + _PER_STRIP * k + i] for i in range(_PER_STRIP))
        found.append(Strip(
            m.vertcat(0, 0, z), axis, across=rho / 2 * part.drag_coefficient * area, volume_mass=rho * volume,
            added_mass=rho * part.added_mass_coefficient * volume,
        ))  # fmt: skip
    if part.keel:
        width = numbers[5]
        found.append(Strip(
            m.vertcat(0, 0, part.low - part.position[2]), axis, across=0.0,
            along=rho / 2 * part.end_drag * m.pi / 4 * width**2, added_mass=0.0,
            added_along=rho * part.end_added_mass * width**3 / 3,
        ))  # fmt: skip
    return found


def _added(part: SlenderHullLoads, numbers: Floats) -> tuple[Floats, float]:
    """Added mass over the density: across at the strips, along at the keel."""
    rows = numbers[_HEAD:].reshape(-1, _PER_STRIP)
    end = float(part.parameter_value("end_added_mass")) * numbers[5] ** 3 / 3
    return float(part.parameter_value("added_mass_coefficient")) * rows[:, 1], end


def _keel(part: SlenderHullLoads) -> float:
    """Place of the keel along the axis of the frame."""
    return float(part.parameter_value("low")) - float(np.ravel(part.parameter_value("position"))[2])


def _places(part: SlenderHullLoads) -> Floats:
    """Places (k, 3) of the strips and the keel at rest, world."""
    z = _numbers(part)[_HEAD:].reshape(-1, _PER_STRIP)[:, 0]
    z = np.append(z, _keel(part)) if part.keel else z
    return np.column_stack([np.zeros((len(z), 2)), z]) + np.ravel(part.parameter_value("position"))


def _elevation(waves: WaveComponents, part: SlenderHullLoads) -> NDArray[np.complex128]:
    return waves.elevation_transfer((*np.ravel(part.parameter_value("position"))[:2], 0.0))


def _velocity(waves: WaveComponents, part: SlenderHullLoads) -> NDArray[np.complex128]:
    return waves.velocity_transfer(_places(part)).transpose(0, 2, 1).reshape(len(waves), -1)


def _acceleration(waves: WaveComponents, part: SlenderHullLoads) -> NDArray[np.complex128]:
    return _felt(waves, part).transpose(0, 2, 1).reshape(len(waves), -1)


def _felt(waves: WaveComponents, part: SlenderHullLoads) -> NDArray[np.complex128]:
    """Acceleration (n, k, 3) with which rho dV (1 + C_a) a is the force of MacCamy and Fuchs across the axis."""
    places, (heights, diameters, *_) = _places(part), _geometry(part)
    radius = np.interp(places[:, 2], heights, diameters) / 2
    coefficient = diffraction_coefficient(waves.wave_number[:, None] * radius)
    share = coefficient / (1 + float(part.parameter_value("added_mass_coefficient")))
    acceleration = waves.acceleration_transfer(places)
    acceleration[:, :, :2] *= share[:, :, None]
    return acceleration
