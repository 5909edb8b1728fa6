"""Own cubics against SciPy's: Akima1DInterpolator, CubicSpline, RectBivariateSpline.

Bounds: rounding, 1e-11 of the largest number; measured up to 1e-12 where two random points lie close together.
"""

import subprocess
import sys

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator, CubicSpline, RectBivariateSpline

from fowtlib.language.cubics import CubicSurface, between, makima_slopes, not_a_knot_slopes
from fowtlib.language.errors import ParameterError


@pytest.mark.parametrize("n", [2, 3, 4, 5, 9, 40])
def test_curves(n):
    g = np.random.default_rng(n)
    x, y = np.sort(g.uniform(0, 3, n)), g.normal(size=(n, 2, 3))
    at = np.append(np.linspace(x[0], x[-1], 77), x)
    modified = between(x, y, makima_slopes(x, y), at)
    assert modified == pytest.approx(Akima1DInterpolator(x, y, method="makima")(at), abs=1e-11)
    if n > 3:
        spline = between(x, y, not_a_knot_slopes(x, y), at)
        assert np.abs(spline - CubicSpline(x, y)(at)).max() < 1e-11 * np.abs(spline).max()


def test_flat_pieces_and_jumps():
    x, y = np.arange(10.0), np.array([0, 0, 0, 0, 1, 1, 1, 2, 5, 5.0])
    at = np.linspace(0, 9, 200)
    values = between(x, y, makima_slopes(x, y), at)
    assert values == pytest.approx(Akima1DInterpolator(x, y, method="makima")(at), abs=1e-14)
    assert values[at < 3] == pytest.approx(0, abs=0)


@pytest.mark.parametrize("shape", [(4, 4), (7, 4), (20, 30)])
def test_surfaces(shape):
    g = np.random.default_rng(shape[1])
    x, y = (np.sort(g.uniform(0, 3, n)) for n in shape)
    table, a, b = g.normal(size=shape), g.uniform(x[0], x[-1], 60), g.uniform(y[0], y[-1], 60)
    surface, exact = CubicSurface(x, y, table), RectBivariateSpline(x, y, table)
    values = exact(a, b, grid=False)
    assert np.abs(surface(a, b) - values).max() < 1e-11 * np.abs(values).max()
    assert surface(a[0], b).shape == (60,) and float(surface(a[3], b[3])) == pytest.approx(values[3], rel=1e-9)
    assert surface(x, y[-1]) == pytest.approx(table[:, -1], abs=1e-12)


def test_a_cubic_is_itself():
    x = np.array([0.0, 0.1, 0.7, 1.5, 1.9])
    assert not_a_knot_slopes(x, x**3 - x) == pytest.approx(3 * x**2 - 1, abs=1e-12)


@pytest.mark.parametrize("x", [[0.0, 1.0, 1.0, 2.0], [0.0, 2.0, 1.0, 3.0], [0.0, 1.0, 2.0], [0.0, 1.0, 2.0, np.nan]])
def test_points_that_do_not_rise_are_refused(x):
    with pytest.raises(ParameterError, match="4 points or more, at values that rise"):
        not_a_knot_slopes(np.array(x), np.zeros(len(x)))


def test_they_are_there_without_scipys():
    text = "import sys, fowtlib.language.cubics; print('scipy.interpolate' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", text], capture_output=True, text=True).stdout == "False\n"
