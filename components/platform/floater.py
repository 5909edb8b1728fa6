"""Floaters that are described by their members."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.linear_loads import Hydrostatics, read_database
from fowtlib.components.hydro.potential_flow import FlowSettings, LinearPotentialFlow
from fowtlib.components.mechanics.bodies import FixedTranslation, RigidBody
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.platform.hull import APART, Hull
from fowtlib.components.platform.member_parts import MemberLoads, members_of
from fowtlib.components.platform.members import MemberShape
from fowtlib.components.platform.regimes import regime
from fowtlib.language import Array, Data, Number, Scalar, Vector, data, outer, param, port, shapes
from fowtlib.language.errors import ParameterError
from fowtlib.language.expressions import StartNumbers

_NUMBERS = 1 + 3 + 9 + 1 + 3 + 36  # mass, centre, inertia, volume, centre of buoyancy, stiffness
_RHO = 1025.0  # density for which the stiffness is computed; Hydrostatics scales it


class Floater(FlowSettings):
    """A rigid hull of members: its mass, its buoyancy, the drag of its members, and, where given, a potential flow.

    Its parts of class CircularMember and RectangularMember, added under any name and at any depth, are its members.
    Mass, centre and inertia, displaced volume and waterplane follow from them when a run starts, so that diameters,
    drafts and levels of ballast may be changed in a built model. What members share counts once (see `hull`).

    frame is the reference point of the hull, on the still water level at rest; `nodes` are frames at further points,
    for towers and moorings. With a `database` added mass, radiation and wave loads come from there; buoyancy and
    stiffness stay those of the members, whose volume must be that of the database within 5 %. Without one, members with
    an `added_mass_coefficient` have the inertia of the water. With `turning` the wave loads of the database follow the
    yaw; the waves in the drag of members are those at the places that these have at the `yaw_at_rest`.
    Raises ParameterError for members that do not meet, ballast above its tank, and a hull that turns over.
    """

    raised: Scalar = param(default=0.0, unit="m", doc="how much higher members lie than their coordinates say")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame at rest, world; z is zero")
    database: Data[HydrodynamicDatabase] = data(read_database, default=None, doc="potential flow of the hull, or none")
    yaw_at_rest: Number = param(
        default=0.0, unit="rad", bound=True, doc="of a turning hull: its members resist the waves at their places there"
    )
    held_upright: bool = param(default=False, doc="moorings hold it upright, as a TLP: it may be unstable without them")
    material: str = param(default="hull", choices=shapes.MATERIALS, doc="what it looks like; glass is seen through")
    node_points: Array = param(default=(), unit="m", doc="points (n, 3) that get frames of their own, in the frame")

    frame: Frame = port(doc="reference point, on the still water level")
    nodes: Frame = port(size=lambda self: len(self.node_rows()), optional=True, doc="frames at the node_points")

    world: World = outer(World)
    sea: Sea = outer(Sea, optional=True)

    def build(self):
        found = StartNumbers(self, "hull", _NUMBERS, hull_numbers)
        self.body = RigidBody(
            mass=found[0], r_cm=[found[k] for k in (1, 2, 3)],
            inertia=[[found[4 + 3 * i + k] for k in range(3)] for i in range(3)],
        )  # fmt: skip
        self.hydrostatics = Hydrostatics(
            volume=found[13], centre_of_buoyancy=[found[k] for k in (14, 15, 16)],
            stiffness=[[found[17 + 6 * i + k] for k in range(6)] for i in range(6)], reference_density=_RHO,
            position=self.position,
        )  # fmt: skip
        self.member_loads = self.loads_of_members()
        self.connect(self.frame, self.body.frame_a)
        self.connect(self.frame, self.hydrostatics.frame)
        self.connect(self.frame, self.member_loads.frame)
        if self.database is not None:
            given = {"database": self.parameter_binding("database"), "position": self.position}
            self.potential_flow = self.flow(**given, **self.values_of(FlowSettings))
            self.connect(self.frame, self.potential_flow.frame)
        for k, (x, y, z) in enumerate(self.node_rows()):
            self.carry(k, [x, y, z + self.raised])

    def loads_of_members(self) -> MemberLoads:
        """The loads of the water on its members."""
        return MemberLoads()

    def flow(self, **settings) -> LinearPotentialFlow:
        """The potential flow of its database."""
        return LinearPotentialFlow(buoyancy=False, **settings)

    def carry(self, k: int, point: list) -> None:
        """Join node k, at a point of the frame, to the hull."""
        rod = self.add(f"to_node_{k + 1}", FixedTranslation(r=point, diameter=0))
        self.connect(self.frame, rod.frame_a)
        self.connect(rod.frame_b, self.nodes[k])

    def node_rows(self) -> list:
        """The points of the nodes, row by row."""
        points = np.asarray(self.parameter_value("node_points"), dtype=float)
        if points.size and (points.ndim != 2 or points.shape[1] != 3):
            raise ParameterError(f"{self.label}.node_points must be a list of points (x, y, z).")
        return [[self.node_points[k, i] for i in range(3)] for k in range(len(points))] if points.size else []

    def hull(self) -> Hull:
        """The hull with the values that the parameters have now: mass, buoyancy, panels, see Hull."""
        raised = float(self.parameter_value("raised"))
        return _hull(tuple(member.numbers(raised) for member in members_of(self)), self.label)

    def ballast_level(self, *names: str, load: float = 0.0, density: float = _RHO) -> float:
        """The level [m], z in the frame, of ballast by name below the floater, with which it floats as it is drawn.

        load [kg]: mass that the hull carries besides, with the vertical pull of moorings over gravity.
        """
        paths = [self.find(name).label for name in names]
        return self.hull().ballast_level(paths, load, density) - float(self.parameter_value("raised"))

    def rise(self, load: float = 0.0, density: float = _RHO) -> float:
        """How much higher [m] than it is drawn the hull floats with its ballast; load as in `ballast_level`."""
        return self.hull().rise(load, density)

    def remarks(self) -> list[str]:
        return _regimes(self) if self.sea is not None else []

    def drawing(self) -> shapes.Drawing:
        return [_drawn(self.frame, member, self.material) for member in self.hull().members] if members_of(self) else []


@lru_cache(maxsize=32)
def _hull(members: tuple[MemberShape, ...], name: str) -> Hull:
    """The same object for the same members, so that what it has computed is found again."""
    return Hull(members, name)


@lru_cache(maxsize=32)
def _checked(hull: Hull, held_upright: bool) -> Hull:
    hull.check_joined()
    if not held_upright:
        hull.check_upright()
    return hull


def hull_numbers(floater: Floater) -> Sequence[float]:
    """What the body and the buoyancy of a floater are made of, when a run starts; everything is checked then."""
    if abs(float(floater.parameter_value("position")[2])) > 1e-9:
        raise ParameterError(
            f"{floater.label}.position: its z must be zero, for the frame lies on the still water level; to float "
            "higher or deeper, set raised."
        )
    linear = any(isinstance(part, Hydrostatics) for part in floater.parts.values())
    hull = _checked(floater.hull(), floater.held_upright or not linear)
    depth = float(floater.world.parameter_value("water_depth"))
    if hull.lowest < -depth:
        raise ParameterError(
            f"{floater.label}: its lowest point is at z = {hull.lowest:g} m, below the seabed at {-depth:g} m; change "
            "the draft, or the water_depth of the World."
        )
    known = floater.database
    if known is None:
        floater.refuse_unused("turning", because="there is no database")
    elif abs(hull.buoyancy.volume / known.volume - 1) > APART:
        raise ParameterError(
            f"{floater.label}: its members displace {hull.buoyancy.volume:.6g} m^3, and the hull of its database "
            f"{known.volume:.6g} m^3; they are not the same hull, or not at the same draft."
        )
    if not floater.turning:
        floater.refuse_unused("yaw_at_rest", because="the hull is not turning")
    mass, water = hull.mass, hull.buoyancy
    stiffness = _RHO * float(floater.world.parameter_value("gravity")) * water.waterplane
    return np.concatenate(
        [[mass.mass], mass.centre, mass.inertia.ravel(), [water.volume], water.centre, stiffness.ravel()]
    )


def _regimes(floater: Floater) -> list[str]:
    """What `fowt check` says of each member in the sea of the model."""
    waves, gravity = floater.sea.components(), float(floater.world.parameter_value("gravity"))
    if not len(waves):
        return []
    hull, known, lines = floater.hull(), floater.database is not None, []
    for k, member in enumerate(members_of(floater)):
        found = regime(hull, k, waves, gravity)
        lines.append(f"{member.label}: {found.says(known, member.is_set('added_mass_coefficient'))}")
    return lines


def _drawn(frame: Any, member: MemberShape, material: str) -> shapes.Shape:
    return drawn_between(frame, member, member.stations[0], member.stations[-1], (0.0, 0.0, 0.0), material)


def drawn_between(
    frame: Any, member: MemberShape, low: float, high: float, origin: ArrayLike, material: str = "hull"
) -> shapes.Shape:
    """A member between two places along it [m], on a frame whose origin is at this point of the floater."""
    places = [s for s in member.stations if low <= s <= high]
    places = [*([low] if low not in places else []), *places, *([high] if high not in places else [])]
    points = [member.at(s) - np.asarray(origin, dtype=float) for s in places]
    sizes = [member.size_at(s, after=s < high) for s in places]
    if low == member.stations[0] and high == member.stations[-1]:
        sizes = list(member.sizes)  # with both sizes of a step
    if member.is_round:
        return shapes.Tube(frame, points, [float(size[0]) for size in sizes], material=material)
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    rings = [at + (corners * size) @ member.axes[:, :2].T for at, size in zip(points, sizes, strict=True)]
    return shapes.Loft(frame, np.array(rings), material=material)
