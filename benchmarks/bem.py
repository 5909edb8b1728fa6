"""Time of one evaluation of the blade-element rotor (NREL 5 MW, 3 x 17 nodes) and of its Jacobian, on one core.

python benchmarks/bem.py
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import fowtlib.models
from fowtlib.components.aero import BladeElementRotor, RigidRotor, bem_numpy, read_blade

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"


def microseconds(function, *inputs, calls=200, repeats=8):
    """Least processor time of a call without copies, over some repeats."""
    buffer, call = function.buffer()
    columns, out = [np.ascontiguousarray(x) for x in inputs], np.zeros(function.nnz_out(0))
    for i, column in enumerate(columns):
        buffer.set_arg(i, memoryview(column))
    buffer.set_res(0, memoryview(out))
    times = []
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(calls):
            call()
        times.append((time.process_time() - start) / calls * 1e6)
    return min(times)


def main():
    blade = read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), 1.5, 63.0)
    variants = {"with skewed wake": {}, "without": {"skew": 0.0}, "dynamic inflow": {"dynamic_inflow": True}}
    for name, options in variants.items():
        rotor = BladeElementRotor(blade, **options)
        function = rotor.external.function
        jacobian = function.jacobian()
        print(name)
        for wind, pitch in ((8.0, 0.0), (18.0, 0.26)):
            u = RigidRotor(rotor, np.radians(2.5), np.radians(5.0)).inputs([wind, 1.0, 0], 1.2, pitch, induced=2.0)
            loads = function(u).full().ravel()
            start = time.process_time()
            bem_numpy.loads(rotor, u)
            twin = time.process_time() - start
            times = f"loads {microseconds(function, u):.1f} us, Jacobian {microseconds(jacobian, u, loads):.1f} us"
            print(f"  {wind:g} m/s: {times} ({jacobian.nnz_out(0)} entries), NumPy twin {twin * 1e3:.0f} ms")


if __name__ == "__main__":
    main()
