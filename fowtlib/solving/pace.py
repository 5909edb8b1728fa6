"""What a simulation will take where there is no C compiler: measured at the start, so that nobody waits in the dark."""

from __future__ import annotations

import time

import numpy as np

from fowtlib.language.externals import runs_as_python
from fowtlib.language.native import NO_COMPILER, compiler
from fowtlib.solving.engines import Engine

# Evaluations of the equations and of their Jacobian for each second with IDAS, and for each step with equal steps:
# those of oc3_spar_rigid, and those of oc3_spar with all its blades in turbulent wind and waves.
BY_SECOND = ((38.0, 1.6), (690.0, 13.0))
BY_STEP = ((1.6, 0.3), (6.5, 0.4))
MANY = 5_000  # operations below which CasADi's virtual machine is fast enough to say nothing


def seconds_per_second(engine: Engine, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> tuple[float, float]:
    """From what to what a simulated second takes on this computer [s]; nothing where compiled code runs, or little."""
    at, step = engine.at, engine.attributes.get("step")
    stand_ins = any(runs_as_python(external.function) for external in at.dae.externals)
    if compiler() or not (stand_ins or step is not None or at.functions.operations > MANY):
        return 0.0, 0.0
    spent = []
    for function in (at.residual, at.jacobian):
        function(t, x, z, q)  # made now
        moved = x + 1e-9 * (1 + np.abs(x))  # what is known of a point is not computed again
        began = time.perf_counter()
        function(t, moved, z, q)
        spent.append(time.perf_counter() - began)
    rates = BY_SECOND if step is None else [(values / step, slopes / step) for values, slopes in BY_STEP]
    low, high = (values * spent[0] + slopes * spent[1] for values, slopes in rates)
    return low, high


def announcement(engine: Engine, pace: tuple[float, float], duration: float) -> str:
    """The line for the user: what is slow, for how long, and what helps."""
    names = [external.path or "the model" for external in engine.at.dae.externals if runs_as_python(external.function)]
    names += ["the solver 'fixed'"] * ("step" in engine.attributes)
    what = f"{' and '.join(dict.fromkeys(names))} as Python code" if names else "the equations interpreted"
    low, high = (_spoken(rate * duration) for rate in pace)
    return f"this run, with {what}, is expected to take {low} to {high} on this computer: {NO_COMPILER}"


def _spoken(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 100 * size else f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 1.0):.0f} s"
