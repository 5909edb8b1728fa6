"""Loads of the water on a slender upright hull of round sections, strip by strip, on one frame or on many."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.components.environment.current import Current, with_current
from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import WaveComponents, unit_waves
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.hull_part import Complexes, Floats, HullPart
from fowtlib.components.hydro.hull_part_slopes import HullPartSlopes, Tangent
from fowtlib.components.hydro.hull_waves import WaterAtStrips
from fowtlib.components.hydro.linear_loads import LARGEST_TILT, PlatformLoad
from fowtlib.components.hydro.strips import Strip, drag_loads, inertia_loads
from fowtlib.language import Array, Component, Scalar, Vector, assert_, at_start, eq, outer, param, var
from fowtlib.language import math as m
from fowtlib.language.expressions import value_of

_ANOTHER = 0.1  # of the diameter at the water level: by so much another section differs
_HEAD, _PER_STRIP = 6, 3  # numbers of a part, and of each of its strips; see HullPart


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
    draft; where a section 10 % wider or narrower than that at rest comes to the water level, or the hull leans by more
    than 45 deg, a run warns. The moment of the vertical pressure within a section is left out (below 0.3 % of the pitch
    moment of a spar).
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
    sea_current: Current = outer(Current, optional=True)

    force: Vector = var(unit="N", doc="load of the water on the part, world")
    moment: Vector = var(unit="N*m", doc="its moment about the frame, world")

    def equations(self):
        count = _HEAD + _PER_STRIP * self.strips
        numbers = at_start("strips", count, "", "buoyancy of this part of the hull, and its strips", _StripNumbers())
        wet, lengthwise, frame = _strips(self, numbers), m.vertcat(0, 0, 1), self.frame
        force, moment = self._buoyancy(numbers, lengthwise)
        water, acceleration = (self._water(name, len(wet)) for name in ("velocity", "acceleration"))
        water = with_current(water, self.sea_current, m.vertcat(*(s.place[2] + self.position[2] for s in wet)))
        for push, turn in (drag_loads(frame, water, wet), inertia_loads(frame, acceleration, wet)):
            force, moment = force + push, moment + turn
        return [
            [eq(self.force, force + self.extra_force), eq(self.moment, moment + self.extra_moment)],
            [*self.push(m.vertcat(self.force, self.moment)), *_near_rest(self)],
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
        unit = {"velocity": "m/s", "acceleration": "m/s^2"}[what]
        value = self.sea.signal(WaterAtStrips(what), 3 * count, f"water {what}", unit, of=self)
        return m.horzcat(value[:count], value[count : 2 * count], value[2 * count :])

    def wave_transfer(self, omega, heading):
        """Complex load (n, 6) per unit wave amplitude on the part at rest, at omega [rad/s] and a heading [rad]."""
        density, gravity, depth = (
            float(self.world.parameter_value(name)) for name in ("water_density", "gravity", "water_depth")
        )
        return _checked(self).wave_load(unit_waves(omega, depth, heading, gravity), density, gravity)

    def numbers(self) -> HullPart:
        """The part with the values that the parameters have now."""
        return value_of(self, "numbers", self._numbers)

    def _numbers(self) -> HullPart:
        values = {name: np.ravel(self.parameter_value(name)) for name in ("heights", "diameters", "position")}
        names = {"low": "low", "high": "high", "added": "added_mass_coefficient", "end_added": "end_added_mass"}
        values |= {name: float(self.parameter_value(given)) for name, given in names.items()}
        return HullPart(**values, count=self.strips, keel=self.keel, waterline=self.waterline)


def _near_rest(part: SlenderHullLoads) -> list[Any]:
    """Warnings where the part that is wet at rest is not the one that is wet."""
    if not part.waterline:
        return []
    rise = part.frame.r[2] - part.position[2]
    reach = at_start("reach", 2, "m", "how far the hull may rise and sink with the same section in the water", _reach)
    lies = "the hull leans by more than 45 deg, where loads of the part that is wet upright mean nothing"
    floats = (
        "the hull has risen by {rise} m (below zero: sunk), so that the section at the water level is another one than "
        "at rest, and loads are those of what is wet there; look at its weight and buoyancy, or take a Floater"
    )
    return [
        assert_(part.frame.R[2, 2] > np.cos(LARGEST_TILT), lies, level="warning"),
        assert_((rise - reach[0]) * (rise + reach[1]) <= 0, floats, level="warning", rise=rise),
    ]


def _reach(part: SlenderHullLoads) -> Floats:
    """How far the hull may rise and sink [m] until the water level comes to another diameter, or to an end."""
    heights, diameters = (np.ravel(part.parameter_value(name)) for name in ("heights", "diameters"))
    own = np.interp(0.0, heights, diameters)
    ways = (np.linspace(0, end, 1001) for end in (min(heights[0], 0.0), max(heights[-1], 0.0)))
    other = ((way, np.abs(np.interp(way, heights, diameters) - own) > _ANOTHER * own) for way in ways)
    return np.array([abs(way[np.argmax(off)] if off.any() else way[-1]) for way, off in other])


def _station(part: SlenderHullLoads, k: int) -> float:
    return float(np.ravel(part.parameter_value("heights"))[k])


def _checked(part: SlenderHullLoads) -> HullPart:
    found = part.numbers()
    found.check(part.label, float(part.world.parameter_value("water_depth")))
    return found


@dataclass(frozen=True)
class _StripNumbers:
    """What a part computes when a run starts, and its slopes; see `fowtlib.solving.closed_slopes`."""

    def __call__(self, part: SlenderHullLoads) -> Floats:
        found = _checked(part)
        return np.concatenate([found.head, found.rows.ravel()])

    def slopes(self, part: SlenderHullLoads, tangent: Tangent) -> Floats:
        return HullPartSlopes.along(part.numbers(), part, tangent).numbers


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


def _elevation(waves: WaveComponents, part: SlenderHullLoads) -> Complexes:
    return part.numbers().elevation(waves)
