"""Responses beside runs: `python benchmarks/response_verification.py MODEL [...]` prints a table for docs/frequency.md.

Six seeds of an hour of wind field and waves in three states of operation and in a storm with the rotor idling. The
statistics of a run are kept in `--folder` as soon as it ends, so that a stopped benchmark goes on where it was. Bounds
are those of the mean of the seeds at 95 % (Student). `--states 8,12` takes some states, `--set PATH=VALUE` switches off
what is said to be the cause of a difference.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
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


def weather(state: str) -> dict[str, Any]:
    """Parameters of a state, without seeds."""
    speed, height, period = STATES[state]
    whole = LENGTH + DISCARD
    given = {
        "wind.kind": "turbulence", "wind.mean_speed": speed, "wind.turbulence_class": "B", "wind.sample_step": 0.1,
        "wind.repetition_period": whole, "sea.spectrum": "jonswap", "sea.significant_wave_height": height,
        "sea.peak_period": period, "sea.repetition_period": whole,
    }  # fmt: skip
    return given | ({"*.safety.idling": 1} if state == "storm" else {})


def statistics(plant: Any, names: list[str], state: str, seed: int, further: dict[str, Any]) -> dict[str, Any]:
    """Mean and standard deviation of each output in one run."""
    parameters = weather(state) | {"wind.seed": seed, "sea.seed": seed + 50} | further
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
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    further = {path: _value(text) for path, _, text in (item.partition("=") for item in given.set)}
    label = hashlib.sha256(json.dumps(further, sort_keys=True).encode()).hexdigest()[:6] if further else "as_is"
    for model in given.models:
        plant = fw.load(model).compile()
        names = [name for wanted in OUTPUTS for name in (wanted, f"{wanted}_left") if name in plant.outputs]
        for state in given.states.split(","):
            runs = []
            for seed in range(1, given.seeds + 1):
                path = given.folder / f"{model}_{state}_{seed}_{label}.json"
                if not path.exists():
                    path.write_text(json.dumps(statistics(plant, names, state, seed, further)))
                runs.append(json.loads(path.read_text()))
            table(plant, model, state, names, runs, weather(state) | further, given.linearisation)


def _value(text: str) -> float | str:
    """A number, or a word such as that of `wind.components=u`."""
    try:
        return float(text)
    except ValueError:
        return text


def table(plant: Any, model: str, state: str, names: list[str], runs: list[dict[str, Any]],
          parameters: dict[str, Any], linearisation: str) -> None:  # fmt: skip
    """Print response and runs of one state; where there is no response, why."""
    try:
        found = fw.response(plant, outputs=names, parameters=parameters, linearisation=linearisation)
    except SimulationError as error:
        print(f"\n{model}, {state}: {error}", flush=True)
        return
    bound = student.ppf(0.975, len(runs) - 1) / np.sqrt(len(runs)) if len(runs) > 1 else np.nan
    print(f"\n{model}, {state}: {len(runs)} seeds of {LENGTH:g} s\n")
    print("| result | mean, response | runs | standard deviation, response | runs | ratio |")
    print("| --- | --- | --- | --- | --- | --- |")
    for k, name in enumerate(names):
        means, stds = np.array([run[name] for run in runs]).T
        mean, std = stds.mean(), (stds.std(ddof=1) if len(runs) > 1 else np.nan)
        ratio = f"{found.std(name) / mean:.2f} +- {found.std(name) / mean * bound * std / mean:.2f}" if mean else "-"
        print(f"| {name} [{found.units[k]}] | {found.mean[k]:.4g} | {means.mean():.4g} | {found.std(name):.4g} | "
              f"{mean:.4g} | {ratio} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
