"""Where the time of a simulation goes: `python benchmarks/profile_run.py`; `--write` puts it into docs/performance.md.

The run is that of `simulate_oc3` in run.py, 1000 s of it. IDAS counts its own calls of the residual and the Jacobian
and the time in them; the rest of a call of IDAS is its own: predictions, error tests, sparse factorisation.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import casadi as ca
import numpy as np
from pages import fill
from run import OC3_CONDITIONS, PAGE

import fowtlib as fw
from fowtlib.solving.engines import choice
from fowtlib.solving.engines.idas import Idas

DURATION = 1000.0
BATCH = 500  # evaluations of a function at once, to time one


class TimedIdas(Idas):
    """IDAS that adds up its counters and keeps the last point."""

    spent: Counter = Counter()
    last: TimedIdas

    def advance(self, t, length, points, x, z, q):
        """As Idas.advance, timed."""
        began = time.perf_counter()
        created = self.spent["create"]
        result = super().advance(t, length, points, x, z, q)
        self.spent["advance"] += time.perf_counter() - began - (self.spent["create"] - created)
        stats = self.integrator(points).stats()
        for name in ("nsteps", "n_call_daeF", "n_call_jacF", "t_wall_daeF", "t_wall_jacF", "netfails"):
            self.spent[name] += stats[name]
        self.point, TimedIdas.last = (t, x, z, self.at.whole(q)), self
        return result

    def _create(self, points):
        began = time.perf_counter()
        integrator = super()._create(points)
        self.spent["create"] += time.perf_counter() - began
        return integrator


def evaluation_time(function: ca.Function, *arguments) -> float:
    """Time of one evaluation [s], without the way from Python."""
    many = function.map(BATCH, "serial")
    columns = [ca.repmat(ca.DM(value), 1, BATCH) for value in arguments]
    times = []
    for _ in range(40):
        began = time.perf_counter()
        many(*columns)
        times.append(time.perf_counter() - began)
    return min(times) / BATCH


def profile() -> str:
    """Two tables: the run, and one evaluation of the equations."""
    plant = fw.load("oc3_spar_rigid").with_parameters(OC3_CONDITIONS).compile()
    choice.Idas = TimedIdas
    began = time.perf_counter()
    plant.simulate(DURATION, output_step=0.1, solver="idas", tolerance=1e-6)
    total = time.perf_counter() - began
    spent = TimedIdas.spent
    idas = spent["advance"] - spent["t_wall_daeF"] - spent["t_wall_jacF"]
    rows = [
        ("residual", f"{spent['n_call_daeF']}", spent["t_wall_daeF"]),
        ("Jacobian", f"{spent['n_call_jacF']}", spent["t_wall_jacF"]),
        ("IDAS itself and the sparse linear solver", f"{spent['nsteps']} steps", idas),
        ("start values, making of functions, checks, results", "once", total - spent["advance"]),
    ]
    steps = spent["nsteps"] / DURATION
    lines = [
        f"{DURATION:g} s in {total:.2f} s: {steps:.1f} steps per second of simulated time, "
        f"{spent['n_call_daeF'] / spent['nsteps']:.1f} residuals and {spent['n_call_jacF'] / spent['nsteps']:.2f} "
        f"Jacobians per step, {100 * spent['netfails'] / spent['nsteps']:.0f} % of the steps repeated.",
        "",
        "| part of the run | calls | time [s] | share |",
        "| --- | --- | --- | --- |",
        *(f"| {what} | {calls} | {seconds:.2f} | {100 * seconds / total:.0f} % |" for what, calls, seconds in rows),
    ]
    return "\n".join([*lines, "", *one_evaluation(TimedIdas.last)])


def one_evaluation(engine: TimedIdas) -> list[str]:
    """What one residual and one Jacobian are made of."""
    functions, point = engine.at.functions, engine.point
    residual = evaluation_time(functions.residual, *point)
    lines = ["| evaluation | time [microseconds] |", "| --- | --- |", f"| residual | {1e6 * residual:.1f} |"]
    rest = residual
    for external in functions.dae.externals:
        function = external.function
        inputs = [np.zeros(function.size_in(i)) for i in range(function.n_in())]
        inputs[0] = np.resize([7.0, 0.05] if "coefficient" in function.name() else [123.4], function.size_in(0))
        spent = evaluation_time(function, *inputs)
        rest -= spent
        lines.append(f"| of which {function.name().replace('_', ' ')} | {1e6 * spent:.1f} |")
    lines.append(f"| of which all other equations | {1e6 * rest:.1f} |")
    lines.append(f"| Jacobian | {1e6 * evaluation_time(functions.jacobian, *point):.1f} |")
    return lines


if __name__ == "__main__":
    text = profile()
    print(text)
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(fill(PAGE.read_text(), "profile", text))
