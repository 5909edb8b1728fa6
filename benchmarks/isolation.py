"""How much the process of its own costs an FMU: a floating turbine, its controller an FMU called at 80 Hz.

python benchmarks/isolation.py FMU [SECONDS]

FMU: the controller of the tests, or one with the same ports. Wall and processor time, of both processes, of alternating
runs in this process and outside of it; what counts are the ratios of the medians.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

import fowtlib as fw
from fowtlib import models

TURBINE = "turbine: {use: turbines/nrel5mw_rigid}"
CONTROLLED = """turbine:
    use: turbines/nrel5mw_rigid
    rotor_speed_start: 1.267
    blade_pitch_start: 0.12
    parts:
      control:
        class: FMU
        file: FILE
        in_process: WHERE
        names: {"generator.speed": generator_speed, "pitch[1]": blade_pitch, torque: generator_torque}
        start: {pitch_start: 0.12, torque_start: 43093.55, speed_start: 122.9, "pitch[1]": 0.12 rad,
                torque: 43093.55 N*m, mode: 3, enabled: true}"""
RUNS = 3


def plant(path: str, in_process: bool) -> fw.Plant:
    """oc3_spar_rigid with the FMU as its controller."""
    text = (Path(models.__path__[0]) / "oc3_spar_rigid.yaml").read_text()
    assert TURBINE in text
    control = CONTROLLED.replace("FILE", str(Path(path).absolute())).replace("WHERE", str(in_process).lower())
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "controlled.yaml"
        file.write_text(text.replace(TURBINE, control))
        return fw.load(file, trust=True, allow=[Path(path).absolute().parent]).compile()


def used() -> tuple[float, float]:
    """Wall and processor time so far, of this process and of those that have ended [s]."""
    times = os.times()
    return time.perf_counter(), times.user + times.system + times.children_user + times.children_system


def main() -> None:
    """See above."""
    path, seconds = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
    plants = {where: plant(path, where) for where in (True, False)}
    found = {where: [] for where in plants}
    for k in range(RUNS + 1):
        for where, one in plants.items():
            begin = used()
            one.simulate(seconds, 1.0, solver="fixed", step=0.0125, outputs=["turbine.blade_pitch"])
            if k:  # the first ones compile
                found[where].append([after - before for before, after in zip(begin, used(), strict=True)])
    inside, outside = ([statistics.median(column) for column in zip(*found[where], strict=True)] for where in plants)
    for name, a, b in zip(("wall", "processor"), inside, outside, strict=True):
        print(f"{name:>10}: in process {a:.3f} s, outside {b:.3f} s, ratio {b / a:.3f}")


if __name__ == "__main__":
    main()
