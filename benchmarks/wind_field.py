"""Time and memory of wind fields: generating them, each in a process of its own, and looking up 51 points.

Times are those of the processor, which other work on the machine disturbs less.

Run: python benchmarks/wind_field.py [folder for the files]
"""

from __future__ import annotations

import ctypes
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from fowtlib.components.environment import generate_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_wind import field_function, field_handle
from fowtlib.language.native import compile_library

TWO_ROTORS = {"width": 320, "height": 160, "columns": 41, "rows": 21}
CASES = {
    "one rotor, Kaimal": {"width": 160, "height": 160, "columns": 25, "rows": 25},
    "one rotor, von Karman, v and w coherent": {
        **{"width": 160, "height": 160, "columns": 25, "rows": 25},
        **{"spectrum": "von_karman", "lateral_coherence": "iec"},
    },
    "two rotors, Kaimal": TWO_ROTORS,
    "two rotors, Kaimal, 4000 s": {**TWO_ROTORS, "duration": 4000},
    "one rotor, coarse, 4000 s": {"width": 160, "height": 160, "columns": 15, "rows": 15, "duration": 4000},
}
POINTS = 51  # three blades of 17 nodes
ENGINE = """
#include <time.h>
typedef int (*Call)(const double **, double **, long long *, double *, int);
EXPORT double spent(Call call, double *column, double *result, int calls, double step) {
    const double *arg[2] = {column, 0};
    double *res[1] = {result};
    const clock_t begin = clock();
    for (int i = 0; i < calls; i++) {
        column[1] += step;
        if (call(arg, res, 0, 0, 0)) return -1;
    }
    return (double)(clock() - begin) / CLOCKS_PER_SEC / calls;
}
"""


def generate(path: Path, name: str) -> None:
    begin = time.process_time()
    grid = generate_field(path, mean_speed=11.4, **CASES[name]).grid
    elapsed = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    size = f"{grid.columns} x {grid.rows} points, {grid.duration:.0f} s at {1 / grid.dt:.0f} Hz"
    print(f"{name}: {size}: {elapsed:.1f} s, peak {peak:.0f} MB, file {path.stat().st_size / 2**20:.0f} MB", flush=True)


def resident() -> float:
    """Memory of this process now, MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def look_up(path: Path) -> None:
    """Calls by pointer from C, through the whole field in steps of 25 ms, as a time-stepping engine makes them."""
    lookup = FieldLookup(generate_field(path, mean_speed=11.4, **CASES["one rotor, coarse, 4000 s"]))
    function, handle = field_function(lookup, POINTS), field_handle(lookup)
    engine = ctypes.CDLL(str(compile_library(ENGINE, "engine")))
    engine.spent.restype = ctypes.c_double
    library = ctypes.CDLL(str(function.library))
    azimuth = np.repeat(np.array([0, 2, 4]) * np.pi / 3, POINTS // 3)
    radius = np.tile(np.linspace(3, 62, POINTS // 3), 3)
    positions = np.stack([0.1 * radius, radius * np.sin(azimuth), 90 + radius * np.cos(azimuth)], axis=-1)
    before = resident()
    for name, prefix in (("value", ""), ("Jacobian", "jac_")):
        column = np.concatenate([[handle, 0.0, *np.zeros(6), 90.0, 0.0], positions.ravel()])
        result = np.empty(12 * 3 * POINTS)
        numbers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (column, result)]
        call = getattr(library, prefix + function.name)
        times = [engine.spent(call, *numbers, 16000, ctypes.c_double(0.025)) for _ in range(10)]
        print(f"{name} at {POINTS} points in C: median {1e6 * np.median(times):.2f}, least {1e6 * min(times):.2f} us")
    grown = resident() - before
    print(f"memory taken by ten passes through {path.stat().st_size / 2**20:.0f} MB: {grown:.1f} MB")
    begin = time.process_time()
    for i in range(2000):
        lookup.evaluate(positions, 0.025 * i)
    print(f"value and Jacobian in NumPy: {1e6 * (time.process_time() - begin) / 2000:.0f} us")


def main(folder: Path) -> None:
    for name in CASES:
        subprocess.run([sys.executable, __file__, str(folder), name], check=True)
    look_up(folder / "field.bts")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        generate(Path(sys.argv[1]) / "field.bts", sys.argv[2])
    else:
        with tempfile.TemporaryDirectory() as scratch:
            main(Path(sys.argv[1] if len(sys.argv) > 1 else scratch))
