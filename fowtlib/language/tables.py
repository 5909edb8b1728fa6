"""Look-up tables as smooth external functions: cubic splines, checked at their edges.

Outside of its range a table keeps the value of its edge, so that an iteration can look there, and an output point found
there stops the simulation with a message: nothing is extrapolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.equations import active, external
from fowtlib.language.errors import ParameterError


@dataclass(frozen=True)
class SplineData:
    """A cubic B-spline: knots of each argument, coefficients (the output runs fastest, then the first argument)."""

    knots: list[np.ndarray]
    coefficients: np.ndarray
    ranges: list[tuple[float, float]]
    uniform: bool = False
    periodic: bool = False


class SplineFunction(ca.Function):
    """A spline as a CasADi function that still knows its data, for engines that evaluate it themselves."""

    def __init__(self, function: ca.Function, data: SplineData):
        super().__init__(function)
        self.data = data


def table1d(
    u: Any, x_grid: Any, y_values: Any, *, name: str = "table", argument: str = "argument", smoothness: str = "c2"
) -> ca.SX:
    """Values of a table at `u`: y_values (n,) or (n, m) over the increasing x_grid (n,), as a column of m.

    smoothness "c2" is the cubic spline (not-a-knot), "c1" the monotone cubic of Fritsch and Carlson (1980), which does
    not overshoot.
    """
    x, y = _grid(x_grid, name), _values(y_values, 1, name)
    if len(x) != len(y):
        raise ParameterError(f"{name}: {len(x)} arguments and {len(y)} rows of values.")
    knots, coefficients = _monotone(x, y) if smoothness == "c1" else _interpolating(x, y)
    function = _spline(name, [knots], coefficients, [(x[0], x[-1])])
    active().check_range(u, x[0], x[-1], name, argument)
    return external(function, u)


def table2d(u: Any, v: Any, x_grid: Any, y_grid: Any, values: Any, *, name: str = "table",
            arguments: Sequence[str] = ("argument 1", "argument 2"), remedy: str = "") -> ca.SX:  # fmt: skip
    """Values of a table at (u, v): values (nx, ny) or (nx, ny, m), twice differentiable, as a column of m.

    A run that leaves the table stops there, and is told the remedy.
    """
    x, y, z = _grid(x_grid, name), _grid(y_grid, name), _values(values, 2, name)
    if z.shape[:2] != (len(x), len(y)):
        raise ParameterError(f"{name}: {len(x)} x {len(y)} arguments and {z.shape[0]} x {z.shape[1]} values.")
    knots_x, along_x = _interpolating(x, z)
    knots_y, along_y = _interpolating(y, np.moveaxis(along_x, 1, 0))
    function = _spline(name, [knots_x, knots_y], np.moveaxis(along_y, 0, 1), [(x[0], x[-1]), (y[0], y[-1])])
    for value, grid, argument in ((u, x, arguments[0]), (v, y, arguments[1])):
        left = f"table left at its edge: {name} at {argument} = {{value}}, and the table covers "
        told = f"{left}{grid[0]:g} to {grid[-1]:g}; {remedy}." if remedy else ""
        active().check_range(value, grid[0], grid[-1], name, argument, told)
    return external(function, ca.vertcat(u, v))


def time_series(
    t: Any, t0: float, dt: float, values: Any, *, periodic: bool = False, name: str = "time series"
) -> ca.SX:
    """Samples (n,) or (n, m) at t0, t0 + dt, ... as a twice differentiable function of time, a column of m.

    A periodic series repeats after n dt; any other must cover the simulation.
    """
    samples = _values(values, 1, name)
    n = len(samples)
    if n < 4:
        raise ParameterError(f"{name}: a time series needs 4 samples or more, and {n} are given.")
    coefficients = cardinal_periodic(samples) if periodic else cardinal(samples)
    knots = t0 + dt * np.arange(-3, len(coefficients) + 1)
    end = t0 + dt * (n if periodic else n - 1)
    time = ca.MX.sym("t")
    inside = t0 + ca.fmod(time - t0, end - t0) if periodic else ca.fmin(ca.fmax(time, t0), end)
    flat = _flat(coefficients)
    value = ca.bspline(inside, flat, [list(knots)], [3], coefficients.shape[1], {"lookup_mode": ["exact"]})
    plain = ca.Function(_identifier(name), [time], [value], ["t"], ["value"])
    function = SplineFunction(plain, SplineData([knots], np.array(flat), [(t0, end)], uniform=True, periodic=periodic))
    if not periodic:
        active().check_range(t, t0, end, name, "time")
    return external(function, t)


def _grid(values: Any, name: str) -> np.ndarray:
    grid = np.asarray(values, dtype=float)
    if grid.ndim != 1 or len(grid) < 4:
        raise ParameterError(f"{name}: the arguments of a table are one column of 4 values or more.")
    if not np.all(np.isfinite(grid)) or not np.all(np.diff(grid) > 0):
        raise ParameterError(f"{name}: the arguments of a table must be finite and increase.")
    return grid


def _values(values: Any, dimensions: int, name: str) -> np.ndarray:
    array = np.asarray(values, dtype=float)
    if array.ndim == dimensions:
        array = array[..., None]
    if array.ndim != dimensions + 1:
        raise ParameterError(f"{name}: values of shape {array.shape} do not fit a table of {dimensions} arguments.")
    if not np.all(np.isfinite(array)):
        raise ParameterError(f"{name}: the values of a table must be finite numbers.")
    return array


def _interpolating(x: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(x, values, k=3, axis=0)
    return spline.t, spline.c


def _monotone(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cubic Hermite spline as a B-spline with double knots; its coefficients are the Bezier points beside the data."""
    from scipy.interpolate import PchipInterpolator

    slope = PchipInterpolator(x, y, axis=0).derivative()(x)
    third = np.diff(x)[:, None] / 3
    inner = np.stack([y[:-1] + slope[:-1] * third, y[1:] - slope[1:] * third], axis=1).reshape(-1, y.shape[1])
    knots = np.concatenate([[x[0]] * 4, np.repeat(x[1:-1], 2), [x[-1]] * 4])
    return knots, np.concatenate([y[:1], inner, y[-1:]])


def cardinal(samples: np.ndarray) -> np.ndarray:
    """Coefficients c of the uniform cubic B-spline: (c[j-1] + 4 c[j] + c[j+1]) / 6 = sample; no end curvature."""
    from scipy.linalg import solve_banded

    n = len(samples)
    bands = np.zeros((3, n))
    bands[0, 1:] = bands[2, :-1] = 1 / 6
    bands[1] = 4 / 6
    bands[1, [0, -1]] = 1.0
    bands[0, 1] = bands[2, -2] = 0.0
    inner = solve_banded((1, 1), bands, samples)
    return np.concatenate([[2 * inner[0] - inner[1]], inner, [2 * inner[-1] - inner[-2]]])


def cardinal_periodic(samples: np.ndarray) -> np.ndarray:
    """The same of samples that repeat themselves, with one coefficient before them and two behind."""
    return cardinal_of_spectrum(np.fft.rfft(samples.T, axis=1), len(samples))


def cardinal_of_spectrum(spectrum: np.ndarray, n: int) -> np.ndarray:
    """The same of n samples given by their discrete Fourier transforms (m, n // 2 + 1): (n + 3, m)."""
    kernel = (4 + 2 * np.cos(2 * np.pi * np.arange(n // 2 + 1) / n)) / 6
    inner = np.fft.irfft(spectrum / kernel, n, axis=1)
    return np.concatenate([inner[:, -1:], inner, inner[:, :2]], axis=1).T


def _spline(
    name: str, knots: list[np.ndarray], coefficients: np.ndarray, ranges: list[tuple[float, float]]
) -> SplineFunction:
    argument = ca.MX.sym("argument", len(knots))
    inside = ca.vertcat(*[ca.fmin(ca.fmax(argument[i], low), high) for i, (low, high) in enumerate(ranges)])
    outputs = coefficients.shape[-1]
    flat = _flat(coefficients)
    value = ca.bspline(inside, flat, [list(k) for k in knots], [3] * len(knots), outputs)
    plain = ca.Function(_identifier(name), [argument], [value], ["argument"], ["value"])
    return SplineFunction(plain, SplineData(knots, np.array(flat), ranges))


def _flat(coefficients: np.ndarray) -> list[float]:
    """CasADi's order: the output runs fastest, then the first argument. CasADi takes a list faster than an array."""
    return np.moveaxis(coefficients, -1, 0).ravel(order="F").tolist()


def _identifier(name: str) -> str:
    """A name CasADi accepts: letters, digits, single underscores, a letter first."""
    words = "".join(character if character.isalnum() and character.isascii() else " " for character in name).split()
    text = "_".join(words) or "table"
    return text if text[0].isalpha() else f"table_{text}"
