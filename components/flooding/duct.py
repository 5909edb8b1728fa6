"""A duct on a body: water that the acceleration of the body drives, and that acts back on it."""

from __future__ import annotations

from typing import Any

import numpy as np

from fowtlib.components.flooding.columns import apparent, potential_along
from fowtlib.components.flooding.pipe import STILL, TwoWaters, friction_factor
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Array, Scalar, Vector, der, eq, facts, param, port, shapes, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class Duct(TwoWaters):
    """A full duct that a body carries, from the first of `points` at water_a to the last at water_b.

    head_drop = (f L / D_h + K) v |v| / (2 g) + L / (g A) dQ/dt + (1/g) int a.dx, with the acceleration a of the body
    at the places x of the duct, from p to q: a_0.(q - p) + w'.int x x dx - (|w x q|^2 - |w x p|^2) / 2. Friction is
    that of a Pipe. The body feels the mass of its water, as that of a thin line, and its flow: with P = rho Q (q - p)
    the force P' + 2 w x P and the moment rho Q' int x x dx + 2 rho Q int x x (w x dx), all in axes of the frame; jets
    at its ends are left out. For an anti-roll tank the tanks at its ends have `flow_inertia`.
    Source: the equation of Bernoulli in a moving frame; A. R. J. M. Lloyd, Seakeeping (1989), ch. 20.
    """

    points: Array = param(unit="m", doc="points (n, 3) on the axis of the duct, from water_a on, resolved in the frame")
    area: Scalar = param(unit="m^2", min=1e-9, doc="A, of its section")
    hydraulic_diameter: Scalar = param(
        default=lambda self: m.sqrt(4 * self.area / m.pi), unit="m", min=1e-6,
        doc="D_h, four sections over the wetted perimeter; without: of a round duct",
    )  # fmt: skip
    roughness: Scalar = param(default=5e-5, unit="m", min=0, doc="equivalent sand roughness of the wall")
    loss_factor: Scalar = param(default=1.5, min=0, doc="K, of inlet, bends and outlet together")
    viscosity: Scalar = param(default=1.19e-6, unit="m^2/s", min=1e-9, doc="kinematic; sea water of 15 deg C: 1.19e-6")
    density: Scalar = param(default=None, unit="kg/m^3", min=0, doc="density of the water; without: World's")

    frame: Frame = port(doc="body that carries it")

    velocity: Vector = var(unit="m/s", state="avoid", doc="velocity of the frame, world")

    def build(self):
        given = np.shape(self.parameter_value("points"))
        if len(given) != 2 or given[0] < 2 or given[1] != 3:
            raise ParameterError(
                f"{self.label}.points needs two points or more, rows of x, y, z, not the shape {given}."
            )

    def equations(self):
        rho = self.world.water_density if self.density is None else self.density
        points = [self.points[i, :].T for i in range(np.shape(self.parameter_value("points"))[0])]
        ways = list(zip(points, points[1:], strict=False))
        length, g = sum((m.norm(b - a) for a, b in ways), 0.0), self.world.gravity
        motion = apparent(self.frame, self.velocity, g)
        driven = sum((potential_along(motion, a, b) for a, b in ways), 0.0) / g
        raised = m.dot(self.frame.R[2, :].T, points[-1] - points[0])  # gravity is in the heads
        slow = length / (g * self.area) * der(self.volume_flow)
        force, moment = _loads(self, rho, ways, motion)
        return [
            *self.through(),
            eq(self.velocity, der(self.frame.r)),
            eq(self.head_drop, _lost(self, length) + slow + driven - raised),
            [eq(self.frame.f, self.frame.R @ force), eq(self.frame.t, self.frame.R @ moment)],
        ]

    def facts(self) -> list[facts.Fact]:
        given = self.parameter_value("density")
        rho = self.world.parameter_value("water_density") if given is None else given
        points = np.asarray(self.parameter_value("points"), dtype=float)
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        middles = (points[1:] + points[:-1]) / 2
        mass = float(rho * self.parameter_value("area") * lengths.sum())
        return [facts.Mass(self.frame, mass, lengths @ middles / lengths.sum())]

    def drawing(self) -> shapes.Drawing:
        points = np.asarray(self.parameter_value("points"), dtype=float)
        diameter = 2 * float(np.sqrt(self.parameter_value("area") / np.pi))
        return [shapes.Tube(self.frame, points, [diameter] * len(points), material="water")]


def _lost(duct: Duct, length: Any) -> Any:
    """Head lost by friction and fittings."""
    D, speed = duct.hydraulic_diameter, duct.volume_flow / duct.area
    size = m.smooth_abs(speed, STILL * duct.viscosity / D)
    friction = friction_factor(size * D / duct.viscosity, duct.roughness / D)
    return (friction * length / D + duct.loss_factor) * speed * size / (2 * duct.world.gravity)


def _loads(duct: Duct, rho: Any, ways: list[Any], motion: tuple[Any, Any, Any]) -> tuple[Any, Any]:
    """Force and moment about the frame, in its axes: of the mass of the water, and of its flow."""
    a, w, turning = motion
    flow, rate = rho * duct.volume_flow, rho * der(duct.volume_flow)
    force, moment = m.zeros(3), m.zeros(3)
    for start, end in ways:
        way, middle = end - start, (start + end) / 2
        mass = rho * duct.area * m.norm(way)
        own = mass / 12 * m.dot(way, way), mass / 12 * way  # a thin rod about its middle
        swung = m.cross(turning, middle) + m.cross(w, m.cross(w, middle))
        force = force + mass * (a + swung) + rate * way + 2 * flow * m.cross(w, way)
        spin = own[0] * turning - own[1] * m.dot(way, turning) - m.cross(w, own[1]) * m.dot(way, w)
        moment = moment + m.cross(middle, mass * (a + swung)) + spin
        moment = moment + rate * m.cross(start, end) + 2 * flow * m.cross(middle, m.cross(w, way))
    return force, moment
