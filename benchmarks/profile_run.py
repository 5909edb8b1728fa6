"""Where the time of a simulation goes: `python benchmarks/profile_run.py`; `--write` puts it into docs/performance.md.

The run is that of `simulate_oc3` in run.py, 1000 s of it, by the processor's time. IDAS counts its own calls of the
residual and the Jacobian; what each of them takes is measured beside the run, and the rest is that of IDAS itself:
predictions, error tests, factors and solutions.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable

import numpy as np
from pages import fill
from run import OC3_CONDITIONS, PAGE

import fowtlib as fw
from fowtlib.solving.engines import choice
from fowtlib.solving.engines.compiled_idas import CompiledIdas

DURATION = 1000.0
BATCH = 500  # evaluations of a function for one measurement


class TimedIdas(CompiledIdas):
    """IDAS that adds up its time and keeps the last point."""

    spent: Counter = Counter()
    last: TimedIdas

    def advance(self, t, length, points, x, z, q):
        """As CompiledIdas.advance, timed."""
        began = time.process_time()
        result = super().advance(t, length, points, x, z, q)
        self.spent["advance"] += time.process_time() - began
        self.point, TimedIdas.last = (t, x, z, self.at.whole(q)), self
        return result


def evaluation_time(call: Callable[[], object]) -> float:
    """Time of one call [s], with the way from Python and back."""
    times = []
    for _ in range(40):
        began = time.process_time()
        for _ in range(BATCH):
            call()
        times.append(time.process_time() - began)
    return min(times) / BATCH


def compiled(engine: TimedIdas) -> dict[str, float]:
    """Time of the compiled equations and of their derivatives [s]."""
    t, *given = engine.point
    x, z, q = (np.ascontiguousarray(values, dtype=float) for values in given)
    states, algebraics = (np.empty(size) for size in engine._sizes)
    columns, unknown = np.empty((len(x) + len(z)) ** 2), engine._tables[2]
    at = engine._instance, t, x.ctypes.data, z.ctypes.data, q.ctypes.data
    ends = states.ctypes.data, algebraics.ctypes.data
    return {
        "residual": evaluation_time(lambda: engine._equations.fs_values(*at, *ends)),
        "Jacobian": evaluation_time(
            lambda: engine._equations.fs_derivatives(*at, unknown.ctypes.data, columns.ctypes.data)
        ),
    }


def profile() -> str:
    """Two tables: the run, and one evaluation of the equations."""
    plant = fw.load("oc3_spar_rigid").with_parameters(OC3_CONDITIONS).compile()
    choice.CompiledIdas = TimedIdas
    began = time.process_time()
    plant.simulate(DURATION, output_step=0.1, solver="idas", tolerance=1e-6)
    total, spent, engine = time.process_time() - began, TimedIdas.spent["advance"], TimedIdas.last
    counts, times = engine.counts(), compiled(engine)
    numbers = {"residual": counts["residuals"], "Jacobian": counts["jacobians"]}
    parts = {name: numbers[name] * times[name] for name in numbers}
    rows = [
        *((name, f"{numbers[name]}", parts[name]) for name in numbers),
        ("IDAS itself, its linear solver, results", f"{counts['steps']} steps", spent - sum(parts.values())),
        ("start values, making of functions, checks", "once", total - spent),
    ]
    steps = counts["steps"]
    lines = [
        f"{DURATION:g} s in {total:.2f} s: {steps / DURATION:.1f} steps per second of simulated time, "
        f"{numbers['residual'] / steps:.1f} residuals and {numbers['Jacobian'] / steps:.2f} "
        f"Jacobians per step, {100 * counts['error_test_failures'] / steps:.0f} % of the steps repeated.",
        "",
        "| part of the run | calls | time [s] | share |",
        "| --- | --- | --- | --- |",
        *(f"| {what} | {calls} | {seconds:.2f} | {100 * seconds / total:.0f} % |" for what, calls, seconds in rows),
        "",
        "| evaluation | time [microseconds] |",
        "| --- | --- |",
        *(f"| {name} | {1e6 * seconds:.1f} |" for name, seconds in times.items()),
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    text = profile()
    print(text)
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(fill(PAGE.read_text(), "profile", text))
