"""Figures of extremes and comparisons, in the style of the figures of results.

The functions read attributes only: those of a Gumbel, a CrossingTail (and a GaussianMaximum), a Comparison.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.solving.results.drawing import COLORS, GRID, INK, drawing, drawing_style, save_figure
from fowtlib.solving.results.plots import _unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PROBABILITIES = (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.99, 0.995, 0.999)
LIGHT_COLORS = {"green": "#bfe3c6", "amber": "#fbdf9d", "red": "#f3b1a8", "none": "#eeeeee"}


def plot_gumbel(
    fit: Any,
    path: str | Path | None = None,
    *,
    duration: float | None = None,
    confidence: float = 0.95,
    count: int = 300,
    seed: int = 0,
    parametric: bool = False,
) -> Figure:
    """Gumbel paper: extremes over the reduced variate -ln(-ln F), on which Gumbel's distribution is a line.

    With the maxima at Gringorten's (i - 0.44) / (n + 0.12), and bounds by bootstrap. duration [s]: marks the most
    probable extreme of a longer time.
    """
    if fit.sample is None:
        raise ModelError("there is nothing to draw: this distribution was not fitted to maxima.")
    ordered = np.sort(fit.sign * fit.sample)
    reduced = -np.log(-np.log((np.arange(1, ordered.size + 1) - 0.44) / (ordered.size + 0.12)))
    longest = fit.duration if duration is None else duration
    last = max(reduced[-1] + 0.7, np.log(longest / fit.duration) + 0.5)
    x = np.linspace(min(reduced[0] - 0.2, -1.6), last, 60)
    p = np.exp(-np.exp(-x))
    bounds = fit.bounds_over(fit.duration, p.tolist(), confidence, count, seed, parametric)
    unit = _unit(fit.unit)
    with drawing_style():
        figure = drawing(7.0, 4.6)
        axis = figure.subplots()
        band = f"{100 * confidence:g} % bounds, {'parametric' if parametric else 'plain'} bootstrap"
        low, high = [b.low for b in bounds], [b.high for b in bounds]
        axis.fill_between(x, low, high, color=COLORS[0], alpha=0.15, linewidth=0, label=band)
        axis.plot(x, [b.value for b in bounds], color=COLORS[0], label=f"Gumbel, by {fit.method}")
        axis.plot(
            reduced, fit.sign * ordered, "o", color=COLORS[1], markersize=4, label=f"{ordered.size} {fit.side}ima"
        )
        if duration is not None:
            value = fit.return_value(duration)
            axis.plot(np.log(duration / fit.duration), value, "D", color=INK, markersize=5,
                      label=f"most probable in {_time(duration)}: {value:.4g} {unit}")  # fmt: skip
        about = f"F: probability that a block of {_time(fit.duration)} stays within"
        axis.set(xlabel=f"reduced variate -ln(-ln F) [-]; {about}", xlim=(x[0], x[-1]))
        axis.set_ylabel(f"{fit.name or 'extreme'} [{unit}]")
        shown = [q for q in PROBABILITIES if x[0] <= -np.log(-np.log(q)) <= x[-1]]
        top = axis.secondary_xaxis("top")
        top.set_xticks([-np.log(-np.log(q)) for q in shown], [f"{q:g}" for q in shown])
        top.set_xlabel("F [-]")
        axis.legend(loc="upper left" if fit.sign > 0 else "lower left")
    return save_figure(figure, path)


def plot_crossings(
    fit: Any,
    path: str | Path | None = None,
    *,
    duration: float | None = None,
    gaussian: Any = None,
) -> Figure:
    """Rates of up-crossings with 95 % confidence over the level, the fit, and a Gaussian process for comparison.

    duration [s]: marks the most probable extreme in that time, at the rate 1 / duration.
    """
    if fit.sample is None:
        raise ModelError("there is nothing to draw: this tail was not fitted to rates.")
    rates, unit = fit.sample, _unit(fit.unit)
    nu, half = rates.rate, rates.half_width
    seen = nu > 0.0
    lowest = 1.0 / duration if duration is not None else 0.3 * float(nu[seen].min())
    lowest = min(lowest, float(nu[seen].min()))
    end = fit.level(0.5 * lowest)
    levels = np.linspace(fit.threshold, end, 200)
    with drawing_style():
        figure = drawing(7.0, 4.6)
        axis = figure.subplots()
        low = np.where(nu > half, nu - half, 0.3 * lowest)
        axis.vlines(rates.levels[seen], low[seen], (nu + half)[seen], color=COLORS[1], linewidth=0.8, alpha=0.6)
        axis.plot(rates.levels[seen], nu[seen], "o", color=COLORS[1], markersize=3.5, label="counted, with 95 % bounds")
        axis.plot(levels, fit.rate(levels), color=COLORS[0], label=f"q exp(-a (y - b)^c), c = {fit.c:.3g}")
        if gaussian is not None:
            axis.plot(levels, gaussian.rate(levels), color=INK, linestyle="--", linewidth=1.0, label="Gaussian process")
        if duration is not None:
            value = fit.return_value(duration)
            axis.axhline(1.0 / duration, color=INK, linewidth=0.7)
            axis.plot(value, 1.0 / duration, "D", color=INK, markersize=5,
                      label=f"most probable in {_time(duration)}: {value:.4g} {unit}")  # fmt: skip
        axis.set_yscale("log")
        axis.set(
            xlabel=f"{fit.name or 'level'} [{unit}]", ylabel="rate of outward passages [1/s]", ylim=(0.4 * lowest, None)
        )
        axis.legend(loc="upper right" if fit.sign > 0 else "upper left")
    return save_figure(figure, path)


def plot_lights(comparison: Any, path: str | Path | None = None, *, title: str = "") -> Figure:
    """One row per channel, one column per measure: the difference in percent in the colour of its light."""
    names, measures = comparison.names, comparison.measures
    if not names:
        raise ModelError("there is nothing to draw: no channels were compared.")
    green, amber = comparison.limits
    with drawing_style():
        figure = drawing(2.6 + 1.15 * len(measures), 1.2 + 0.27 * len(names))
        axis = figure.subplots()
        axis.grid(False)
        for row in comparison.rows:
            i, j = names.index(row.name), measures.index(row.measure)
            axis.fill([j, j + 1, j + 1, j], [i, i, i + 1, i + 1], color=LIGHT_COLORS[row.light], linewidth=0)
            text = "no scale" if row.percent is None else _percent_text(row.percent)
            weight = "bold" if row.light == "red" else "normal"
            axis.text(j + 0.5, i + 0.5, text, ha="center", va="center", color=INK, fontsize=8.5, fontweight=weight)
        axis.hlines(range(len(names) + 1), 0, len(measures), color="white", linewidth=1.5)
        axis.vlines(range(len(measures) + 1), 0, len(names), color="white", linewidth=1.5)
        axis.set(xlim=(0, len(measures)), ylim=(len(names), 0))
        axis.set_xticks(np.arange(len(measures)) + 0.5, measures)
        units = {row.name: _unit(row.unit) for row in comparison.rows}
        axis.set_yticks(np.arange(len(names)) + 0.5, [f"{name} [{units[name]}]" for name in names])
        axis.tick_params(length=0)
        axis.xaxis.tick_top()
        text = (
            f"difference [% of the {comparison.relative_to}]: green to {green:g}, amber to {amber:g}, red (bold) beyond"
        )
        axis.set_xlabel(text, color=INK, fontsize=8.5)
        for side in ("left", "bottom"):
            axis.spines[side].set_color(GRID)
        if title:
            axis.set_title("\n".join(textwrap.wrap(title, 60)))
    return save_figure(figure, path)


def _percent_text(percent: float) -> str:
    digits = 0 if abs(percent) >= 99.5 else 1
    return f"{round(percent, digits) + 0.0:+.{digits}f}"  # + 0.0 makes of -0.0 a zero


def _time(seconds: float) -> str:
    """A duration as a person says it: 3 h, but 1000 s."""
    for unit, size in (("years", 365.25 * 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= size and abs(2.0 * seconds / size - round(2.0 * seconds / size)) < 1e-6:
            return f"{seconds / size:.4g} {unit}"
    return f"{seconds:.4g} s"
