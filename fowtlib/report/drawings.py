"""The figures of a report: values of many cases over one label, spectra, and series around an extreme."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fowtlib.analysis import Spectrum

SIZE = (4.6, 2.9)  # inches
EDGES = {"left": 0.17, "right": 0.98, "bottom": 0.16, "top": 0.97}  # fixed: to find them takes as long as to draw
MOST_POINTS = 1500  # of a line; of more, the lowest and highest of each stretch are drawn


def over_label(title: str, unit: str, label: str, groups: Mapping[str, np.ndarray]) -> Figure:
    """Mean, and the range from the least to the largest value, of each case over a label, and the mean over cases.

    groups: by group of cases, rows of label, mean, min, max.
    """
    with drawing_style():
        figure = drawing(*SIZE, EDGES)
        axis = figure.subplots()
        everything = np.concatenate(list(groups.values()))
        places = np.unique(everything[:, 0])
        least = np.diff(places).min() if len(places) > 1 else 1.0
        for index, (group, rows) in enumerate(groups.items()):
            color = COLORS[index % len(COLORS)]
            x = rows[:, 0] + 0.12 * least * (index - 0.5 * (len(groups) - 1))
            axis.vlines(x, rows[:, 2], rows[:, 3], color=color, linewidth=1.0, alpha=0.35)
            axis.plot(x, rows[:, 1], "o", color=color, markersize=3.0, alpha=0.8, label=group or None)
        if len(places) > 1:
            means = [everything[everything[:, 0] == place, 1].mean() for place in places]
            axis.plot(places, means, color=INK, linewidth=1.0)
        axis.margins(x=0.05)
        axis.set(xlabel=label, ylabel=f"{title} [{unit}]")
        if len(groups) > 1:
            axis.legend(loc="best")
    return figure


def spectra(title: str, unit: str, found: Mapping[str, Spectrum], highest: float) -> Figure:
    """Densities over frequency, one line for each label."""
    with drawing_style():
        figure = drawing(*SIZE, EDGES)
        axis = figure.subplots()
        top = 0.0
        for index, (name, spectrum) in enumerate(found.items()):
            inside = (spectrum.frequency > 0) & (spectrum.frequency <= highest)
            frequency, density = spectrum.frequency[inside], spectrum.density[inside]
            axis.plot(frequency, density, color=COLORS[index % len(COLORS)], label=name)
            top = max(top, float(density.max(initial=0.0)))
        if top > 0:
            axis.set_yscale("log")
            axis.yaxis.set_major_formatter(lambda value, _: f"{value:.0e}")  # no formulas, which are slow to set
            axis.yaxis.set_minor_formatter("")
            axis.set_ylim(top * 1e-6, top * 3)
        axis.set(xlabel="frequency [Hz]", ylabel=f"{title} [({unit})²/Hz]", xlim=(0.0, highest))
        axis.legend(loc="best")
    return figure


def around(time: np.ndarray, rows: Sequence[tuple[str, str, np.ndarray]], at: float) -> Figure:
    """Series one above the other, with a line at an instant. rows: title, unit and values of each."""
    with drawing_style():
        height = 0.7 + 1.25 * len(rows)
        figure = drawing(9.4, height, {"left": 0.09, "right": 0.99, "bottom": 0.5 / height, "top": 1 - 0.08 / height})
        axes = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for index, (axis, (title, unit, values)) in enumerate(zip(axes, rows, strict=True)):
            axis.plot(*thinned(time, values), color=COLORS[index % len(COLORS)])
            axis.axvline(at, color=INK, linewidth=0.8, linestyle="--")
            axis.set_ylabel(f"{title}\n[{unit}]")
        axes[-1].set_xlabel("time [s]")
    return figure


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same line to the eye with fewer points: of each stretch its lowest and its highest point."""
    if len(time) <= MOST_POINTS:
        return time, values
    ends = np.linspace(0, len(time), MOST_POINTS // 2 + 1).astype(int)
    kept = {0, len(time) - 1}
    for first, last in zip(ends[:-1], ends[1:], strict=True):
        kept |= {first + int(values[first:last].argmin()), first + int(values[first:last].argmax())}
    chosen = np.array(sorted(kept))
    return time[chosen], values[chosen]
