"""What a simulation will take: reckoned for its stretches, and measured where there is no C compiler.

Stretches end by what is reckoned, never by the clock, on which results must not depend. Without a compiler the time is
measured at the start, so that nobody waits in the dark.
"""

from __future__ import annotations

import time

import numpy as np

from fowtlib.language.externals import runs_as_python
from fowtlib.language.native import compiler, no_compiler
from fowtlib.solving.engines import Engine
from fowtlib.solving.engines.base import STEP
from fowtlib.solving.functions import AtParameters

# Evaluations of the equations and of their Jacobian for each second with IDAS, and for each step with equal steps:
# those of oc3_spar_rigid, and those of oc3_spar with all its blades in turbulent wind and waves.
BY_SECOND = ((38.0, 1.6), (690.0, 13.0))
BY_STEP = ((1.6, 0.3), (6.5, 0.4))
BY_AZIMUTH = (377.0, 96.0)  # for the mean of oc3_spar, to start from
# s that a simulated one takes at most, by operations and unknowns: oc3_spar_rigid to two_rotor_spar take a tenth to all
# of it with IDAS, and the fixed-step engine a quarter of that. Interpreted, it is a hundred times as much.
PRICE, PRICE_FIXED, TIMES_INTERPRETED = 2e-8, 5e-9, 100.0
BUDGET = 4.0  # s that a stretch is meant to take at most
MANY = 5_000  # operations below which CasADi's virtual machine is fast enough to say nothing


def seconds_per_second(engine: Engine, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> tuple[float, float]:
    """From what to what a simulated second takes on this computer [s]; nothing where compiled code runs, or little."""
    at, step = engine.at, engine.attributes.get("step")
    if not is_slow(engine):
        return 0.0, 0.0
    spent = _spent(at, t, x, z, q)
    rates = BY_SECOND if step is None else [(values / step, slopes / step) for values, slopes in BY_STEP]
    low, high = (values * spent[0] + slopes * spent[1] for values, slopes in rates)
    return low, high


def longest_stretch(engine: Engine) -> float:
    """The longest stretch [s] that is reckoned to take less than BUDGET; the same on every computer."""
    at, step = engine.at, engine.attributes.get("step")
    unknowns = at.dae.x.shape[0] + at.dae.z.shape[0]
    price = PRICE if step is None else PRICE_FIXED * max(1.0, STEP / float(step))
    price *= TIMES_INTERPRETED if is_slow(engine) else 1.0
    return BUDGET / (price * max(1, at.functions.operations * unknowns))


def is_slow(engine: Engine) -> bool:
    """Whether Python code or CasADi's virtual machine does what compiled code would do."""
    return interpreted(engine.at) or ("step" in engine.attributes and not compiler())


def interpreted(at: AtParameters) -> bool:
    """Whether equations that take long are computed by Python code or by CasADi's virtual machine."""
    stand_ins = any(runs_as_python(external.function) for external in at.dae.externals)
    return not compiler() and (stand_ins or at.functions.operations > MANY)


def mean_announcement(at: AtParameters, point: tuple[float, np.ndarray, np.ndarray, np.ndarray], azimuths: int) -> str:
    """The line for the user before the mean state of turning rotors is sought; empty where that is soon done."""
    if not interpreted(at):
        return ""
    spent = _spent(at, *point)
    duration = azimuths * sum(number * each for number, each in zip(BY_AZIMUTH, spent, strict=True))
    return f"the mean state of the turning rotors is expected to take {_spoken(duration)} here: {no_compiler()}"


def _spent(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> list[float]:
    """Seconds for an evaluation of the equations, and of their Jacobian."""
    spent = []
    for function in (at.residual, at.jacobian):
        function(t, x, z, q)  # made now
        moved = x + 1e-9 * (1 + np.abs(x))  # what is known of a point is not computed again
        began = time.perf_counter()
        function(t, moved, z, q)
        spent.append(time.perf_counter() - began)
    return spent


def announcement(engine: Engine, pace: tuple[float, float], duration: float) -> str:
    """The line for the user: what is slow, for how long, and what helps."""
    names = [external.path or "the model" for external in engine.at.dae.externals if runs_as_python(external.function)]
    names += ["the solver 'fixed'"] * ("step" in engine.attributes)
    what = f"{' and '.join(dict.fromkeys(names))} as Python code" if names else "the equations interpreted"
    low, high = (_spoken(rate * duration) for rate in pace)
    return f"this run, with {what}, is expected to take {low} to {high} on this computer: {no_compiler()}"


def _spoken(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 100 * size else f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 1.0):.0f} s"
