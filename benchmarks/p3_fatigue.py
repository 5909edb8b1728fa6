"""Dirlik's law beside rainflow of runs, for five of the thirty states of the optimised 10-MW spar.

`python benchmarks/p3_fatigue.py --seeds 3` prints the table of docs/p3_design.md: damage of an hour at the base of the
tower and of the section 42 m above it, by the branch m = 5 of curve D. Runs of the elastic model are hours with a wind
and a sea of their own, after 600 s from the mean position; what they gave is kept in `--folder`.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path

import numpy as np
from pages import markdown
from scipy.stats import t as student

import fowtlib as fw
from fowtlib.analysis.fatigue import SNCurve, TubeSection, rainflow_cycles
from fowtlib.metocean import likely_states, site

DISCARD, HOUR, STEP = 600.0, 3600.0, 0.1
WINDS = (7.0, 11.0, 15.0, 19.0, 23.0)
CURVE = SNCurve(5.0, 15.606, thickness_exponent=0.2)
PLACES = {"tower_base_moment": (12.66, 0.061), "tower_moment_52": (12.742, 0.029)}  # diameter, wall [m]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=Path("output/p3_fatigue"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    plant, rows = fw.load("dtu10mw_spar_3_operating").compile(), []
    states = {u: (h, t) for u, h, t in likely_states(site("northern_north_sea").at(119), range(1, 31))}
    for speed in WINDS:
        height, period = states[speed]
        weather = {"wind.kind": "ntm", "wind.turbulence_class": "B", "wind.mean_speed": speed,
                   "sea.significant_wave_height": height, "sea.peak_period": period}  # fmt: skip
        found, runs = fw.response(plant, outputs=list(PLACES), parameters=weather), []
        for seed in range(1, given.seeds + 1):
            path = given.folder / f"{speed:g}_{seed}.json"
            if not path.exists():
                whole = {f"{part}.repetition_period": DISCARD + HOUR for part in ("wind", "sea")}
                more = whole | {"wind.seed": seed, "sea.seed": seed + 50, "wind.sample_step": STEP}
                run = plant.simulate(DISCARD + HOUR, STEP, parameters=weather | more, solver="fixed", start="turning",
                                     outputs=list(PLACES))  # fmt: skip
                kept, numbers = run.time >= DISCARD, {}
                for name, (diameter, wall) in PLACES.items():
                    stress = np.asarray(run[name].values)[kept] * 1e6 * TubeSection(diameter, wall).bending
                    cycles = rainflow_cycles((run.time[kept], stress))
                    numbers[name] = float(CURVE.with_thickness(wall).damage(cycles))
                path.write_text(json.dumps(numbers))
            runs.append(json.loads(path.read_text()))
        for name, (diameter, wall) in PLACES.items():
            curve, section = CURVE.with_thickness(wall), TubeSection(diameter, wall)
            dirlik, counted = (found.damage(name, curve, section, method=k, **more)
                               for k, more in (("dirlik", {}), ("rainflow", {"seeds": 6})))  # fmt: skip
            each = np.array([one[name] for one in runs])
            bound = student.ppf(0.975, len(each) - 1) * each.std(ddof=1) / np.sqrt(len(each)) / each.mean()
            ratio = dirlik / each.mean()
            rows.append((f"{speed:g} m/s, {height:.1f} m, {period:.1f} s", name, f"{dirlik:.3e}", f"{counted:.3e}",
                         f"{each.mean():.3e}", f"{ratio:.2f} +- {ratio * bound:.2f}"))  # fmt: skip
            print(rows[-1], flush=True)
    print(markdown((("state", "moment", "Dirlik", "inverse FFT", "rainflow, runs", "ratio"), rows)))


if __name__ == "__main__":
    main()
