"""States whose implicit steps an external function solves: the same motion, without unknowns of their own."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Array, ExternalFunction, Scalar, der, eq, param, stage_step, var
from fowtlib.language import math as m
from fowtlib.language.errors import StructureError
from fowtlib.language.native import compiler
from fowtlib.solving.engines.reduction import reduction

TIMES = np.array([0.05, 0.4])


def filters(u):
    """Force of two lags behind a speed, the second of them after a bend: x' = (target - x) / T."""
    x, speed, step = u[:2], u[2], u[3]
    first = (x[0] + step / TIMES[0] * speed) / (1 + step / TIMES[0])
    bent = np.tanh(first)
    second = (x[1] + step / TIMES[1] * bent) / (1 + step / TIMES[1])
    return np.array([-3 * first - 8 * second, (speed - first) / TIMES[0], (bent - second) / TIMES[1]])


function = ExternalFunction("lags", {"states": 2, "speed": 1, "step": 1}, {"force": 1, "rates": 2}, python=filters)


class Lagging(fw.Component):
    """A mass on a spring with a force that lags behind its speed; driven."""

    solved: bool = param(default=True)
    mass: Scalar = param(default=2.0)
    read: bool = param(default=False)
    twice: bool = param(default=False)
    x: Scalar = var(state="prefer", start=1.0)
    v: Scalar = var(state="prefer")
    lags: Array = var(shape=(2,), state="prefer")
    seen: Scalar = var()

    def equations(self):
        step = stage_step(self.lags) if self.solved else 0.0
        out = function(states=self.lags, speed=self.v, step=step)
        other = function(states=self.lags, speed=self.v, step=step)["force"] if self.twice else 0.0
        more = self.lags[0] if self.read else 0.0
        return [
            eq(der(self.x), self.v),
            eq(self.mass * der(self.v), out["force"] + other + more - 40 * self.x),
            eq(der(self.lags), out["rates"]),
            eq(self.seen, self.lags[1]),
        ]  # fmt: skip


def motion(solver, solved=True, **more):
    plant = fw.load(Lagging(solved=solved)).compile()
    return plant, plant.simulate(4.0, 0.1, solver=solver, **more)


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_the_motion_is_that_of_states_like_others():
    (inside, one), (free, other) = (motion("fixed", solved, step=0.02, tolerance=1e-11) for solved in (True, False))
    assert len(reduction(inside.dae).free) == len(reduction(free.dae).free) - 2
    assert reduction(inside.dae).inside and not reduction(inside.dae, stages=False).inside
    for name in ("x", "v", "seen", "lags[0]"):
        assert one.array(name) == pytest.approx(other.array(name), abs=2e-8)  # what Newton leaves
    _, fine = motion("fixed", step=0.002, tolerance=1e-9)
    _, exact = motion("idas", tolerance=1e-9)
    errors = [np.abs(run.array("seen") - exact.array("seen")).max() for run in (one, fine)]
    assert errors[1] < 2e-2 * errors[0]  # of second order, as the scheme is
    assert errors[0] < 0.01 * np.abs(exact.array("seen")).max()


def test_only_the_function_reads_the_states():
    for options, message in (({"read": True}, "are read by equations"), ({"twice": True}, "by 2 external functions")):
        with pytest.raises(StructureError, match=message):
            fw.load(Lagging(**options)).compile()


def test_they_must_be_states():
    class Wrong(fw.Component):
        x: Scalar = var(state="prefer")

        def equations(self):
            out = function(states=m.vertcat(self.x, 0), speed=1.0, step=stage_step(2 * self.x))
            return [eq(der(self.x), out["force"])]

    with pytest.raises(StructureError, match="is no state of the model"):
        fw.load(Wrong()).compile()
