"""IDAS called without CasADi in between: against CasADi's integrator with the same equations, the same IDAS."""

from __future__ import annotations

import sys
import threading

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Array, Scalar, assert_, der, eq, param, var
from fowtlib.language import math as m
from fowtlib.language.errors import SimulationError
from fowtlib.language.native import compiler
from fowtlib.solving.engines import choice
from fowtlib.solving.engines import compiled as compiled_functions
from fowtlib.solving.engines.compiled import CompiledFunctions
from fowtlib.solving.engines.compiled_idas import CompiledIdas
from fowtlib.solving.engines.idas import Idas
from fowtlib.solving.engines.sundials import sundials
from fowtlib.solving.failure import StepFailure

pytestmark = pytest.mark.skipif(not compiler() or not sundials(), reason="needs a C compiler and SUNDIALS 2")


class Ladder(fw.Component):
    """Masses on a chain of stiffening springs with implicit drag, a jerk that two states follow, and a slow filter.

    Rates are states, algebraic unknowns, and expressions, so that rows are substituted over one, two and three steps.
    """

    count: int = param(default=6, structural=True, doc="masses")
    stiffness: Scalar = param(default=40.0, unit="1/s^2", doc="stiffness over mass")
    q: Array = var(unit="1", shape=("count",), start=0.1, state="prefer", doc="positions")
    v: Array = var(unit="1/s", shape=("count",), start=0.5, state="prefer", doc="speeds")
    drag: Array = var(unit="1/s^2", shape=("count",), start=0.3, doc="solve drag + drag^3 = v")
    a: Scalar = var(unit="1", start=0.0, state="prefer", doc="follows b")
    b: Scalar = var(unit="1/s", start=0.2, state="prefer", doc="follows c")
    c: Scalar = var(unit="1/s^2", start=0.0, state="prefer", doc="follows jerk")
    jerk: Scalar = var(unit="1/s^3", start=0.1, doc="solves jerk + jerk^3 = -a - 3 b - 3 c")
    filtered: Scalar = var(unit="1", doc="filtered position of the last mass")

    def equations(self):
        below = [0.2 * m.sin(3 * self.time), *(self.q[i] for i in range(self.count - 1))]
        stretch = [self.q[i] - below[i] for i in range(self.count)]
        spring = [self.stiffness * (s + s**3) for s in stretch]
        ahead = [*spring[1:], 0.0]
        return [
            *(eq(der(self.q[i]), self.v[i]) for i in range(self.count)),
            *(eq(der(self.v[i]), ahead[i] - spring[i] - self.drag[i]) for i in range(self.count)),
            *(eq(self.drag[i] + self.drag[i] ** 3, self.v[i]) for i in range(self.count)),
            eq(der(self.a), self.b),
            eq(der(self.b), self.c),
            eq(der(self.c), self.jerk),
            eq(self.jerk + self.jerk**3, -self.a - 3 * self.b - 3 * self.c),
            eq(der(self.filtered), 0.1 * (self.q[self.count - 1] - self.filtered)),
        ]


@pytest.fixture(scope="module")
def plant():
    return fw.load(Ladder()).compile()


def engines(plant, tolerance, parameters=None):
    """The same IDAS by CasADi, and alone."""
    at, code = plant.at(parameters), plant.fixed_step_code
    return Idas(at, tolerance, compiled=CompiledFunctions(code)), CompiledIdas(at, tolerance, code, sundials())


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="layouts of other systems' memory have not been seen")
def test_the_linear_solver_of_ida_is_found():
    """With the wheel of CasADi that is pinned; without it all else here would be skipped."""
    found = sundials()
    assert found is not None
    assert len(found.calls) == len(set(found.calls))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_the_same_steps_as_casadis(plant, tolerance):
    """Steps, residuals and Jacobians in number, values as far as rounding grows: a thousandth of the tolerance.

    Numbers of iterations depend on each solution of a linear system, on the age of its matrix, and on IDA's own factor
    for a changed step.
    """
    state, (casadi, alone) = plant.initial_state(), engines(plant, tolerance)
    code = plant.fixed_step_code
    assert len(code.reduction.order) >= 3 + 6 and len(code.reduction.free) >= 1
    runs = [engine.advance(2.0, 10.0, 40, state.x, state.z, np.zeros(0)) for engine in (casadi, alone)]
    for own, other in zip(*runs, strict=True):
        np.testing.assert_allclose(own, other, atol=1e-3 * tolerance)
    stats, counts = casadi.integrator(40).stats(), alone.counts()
    assert counts["steps"] == stats["nsteps"] > 50
    assert counts["residuals"] == stats["n_call_daeF"]
    assert counts["jacobians"] == stats["n_call_jacF"] < counts["residuals"] / 4


def test_parameters_and_starts_of_each_call(plant):
    """Each call is a new start, with the values that it is given."""
    state = plant.initial_state()
    alone, other = engines(plant, 1e-6)[1], engines(plant, 1e-6, {"stiffness": 90.0})
    first = alone.advance(0.0, 2.0, 4, state.x, state.z, np.zeros(0))
    alone.advance(5.0, 1.0, 3, first[0][-1], first[1][-1], np.zeros(0))
    for own, again in zip(first, alone.advance(0.0, 2.0, 4, state.x, state.z, np.zeros(0)), strict=True):
        np.testing.assert_array_equal(own, again)
    stiff = [engine.advance(0.0, 2.0, 4, state.x, state.z, np.zeros(0))[0] for engine in other]
    np.testing.assert_allclose(*stiff, atol=1e-6)  # the tolerance of both
    assert np.abs(stiff[0] - first[0]).max() > 0.01


def test_two_runs_at_once(plant):
    """Engines share no memory, and know in each thread whose linear systems they solve."""
    state, expected, found = plant.initial_state(), {}, {}
    chosen = {k: engines(plant, 1e-6, {"stiffness": k})[1] for k in (20.0, 60.0)}

    def run(k, into):
        for _ in range(5):
            into[k] = chosen[k].advance(0.0, 20.0, 20, state.x, state.z, np.zeros(0))[0]

    for k in chosen:
        run(k, expected)
    threads = [threading.Thread(target=run, args=(k, found)) for k in chosen]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in chosen:
        np.testing.assert_array_equal(found[k], expected[k])


def test_a_run_that_is_asked_to_stop_gives_what_it_has(plant):
    state, alone = plant.initial_state(), engines(plant, 1e-6)[1]
    alone.stop(True)
    x, z = alone.advance(0.0, 10.0, 10, state.x, state.z, np.zeros(0))
    assert len(x) == len(z) == len(alone.seen) == 0
    alone.stop(False)
    assert len(alone.advance(0.0, 10.0, 10, state.x, state.z, np.zeros(0))[0]) == len(alone.seen) == 10


class Blow(fw.Component):
    """x' = growth x^2 - root, root^2 = limit - x: ends in infinite time, or where there is no root."""

    growth: Scalar = param(default=1.0, unit="1/s", doc="growth")
    limit: Scalar = param(default=1e12, unit="1", doc="where the root ends")
    x: Scalar = var(unit="1", start=1.0, state="prefer", doc="grows")
    root: Scalar = var(unit="1", start=1.0, doc="a number where x is below the limit")

    def equations(self):
        return [
            eq(der(self.x), self.growth * self.x**2),
            eq(m.log(self.root + 2) + self.root**3, m.sqrt(self.limit - self.x)),
        ]


@pytest.mark.parametrize("parameters", [{}, {"limit": 3.0}, {"growth": -1.0, "limit": 0.5}])
def test_the_same_reason_of_a_failure(parameters):
    """A pole in finite time, a root that ends on the way, and one that is not there from the start."""
    plant = fw.load(Blow()).compile()
    state = fw.load(Blow()).compile().initial_state()
    reasons = []
    for engine in engines(plant, 1e-6, parameters):
        with pytest.raises(StepFailure) as failure:
            engine.advance(0.0, 5.0, 5, state.x, state.z, np.zeros(0))
        reasons.append(str(failure.value))
    assert reasons[0] == reasons[1]


class Checked(fw.Component):
    """A decay with a check that ends the run."""

    x: Scalar = var(unit="1", start=1.0, state="prefer", doc="falls")
    square: Scalar = var(unit="1", doc="eliminated")

    def equations(self):
        return [
            eq(der(self.x), -self.x),
            eq(self.square, self.x**2),
            assert_(self.x > 0.5, f"{self.x} is low"),
        ]


def test_results_and_checks_come_with_the_points(monkeypatch):
    """What simulate takes: the engine alone where the equations are compiled, CasADi's where it cannot be."""
    monkeypatch.setattr(compiled_functions, "OPERATIONS", (-1, 1000))
    made, create = [], choice.CompiledIdas
    monkeypatch.setattr(choice, "CompiledIdas", lambda *given: made.append(create(*given)) or made[-1])
    runs = []
    for found in (sundials(), None):
        monkeypatch.setattr(choice, "sundials", lambda found=found: found)
        with pytest.raises(SimulationError, match="is low") as stopped:
            fw.load(Checked()).compile().simulate(2.0, 0.05, solver="idas", tolerance=1e-8)
        runs.append(stopped.value.result)
    assert len(made) == 1
    assert made[0].seen.shape[1] == made[0].code.width
    assert runs[0].time[-1] == runs[1].time[-1] == pytest.approx(0.7)
    for name in ("x", "square"):
        np.testing.assert_allclose(runs[0].array(name), runs[1].array(name), rtol=1e-9)
    np.testing.assert_allclose(runs[0].array("square"), np.exp(-2 * runs[0].time), rtol=1e-6)
