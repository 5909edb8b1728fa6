"""Newton by whole steps, and where it gives up."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from fowtlib.solving.newton import newton, undamped


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
