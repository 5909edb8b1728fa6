"""The tower in the wind: how it deflects and slows the wind at the blades, and its own drag."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.world import World
from fowtlib.components.mechanics import Frame
from fowtlib.language import Array, Component, Scalar, Vector, der, eq, outer, param, port, quadratic, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class TowerFlow(Component):
    """Partial: what a tower does to the wind at the nodes of every rotor of blade elements, which finds it.

    Full from the lowest to the highest frame; beyond, it fades within one local diameter. Inside of the tower it is
    bounded and means nothing, and a simulation in which a blade strikes the tower stops there.

    Connect `nodes` to frames along the axis, from the base to the top; straight lines between them.
    """

    diameters: list = param(unit="m", doc="diameters of the tower at the frames, two or more")
    active: bool = param(default=True, doc="false: the wind passes as if there were no tower")

    nodes: Frame = port(size=lambda self: len(self.diameters), doc="frames on the axis of the tower, base first")

    def equations(self):
        _check(self, self.diameters, "diameters", least=2)
        return [[eq(node.f, m.zeros(3)), eq(node.t, m.zeros(3))] for node in self.nodes]

    def added(self, axis: _Axis, wind: ca.SX, position: ca.SX) -> ca.SX:
        """What is added to the wind (3) at a position (3)."""
        raise NotImplementedError

    def change(self, wind: ca.SX, position: ca.SX) -> ca.SX:
        """What the tower adds to the undisturbed wind (3, n, world) at positions (3, n); while flattening."""
        if not self.active:
            return ca.SX.zeros(*ca.SX(wind).shape)
        axis = _Axis([node.r for node in self.nodes], self.diameters)
        columns = zip(ca.horzsplit(ca.SX(wind)), ca.horzsplit(ca.SX(position)), strict=True)
        return m.horzcat(*[self.added(axis, w, r) for w, r in columns])

    def clearance(self, position: ca.SX) -> ca.SX:
        """Least distance [m] of positions (3, n) from the surface, of those between the base and the top."""
        axis, least = _Axis([node.r for node in self.nodes], self.diameters), ca.SX(float(max(self.diameters)))
        for r in ca.horzsplit(ca.SX(position)):
            away, diameter, beyond = axis.beside(r)
            least = m.fmin(least, m.if_else(beyond > 0, least, m.norm(away) - diameter / 2))
        return least


class TowerPotentialFlow(TowerFlow):
    """The dam of a tower: plane potential flow around a cylinder of the local diameter.

    The wind W across the tower axis becomes, at the distance d (vector) from the nearest point of the axis,
    W (1 + R^2/d^2) - 2 R^2 d (d . W)/d^4 with the local radius R; upstream that is W (1 - (D/2x)^2). AeroDyn has the
    same as TwrPotent = 1 (Moriarty and Hansen 2005, NREL/TP-500-36881). W is the undisturbed wind of the node itself.
    Potential flow has no wake: for upwind rotors. See TowerFlow, and TowerShadow for the wake.
    """

    def added(self, axis: _Axis, wind: ca.SX, position: ca.SX) -> ca.SX:
        return axis.deflection(wind, position)


class TowerShadow(TowerFlow):
    """The wake of a tower, for rotors downwind of it: what the drag of the tower takes off the wind behind it.

    With lengths over the local radius, x along the wind W across the tower axis, y beside it and r = |(x, y)|, the wind
    is W (1 - C_d / sqrt(r) cos^2(pi y / (2 sqrt r))) for x > 0 and |y| < sqrt(r): far behind, the momentum that is
    missing is the drag C_d D rho W^2 / 2. The share that is missing is bounded near the tower. Powles (1983), as in
    AeroDyn (TwrShadow = 1). It adds to the dam of a TowerPotentialFlow; W is the undisturbed wind of the node itself.
    """

    drag_coefficient: Scalar = param(default=1.0, min=0, doc="drag coefficient C_d by the diameter")
    greatest_deficit: Scalar = param(default=0.5, min=0, max=1, doc="bound of the share of the wind that is missing")

    def added(self, axis: _Axis, wind: ca.SX, position: ca.SX) -> ca.SX:
        return axis.shadow(wind, position, self.drag_coefficient, self.greatest_deficit)


class TowerDrag(Component):
    """Drag of the wind on a tower: 0.5 rho C_d D |U| U per length, U the relative wind across the tower, at each frame.

    Quasi-steady; the frames' own z axes point along the tower. A frame stands for `lengths` of the tower around it, so
    that the lengths add up to the tower and frames lie in the middle of their parts. Source: Hansen (2015),
    Aerodynamics of Wind Turbines, section on loads; C_d of a smooth tower 0.5 to 1.2 by its Reynolds number.

    In a wind field the points of its tower serve below its plane; below them, or without them below the plane, the wind
    falls linearly to nothing at z = 0, as InflowWind has it.
    """

    diameters: Array = param(unit="m", min=0, doc="diameters of the tower at the frames")
    lengths: Array = param(unit="m", min=0, doc="length of tower that each frame stands for")
    drag_coefficient: Scalar = param(default=1.0, min=0, doc="drag coefficient C_d by the diameter")
    active: bool = param(default=True, doc="false: no drag")
    station: int = param(default=0, min=0, doc="number of the wind's station that the tower stands in")

    world: World = outer(World)
    wind: Wind = outer(Wind)
    nodes: Frame = port(size=lambda self: np.size(self.parameter_value("diameters")), doc="frames along the tower")

    force: Vector = var(unit="N", doc="drag of the whole tower, world")

    def equations(self):
        sizes = {name: np.ravel(self.parameter_value(name)).tolist() for name in ("diameters", "lengths")}
        for name, values in sizes.items():
            _check(self, values, name)
        if len(sizes["lengths"]) != len(sizes["diameters"]):
            counts = f"{len(sizes['diameters'])} diameters and {len(sizes['lengths'])} lengths"
            raise ParameterError(f"{self.label}: {counts}; give one for each frame.")
        forces = self._forces() if self.active else [m.zeros(3) for _ in self.nodes]
        return [
            [[eq(node.f, -f), eq(node.t, m.zeros(3))] for node, f in zip(self.nodes, forces, strict=True)],
            eq(self.force, sum(forces)),
        ]

    def _forces(self) -> list[ca.SX]:
        wind = self.wind.velocity(m.horzcat(*[node.r for node in self.nodes]), self.station, reach="ground")
        return [self._drag(wind[:, k] - der(node.r), node.R[:, 2], k) for k, node in enumerate(self.nodes)]

    def _drag(self, relative: ca.SX, axis: ca.SX, k: int) -> ca.SX:
        across = relative - axis * m.dot(axis, relative)
        area = self.diameters[k] * self.lengths[k]
        # a speed of 1e-6 m/s keeps the slope of |U| U finite where there is no wind
        return 0.5 * self.world.air_density * self.drag_coefficient * area * quadratic(across, 1e-6, f"drag {k}")


def deflected_wind(wind: Any, position: Any, points: list[Any], diameters: list[float]) -> ca.SX:
    """Wind (3) beside a tower with the diameters at the points of its axis, base first; see TowerPotentialFlow."""
    return wind + _Axis(points, diameters).deflection(wind, position)


def shadowed_wind(
    wind: Any, position: Any, points: list[Any], diameters: list[float], drag_coefficient: float = 1.0,
    greatest_deficit: float = 0.5,
) -> ca.SX:  # fmt: skip
    """Wind (3) in the wake of a tower with the diameters at the points of its axis, base first; see TowerShadow."""
    return wind + _Axis(points, diameters).shadow(wind, position, drag_coefficient, greatest_deficit)


class _Axis:
    """The axis of a tower, its points on straight lines; what does not depend on a position is written once."""

    def __init__(self, points: list[Any], diameters: list[float]):
        whole = points[-1] - points[0]
        self.base, self.direction = points[0], whole / m.norm(whole)
        heights = [m.dot(self.direction, point - self.base) for point in points]
        lengths = [heights[k + 1] - heights[k] for k in range(len(points) - 1)]
        self.top, self.diameter = heights[-1], float(diameters[0])
        self.pieces = [
            (heights[k], 1 / lengths[k], points[k + 1] - points[k] - lengths[k] * self.direction,
             float(diameters[k + 1]) - float(diameters[k])) for k in range(len(points) - 1)
        ]  # fmt: skip

    def beside(self, position: Any) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Vector to a position, across the tower; local diameter; how far it is above the top or below the base."""
        from_base = position - self.base
        height = m.dot(self.direction, from_base)
        away, diameter = from_base - height * self.direction, ca.SX(self.diameter)
        for begin, per_length, aside, wider in self.pieces:
            share = m.fmin(m.fmax((height - begin) * per_length, 0), 1)
            diameter += share * wider
            if len(self.pieces) > 1:  # a single one is straight
                away -= share * aside
        return away, diameter, m.fmax(-height, height - self.top)

    def deflection(self, wind: Any, position: Any) -> ca.SX:
        """What potential flow adds to the wind."""
        away, diameter, beyond = self.beside(position)
        across, radius2 = self.across(wind), diameter**2 / 4
        distance2 = m.fmax(m.sumsqr(away), radius2)
        share = self.fade(beyond, diameter) * radius2 / distance2
        return share * (across - (2 * m.dot(away, across) / distance2) * away)

    def shadow(self, wind: Any, position: Any, drag_coefficient: Any, greatest_deficit: Any) -> ca.SX:
        """What the wake of the tower takes off the wind, negative along it."""
        away, diameter, beyond = self.beside(position)
        across, away = self.across(wind), away / (diameter / 2)
        along = m.dot(away, across) / m.smooth_norm(across, 1e-6)
        root = m.fmax(m.sumsqr(away), 1) ** 0.25
        beside = m.sqrt(m.fmax(m.sumsqr(away) - along**2, 1e-12))
        deficit = drag_coefficient / root * m.cos(m.pi / 2 * m.fmin(beside / root, 1)) ** 2
        missing = m.if_else(along > 0, m.fmin(deficit, greatest_deficit), 0)
        return -self.fade(beyond, diameter) * missing * across

    def across(self, wind: Any) -> ca.SX:
        """The wind across the axis."""
        return wind - self.direction * m.dot(self.direction, wind)

    def fade(self, beyond: Any, diameter: Any) -> ca.SX:
        """1 beside the tower, 0 from one diameter beyond its ends on."""
        height = m.fmin(m.fmax(beyond / diameter, 0), 1)
        return 1 - height**2 * (3 - 2 * height)


def _check(component: Component, values: list, name: str, least: int = 1) -> None:
    if len(values) < least:
        raise ParameterError(f"{component.label}.{name}: {least} or more are needed, one for each frame.")
    for value in values:
        if not float(value) > 0:
            raise ParameterError(f"{component.label}.{name}: {value} is not a positive length in m.")
