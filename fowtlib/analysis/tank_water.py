"""The water in tanks of a model as liquids that a hull carries.

Of a BoxTank and a RoundTank the inside is a closed surface, cut by the level at any attitude. Of other tanks the part
itself says, by its `vessel`, what is below a level and a slope, as it does in a run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from fowtlib.analysis.afloat import Liquid
from fowtlib.components.flooding import BoxTank, RoundTank, Tank
from fowtlib.components.flooding.tank import STEEPEST
from fowtlib.components.platform import MemberShape, WettedSurface
from fowtlib.components.platform.union import union
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]

STEP = 1e-5  # of the vertical, in differences


def water_in(part: Tank, state: Any, origin: Floats, R: Floats) -> Liquid | VesselWater:
    """The water of a tank at a state, in the axes R (3, 3) about the origin (3,) of a hull."""
    place, turn, volume = state.values([join(part.path, name) for name in ("frame.r", "frame.R", "volume")])
    density = part.parameter_value("density")
    water = float(part.world.parameter_value("water_density") if density is None else density)
    amount, to_hull = float(np.ravel(volume)[0]), R.T @ turn
    if isinstance(part, (BoxTank, RoundTank)):
        triangles = inside_of(part).triangles @ to_hull.T + R.T @ (place - origin)
        return Liquid(WettedSurface(triangles), amount, water, part.label)
    floor = R.T @ (place - origin) + to_hull @ np.ravel(part.parameter_value("place"))
    return VesselWater(_contents(part), floor, to_hull, amount, water, part.label)


@dataclass(frozen=True, eq=False)
class VesselWater:
    """The water of a tank by what its vessel holds below a level: as Liquid, up to STEEPEST of its axis.

    contents: of level and two slopes, volume and first moments (3,) about the middle of the floor, in its axes; floor
    (3,) and axes (3, 3) in the hull.
    """

    contents: Any
    floor: Floats
    axes: Floats
    volume: float
    density: float
    name: str

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.volume

    def at(self, normal: Floats) -> tuple[Floats, Floats]:
        """First moments (3,) [m^4] of the water in the hull, and their derivatives (3, 3) by the vertical."""
        around = np.eye(3) * STEP
        slopes = [(self._moments(normal + d) - self._moments(normal - d)) / (2 * STEP) for d in around]
        return self._moments(normal), np.stack(slopes, axis=1)

    def _moments(self, normal: Floats) -> Floats:
        from scipy.optimize import newton  # slow to import

        up = self.axes.T @ normal
        if up[2] < math.cos(math.radians(STEEPEST)) * float(np.linalg.norm(up)):
            raise ParameterError(
                f"{self.name}: its axis is turned by more than {STEEPEST:g} deg against the vertical, for which what "
                "it holds is not known; take smaller heels."
            )
        slope = float(up[0] / up[2]), float(up[1] / up[2])
        volume = self.volume

        def miss(level: float) -> float:
            return float(self.contents(level, *slope)[0]) - volume

        level = newton(miss, 1.0, tol=1e-12, maxiter=100) if volume else 0.0
        first = self.contents(level, *slope)[1].full().ravel()
        return volume * self.floor + self.axes @ first


def _contents(part: Tank) -> Any:
    """Volume and first moments of the vessel of a tank as a function of level and slopes, with its present values."""
    level, along_x, along_y = (ca.SX.sym(name) for name in ("level", "along_x", "along_y"))
    held = type(part).vessel(cast("Tank", _Values(part))).contents(level, (along_x, along_y))
    return ca.Function("contents", [level, along_x, along_y], [ca.SX(held.volume), ca.vec(ca.SX(held.first))])


class _Values:
    """A part whose parameters are the numbers that they have now."""

    def __init__(self, part: Tank):
        self._part = part

    def __getattr__(self, name: str) -> Any:
        if name in self._part.parameters:
            return self._part.parameter_value(name)
        return getattr(self._part, name)


def inside_of(part: Tank) -> WettedSurface:
    """The inside of a tank as a closed surface, in the axes of its frame."""
    height = float(part.parameter_value("height")) if isinstance(part, (BoxTank, RoundTank)) else 0.0
    x, y, z = np.ravel(part.parameter_value("place")).tolist()

    def outside(size: float, other: float, is_round: bool) -> Floats:
        ends = (x, y, z), (x, y, z + height)
        return union((MemberShape(part.label, *ends, (0.0, height), ((size, other),) * 2, is_round),)).triangles()

    if isinstance(part, BoxTank):
        return WettedSurface(outside(*(float(part.parameter_value(name)) for name in ("length", "width")), False))
    if isinstance(part, RoundTank):
        wall, inner = (part.parameter_value(name) for name in ("diameter", "inner_diameter"))
        triangles = outside(float(wall), float(wall), True)
        if inner:  # the wall of a hole looks inwards
            triangles = np.concatenate([triangles, outside(float(inner), float(inner), True)[:, ::-1]])
        return WettedSurface(triangles)
    raise ParameterError(
        f"{part.label}: the shape of a {type(part).__name__} is not known as a surface; take a BoxTank or a RoundTank."
    )
