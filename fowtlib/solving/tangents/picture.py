"""The picture of sensitivities: a panel for each result, a line for each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.solving.results.drawing import COLORS, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 8  # parameters of a panel: those by which the result changes most
DASHES = ("-", "--", ":")


def draw(found: Any, path: str | Path | None, results: Sequence[str]) -> Figure:
    """Each result's change for one per cent of each parameter; of one that is zero, for 0.01 of its SI unit."""
    with drawing_style():
        figure = drawing(8.0, 0.6 + 1.9 * len(results))
        axes = figure.subplots(len(results), 1, sharex=True, squeeze=False)[:, 0]
        size = 0.01 * np.where(found.at == 0, 1.0, np.abs(found.at))
        for axis, result in zip(axes, results, strict=True):
            series = np.column_stack([found.array(result, name) for name in found.parameters]) * size
            order = np.argsort(-np.abs(series).max(axis=0), kind="stable")[:MOST]
            for column in np.sort(order):
                style = DASHES[column // len(COLORS) % len(DASHES)]
                axis.plot(found.time, series[:, column], style, color=COLORS[column % len(COLORS)],
                          label=found.parameters[column])  # fmt: skip
            unit = found.units[found.results.index(result)]
            axis.set_title(f"{result}: change for 1 % of a parameter")
            axis.set_ylabel("" if unit == "1" else unit)
            axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        axes[-1].set_xlabel("time, s")
    return save_figure(figure, path)
