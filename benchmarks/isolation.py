"""How much the process of its own costs an FMU and a controller library, called at 80 Hz.

python benchmarks/isolation.py [SECONDS] [--only PART]

The FMU and the library of the tests: bare exchanges without a model, then as the controller of a floating turbine with
a rigid tower and blades, and with flexible ones, for SECONDS and a fifth of it. Medians of alternating runs in this
process and outside of it: the start (what a run of one call takes), and what each further call takes with its part of
the simulation, in wall and in processor time, of both processes.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib import models
from fowtlib.components.fmu import FMU
from fowtlib.components.fmu.running import FmuProcess
from fowtlib.components.servo.bladed import MEASURED
from fowtlib.components.servo.bladed_library import PITCH, TORQUE, BladedProcess
from fowtlib.language.native import compiler

TESTS = Path(__file__).parents[1] / "tests"
sys.path.insert(0, str(TESTS / "fmu"))

PERIOD = 0.0125  # s
CALLS = 20_000
RUNS = 3
TURBINES = {"oc3_spar_rigid": "turbines/nrel5mw_rigid", "oc3_spar": "turbines/nrel5mw"}
YAW = {"oc3_spar_rigid": "", "oc3_spar": ", mode: yaw}\n        units: {mode: rad"}  # which that FMU does not use
START = {"generator.speed": 1173.6, "pitch[1]": 0.12, "torque": 43.09355, "mode": 3, "enabled": True}
CONTROLLED = """turbine:
    use: USE
    rotor_speed_start: 1.267
    blade_pitch_start: 0.12
    parts:
      control:
        class: FMU
        file: FILE
        in_process: WHERE
        names: {"generator.speed": generator_speed, "pitch[1]": blade_pitch, torque: generator_torqueYAW}
        start: {pitch_start: 0.12, torque_start: 43093.55, speed_start: 122.9, "pitch[1]": 0.12 rad,
                torque: 43093.55 N*m, mode: 3, enabled: true}"""
Run = Callable[[int], None]  # so many calls


def used() -> np.ndarray:
    """Wall and processor time so far, of this process and of those that have ended [s]."""
    uses = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return np.array([time.perf_counter(), sum(use.ru_utime + use.ru_stime for use in uses)])


def measured(run: Run, calls: int) -> np.ndarray:
    """Start [s] and time of a further call [s], in rows; wall and processor time in columns."""
    begin = used()
    run(1)
    one = used()
    run(calls)
    return np.array([one - begin, (used() - one - (one - begin)) / (calls - 1)])


def compare(name: str, inside: Run, outside: Run, calls: int) -> None:
    """Print a line for wall and one for processor time."""
    for run in (inside, outside):
        run(2)  # compiles, imports
    found = {inside: [], outside: []}
    for _ in range(RUNS):
        for run, values in found.items():
            values.append(measured(run, calls))
    a, b = (np.array([[statistics.median(v[i, j] for v in values) for j in (0, 1)] for i in (0, 1)])
            for values in found.values())  # fmt: skip
    for j, clock in enumerate(("wall", "processor")):
        print(
            f"{name:>26}, {clock:>9}: start {a[0, j]:.3f} s in process, {b[0, j]:.3f} s outside; "
            f"a call {1e6 * a[1, j]:.1f} and {1e6 * b[1, j]:.1f} us, ratio {b[1, j] / a[1, j]:.2f}",
            flush=True,
        )


def bare(process: FmuProcess | BladedProcess, inputs: int) -> Run:
    """Calls without a model."""
    values = np.full(inputs, 120.0)

    def run(calls: int) -> None:
        session = process.start()
        for k in range(calls):
            session.step(k * PERIOD, values)
        session.close()

    return run


def bare_fmu(path: Path, in_process: bool) -> Run:
    """The FMU by itself."""
    start = START | ({"array_in": 0} if "array_in" in FMU(file=str(path)).ports else {})
    unit = FMU(file=str(path), start=start)
    process = FmuProcess(
        unit._archive, unit._description, unit._content, unit._inputs, unit._outputs, unit._start, PERIOD,
        in_process=in_process,
    )  # fmt: skip
    return bare(process, sum(signal.variable.size for signal in process.inputs))


def bare_library(folder: Path, in_process: bool) -> Run:
    """The library by itself. It keeps a log, for which there is no folder here."""
    library, settings = folder / "discon.so", folder / "DISCON.IN"
    if not library.exists():
        source = TESTS / "servo" / "discon.c"
        subprocess.run([*compiler(), "-O1", "-fPIC", "-shared", source, "-o", library, "-lm"], check=True)
        settings.write_text("0.01 none\n")
    records = [*PITCH, TORQUE, *MEASURED.values()]
    process = BladedProcess(
        library=str(library), procedure="DISCON", input_file=str(settings), output_root=str(folder / "no" / "log"),
        period=PERIOD, blades=3, individual=False, efficiency=1.0, measured=records, demanded=[], fixed={},
        in_process=in_process,
    )  # fmt: skip
    return bare(process, len(records))


def turbine(model: str, path: Path, in_process: bool) -> Run:
    """A floating turbine with the FMU as its controller."""
    text = (Path(models.__path__[0]) / f"{model}.yaml").read_text()
    known = f"turbine: {{use: {TURBINES[model]}}}"
    assert known in text
    control = CONTROLLED.replace("USE", TURBINES[model]).replace("FILE", str(path)).replace("YAW", YAW[model])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "controlled.yaml"
        file.write_text(text.replace(known, control.replace("WHERE", str(in_process).lower())))
        plant = fw.load(file, trust=True, allow=[path.parent]).compile()

    def run(calls: int) -> None:
        plant.simulate(calls * PERIOD, calls * PERIOD, solver="fixed", step=PERIOD, outputs=["turbine.blade_pitch"])

    return run


def main() -> None:
    """See above."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seconds", nargs="?", type=float, default=200.0)
    parser.add_argument("--only", choices=("bare", *TURBINES))
    given = parser.parse_args()
    import controller_fmu

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = {version: controller_fmu.make(folder / f"controller_{version}.fmu", version) for version in (2, 3)}
        if given.only in (None, "bare"):
            for version, path in paths.items():
                compare(f"FMU {version}.0", bare_fmu(path, True), bare_fmu(path, False), CALLS)
            compare("controller library", bare_library(folder, True), bare_library(folder, False), CALLS)
        for model, part in (("oc3_spar_rigid", 1.0), ("oc3_spar", 0.2)):
            if given.only in (None, model):
                inside, outside = (turbine(model, paths[2], where) for where in (True, False))
                compare(f"FMU in {model}", inside, outside, round(part * given.seconds / PERIOD))


if __name__ == "__main__":
    main()
