"""One plant for many runs: what is made for the first serves all others, whatever numbers they have."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Scalar, assert_, assign, der, eq, initial, param, sampled, table1d, var, when
from fowtlib.language import math as m


class Everything(fw.Component):
    """A driven oscillator with friction that is an implicit equation, an event, a sampled part and a check."""

    stiffness: Scalar = param(default=4.0, unit="1/s^2", doc="stiffness over mass")
    friction: Scalar = param(default=0.3, unit="1/s", doc="friction over mass")
    period: Scalar = param(default=0.5, unit="s", doc="period of the controller")
    offset: Scalar = param(default=0.2, unit="m", doc="position at which it starts")
    x: Scalar = var(unit="m", state="prefer", doc="position")
    v: Scalar = var(unit="m/s", start=0.4, state="prefer", doc="speed")
    drag: Scalar = var(unit="m/s^2", start=0.1, doc="solves drag + drag^3 = friction v")
    push: Scalar = var(unit="m/s^2", start=0.0, discrete=True, doc="of the controller")
    hits: Scalar = var(unit="1", start=0.0, discrete=True, doc="how often x has fallen below -0.1")

    def equations(self):
        spring = table1d(self.x, np.linspace(-3, 3, 13), np.sin(np.linspace(-3, 3, 13)))
        return [
            eq(der(self.x), self.v),
            eq(der(self.v), -self.stiffness * spring - self.drag + self.push + m.sin(self.time)),
            eq(self.drag + self.drag**3, self.friction * self.v),
            initial(self.x, self.offset),
            sampled(self.period, assign(self.push, -0.1 * self.v)),
            when(self.x < -0.1, assign(self.hits, self.hits + 1)),
            assert_(self.x < 0.15, f"{self.x} m is far", level="warning"),
        ]


@pytest.fixture
def made(monkeypatch):
    """Names of the functions and integrators that CasADi makes."""
    names: list[str] = []
    construct, integrator, jacobian = ca.Function.__init__, ca.integrator, ca.jacobian

    def counted(self, *arguments):
        if arguments and isinstance(arguments[0], str):  # not the copy of one that is there
            names.append(arguments[0])
        construct(self, *arguments)

    monkeypatch.setattr(ca.Function, "__init__", counted)
    monkeypatch.setattr(ca, "integrator", lambda *a: names.append("integrator") or integrator(*a))
    monkeypatch.setattr(ca, "jacobian", lambda *a: names.append("jacobian") or jacobian(*a))
    return names


OTHER = {"stiffness": 6.0, "friction": 0.8, "period": 0.25, "offset": 0.3}


def use(plant, solver, parameters):
    """All that a plant is asked for, as numbers."""
    with pytest.warns(UserWarning, match="is far"):
        result = plant.simulate(4.0, 0.1, solver=solver, parameters=parameters)
    state = plant.initial_state(parameters)
    linear = plant.linearize(state, ["stiffness"], ["drag"])
    numbers = [result["x"].values[-1], result.array("drag")[-1], result.array("hits")[-1], state["der(v)"]]
    return [*numbers, *np.ravel(linear.matrices["A"]), *np.ravel(linear.matrices["D"])]


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_other_parameters_make_no_function_and_no_integrator(made, solver):
    plant = fw.load(Everything()).compile()
    first = use(plant, solver, None)
    assert "residual" in made or solver == "fixed"
    assert ("integrator" in made) == (solver == "idas")
    made.clear()
    second = use(plant, solver, OTHER)
    assert made == []
    assert not np.allclose(first, second)
    again = use(plant, solver, None)
    np.testing.assert_array_equal(again, first)
    fresh = use(fw.load(Everything(**OTHER)).compile(), solver, None)
    np.testing.assert_allclose(second, fresh, rtol=1e-10, atol=1e-12)


def test_an_equilibrium_and_start_values_make_no_function_again(made):
    class Hanging(fw.Component):
        """A mass on a stiffening spring."""

        stiffness: Scalar = param(default=4.0, unit="1/s^2", doc="stiffness over mass")
        x: Scalar = var(unit="m", start=0.1, state="prefer", doc="position")
        v: Scalar = var(unit="m/s", state="prefer", doc="speed")

        def equations(self):
            return [eq(der(self.x), self.v), eq(der(self.v), 1.0 - self.stiffness * (self.x + self.x**3) - self.v)]

    plant = fw.load(Hanging()).compile()
    plant.equilibrium()
    made.clear()
    state = plant.equilibrium({"stiffness": 0.5}, start={"x": 0.5})
    assert made == []
    assert state["x"] == pytest.approx(1.0, abs=1e-9)


def test_a_parameter_that_was_zero_and_is_no_longer(made):
    """What it multiplies was left out; the functions are made again once, and serve both from then on."""
    plant = fw.load(Everything(friction=0.0)).compile()
    none = plant.simulate(1.0, 0.1)["x"].values
    made.clear()
    some = plant.simulate(1.0, 0.1, parameters={"friction": 0.8})["x"].values
    assert made
    made.clear()
    np.testing.assert_allclose(plant.simulate(1.0, 0.1)["x"].values, none, rtol=1e-6)
    less = plant.simulate(1.0, 0.1, parameters={"friction": 0.4})["x"].values
    assert not made
    fresh = fw.load(Everything(friction=0.8)).compile().simulate(1.0, 0.1)["x"].values
    np.testing.assert_allclose(some, fresh, rtol=1e-12)
    assert np.abs(some - less).max() > 1e-4 < np.abs(less - none).max()
    state = fw.load(Everything(friction=0.0)).compile().initial_state()
    slope = plant.linearize(state, ["friction"], ["drag"]).matrices["D"]
    assert slope[0, 0] == pytest.approx(0.4)  # the speed at the start, where there is no drag yet


@pytest.mark.parametrize("points", [1, 9, 10, 99, 100, 237])
def test_many_points_are_one_after_the_other(points):
    plant = fw.load(Everything()).compile()
    at, random = plant.at(), np.random.default_rng(3)
    t, x, z, q = (random.normal(size=(points, k) if k else points) for k in (0, 2, 1, 2))
    function = plant.functions.observed(["der(v)", "drag", "x"])
    values = at.along(function, t, x, z, q)
    assert values.shape == (points, 3)
    for row, point in zip(values, zip(t, x, z, q, strict=True), strict=True):
        np.testing.assert_allclose(row, np.array(at.call(function, *point)).ravel(), rtol=1e-14)
