"""The members of a floater as components: what they are made of, and what the water does to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.components.environment.current import Current, with_current
from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import WaveComponents, wave_number
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.linear_loads import PlatformLoad
from fowtlib.components.hydro.strips import Strip, deforming_drag_loads, deforming_inertia_loads
from fowtlib.components.hydro.turning_waves import TurningWaveExcitation
from fowtlib.components.platform.contents import Ballast, Bulkhead, LumpedMass
from fowtlib.components.platform.members import MemberShape
from fowtlib.language import Array, Component, Scalar, Vector, at_start, eq, facts, outer, param, shapes, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from fowtlib.components.platform.floater import Floater
    from fowtlib.components.platform.hull import Hull

_PER_STRIP = 8  # place, across_1, across_2, volume, end, volume of an end
_PER_MEMBER = 13  # axes, waterline and its place


class MemberLoads(PlatformLoad):
    """What the water does to the members of a floater, on the frame of the floater: the sum over its members.

    It is a part of a Floater; the loads of each member are variables of the member. `extra_force` and `extra_moment`
    are the inputs of linear models; with `wave_transfer`, which there is where a member has the inertia of the water,
    they give response amplitude operators.
    """

    wave_inputs = ("extra_force", "extra_moment")
    bends = False  # whether there are shapes of coordinates `modes.q` that move the members

    extra_force: Vector = param(default=(0, 0, 0), unit="N", doc="force added to those of the members, world")
    extra_moment: Vector = param(default=(0, 0, 0), unit="N*m", doc="moment added to those of the members, world")

    world: World = outer(World)

    def equations(self):
        members = members_of(next(iter(self.enclosing())))
        loads = [m.vertcat(member.force, member.moment) for member in members]
        return self.push(sum(loads, m.vertcat(self.extra_force, self.extra_moment)))

    @property
    def wave_transfer(self) -> Callable[[np.ndarray, float], np.ndarray]:
        """Complex load (n, 6) per unit wave amplitude, a function of frequencies [rad/s] and a heading [rad]."""
        members = members_of(next(iter(self.enclosing())))
        if not any(map(has_inertia, members)):
            raise AttributeError("no member has the inertia of the water")
        return partial(wave_loads, self.world, members)

    def facts(self) -> list[facts.Fact]:
        members = [one for one in members_of(next(iter(self.enclosing()))) if has_inertia(one)]
        density = float(self.world.parameter_value("water_density"))
        matrix = sum((_added_mass(member) for member in members), np.zeros((6, 6)))
        return [facts.Loads("A(inf)", density * matrix, "kg")] if members else []


class Member(Component):
    """A straight member of a floater, from one point to another. Partial: a subclass says what section it has.

    Points are resolved in the frame of the floater: its reference point on the still water level, z up. Walls are those
    of a closed tube; its ends are open unless Bulkheads close them. Ballast, Bulkhead and LumpedMass are parts of it.
    What lies in a larger member counts there, so a pontoon may run from axis to axis.

    In the water: drag at the place that the member has in motion, with the waves as at its place at rest, on the part
    that is wet at rest; with an `added_mass_coefficient` also the inertia of the water, for members that are slender
    against the waves and in no potential-flow database. See hydro.strips.
    Source: J.R. Morison et al., Petroleum Transactions 189 (1950) 149-154.
    """

    start: Vector = param(unit="m", doc="one end of the axis, resolved in the frame of the floater")
    end: Vector = param(unit="m", doc="the other end")
    stations: Array = param(
        default=(), doc="where sizes and walls are given, 0 at the start to 1 at the end; two values: at the ends"
    )
    wall_thickness: Array = param(default=0.0, unit="m", min=0, doc="thickness of the wall, one or at each station")
    density: Scalar = param(default=7850.0, unit="kg/m^3", min=0, doc="density of the wall")
    end_drag: Array = param(default=(0.0, 0.0), shape=(2,), min=0, doc="C_e along the axis on the wet area of each end")
    end_added_mass: Array = param(
        default=(0.0, 0.0), shape=(2,), min=0, doc="C_a along the axis of each end, on the half ball over it"
    )
    sections: int = param(default=6, min=0, doc="strips in the water; 0: no drag and no inertia")

    world: World = outer(World)
    sea: Sea = outer(Sea, optional=True)
    sea_current: Current = outer(Current, optional=True)
    carrier: MemberLoads = outer(MemberLoads)

    force: Vector = var(unit="N", doc="load of the water on the member, besides buoyancy and potential flow; world")
    moment: Vector = var(unit="N*m", doc="moment of that about the frame of the floater, world")
    on_shapes: Array = var(shape=lambda self: (_shape_count(self),), unit="N", doc="load of that on shapes of bending")

    def drawing(self) -> shapes.Drawing:
        return []  # the floater draws it, since it has the frame

    def section_sizes(self) -> tuple[np.ndarray, bool, float]:
        """Sizes (n, 2) [m] of the section at the stations, whether it is round, and its turn [rad]."""
        raise NotImplementedError

    def coefficients(self, of: str):
        """C_d or C_a for flows along the two directions of the section, in terms of parameters; None for no C_a."""
        raise NotImplementedError

    def numbers(self, raised: float) -> MemberShape:
        """The member with the values that its parameters have now, everything `raised` [m] higher."""
        outside, inner = self.outside(raised), self.parts.values()
        walls = np.broadcast_to(np.ravel(self.parameter_value("wall_thickness")), len(outside.stations))
        return replace(
            outside, walls=tuple(map(float, walls)), density=float(self.parameter_value("density")),
            fills=tuple(part.numbers(raised, outside.length) for part in inner if isinstance(part, Ballast)),
            plates=tuple(part.numbers() for part in inner if isinstance(part, Bulkhead)),
            lumps=tuple(part.numbers(raised) for part in inner if isinstance(part, LumpedMass)),
        )  # fmt: skip

    def outside(self, raised: float) -> MemberShape:
        """What the water sees of it: as `numbers`, without what it is made of and filled with, which is not read."""
        start, end = ((float(x), float(y), float(z) + raised) for x, y, z in
                      (self.parameter_value("start"), self.parameter_value("end")))  # fmt: skip
        length = float(np.linalg.norm(np.subtract(end, start)))
        sizes, is_round, turn = self.section_sizes()
        places = _stations(
            self, {"its section": len(sizes), "wall_thickness": np.size(self.parameter_value("wall_thickness"))}
        )
        sizes = np.broadcast_to(sizes, (len(places), 2))
        return MemberShape(
            self.label, start, end, tuple(float(s * length) for s in places),
            tuple((float(a), float(b)) for a, b in sizes), is_round, turn=turn,
        )  # fmt: skip


class CircularMember(Member):
    """A round member with one diameter or several, linear between them: a column, a brace, a heave plate.

    A step, as of a column on its heave plate, is two stations at one place, or two members. See Member.
    """

    diameters: Array = param(unit="m", min=0, doc="outer diameter, one or at each station")
    drag_coefficient: Scalar = param(default=0.0, min=0, doc="C_d across the axis, on the diameter")
    added_mass_coefficient: Scalar = param(
        default=None, min=0, doc="C_a across the axis, on the displaced water; without a value: no inertia"
    )

    def equations(self):
        return _loads(self)

    def section_sizes(self):
        diameters = np.ravel(self.parameter_value("diameters"))
        return np.stack([diameters, diameters], axis=1), True, 0.0

    def coefficients(self, of):
        return self.drag_coefficient if of == "drag" else self.added_mass_coefficient


class RectangularMember(Member):
    """A member with a rectangular section: a pontoon, a barge.

    Its width is horizontal and its height upright, or as upright as the axis allows; of a vertical member they are
    along x and y. `turn` turns them about the direction from start to end. See Member.
    """

    widths: Array = param(unit="m", min=0, doc="outer width, one or at each station")
    heights: Array = param(unit="m", min=0, doc="outer height, one or at each station")
    turn: Scalar = param(default=0.0, unit="rad", doc="turn of the section about the axis")
    drag_coefficient: Array = param(
        default=(0.0, 0.0), shape=(2,), min=0,
        doc="C_d of a flow along the width, on the height; and of one along the height, on the width",
    )  # fmt: skip
    added_mass_coefficient: Array = param(
        default=None, shape=(2,), min=0,
        doc="C_a along the width and along the height, on the displaced water; if not given: no inertia",
    )  # fmt: skip

    def equations(self):
        return _loads(self)

    def section_sizes(self):
        sizes = [np.ravel(self.parameter_value(name)) for name in ("widths", "heights")]
        count = max(map(len, sizes))
        if any(len(size) not in (1, count) for size in sizes):
            raise ParameterError(f"{self.label}: {len(sizes[0])} widths and {len(sizes[1])} heights; give as many.")
        return (
            np.stack([np.broadcast_to(size, count) for size in sizes], axis=1),
            False,
            float(self.parameter_value("turn")),
        )

    def coefficients(self, of):
        pair = self.drag_coefficient if of == "drag" else self.added_mass_coefficient
        return None if pair is None else (pair[0], pair[1])


def members_of(floater: Component) -> list[Member]:
    """The members of a floater, however deep in it."""
    return [part for part in floater.walk() if isinstance(part, Member)]


def floater_of(member: Component) -> Floater:
    """The floater that a member is a part of."""
    return next(one for one in member.enclosing() if any(isinstance(part, MemberLoads) for part in one.parts.values()))


def _shape_count(member: Component) -> int:
    """How many shapes the carrier of a member bends in; 0: it is rigid."""
    parts = (part for one in member.enclosing() for part in one.parts.values() if isinstance(part, MemberLoads))
    carrier = next(parts, None)
    return carrier.shapes if carrier is not None and carrier.bends else 0


def _loads(member: Member) -> list:
    """The equations of a member: its force and moment, and the loads on the shapes in which it bends."""
    force, moment, on_shapes = m.zeros(3), m.zeros(3), m.zeros(_shape_count(member))
    if member.sections:
        floater = floater_of(member)
        ends = np.cumsum([0, *(_count(one) for one in members_of(floater))]).tolist()
        number = _number(floater, member)
        found = at_start("strips", ends[-1], "", "places and sizes of the strips in the water", _all_strips, of=floater)
        found = found[ends[number] : ends[number + 1]]
        frame, strips = member.carrier.frame, _strips(member, found)
        q = None
        if member.carrier.bends:
            q, strips = member.carrier.modes.q, member.carrier.bending(floater, number, strips)
        velocity = _water(member, "velocity", len(strips), "m/s")
        velocity = with_current(velocity, member.sea_current, m.vertcat(*(strip.place[2] for strip in strips)))
        force, moment, on_shapes = deforming_drag_loads(frame, velocity, strips, q)
        if strips[0].added_mass is not None:
            acceleration = _water(member, "acceleration", len(strips), "m/s^2")
            push, turn, bent = deforming_inertia_loads(frame, acceleration, strips, q)
            lift, tilt = _lifted(member, found)
            force, moment, on_shapes = force + push + lift, moment + turn + tilt, on_shapes + bent
            if q is not None:
                by_line = m.mtimes(frame.R, member.carrier.at_waterline(floater, number))
                on_shapes = on_shapes + m.mtimes(by_line.T, lift)
    return [eq(member.force, force), eq(member.moment, moment), eq(member.on_shapes, on_shapes)]


def _stations(member: Member, counts: dict[str, int]) -> np.ndarray:
    """Where sizes and walls are given, as fractions of the length. Raises ParameterError where the counts differ."""
    given = np.ravel(member.parameter_value("stations"))
    places = given if len(given) else np.array([0.0, 1.0])
    for name, count in counts.items():
        if count not in (1, len(places)):
            raise ParameterError(
                f"{member.label}: {name} has {count} values, and there are {len(places)} stations; give as many."
            )
    if abs(places[0]) > 1e-9 or abs(places[-1] - 1) > 1e-9 or (np.diff(places) < 0).any():
        raise ParameterError(
            f"{member.label}.stations must go from 0, the start, to 1, the end, and up; they are "
            f"{', '.join(f'{s:g}' for s in places)}."
        )
    return places


def _number(floater: Floater, member: Member) -> int:
    return [one.path for one in members_of(floater)].index(member.path)


def _count(member: Member) -> int:
    """How many numbers its strips take."""
    sections = member.parameter_value("sections")
    return _PER_MEMBER + _PER_STRIP * (sections + 2) if sections else 0


def _all_strips(floater: Floater) -> np.ndarray:
    """Places and sizes of the strips of all members, when a run starts."""
    hull, members = floater.hull(), members_of(floater)
    return np.concatenate([_numbers(hull, k, one) for k, one in enumerate(members) if _count(one)])


def _strip_numbers(member: Member) -> np.ndarray:
    """Those of one member."""
    floater = floater_of(member)
    return _numbers(floater.hull(), _number(floater, member), member)


def _numbers(hull: Hull, number: int, member: Member) -> np.ndarray:
    strips = hull.strips(number, member.parameter_value("sections"))
    rows = np.column_stack(
        [strips.places, strips.across_1, strips.across_2, strips.volume, strips.ends, strips.end_volumes]
    )
    return np.concatenate([strips.directions[0], [strips.waterline], strips.waterline_place, rows.ravel()])


def _strips(member: Member, found) -> list[Strip]:
    """The strips of a member in symbols: coefficients are its parameters, places and sizes those of a run."""
    count = member.sections + 2
    axes = [found[3 * k : 3 * k + 3] for k in range(3)]
    rho, drag, added = member.world.water_density, member.coefficients("drag"), member.coefficients("added mass")
    strips = []
    for k in range(count):
        row = found[_PER_MEMBER + _PER_STRIP * k : _PER_MEMBER + _PER_STRIP * (k + 1)]
        last = k - member.sections  # 0 and 1: the ends
        strips.append(Strip(
            row[:3], axes[2], side=axes[0] if isinstance(drag, tuple) else None,
            across=tuple(rho / 2 * C * row[3 + i] for i, C in enumerate(drag)) if isinstance(drag, tuple)
            else rho / 2 * drag * row[3],
            along=rho / 2 * member.end_drag[last] * row[6] if last >= 0 else 0.0,
            volume_mass=rho * row[5],
            added_mass=tuple(rho * C * row[5] for C in added) if isinstance(added, tuple)
            else None if added is None else rho * added * row[5],
            added_along=rho * member.end_added_mass[last] * row[7] if last >= 0 else 0.0,
        ))  # fmt: skip
    return strips


def _places(member: Member) -> np.ndarray:
    """Places (k, 3) of the strips at rest, world."""
    numbers = _strip_numbers(member)[_PER_MEMBER:].reshape(-1, _PER_STRIP)
    return _at_rest(floater_of(member), numbers[:, :3])


def _at_rest(floater: Floater, points: np.ndarray) -> np.ndarray:
    """Places (k, 3) of points of the frame at rest, world; a turning hull rests turned about its pivot."""
    yaw, pivot = float(floater.parameter_value("yaw_at_rest")), np.zeros(3)
    for part in floater.walk():
        if isinstance(part, TurningWaveExcitation):
            pivot = np.asarray(part.parameter_value("pivot"), dtype=float)
    c, s = np.cos(yaw), np.sin(yaw)
    turned = (points - pivot) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return turned + pivot + floater.parameter_value("position")


def _water(member: Member, what: str, count: int, unit: str):
    """Velocity or acceleration (k, 3) of the water at the strips of a member."""
    if member.sea is None:
        return m.zeros(count, 3)
    transfer = {"velocity": _velocity, "acceleration": _acceleration}[what]
    value = member.sea.signal(transfer, 3 * count, f"water {what}", unit, of=member)
    return m.horzcat(value[:count], value[count : 2 * count], value[2 * count :])


def _velocity(waves: WaveComponents, member: Member) -> np.ndarray:
    return waves.velocity_transfer(_places(member)).transpose(0, 2, 1).reshape(len(waves), -1)


def _acceleration(waves: WaveComponents, member: Member) -> np.ndarray:
    return waves.acceleration_transfer(_places(member)).transpose(0, 2, 1).reshape(len(waves), -1)


def _elevation(waves: WaveComponents, member: Member) -> np.ndarray:
    return waves.elevation_transfer(_at_rest(floater_of(member), _strip_numbers(member)[None, 10:13]))


def has_inertia(member: Member) -> bool:
    """Whether a member has the inertia of the water, and with it the load of the waves."""
    return bool(member.sections) and member.parameter_value("added_mass_coefficient") is not None


def _added_volumes(member: Member, found: np.ndarray) -> np.ndarray:
    """Added mass (k, 3, 3) of the strips over the density of the water, in the axes of the floater."""
    axes, rows = found[:9].reshape(3, 3), found[_PER_MEMBER:].reshape(-1, _PER_STRIP)
    added = np.diag(np.broadcast_to(member.parameter_value("added_mass_coefficient"), 2))
    ends = np.zeros(len(rows))
    ends[-2:] = rows[-2:, 7] * member.parameter_value("end_added_mass")
    along = np.einsum("k,i,j->kij", ends, axes[2], axes[2])
    return along + np.einsum("k,ij->kij", rows[:, 5], axes[:2].T @ added @ axes[:2])


def _added_mass(member: Member) -> np.ndarray:
    """Added mass (6, 6) of a member about the frame of the floater, over the density of the water."""
    found = _strip_numbers(member)
    places = found[_PER_MEMBER:].reshape(-1, _PER_STRIP)[:, :3]
    motion = np.array([np.hstack([np.eye(3), np.cross(place, np.eye(3))]) for place in places])  # v + w x place
    return np.einsum("kia,kij,kjb->ab", motion, _added_volumes(member, found), motion)


def wave_forces(world: World, member: Member, omega: np.ndarray, heading: float) -> tuple[np.ndarray, np.ndarray]:
    """Complex forces (n, k, 3) of a wave of unit amplitude on a member at rest: on its strips, and at its water line.

    The second: their places (k, 3) in the frame of the floater.
    """
    depth, gravity, rho = (float(world.parameter_value(name)) for name in ("water_depth", "gravity", "water_density"))
    omega = np.asarray(omega, dtype=float)
    one, number = np.ones(len(omega)), wave_number(omega, depth, gravity)
    waves = WaveComponents(omega, one, 0 * one, number, heading, np.inf, depth)
    found, a = _strip_numbers(member), waves.acceleration_transfer(_places(member))
    rows = found[_PER_MEMBER:].reshape(-1, _PER_STRIP)
    mass = rows[:, 5, None, None] * np.eye(3) + _added_volumes(member, found)
    force = rho * np.einsum("kij,nkj->nki", mass, a)
    lift = rho * gravity * found[9] * _elevation(waves, member) * [[0, 0, 1]]
    return np.concatenate([force, lift[:, None, :]], axis=1), np.vstack([rows[:, :3], found[10:13]])


def wave_loads(world: World, members: list[Member], omega: np.ndarray, heading: float) -> np.ndarray:
    """Complex load (n, 6) of a wave of unit amplitude on members at rest, about their frame."""
    total = np.zeros((len(omega), 6), dtype=complex)
    for member in filter(has_inertia, members):
        force, places = wave_forces(world, member, omega, heading)
        total += np.concatenate([force.sum(axis=1), np.cross(places, force).sum(axis=1)], axis=1)
    return total


def _lifted(member: Member, found):
    """Force and moment of the wave on the section at the water level: rho g elevation S, upwards."""
    if member.sea is None:
        return m.zeros(3), m.zeros(3)
    elevation = member.sea.signal(_elevation, 1, "wave at the water line", "m", of=member)
    lift = m.vertcat(0, 0, member.world.water_density * member.world.gravity * found[9] * elevation)
    return lift, m.cross(m.mtimes(member.carrier.frame.R, found[10:13]), lift)
