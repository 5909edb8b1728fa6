"""Pictures of contours and of exceedance over the response."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.metocean.states import States
from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fowtlib.metocean.comparison import Answers

YEARS = np.geomspace(0.01, 1000, 60)
_RINGS = 12  # sections of a surface that are drawn with a line and named


def plot_contours(
    contours: Sequence[tuple[str, States]],
    path: str | Path | None = None,
    *,
    rings: Sequence[tuple[str, States]] = (),
    open_lines: bool = False,
    height: float | None = None,
    title: str = "",
) -> Figure:
    """Wave height over wind speed, and over peak period.

    contours: lines of wind speed and wave height, by their labels, each a closed line unless open_lines. rings:
    sections of a surface at wind speeds, drawn over the peak period; without any it shows the period that goes with the
    line. height: of the wind speed [m].
    """
    with drawing_style():
        figure = drawing(9.4, 4.4)
        left, right = figure.subplots(1, 2, sharey=True)
        for index, (label, states) in enumerate(contours):
            color = COLORS[index % len(COLORS)]
            left.plot(*_line(states.wind_speed, states.wave_height, open_lines), color=color, label=label)
            if not rings:
                right.plot(*_line(states.peak_period, states.wave_height, open_lines), color=color, label=label)
        for index, (label, states) in enumerate(rings):
            left.plot(states.wind_speed, states.wave_height, color="#888888", linewidth=1.0, zorder=1)
            shade = 0.15 + 0.75 * index / max(len(rings) - 1, 1)
            color = _shade(shade)
            shown = len(rings) <= _RINGS or index % -(-len(rings) // _RINGS) == 0
            style = {"linestyle": "-"} if len(states) > 1 else {"marker": "o", "markersize": 3}
            right.plot(
                *_line(states.peak_period, states.wave_height, open_lines),
                color=color,
                label=label if shown else None,
                **style,
            )
        at = f" at {height:g} m" if height is not None else ""
        left.set(xlabel=f"mean wind speed{at} [m/s]", ylabel="significant wave height [m]")
        right.set(xlabel="peak period [s]")
        left.set_title("Wind and waves")
        right.set_title("Sections at wind speeds" if rings else "Period that goes with them (median)")
        for axis in (left, right):
            axis.set_xlim(0, 1.04 * max(line.get_xdata().max() for line in axis.get_lines()))
            if axis.get_legend_handles_labels()[0]:
                axis.legend(loc="upper left")
        left.set_ylim(0, None)
        figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return save_figure(figure, path)


def plot_exceedance(answers: Sequence[Answers], path: str | Path | None = None, *, title: str = "") -> Figure:
    """Return period over the response, one panel each: from all states a line, from contours their points."""
    columns = min(3, len(answers))
    rows = -(-len(answers) // columns)
    with drawing_style():
        figure = drawing(3.3 * columns + 0.6, 2.6 * rows + 0.7)
        axes = figure.subplots(rows, columns, squeeze=False)
        for axis, each in zip(axes.ravel(), answers, strict=False):
            if each.flta is not None:
                values = each.fits.sign * each.flta.curve(_reachable(each))
                axis.plot(values, _reachable(each), color=COLORS[0], label="all states (FLTA)")
            marks: list[tuple[str, Any, str]] = [
                (f"contour (ECM, {100 * each.ecm.fractile:g} %)", each.ecm.value, "o") if each.ecm else ("", None, ""),
                ("several contours (MECM)", each.mecm.value, "s") if each.mecm else ("", None, ""),
            ]
            for index, (label, value, marker) in enumerate(marks, start=1):
                if value is not None:
                    axis.plot(each.fits.sign * value, each.years, marker, color=COLORS[index],
                              markersize=8 - 3 * (index - 1), label=label)  # fmt: skip
            axis.axhline(each.years, color=INK, linewidth=0.7, linestyle=":")
            axis.set_yscale("log")
            axis.set(xlabel=f"{each.fits.label.replace('_', ' ')}{f' [{each.fits.unit}]' if each.fits.unit else ''}")
            axis.margins(x=0.06)
        for row in axes:
            row[0].set_ylabel("return period [years]")
        for axis in axes.ravel()[len(answers) :]:
            axis.set_visible(False)
        handles = {
            label: handle
            for axis in axes.ravel()
            for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3)
        figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return save_figure(figure, path)


def _reachable(answers: Answers) -> np.ndarray:
    """Return periods that the probability of all states allows."""
    from fowtlib.metocean.long_term import years_of

    assert answers.flta is not None
    shortest = years_of(answers.flta.states.weights.sum(), answers.flta.duration)
    return YEARS[shortest * 1.05 < YEARS]


def _line(x: np.ndarray, y: np.ndarray, is_open: bool) -> tuple[np.ndarray, np.ndarray]:
    return (x, y) if is_open else (np.append(x, x[:1]), np.append(y, y[:1]))


def _shade(part: float) -> Any:
    import matplotlib

    return matplotlib.colormaps["viridis"](part)
