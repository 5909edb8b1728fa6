"""Hull, tower and controller at once for four strategies: `python benchmarks/p4_optimum.py FOLDER [--strategy CS4]`.

Runs models/designs/dtu10mw_p4.yaml once for each strategy, which has its own feedback gains as variables: none (CS1),
of the platform's pitch rate (CS2), of the nacelle's velocity (CS3), of that velocity through a low-pass (CS4); `all`
has all three. A search begins at the design of its strategy in FOLDER, or else where CS1 has ended, or else at the
printed spar. Journals and designs are kept there; one that was cut off goes on from its best. `--check` evaluates the
designs of FOLDER in all states, fifteen of fatigue and three of fifty years, `--runs 2` has two runs of half an hour of
the nonlinear model in two of them, and each prints its table of docs/p4_control.md.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from p3_design import begun_at, processor_times
from p4_control import EXPONENT, EXTREMES, Spar, label, row
from p4_design import buckling_walls, cost, measures
from pages import markdown

import fowtlib as fw
from fowtlib.design import rules
from fowtlib.design.evaluation import Evaluated
from fowtlib.design.file import read_design

FEEDBACK = {
    "CS1": (),
    "CS2": ("pitch_rate_gain",),
    "CS3": ("velocity_gain",),
    "CS4": ("filtered_gain", "filter_frequency"),
    "all": ("pitch_rate_gain", "velocity_gain", "filtered_gain", "filter_frequency"),
}
WATCHED = ("rotor_speed", "pitch", "blade_pitch_rate", "tower_base_moment", "tower_moment_node_5")
RUN_IN = ("wind 17", "EC3")
LINE = (1167483.0, 6732.4)  # what a line pulls down with at rest [N] and its growth with heave [N/m], as in the file


def with_strategy(design: fw.Design, name: str) -> fw.Design:
    """The same design with the feedback of one strategy; other gains stay at zero."""
    others = {gain for gains in FEEDBACK.values() for gain in gains} - {*FEEDBACK[name]}
    kept = [item for item in design.variables if item.name not in others]
    return replace(design, variables=kept, title=f"{design.title}, {name}")


class Within:
    """Results of a design with more variables (fowtlib.design.Evaluator), of which others stay at zero.

    So responses and their slopes are prepared once for all strategies.
    """

    def __init__(self, whole: fw.Design, design: fw.Design):
        names = whole.space.elements
        self.whole, self.places = whole, [names.index(name) for name in design.space.elements]
        self.x = np.where([name in FEEDBACK["all"][:3] for name in names], 0.0, whole.space.start)

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        full = self.x.copy()
        full[self.places] = x
        found = self.whole.results.evaluate(full, jacobian)
        if found.jacobian is None:
            return found
        return replace(found, jacobian={key: slope[:, self.places] for key, slope in found.jacobian.items()})


def saved(design: fw.Design, folder: Path, name: str) -> fw.Design:
    """The design of a strategy that starts where its search ended."""
    return begun_at(with_strategy(design, name), folder / f"{name}.json")


def checked(design: fw.Design) -> dict[str, Any]:
    """A design in fifteen states of fatigue and three of fifty years, by responses with its own gains and drag."""
    given = design.space.parameters(design.space.start)
    gains = {path: float(np.ravel(value)[0]) for path, value in given.items() if "gain" in path or "filter_" in path}
    spar = Spar({path: value for path, value in given.items() if path not in gains}, exact=True)
    _, buckling = buckling_walls(spar, gains)
    state = next(state for state in spar.states if state[0] == 17.0)
    moment = {process: spar._response(state, gains).spectrum("tower_base_moment", process).std
              for process in ("sea", "wind")}  # fmt: skip
    found = row(spar, gains) | measures(given, np.array(given["hull_walls"], float))
    found["heave"] = float(rules.spar_heave_period(given["hull_heights"], given["hull_diameters"], *LINE))
    return found | {"tower": spar.steel(spar.t), "tower cost": cost(spar, spar.t), "buckling": float(buckling.max()),
                    "moment by": moment, "label": label(gains)}  # fmt: skip


def check(design: fw.Design, folder: Path) -> None:
    """The table of all designs that a folder has."""
    columns, base = {}, None
    for name in (name for name in FEEDBACK if (folder / f"{name}.json").exists()):
        one = checked(saved(design, folder, name))
        one["both"] = one["tower cost"] + one["hull"]
        base = base or one
        share = lambda key, one=one, base=base: f"({100 * (one[key] / base[key] - 1):+.1f} %)"  # noqa: E731
        many = lambda values, digits: ", ".join(f"{value:.{digits}f}" for value in values)  # noqa: E731
        columns[name] = {
            "gains": one["label"],
            "tower [t]": f"{one['tower'] / 1e3:.1f} {share('tower')}",
            "tower [MEUR]": f"{one['tower cost'] / 1e6:.3f} {share('tower cost')}",
            "hull [MEUR]": f"{one['hull'] / 1e6:.3f} {share('hull')}",
            "both [MEUR]": f"{one['both'] / 1e6:.3f} {share('both')}",
            "damage of the tower, largest and least": many((max(one["use"]), min(one["use"])), 3),
            "buckling of the tower": f"{one['buckling']:.3f}",
            "pitch in EC1, EC2, EC3 [deg]": many((one["largest"][e]["pitch"] for e in EXTREMES), 2),
            "heave [s], taper": many((one["heave"], one["taper"]), 3),
            "rotor speed [rad/s]": f"{one['speed']:.4f}",
            "duty cycle [1e-3]": f"{1e3 * one['duty']:.2f}",
            "platform pitch [deg]": f"{one['pitch']:.3f}",
            "moment of the base [MN m]": f"{one['moment']:.2f}",
            "at 17 m/s by sea, wind": many((one["moment by"][p] for p in ("sea", "wind")), 1),
            "pitch mode at 13, 17, 23 m/s [rad/s]": many(one["frequency"], 3),
            "its damping ratio": many(one["damping"], 2),
        }
    rows = [(head, *(column[head] for column in columns.values())) for head in next(iter(columns.values()))]
    print(markdown((("", *columns), rows)))


def in_time(design: fw.Design, folder: Path, seeds: int) -> None:
    """Runs of half an hour of the nonlinear model, of the same winds and seas for all, and the response over them."""
    rows = []
    for name in (name for name in FEEDBACK if (folder / f"{name}.json").exists()):
        asked = saved(design, folder, name)
        given = asked.space.parameters(asked.space.start)
        for case in (case for case in asked.cases if case.name in RUN_IN):
            plant = case.model or asked.plant
            own = {path: value for path, value in given.items() if path in plant.dae.parameters} | {**case.parameters}
            some = [result for result in WATCHED if result in plant.outputs]
            runs = [one_run(plant, own, some, seed, folder / f"run_{name}_{case.name.replace(' ', '_')}_{seed}.json")
                    for seed in range(1, seeds + 1)]  # fmt: skip
            response = fw.response(plant, outputs=some, parameters=own)
            for result in some:
                mean, std, load, most = np.array([run[result] for run in runs]).T
                std, load = np.sqrt(np.mean(std**2)), np.mean(load**EXPONENT) ** (1 / EXPONENT)
                over = f"{response.equivalent_load(result, EXPONENT) / load:.2f}" if load else ""
                rows.append((name, case.name, result, f"{mean.mean():.3g}", f"{response.mean_of(result):.3g}",
                             f"{std:.4g}", f"{response.std(result) / std:.2f}", f"{load:.1f}", over,
                             f"{most.mean():.4g}"))  # fmt: skip
    heads = ("strategy", "state", "result", "mean", "of the response", "deviation", "response over runs", "range",
             "response over runs", "largest")  # fmt: skip
    print(markdown((heads, rows)))


def one_run(plant: Any, given: dict[str, Any], results: list[str], seed: int, file: Path) -> dict[str, list[float]]:
    """By result: mean, deviation, damage-equivalent range and largest value of a run, but for its first 300 s."""
    if not file.exists():
        seeds = {"wind.seed": seed, "sea.seed": 100 + seed}
        run = plant.simulate(2100.0, 0.25, parameters=given | seeds, outputs=results, solver="fixed", step=0.05)
        late, found = np.asarray(run.time) > 300.0, {}
        for name in results:
            x = np.asarray(run[name])[late]
            load = fw.damage_equivalent_load(run[name], EXPONENT, discard=300.0) if "moment" in name else 0.0
            found[name] = [float(v) for v in (x.mean(), x.std(), load, x.max())]
        file.write_text(json.dumps(found))
    return json.loads(file.read_text())


def draw(design: fw.Design, folder: Path, to: Path) -> None:
    """Diameters and walls of the printed spar and of those that were found; spectra of the base moment at 17 m/s."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.8), layout="constrained")
    shape, walls, spectra = figure.subplots(1, 3)
    found = {name: saved(design, folder, name) for name in FEEDBACK if (folder / f"{name}.json").exists()}
    state = next(case for case in design.cases if case.name == "wind 17")
    for k, (name, one) in enumerate({"printed": with_strategy(design, "CS1"), **found}.items()):
        given, look = one.space.parameters(one.space.start), {"color": f"C{k}", "label": name, "lw": 1.2}
        values = {**design.plant.parameter_values(), **given}
        z = np.concatenate([values["hull_heights"], values["tower_heights"]])
        shape.plot(np.concatenate([values["hull_diameters"], values["tower_diameters"]]), z, **look)
        walls.plot(1e3 * np.asarray(values["tower_walls"]), values["tower_heights"], **look)
        response = fw.response(design.plant, outputs=["tower_base_moment"], parameters={**given, **state.parameters})
        for process, line in (("sea", "--"), ("wind", "-")):
            spectrum = response.spectrum("tower_base_moment", process)
            look |= {"ls": line, "label": f"{name}, {process}"}
            spectra.loglog(2 * np.pi * spectrum.frequency, spectrum.density / (2 * np.pi), **look)
    shape.set(xlabel="diameter [m]", ylabel="height above the still water level [m]")
    shape.axhline(0.0, color="0.7", lw=0.8)
    walls.set(xlabel="wall of the tower [mm]")
    spectra.set(xlim=(0.05, 2), ylim=(10, 1e5), xlabel="frequency [rad/s]",
                ylabel="base moment, 17 m/s [(MN m)^2 s/rad]")  # fmt: skip
    for axes in (shape, spectra):
        axes.legend(frameon=False, fontsize=7)
    figure.savefig(to, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--strategy", action="append", choices=list(FEEDBACK), help="by default CS1 to CS4")
    parser.add_argument("--iterations", type=int, default=60)
    parser.add_argument("--region", type=float, default=0.04)
    parser.add_argument("--processes", type=int, default=1, help="that evaluate states at once")
    parser.add_argument("--check", action="store_true", help="the designs of the folder in all states")
    parser.add_argument("--draw", type=Path, help="a picture of the designs of the folder")
    parser.add_argument("--runs", type=int, default=0, help="of half an hour in two states")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    read, begun = read_design("dtu10mw_p4"), time.perf_counter()

    def say(line: str) -> None:
        here, there = processor_times()
        print(f"{time.perf_counter() - begun:7.0f} s {here:5.0f} + {there:.0f} s  {line}", flush=True)

    if (arguments.check or arguments.runs or arguments.draw) and not list(arguments.folder.glob("CS?.json")):
        raise fw.ModelError(f"{arguments.folder} has no design such as CS1.json; benchmarks/p4_designs has four.")
    if arguments.check:
        check(read.design, arguments.folder)
    if arguments.runs:
        in_time(read.design, arguments.folder, arguments.runs)
    if arguments.draw:
        draw(read.design, arguments.folder, arguments.draw)
    if arguments.check or arguments.runs or arguments.draw:
        return
    whole = replace(read.design, processes=arguments.processes)
    for name in arguments.strategy or list(FEEDBACK)[:4]:
        asked = with_strategy(read.design, name)
        within = Within(whole, asked)
        asked = replace(asked, evaluator=lambda *_, within=within, **__: within)
        for first in (arguments.folder / f"{name}.json", arguments.folder / "CS1.json"):
            if first.exists():
                asked = begun_at(asked, first)
                break
        say(name)
        options = {**read.optimiser, "iterations": arguments.iterations}
        found = asked.optimise(**options, options={"region": arguments.region, "say": say}, resume=True, say=say,
                               journal=str(arguments.folder / f"{name}.jsonl"))  # fmt: skip
        print(found, flush=True)
        found.save(arguments.folder / f"{name}.json")


if __name__ == "__main__":
    try:
        main()
    except fw.ModelError as error:
        sys.exit(str(error))
