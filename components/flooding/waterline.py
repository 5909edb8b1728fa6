"""Where the water stands in a tank, for pictures: a closed line on its walls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fowtlib.language import shapes
from fowtlib.language.declarations import join


def waterline(tank: Any, outline: np.ndarray) -> shapes.Curve:
    """The level surface where it meets the walls; outline: points (n, 2) of the section, the last one the first."""
    floor = np.ravel(tank.parameter_value("place"))
    height = float(tank.parameter_value("height"))

    def points(values: Mapping[str, Any]) -> np.ndarray:
        R = np.stack([np.stack([values[f"R{i}{j}"] for j in range(3)], axis=-1) for i in range(3)], axis=-2)
        foot = floor + np.column_stack([outline, np.zeros(len(outline))])
        below = np.einsum("tj,nj->tn", R[:, 2], foot) + values["r"][:, 2, None]
        z = np.clip((values["surface"][:, None] - below) / R[:, 2, 2, None], 0, height)  # along the wall
        local = foot[None] + z[..., None] * np.array([0.0, 0.0, 1.0])
        return values["r"][:, None] + np.einsum("tij,tnj->tni", R, local)

    turned = {f"R{i}{j}": join(tank.frame.path, f"R[{i},{j}]") for i in range(3) for j in range(3)}
    return shapes.Curve({"r": tank.frame, "surface": join(tank.path, "surface"), **turned}, points)
