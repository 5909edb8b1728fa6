"""An anchor that gives way: it is dragged over the seabed where it is pulled with more than it can hold."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import (
    Array,
    Component,
    Scalar,
    Vector,
    assert_,
    der,
    eq,
    fix_orientation,
    param,
    port,
    shapes,
    var,
)
from fowtlib.language import math as m

STILL = 1e-6
"""Speed [m/s] of the rounding of |v|."""


class DragAnchor(Component):
    """An anchor on the seabed whose soil holds up to holding_capacity C against a level pull, in any direction.

    Soil like Dahl's friction: its grip G grows with the way by C / mobilisation, and less and less near C,
    dG/dt = C / d (v - |v| (|G| / C)^3 G / C); the anchor has mass dv/dt = pull - G - c v, where c damps its motion.
    Below C it stays, after the way that takes up the pull; above it is dragged, and stays where it comes to rest. It
    does not dig in deeper or break out upwards: what pulls it up is held. Any line ends at its frame. A run starts with
    the grip `pull_start`. It rests wherever it holds, so that `equilibrium` must hold its `dragged[0]`, `dragged[1]`.
    Source: P.R. Dahl, AIAA Journal 14 (1976) 1675-1682.
    """

    mode_names = {"*": "{part} motion"}

    position: Vector = param(unit="m", doc="where it is set, world")
    holding_capacity: Scalar = param(unit="N", min=1.0, doc="largest level pull that the soil holds")
    mass: Scalar = param(default=20e3, unit="kg", min=1.0, doc="mass of the anchor and of the soil that goes with it")
    mobilisation: Scalar = param(default=0.2, unit="m", min=1e-3, doc="way d at which the first stiffness would give C")
    pull_start: Array = param(default=(0, 0), shape=(2,), unit="N", doc="level pull that a run starts with")
    dragged_warning: Scalar = param(default=1.0, unit="m", min=0, doc="way from which on a warning is given")

    frame: Frame = port(doc="where the line ends; keeps the axes of the world")

    dragged: Array = var(shape=(2,), unit="m", start=0.0, state="prefer", doc="level way from where it was set, world")
    v: Array = var(shape=(2,), unit="m/s", start=0.0, state="prefer", doc="its velocity, world")
    grip: Array = var(shape=(2,), unit="N", start=pull_start, nominal=1e5, state="prefer", doc="of the soil, world")
    way: Scalar = var(unit="m", doc="distance from where it was set")

    def start_place(self):
        return self.parameter_value("position")

    def fixed_rotation(self):
        return m.eye(3)

    def equations(self):
        C, way = self.holding_capacity, self.dragged
        stiffness = C / self.mobilisation
        share = m.smooth_norm(self.grip, 1e-6 * C) / C
        yielding = m.smooth_norm(self.v, STILL) - STILL
        return [
            eq(der(self.dragged), self.v),
            eq(self.mass * der(self.v), self.frame.f[:2] - self.grip - m.sqrt(stiffness * self.mass) * self.v),
            eq(der(self.grip), stiffness * (self.v - yielding * share**3 * self.grip / C)),
            eq(self.frame.r, self.position + m.vertcat(way[0], way[1], 0)),
            fix_orientation(self.frame, m.eye(3), m.zeros(3)),
            eq(self.way, m.smooth_norm(way, 1e-9)),
            assert_(self.way < self.dragged_warning, "the anchor is dragged by {way} m", "warning", way=self.way),
        ]

    def drawing(self) -> shapes.Drawing:
        return [shapes.Ball(self.frame, material="line")]
