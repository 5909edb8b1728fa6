"""Pictures of docs/load_cases.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

INK, OTHER = "#0b5394", "#d1651b"
TITLES = {
    "wave_elevation": "wave [m]", "wind_speed": "wind at hub [m/s]", "surge": "surge [m]", "heave": "heave [m]",
    "pitch": "pitch [deg]", "yaw": "yaw [deg]", "rotor_speed": "rotor [rpm]", "blade_pitch": "blade pitch [deg]",
    "generator_power": "power [MW]", "thrust": "thrust [MN]", "blade_tip_out_of_plane_1": "tip out of plane [m]",
    "blade_root_flapwise_moment_1": "flapwise moment [MN m]", "tower_top_fore_aft_displacement": "tower top [m]",
    "tower_base_fore_aft_moment": "tower base moment [MN m]",
}  # fmt: skip
SCALES = {"generator_power": 1e-3, "thrust": 1e-3, "blade_root_flapwise_moment_1": 1e-6,
          "tower_base_fore_aft_moment": 1e-6}  # fmt: skip


def _axes(rows: int, columns: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=size, layout="constrained")
    axes = list(np.ravel(figure.subplots(rows, columns)))
    for axis in axes:
        axis.grid(color="#d9d9d9", linewidth=0.6)
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize=8)
    return figure, axes


def _save(figure: Figure, path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=100)


def series(result: Any, names: Sequence[str], path: Path, window: tuple[float, float]) -> None:
    """Time series of some results."""
    rows = (len(names) + 1) // 2
    figure, axes = _axes(rows, 2, (8.0, 1.45 * rows + 0.4))
    seen = (result.time >= window[0]) & (result.time <= window[1])
    for axis, name in zip(axes, names, strict=False):
        values = SCALES.get(name, 1.0) * np.asarray(result[name])[seen]
        axis.plot(result.time[seen], values, color=INK, linewidth=0.9)
        axis.set_title(TITLES[name], fontsize=9, loc="left")
        axis.set_xlim(window)
    for axis in axes[len(names) :]:
        axis.set_visible(False)
    for axis in axes[len(names) - 2 : len(names)]:
        axis.set_xlabel("time [s]", fontsize=9)
    _save(figure, path)


def steady(points: Mapping, fast: Mapping, pitch: Mapping, weight: float, path: Path) -> None:
    """Steady operation over the wind speed; published values as open circles."""
    figure, axes = _axes(2, 3, (9.0, 4.6))
    speeds = np.array(list(points))
    panels = (
        ("rotor speed [rpm]", [p.rotor_speed for p in points.values()], {}),
        ("blade pitch [deg]", [p.pitch for p in points.values()], pitch),
        ("power [MW]", [p.power / 1e3 for p in points.values()], {v: power / 1e3 for v, (power, _) in fast.items()}),
        ("force on the shaft [kN]", [p.thrust + weight for p in points.values()], {v: f for v, (_, f) in fast.items()}),
        ("tip out of plane [m]", [p.deflection for p in points.values()], {}),
        ("tower top [m]", [p.tower_top for p in points.values()], {}),
    )
    for axis, (title, own, published) in zip(axes, panels, strict=True):
        axis.plot(speeds, own, color=INK, linewidth=1.3, marker=".", markersize=4, label="fowtlib")
        if published:
            axis.plot(list(published), list(published.values()), "o", color=OTHER, fillstyle="none", markersize=5,
                      label="NREL")  # fmt: skip
            axis.legend(frameon=False, fontsize=8)
        axis.set_title(title, fontsize=9, loc="left")
        axis.set_xlim(2, 26)
    for axis in axes[3:]:
        axis.set_xlabel("wind speed [m/s]", fontsize=9)
    _save(figure, path)


def decays(found: Mapping[str, Any], path: Path) -> None:
    """Free decays with their envelopes."""
    figure, axes = _axes(1, len(found), (9.0, 2.6))
    for axis, (name, decay) in zip(axes, found.items(), strict=True):
        time = decay.series.time
        axis.plot(time, decay.series.values, color=INK, linewidth=1.0)
        after = time[time >= decay.extrema_time[0]]
        for sign in (1, -1):
            axis.plot(after, decay.rest + sign * decay.envelope(after), "--", color=OTHER, linewidth=0.9)
        axis.set_title(TITLES[name], fontsize=9, loc="left")
        axis.set_xlabel("time [s]", fontsize=9)
    _save(figure, path)


def spectra(found: Mapping[str, Any], path: Path) -> None:
    """Power spectra over a logarithmic axis."""
    figure, axes = _axes(2, 2, (9.0, 4.6))
    for axis, (name, spectrum) in zip(axes, found.items(), strict=True):
        shown = (spectrum.frequency > 0) & (spectrum.frequency < 1)
        scale = SCALES.get(name, 1.0) ** 2
        axis.loglog(spectrum.frequency[shown], scale * spectrum.density[shown], color=INK, linewidth=1.0)
        unit = TITLES[name].partition("[")[2].rstrip("]")
        squared = f"({unit})^2" if " " in unit else f"{unit}^2"
        axis.set_title(f"{TITLES[name].partition(' [')[0]} [{squared}/Hz]", fontsize=9, loc="left")
        axis.set_xlim(0.003, 1)
    for axis in axes[2:]:
        axis.set_xlabel("frequency [Hz]", fontsize=9)
    _save(figure, path)


def two_rotors(found: Mapping[Any, Any], path: Path) -> None:
    """Mean values, and below them standard deviations, over the wind speed of the cases."""
    figure, axes = _axes(2, 4, (10.0, 4.6))
    speeds = [case.speed for case in found]
    panels = (("yaw [deg]", ("yaw",)), ("pitch [deg]", ("pitch",)), ("surge [m]", ("surge",)),
              ("power [MW]", ("generator_power_left", "generator_power_right")))  # fmt: skip
    for column, (title, names) in enumerate(panels):
        for row, (kind, word) in enumerate((("mean", "mean"), ("std", "std. deviation of"))):
            axis = axes[4 * row + column]
            for name, color, dashes in zip(names, (INK, OTHER), ("-", "--"), strict=False):
                scale = 1e-3 if "power" in name else 1.0
                values = [scale * getattr(statistics[name], kind) for statistics in found.values()]
                label = name.rpartition("_")[2] if len(names) > 1 else None
                axis.plot(speeds, values, dashes, color=color, linewidth=1.3, marker=".", markersize=5, label=label)
            if len(names) > 1:
                axis.legend(frameon=False, fontsize=8)
            axis.set_title(f"{word} {title}", fontsize=9, loc="left")
            axis.set_xlim(4, 26)
            if row:
                axis.set_ylim(bottom=0)
                axis.set_xlabel("wind speed [m/s]", fontsize=9)
    _save(figure, path)


def gyroscopic(found: Mapping[str, Any], path: Path) -> None:
    """Pitch of each decay above, yaw and that of the oscillator below."""
    figure, axes = _axes(2, len(found), (2.6 * len(found), 4.2))
    for column, (name, run) in enumerate(found.items()):
        above, below = axes[column], axes[len(found) + column]
        above.plot(run.time, run.pitch, color=INK, linewidth=1.0)
        above.set_title(name, fontsize=8, loc="left")
        below.plot(run.time, run.yaw, color=INK, linewidth=1.2, label="model")
        below.plot(run.time, run.expected, "--", color=OTHER, linewidth=1.0, label="one oscillator")
        below.set_xlabel("time [s]", fontsize=9)
        above.set_ylim(-5.5, 5.5)
        below.set_ylim((-1, 1) if name == "oc3_spar" or column == 1 else (-6, 6))
    axes[0].set_ylabel("pitch [deg]", fontsize=9)
    axes[len(found)].set_ylabel("yaw [deg]", fontsize=9)
    axes[len(found)].legend(frameon=False, fontsize=8)
    _save(figure, path)
