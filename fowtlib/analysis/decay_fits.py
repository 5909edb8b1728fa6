"""Damping from the record of a free decay, split into linear and quadratic, with confidence: of tests and of runs.

The motion is x'' + p1 x' + p2 |x'| x' + p3 (x - rest) = 0. Three ways lead to its numbers:

damped_sinusoid     x = rest + X exp(-zeta w t) cos(w_d t + phase), least squares over the whole record; p2 = 0
linear_quadratic    amplitudes of half cycles, 2/T ln(X_n-1 / X_n+1) = p1 + 16/3 X_n/T p2, a straight line (Faltinsen
                    1990, Sea Loads on Ships and Offshore Structures, section 7: equivalent linearisation)
decay_equation      the equation itself, integrated and fitted to the record; exact, also where damping is large

w = sqrt(p3); at an amplitude X the equivalent linear damping is p1 + 8/(3 pi) w X p2, and its ratio that over 2 w.
Errors take the residuals of neighbouring samples for independent. `correlation` says whether they are: near 1 the rest
is no noise but something that the equation does not have, and the errors are too small.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.estimates import Estimate, covariance_of, of_formula
from fowtlib.analysis.series import Series, as_series
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike

PER_QUADRATIC = 8.0 / (3.0 * math.pi)  # of |x'| x' over x', per amplitude of the velocity
_LEAST_CYCLES = 2.0
_LEAST_POINTS = 8  # of a period
_TURN = 0.07  # of the phase, rad, in a step of the integration
_NOISE = 5.0  # amplitudes that are smaller than so many of their errors are left out


@dataclass(frozen=True)
class DecayFit:
    """Numbers of the equation above, from one record; amplitudes in the unit of the record.

    natural_frequency   w = sqrt(p3), rad/s
    p1, p2              1/s, and 1/unit
    fitted              the motion of the equation at the times of the record (of a straight line: its half cycles)
    residual            standard deviation of what is left, in the unit of the record; correlation of neighbours
    begin               offset from rest and speed at the first time of the record, of decay_equation
    amplitude, rate     of linear_quadratic: the points (X_n, 2/T ln(X_n-1 / X_n+1)) of the line
    """

    method: str
    series: Series
    rest: float
    natural_frequency: Estimate
    p1: Estimate
    p2: Estimate
    covariance: np.ndarray  # of natural_frequency, p1, p2
    residual: float
    correlation: float
    fitted: np.ndarray
    amplitude: np.ndarray
    rate: np.ndarray
    begin: tuple[float, float] = (math.nan, math.nan)

    @property
    def damping_ratio(self) -> Estimate:
        """Linear part of the damping over the critical one, p1 / (2 w)."""
        return self.equivalent_damping_ratio(0.0)

    @property
    def period(self) -> Estimate:
        """Damped period of small motions, 2 pi / sqrt(w^2 - p1^2 / 4), s."""
        w, p1 = self.natural_frequency.value, self.p1.value
        squared = w**2 - p1**2 / 4
        period = 2 * math.pi / math.sqrt(squared)
        return self._estimate(period, period / squared * np.array([-w, p1 / 4, 0.0]))

    def equivalent_damping_ratio(self, amplitude: float) -> Estimate:
        """Damping ratio of the linear oscillator that loses as much energy in a cycle of this amplitude."""
        w, p1, p2 = self.natural_frequency.value, self.p1.value, self.p2.value
        gradient = np.array([-p1 / (2 * w**2), 1 / (2 * w), PER_QUADRATIC * amplitude / 2])
        return self._estimate(p1 / (2 * w) + PER_QUADRATIC * amplitude * p2 / 2, gradient)

    def equivalent_damping(self, amplitude: float, inertia: float) -> Estimate:
        """Damping B1 + 8/(3 pi) w X B2 of that oscillator; inertia: mass or moment of inertia with added mass."""
        w, p1, p2 = self.natural_frequency.value, self.p1.value, self.p2.value
        gradient = inertia * np.array([PER_QUADRATIC * amplitude * p2, 1.0, PER_QUADRATIC * w * amplitude])
        return self._estimate(inertia * (p1 + PER_QUADRATIC * w * amplitude * p2), gradient)

    def coefficients(self, inertia: float) -> tuple[Estimate, Estimate]:
        """B1 = p1 inertia and B2 = p2 inertia, of force over velocity and over its square."""
        return (self._estimate(self.p1.value * inertia, np.array([0.0, inertia, 0.0])),
                self._estimate(self.p2.value * inertia, np.array([0.0, 0.0, inertia])))  # fmt: skip

    def rows(self, amplitude: float) -> list[tuple[str, float, float, float, str]]:
        """Name, value, lower and upper end at 95 %, unit: of the numbers, and of the damping at this amplitude."""
        unit = self.series.unit
        told = (
            ("natural frequency", self.natural_frequency, "rad/s"), ("damped period", self.period, "s"),
            ("linear damping p1", self.p1, "1/s"), ("quadratic damping p2", self.p2, f"1/{unit}"),
            ("damping ratio, linear part", self.damping_ratio, "1"),
            (f"damping ratio at {amplitude:.4g} {unit}", self.equivalent_damping_ratio(amplitude), "1"),
        )  # fmt: skip
        return [(name, number.value, *number.interval(), in_unit) for name, number, in_unit in told]

    def _estimate(self, value: float, gradient: np.ndarray) -> Estimate:
        return Estimate(value, of_formula(gradient, self.covariance), self.p1.freedom)


def damped_sinusoid(series: SeriesLike, *, discard: float = 0.0, name: str = "") -> DecayFit:
    """The damped harmonic motion nearest to a record after ``discard`` seconds: the same damping in all cycles."""
    record = _record(series, discard, name)
    time = record.time - record.time[0]
    w, damping = _found(record, time)

    def left(values: np.ndarray) -> np.ndarray:
        return _projected(time, record.values, values[0], values[1])[1]

    w, damping = _least_squares(left, np.array([w, damping]), np.array([w, 0.1]), record).x
    if w <= 0 or abs(damping) >= 1:
        raise ModelError(f"{record.name}: no motion that swings and dies out is near to the record.")
    weights, rest = _projected(time, record.values, w, damping)
    jacobian = _sinusoid_jacobian(time, w, damping, weights)
    covariance = covariance_of(jacobian, rest)[:2, :2]
    turn = np.array([[1.0, 0.0], [2 * damping, 2 * w], [0.0, 0.0]])  # of w, p1, p2 by w, zeta
    fitted = record.values - rest
    return _fit("damped sinusoid", record, float(weights[0]), (w, 2 * damping * w, 0.0), turn @ covariance @ turn.T,
                rest, fitted, record.values.size - 5)  # fmt: skip


def linear_quadratic(series: SeriesLike, *, discard: float = 0.0, smallest: float = 0.02, name: str = "") -> DecayFit:
    """p1 and p2 from the amplitudes of half cycles by Faltinsen's straight line.

    Each amplitude is that of a harmonic fitted to its half cycle, so that noise does not make it larger. The points of
    the line share amplitudes, and small ones are less sure: the line is weighted with the covariance that follows.
    smallest: half cycles below this fraction of the first are left out.
    """
    whole = damped_sinusoid(series, discard=discard, name=name)
    record = whole.series
    when, amplitude, error = _half_cycles(record, whole)
    kept = (amplitude >= smallest * amplitude[:1].sum()) & (amplitude >= _NOISE * error)
    count = int(kept.size if kept.all() else np.argmin(kept))
    if count < 5:
        raise ModelError(
            f"{record.name}: {count} half cycles stand out of the rest, 5 are needed for a straight line; take a "
            "larger offset, or a record with less noise."
        )
    when, amplitude, error = when[:count], amplitude[:count], error[:count]
    cycle = when[2:] - when[:-2]
    logarithms = np.log(amplitude)
    rate = 2 / cycle * (logarithms[:-2] - logarithms[2:])
    basis = np.column_stack([np.ones(rate.size), 16 / 3 * amplitude[1:-1] / cycle])
    shares = np.zeros((rate.size, count))
    index = np.arange(rate.size)
    shares[index, index], shares[index, index + 2] = 2 / cycle, -2 / cycle
    spread = shares * (error / amplitude)
    lower = np.linalg.cholesky(spread @ spread.T)
    white, target = np.linalg.solve(lower, basis), np.linalg.solve(lower, rate)
    (p1, p2), *_ = np.linalg.lstsq(white, target, rcond=None)
    line = covariance_of(white, target - white @ np.array([p1, p2]))
    freedom = rate.size - 2
    swings = 2 * math.pi / cycle
    w = math.sqrt(float(swings.mean()) ** 2 + p1**2 / 4)
    covariance = np.zeros((3, 3))
    covariance[1:, 1:] = line
    covariance[0, 0] = float(swings.var(ddof=1)) / max(rate.size / 2, 1.0)  # a period in two is new
    rest = rate - basis @ np.array([p1, p2])
    fit = _fit("straight line", record, whole.rest, (w, p1, p2), covariance, rest, amplitude, freedom)
    return replace(fit, amplitude=amplitude[1:-1], rate=rate)


def decay_equation(series: SeriesLike, *, discard: float = 0.0, name: str = "") -> DecayFit:
    """p1, p2 and p3 of the equation whose solution is nearest to a record, with its rest and its start."""
    whole = damped_sinusoid(series, discard=discard, name=name)
    record = whole.series
    time = record.time - record.time[0]
    w, p1 = whole.natural_frequency.value, whole.p1.value
    swing = max(float(np.abs(whole.fitted - whole.rest).max()), 1e-300)
    begin = whole.fitted[0] - whole.rest
    speed = (whole.fitted[1] - whole.fitted[0]) / (time[1] - time[0])
    guess = np.array([whole.rest, begin, speed, w, p1, 0.0])
    sizes = np.array([swing, swing, swing * w, w, 0.05 * w, 0.05 / swing])

    solved: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def solution(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = values.tobytes()
        if key not in solved:
            solved.clear()
            solved[key] = _motion(time, values[1:])
        return solved[key]

    def left(values: np.ndarray) -> np.ndarray:
        return record.values - values[0] - solution(values)[0]

    def slopes(values: np.ndarray) -> np.ndarray:
        return -np.column_stack([np.ones(time.size), solution(values)[1]])

    best = _least_squares(left, guess, sizes, record, slopes)
    covariance = covariance_of(best.jac, best.fun)[3:, 3:]
    fitted = record.values - best.fun
    rest, numbers = float(best.x[0]), tuple(map(float, best.x[3:]))
    fit = _fit("equation", record, rest, numbers, covariance, best.fun, fitted, record.values.size - 6)
    return replace(fit, begin=(float(best.x[1]), float(best.x[2])))


METHODS: dict[str, Callable[..., DecayFit]] = {
    "sinusoid": damped_sinusoid, "line": linear_quadratic, "equation": decay_equation
}  # fmt: skip
"""The ways by the names that `fowt decay --fit` has for them."""


def _record(series: SeriesLike, discard: float, name: str) -> Series:
    record = as_series(series, name).after(discard)
    _ = record.step
    if np.ptp(record.values) <= 1e-12 * max(1.0, float(np.abs(record.values).max())):
        raise ModelError(f"decay of {record.name}: nothing moves.")
    return record


def _found(record: Series, time: np.ndarray) -> tuple[float, float]:
    """First guess of w and zeta: the largest line of the record, then the best of some dampings."""
    padded = 8 * time.size
    lines = np.abs(np.fft.rfft(record.values - record.values[-max(time.size // 3, 2) :].mean(), padded))
    frequency = np.fft.rfftfreq(padded, time[1])
    lowest = int(np.searchsorted(frequency, _LEAST_CYCLES / 2 / time[-1]))
    top = lowest + int(np.argmax(lines[lowest:]))
    w = 2 * math.pi * float(frequency[top])
    cycles = w * time[-1] / (2 * math.pi)
    if cycles < _LEAST_CYCLES or 2 * math.pi / w < _LEAST_POINTS * time[1]:
        raise ModelError(
            f"decay of {record.name}: {time[-1]:g} s in steps of {time[1]:g} s hold {cycles:.2g} periods of "
            f"{2 * math.pi / w:.3g} s; a fit takes {_LEAST_CYCLES:g} periods of {_LEAST_POINTS} steps at least. "
            "A motion that only creeps back has none."
        )
    tries = [(float(np.sum(_projected(time, record.values, w * f, z)[1] ** 2)), w * f, z)
             for f in (0.97, 0.985, 1.0, 1.015, 1.03) for z in (1e-3, 4e-3, 0.01, 0.03, 0.1, 0.25)]  # fmt: skip
    return min(tries)[1:]


def _basis(time: np.ndarray, w: float, damping: float) -> np.ndarray:
    faded = np.exp(-damping * w * time)
    turned = w * math.sqrt(max(1 - damping**2, 1e-12)) * time
    return np.column_stack([np.ones(time.size), faded * np.cos(turned), faded * np.sin(turned)])


def _projected(time: np.ndarray, values: np.ndarray, w: float, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Rest and both amplitudes that fit best with w and zeta, and what is left."""
    basis = _basis(time, w, damping)
    weights = np.linalg.lstsq(basis, values, rcond=None)[0]
    return weights, values - basis @ weights


def _sinusoid_jacobian(time: np.ndarray, w: float, damping: float, weights: np.ndarray) -> np.ndarray:
    """Derivatives of the damped sinusoid by w, zeta, rest and both amplitudes (n, 5)."""
    basis = _basis(time, w, damping)
    turn = math.sqrt(1 - damping**2)
    swing = basis[:, 1:] @ weights[1:]
    ahead = time * (basis[:, 1] * weights[2] - basis[:, 2] * weights[1])  # by the damped frequency
    by_w, by_damping = -damping * time * swing + turn * ahead, -w * time * swing - w * damping / turn * ahead
    return np.column_stack([by_w, by_damping, basis])


def _least_squares(
    left: Callable[..., np.ndarray], guess: np.ndarray, sizes: np.ndarray, record: Series, jacobian: Any = "3-point"
) -> Any:
    from scipy.optimize import least_squares

    best = least_squares(left, guess, jacobian, x_scale=np.abs(sizes), xtol=1e-10, ftol=1e-12, gtol=1e-14)
    if not best.success:
        raise ModelError(f"decay of {record.name}: the fit does not come to an end; is it one motion that dies out?")
    return best


def _half_cycles(record: Series, whole: DecayFit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, amplitude and error of amplitude of every half cycle, by a harmonic over a quarter period to both sides."""
    time, values = record.time, record.values - whole.rest
    w, damping = whole.natural_frequency.value, whole.damping_ratio.value
    swings = 2 * math.pi / whole.period.value
    weights, _ = _projected(time - time[0], record.values, w, damping)
    first = math.atan2(weights[2], weights[1]) / swings  # of an extremum
    half = math.pi / swings
    first -= half * math.floor(first / half + 0.05)
    found = []
    for centre in np.arange(time[0] + first, time[-1], half):
        for _ in range(3):  # the extremum, and then the half cycle round it
            inside = np.abs(time - centre) <= half / 2
            if inside.sum() < max(4, 0.45 * half / record.step):
                break
            after = time[inside] - centre
            faded = np.exp(-damping * w * after)
            basis = np.column_stack([faded * np.cos(swings * after), faded * np.sin(swings * after)])
            weights, *_ = np.linalg.lstsq(basis, values[inside], rcond=None)
            amplitude = float(np.hypot(*weights))
            shift = math.remainder(math.atan2(weights[1], weights[0]), math.pi) / swings
            centre += float(np.clip(shift, -half / 4, half / 4))
            error = math.sqrt(float(np.linalg.inv(basis.T @ basis)[0, 0]))
        else:
            left = values[inside] - basis @ weights
            found.append((centre, amplitude, error, float(left @ left), left.size - 2))
    if not found:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    when, amplitude, error, squares, freedom = np.array(found).T
    return when, amplitude, error * math.sqrt(max(squares.sum() / freedom.sum(), 1e-300))


def _motion(time: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solution of the equation about its rest (n,), and its derivatives by the numbers (n, 5).

    numbers: position and velocity at the start, w, p1, p2. Runge-Kutta steps of the fourth order, 90 to a cycle or
    more, and Hermite's cubic between them: their own damping ratio is 1e-8.
    """
    from scipy.interpolate import CubicHermiteSpline

    x, v, w, p1, p2 = map(float, numbers)
    count = max(math.ceil(abs(w) * time[-1] / _TURN), 8)
    grid = np.linspace(0.0, time[-1], count + 1)
    begin = np.concatenate([[x, v], np.eye(5)[0], np.eye(5)[1]])
    given = np.tile(np.array([[grid[1]], [w], [p1], [p2]]), count)
    states = np.column_stack([begin, np.asarray(_steps(count)(begin, given))]).T
    found = CubicHermiteSpline(grid, states[:, [0, *range(2, 7)]], states[:, [1, *range(7, 12)]])(time)
    return found[:, 0], found[:, 1:]


@lru_cache(maxsize=4)
def _steps(count: int) -> Any:
    """So many steps of the equation and its derivatives: (12,) and (4, count) to the states after each (12, count)."""
    import casadi as ca

    y, given = ca.SX.sym("y", 12), ca.SX.sym("given", 4)
    step, w, p1, p2 = ca.vertsplit(given)

    def rates(y: Any) -> Any:
        size = ca.fabs(y[1])
        pushed = ca.vertcat(0, 0, -2 * w * y[0], -y[1], -size * y[1])
        slope = -(p1 + 2 * p2 * size) * y[7:] - w**2 * y[2:7] + pushed
        return ca.vertcat(y[1], -(p1 + p2 * size) * y[1] - w**2 * y[0], y[7:], slope)

    k1 = rates(y)
    k2 = rates(y + step / 2 * k1)
    k3 = rates(y + step / 2 * k2)
    k4 = rates(y + step * k3)
    return ca.Function("step", [y, given], [y + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)]).mapaccum(count)


def _fit(method: str, record: Series, rest: float, numbers: tuple[float, float, float], covariance: np.ndarray,
         left: np.ndarray, fitted: np.ndarray, freedom: int) -> DecayFit:  # fmt: skip
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    w, p1, p2 = (Estimate(float(value), float(error), freedom) for value, error in zip(numbers, errors, strict=True))
    power = float(left @ left)
    neighbours = float(left[1:] @ left[:-1]) / power if power > 0 else 0.0
    none = np.zeros(0)
    return DecayFit(method, record, rest, w, p1, p2, covariance, float(left.std()), neighbours, fitted, none, none)
