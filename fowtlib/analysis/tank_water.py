"""The water in tanks of a model as liquids that a hull carries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fowtlib.analysis.afloat import Liquid
from fowtlib.components.flooding import BoxTank, RoundTank, Tank
from fowtlib.components.platform import MemberShape, WettedSurface
from fowtlib.components.platform.union import union
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]


def water_in(part: Tank, state: Any, origin: Floats, R: Floats) -> Liquid:
    """The water of a tank at a state, in the axes R (3, 3) about the origin (3,) of a hull.

    Raises ParameterError for a tank whose shape is known by its sections alone.
    """
    place, turn, volume = state.values([join(part.path, name) for name in ("frame.r", "frame.R", "volume")])
    inside = inside_of(part)
    density = part.parameter_value("density")
    water = part.world.parameter_value("water_density") if density is None else density
    surface = WettedSurface((place + inside.triangles @ np.transpose(turn) - origin) @ R)
    return Liquid(surface, float(np.ravel(volume)[0]), float(water), part.label)


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
        f"{part.label}: the shape of a {type(part).__name__} is not known as a surface; righting arms and stages know "
        "BoxTank and RoundTank."
    )
