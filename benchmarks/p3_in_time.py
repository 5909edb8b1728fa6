"""The 10-MW spar in the nonlinear time domain, judged by its limits: `benchmarks/p3_in_time.py [DESIGN.json] FOLDER`.

Hours of the nonlinear model in the three states of fifty years (`--seeds 6`; `--storms 20` of EC3, where the line is
used most) and the thirty of fatigue (`--fatigue 2`), with lines that move. By default of the design in
benchmarks/p3_designs/optimum.json. What the runs have, means, largest values, deviations and damage-equivalent ranges
of rainflow, takes the place of what the response has in the question of p3_design.py, so that the same rules judge it;
both are printed. What a run gave is kept in FOLDER.
"""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from p3_design import HULL, STORMS, TOWER, begun_at, everywhere
from pages import markdown
from scipy.stats import t as student

import fowtlib as fw
from fowtlib.analysis.fatigue import damage_equivalent_load
from fowtlib.design import rules
from fowtlib.design.evaluation import Evaluated
from fowtlib.design.file import read_design
from fowtlib.design.measures import answer

DISCARD, HOUR, STEP = 600.0, 3600.0, 0.1
EXPONENT = 5.0
WATCHED = ("surge", "pitch", "fairlead_offset", "upwind_tension", "rotor_speed", "tower_base_moment",
           "tower_moment_node_5", "tower_moment_node_10", "hull_moment_node_8")  # fmt: skip
LINES = {"dynamic tension": "kN", "storm tension": "N"}  # what runs have needs no law of maxima
OF_LAW = ("deviations", "probable deviations", "tension at the mean offset")
EULER = 0.5772  # the mean of Gumbel's law above its mode, over its scale


def of_search(design: fw.Design) -> fw.Design:
    """The states of the search, whose damages stand for those of thirty, and all storms."""
    here = {case.name for case in design.cases}
    more = [case for case in everywhere(design).cases if case.name in STORMS and case.name not in here]
    constraints = [replace(item, cases=tuple(STORMS)) if "EC1" in (item.cases or ()) else item
                   for item in design.constraints]  # fmt: skip
    return replace(design, cases=[*design.cases, *more], constraints=constraints, slopes="differences")


class Hours:
    """Numbers of hours of each case: for each output its mean, deviation, largest, smallest and equivalent range."""

    def __init__(self, design: fw.Design, folder: Path, seeds: dict[str, int], fatigue: int):
        self.folder, self.seeds, self.fatigue = folder, seeds, fatigue
        folder.mkdir(parents=True, exist_ok=True)
        self.given = design.space.parameters(design.space.start)
        self.plant = design.plant

    def of(self, case: fw.DesignCase) -> list[dict[str, Any]]:
        return [self.run(case, seed) for seed in range(1, self.seeds.get(case.name, self.fatigue) + 1)]

    def run(self, case: fw.DesignCase, seed: int) -> dict[str, Any]:
        path = self.folder / f"{case.name.replace(' ', '_')}_{seed}.json"
        if not path.exists():
            plant = case.model or self.plant
            given = {name: value for name, value in self.given.items() if name in plant.dae.parameters}
            own = {f"{part}.{name}": value for part, number in (("wind", seed), ("sea", seed + 50))
                   for name, value in (("seed", number), ("repetition_period", DISCARD + HOUR))}  # fmt: skip
            run = plant.simulate(DISCARD + HOUR, STEP, start="turning", solver="fixed", outputs=list(plant.outputs),
                                 parameters={**given, **case.parameters, **own, "wind.sample_step": STEP})  # fmt: skip
            kept, found = run.time >= DISCARD, {}
            for name in plant.outputs:
                x = np.asarray(run[name].values)[kept]
                load = damage_equivalent_load((run.time[kept], x), EXPONENT) if "moment" in name else 0.0
                found[name] = [float(v) for v in (x.mean(), x.std(), x.max(), x.min(), load)]
            path.write_text(json.dumps({"units": {n: run[n].units for n in plant.outputs}, "values": found}))
        return json.loads(path.read_text())


class OfRuns:
    """An evaluator of a design (fowtlib.design.Evaluator) that has its results from hours of runs."""

    def __init__(self, hours: Hours, cases: Sequence[fw.DesignCase], keys: Sequence[tuple[str, str]]):
        self.hours, self.cases, self.keys = hours, {case.name: case for case in cases}, keys

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        values, units = {}, {}
        for case, name in self.keys:
            statistic, result = answer(name) or ("", name)
            runs = self.hours.of(self.cases[case])
            mean, std, largest, smallest, load = np.array([run["values"][result] for run in runs]).T
            values[case, name] = np.array([{
                "": mean.mean(), "std of ": np.sqrt(np.mean(std**2)), "largest ": largest.mean(),
                "smallest ": smallest.mean(), "range of ": np.mean(load**EXPONENT) ** (1 / EXPONENT),
            }[statistic]])  # fmt: skip
            units[name] = runs[0]["units"][result]
        return Evaluated(values, units)


def of_runs(design: fw.Design, hours: Hours) -> fw.Design:
    """The same question, with its results from runs; the lines of these move by themselves."""
    names = ["largest upwind_tension", "upwind_tension"]
    own = {line: fw.Function(line, lambda v, to=to: to * (v[names[0]] - v[names[1]]), names, unit)
           for (line, unit), to in zip(LINES.items(), (1.0, 1e3), strict=True)}  # fmt: skip
    offset = "largest fairlead_offset"
    own["storm offset"] = fw.Function("storm offset", lambda v: v[offset], [offset], "m")
    functions = [own.get(item.name, item) for item in design.functions if item.name not in OF_LAW]
    return replace(design, functions=functions,
                   evaluator=lambda plant, space, cases, keys, **_: OfRuns(hours, cases, keys))  # fmt: skip


def beside(design: fw.Design, hours: Hours) -> None:
    """Mean, deviation and largest value in the states of fifty years: response and runs with bounds at 95 %."""
    rows = []
    for case in (item for item in design.cases if item.name in STORMS):
        plant, runs = case.model or design.plant, hours.of(case)
        given = {name: value for name, value in hours.given.items() if name in plant.dae.parameters}
        some = [name for name in WATCHED if name in plant.outputs]
        response = fw.response(plant, outputs=some, parameters={**given, **case.parameters})
        for name in some:
            each = np.array([run["values"][name][:3] for run in runs])
            half = student.ppf(0.975, len(each) - 1) * each.std(axis=0, ddof=1) / np.sqrt(len(each))
            expected = (response.mean_of(name), response.std(name), response.extreme(name, HOUR, float(np.exp(-1))))
            ratio = [
                f"{e / m:.2f} +- {e / m**2 * h:.2f}" for e, m, h in zip(expected, each.mean(axis=0), half, strict=True)
            ]
            rows.append((case.name, name, "; ".join(f"{v:.4g}" for v in expected),
                         "; ".join(f"{v:.4g}" for v in each.mean(axis=0)), *ratio[1:]))  # fmt: skip
    heads = ("state", "result", "response: mean; deviation; largest", "runs", "deviation", "largest")
    print(markdown((heads, rows)))


def line_in_storm(design: fw.Design, hours: Hours, linear: fw.Optimum) -> None:
    """T_d of the line over its limit and the offset of the fairlead in the hours of EC3; means with bounds at 95 %."""
    runs = hours.of(next(case for case in design.cases if case.name == "EC3"))
    mean, largest = 1e3 * np.array([run["values"]["upwind_tension"][:3:2] for run in runs]).T
    found = linear.results["EC3"]
    use = rules.mooring_strength(mean, largest - mean, found["breaking strength"]).utilisation
    offset = np.array([run["values"]["fairlead_offset"][2] for run in runs])
    for what, x in (("T_d of the line in EC3 over its limit", use), ("largest offset of the fairlead [m]", offset)):
        scale, half = x.std(ddof=1) * np.sqrt(6) / np.pi, student.ppf(0.975, x.size - 1) * x.std(ddof=1) / x.size**0.5
        mode = x.mean() - EULER * scale
        print(f"{what}, {x.size} hours: {x.mean():.3f} +- {half:.3f}; by Gumbel's law {mode:.3f} most probable, "
              f"{mode - scale * np.log(-np.log(0.9)):.3f} in one hour of ten: {np.sort(x).round(2)}")  # fmt: skip
    print(f"by the response, in one hour of ten: {found['storm strength']:.3f} and {found['storm offset']:.2f} m; an "
          f"anchor is pulled up at {found['uplift offset']:.2f} m\n")  # fmt: skip


def uses(linear: fw.Optimum, nonlinear: fw.Optimum) -> None:
    """Each limit by the response and by the runs."""
    rows, names = [], [item.name for item in nonlinear.constraints]
    for name in names:
        a, b = (next(item for item in one.constraints if item.name == name) for one in (linear, nonlinear))
        broken = "broken" if b.violated else ""
        rows.append((name, f"{a.value:.4g}", f"{b.value:.4g}", f"{a.lower:.4g}", f"{a.upper:.4g}", broken))
    print(markdown((("limit", "response", "runs", "lower", "upper", ""), rows)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", type=Path, nargs="?", default=Path(__file__).parent / "p3_designs" / "optimum.json")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--storms", type=int, help="seeds of EC3, where these are others")
    parser.add_argument("--fatigue", type=int, default=2, help="seeds of each state of fatigue")
    parser.add_argument("--few", action="store_true", help="the four fatigue states of the search in place of thirty")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    begun = begun_at(read_design("dtu10mw_spar").design, asked.design)
    design = of_search(begun) if asked.few else everywhere(begun)
    seeds = dict.fromkeys(STORMS, asked.seeds) | {"EC3": asked.storms or asked.seeds}
    hours = Hours(design, asked.folder, seeds, asked.fatigue)
    beside(design, hours)
    linear, nonlinear = design.evaluate(), of_runs(design, hours).evaluate()
    line_in_storm(design, hours, linear)
    uses(linear, nonlinear)
    for part, ranges in (("hull", HULL), ("tower", TOWER)):
        ratios = [np.array(linear.results[case.name][name]) / nonlinear.results[case.name][name]
                  for case in design.cases if case.weight > 0 for name in ranges]  # fmt: skip
        print(part, "range by the response over that of runs, by state and place:")
        print(np.array(ratios).reshape(-1, len(ranges)).round(2))


if __name__ == "__main__":
    main()
