"""How long gradients of a response take beside the response: `python benchmarks/gradients.py [MODEL]`.

Processor time, at points that are new each time: 1, 20 and 80 parameters, one result and twelve.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import fowtlib as fw
from fowtlib.frequency import PreparedGradient
from fowtlib.solving.tuned import tuned_elements

WEATHER = {"wind.mean_speed": 18.0}
RESULTS = ["std pitch", "max fairlead_tension_2", "range thrust", "std surge", "std heave", "std rotor_speed",
           "mean pitch", "mean fairlead_tension_2", "range pitch", "frequency heave", "frequency surge",
           "damping pitch"]  # fmt: skip
POINTS = 3


def processor_time(function: Callable[..., Any], point: np.ndarray, moving: np.ndarray | None = None) -> float:
    """Median over some points, each a thousandth beside the last; moving: which elements move, None for all."""
    times = []
    for k in range(POINTS):
        moved = np.where(True if moving is None else moving, point * (1 + 1e-3 * (k + 1)), point)
        begin = time.process_time()
        function(moved)
        times.append(time.process_time() - begin)
    return sorted(times)[POINTS // 2]


def main(name: str) -> None:
    plant = fw.load(name).compile()
    paths = [path for path, item in plant.dae.parameters.items() if item.max is None]
    names = [item.name for path in paths for item in tuned_elements(plant, [path])]
    begin = time.process_time()
    fw.response(plant, parameters=WEATHER)
    print(f"{name}: fw.response, the first {time.process_time() - begin:.2f} s", end="")
    begin = time.process_time()
    fw.response(plant, parameters=WEATHER)
    print(f", again {time.process_time() - begin:.2f} s")
    print("| parameters | results | values | values and gradients | ratio |\n| --- | --- | --- | --- | --- |")
    for count in (1, 20, 80):
        for results in (RESULTS[:1], RESULTS):
            prepared = PreparedGradient(plant, results, names[:count], parameters=WEATHER)
            prepared.evaluate()
            values, both = (processor_time(one, prepared.start) for one in (prepared.values, prepared.evaluate))
            print(f"| {count} | {len(results)} | {values:.2f} s | {both:.2f} s | {both / values:.1f} |", flush=True)


if __name__ == "__main__":
    main(*(sys.argv[1:] or ["oc3_spar_rigid"]))
