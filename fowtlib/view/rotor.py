"""Figure of a rotor: its coefficients over tip speed ratio and pitch, and its steady operation over the wind."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_rotor(
    table: Any, power: np.ndarray, points: Sequence[Any], path: str | Path | None = None, *, title: str = ""
) -> Figure:
    """C_p and C_t as contours, with the line of steady operation; power, thrust, speed and pitch over the wind.

    table    tip_speed_ratio (n,), blade_pitch (m,) [rad], thrust (n, m): a CoefficientTable
    power    power coefficients (n, m)
    points   operating points by rising wind speed: wind_speed, rotor_speed, blade_pitch, ... in SI units
    """
    with drawing_style():
        figure = drawing(9.2, 8.4)
        grid = figure.add_gridspec(4, 2, height_ratios=(3.2, 1.0, 1.0, 0.02))
        for column, (values, name, best) in enumerate(((power, "C_p", True), (table.thrust, "C_t", False))):
            _contours(figure, figure.add_subplot(grid[0, column]), table, values, name, points, best)
        wind = np.array([point.wind_speed for point in points])
        series = (
            ("aerodynamic power [MW]", [point.aero_power / 1e6 for point in points]),
            ("rotor speed [rpm]", [point.rotor_speed * 30 / np.pi for point in points]),
            ("thrust [kN]", [point.thrust / 1e3 for point in points]),
            ("blade pitch [deg]", [np.degrees(point.blade_pitch) for point in points]),
        )
        for index, (name, values) in enumerate(series):
            axis = figure.add_subplot(grid[1 + index % 2, index // 2])
            axis.plot(wind, values, color=COLORS[index], marker="o", markersize=2.5, clip_on=False)
            axis.set_title(name)
            axis.set_ylim(bottom=min(0.0, min(values)))
            axis.margins(y=0.08)
            if index % 2:
                axis.set_xlabel("wind speed [m/s]")
            else:
                axis.tick_params(labelbottom=False)
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    return save_figure(figure, path)


def _contours(
    figure: Figure, axis: Axes, table: Any, values: np.ndarray, name: str, points: Sequence[Any], best: bool
) -> None:
    from matplotlib.ticker import MaxNLocator

    ratios, pitches = table.tip_speed_ratio, np.degrees(table.blade_pitch)
    top = float(values.max())
    levels = MaxNLocator(10, steps=[1, 2, 5]).tick_values(0.0, max(top, 0.01))
    filled = axis.contourf(ratios, pitches, values.T, levels, cmap="viridis", extend="min")
    figure.colorbar(filled, ax=axis, shrink=0.9, ticks=levels)
    ran = [(point.tip_speed_ratio, np.degrees(point.blade_pitch)) for point in points]
    line = {"color": "white", "marker": "o", "markersize": 2.5, "linewidth": 1.0}
    axis.plot(*zip(*ran, strict=True), **line, label="steady operation")
    if best:
        i, j = np.unravel_index(values.argmax(), values.shape)
        axis.plot(ratios[i], pitches[j], "*", color=COLORS[1], markersize=10, label=f"largest {name}: {top:.3f}")
    axis.set(xlabel="tip speed ratio", ylabel="blade pitch [deg]")
    axis.set_title(f"${name}$")
    axis.grid(visible=False)
    axis.legend(loc="upper right", facecolor="#e8e8e8", frameon=True, framealpha=0.85, labelcolor=INK)
