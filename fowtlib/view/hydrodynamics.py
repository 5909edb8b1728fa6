"""Figure of a hydrodynamic database: added mass, damping and wave load over frequency."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_HALVES = ((0, 1, 2), (3, 4, 5))
_STYLES = ("-", (0, (6, 3)), "-")  # surge and sway, roll and pitch are often the same
_SMALL = 1e-6  # of the largest of its kind: a mode without a curve


def plot_database(database: Any, path: str | Path | None = None, *, heading: float = 0.0, title: str = "") -> Figure:
    """A, B and |X| of the six motions over the frequency; A_inf at the right edge; X for the heading [rad] nearest.

    database: a HydrodynamicDatabase.
    """
    nearest = database.nearest_heading(heading)
    degrees = np.degrees(database.heading[nearest])
    rows = (
        ("added mass", ("[kg]", "[kg m²]"), np.einsum("nii->ni", database.A), np.diag(database.A_inf)),
        ("radiation damping", ("[N s/m]", "[N m s]"), np.einsum("nii->ni", database.B), None),
        (f"wave load, heading {degrees:g}°", ("[N/m]", "[N m/m]"), np.abs(database.X[:, nearest]), None),
    )
    with drawing_style():
        figure = drawing(9.2, 8.4)
        axes = figure.subplots(3, 2, sharex=True)
        for row, (name, units, values, limit) in enumerate(rows):
            for column, modes in enumerate(_HALVES):
                axis = axes[row, column]
                _curves(axis, database.omega, values, limit, modes)
                axis.set_title(f"{name} {units[column]}")
                axis.legend(loc="best")
        for axis in axes[-1]:
            axis.set_xlabel("frequency [rad/s]")
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold", color=INK)
    return save_figure(figure, path)


def _curves(axis: Axes, omega: np.ndarray, values: np.ndarray, limit: np.ndarray | None, modes: tuple) -> None:
    largest = np.abs(values[:, modes]).max()
    for mode in modes:
        if np.abs(values[:, mode]).max() <= _SMALL * largest:
            continue
        color, style = COLORS[mode % 3], _STYLES[mode % 3]
        width = 2.2 if mode % 3 == 0 else 1.1  # the one that lies below
        axis.plot(omega, values[:, mode], color=color, linestyle=style, linewidth=width, label=_MODES[mode])
        if limit is not None:
            axis.plot([omega[-1]], [limit[mode]], color=color, marker="<", markersize=5, clip_on=False)
    if values.min() >= 0:
        axis.set_ylim(bottom=0)
