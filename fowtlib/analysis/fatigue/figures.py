"""Figures of fatigue: S-N curves, and damage around a tube. They read attributes only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CYCLES = (1e4, 1e9)  # that an S-N curve is drawn for


def plot_sn_curves(curves: Sequence[Any], path: str | Path | None = None) -> Figure:
    """Stress ranges [MPa] over cycles to failure, with the place where the slope changes."""
    if not curves:
        raise ModelError("there are no S-N curves to plot.")
    ranges = np.geomspace(1e6, 1e10, 2000)
    with drawing_style():
        figure = drawing(6.5, 4.2)
        axis = figure.subplots()
        for index, curve in enumerate(curves):
            color = COLORS[index % len(COLORS)]
            cycles = curve.endurance(ranges)
            seen = (cycles >= CYCLES[0]) & (cycles <= CYCLES[1])
            axis.loglog(cycles[seen], ranges[seen] / 1e6, color=color, label=curve.name)
            if curve.knee:
                axis.plot(curve.endurance(curve.knee), curve.knee / 1e6, "o", color=color, markersize=4)
        axis.set_xlim(*CYCLES)
        axis.set_xlabel("cycles to failure")
        axis.set_ylabel("stress range [MPa]")
        axis.grid(which="minor", alpha=0.4)
        axis.legend(loc="upper right")
    return save_figure(figure, path)


def plot_damage_rose(damage: Any, path: str | Path | None = None) -> Figure:
    """Damage around a tube over the angle from x (downwind, to the right) to y (port, up), as share of the largest."""
    closed = np.append(damage.angles, damage.angles[0] + 2 * np.pi)
    share = np.append(damage.damage, damage.damage[0]) / (damage.worst or 1.0)
    with drawing_style():
        figure = drawing(4.6, 4.6)
        axis: Any = figure.add_subplot(projection="polar")
        axis.fill(closed, share, color=COLORS[0], alpha=0.25)
        axis.plot(closed, share, color=COLORS[0])
        axis.plot(damage.worst_angle, 1.0, "o", color=COLORS[1], clip_on=False)
        axis.set_rlim(0.0, 1.05)
        axis.set_rticks([0.25, 0.5, 0.75, 1.0])
        axis.set_rlabel_position(67.5)
        axis.tick_params(colors=INK)
        axis.set_xticks(np.radians(np.arange(0, 360, 45)), ["x", "45°", "y", "135°", "-x", "225°", "-y", "315°"])
        axis.set_title(
            f"damage over the largest, {damage.worst:.3g} in {damage.duration:g} s\n"
            f"at {np.degrees(damage.worst_angle):.4g}° from x to y"
        )
    return save_figure(figure, path)
