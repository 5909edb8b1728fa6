"""Pictures of design maps: curves over one parameter, contours over two, with what the limits leave.

The functions read attributes only: those of a ParameterMap.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEVELS = 9
COLUMNS = 2  # of panels
LETTERS = 11  # of a title, per inch
BROKEN = COLORS[1]


def plot_map(map_: Any, path: str | Path | None = None, title: str = "") -> Figure:
    """One panel for each quantity; what breaks a limit is hatched, the limit itself a dashed line."""
    names = map_.quantities or list(map_.table)
    rows = -(-len(names) // COLUMNS)
    width = 9.0 if len(names) > 1 else 5.5
    title = "\n".join(textwrap.fill(line, int(LETTERS * width)) for line in title.splitlines())
    with drawing_style():
        figure = drawing(width, 3.6 * rows + (0.1 + 0.2 * len(title.splitlines()) if title else 0.0))
        panels = figure.subplots(rows, min(COLUMNS, len(names)), squeeze=False).ravel()
        for axis, name in zip(panels, names, strict=False):
            (_curve if len(map_.axes) == 1 else _contours)(axis, map_, name)
            axis.set_title(f"{name} [{map_.units[name]}]", loc="left", fontsize=9.5)
            axis.set_xlabel(f"{map_.axes[0].path} [{map_.axes[0].unit}]")
        for axis in panels[len(names) :]:
            axis.set_visible(False)
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return save_figure(figure, path)


def _curve(axis: Axes, map_: Any, name: str) -> None:
    x, values, kept = map_.axes[0].values, map_[name], map_.feasible
    axis.plot(x, values, color=COLORS[0], marker=".", ms=4)
    axis.plot(x[~kept], values[~kept], "x", color=BROKEN, ms=5)
    for limit in map_.limits:
        if limit.quantity == name:
            axis.axhline(limit.number(map_.units[name]), color=INK, lw=1.0, ls="--")


def _contours(axis: Axes, map_: Any, name: str) -> None:
    x, y = map_.axes[0].values, map_.axes[1].values
    values = np.ma.masked_invalid(map_[name].T)
    axis.set_ylabel(f"{map_.axes[1].path} [{map_.axes[1].unit}]")
    if min(values.shape) < 2 or values.count() < 4:
        axis.text(0.5, 0.5, "too few points for contours", ha="center", va="center", transform=axis.transAxes)
        return
    if np.ptp(values.compressed()) > 1e-9 * np.abs(values).max():
        filled = axis.contourf(x, y, values, LEVELS, cmap="viridis", alpha=0.75)
        axis.figure.colorbar(filled, ax=axis)
        lines = axis.contour(x, y, values, LEVELS, colors=INK, linewidths=0.5)
        axis.clabel(lines, fontsize=7, fmt="%.5g")
    for limit in map_.limits:
        bound, of = limit.number(map_.units[limit.quantity]), np.ma.masked_invalid(map_[limit.quantity].T)
        beyond = of - bound if limit.below else bound - of
        if beyond.max() > 0:
            axis.contourf(x, y, beyond, [0.0, 2.0 * beyond.max()], colors="none", hatches=["////"])
        if limit.quantity == name and beyond.min() < 0 < beyond.max():
            axis.contour(x, y, values, [bound], colors=BROKEN, linewidths=1.5, linestyles="--")
