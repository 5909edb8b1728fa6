"""The spar for the DTU 10-MW turbine, optimised: `python benchmarks/p3_design.py FOLDER [--nearest]`.

Runs models/designs/dtu10mw_spar.yaml and keeps journal, design and pictures in FOLDER; a search that was cut off goes on
from its best. `--nearest` asks for the design nearest to the printed one that keeps all limits instead of the cheapest:
least is the sum of squared changes of sizes over those printed. `--from DESIGN.json` begins at a saved design.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np

import fowtlib as fw
from fowtlib.design.file import read_design

FREE = ("stiffener_fraction", "ballast", "ring_web_height", "ring_web", "ring_flange_width", "ring_flange",
        "ring_spacing")  # fmt: skip
"""What is not printed, or follows from the rest: any change of it is as good as none."""


def nearest_to(design: fw.Design) -> fw.Design:
    """The same limits, with the smallest change of what is printed as the objective."""
    kept = {item.name: np.array(item.start) for item in design.space.placed if item.name not in FREE}

    def change(values: dict) -> ca.MX:
        return sum(ca.sumsqr((values[name] - start) / start) for name, start in kept.items()) + 1e-3

    functions = [item for item in design.functions if item.name not in ("value", "cost", "hull cost", "tower cost")]
    return replace(design, objective="change", functions=[*functions, fw.Function("change", change, list(kept))],
                   title="The printed spar, made feasible")  # fmt: skip


def begun_at(design: fw.Design, path: Path) -> fw.Design:
    """The same design with variables that start where a saved one ended."""
    saved = {size["name"]: size["value"] for size in json.loads(path.read_text())["variables"]}
    starts = {item.name: [saved[name] for name in item.elements] for item in design.space.placed}
    return replace(design, variables=[replace(item, start=starts[item.name]) for item in design.variables])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--file", default="dtu10mw_spar")
    parser.add_argument("--iterations", type=int, default=60)
    parser.add_argument("--region", type=float, default=0.08)
    parser.add_argument("--nearest", action="store_true")
    parser.add_argument("--from", dest="begin", type=Path)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()

    def say(line: str) -> None:
        print(f"{time.perf_counter() - begun:7.0f} s {time.process_time():6.0f} s  {line}", flush=True)

    read = read_design(arguments.file)
    design = read.design if arguments.begin is None else begun_at(read.design, arguments.begin)
    asked = nearest_to(design) if arguments.nearest else design
    options = {**read.optimiser, "iterations": arguments.iterations, "options": {"region": arguments.region, "say": say}}
    found = asked.optimise(**options, resume=True, journal=str(arguments.folder / "journal.jsonl"), say=say)
    print(found)
    found.save(arguments.folder / "design.json")
    found.plot(arguments.folder / "design.png")


if __name__ == "__main__":
    main()
