"""Pictures of designs: sizes before and after with their bounds, how far constraints are used, the way, Pareto fronts.

The functions read attributes only: those of an Optimum or of a Front.
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

BEFORE, AFTER, LIMIT = "#999999", COLORS[0], COLORS[1]
MOST_BARS = 24


def plot_optimum(optimum: Any, path: str | Path | None = None) -> Figure:
    """A panel for each array along its member, then single sizes between their bounds, constraints, and the way."""
    along = {member.path: member for member in optimum.members}
    single = [size for size in optimum.variables if size.name.partition("[")[0] not in _spline_names(optimum)]
    panels: list[tuple[str, Any]] = [("member", member) for member in along.values()]
    panels += [("sizes", single)] if single else []
    panels += [("constraints", optimum.constraints)] if optimum.constraints else []
    panels += [("way", optimum)] if len(optimum.history) > 1 else []
    rows = -(-len(panels) // 2)
    with drawing_style():
        figure = drawing(10.0 if len(panels) > 1 else 5.5, 3.4 * rows + 0.4)
        axes = figure.subplots(rows, min(2, len(panels)), squeeze=False).ravel()
        for axis, (kind, what) in zip(axes, panels, strict=False):
            {"member": _member, "sizes": _sizes, "constraints": _constraints, "way": _way}[kind](axis, what)
        for axis in axes[len(panels) :]:
            axis.set_visible(False)
        end = "all constraints are kept" if optimum.feasible else "not all constraints are kept"
        title = f"{optimum.title}: {optimum.objective} from {optimum.start_objective:.5g} to {optimum.value:.5g}, {end}"
        figure.suptitle(textwrap.fill(title, 110), x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return save_figure(figure, path)


def _spline_names(optimum: Any) -> set[str]:
    """Variables of several numbers, which are drawn along their members."""
    return {size.name.partition("[")[0] for size in optimum.variables if "[" in size.name} if optimum.members else set()


def _member(axis: Axes, member: Any) -> None:
    axis.plot(member.stations, member.start, color=BEFORE, ls="--", marker=".", label="start")
    axis.plot(member.stations, member.value, color=AFTER, marker=".", label="optimum")
    axis.set_title(f"{member.path} [{member.unit}]", loc="left", fontsize=9.5)
    axis.set_xlabel(member.along)
    axis.legend(frameon=False, fontsize=8)


def _sizes(axis: Axes, sizes: Any) -> None:
    """Between the bounds 0 and 1, where there are two."""
    shown = list(sizes)[:MOST_BARS]
    for k, size in enumerate(shown):
        span = size.upper - size.lower
        low, span = (size.lower, span) if np.isfinite(span) else (min(size.start, size.value), None)
        span = span or max(abs(size.value - size.start), 1e-12)
        before, after = (size.start - low) / span, (size.value - low) / span
        axis.plot([0, 1], [k, k], color=INK, lw=0.6, alpha=0.4)
        axis.annotate("", (after, k), (before, k), arrowprops={"arrowstyle": "->", "color": BEFORE, "lw": 1})
        axis.plot([before], [k], "o", color=BEFORE, ms=4)
        axis.plot([after], [k], "o", color=LIMIT if size.active else AFTER, ms=6)
        axis.annotate(f"{size.value:.4g}", (after, k), (0, 6), textcoords="offset points", ha="center", fontsize=7.5)
    axis.set_yticks(range(len(shown)), [f"{size.name} [{size.unit}]" for size in shown], fontsize=8)
    axis.set_ylim(len(shown) - 0.5, -0.7)
    axis.set_xlim(-0.08, 1.08)
    axis.set_xticks([0, 1], ["lower", "upper"])
    axis.set_title("sizes between their bounds (orange: at one)", loc="left", fontsize=9.5)


def _constraints(axis: Axes, constraints: Any) -> None:
    """How far each limit is used: 1 is at the limit; the fullest of many."""
    shown = sorted(constraints, key=lambda item: -item.use)[:MOST_BARS]
    for k, item in enumerate(shown):
        color = LIMIT if item.active or item.violated else AFTER
        axis.barh(k, np.clip(item.use, 0, 2), color=color, height=0.6)
        text = f"{item.value:.4g}{' broken' if item.violated else ' active' if item.active else ''}"
        inside = item.use > 0.35
        axis.text(0.02 + (0.0 if inside else max(item.use, 0.0)), k, text, va="center", fontsize=7.5,
                  color="white" if inside else INK)  # fmt: skip
    axis.axvline(1.0, color=INK, lw=1.0, ls="--")
    axis.set_yticks(range(len(shown)), [f"{item.name} [{item.unit}]" for item in shown], fontsize=8)
    axis.set_ylim(len(shown) - 0.5, -0.5)
    axis.set_xlim(0, max(1.1, *(min(item.use, 2.0) for item in shown)))
    axis.set_title("use of the limits (1: at the limit)", loc="left", fontsize=9.5)


def _way(axis: Axes, optimum: Any) -> None:
    objective, violation = np.array(optimum.history).T
    axis.plot(objective, color=AFTER, marker=".")
    broken = np.flatnonzero(violation > 1e-5)
    axis.plot(broken, objective[broken], "x", color=LIMIT, label="not all constraints kept")
    axis.margins(x=0.03)
    axis.set_title(_labelled("objective", optimum.unit), loc="left", fontsize=9.5)
    axis.set_xlabel("iterate")
    if broken.size:
        axis.legend(frameon=False, fontsize=8)


def _labelled(name: str, unit: str) -> str:
    return name if unit in ("", "1") else f"{name} [{unit}]"


def plot_front(front: Any, path: str | Path | None = None) -> Figure:
    """The two results of a Pareto front against each other, and the designs that are better than none."""
    with drawing_style():
        figure = drawing(6.0, 4.2)
        axis = figure.subplots()
        x, y = np.array([front.first, front.second])
        good = np.array(front.efficient, dtype=bool)
        axis.plot(x[good], y[good], color=AFTER, marker="o", ms=4)
        axis.plot(x[~good], y[~good], "x", color=LIMIT, ms=5)
        axis.margins(x=0.04)
        axis.set_xlabel(_labelled(front.names[0], front.units[0]))
        axis.set_ylabel(_labelled(front.names[1], front.units[1]))
        axis.set_title(front.title, loc="left", fontsize=10.5)
    return save_figure(figure, path)


def plot_calibration(found: Any, path: str | Path | None = None) -> Figure:
    """Of a Calibration, for every channel: record, run before and after; below, the residuals after."""
    names = list(found.measured)
    with drawing_style():
        figure = drawing(9.0, 3.6 * len(names) + 0.4)
        axes = figure.subplots(2 * len(names), 1, height_ratios=[2.2, 1.0] * len(names), squeeze=False)[:, 0]
        for top, below, name in zip(axes[::2], axes[1::2], names, strict=True):
            series = found.measured[name]
            top.plot(found.time, found.run_before[name], color=BEFORE, ls="--", lw=1.0, label="model before")
            top.plot(found.time, series.values, color=INK, lw=1.0, label="record")
            top.plot(found.time, found.run[name], color=AFTER, lw=1.0, label="model fitted")
            top.set(ylabel=f"{name} [{series.unit}]")
            top.legend(loc="upper right", ncols=3, fontsize=8)
            below.plot(found.time, found.residuals[name], color=LIMIT, lw=0.8)
            below.axhline(0.0, color=INK, linewidth=0.7)
            below.set(ylabel="residual", xlabel="time [s]" if name == names[-1] else "")
            left = f"left: {100 * found.left[name]:.2g} % (before {100 * found.left_before[name]:.2g} %)"
            below.set_title(left, loc="left", fontsize=8.5)
    return save_figure(figure, path)
