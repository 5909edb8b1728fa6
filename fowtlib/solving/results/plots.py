"""Figures of results, decays, response operators, spectra and modes, with labelled axes and units.

Every function returns a ``matplotlib.figure.Figure`` and, given a ``path``, writes it (png, pdf or svg by the ending).
matplotlib is imported on the first call; no window and no global state of pyplot is touched, so that figures are the
same on a server and in a notebook. The functions read attributes only (a decay needs ``.series``, ``.period``, ...),
and depend on no other part of the toolkit.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Panels of a floating turbine in the order of cause and effect: the results of a panel, one of each per rotor or line.
# A second result is drawn when it moves at least a tenth as much as the first (sway and roll matter in oblique seas).
PANELS: tuple[tuple[str, ...], ...] = (
    ("wind_speed",),
    ("wave_elevation",),
    ("surge", "sway"),
    ("heave",),
    ("pitch", "roll"),
    ("yaw",),
    ("rotor_speed",),
    ("blade_pitch",),
    ("generator_torque",),
    ("generator_power",),
    ("thrust",),
    ("fairlead_tension",),
)
# The least range of an axis: a part of the value, and an amount by its unit; smaller changes are not magnified.
LEAST_RANGE = 0.02
LEAST_RANGES = {"m": 0.1, "deg": 0.1, "rad": 0.002, "rpm": 0.1, "m/s": 0.1, "1": 1e-3, "-": 1e-3}
CROWDED, BESIDE = 8, 16  # spectra from which the legend of a panel stands beside it, and that have room there in 2.5 in


def plot_result(
    result: Any, names: Sequence[str] | None = None, path: str | Path | None = None, *, discard: float = 0.0
) -> Figure:
    """Time series, one panel per kind of quantity over a common time axis.

    names  results to show, one panel each; a name may be any variable of the model when the result can observe it.
           None shows the usual panels of a floating turbine, or all results when it has none of them.
    discard  seconds at the beginning that are not shown
    """
    if discard:
        result = _Later(result, discard)
    panels = _panels(result, names)
    if not panels:
        raise ModelError("there is nothing to plot: the result holds no series.")
    columns = 1 if len(panels) < 6 else 2
    rows = -(-len(panels) // columns)
    with drawing_style():
        figure = drawing(6.2 * columns, 0.7 + 1.45 * rows)
        grid = figure.add_gridspec(rows, columns)
        first = None
        for index, (title, members) in enumerate(panels):
            row, column = index % rows, index // rows
            lowest = index == len(panels) - 1 or row == rows - 1
            axis = figure.add_subplot(grid[row : rows if lowest else row + 1, column], sharex=first)
            first = first or axis
            _draw_series(axis, result, title, members)
            axis.tick_params(labelbottom=lowest)
            if lowest:
                axis.set_xlabel("time [s]")
        title = result.attributes.get("title") or result.attributes.get("model")
        if title:
            figure.suptitle(str(title), x=0.01, ha="left", fontsize=11, fontweight="bold")
    return save_figure(figure, path)


def plot_decay(decay: Any, path: str | Path | None = None) -> Figure:
    """Free decay with its extrema and the fitted envelope; below, damping ratio over amplitude."""
    series = decay.series
    unit = _unit(series.unit)
    with drawing_style():
        figure = drawing(7.5, 5.4)
        top, bottom = figure.subplots(2, 1, height_ratios=(1.7, 1.0))
        top.plot(series.time, series.values, color=COLORS[0], label=series.name)
        later = np.linspace(decay.extrema_time[0], decay.extrema_time[-1], 400)
        hull = decay.envelope(later)
        for sign, label in ((1.0, "fitted envelope"), (-1.0, None)):
            top.plot(later, decay.rest + sign * hull, color=COLORS[1], linestyle="--", linewidth=1.0, label=label)
        top.plot(decay.extrema_time, decay.extrema, "o", color=COLORS[1], markersize=3.5, label="extrema")
        top.axhline(decay.rest, color=INK, linewidth=0.7)
        top.set(xlabel="time [s]", ylabel=f"{series.name} [{unit}]")
        top.set_title(
            f"Free decay in {series.name}: period {decay.period:.4g} s ({decay.frequency:.4g} Hz), "
            f"damping ratio {100.0 * decay.damping_ratio:.3g} %"
        )
        top.legend(loc="upper right", ncols=3)
        bottom.plot(decay.amplitude, 100.0 * decay.damping, "o", color=COLORS[0], markersize=4, label="half cycles")
        reach = np.array([0.0, 1.05 * decay.amplitude.max()])
        line = 100.0 * (decay.damping_at_zero + decay.damping_slope * reach)
        sign = "+" if decay.damping_slope >= 0.0 else "\N{MINUS SIGN}"
        per = f" %/{unit}" if unit != "-" else " %"
        label = f"{100.0 * decay.damping_at_zero:.3g} % {sign} {abs(100.0 * decay.damping_slope):.3g}{per} x amplitude"
        bottom.plot(reach, line, color=COLORS[1], linestyle="--", linewidth=1.0, label=label)
        bottom.set(xlabel=f"amplitude [{unit}]", ylabel="damping ratio [%]", xlim=reach)
        lowest, highest = (100.0 * float(value) for value in (decay.damping.min(), decay.damping.max()))
        bottom.set_ylim(min(0.0, 1.15 * lowest), max(0.0, 1.15 * highest) or None)
        bottom.legend(loc="lower right")
    return save_figure(figure, path)


def plot_rao(
    raos: Any,
    path: str | Path | None = None,
    *,
    outputs: Sequence[str] | None = None,
    phase: bool = True,
    logarithmic: bool | None = None,
    title: str = "",
) -> Figure:
    """Response per metre of wave over frequency, amplitude and phase side by side, one row per output.

    raos         one response operator, or several to compare; those of fewer than 40 frequencies are drawn with markers
    logarithmic  scale of all amplitudes; None takes it where a resonance would hide the rest of one of them
    title        what the response is of, above the figure
    """
    raos = [raos] if hasattr(raos, "response") else list(raos)
    shown = list(outputs or dict.fromkeys(name for rao in raos for name in rao.outputs))
    columns = 2 if phase else 1
    if logarithmic is None:
        logarithmic = any(_hides(rao.amplitude(name)) for rao in raos for name in rao.outputs if name in shown)
    with drawing_style():
        figure = drawing(4.6 * columns + 0.4, 0.8 + 1.7 * len(shown))
        axes = figure.subplots(len(shown), columns, sharex=True, squeeze=False)
        for row, name in zip(axes, shown, strict=True):
            having = [(index, rao) for index, rao in enumerate(raos) if name in rao.outputs]
            for index, rao in having:
                look = _look(index, rao.frequency.size)
                row[0].plot(rao.frequency, rao.amplitude(name), label=rao.method, **look)
                if phase:
                    row[1].plot(*_broken(rao.frequency, rao.phase(name)), **look)
            row[0].set_title(name.replace("_", " "))
            row[0].set_ylabel(f"amplitude [{having[0][1].unit(name)}]")
            everything = np.concatenate([rao.amplitude(name) for _, rao in having])
            if logarithmic and everything.any():
                row[0].set_yscale("log")
                row[0].set_ylim(bottom=max(1e-4 * everything.max(), 0.7 * everything[everything > 0].min()))
                if np.ptp(np.log10(row[0].get_ylim())) > 1.2:  # the labels between the powers of ten would overlap
                    row[0].yaxis.set_minor_formatter("")
            else:
                row[0].set_ylim(bottom=0.0)
            if phase:
                row[1].set_ylabel("phase [deg]")
                row[1].set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180))
        for axis in axes[-1]:
            axis.set_xlabel("wave frequency [Hz]")
        if len(raos) > 1:
            axes[0][0].legend(loc="best")
        headings = sorted({round(float(np.degrees(rao.heading)), 6) for rao in raos})
        of = f"Response to waves of heading {headings[0]:g} deg" if len(headings) == 1 else "Response to waves"
        head = "\n".join(textwrap.fill(line, 46 * columns) for line in (*title.splitlines(), of))
        figure.suptitle(head, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return save_figure(figure, path)


def plot_spectra(
    spectra: Any,
    path: str | Path | None = None,
    *,
    targets: Mapping[str, Any] | None = None,
    highest: float | None = None,
    logarithmic: bool = True,
) -> Figure:
    """Power spectral densities, one panel per unit.

    targets  label -> function(frequency [Hz]) -> density, drawn into the first panel, such as the spectrum of the sea
    highest  last frequency shown, Hz; None: 0.5 Hz, or beyond what all but a hundredth of each variance lies below
    """
    spectra = [spectra] if hasattr(spectra, "density") else list(spectra)
    highest = max([0.5, *map(_reach, spectra)]) if highest is None else highest
    units = list(dict.fromkeys(spectrum.unit for spectrum in spectra))
    with drawing_style():
        panels = [[spectrum for spectrum in spectra if spectrum.unit == unit] for unit in units]
        heights = [2.5 * max(1.0, len(members) / BESIDE) for members in panels]
        figure = drawing(7.5, 0.6 + sum(heights))
        axes = figure.subplots(len(units), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
        for panel, (axis, unit, members) in enumerate(zip(axes, units, panels, strict=True)):
            top = 0.0
            for index, spectrum in enumerate(members):
                seen = (spectrum.frequency > 0) & (spectrum.frequency <= highest)
                label = spectrum.name.replace("_", " ")
                style = {"color": _color(index), "linestyle": ("-", "--", ":", "-.")[index // len(COLORS) % 4]}
                axis.plot(spectrum.frequency[seen], spectrum.density[seen], label=label, lw=1.0, **style)
                top = max(top, float(spectrum.density[seen].max()))
            if panel == 0:
                for index, (label, target) in enumerate((targets or {}).items()):
                    f = np.linspace(highest / 500, highest, 500)
                    axis.plot(f, target(f), color=INK, linestyle=("--", ":")[index % 2], lw=1.3, label=label)
            if logarithmic and top > 0.0:
                axis.set_yscale("log")
                axis.set_ylim(1e-5 * top, 3.0 * top)
            else:
                axis.set_ylim(bottom=0.0)
            axis.set_xlim(0.0, highest)
            axis.set_ylabel(f"density [{_squared(unit)}/Hz]")
            if len(members) > CROWDED:
                axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7.0)
            else:
                axis.legend(loc="upper right", ncols=2)
        axes[-1].set_xlabel("frequency [Hz]")
    return save_figure(figure, path)


def _reach(spectrum: Any) -> float:
    """Frequency [Hz] to show a spectrum to: somewhat above the one below which 99 % of the variance lies."""
    f, S = np.asarray(spectrum.frequency), np.asarray(spectrum.density)
    variance = np.concatenate([[0.0], np.cumsum(0.5 * (S[1:] + S[:-1]) * np.diff(f))])
    if not variance[-1] > 0:
        return 0.0
    return float(min(1.2 * f[np.searchsorted(variance, 0.99 * variance[-1])], f[-1]))


def plot_coefficients(coefficients: Sequence[Any], path: str | Path | None = None) -> Figure:
    """Aerodynamic inertia and damping over the period of the motion, one line for each way they were found."""
    with drawing_style():
        figure = drawing(7.5, 5.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        for index, one in enumerate(coefficients):
            order = np.argsort(one.frequency)
            few = {"marker": "o", "linestyle": "none"} if one.frequency.size < 12 else {}
            for axis, values in ((upper, one.inertia / 1e3), (lower, one.damping / 1e3)):
                axis.plot(1 / one.frequency[order], values[order], color=_color(index), label=one.method, **few)
        upper.set_ylabel("inertia [t]")
        lower.set_ylabel("damping [kN s/m]")
        lower.set_xlabel("period [s]")
        lower.axhline(0.0, color=INK, lw=0.6)
        upper.legend(loc="best")
    return save_figure(figure, path)


def plot_modes(modes: Sequence[Any], path: str | Path | None = None, *, title: str = "") -> Figure:
    """Natural frequencies and damping ratios of the oscillating modes as bars, the lowest frequency on top.

    modes  of ``linear.modes()``, or with their names of ``natural_modes(plant)``
    title  what the modes are of, above the figure
    """
    modes = [mode for mode in modes if _frequency(mode) > 0 and abs(mode.damping_ratio) < 1 - 1e-9]
    modes = sorted(modes, key=_frequency)
    if not modes:
        raise ModelError("there is nothing to plot: the linear model has no oscillating mode.")
    rows = np.arange(len(modes))
    if all(hasattr(mode, "name") for mode in modes):
        labels = [f"{mode.name}  {mode.number}" for mode in modes]
    else:
        labels = _last_words([mode.label or f"mode {i + 1}" for i, mode in enumerate(modes)])
    frequency = np.array([_frequency(mode) for mode in modes])
    damping = np.array([100.0 * mode.damping_ratio for mode in modes])
    with drawing_style():
        figure = drawing(8.0, 1.1 + 0.32 * len(modes))
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.4, 1.0))
        left.set_xscale("log")
        left.set_xlim(10.0 ** np.floor(np.log10(0.7 * frequency.min())), 4.0 * frequency.max())
        _bars(left, rows, frequency, COLORS[0], [f"{f:.4g} Hz  ({1 / f:.4g} s)" for f in frequency])
        _bars(right, rows, damping, COLORS[1], [f"{d:.3g} %" for d in damping])
        right.set_xlim(min(0.0, 1.25 * damping.min()), max(1.3 * damping.max(), 1.0))
        left.set_yticks(rows, labels)
        left.set_ylim(len(modes) - 0.4, -0.6)  # the lowest on top, no wider margins where there are many
        left.set_xlabel("natural frequency [Hz]")
        right.set_xlabel("damping ratio [%]")
        for axis in (left, right):
            axis.grid(visible=False, axis="y")
            axis.tick_params(axis="y", length=0)
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return save_figure(figure, path)


def _frequency(mode: Any) -> float:
    """Undamped frequency [Hz] of a mode, named or not."""
    return mode.frequency if hasattr(mode, "frequency") else mode.frequency_hz


# -- inside -----------------------------------------------------------------------------------------------------------


def _hides(amplitude: np.ndarray) -> bool:
    """True where a resonance is so high that a linear scale would show nothing else."""
    return bool(amplitude.max() > 30.0 * np.median(amplitude) > 0.0)


class _Later:
    """A result without its first seconds."""

    def __init__(self, result: Any, discard: float) -> None:
        self._result = result
        self._kept = result.time >= result.time[0] + discard
        if not self._kept.any():
            raise ModelError(f"discarding {discard:g} s leaves nothing of a result of {result.duration:g} s.")
        self.time = result.time[self._kept]
        self.attributes, self.unit, self.long_name = result.attributes, result.unit, result.long_name

    def array(self, name: str) -> np.ndarray:
        return self._result.array(name)[self._kept]

    def columns(self) -> Iterator[tuple[str, np.ndarray]]:
        return ((name, values[self._kept]) for name, values in self._result.columns())


def _panels(result: Any, names: Sequence[str] | None) -> list[tuple[str, list[str]]]:
    """Titles and members of the panels."""
    if names is not None:
        for name in names:
            result.array(name)  # an unknown name stops here, with a suggestion
        return [(result.long_name(name), [name]) for name in names]
    scalar = dict(result.columns())
    panels = []
    for kinds in PANELS:
        groups = [[name for name in scalar if re.fullmatch(rf"{kind}(_\w+)?", name)] for kind in kinds]
        if not groups[0]:
            continue
        moves = max(float(np.ptp(scalar[name])) for name in groups[0])
        others = [name for group in groups[1:] for name in group if np.ptp(scalar[name]) >= 0.1 * moves]
        title = ", ".join(kind for kind in kinds if any(name.startswith(kind) for name in [*groups[0], *others]))
        panels.append((title, [*groups[0], *others]))
    return panels or [(result.long_name(name), [name]) for name in scalar]


def _draw_series(axis: Axes, result: Any, title: str, members: Sequence[str]) -> None:
    for index, name in enumerate(members):
        width = 1.1 if result.time.size < 8000 else 0.7
        dashes = (None, (4, 1.5), (1.5, 1.0))[index] if index < 3 else (6, 1, 1, 1)  # one line does not hide another
        axis.plot(
            result.time, result.array(name), color=_color(index), label=_short(name, members), linewidth=width,
            dashes=dashes or (None, None),
        )  # fmt: skip
    unit = _unit(result.unit(members[0]))
    axis.set_title(f"{title.replace('_', ' ')} [{unit}]")
    if len(members) > 1:
        axis.legend(loc="upper right", bbox_to_anchor=(1.0, 1.2), ncols=len(members), borderpad=0.0, handlelength=1.2)
    flat = np.concatenate([result.array(name) for name in members])
    middle, size = float(flat.min() + np.ptp(flat) / 2), float(np.ptp(flat))
    least = max(LEAST_RANGE * abs(middle), LEAST_RANGES.get(result.unit(members[0]), 0.0))
    if size < 1e-6 * max(1.0, abs(middle)):  # a constant: no magnified rounding errors
        least = max(least, 0.1)
    if size < least:  # what hardly moves looks so
        axis.set_ylim(middle - least / 2, middle + least / 2)
    axis.ticklabel_format(axis="y", useOffset=False)


def _short(name: str, members: Sequence[str]) -> str:
    """Label in a legend: without what all members of the panel share ("rotor_speed_left" -> "left")."""
    if len(members) < 2:
        return name
    shared = 0
    words = [member.split("_") for member in members]
    while all(len(word) > shared + 1 and word[shared] == words[0][shared] for word in words):
        shared += 1
    return " ".join(name.split("_")[shared:])


def _last_words(paths: Sequence[str]) -> list[str]:
    """The last word of each path ("platform.motion.surge" -> "surge"); as many words as it takes to tell them apart."""
    words = [path.split(".") for path in paths]
    counts = range(1, max(map(len, words)) + 1)
    distinct = len(set(paths))
    count = next(n for n in counts if len({tuple(word[-n:]) for word in words}) == distinct)
    return [".".join(word[-count:]).replace("_", " ") for word in words]


def _color(index: int) -> str:
    return COLORS[index % len(COLORS)]


def _unit(unit: str) -> str:
    """Unit for an axis: "N*m" is written "N m", none is "-"."""
    return "-" if unit in ("", "1") else unit.replace("**", "^").replace("*", " ")


def _squared(unit: str) -> str:
    unit = _unit(unit)
    return "1" if unit == "-" else f"{unit}\N{SUPERSCRIPT TWO}" if unit.isalpha() else f"({unit})\N{SUPERSCRIPT TWO}"


def _look(index: int, points: int) -> dict[str, Any]:
    marks = points < 40
    return {
        "color": _color(index),
        "linestyle": "none" if marks and index else "-",
        "marker": "o" if marks else None,
        "markersize": 3.5,
        "clip_on": not (marks and index),
        "zorder": 3 if marks and index else 2,
    }


def _broken(frequency: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Phase with gaps where it jumps through 180 degrees, so that no line crosses the panel; no point is lost."""
    jumps = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
    return np.insert(frequency, jumps, frequency[jumps]), np.insert(np.asarray(phase, float), jumps, np.nan)


def _bars(axis: Axes, rows: np.ndarray, values: np.ndarray, color: str, labels: Sequence[str]) -> None:
    bars = axis.barh(rows, values, height=0.62, color=color)
    axis.bar_label(bars, labels, padding=4, fontsize=8.5, color=INK)
