"""Statistics of load cases with a former and with the present code: `python benchmarks/former_statistics.py COMMIT`.

The same wind fields and seas, steps of 12.5 ms, 600 s behind 100 s that are left out. Beside the former code and the
present one, in turn, stand runs of the present one with iterations that are solved a thousand times closer, which tell
what the iterations of a step leave, and with half the step besides. COMMIT may be a folder with a checkout.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from former import HERE, _Checkout, checkout

MODELS = {"oc3_spar": 160.0, "two_rotor_spar": 300.0}  # width of the wind field [m]
CASES = [(8.0, 2.5, 9.8, 1), (12.0, 3.2, 10.1, 2), (18.0, 4.4, 10.7, 3)]  # wind speed [m/s], Hs [m], Tp [s], seed
DISCARD, DURATION, OUTPUT = 100.0, 700.0, 0.1  # s
RUNS = {"former": {}, "now": {}, "closer": {"newton": 0.2}, "half the step": {"newton": 0.2, "step": 0.00625}}
STEP = 0.0125  # s
PAIRS = [("former", "now"), ("closer", "now"), ("closer", "former"), ("half the step", "closer")]
SLOPES = (4.0, 10.0)  # of the damage-equivalent loads, of steel and of composites


def field(folder: Path, model: str, speed: float, seed: int) -> Path:
    """The wind field of a case, made once."""
    from fowtlib.components.environment import generate_field

    path, width = folder / f"{model}_{speed:g}_{seed}.bts", MODELS[model]
    if not path.exists():
        grid = {"columns": round(width / 10) + 1, "rows": 16, "width": width, "height": 150.0}
        generate_field(path, mean_speed=speed, duration=DURATION + 60.0, seed=seed, **grid)
    return path


def run(model: str, wind: str, sea: tuple[float, float, int], newton: float, step: float, path: str) -> None:
    """One run; its results go into a file of NumPy."""
    import fowtlib as fw
    from fowtlib.solving.engines import fixed_step

    if newton:
        fixed_step.NEWTON = newton
    height, period, seed = sea
    conditions = {"sea.spectrum": "jonswap", "sea.significant_wave_height": height, "sea.peak_period": period,
                  "sea.seed": seed, "wind.kind": "field", "wind.file": wind}  # fmt: skip
    plant = fw.load(model, set=conditions).compile()
    result = plant.simulate(DURATION, OUTPUT, start=plant.initial_state(), solver="fixed", step=step)
    np.savez(path, **{name: np.asarray(result[name]) for name in result.names})


def figures(series: np.ndarray) -> dict[str, float]:
    """Mean, deviation, extremes and damage-equivalent ranges of a series."""
    from fowtlib.analysis.fatigue.cycles import rainflow_cycles

    cycles = rainflow_cycles((OUTPUT * np.arange(len(series)), series))
    equivalent = {f"DEL {m:g}": cycles.power_mean(m, DURATION - DISCARD) for m in SLOPES}
    return {"mean": series.mean(), "std": series.std(), "max": series.max(), "min": series.min(), **equivalent}


def differences(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> dict[str, dict[str, float]]:
    """Of each result: by what share its figures differ, means of the root mean square, extremes of the range."""
    found = {}
    for name, series in one.items():
        a, b = (values.reshape(len(values), -1)[round(DISCARD / OUTPUT) :] for values in (series, other[name]))
        for k in range(a.shape[1]):
            size, spread = float(np.sqrt((a[:, k] ** 2).mean())), float(np.ptp(a[:, k]))
            if spread <= 1e-6 * size or not size:
                continue
            here, there = figures(a[:, k]), figures(b[:, k])
            of = here | {"mean": size, "max": spread, "min": spread}
            row = {key: abs(there[key] - here[key]) / of[key] for key in here}
            row["series"] = float(np.sqrt(((a[:, k] - b[:, k]) ** 2).mean())) / here["std"]
            found[name if a.shape[1] == 1 else f"{name}[{k}]"] = row
    return found


def results_of(model: str, case: tuple[float, float, float, int], before: Path, folder: Path) -> dict[str, dict]:
    """The results of all kinds of runs of a case."""
    speed, height, period, seed = case
    wind, found = field(folder, model, speed, seed), {}
    for kind, changed in RUNS.items():
        path = folder / f"{wind.stem}_{kind.replace(' ', '_')}.npz"
        if not path.exists():
            what = {"newton": 0.0, "step": STEP} | changed
            words = [model, wind, height, period, seed, what["newton"], what["step"], path]
            command = [sys.executable, "-W", "ignore", __file__, "one", before if kind == "former" else HERE, *words]
            threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
            subprocess.run([*map(str, command)], check=True, env=os.environ | threads, stdout=subprocess.DEVNULL)
        with np.load(path) as file:
            found[kind] = dict(file)
    return found


def main() -> None:
    """Run all and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("former")
    parser.add_argument("--keep", type=Path, help="folder for fields and results")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, checkout(options.former) as before:
        folder = options.keep or Path(name)
        folder.mkdir(exist_ok=True)
        for model in MODELS:
            for case in CASES:
                results = results_of(model, case, before, folder)
                for one, other in PAIRS:
                    found = differences(results[one], results[other])
                    for key in next(iter(found.values())):
                        worst = sorted(((row[key], label) for label, row in found.items()), reverse=True)
                        median = float(np.median([row[key] for row in found.values()]))
                        tops = ", ".join(f"{label} {value:.1e}" for value, label in worst[:3])
                        print(f"{model} {case[0]:g} {one}|{other} {key}: median {median:.1e}, {tops}", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "one":
        sys.meta_path.insert(0, _Checkout(Path(sys.argv[2])))
        model, wind, *rest, path = sys.argv[3:]
        height, period, seed, newton, step = rest
        run(model, wind, (float(height), float(period), int(seed)), float(newton), float(step), path)
    else:
        main()
