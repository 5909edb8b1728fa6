"""What is done before the first step: Jacobians for start values, and compiled equations that are found again."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import ExternalFunction, Scalar, der, eq, initial, param, table1d, time_series, var
from fowtlib.language import math as m
from fowtlib.language.native import compiler
from fowtlib.solving import functions as solving_functions
from fowtlib.solving import initial as start_values
from fowtlib.solving.engines import fixed_step_code

GRID = np.linspace(-3.0, 3.0, 25)


class Chained(fw.Component):
    """Externals of externals, of states, unknowns and time; an initial equation; z by an implicit equation."""

    gain: Scalar = param(default=0.4, doc="gain")
    x: Scalar = var(start=0.3, doc="state")
    y: Scalar = var(start=0.5, fixed=True, state="prefer", doc="state")
    z: Scalar = var(start=0.2, doc="unknown")

    def equations(self):
        wave = time_series(self.time, 0.0, 0.1, np.cos(np.arange(50) / 7), name="wave")
        first = table1d(self.x + self.gain * self.z, GRID, np.sin(GRID), name="first")
        mixing = ExternalFunction(
            "mixing", {"a": 2}, {"b": 2}, python=lambda a: [a[0] * a[1], a[0] - a[1] ** 2],
            jacobian=lambda a: [[a[1], a[0]], [1.0, -2 * a[1]]],
        )  # fmt: skip
        second = mixing(a=m.vertcat(first, self.y))["b"]
        return [
            eq(der(self.x), second[0] - self.x),
            eq(der(self.y), wave - self.y),
            eq(self.z + 0.1 * m.sin(self.z) + 0.2 * second[1], self.x + wave),
            initial(der(self.x), 0.1),
        ]


@pytest.fixture
def plant():
    return fw.load(Chained()).compile()


def test_along_directions_the_jacobian_is_the_torn_one(plant):
    functions, dae = plant.functions, plant.dae
    assert len(dae.levels) == 2  # an external takes the output of another
    rows = ca.vertcat(dae.ode, dae.alg, dae.initial_equations)
    columns = ca.vertcat(functions.x, functions.z)
    point = (0.7, [0.3, 0.5], [0.2], plant.at().parameters)
    along = np.array(functions.directional_jacobian("along", rows, columns)(*point))
    torn = np.array(ca.densify(functions.torn_jacobian("torn", rows, [columns])(*point)))
    assert along.shape == torn.shape == (rows.shape[0], columns.shape[0])
    assert np.abs(torn).max() > 0.1
    np.testing.assert_allclose(along, torn, rtol=1e-13, atol=1e-15)


def test_the_jacobian_along_directions_is_that_of_differences(plant):
    functions, at = plant.functions, plant.at()
    point = (0.7, [0.3, 0.5], [0.2], at.parameters)
    slopes = np.array(functions.directional_jacobian("along", plant.dae.alg, plant.dae.z)(*point))
    h = 1e-5
    above, below = (float(at.residual(0.7, [0.3, 0.5], [0.2 + d], [])[1]) for d in (h, -h))
    assert slopes[0, 0] == pytest.approx((above - below) / (2 * h), rel=1e-8)
    assert np.array_equal(slopes, np.array(at.algebraic_jacobian(0.7, [0.3, 0.5], [0.2], [])))
    functions.jacobian  # noqa: B018  made now: it serves from here on
    again = np.array(ca.densify(at.algebraic_jacobian(0.7, [0.3, 0.5], [0.2], [])))
    np.testing.assert_allclose(slopes, again, rtol=1e-13)


def test_many_unknowns_start_where_few_do(plant, monkeypatch):
    few = plant.initial_state()
    monkeypatch.setattr(solving_functions, "MANY", 0)
    monkeypatch.setattr(start_values, "MANY", 0)
    many = fw.load(Chained()).compile().initial_state()
    np.testing.assert_allclose([*few.x, *few.z], [*many.x, *many.z], rtol=1e-12)
    assert few["der(x)"] == pytest.approx(0.1, abs=1e-9)
    assert few["y"] == 0.5


class Decay(fw.Component):
    """x' = -rate x^power."""

    rate: Scalar = param(default=0.5, doc="rate")
    power: int = param(default=1, doc="power")
    x: Scalar = var(start=1.0, doc="state")

    def equations(self):
        return [eq(der(self.x), -self.rate * self.x**self.power)]


@pytest.fixture
def texts(tmp_path, monkeypatch):
    """Names of the models whose text was written, in a cache that is empty at first."""
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    written = []
    original = fixed_step_code.model_text

    def model_text(dae, *more):
        written.append(dae.states[0].path)
        return original(dae, *more)

    monkeypatch.setattr(fixed_step_code, "model_text", model_text)
    return written


def run(**parameters):
    plant = fw.load(Decay(**parameters)).compile()
    return plant.simulate(2.0, 0.5, solver="fixed", step=0.02, outputs=["x"]).array("x")


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_the_text_of_the_same_equations_is_written_once(texts):
    first = run()
    assert np.array_equal(run(), first)
    assert len(texts) == 1
    faster = run(rate=1.0)  # a tunable parameter is an argument of the code
    assert len(texts) == 1
    np.testing.assert_allclose(faster, np.exp(-np.arange(0, 2.1, 0.5)), rtol=1e-3)
    np.testing.assert_allclose(run(power=2), 1 / (1 + 0.5 * np.arange(0, 2.1, 0.5)), rtol=1e-3)
    assert len(texts) == 2


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_other_code_that_writes_it_writes_it_anew(texts, monkeypatch):
    first = run()
    monkeypatch.setattr(fixed_step_code, "sources", lambda *modules: ["another text", "1.0"])
    assert np.array_equal(run(), first)
    assert len(texts) == 2


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_a_damaged_text_is_written_again(texts, tmp_path):
    first = run()
    (file,) = tmp_path.glob("text_*.json")
    file.write_text(file.read_text(encoding="utf-8").replace("x[0]", "x[1]"), encoding="utf-8")
    assert np.array_equal(run(), first)
    assert len(texts) == 2


class Alone(fw.Component):
    """Without algebraic unknowns."""

    x: Scalar = var(start=0.0, doc="state")
    y: Scalar = var(start=0.0, doc="state")

    def equations(self):
        return [eq(der(self.x), -self.x), eq(der(self.y), self.x - self.y), initial(self.x, 1), initial(self.y, 2)]


def test_with_all_start_values_given_nothing_is_left_to_solve_for():
    plant = fw.load(Alone()).compile()
    states = [plant.initial_state(start=start).x.tolist() for start in ({}, {"x": 3.0}, {"x": 3.0, "y": 4.0})]
    assert states == [[1, 2], [3, 2], [3, 4]]


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_code_that_was_begun_is_the_code(plant, monkeypatch, tmp_path):
    """Begun or not, the same library, written once and compiled once; and the same results to the last digit."""
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "own"))
    written = []
    write = fixed_step_code.write
    monkeypatch.setattr(fixed_step_code, "write", lambda *given: written.append(1) or write(*given))
    plant.begin_code()
    plant.begin_code()
    begun = plant.simulate(1.0, 0.1, solver="fixed")
    assert len(written) == 1 and len(list((tmp_path / "own").glob("model_*.so"))) == 1
    other = fw.load(Chained()).compile()
    later = other.simulate(1.0, 0.1, solver="fixed")
    assert plant.fixed_step_code.path == other.fixed_step_code.path and len(written) == 2
    assert all(np.array_equal(begun.array(name), later.array(name)) for name in ("x", "y", "z"))
