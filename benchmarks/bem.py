"""Time of one evaluation of the blade-element rotor (NREL 5 MW, 3 x 17 nodes) and of its Jacobian, on one core.

The wind differs by 1 m/s from node to node. With one node after the other, and with as many at once as there are lanes.

python benchmarks/bem.py
"""

from __future__ import annotations

import ctypes
import time
from pathlib import Path

import numpy as np

import fowtlib.models
from fowtlib.components.aero import AIRFOIL_MODELS, BladeElementRotor, RigidRotor, bem, bem_numpy, read_blade

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
    variants = {"with skewed wake": {}, "without": {"skew": 0.0}, "dynamic inflow": {"dynamic_inflow": True},
                "unsteady airfoils": {"airfoil_model": AIRFOIL_MODELS["beddoes_leishman"]}}  # fmt: skip
    bem.only_lanes = lambda nodes: ""  # all widths, as in an FMU
    for name, options in variants.items():
        rotor = BladeElementRotor(blade, **options)
        function = rotor.external.function
        jacobian = function.jacobian()
        print(name)
        lanes = getattr(ctypes.CDLL(str(rotor.external.library)), f"{rotor.external.name}_lanes", lambda most: 1)
        n, uneven = rotor.nodes, np.random.default_rng(1).normal(size=3 * rotor.nodes)
        for wind, pitch in ((8.0, 0.0), (11.4, 0.0), (18.0, 0.26)):
            u = RigidRotor(rotor, np.radians(2.5), np.radians(5.0)).inputs([wind, 1.0, 0], 1.2, pitch, induced=2.0)
            u[15 * n : 18 * n] += uneven
            loads = function(u).full().ravel()
            start = time.process_time()
            bem_numpy.loads(rotor, u)
            twin = time.process_time() - start
            print(f"  {wind:g} m/s, {jacobian.nnz_out(0)} entries; NumPy twin {twin * 1e3:.0f} ms")
            for width in (1, 2, 4, 8):
                if lanes(width) == width:
                    times = microseconds(function, u), microseconds(jacobian, u, loads)
                    print(f"    lanes {width}: loads {times[0]:.1f} us, Jacobian {times[1]:.1f} us")
            lanes(8)


if __name__ == "__main__":
    main()
