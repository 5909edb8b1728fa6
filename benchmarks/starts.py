"""What a start costs: error of mean and deviation over a window after a discarded time, by channel, over seeds.

Wind and waves repeat themselves after a period. A run that goes on for one period has no transient left and meets the
same wind and waves again, so that each start is compared with its own stationary run, and no scatter of seeds is in it.
Behind each error stands its standard error over the seeds.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/starts.py oc3_spar_rigid --period 4096 --seeds 8 --speeds 8,11,13,18
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np

import fowtlib as fw

STEP = 0.2  # s between output points
WINDOW = 600.0  # s
SEAS = {8: (2.5, 9.8), 11: (3.0, 10.0), 13: (3.5, 10.2), 18: (5.0, 11.0)}  # Hs [m] and Tp [s] at a wind speed [m/s]
CHANNELS = ("surge", "sway", "heave", "roll", "pitch", "yaw", "rotor_speed", "rotor_speed_left")  # where there are such
COLUMNS = (("rest", 0), ("rest", 200), ("turning", 0), ("turning", 60), ("turning", 200), ("stationary", 0),
           ("stationary", 60), ("stationary", 200))  # fmt: skip


def conditions(speed: int, seed: int, period: float) -> dict[str, float | int | str]:
    """Kaimal wind of class B and a JONSWAP sea that comes from 17 deg; no seed serves both."""
    height, peak = SEAS[speed]
    return {
        "wind.kind": "kaimal", "wind.mean_speed": float(speed), "wind.seed": seed, "wind.repetition_period": period,
        "sea.spectrum": "jonswap", "sea.significant_wave_height": height, "sea.peak_period": peak,
        "sea.seed": 1000 + seed, "sea.repetition_period": period, "sea.heading": 0.3,
    }  # fmt: skip


def rows(plant: fw.Plant, speed: int, seeds: int, period: float) -> list[str]:
    """Lines of the table at one wind speed."""
    names = [name for name in CHANNELS if name in plant.outputs]
    last = WINDOW + max(time for _, time in COLUMNS)
    series: dict[tuple[str, int], np.ndarray] = {}
    for seed in range(1, seeds + 1):
        given = conditions(speed, seed, period)
        long = _channels(names, plant.simulate(period + last, STEP, solver="fixed", parameters=given, start="turning"))
        count = round(last / STEP) + 1
        series["settled", seed] = long[round(period / STEP) :][:count]
        series["turning", seed] = long[:count]
        for start in ("rest", "stationary"):
            result = plant.simulate(last, STEP, solver="fixed", parameters=given, start=start)
            series[start, seed] = _channels(names, result)
    lines = []
    for i, name in enumerate(names):
        size = np.sqrt(np.mean([series["settled", seed][:, i].var() for seed in range(1, seeds + 1)]))
        cells = []
        for start, time in COLUMNS:
            window = slice(round(time / STEP), round((time + WINDOW) / STEP) + 1)
            found, wanted = (np.array([series[run, seed][window, i] for seed in range(1, seeds + 1)])
                             for run in (start, "settled"))  # fmt: skip
            means = (found.mean(axis=1) - wanted.mean(axis=1)) / size
            spreads = (found.std(axis=1) - wanted.std(axis=1)) / wanted.std(axis=1).mean()
            cells.append(f"{_percent(means)}, {_percent(spreads)}")
        lines.append(f"| {speed} m/s, {name.replace('_', ' ')} | {size:.3g} | {' | '.join(cells)} |")
    return lines


def _channels(names: list[str], result: fw.Result) -> np.ndarray:
    return np.column_stack([np.asarray(result[name], dtype=float) for name in names])


def _percent(errors: np.ndarray) -> str:
    """Mean over the seeds and its standard error."""
    whole, scatter = round(100 * errors.mean()), round(100 * errors.std(ddof=1) / np.sqrt(errors.size))
    return f"{whole:+d}±{scatter}" if whole else f"0±{scatter}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model")
    parser.add_argument("--period", type=float, default=4096.0)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--speeds", default="8,11,13,18")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    plant = fw.load(given.model).compile()
    print("| wind, result | deviation | " + " | ".join(f"{start}, {time} s" for start, time in COLUMNS) + " |")
    print("| --- " * (len(COLUMNS) + 2) + "|")
    for speed in map(int, given.speeds.split(",")):
        print("\n".join(rows(plant, speed, given.seeds, given.period)), flush=True)


if __name__ == "__main__":
    main()
