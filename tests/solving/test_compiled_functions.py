"""IDAS with the compiled equations of the fixed-step engine: against CasADi's, for values, Jacobian and whole runs."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Array, ExternalFunction, Scalar, der, eq, param, table1d, var
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError
from fowtlib.language.native import compiler
from fowtlib.solving.engines import compiled as compiled_functions
from fowtlib.solving.engines.compiled import CompiledFunctions, jacobian_patterns, worth_compiling
from fowtlib.solving.engines.fixed_step_code import FixedStepCode
from fowtlib.solving.engines.idas import Idas

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")

CUBE = """
typedef long long int casadi_int;
static const casadi_int column[] = {2, 1, 1}, diagonal[] = {2, 2, 0, 1, 2, 0, 1};
EXPORT int cube(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    for (int i = 0; i < 2 && res[0]; i++) res[0][i] = arg[0][i] * arg[0][i] * arg[0][i];
    return arg[0][0] > 100;
}
EXPORT int jac_cube(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    for (int i = 0; i < 2 && res[0]; i++) res[0][i] = 3 * arg[0][i] * arg[0][i];
    return 0;
}
EXPORT casadi_int cube_n_in(void) { return 1; }
EXPORT casadi_int cube_n_out(void) { return 1; }
EXPORT const casadi_int *cube_sparsity_in(casadi_int i) { return column; }
EXPORT const casadi_int *cube_sparsity_out(casadi_int i) { return column; }
EXPORT casadi_int jac_cube_n_in(void) { return 2; }
EXPORT casadi_int jac_cube_n_out(void) { return 1; }
EXPORT const casadi_int *jac_cube_sparsity_in(casadi_int i) { return column; }
EXPORT const casadi_int *jac_cube_sparsity_out(casadi_int i) { return diagonal; }
"""


class Chain(fw.Component):
    """Two masses with springs of a table and of an external, one after the other, a filter, and an implicit damper."""

    stiffness: Scalar = param(default=2.0, unit="1/s^2", doc="stiffness over mass")
    q: Array = var(unit="1", shape=(2,), start=[0.3, -0.2], state="prefer", doc="positions")
    v: Array = var(unit="1/s", shape=(2,), start=[1.0, 0.5], state="prefer", doc="speeds")
    filtered: Scalar = var(unit="1", start=0.1, doc="filtered position")
    drag: Scalar = var(unit="1/s^2", start=0.1, doc="solves drag + drag^3 = v[1]")

    def equations(self):
        soft = table1d(self.q[0], np.linspace(-3, 3, 13), np.sin(np.linspace(-3, 3, 13)))
        cube = ExternalFunction("cube", {"q": 2}, {"force": 2}, source=CUBE, python=lambda q: q**3)
        hard = cube(q=m.vertcat(self.q[1] + soft, self.q[1]))["force"]
        return [
            eq(der(self.q[0]), self.v[0]),
            eq(der(self.q[1]), self.v[1]),
            eq(der(self.v[0]), -self.stiffness * soft - hard[0]),
            eq(der(self.v[1]), -self.stiffness * self.q[1] - hard[1] - self.drag + m.sin(self.time)),
            eq(self.drag + self.drag**3, self.v[1]),
            eq(der(self.filtered), self.q[1] - self.filtered),
        ]


@pytest.fixture(scope="module")
def plant():
    return fw.load(Chain()).compile()


def functions(plant):
    return CompiledFunctions(plant.fixed_step_code)


def given(plant, compiled, **parameters):
    """What the compiled functions take as q: the parameters and the number of the instance."""
    return np.concatenate([plant.at(parameters).parameters, compiled.handle])


def some_points(plant, count=20):
    random = np.random.default_rng(1)
    for _ in range(count):
        yield random.uniform(0, 9), *(random.normal(size=size) for size in (len(plant.dae.states), 1))


@pytest.mark.parametrize("stiffness", [2.0, 7.0])
def test_values_and_jacobian(plant, stiffness):
    """The Jacobian is exact up to the error of differences."""
    at, compiled = plant.at({"stiffness": stiffness}), functions(plant)
    assert len(plant.dae.algebraics) == 1
    for t, x, z in some_points(plant):
        q = given(plant, compiled, stiffness=stiffness)
        for own, other in zip(compiled.residual(t, x, z, q), at.residual(t, x, z, []), strict=True):
            np.testing.assert_allclose(own.full(), other.full(), rtol=1e-12, atol=1e-12)
        for own, other in zip(compiled.jacobian(t, x, z, q), at.jacobian(t, x, z, []), strict=True):
            np.testing.assert_allclose(own.full(), other.full(), rtol=1e-4, atol=1e-4)
            assert own.sparsity() == other.sparsity()


def test_parameters_are_arguments_and_an_instance_gives_its_number_back(plant):
    one, two = functions(plant), functions(plant)
    t, x, z = next(some_points(plant))
    points = [(f, given(plant, f, stiffness=k)) for f, k in ((one, 2.0), (one, 3.0), (two, 3.0), (one, 2.0))]
    ends = [np.array(f.residual(t, x, z, q)[0]).ravel() for f, q in points]
    assert np.abs(ends[0] - ends[1]).max() > 0.01
    np.testing.assert_array_equal(ends[0], ends[3])
    np.testing.assert_array_equal(ends[1], ends[2])
    slopes = [np.array(f.jacobian(t, x, z, q)[0].full()) for f, q in points]
    assert np.abs(slopes[0] - slopes[1]).max() > 0.01
    np.testing.assert_array_equal(slopes[0], slopes[3])
    number = two.handle[0]
    del two, points
    assert functions(plant).handle[0] == number


def test_a_run(plant):
    state, at, compiled = plant.initial_state(), plant.at(), functions(plant)
    runs = []
    for engine in (Idas(at, 1e-9), Idas(at, 1e-9, compiled=compiled)):
        runs.append(engine.advance(0.0, 10.0, 50, state.x, state.z, np.zeros(0)))
    for own, other in zip(*runs, strict=True):
        np.testing.assert_allclose(own, other, atol=1e-6)


def test_what_simulate_takes(plant, monkeypatch):
    """Small models are interpreted; where equations are many, they are compiled, and the results are the same."""
    assert not worth_compiling(plant.functions)
    expected = plant.simulate(5.0, solver="idas", tolerance=1e-9)
    made = []
    monkeypatch.setattr(compiled_functions, "OPERATIONS", (10, 1000))
    monkeypatch.setattr(FixedStepCode, "address", lambda self, name: made.append(name) or _address(self, name))
    fresh = fw.load(Chain()).compile()
    found = fresh.simulate(5.0, solver="idas", tolerance=1e-9)
    assert "model" in made
    np.testing.assert_allclose(found.array("q"), expected.array("q"), atol=1e-6)
    monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    assert not worth_compiling(fresh.functions)


_address = FixedStepCode.address


def test_an_external_in_python_is_not_called_from_compiled_code(monkeypatch):
    class Slow(fw.Component):
        """A decay by a Python function."""

        x: Scalar = var(unit="1", start=1.0, doc="state")

        def equations(self):
            decay = ExternalFunction("decay", {"x": 1}, {"rate": 1}, python=lambda x: -x, jacobian=lambda x: [[-1.0]])
            return [eq(der(self.x), decay(x=self.x)["rate"])]

    monkeypatch.setattr(compiled_functions, "OPERATIONS", (0, 1000))
    assert not worth_compiling(fw.load(Slow()).compile().functions)


def test_an_external_that_refuses_is_noticed(plant):
    """At a position for which the external gives no value; at the next point it does again."""
    compiled, names = functions(plant), [state.path for state in plant.dae.states]
    t, x, z = next(some_points(plant))
    q = given(plant, compiled)
    expected = np.array(compiled.residual(t, x, z, q)[0])
    far = np.where(np.array(names) == "q[1]", 200.0, x)
    for function in (compiled.residual, compiled.jacobian):
        with pytest.raises(RuntimeError, match="Evaluation failed"):
            function(t, far, z, q)
    np.testing.assert_array_equal(np.array(compiled.residual(t, x, z, q)[0]), expected)


@pytest.mark.parametrize("operations", [(0, 1000), (10_000, 20_000)])
def test_a_run_into_where_an_external_refuses_ends_with_a_sentence(monkeypatch, operations):
    """From 90, 3 further each second, to 100; with the equations compiled and interpreted."""

    class Moving(fw.Component):
        """A position at which the external refuses soon."""

        x: Scalar = var(unit="1", start=90.0, doc="position")
        y: Scalar = var(unit="1", start=0.0, doc="what the external drives")

        def equations(self):
            cube = ExternalFunction("cube", {"q": 2}, {"force": 2}, source=CUBE, python=lambda q: q**3)
            force = cube(q=m.vertcat(self.x, self.y))["force"]
            return [eq(der(self.x), 3.0), eq(der(self.y), 1e-9 * force[0] - force[1])]

    monkeypatch.setattr(compiled_functions, "OPERATIONS", operations)
    with pytest.raises(ModelError, match="an external function has no value there") as failed:
        fw.load(Moving()).compile().simulate(10.0, output_step=0.5, solver="idas")
    assert 3.0 <= failed.value.result.time[-1] < 10 / 3


def test_which_unknown_moves_a_state(plant):
    """A position is moved by the rate of its speed: itself an unknown, or an algebraic one."""
    code, states = plant.fixed_step_code, [state.path for state in plant.dae.states]
    unknown = dict(zip(states, code.reduction.unknown_of_states(len(code.dae.algebraics)), strict=True))
    assert unknown["q[0]"] == unknown["v[0]"]
    assert unknown["q[1]"] == unknown["v[1]"]
    assert len(set(unknown.values())) == 3


def test_patterns(plant):
    """Through the table and the external: the acceleration of the first mass depends on both positions."""
    states = [state.path for state in plant.dae.states]
    ode_x = jacobian_patterns(plant.dae)[0]
    row = {states[j] for i, j in zip(*ode_x.get_triplet(), strict=True) if states[i] == "v[0]"}
    assert row == {"q[0]", "q[1]"}
