"""Runs in time over the gain of the yaw control, and over the mass of the mooring lines, for docs/design_maps.md.

`python benchmarks/design_sweeps.py` prints the tables and writes the pictures; with `--write` the tables go into the
page. `design_sweeps.py yaw_gain` does one of them.
Conditions: O. El Beshbichi, PhD thesis, University of Stavanger (2023), table 4.6.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pages import Table, fill, markdown

import fowtlib as fw
from fowtlib.solving.results.drawing import COLORS, drawing, drawing_style, save_figure

PAGE = Path(__file__).parent.parent / "docs" / "design_maps.md"
FIGURES = PAGE.parent / "figures"
DURATION, DISCARD, STEP = 1000.0, 300.0, 0.5  # s
SEEDS = range(1, 7)
GAINS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0)
MASSES = (150.0, 170.0, 180.0, 190.0, 200.0, 210.0, 230.0)  # kg/m
CONDITIONS = {"8 m/s": (8.0, 2.5, 9.8), "11.4 m/s": (11.4, 3.1, 10.1), "18 m/s": (18.0, 4.4, 10.6)}  # wind, Hs, Tp
DRAWN = 10.0  # largest gain in the picture
SIDES = ("left", "right")


def conditions(wind: float, height: float, period: float, seed: int) -> dict[str, Any]:
    """Parameters of a run; wind of the normal turbulence model, class B."""
    return {
        "wind.mean_speed": wind, "wind.seed": seed, "sea.seed": seed,
        "sea.significant_wave_height": height, "sea.peak_period": period,
    }  # fmt: skip


def runs(plant: Any, case: str, given: dict[str, Any], outputs: list[str]) -> list[Any]:
    """A result for each seed, without its beginning: arrays by name."""
    found = []
    for seed in SEEDS:
        parameters = {**conditions(*CONDITIONS[case], seed), **given}
        result = plant.simulate(DURATION, STEP, parameters=parameters)
        found.append({name: np.asarray(result[name])[int(DISCARD / STEP) :] for name in outputs})
    return found


def yaw_gain() -> Table:
    """Deviations of yaw and blade pitch, and mean power, over the gain of the yaw control."""
    plant = fw.load("two_rotor_spar_rigid").compile()
    pairs = [f"{name}_{side}" for name in ("blade_pitch", "generator_power") for side in SIDES]
    outputs = ["yaw", "pitch", "surge", *pairs]
    rows: list[tuple[object, ...]] = []
    curves: dict[str, list[tuple[float, ...]]] = {}
    for case in CONDITIONS:
        for gain in GAINS:
            found = runs(plant, case, {"yaw_gain": gain}, outputs)
            power = float(np.mean([sum(run[f"generator_power_{side}"].mean() for side in SIDES) for run in found]))
            values = (
                spread(found, "yaw"), float(np.mean([np.abs(run["yaw"]).max() for run in found])),
                (spread(found, "blade_pitch_left") + spread(found, "blade_pitch_right")) / 2,
                spread(found, "surge"), spread(found, "pitch"), power,
            )  # fmt: skip
            curves.setdefault(case, []).append(values)
            rows.append((case, gain, *values[:-1], curves[case][0][-1] - power))
    _draw_yaw(curves)
    heads = ("wind", "K", "yaw, deviation [deg]", "yaw, largest [deg]", "blade pitch, deviation [deg]",
             "surge, deviation [m]", "pitch, deviation [deg]", "loss of power [kW]")  # fmt: skip
    return heads, rows


def spread(found: list[Any], name: str) -> float:
    """Standard deviation, mean of the seeds."""
    return float(np.mean([run[name].std() for run in found]))


def _draw_yaw(curves: dict[str, list[tuple[float, ...]]]) -> None:
    panels = ((0, "yaw, standard deviation [deg]"), (2, "blade pitch, standard deviation [deg]"),
              (None, "loss of mean power, both rotors [kW]"))  # fmt: skip
    with drawing_style():
        figure = drawing(10.0, 3.4)
        for axis, (column, label) in zip(figure.subplots(1, len(panels)), panels, strict=True):
            for color, (case, values) in zip(COLORS, curves.items(), strict=False):
                table, drawn = np.array(values), np.array(GAINS) <= DRAWN
                y = table[0, -1] - table[:, -1] if column is None else table[:, column]
                axis.plot(np.array(GAINS)[drawn], y[drawn], color=color, marker=".", label=case)
            axis.set_xlabel("gain K of the yaw control [-]")
            axis.set_ylabel(label)
        figure.axes[0].legend(title="mean wind", fontsize=8)
    save_figure(figure, FIGURES / "yaw_gain.png")


def mooring_mass() -> Table:
    """Surge, tension and what lies on the seabed of the upwind line, over the mass of the lines."""
    outputs = {"seabed": "platform.mooring.line_2.seabed_length"}
    plant = fw.load("two_rotor_spar_rigid").compile()
    rows: list[tuple[object, ...]] = []
    for mass in MASSES:
        names = ["surge", "fairlead_tension_2", *outputs.values()]
        found = runs(plant, "11.4 m/s", {"platform.mooring_mass": mass}, names)
        seabed = [run[outputs["seabed"]].min() for run in found]
        rows.append((
            mass, float(np.mean([run["surge"].mean() for run in found])),
            float(np.mean([run["surge"].max() for run in found])), float(np.mean(seabed)), float(np.min(seabed)),
            float(np.mean([run["fairlead_tension_2"].max() for run in found])),
        ))  # fmt: skip
    _draw_mooring(np.array(rows, dtype=float))
    heads = ("mass [kg/m]", "surge, mean [m]", "surge, largest [m]", "least length on the seabed [m]",
             "of all seeds [m]", "tension, largest [kN]")  # fmt: skip
    return heads, rows


def _draw_mooring(rows: np.ndarray) -> None:
    with drawing_style():
        figure = drawing(7.5, 3.4)
        surge, seabed = figure.subplots(1, 2)
        surge.plot(rows[:, 0], rows[:, 2], color=COLORS[0], marker=".", label="largest")
        surge.plot(rows[:, 0], rows[:, 1], color=COLORS[1], marker=".", label="mean")
        surge.set_ylabel("surge [m]")
        surge.legend(fontsize=8)
        seabed.plot(rows[:, 0], rows[:, 3], color=COLORS[0], marker=".")
        seabed.axhline(0.0, color=COLORS[1], lw=1.0, ls="--")
        seabed.set_ylabel("least length on the seabed, upwind line [m]")
        for axis in (surge, seabed):
            axis.set_xlabel("mass of the mooring lines [kg/m]")
    save_figure(figure, FIGURES / "mooring_mass.png")


SWEEPS: dict[str, Callable[[], Table]] = {"yaw gain": yaw_gain, "mooring mass": mooring_mass}


def main() -> None:
    """Run the sweeps that are named, or all."""
    names = [name for name in SWEEPS if name.replace(" ", "_") in sys.argv[1:]] or list(SWEEPS)
    for name in names:
        text = markdown(SWEEPS[name](), 4)
        print(text, flush=True)
        if "--write" in sys.argv:
            PAGE.write_text(fill(PAGE.read_text(encoding="utf-8"), name, text), encoding="utf-8")


if __name__ == "__main__":
    main()
