"""What responses share, or sum up otherwise: sums of shares, arrays of functions, kept eigenvectors, near means."""

import casadi as ca
import numpy as np
import pytest

from fowtlib.frequency.driven import _of_few
from fowtlib.frequency.known_rows import KnownRows
from fowtlib.frequency.studies import _distance
from fowtlib.language import Component, Number, param
from fowtlib.language.eigenvectors import eigenvalues, eigenvectors
from fowtlib.language.expressions import one_evaluation, parameters_read
from fowtlib.solving.arrays import Arrays
from fowtlib.solving.known_slopes import KnownSlopes, contents_of
from fowtlib.solving.real_modes import RealModes


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


def test_modes_in_real_numbers_answer_as_the_equations_do_and_backwards():
    random = np.random.default_rng(5)
    A = random.standard_normal((7, 7)) - 2 * np.eye(7)
    roots, right, left = eigenvectors(A)
    assert 0 < np.sum(roots.imag == 0) < 7  # pairs and real roots
    modes, omega = RealModes.made(roots, right, left), np.array([0.1, 0.9, 3.0])
    b = random.standard_normal((7, 3, 2)) + 1j * random.standard_normal((7, 3, 2))
    B, C, functions = random.standard_normal((7, 2)), random.standard_normal((4, 7)), modes.functions(omega)
    x = np.einsum("sn,nqk->sqk", modes.shapes, modes.answers(functions, np.einsum("ns,sqk->nqk", modes.of, b)))
    parts = modes.answers(functions.conj(), np.einsum("sn,sqk->nqk", modes.shapes, b))
    y, H = np.einsum("ns,nqk->sqk", modes.of, parts), modes.between(C, B) @ functions
    for k, w in enumerate(omega):
        system = 1j * w * np.eye(7) - A
        np.testing.assert_allclose(system @ x[:, k], b[:, k], atol=1e-12)
        np.testing.assert_allclose(system.conj().T @ y[:, k], b[:, k], atol=1e-12)
        np.testing.assert_allclose(H[:, :, k], C @ np.linalg.solve(system, B), atol=1e-12)


class Filter(Component):
    """Something that is a function of frequency."""

    gain: Number = param(default=2.0, doc="factor")
    other: Number = param(default=1.0, doc="what the function does not read")


def test_rows_that_are_known_are_not_asked_for_again():
    part, known, asked = Filter(), KnownRows(), []

    def function(omega):
        asked.append(omega.tolist())
        return part.parameter_value("gain") * omega

    def rows(omega, **values):
        part._values.update(values)
        return known.of("f", part, contents_of(values), function, {})(np.array(omega)).tolist()

    assert rows([1.0, 2.0, 4.0], gain=2.0, other=1.0) == [2.0, 4.0, 8.0]
    assert rows([1.0, 3.0, 4.0], gain=2.0, other=5.0) == [2.0, 6.0, 8.0]  # of the same gain
    assert rows([2.0, 3.0, 4.0], gain=2.0, other=5.0) == [4.0, 6.0, 8.0]  # of two tables
    assert rows([1.0, 3.0], gain=3.0, other=5.0) == [3.0, 9.0]
    assert rows([3.0], gain=2.0, other=7.0) == [6.0]
    assert asked == [[1.0, 2.0, 4.0], [3.0], [1.0, 3.0]]
    assert rows([3.0]) == [6.0]  # a gain that is not given may be another one: asked
    assert len(asked) == 4


def test_what_a_value_reads_is_noted_for_all_who_ask_for_it():
    part = Filter()
    with one_evaluation():
        assert part.parameter_value("gain") == 2.0  # nobody notes it
        for _ in range(2):
            with parameters_read() as read:
                part.parameter_value("gain")
            assert read == {("", "gain")}


def test_slopes_are_known_for_equal_numbers_alone():
    known, wind = KnownSlopes(), {"wind.kind": "kaimal", "wind.speed": 9.0, "hull.wall": np.array([0.04, 0.05])}
    first = known.of("mass", contents_of(wind))
    first.note({("hull", "wall")}, contents_of(wind))
    first.slopes["hull.wall[0]"] = 7.0
    assert known.of("mass", contents_of(wind | {"wind.speed": 12.0})) is first  # nobody reads it
    assert known.of("mass", contents_of(wind | {"hull.wall": np.array([0.04, 0.06])})).slopes == {}
    again = known.of("mass", contents_of(wind))
    assert again.slopes == {}  # of the last numbers alone
    again.note({("hull", "wall")}, contents_of(wind))
    assert known.of("mass", contents_of(wind | {"wind.kind": "frozen"})) is not again  # another kind of part
