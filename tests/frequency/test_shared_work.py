"""What responses share, or sum up otherwise: sums of shares, arrays of functions, kept eigenvectors, near means."""

import casadi as ca
import numpy as np
import pytest

from fowtlib.frequency.driven import _of_few
from fowtlib.frequency.studies import _distance
from fowtlib.language.eigenvectors import eigenvalues, eigenvectors
from fowtlib.solving.arrays import Arrays


@pytest.mark.parametrize("undamped", [(), (0,), (0, 1)])
def test_covariances_by_sums_of_shares_are_those_frequency_by_frequency(undamped):
    random = np.random.default_rng(3)
    omega, n, m, laws = np.linspace(0.05, 3.0, 60), 7, 3, 5
    roots = -0.02 - random.random(n) + 2j * random.standard_normal(n)
    roots[:2] = roots[0], roots[0].conj()
    roots[list(undamped)] = 0.0
    complex_of = lambda *shape: random.standard_normal(shape) + 1j * random.standard_normal(shape)  # noqa: E731
    drive, by_inputs, shapes = complex_of(60, m, 4), complex_of(n, m), complex_of(laws, n)
    own = random.standard_normal((laws, m))
    shares = 1 / (1j * omega - roots[:, None])
    y = np.einsum("ln,nq,nm,qmk->lqk", shapes, shares, by_inputs, drive) + np.einsum("lm,qmk->lqk", own, drive)
    expected = np.einsum("lqk,pqk->lp", y, y.conj()).real
    covariances = drive @ drive.conj().transpose(0, 2, 1)
    found = _of_few(covariances, roots, shares, by_inputs, shapes, own)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max())


def test_arrays_are_the_values_of_the_function():
    x, y = ca.SX.sym("x", 4), ca.SX.sym("y", 2)
    sparse = ca.SX(4, 3)
    sparse[1, 0], sparse[3, 2] = x[0] * y[1], ca.sin(x[2])
    function = ca.Function("f", [x, y], [sparse, ca.mtimes(x, y.T), ca.SX(2, 2), ca.dot(x, x)])
    arrays, given = Arrays(function), (np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.5, -2.0]))
    for mine, value in zip(arrays(*given), function(*given), strict=True):
        np.testing.assert_array_equal(mine, value.full())
    first = arrays.entries(*given)[1]
    arrays.entries(2 * given[0], given[1])
    np.testing.assert_array_equal(first, np.outer(*given).ravel(order="F"))  # the memory is not lent


def test_eigenvectors_of_the_last_matrices_are_kept():
    A = np.random.default_rng(1).standard_normal((6, 6))
    roots, right, left = eigenvectors(A)
    assert eigenvectors(A.copy())[1] is right
    assert eigenvalues(A) is roots
    np.testing.assert_allclose((right * roots) @ left, A, atol=1e-12)
    assert eigenvectors(A + 1e-9)[1] is not right
    assert eigenvectors(np.array([[0.0, 1.0], [0.0, 0.0]])) is None


def test_means_of_other_sizes_are_near_and_of_other_kinds_are_not():
    sizes = {"hull": np.array([6.0, 7.0]), "wind.mean_speed": 12.0, "wind.kind": "steady"}
    assert _distance(sizes, sizes) == 0
    near, far = ({**sizes, "hull": sizes["hull"] * factor} for factor in (1.01, 1.2))
    assert 0 < _distance(sizes, near) < _distance(sizes, far) < 1
    for other in ({"hull": np.array([6.0, 7.0, 8.0])}, {"wind.kind": "none"}, {"hull": [[1.0], [1.0, 2.0]]}):
        assert _distance(sizes, {**sizes, **other}) == np.inf
