"""Newton by whole steps, and where it gives up."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from fowtlib.solving.newton import DENSE, beside, newton, undamped


def problem(function, slope):
    return lambda v: function(v), lambda v: sparse.csc_matrix(np.diag(slope(v)))


def test_whole_steps_over_a_residual_that_rises_first():
    """x^2 = 1e-4 from 0.002: the first step goes to 0.026, where the residual is six times as large."""
    residual, jacobian = problem(lambda v: v**2 - 1e-4, lambda v: 2 * v)
    found = undamped(residual, jacobian, np.array([0.002]))
    assert found.converged and abs(found.values[0] - 0.01) < 1e-12 and found.iterations < 9


def test_what_does_not_come_nearer_is_left_to_the_damped_one():
    residual, jacobian = problem(np.arctan, lambda v: 1 / (1 + v**2))
    start = np.array([3.0])  # whole steps leave arctan for infinity beyond 1.39
    assert undamped(residual, jacobian, start) is None
    assert abs(newton(residual, jacobian, start).values[0]) < 1e-10
    singular = problem(lambda v: v**2, lambda v: 0 * v)
    assert undamped(*singular, np.array([1.0])) is None


@pytest.mark.parametrize("size", [3, DENSE + 1])
def test_from_a_solution_beside_it_with_the_slopes_there_alone(size):
    """Of x + tanh(M x)/2 = x0 + tanh(M x0)/2 that is x0, as M is small; from that of a fifth more on the right."""
    rng, asked = np.random.default_rng(1), []
    M = rng.normal(size=(size, size)) / size
    x0 = rng.normal(size=size)

    def function(x):
        return x + np.tanh(M @ x) / 2

    def slopes(x):
        asked.append(x)
        return sparse.csc_matrix(np.eye(size) + M / 2 / np.cosh(M @ x)[:, None] ** 2)

    start = newton(lambda x: function(x) - 1.2 * function(x0), slopes, x0).values
    asked.clear()
    found = beside(lambda x: function(x) - function(x0), slopes, start, tolerance=1e-11)
    assert found.converged and len(asked) == 1
    np.testing.assert_allclose(found.values, x0, atol=1e-13)  # rounding of numbers of size 1, some hundred times


def test_slopes_that_do_not_serve_elsewhere_are_told():
    residual, jacobian = problem(np.arctan, lambda v: 1 / (1 + v**2))
    assert beside(residual, jacobian, np.array([3.0])) is None
    assert beside(*problem(lambda v: v**2, lambda v: 0 * v), np.array([1.0])) is None  # singular
    assert beside(residual, jacobian, np.zeros(1)).converged  # there already
    assert beside(residual, jacobian, np.zeros(0)).converged  # nothing to solve


def test_a_short_step_of_updates_is_no_solution():
    """x^3 + 1 = 0 from 0.6, where slopes are far off: what comes back is the root, or nothing."""
    for start in np.linspace(-3, 3, 121):
        found = beside(lambda x: x**3 + 1, lambda x: np.diag(3 * x**2), np.array([start]), tolerance=1e-8)
        assert found is None or abs(found.values[0] + 1) < 1e-7
