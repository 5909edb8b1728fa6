"""Aerodynamic loads of a rotor on the frames along its blades, by blade-element momentum theory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np

from fowtlib.components.aero.added_mass import added_mass_loads
from fowtlib.components.aero.air_loads import AirLoads
from fowtlib.components.aero.airfoil_states import AirfoilStates
from fowtlib.components.aero.bem import LINE_LOADS, PITT_PETERS, BladeElementRotor
from fowtlib.components.aero.blade_aerodynamics import BladeAerodynamics, read_airfoils, read_blade
from fowtlib.components.aero.dynamic_inflow import DynamicInflow
from fowtlib.components.aero.tower_flow import TowerFlow
from fowtlib.components.aero.unsteady_airfoils import AIRFOIL_MODELS
from fowtlib.components.environment.wind import Wind, require_disk
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics import Frame
from fowtlib.components.mechanics.rotations import axis_rotation, unit_axis
from fowtlib.language import (
    Array,
    Component,
    Data,
    Number,
    RealOutput,
    Vector,
    assert_,
    at_start,
    data,
    der,
    eq,
    outer,
    param,
    port,
    var,
)
from fowtlib.language import math as m

OF_BLADE = ("airfoils", "hub_radius", "tip_radius", "smooth_airfoils")  # what read_blade takes
OPTIONS = ("skew", "axial_drag", "tangential_drag", "tip_loss", "hub_loss", "line_loads")


def _stations(elements: BladeElements) -> tuple[int]:
    return (len(elements.rotor.blade.radius),)


class BladeElements(Component):
    """Partial: the blades of a rotor as elements, and how momentum theory treats them; see BladeElementRotor."""

    blade: Data[BladeAerodynamics] = data(read_blade, using=OF_BLADE, doc="CSV of its elements, see read_blade")
    airfoils: Data[Mapping] = data(read_airfoils, default=None, using=OF_BLADE[-1:], doc="CSV, see read_airfoils")
    smooth_airfoils: bool = param(default=True, doc="monotone cubics between the angles of the airfoils, else lines")
    hub_radius: Number = param(default=None, unit="m", min=0, doc="distance of the blade roots from the shaft")
    tip_radius: Number = param(unit="m", min=0, doc="distance of the tips from the shaft, along the unconed blade")
    blades: int = param(default=3, min=1, doc="number of blades")
    rotation: int = param(default=1, choices=(1, -1), doc="1: clockwise seen from upwind, -1: counter-clockwise")
    skew: Number = param(default=PITT_PETERS, min=0, doc="factor of the skewed wake, 0: none; see BladeElementRotor")
    axial_drag: bool = param(default=True, doc="drag takes part in the axial induction")
    tangential_drag: bool = param(default=True, doc="drag takes part in the tangential induction")
    tip_loss: bool = param(default=True, doc="Prandtl's loss at the tip")
    hub_loss: bool = param(default=True, doc="Prandtl's loss at the hub")
    line_loads: str = param(
        default="elements", choices=LINE_LOADS,
        doc="loads per length times the elements, or straight lines from node to node and to zero at the ends"
    )  # fmt: skip
    chord: Array = param(
        default=lambda self: self.rotor.blade.chord, unit="m", min=1e-6, shape=_stations, doc="chord of each element"
    )
    twist: Array = param(
        default=lambda self: self.rotor.blade.twist, unit="rad", shape=_stations, doc="twist of each, to feather"
    )

    @property
    def rotor(self) -> BladeElementRotor:
        """The rotor of the files, as quasi-steady theory has it."""
        blade = self.blade.fitting(self.label, self.airfoils, hub_radius=self.hub_radius, tip_radius=self.tip_radius)
        return _rotor(blade, self.blades, self.rotation, tuple((name, getattr(self, name)) for name in OPTIONS))

    @property
    def steady_rotor(self) -> BladeElementRotor:
        """The same with the chord and the twist of the parameters, as numbers, for steady operation."""
        shape = (tuple(np.ravel(self.parameter_value(name)).tolist()) for name in ("chord", "twist"))
        return _shaped(self.rotor, *shape)

    def section_axes(self, nodes):
        """Axes of the sections at the nodes, whose frames have the pitch of their blade and no twist."""
        twisted = [axis_rotation(unit_axis((0, 0, -self.rotation)), angle) for angle in ca.vertsplit(self.twist)]
        return [node.R @ twisted[i % len(twisted)] for i, node in enumerate(nodes)]


class RotorLoads(BladeElements):
    """Partial: the loads of all nodes together; thrust, torque and power of a rotor."""

    hub: Frame = port(doc="hub centre, turning with the rotor; x along the shaft, downwind")
    nodes: Frame = port(size=lambda self: self.rotor.nodes, doc="frames of the nodes, blade by blade from the root")

    thrust: RealOutput = port(unit="N", doc="force of the air along the shaft, positive downwind")
    torque: RealOutput = port(unit="N*m", doc="moment of the air about the shaft, positive when it drives the rotor")
    aero_power: RealOutput = port(unit="W", doc="torque times rotor speed")
    force: Vector = var(unit="N", doc="force of the air on the rotor, world")
    moment: Vector = var(unit="N*m", doc="moment of the air on the rotor about the hub, world")

    def passed_on(self, loads):
        """The loads (6n), force and moment of each node, to the nodes and to the outputs."""
        hub, shaft = self.hub, self.hub.R[:, 0]
        parts = ca.vertsplit(loads, 3)
        given = list(zip(self.nodes, parts[::2], parts[1::2], strict=True))
        return [
            [[eq(node.f, -f), eq(node.t, -t)] for node, f, t in given],
            [eq(hub.f, m.zeros(3)), eq(hub.t, m.zeros(3))],
            eq(self.force, sum(f for _, f, _ in given)),
            eq(self.moment, sum(m.cross(node.r - hub.r, f) + t for node, f, t in given)),
            eq(self.thrust, m.dot(shaft, self.force)),
            eq(self.torque, self.rotation * m.dot(shaft, self.moment)),
            eq(self.aero_power, m.dot(self.moment, hub.w)),
        ]


class BladeElementAerodynamics(RotorLoads, AirLoads):
    """Loads of the air on a rotor with moving and bending blades: a BladeElementRotor between the frames of its nodes.

    Each node takes part with its own position, orientation and velocity, in the wind at its place. The frames in
    `nodes` are parallel to the pitched blade root when nothing bends, blade by blade from root to tip, and lie at the
    aerodynamic centres (`node_points`); the twist of the airfoils is added here. `force` and `moment` are the sums over
    all nodes, the moment about the hub; thrust and torque are their parts along and about the shaft. The nodes meet the
    wind that every TowerFlow of the model deflects; dynamic_inflow adds the part `inflow`, see DynamicInflow,
    and an airfoil_model with memory the part `airfoil_states`. added_mass: what the air adds to the mass of the blades.
    A wind field that does not cover the disk of tip_radius about the rotor's station is refused, see Wind.require.
    """

    dynamic_inflow: bool = param(default=False, doc="the induced speed follows the loads with a delay: DynamicInflow")
    airfoil_model: str = param(
        default="steady", choices=tuple(AIRFOIL_MODELS), doc="what the airfoils make of the flow, see UnsteadyAirfoil"
    )
    added_mass: bool = param(default=False, doc="the air that accelerates with the sections, see section_added_mass")
    station: int = param(default=0, min=0, doc="number of the wind's station at this rotor")

    world: World = outer(World)
    wind: Wind = outer(Wind)
    towers: list[TowerFlow] = outer(TowerFlow, many=True)
    disk_wind: RealOutput = port(unit="m/s", shape=(3,), doc="wind averaged over the nodes, world")

    def felt_disk(self) -> tuple[int, float]:
        """Station, and radius [m] about it within which the wind counts."""
        return self.station, float(self.tip_radius)

    def disk_diameter(self) -> float:
        """Of the disk [m]."""
        return 2 * float(self.tip_radius)

    def build(self):
        model = AIRFOIL_MODELS[self.airfoil_model]
        if model.states and self.hub_radius is not None:
            self.airfoil_states = AirfoilStates(sections=self.rotor.nodes, units=list(model.state_units))
        if self.dynamic_inflow and self.hub_radius is not None:
            b = self.rotor.blade
            self.inflow = DynamicInflow(radius=b.radius.tolist(), length=b.length.tolist(), tip_radius=b.tip_radius)

    def equations(self):
        places, towers = m.horzcat(*[node.r for node in self.nodes]), [tower for tower in self.towers if tower.active]
        at_start("place in the wind", doc="a wind field that is too small is refused", compute=_require_wind)
        wind, n = self.wind.velocity(places, self.station, reach="plane"), self.rotor.nodes
        outputs = self.air(places, wind + sum(tower.change(wind, places) for tower in towers))
        return [
            self.passed_on(self.in_air * (outputs["loads"] + (added_mass_loads(self) if self.added_mass else 0))),
            self.switching(),
            eq(self.disk_wind, wind @ (np.ones((n, 1)) / n)),
            self.wake(outputs["quasi_steady"]) if self.dynamic_inflow else [],
            self.airfoil_states.moved(outputs["airfoil_rates"]) if "airfoil_rates" in outputs else [],
            [assert_(tower.clearance(places) > 0, "a blade strikes the tower") for tower in towers],
        ]

    def air(self, places, wind):
        """What the external function says, with the wind (3, n) at the places (3, n) of the nodes."""
        rotor, hub, more = self.rotor, self.hub, {}
        if self.dynamic_inflow:
            more = {"induced": self.inflow.induced}
        if AIRFOIL_MODELS[self.airfoil_model].states:
            more["airfoil_states"], more["stage_step"] = self.airfoil_states.by_section()
            more["turn_rate"] = m.vertcat(*self.turning())
        rotor = _with_states(rotor, self.dynamic_inflow, self.airfoil_model)
        return rotor.external(
            position=m.vec(places), orientation=m.vertcat(*[m.vec(R) for R in self.section_axes(self.nodes)]),
            velocity=m.vertcat(*[der(node.r) for node in self.nodes]), wind=m.vec(wind), hub_position=hub.r,
            hub_orientation=m.vec(hub.R), hub_velocity=der(hub.r), disk_wind=self.disk_wind,
            air_density=self.world.air_density, chord=self.chord, **more,
        )  # fmt: skip

    def turning(self):
        """Angular velocity of each node along its blade, without what the turning of the rotor has of it."""
        shaft, w = self.hub.R[:, 0], self.hub.w
        return [m.dot(node.w - m.dot(w, shaft) * shaft, node.R[:, 2]) for node in self.nodes]

    def wake(self, quasi_steady):
        """What the wake is told: the mean over the blades, and the wind through the disk."""
        mean = sum(ca.vertsplit(quasi_steady, len(self.inflow.radius))) / self.blades
        through = m.dot(self.hub.R[:, 0], self.disk_wind - der(self.hub.r))
        return [eq(self.inflow.quasi_steady, mean), eq(self.inflow.wind_speed, through)]


def _require_wind(air: BladeElementAerodynamics) -> float:
    """Where the wind does not reach all of the rotor, an error."""
    require_disk(air.wind, air.tip_radius, air.station, f"the rotor of {air.label}")
    return 1.0


@lru_cache(maxsize=16)
def _rotor(blade: BladeAerodynamics, blades: int, rotation: int, options: tuple) -> BladeElementRotor:
    """The same object for the same rotor, so that its function is made once."""
    return BladeElementRotor(blade, blades, rotation, **dict(options))


@lru_cache(maxsize=16)
def _with_states(rotor: BladeElementRotor, dynamic_inflow: bool, airfoil_model: str) -> BladeElementRotor:
    if not dynamic_inflow and airfoil_model == "steady":
        return rotor
    return replace(rotor, dynamic_inflow=dynamic_inflow, airfoil_model=AIRFOIL_MODELS[airfoil_model])


@lru_cache(maxsize=16)
def _shaped(rotor: BladeElementRotor, chord: tuple[float, ...], twist: tuple[float, ...]) -> BladeElementRotor:
    blade = rotor.blade
    if chord == tuple(blade.chord.tolist()) and twist == tuple(blade.twist.tolist()):
        return rotor
    return replace(rotor, blade=replace(blade, chord=np.array(chord), twist=np.array(twist)))


def node_points(blade: BladeAerodynamics, rotation: int = 1) -> list[tuple[float, float, float]]:
    """Where the nodes lie on a blade [m]: from the root, z along the pitch axis; see the axes of Blade."""
    return [(float(c), rotation * float(s), float(r - blade.hub_radius))
            for r, c, s in zip(blade.radius, blade.curve, blade.sweep, strict=True)]  # fmt: skip
