"""A, B, C, D of a linear model and the gain of a regulator: with names, and matrices all the same."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

from fowtlib.control import lqr
from fowtlib.language.errors import ModelError
from fowtlib.solving.linear import LinearModel

A = np.array([[0.0, 1.0, 0.0], [-4.0, -0.4, 1.0], [0.5, 0.0, -3.0]])
B, C, D = np.array([[0.0], [1.0], [2.0]]), np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 5.0]]), np.zeros((2, 1))


@pytest.fixture
def linear():
    return LinearModel(A, B, C, D, ["x", "v", "f"], ["u"], ["y", "z"], {"y": "m", "z": "N"})


def test_shapes_of_modes_by_numpy(linear):
    """C times the eigenvectors, as a user of numpy writes it: the shapes that `modes` has, to a factor."""
    values, vectors = np.linalg.eig(linear.A)
    shapes = linear.C @ vectors
    np.testing.assert_allclose(shapes, C @ np.linalg.eig(A)[1])
    for mode in linear.modes():
        k = int(np.argmin(np.abs(values - mode.eigenvalue)))
        shape = shapes[:, k] / shapes[np.argmax(np.abs(shapes[:, k])), k]
        np.testing.assert_allclose(shape, [mode.shape["y"], mode.shape["z"]])


def test_products_are_those_of_the_numbers(linear):
    np.testing.assert_array_equal(linear.A @ linear.A, A @ A)
    np.testing.assert_array_equal(linear.C @ linear.A @ linear.B, C @ A @ B)
    np.testing.assert_array_equal(linear.C @ linear.A.T, C @ A.T)
    np.testing.assert_array_equal(linear.B.T @ linear.A, B.T @ A)
    np.testing.assert_array_equal(C @ linear.A, C @ A)
    np.testing.assert_array_equal(np.matmul(linear.C, linear.A), C @ A)
    np.testing.assert_array_equal(np.dot(linear.C, linear.A), C @ A)
    np.testing.assert_array_equal(linear.C.dot(linear.A), C @ A)
    np.testing.assert_array_equal(linear.A @ np.arange(3.0), A @ np.arange(3.0))
    np.testing.assert_array_equal(np.arange(2.0) @ linear.C, np.arange(2.0) @ C)
    assert float(linear.A[0] @ linear.A[1]) == pytest.approx(A[0] @ A[1])
    np.testing.assert_array_equal(linear.A @ xarray.DataArray(A, dims=("rate", "state")), A @ A)
    np.testing.assert_array_equal(xarray.DataArray(A, dims=("rate", "state")) @ linear.B, A @ B)


def test_linear_algebra_of_numpy(linear):
    for of in ("inv", "pinv", "det", "eigvals", "norm", "svd", "qr"):
        found, expected = getattr(np.linalg, of)(linear.A), getattr(np.linalg, of)(A)
        for one, other in zip(np.atleast_1d(found) if of != "svd" else found, np.atleast_1d(expected) if of != "svd"
                              else expected, strict=True):  # fmt: skip
            assert not isinstance(one, xarray.DataArray)
            np.testing.assert_array_equal(one, other)
    gain = D - linear.C @ np.linalg.solve(linear.A, linear.B)
    np.testing.assert_allclose(gain, linear.frequency_response([0.0])[0].real)
    np.testing.assert_array_equal(np.linalg.matrix_power(linear.A, 3), A @ A @ A)


def test_names_stay_where_both_factors_have_them(linear):
    product = linear.C @ linear.A
    assert float(product.sel(output="z", state="f")) == (C @ A)[1, 2]
    assert float((linear.A @ linear.B).sel(rate="v", input="u")) == (A @ B)[1, 0]
    assert isinstance(linear.A @ np.eye(3), np.ndarray)
    assert float(linear.A.sel(rate="v", state="x")) == -4.0 and float(linear.A.dot(linear.A, dim=...)) == np.sum(A * A)


def test_functions_of_one_matrix_keep_the_names(linear):
    for found, expected in ((-linear.A, -A), (linear.A.round(1), A.round(1)), (abs(linear.A), abs(A))):
        assert found.dims == ("rate", "state") and float(found.sel(rate="v", state="x")) == expected[1, 0]
        np.testing.assert_array_equal(found, expected)


def test_what_xarray_would_put_in_order_is_refused(linear):
    """A + A.T by names is 2 A."""
    for wrong in (lambda: linear.A + linear.A.T, lambda: linear.A.T * linear.A, lambda: linear.A - linear.C,
                  lambda: np.add(linear.A, linear.A.T)):  # fmt: skip
        with pytest.raises(ModelError, match="np.asarray"):
            wrong()
    with pytest.raises(ModelError, match="no matrix product of 3 x 3 and 2 x 3"):
        linear.A @ linear.C
    np.testing.assert_array_equal(linear.A + 2 * linear.A, 3 * A)
    np.testing.assert_array_equal(linear.A - np.eye(3), A - np.eye(3))


def test_the_gain_of_a_regulator(linear):
    regulator = lqr(linear, {"x": 1.0}, 1.0)
    loop = linear.A - linear.B @ regulator.K
    np.testing.assert_allclose(loop, A - B @ regulator.gain)
    assert loop.dims == ("rate", "state")
    assert np.linalg.eigvals(loop).real.max() < 0
