"""Aerodynamic loads of a rotor on the frames along its blades, by blade-element momentum theory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from fowtlib.components.aero.bem import LINE_LOADS, PITT_PETERS, BladeElementRotor
from fowtlib.components.aero.blade_aerodynamics import BladeAerodynamics, read_airfoils, read_blade
from fowtlib.components.aero.dynamic_inflow import DynamicInflow
from fowtlib.components.aero.tower_flow import TowerPotentialFlow
from fowtlib.components.environment.wind import Wind, require_disk
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics import Frame
from fowtlib.components.mechanics.rotations import axis_rotation, unit_axis
from fowtlib.language import (
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


class BladeElementAerodynamics(Component):
    """Loads of the air on a rotor with moving and bending blades: a BladeElementRotor between the frames of its nodes.

    Each node takes part with its own position, orientation and velocity, in the wind at its place. The frames in
    `nodes` are parallel to the pitched blade root when nothing bends, blade by blade from root to tip, and lie at the
    aerodynamic centres (`node_points`); the twist of the airfoils is added here. thrust, side and vertical force are
    the sums over all nodes along the axes of the shaft: x downwind, not turning. The nodes meet the wind that every
    TowerPotentialFlow of the model deflects; dynamic_inflow adds the part `inflow`, see DynamicInflow. A wind
    field that does not cover the disk of tip_radius about the rotor's station is refused, see Wind.require.
    """

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
    dynamic_inflow: bool = param(default=False, doc="the induced speed follows the loads with a delay: DynamicInflow")
    station: int = param(default=0, min=0, doc="number of the wind's station at this rotor")

    world: World = outer(World)
    wind: Wind = outer(Wind)
    towers: list[TowerPotentialFlow] = outer(TowerPotentialFlow, many=True)
    hub: Frame = port(doc="hub centre, turning with the rotor; x along the shaft, downwind")
    nodes: Frame = port(size=lambda self: self.rotor.nodes, doc="frames of the nodes, blade by blade from the root")

    thrust: RealOutput = port(unit="N", doc="force of the air along the shaft, positive downwind")
    torque: RealOutput = port(unit="N*m", doc="moment of the air about the shaft, positive when it drives the rotor")
    aero_power: RealOutput = port(unit="W", doc="torque times rotor speed")
    disk_wind: RealOutput = port(unit="m/s", shape=(3,), doc="wind averaged over the nodes, world")
    force: Vector = var(unit="N", doc="force of the air on the rotor, world")
    moment: Vector = var(unit="N*m", doc="moment of the air on the rotor about the hub, world")

    @property
    def rotor(self) -> BladeElementRotor:
        """The rotor as quasi-steady theory has it, for steady operation."""
        blade = self.blade.fitting(self.label, self.airfoils, hub_radius=self.hub_radius, tip_radius=self.tip_radius)
        return _rotor(blade, self.blades, self.rotation, tuple((name, getattr(self, name)) for name in OPTIONS))

    def build(self):
        if self.dynamic_inflow and self.hub_radius is not None:
            b = self.rotor.blade
            self.inflow = DynamicInflow(radius=b.radius.tolist(), length=b.length.tolist(), tip_radius=b.tip_radius)

    def equations(self):
        hub, nodes, towers = self.hub, list(self.nodes), [tower for tower in self.towers if tower.active]
        places = m.horzcat(*[node.r for node in nodes])
        at_start("place in the wind", doc="a wind field that is too small is refused", compute=_require_wind)
        wind = self.wind.velocity(places, self.station, reach="plane")
        outputs = _air(self, wind + sum(tower.change(wind, places) for tower in towers))
        loads = [outputs["loads"][i : i + 3] for i in range(0, 6 * len(nodes), 3)]
        given = list(zip(loads[::2], loads[1::2], strict=True))
        about_hub = [m.cross(node.r - hub.r, f) + t for node, (f, t) in zip(nodes, given, strict=True)]
        shaft = hub.R[:, 0]
        return [
            [[eq(node.f, -f), eq(node.t, -t)] for node, (f, t) in zip(nodes, given, strict=True)],
            [eq(hub.f, m.zeros(3)), eq(hub.t, m.zeros(3))],
            eq(self.disk_wind, wind @ (np.ones((len(nodes), 1)) / len(nodes))),
            eq(self.force, sum(f for f, _ in given)),
            eq(self.moment, sum(about_hub)),
            eq(self.thrust, m.dot(shaft, self.force)),
            eq(self.torque, self.rotation * m.dot(shaft, self.moment)),
            eq(self.aero_power, m.dot(self.moment, hub.w)),
            _wake(self, outputs["quasi_steady"]) if self.dynamic_inflow else [],
            [assert_(tower.clearance(places) > 0, "a blade strikes the tower") for tower in towers],
        ]


def _require_wind(air: BladeElementAerodynamics) -> float:
    """Where the wind does not reach all of the rotor, an error."""
    require_disk(air.wind, air.tip_radius, air.station, f"the rotor of {air.label}")
    return 1.0


def _air(air: BladeElementAerodynamics, wind: Any) -> dict[str, Any]:
    """What the external function says, with the wind (3, n) at the nodes."""
    rotor, hub, nodes, more = air.rotor, air.hub, list(air.nodes), {}
    twist = [axis_rotation(unit_axis((0, 0, -air.rotation)), float(angle)) for angle in rotor.blade.twist]
    turned = [node.R @ twist[i % len(twist)] for i, node in enumerate(nodes)]
    if air.dynamic_inflow:
        rotor, more = _dynamic(rotor), {"induced": air.inflow.induced}
    return rotor.external(
        position=m.vertcat(*[node.r for node in nodes]), orientation=m.vertcat(*[m.vec(R) for R in turned]),
        velocity=m.vertcat(*[der(node.r) for node in nodes]), wind=m.vec(wind), hub_position=hub.r,
        hub_orientation=m.vec(hub.R), hub_velocity=der(hub.r), disk_wind=air.disk_wind,
        air_density=air.world.air_density, chord=rotor.blade.chord, **more,
    )  # fmt: skip


def _wake(air: BladeElementAerodynamics, quasi_steady: Any) -> list[Any]:
    """What the wake is told: the mean over the blades, and the wind through the disk."""
    n = len(air.inflow.radius)
    mean = sum([quasi_steady[k * n : (k + 1) * n] for k in range(air.blades)]) / air.blades
    through = m.dot(air.hub.R[:, 0], air.disk_wind - der(air.hub.r))
    return [eq(air.inflow.quasi_steady, mean), eq(air.inflow.wind_speed, through)]


@lru_cache(maxsize=16)
def _rotor(blade: BladeAerodynamics, blades: int, rotation: int, options: tuple) -> BladeElementRotor:
    """The same object for the same rotor, so that its function is made once."""
    return BladeElementRotor(blade, blades, rotation, **dict(options))


@lru_cache(maxsize=16)
def _dynamic(rotor: BladeElementRotor) -> BladeElementRotor:
    return replace(rotor, dynamic_inflow=True)


def node_points(blade: BladeAerodynamics, rotation: int = 1) -> list[tuple[float, float, float]]:
    """Where the nodes lie on a blade [m]: from the root, z along the pitch axis; see the axes of Blade."""
    return [(float(c), rotation * float(s), float(r - blade.hub_radius))
            for r, c, s in zip(blade.radius, blade.curve, blade.sweep, strict=True)]  # fmt: skip
