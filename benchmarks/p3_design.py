"""The spar for the DTU 10-MW turbine, optimised: `python benchmarks/p3_design.py FOLDER [--nearest]`.

Runs models/designs/dtu10mw_spar.yaml in two searches: first for the design nearest to the printed one that keeps all
limits, as least of squared changes of sizes over those printed, in which steps are long; then from there for the
cheapest. Journals, designs and pictures are in FOLDER; what was cut off goes on from its best. `--nearest` ends after
the first; `--from DESIGN.json` begins at a saved design, without the first. `--check` evaluates a design in all states:
thirty of fatigue, of 1 to 30 m/s, and three of fifty years, and holds the periods of heave and pitch at rest apart.
p3_in_time.py simulates it there.
"""

from __future__ import annotations

import argparse
import json
import os
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

import fowtlib as fw
from fowtlib.design import rules
from fowtlib.design.file import read_design
from fowtlib.metocean import likely_states, site

FREE = ("stiffener_fraction", "ballast", "ring_web_height", "ring_web", "ring_flange_width", "ring_flange",
        "ring_spacing", "fairlead_depth")  # fmt: skip
"""What is not printed, or follows from the rest, or is where the file has it: any change of it is as good as none."""

STRICT = 200.0  # penalty of broken limits in the first search: keeping EC3's is worth more than the default


def nearest_to(printed: fw.Design, design: fw.Design) -> fw.Design:
    """The same limits, with the smallest change of what is printed as the objective, from where a design starts."""
    kept = {item.name: np.array(item.start) for item in printed.space.placed if item.name not in FREE}

    def change(values: dict) -> ca.MX:
        frames = 0.1 * values["stiffener_fraction"]  # which are not printed: light ones
        return sum(ca.sumsqr((values[name] - start) / start) for name, start in kept.items()) + frames

    of_cost = ("value", "cost", "hull cost", "tower cost", "uneven diameters", "uneven walls")
    functions = [item for item in design.functions if item.name not in of_cost]
    functions.append(fw.Function("change", change, [*kept, "stiffener_fraction"]))
    return replace(design, objective=fw.Objective({"change": 1.0}, scale=0.05), functions=functions,
                   title="The printed spar, made feasible")  # fmt: skip


def begun_at(design: fw.Design, path: Path) -> fw.Design:
    """The same design with variables that start where a saved one ended; those that it has not stay as they are."""
    rows = json.loads(path.read_text())["variables"]
    saved = {row["variable"].rpartition(" [")[0]: row["optimum"] for row in rows}
    starts = {item.name: [saved[name] for name in item.elements]
              for item in design.space.placed if set(item.elements) <= set(saved)}  # fmt: skip
    return replace(design, variables=[replace(item, start=starts[item.name]) if item.name in starts else item
                                      for item in design.variables])  # fmt: skip


HULL = [f"range of hull_moment_node_{k}" for k in range(4, 11)]
TOWER = ["range of tower_base_moment", *(f"range of tower_moment_node_{k}" for k in range(1, 11))]
USES = ("hull use", "tower use")  # of stress by fatigue; 1 in all states, less in the few that stand for them
STORMS = {"EC1": (11.0, 7.5, 12.0, 0.18), "EC2": (21.0, 9.9, 14.0, 0.14), "EC3": (50.0, 15.1, 16.0, 0.12)}


def everywhere(design: fw.Design) -> fw.Design:
    """The same design in all states, with the damages of all of them."""
    parked = next(case.model for case in design.cases if case.model is not None)
    found = likely_states(site("northern_north_sea").at(119), range(1, 31))
    states = {f"wind {u:g}": (u, h, t, 0.14 * (0.75 * u + 5.6) / u) for u, h, t in found}
    weights = dict(zip(states, found.weights, strict=True))
    cases = []
    for name, (u, h, t, intensity) in {**STORMS, **states}.items():
        weather = {"wind.mean_speed": u, "wind.turbulence_intensity": intensity,
                   "sea.significant_wave_height": h, "sea.peak_period": t}  # fmt: skip
        turns = 4.0 <= u <= 25.0
        at_rest = {} if turns else {"thrust": 192.6e3 * (u / 50) ** 2}
        cases.append(fw.DesignCase(name, weather | at_rest, float(weights.get(name, 0.0)), None if turns else parked))

    def damage(ranges: list[str], tube: str, factor: float, first: int) -> fw.Function:
        sizes = [f"{tube}_diameters", f"{tube}_walls"]
        return fw.Function(f"{tube} fatigue", lambda v: rules.tube_fatigue(
            ca.vertcat(*(v[name] for name in ranges)), v[sizes[0]], v[sizes[1]], factor, first=first),
            [*ranges, *sizes], si=True)  # fmt: skip

    running = {f"std of rotor_speed @ {name}": weights[name] for name, state in states.items() if 4 <= state[0] <= 25}
    new = [damage(HULL, "hull", 3.0, 4), damage(TOWER, "tower", 2.0, 0),
           fw.Function("deviation", lambda v: sum(p * v[name] for name, p in running.items()) * np.pi / 30,
                       list(running), "rad/s")]  # fmt: skip
    names = {item.name for item in new}
    functions = [*(item for item in design.functions if item.name not in names), *new]
    constraints = [replace(item, cases=tuple(STORMS)) if "EC1" in (item.cases or ()) else item
                   for item in design.constraints]  # fmt: skip
    constraints = [replace(item, upper=1.0) if item.result in USES else item for item in constraints]
    return replace(design, cases=cases, functions=functions, constraints=constraints, slopes="differences")


def at_rest(design: fw.Design) -> fw.Design:
    """With the periods at rest in addition: heave over pitch stays 0.1 away from 0.5, 1, 1.5 and 2."""
    parked = next(case.model for case in design.cases if case.model is not None)
    calm = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 0.0, "thrust": 0.0}
    heave, pitch = (f"period of {mode} @ rest" for mode in ("heave", "pitch"))
    apart = fw.Function("periods apart", lambda v: ca.vertcat(*rules.period_ratio(v[heave], v[pitch])), [heave, pitch])
    return replace(design, cases=[*design.cases, fw.DesignCase("rest", calm, 0.0, parked)],
                   functions=[*design.functions, apart],
                   constraints=[*design.constraints, fw.Constraint("periods apart", upper=1.0)])  # fmt: skip


RINGS = ("ring_web_height", "ring_web", "ring_flange_width", "ring_flange", "ring_spacing")


def cheapest_rings(design: fw.Design, found: fw.Optimum) -> str:
    """Cost of a hull with the cheapest frames for its walls and the loads that were found."""
    z = np.append(found["depths"], [0.0, 10.0])
    sizes = [ca.DM(item) for item in (z, found["hull_diameters"], found["hull_walls"])]
    nodes = [f"largest hull_moment_node_{k}" for k in range(1, 11)] + ["largest tower_base_moment"]
    moments = [1e6 * max(found.results[storm][name] for storm in STORMS) for name in nodes]
    forces = [1e6 * found.results["EC1"][f"hull_axial_force_node_{k}"] for k in range(1, 11)]
    x, unit = ca.MX.sym("x", 20), np.repeat([0.5, 0.016, 0.4, 0.025, 2.5], 4)
    rings = ca.vertsplit(x * unit, 4)
    use, calm = (rules.hull_buckling(*sizes, ca.DM(m), ca.DM(forces), *rings, ends=True)
                 for m in (moments, np.zeros(11)))  # fmt: skip
    cost = rules.hull_cost(*sizes, *rings).cost / 1e6
    rows = ca.vertcat(use.shell, use.area, use.inertia, use.stress, use.web, use.flange, use.torsion, calm.inertia,
                      calm.stress)  # fmt: skip
    bounds = [
        np.concatenate([getattr(design.space[name], side) for name in RINGS]) / unit for side in ("lower", "upper")
    ]
    solver = ca.nlpsol("rings", "ipopt", {"x": x, "f": cost, "g": rows}, {"ipopt.print_level": 0, "print_time": False})
    best = solver(x0=np.concatenate([found[name] for name in RINGS]) / unit, lbx=bounds[0], ubx=bounds[1], ubg=1.0)
    kept = "" if solver.stats()["success"] else " (not found)"
    bare = rules.steel_cost(rules.tube_sections(*sizes)).cost / 1e6
    price = float(best["f"])
    return f"hull {price:.3f} MEUR with the cheapest frames{kept}, of which frames {price - float(bare):.3f}"


def draw(design: fw.Design, saved: dict[str, Path], to: Path) -> None:
    """Outlines and walls of hull and tower, as printed and as saved."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6), layout="constrained")
    shape, walls = figure.subplots(1, 2, sharey=True)
    tower = np.array(design.plant.parameter_values()["tower_heights"])
    for name, one in {"printed": design, **{k: begun_at(design, path) for k, path in saved.items()}}.items():
        at = {item.name: item.start for item in one.space.placed}
        z = np.append(at["depths"], [0.0, 10.0])
        heights = np.concatenate([z, tower])
        shape.plot(np.concatenate([at["hull_diameters"], at["tower_diameters"]]), heights, label=name)
        walls.plot(1e3 * np.concatenate([at["hull_walls"], at["tower_walls"]]), heights, label=name)
    shape.set(xlabel="diameter [m]", ylabel="height above the still water level [m]")
    walls.set(xlabel="wall [mm]")
    for axes in (shape, walls):
        axes.axhline(0.0, color="0.7", linewidth=0.8)
        axes.grid(alpha=0.3)
    shape.legend()
    figure.savefig(to, dpi=110)


def processor_times() -> tuple[float, float]:
    """Of this process, and of those that it has made, with those that have ended [s]."""
    ticks = 0
    for child in active_children():
        ticks += sum(map(int, Path(f"/proc/{child.pid}/stat").read_text().rpartition(")")[2].split()[11:13]))
    ended = os.times()
    return time.process_time(), ticks / os.sysconf("SC_CLK_TCK") + ended.children_user + ended.children_system


def searched(design: fw.Design, folder: Path, name: str, say: Callable[[str], None], options: dict[str, Any],
             **how: float) -> None:  # fmt: skip
    """Search; what it ends at is printed, and kept as NAME.json, .png and .jsonl."""
    found = design.optimise(**options, options={**how, "say": say}, resume=True, say=say,
                            journal=str(folder / f"{name}.jsonl"))  # fmt: skip
    print(found)
    found.save(folder / f"{name}.json")
    found.plot(folder / f"{name}.png")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--file", default="dtu10mw_spar")
    parser.add_argument("--iterations", type=int, help="at most, in place of those of the file")
    parser.add_argument("--region", type=float, default=0.04)
    parser.add_argument("--nearest", action="store_true", help="no more than the smallest change")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--draw", type=Path, help="a picture of the printed spar and of those in p3_designs")
    parser.add_argument("--from", dest="begin", type=Path)
    parser.add_argument("--processes", type=int, default=1, help="that evaluate states at once")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()

    def say(line: str) -> None:
        here, there = processor_times()
        print(f"{time.perf_counter() - begun:7.0f} s {here:5.0f} + {there:.0f} s  {line}", flush=True)

    read = read_design(arguments.file)
    design = read.design if arguments.begin is None else begun_at(read.design, arguments.begin)
    if arguments.draw:
        here = Path(__file__).parent / "p3_designs"
        draw(design, {"made feasible": here / "nearest.json", "found": here / "optimum.json"}, arguments.draw)
        return
    if arguments.check:
        found = at_rest(everywhere(design)).evaluate()
        print(found)
        print(cheapest_rings(design, found))
        found.save(arguments.folder / "check.json")
        return
    design = replace(design, processes=arguments.processes)
    options = read.optimiser | ({"iterations": arguments.iterations} if arguments.iterations else {})
    changed = arguments.folder / "nearest.json"
    if arguments.nearest or arguments.begin is None:
        if arguments.nearest or not changed.exists():
            searched(nearest_to(read.design, design), arguments.folder, "nearest", say, options,
                     region=arguments.region, penalty=STRICT)  # fmt: skip
        design = begun_at(design, changed)
    if not arguments.nearest:
        searched(design, arguments.folder, "design", say, options, region=arguments.region)


if __name__ == "__main__":
    main()
