"""Hull, tower and controller at once for four strategies: `python benchmarks/p4_optimum.py FOLDER [--strategy CS4]`.

Runs models/designs/dtu10mw_p4.yaml once for each strategy, which has its own feedback gains as variables: none (CS1),
of the platform's pitch rate (CS2), of the nacelle's velocity (CS3), of that velocity through a low-pass (CS4); `all`
has all three. Each search begins at the printed spar and keeps journal and design in FOLDER; one that was cut off goes
on from its best, and one that has ended is not repeated. Prints the tables of docs/p4_control.md.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from dataclasses import replace
from pathlib import Path

from p3_design import begun_at, processor_time

import fowtlib as fw
from fowtlib.design.file import read_design

FEEDBACK = {
    "CS1": (),
    "CS2": ("pitch_rate_gain",),
    "CS3": ("velocity_gain",),
    "CS4": ("filtered_gain", "filter_frequency"),
    "all": ("pitch_rate_gain", "velocity_gain", "filtered_gain", "filter_frequency"),
}


def with_strategy(design: fw.Design, name: str) -> fw.Design:
    """The same design with the feedback of one strategy; other gains stay at zero."""
    others = {gain for gains in FEEDBACK.values() for gain in gains} - {*FEEDBACK[name]}
    kept = [item for item in design.variables if item.name not in others]
    return replace(design, variables=kept, title=f"{design.title}, {name}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--strategy", action="append", choices=list(FEEDBACK), help="one of them; by default CS1 to CS4")
    parser.add_argument("--iterations", type=int, default=60)
    parser.add_argument("--region", type=float, default=0.04)
    parser.add_argument("--from", dest="begin", type=Path)
    parser.add_argument("--processes", type=int, default=1, help="that evaluate states at once")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    read, begun = read_design("dtu10mw_p4"), time.perf_counter()

    def say(line: str) -> None:
        print(f"{time.perf_counter() - begun:7.0f} s {processor_time():6.0f} s  {line}", flush=True)

    for name in arguments.strategy or list(FEEDBACK)[:4]:
        asked = replace(with_strategy(read.design, name), processes=arguments.processes)
        if arguments.begin is not None:
            asked = begun_at(asked, arguments.begin)
        say(name)
        options = {**read.optimiser, "iterations": arguments.iterations}
        found = asked.optimise(**options, options={"region": arguments.region, "say": say}, resume=True, say=say,
                               journal=str(arguments.folder / f"{name}.jsonl"))  # fmt: skip
        print(found, flush=True)
        found.save(arguments.folder / f"{name}.json")


if __name__ == "__main__":
    main()
