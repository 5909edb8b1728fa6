"""Loads of products of fluctuations against closed forms.

x of x' + x = white noise has the covariance s^2 exp(-|t|), and x^2 that of 2 s^4 exp(-2|t|) (Isserlis). What has the
covariance V exp(-b|t|) gives y of y' + a y = it the variance V / (a (a + b)), and a damped oscillator by its spectrum.
Of x and what follows it within 1 s (`late`) the covariances are s^2/2 (1 + t) exp(-t) for late with itself, s^2/2
exp(-t) where late leads, s^2/2 (1 + 2 t) exp(-t) where it lags.
"""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.frequency import equivalent as search
from fowtlib.frequency.products import PRODUCTS, correlations, spectra_of_products
from fowtlib.frequency.relaxation import Relaxation
from fowtlib.frequency.responses import ProductsWarning
from fowtlib.language import Scalar, der, eq, param, var
from fowtlib.language.errors import SimulationError
from tests.frequency.test_equivalent import GRID, Filter, filtered

FINE = np.geomspace(2e-3, 9.0, 500)  # Hz


def test_the_spectrum_of_a_square_is_twice_that_of_the_covariance_squared():
    f = np.geomspace(1e-4, 30.0, 3000)
    lines, found = spectra_of_products(
        np.array([[[2.0]]]), *correlations(f, (4 / (1 + (2 * np.pi * f) ** 2)).reshape(-1, 1, 1))
    )
    expected = 2 * 2 * 2 * 2 / (4 + (2 * np.pi * lines) ** 2)  # of 2 exp(-2 |t|), one-sided
    there = (lines > 1e-3) & (lines < 1.0)
    assert found[there, 0, 0].real == pytest.approx(expected[there], rel=0.01)  # what lies beyond 30 Hz; the rest less


def test_two_products_have_the_cross_spectrum_of_isserlis():
    """y1^2/2 and y1 y2 of y2 that lags y1 by a second: their cross covariance R11(t) R12(t), E[y1(t + tau) y2(t)]."""
    f = np.linspace(1e-3, 2.0, 4000)
    S = np.exp(-((f / 0.2) ** 2))
    H = np.stack([np.ones_like(f), np.exp(-2j * np.pi * f)], axis=1)[:, :, None]
    cross = H @ H.conj().transpose(0, 2, 1) * S[:, None, None]
    # of a covariance of one: mix with the inverse root of that at a lag of zero, the forms likewise
    P = np.trapezoid(cross, f, axis=0).real
    L = np.linalg.cholesky(P)
    forms = np.array([[[1.0, 0.0], [0.0, 0.0]], [[0.0, 1.0], [1.0, 0.0]]])
    lines, found = spectra_of_products(L.T @ forms @ L, *correlations(f, cross))
    step = lines[1] - lines[0]
    lag = np.arange(0, 6, 0.25)

    def R(t):
        return np.trapezoid(S * np.cos(2 * np.pi * f * t[:, None]), f, axis=1)

    got = np.real(np.exp(2j * np.pi * lines * lag[:, None]) @ found[:, 0, 1]) * step - found[0, 0, 1].real * step / 2
    assert got == pytest.approx(R(lag) * R(lag + 1), abs=0.005 * P[0, 0] ** 2)  # steps of the axis, 1e-3 Hz


def test_a_square_drives_what_follows_it():
    """E of y' + y = x^2 has slope 0 for x without a mean, and the variance 2 s^4 / 3 by products."""
    found = fw.response(squares(), outputs=["x", "y"], frequencies=FINE, linearisation="quadratic")
    s = found.std("x")
    assert found.mean[1] == pytest.approx(s**2, rel=0.02)
    assert found.std("y", PRODUCTS) == pytest.approx(
        np.sqrt(2 / 3) * s**2, rel=0.02
    )  # frequencies end at 2e-3 and 9 Hz
    assert found.std("y") == pytest.approx(found.std("y", PRODUCTS), rel=1e-3)
    without = fw.response(squares(), outputs=["x", "y"], frequencies=FINE, linearisation="equivalent")
    assert without.std("y") < 0.02 * s**2


def test_a_product_of_two_has_their_covariances_beside_their_slopes():
    """Covariance of x late: R_xx R_ll + R_xl(tau) R_xl(-tau) = s^4 (1 + t)/2 e^-2t + s^4 (1 + 2 t)/4 e^-2t."""
    names = ["x", "late", "product"]
    found = fw.response(filtered(level=0.5, lead=1.0), outputs=names, frequencies=GRID, linearisation="quadratic")
    s = found.std("x")
    t = np.linspace(0, 40, 40001)
    R = s**4 * np.exp(-2 * t) * ((1 + t) / 2 + (1 + 2 * t) / 4)
    variance = np.trapezoid(R * np.exp(-t), t)  # of what follows within 1 s
    assert found.std("product", PRODUCTS) == pytest.approx(np.sqrt(variance), rel=0.02)
    linear = fw.response(filtered(level=0.5, lead=1.0), outputs=names, frequencies=GRID, linearisation="equivalent")
    together = np.hypot(linear.std("product"), np.sqrt(variance))
    assert found.std("product") == pytest.approx(together, rel=0.02)


def test_what_follows_a_corner_has_most_of_what_it_is_beside_its_half():
    """Variance of max(x, 0) beside its slope: s^2 (1/4 - 1/(2 pi)), of which s^2/(4 pi) is of second order."""
    found = fw.response(filtered(level=0.5), outputs=["x", "held"], frequencies=GRID, linearisation="quadratic")
    s = found.std("x")
    assert found.std("held", PRODUCTS) == pytest.approx(s / np.sqrt(4 * np.pi), rel=0.05)  # lags by 0.05 s: 5 % of it


class Squares(Filter):
    """The filter, and what follows the square of x."""

    y: Scalar = var(start=0.0, doc="follows the square of x within 1 s")

    def equations(self):
        return [*super().equations(), eq(der(self.y), self.x**2 - self.y)]


def squares():
    root = fw.Assembly("filters")
    root.one = Squares(level=0.5)
    return fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "y")})


class Damped(Filter):
    """The filter, and y that follows x with a rate of 1 + strength x."""

    strength: Scalar = param(default=0.3, doc="of x in the rate of y")

    y: Scalar = var(start=0.0, doc="with a random decay")

    def equations(self):
        return [*super().equations(), eq(der(self.y), self.x - (1 + self.strength * self.x) * self.y)]


def exact_of_damped(b, s2):
    """Mean and deviation of y = int exp(-u - b I_u) x(-u) du, I_u = int_{-u}^0 x; x of the covariance s2 exp(-|t|).

    For Gaussian A, x and x' with means of zero E[exp(-A) x] = -C(A, x) exp(C(A, A)/2), and E[exp(-A) x x'] = (C(x, x')
    + C(A, x) C(A, x')) exp(C(A, A)/2).
    """
    u = np.linspace(0, 25, 1251)
    w = np.full(u.size, u[1])
    w[[0, -1]] /= 2

    def V(u):
        return 2 * s2 * (u - 1 + np.exp(-u))

    def C(u, w):  # of I_u with x(-w)
        inside = 2 - np.exp(-np.minimum(w, u)) - np.exp(-np.maximum(u - w, 0))
        beyond = np.exp(-np.maximum(w - u, 0)) - np.exp(-w)
        return s2 * np.where(w <= u, inside, beyond)

    mean = np.sum(w * np.exp(-u) * -b * C(u, u) * np.exp(b**2 * V(u) / 2))
    p, q = u[:, None], u[None, :]
    of_both = 2 * V(p) + 2 * V(q) - V(np.abs(p - q))  # V(I_p + I_q)
    left, right = b * (C(p, p) + C(q, p)), b * (C(p, q) + C(q, q))
    square = (s2 * np.exp(-np.abs(p - q)) + left * right) * np.exp(b**2 * of_both / 2 - p - q)
    return mean, np.sqrt(w @ square @ w - mean**2)


def test_a_random_decay_has_the_deviation_of_the_exact_moments():
    root = fw.Assembly("filters")
    root.one = Damped(level=0.5)
    model = fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "y")})
    found = fw.response(model, frequencies=FINE, linearisation="quadratic")
    mean, s = exact_of_damped(0.3, found.std("x") ** 2)
    without = fw.response(model, frequencies=FINE, linearisation="equivalent")
    assert found.std("y") == pytest.approx(s, rel=0.01)  # what is left is of fourth order in the strength
    assert found.mean[1] == pytest.approx(mean, rel=0.04)
    assert abs(without.std("y") / s - 1) > 0.05
    alone = np.hypot(without.std("y"), found.std("y", PRODUCTS))
    assert abs(alone / s - 1) > 0.03  # it takes the answer of products to products, not their noise alone


def test_a_strongly_random_decay_has_nine_tenths_of_the_exact_deviation():
    """A rate of 1 + 0.6 x, x of 0.88, is below zero in 3 % of the time; fourth order in the strength counts."""
    root = fw.Assembly("filters")
    root.one = Damped(level=0.5, strength=0.6)
    model = fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "y")})
    found, without = (fw.response(model, frequencies=FINE, linearisation=word) for word in ("quadratic", "equivalent"))
    s = exact_of_damped(0.6, found.std("x") ** 2)[1]
    assert found.std("y") == pytest.approx(s, rel=0.1)  # 0.92
    assert without.std("y") < 0.75 * s  # 0.69


def test_where_what_products_make_of_products_swings_out_it_is_the_loads_alone_with_a_warning(monkeypatch):
    """Of y' = x - (1 + 0.3 x) y by a bound on the search that nothing passes."""
    root = fw.Assembly("filters")
    root.one = Damped(level=0.5, strength=0.3)
    model = fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "y")})
    whole = fw.response(model, frequencies=FINE, linearisation="quadratic")
    without = fw.response(model, frequencies=FINE, linearisation="equivalent")
    monkeypatch.setattr(search, "SWUNG", 1.01)
    with pytest.warns(ProductsWarning, match="loads of their own, but not with what they make of products"):
        alone = fw.response(model, frequencies=FINE, linearisation="quadratic")
    together = np.hypot(without.std("y"), alone.std("y", PRODUCTS))
    assert alone.std("y") == pytest.approx(together, rel=0.02)  # its own covariance makes its products
    assert alone.std("y") < 0.98 * whole.std("y")
    monkeypatch.setattr(search, "FED_BACK", 1)  # no search settles so soon
    monkeypatch.setattr(search, "SWUNG", 3.0)
    with pytest.warns(ProductsWarning):
        assert fw.response(model, frequencies=FINE, linearisation="quadratic").std("y") == alone.std("y")


def test_a_search_whose_whole_steps_grow_ends_by_steps_that_turn_back():
    """A variance v = 1/(0.125 v - 0.05), as of a swing that only its own size damps, rough by 5 %: 3.04.

    The slope of the right side is -1.2 there, so that whole steps grow; with 0.9 in place of 0.05 it is -8.4.
    """
    for lost in (0.05, 0.9):
        root = (lost + np.sqrt(lost**2 + 0.5)) / 0.25
        slope = -0.125 * root**2
        assert slope < -1.1
        relaxed, v = Relaxation(), np.array([1.2 * root])
        for k in range(30):
            rough = 1 + 0.05 * np.sin(50.0 * k**2)
            found = 1 / np.maximum(0.125 * v - lost, 0.05 / root) * rough
            v = v + relaxed(found - v) * (found - v)
        assert v == pytest.approx(root, rel=0.02), lost


def test_a_search_with_products_that_does_not_settle_is_refused(monkeypatch):
    monkeypatch.setattr(search, "WITH_PRODUCTS", 3)  # it takes more
    root = fw.Assembly("filters")
    root.one = Damped(level=0.5)
    model = fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "y")})
    with pytest.raises(SimulationError, match="quadratic linearisation does not settle within 3 iterations.*'equival"):
        fw.response(model, frequencies=FINE, linearisation="quadratic")
