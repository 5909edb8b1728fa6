"""The tables and pictures of docs/control.md: PI, PI-P and LQR control of the two-rotor spar in turbulent wind.

    python benchmarks/control.py FOLDER

runs the batch in FOLDER (what is done already stays), prints the tables and draws docs/figures/control_*.png. Wind and
sea: O. El Beshbichi, thesis, Univ. of Stavanger (2023), chapter 5: Kaimal, class B, significant wave height 6 m, peak
period 10 s, constant power above rated wind.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import fowtlib as fw

SEEDS, DURATION, SETTLE = (1, 2, 3, 4), 1000.0, 200.0
WINDS = (5, 8, 10, 11, 12, 13, 15, 17, 20, 25)
INTENSITIES = (0.05, 0.10, 0.15, 0.20)
MEAN = {"sea.significant_wave_height": 6.0, "sea.peak_period": 10.0}
OUTPUTS = ("yaw", "pitch", "blade_pitch_left", "blade_pitch_right", "generator_power_left", "generator_power_right",
           "generator_speed_left", "generator_speed_right")  # fmt: skip
POWER = {f"turbine_{side}.control.region_3": "constant_power" for side in ("left", "right")}
CONTROLS = ("PI", "PI-P", "LQR", "LQR printed")
PRINTED = {  # tables 5.5 and 5.6: speeds of the own and the other rotor, yaw, yaw rate; integral. Up to this wind.
    10.5: (-0.0241, 0.0241, 1.2244, 5.4343, 1e-3), 12.5: (-0.87, -0.38, 1.929, 6.52, 0.0071),
    99.0: (-1.617, 1.0, 5.04, -0.8838, 0.1),
}
SINGLE = (13, 17)  # winds of the spar with one rotor
RATED = 5000.0  # kW
FIGURES = Path(__file__).parent.parent / "docs" / "figures"
Runs = dict[str, np.ndarray]


def models(folder: Path) -> dict[str, str]:
    """The models of the controls: a file with the yaw gain and constant power, or the shipped one."""
    found = {}
    for name, gain in (("PI", 0.0), ("PI-P", 1.5)):
        model = fw.load("two_rotor_spar_rigid").with_parameters({"yaw_gain": gain, **POWER})
        found[name] = str(folder / f"{name.lower().replace('-', '_')}.yaml")
        Path(found[name]).write_text(fw.dump(model))
    single = fw.load("oc3_spar_rigid").with_parameters({"turbine.control.region_3": "constant_power"})
    found["OC3"] = str(folder / "oc3.yaml")
    Path(found["OC3"]).write_text(fw.dump(single))
    return {**found, **dict.fromkeys(("LQR", "LQR printed"), "two_rotor_spar_rigid_feedback")}


def printed_gains() -> dict[str, list]:
    """The gains of the thesis as parameters of the feedback, over the points of its table."""
    table = fw.load("two_rotor_spar_rigid_feedback").root.feedback.table
    gains, integrals = np.zeros_like(table.gains), np.zeros_like(table.gains)
    for k, wind in enumerate(table.points):
        own, other, yaw, rate, integral = next(value for limit, value in PRINTED.items() if wind < limit)
        gains[k] = [[own, other, 0, 0, yaw, rate], [other, own, 0, 0, -yaw, -rate]]
        integrals[k, [0, 1], [0, 1]] = -integral
    flat = {"feedback.gains": gains, "feedback.integral_gains": integrals}
    return {path: values.reshape(len(table.points), -1).tolist() for path, values in flat.items()}


def cases(files: dict[str, str]) -> list[fw.Case]:
    """Each control in each wind with each seed; and over the turbulence intensity at 12 m/s."""
    made = []
    for control, file in files.items():
        for wind in SINGLE if control == "OC3" else WINDS:
            made += [_case(control, file, wind, seed, None) for seed in SEEDS]
        if control in ("OC3", "LQR printed"):
            continue
        made += [_case(control, file, 12, seed, i) for i in INTENSITIES for seed in SEEDS]
    return made


def _case(control: str, file: str, wind: float, seed: int, intensity: float | None) -> fw.Case:
    what = "class_B" if intensity is None else f"I{100 * intensity:g}"
    parameters = {**MEAN, "wind.mean_speed": wind, "wind.seed": seed, "sea.seed": seed}
    if intensity is not None:
        parameters["wind.turbulence_intensity"] = intensity
    if control == "LQR printed":
        parameters |= printed_gains()
    outputs = ("pitch", "blade_pitch", "generator_power", "generator_speed") if control == "OC3" else OUTPUTS
    name = control.lower().replace("-", "_").replace(" ", "_")
    return fw.Case(
        f"{name}_{wind:g}_{what}_{seed}", file, parameters, duration=DURATION,
        output_step=0.25, discard=SETTLE, outputs=outputs,
        labels={"control": control, "wind": wind, "seed": seed, "intensity": intensity or 0},
    )  # fmt: skip


def _each(result: fw.Result, name: str) -> list[np.ndarray]:
    names = [name] if name in result else [f"{name}_{side}" for side in ("left", "right")]
    return [np.asarray(result[item]) for item in names]


def _both(result: fw.Result, name: str) -> np.ndarray:
    return np.concatenate(_each(result, name))


def _rates(result: fw.Result) -> np.ndarray:
    step = float(result["pitch"].time[1] - result["pitch"].time[0])
    return np.concatenate([np.diff(series) / step for series in _each(result, "blade_pitch")])


FIGURES_OF_MERIT: dict[str, Callable[[fw.Result], float]] = {
    "yaw, deviation [deg]": lambda r: float(np.std(r["yaw"])) if "yaw" in r else np.nan,
    "pitch, mean [deg]": lambda r: float(np.mean(r["pitch"])),
    "pitch, deviation [deg]": lambda r: float(np.std(r["pitch"])),
    "power of a rotor, mean [kW]": lambda r: float(np.mean(_both(r, "generator_power"))),
    "power, deviation [kW]": lambda r: float(np.std(_both(r, "generator_power"))),
    "power, rms error [kW]": lambda r: float(np.sqrt(np.mean((_both(r, "generator_power") - RATED) ** 2))),
    "generator speed, mean [rpm]": lambda r: float(np.mean(_both(r, "generator_speed"))),
    "generator speed, deviation [rpm]": lambda r: float(np.std(_both(r, "generator_speed"))),
    "blade pitch, mean [deg]": lambda r: float(np.mean(_both(r, "blade_pitch"))),
    "blade pitch, deviation [deg]": lambda r: float(np.std(_both(r, "blade_pitch"))),
    "pitch rate, rms [deg/s]": lambda r: float(np.sqrt(np.mean(_rates(r) ** 2))),
}


def main() -> None:
    """Run, print, draw."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    batch = fw.run_batch(cases(models(folder)), folder / "batch", source="control", workers=1)
    values: dict[tuple, list[list[float]]] = {}
    for row in batch.rows("done"):
        labels = row.case.labels
        result = batch.result(row.case.name)
        merits = [merit(result) for merit in FIGURES_OF_MERIT.values()]
        values.setdefault((labels["control"], labels["wind"], labels["intensity"]), []).append(merits)
    mean = {key: np.mean(rows, axis=0) for key, rows in values.items()}
    spread = {key: np.std(rows, axis=0, ddof=1) / np.sqrt(len(rows)) for key, rows in values.items()}
    print_tables(mean, spread)
    draw(mean, spread)


def print_tables(mean: Runs, spread: Runs) -> None:
    """Every figure of merit over the wind; and yaw over the turbulence intensity."""
    for i, name in enumerate(FIGURES_OF_MERIT):
        heads = ("wind [m/s]", *CONTROLS, "LQR to PI-P", "printed to PI-P")
        print(f"\n{name}\n\n| " + " | ".join(heads) + " |\n" + "| --- " * len(heads) + "|")
        for wind in WINDS:
            row = [mean[control, wind, 0][i] for control in CONTROLS]
            change = " | ".join(f"{100 * (value / row[1] - 1):+.0f} %" for value in row[2:])
            print(f"| {wind} | " + " | ".join(f"{v:.4g}" for v in row) + f" | {change} |")
        if i:
            print("OC3: " + ", ".join(f"{mean['OC3', wind, 0][i]:.4g} at {wind} m/s" for wind in SINGLE))
    names = list(FIGURES_OF_MERIT)
    shown = [i for i, name in enumerate(names) if not name.startswith("blade") and "speed, mean" not in name]
    print("\n| wind [m/s] | " + " | ".join(names[i] for i in shown) + " |\n| --- " + "| --- " * 8 + "|")
    for wind in WINDS:
        cells = [" / ".join(f"{mean[control, wind, 0][i]:.4g}" for control in CONTROLS[:3]) for i in shown]
        print(f"| {wind} | " + " | ".join(cells) + " |")
    print("\nstandard errors of the mean over the seeds, largest of all winds, relative to the value")
    for i, name in enumerate(FIGURES_OF_MERIT):
        pairs = [(spread[c, w, 0][i], abs(mean[c, w, 0][i])) for c in CONTROLS for w in WINDS]
        largest = max(error / value for error, value in pairs if value > 0)
        print(f"  {name}: {100 * largest:.1f} %")
    print("\nyaw, deviation [deg], over the turbulence intensity\n")
    print("| intensity | " + " | ".join(CONTROLS[:3]) + " |\n| --- " + "| --- " * 3 + "|")
    for intensity in INTENSITIES:
        print(f"| {intensity:.2f} | " + " | ".join(f"{mean[c, 12, intensity][0]:.3g}" for c in CONTROLS[:3]) + " |")


def draw(mean: Runs, spread: Runs) -> None:
    """Six figures of merit over the wind, with the standard error over the seeds; yaw over the intensity."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown = (0, 2, 3, 4, 7, 10)
    names = list(FIGURES_OF_MERIT)
    figure, axes = plt.subplots(2, 3, figsize=(11, 6), layout="constrained")
    for axis, i in zip(axes.flat, shown, strict=True):
        for control in CONTROLS:
            values = [mean[control, wind, 0][i] for wind in WINDS]
            errors = [spread[control, wind, 0][i] for wind in WINDS]
            axis.errorbar(WINDS, values, errors, marker="o", markersize=3, capsize=2, label=control)
        axis.set(title=names[i], xlabel="mean wind [m/s]", ylim=(0, None))
        axis.grid(alpha=0.3)
    axes.flat[0].legend()
    figure.savefig(FIGURES / "control_effects.png", dpi=110)
    figure, axis = plt.subplots(figsize=(5, 3.4), layout="constrained")
    for control in CONTROLS[:3]:
        values = [mean[control, 12, i][0] for i in INTENSITIES]
        errors = [spread[control, 12, i][0] for i in INTENSITIES]
        axis.errorbar(INTENSITIES, values, errors, marker="o", markersize=3, capsize=2, label=control)
    axis.set(title="12 m/s", xlabel="turbulence intensity", ylabel="yaw, deviation [deg]", ylim=(0, None))
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(FIGURES / "control_intensity.png", dpi=110)


if __name__ == "__main__":
    main()
