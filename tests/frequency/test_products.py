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
from fowtlib.frequency.products import PRODUCTS, spectra_of_products
from fowtlib.language import Scalar, der, eq, var
from tests.frequency.test_equivalent import GRID, Filter, filtered

FINE = np.geomspace(2e-3, 9.0, 500)  # Hz


def test_the_spectrum_of_a_square_is_twice_that_of_the_covariance_squared():
    f = np.geomspace(1e-4, 30.0, 3000)
    lines, found = spectra_of_products(np.array([[[2.0]]]), f, (4 / (1 + (2 * np.pi * f) ** 2)).reshape(-1, 1, 1))
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
    lines, found = spectra_of_products(L.T @ forms @ L, f, cross)
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
    assert found.std("y", PRODUCTS) == pytest.approx(np.sqrt(2 / 3) * s**2, rel=0.02)  # frequencies end at 2e-3 and 9 Hz
    assert found.std("y") == pytest.approx(found.std("y", PRODUCTS), rel=1e-3)
    without = fw.response(squares(), outputs=["x", "y"], frequencies=FINE, linearisation="equivalent")
    assert without.std("y") < 0.02 * s**2


def test_a_product_of_two_has_their_covariances_beside_their_slopes():
    """E[z(t + tau) z(t)] of z = x late: R_xx R_ll + R_xl(tau) R_xl(-tau) = s^4 (1 + t)/2 e^-2t + s^4 (1 + 2 t)/4 e^-2t."""
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
