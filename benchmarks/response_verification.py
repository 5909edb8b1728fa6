"""Responses beside runs: `python benchmarks/response_verification.py MODEL [...]` prints a table for docs/frequency.md.

Six seeds of an hour of wind field and waves in three states of operation and in a storm with the rotor idling. The
statistics of a run are kept in `--folder` as soon as it ends, so that a stopped benchmark goes on where it was. Bounds
are those of the mean of the seeds at 95 % (Student). `--states 8,12` takes some states, `--set PATH=VALUE` switches off
what is said to be the cause of a difference, in runs and response, and `--varying-speed` gives the response its option.
A switched state has a table of what this closes of the gap: the share of `ratio - 1` of the same seeds as they are.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from pages import markdown
from scipy.stats import t as student

import fowtlib as fw
from fowtlib.language.errors import SimulationError

DISCARD, LENGTH, STEP = 400.0, 3600.0, 0.1
STATES = {  # wind speed [m/s], significant wave height [m], peak period [s]
    "8": (8.0, 2.5, 9.8),
    "10": (10.0, 2.8, 9.9),
    "12": (12.0, 3.2, 10.1),
    "14": (14.0, 3.6, 10.3),
    "18": (18.0, 4.4, 10.6),
    "storm": (50.0, 12.7, 14.1),
}
OUTPUTS = (
    "surge", "sway", "heave", "roll", "pitch", "yaw", "rotor_speed", "blade_pitch", "thrust",
    "tower_base_fore_aft_moment", "tower_base_side_side_moment", "tower_base_torsion", "fairlead_tension_1",
    "fairlead_tension_2", "blade_root_flapwise_moment_1", "blade_root_edgewise_moment_1",
)  # fmt: skip


def weather(state: str, further: dict[str, Any] | None = None) -> dict[str, Any]:
    """Parameters of a state, without seeds; an intensity of the turbulence takes the place of its class."""
    speed, height, period = STATES[state]
    whole = LENGTH + DISCARD
    given = {
        "wind.kind": "turbulence", "wind.mean_speed": speed, "wind.turbulence_class": "B", "wind.sample_step": 0.1,
        "wind.repetition_period": whole, "sea.spectrum": "jonswap", "sea.significant_wave_height": height,
        "sea.peak_period": period, "sea.repetition_period": whole,
    }  # fmt: skip
    if "wind.turbulence_intensity" in (further or {}):
        del given["wind.turbulence_class"]
    return given | ({"*.safety.idling": 1} if state == "storm" else {}) | (further or {})


def statistics(plant: Any, names: list[str], state: str, seed: int, further: dict[str, Any]) -> dict[str, Any]:
    """Mean and standard deviation of each output in one run."""
    parameters = weather(state, further) | {"wind.seed": seed, "sea.seed": seed + 50}
    start = "rest" if state == "storm" else "turning"
    run = plant.simulate(LENGTH + DISCARD, STEP, parameters=parameters, solver="fixed", start=start)
    kept = run.time >= DISCARD
    values = {name: run[name].values[kept] for name in names}
    return {name: (float(np.mean(series)), float(np.std(series))) for name, series in values.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="+")
    parser.add_argument("--states", default="8,12,18,storm", help=f"of {', '.join(STATES)}")
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--folder", type=Path, default=Path("output/response_verification"))
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--linearisation", choices=("tangent", "equivalent", "quadratic"), default="tangent")
    parser.add_argument("--varying-speed", action="store_true")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    further = {path: _value(text) for path, _, text in (item.partition("=") for item in given.set)}
    label = hashlib.sha256(json.dumps(further, sort_keys=True).encode()).hexdigest()[:6] if further else "as_is"
    options: dict[str, Any] = {"linearisation": given.linearisation, "varying_speed": given.varying_speed}
    for model in given.models:
        plant = fw.load(model).compile()
        names = results_of(plant)
        columns: dict[str, dict[str, str]] = {}
        for state in given.states.split(","):
            runs = hours(given.folder, plant, model, state, given.seeds, further, label)
            try:
                found = fw.response(plant, outputs=names, parameters=weather(state, further), **options)
                columns[state] = table(f"{model}, {state}", names, found, runs)
                if further or given.varying_speed:
                    plain = fw.response(plant, outputs=names, parameters=weather(state))
                    before = hours(given.folder, plant, model, state, given.seeds, {}, "as_is")
                    closed(f"{model}, {state}", names, (plain, before), (found, runs))
            except SimulationError as error:
                print(f"\n{model}, {state}: {error}", flush=True)
        rows = [(name, *(column[name] for column in columns.values())) for name in names]
        print(f"\n{model}, standard deviations, response over runs\n")
        print(markdown((("result", *columns), rows)), flush=True)


def hours(
    folder: Path, plant: Any, model: str, state: str, seeds: int, further: dict[str, Any], label: str
) -> list[dict[str, Any]]:
    """Statistics of the runs of one state: those that are kept, and the others made now."""
    found = []
    for seed in range(1, seeds + 1):
        path = folder / f"{model}_{state}_{seed}_{label}.json"
        if not path.exists():
            path.write_text(json.dumps(statistics(plant, results_of(plant), state, seed, further)))
        found.append(json.loads(path.read_text()))
    return found


def results_of(plant: Any) -> list[str]:
    """Results that are kept: those of OUTPUTS, of the left rotor where there are two."""
    return [name for wanted in OUTPUTS for name in (wanted, f"{wanted}_left") if name in plant.outputs]


def _value(text: str) -> float | str:
    """A number, or a word such as that of `wind.components=u`."""
    try:
        return float(text)
    except ValueError:
        return text


def table(title: str, names: list[str], found: Any, runs: list[dict[str, Any]]) -> dict[str, str]:
    """Print response and runs of one state, and give the ratios with their bounds."""
    print(f"\n{title}: {len(runs)} seeds of {LENGTH:g} s\n")
    print("| result | mean, response | runs | standard deviation, response | runs | ratio |")
    print("| --- | --- | --- | --- | --- | --- |")
    ratios = {}
    for k, name in enumerate(names):
        means, stds = np.array([run[name] for run in runs]).T
        mean = stds.mean()
        ratios[name] = f"{found.std(name) / mean:.2f} +- {found.std(name) / mean**2 * bound(stds):.2f}" if mean else "-"
        print(f"| {name} [{found.units[k]}] | {found.mean[k]:.4g} | {means.mean():.4g} | {found.std(name):.4g} | "
              f"{mean:.4g} | {ratios[name]} |", flush=True)  # fmt: skip
    return ratios


def bound(values: np.ndarray) -> float:
    """Half of the range of 95 % of the mean of the values."""
    if len(values) < 2:
        return np.nan
    return float(student.ppf(0.975, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values)))


def closed(title: str, names: list[str], before: tuple[Any, Any], after: tuple[Any, Any]) -> None:
    """Print the ratios of (response, runs) as it is and switched, and the share of the gap that the switch closes."""
    rows = []
    for name in names:
        of_runs = [np.mean([run[name][1] for run in runs]) for _, runs in (before, after)]
        if min(of_runs) > 0:
            old, new = (found.std(name) / std for (found, _), std in zip((before, after), of_runs, strict=True))
            rows.append((name, f"{old:.3f}", f"{new:.3f}", f"{100 * (1 - abs(new - 1) / abs(old - 1)):.0f} %"))
    print(f"\n{title}, switched, {len(after[1])} seeds\n")
    print(markdown((("result", "as it is", "switched", "of the gap"), rows)), flush=True)


if __name__ == "__main__":
    main()
