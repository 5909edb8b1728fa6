"""Response operators from tests in waves: from the undisturbed part of regular runs, and from spectra with confidence.

Convention as in fowtlib.analysis.rao: elevation a cos(omega t) gives a |H| cos(omega t + phase).
Confidence of spectra: J. S. Bendat and A. G. Piersol (2010), Random Data, 4th ed., sections 9.2 and 11.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.analysis.rao import Rao
from fowtlib.analysis.series import Series, as_series
from fowtlib.components.environment.waves import wave_number
from fowtlib.language.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike

GRAVITY = 9.81
_STEADY = 0.05  # of the mean amplitude: a change from period to period that counts as steady
_FELT = 0.01  # of the largest density of the waves: below, a ratio of spectra is one of noise


@dataclass(frozen=True)
class RegularTest:
    """One run in regular waves: actual period and amplitude of the wave in the window, and the responses.

    response   complex, per unit of elevation; error: standard error of its amplitude, from what the harmonic leaves
    left       standard deviation of the elevation that is no harmonic of this period, over that of the harmonic
    """

    period: float
    amplitude: float
    window: tuple[float, float]
    outputs: tuple[str, ...]
    response: np.ndarray
    error: np.ndarray
    units: tuple[str, ...]
    left: float


def group_speed(period: float, depth: float, gravity: float = GRAVITY) -> float:
    """Speed [m/s] of the front of waves of this period [s]: omega/(2 k) (1 + 2 k h / sinh(2 k h)), linear theory."""
    omega = 2 * math.pi / period
    k = float(wave_number(np.array([omega]), depth, gravity)[0])
    turn = 2 * k * depth
    return omega / (2 * k) * (1 + (turn / math.sinh(turn) if turn < 500 else 0.0))


def undisturbed_window(
    period: float, depth: float, from_maker: float, to_beach: float, *, ramp: float = 0.0, gravity: float = GRAVITY
) -> tuple[float, float]:
    """Time [s] since the wave maker starts between the arrival of the full wave and of its first reflection.

    from_maker, to_beach: distances [m] of the model from the maker and from what reflects, along the waves; ramp [s]:
    time in which the maker comes to its full stroke. Fronts travel with the group speed.
    Raises ModelError where the reflection comes first.
    """
    speed = group_speed(period, depth, gravity)
    begin, end = from_maker / speed + ramp, (from_maker + 2 * to_beach) / speed
    if end - begin < 2 * period:
        raise ModelError(
            f"waves of {period:g} s are undisturbed for {max(end - begin, 0):.3g} s at the model, less than two "
            f"periods: their front travels at {speed:.3g} m/s; take a longer basin or a shorter ramp."
        )
    return begin, end


def steady_window(elevation: SeriesLike, period: float, *, discard: float = 0.0) -> tuple[float, float]:
    """The first part of a record of regular waves in which the amplitude stays the same from period to period, to 5 %.

    It ends where a reflection changes the amplitude; where one comes back in phase only `undisturbed_window` knows.
    Raises ModelError where no three periods are steady.
    """
    record = as_series(elevation).after(discard)
    count = max(int(round(period / record.step)), 4)
    whole = record.values.size // count
    time = record.time[: whole * count].reshape(whole, count)
    blocks = record.values[: whole * count].reshape(whole, count)
    turned = np.exp(-2j * math.pi / period * time)
    sizes = 2 * np.abs(((blocks - blocks.mean(axis=1, keepdims=True)) * turned).mean(axis=1))
    start = 0
    for i in range(whole + 1):
        of_it = sizes[start:i]
        if i < whole and sizes[i] < 0.5 * sizes.max():
            start = i + 1
        elif i == whole or (of_it.size and abs(sizes[i] - of_it.mean()) > _STEADY * of_it.mean()):
            if of_it.size >= 3:
                return float(time[start, 0]), float(time[i - 1, -1])
            start = i
    raise ModelError(
        f"{record.name}: no three periods of {period:g} s have the same amplitude to {100 * _STEADY:g} %; are these "
        "regular waves of this period? Else give the window."
    )


def regular_test(
    elevation: SeriesLike, responses: Mapping[str, SeriesLike], period: float, *,
    window: tuple[float, float] | None = None,
) -> RegularTest:  # fmt: skip
    """Response to one regular wave in a window of its record; None: in `steady_window`.

    ``period`` [s] is the one that was asked for; the actual one is that of the harmonic nearest to the elevation within
    10 % of it, and the responses are those of this harmonic, in whole periods.
    """
    begin, end = steady_window(elevation, period) if window is None else window
    wave = _between(as_series(elevation), begin, end)
    actual = _actual_period(wave, period)
    whole = math.floor((wave.time[-1] - wave.time[0]) / actual + 1e-9) * actual
    end = wave.time[0] + whole
    coefficient, left, _ = _harmonic(_between(wave, begin, end), actual)
    found = [_harmonic(_between(as_series(record, name), begin, end), actual) for name, record in responses.items()]
    size = abs(coefficient)
    per = tuple(f"{unit}/m" if "/" not in unit else f"({unit})/m" for unit in _units(responses))
    return RegularTest(
        actual, size, (float(begin), float(end)), tuple(responses),
        np.array([item[0] / coefficient for item in found]), np.array([item[2] / size for item in found]), per,
        left / (size / math.sqrt(2)),
    )  # fmt: skip


def rao_of_tests(tests: Sequence[RegularTest], heading: float = 0.0) -> Rao:
    """The response operator of several regular tests, over their actual frequencies."""
    if not tests:
        raise ModelError("there are no regular tests to make a response operator of.")
    first = tests[0]
    for test in tests:
        if test.outputs != first.outputs:
            raise ModelError(f"the tests have different responses: {first.outputs} and {test.outputs}.")
    ordered = sorted(tests, key=lambda test: -test.period)
    frequency = np.array([1 / test.period for test in ordered])
    response = np.array([test.response for test in ordered])
    return Rao(frequency, first.outputs, response, first.units, heading, "regular waves, actual periods")


@dataclass(frozen=True)
class SpectralRao:
    """Response operator from the spectra of one sea, where the waves have energy.

    response    S_xy / S_xx, complex (n, m): what follows the waves, without noise of the response
    ratio       sqrt(S_yy / S_xx) (n, m), which holds noise and other motions too
    coherence   gamma^2 (n, m): share of the response that follows the waves linearly
    averages    number of independent periodograms behind each value; it has 2 of them degrees of freedom
    """

    frequency: np.ndarray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    response: np.ndarray
    ratio: np.ndarray
    coherence: np.ndarray
    averages: float
    heading: float = 0.0

    @property
    def rao(self) -> Rao:
        """The linear part as a response operator."""
        return Rao(self.frequency, self.outputs, self.response, self.units, self.heading, "spectra")

    def radius(self, name: str, level: float = 0.95) -> np.ndarray:
        """Radius about the complex response within which the true one lies with this confidence, at each frequency.

        r^2 = 2/(n - 2) F(2, n - 2) (1 - gamma^2) S_yy / S_xx, n = 2 averages.
        """
        from scipy.stats import f

        if name not in self.outputs:
            raise ModelError(f"there is no response '{name}'{did_you_mean(name, self.outputs)}")
        column, n = self.outputs.index(name), 2 * self.averages
        if n <= 2:
            raise ModelError("one periodogram has no confidence: take shorter segments, or a longer record.")
        lost = np.maximum(1 - self.coherence[:, column], 0.0)
        return self.ratio[:, column] * np.sqrt(2 / (n - 2) * f.ppf(level, 2, n - 2) * lost)

    def interval(self, name: str, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper end of the amplitude."""
        radius, size = self.radius(name, level), np.abs(self.response[:, self.outputs.index(name)])
        return np.maximum(size - radius, 0.0), size + radius


def spectral_rao(
    elevation: SeriesLike, responses: Mapping[str, SeriesLike], *, segment: float, discard: float = 0.0,
    heading: float = 0.0, window: str = "hann",
) -> SpectralRao:  # fmt: skip
    """Response operator from a run in irregular waves, by Welch's average over half-overlapping segments.

    segment  length [s]: longer ones resolve resonances, shorter ones are more certain; 1/segment should be a quarter
             of the width of a peak (2 damping ratio x frequency) or less
    window   of scipy.signal; "boxcar" for seas that repeat themselves with the segment, where it is exact
    """
    from scipy import signal

    wave = as_series(elevation, "elevation").after(discard)
    step, count = wave.step, int(round(segment / wave.step))
    if count < 16 or count > wave.values.size:
        raise ModelError(
            f"{wave.name}: segments of {segment:g} s do not fit: the record has {wave.values.size * step:g} s in steps "
            f"of {step:g} s, a segment takes 16 steps or more."
        )
    motions = [as_series(record, name).after(discard) for name, record in responses.items()]
    for record in motions:
        if record.time.shape != wave.time.shape or np.abs(record.time - wave.time).max() > 1e-6 * step:
            raise ModelError(f"{record.name} and {wave.name} are not at the same times; interpolate one of them.")
    options = {"fs": 1 / step, "window": window, "nperseg": count, "detrend": "constant"}
    frequency, waves = signal.welch(wave.values, **options)
    felt = waves > _FELT * waves.max()
    felt[0] = False
    crossed = np.array([signal.csd(wave.values, record.values, **options)[1] for record in motions]).T[felt]
    powers = np.array([signal.welch(record.values, **options)[1] for record in motions]).T[felt]
    waves = waves[felt, None]
    segments = 1 + (wave.values.size - count) // max(count - count // 2, 1)
    averages = 18.0 * segments**2 / (19.0 * segments - 1.0)  # as power_spectrum has it
    coherence = np.abs(crossed) ** 2 / np.maximum(waves * powers, 1e-300)
    units = tuple(f"{unit}/m" if "/" not in unit else f"({unit})/m" for unit in _units(responses))
    return SpectralRao(
        frequency[felt], tuple(responses), units, crossed / waves, np.sqrt(powers / waves), coherence, averages, heading
    )


def _units(responses: Mapping[str, SeriesLike]) -> list[str]:
    return [as_series(record, name).unit for name, record in responses.items()]


def _between(record: Series, begin: float, end: float) -> Series:
    inside = (record.time >= begin - 1e-9) & (record.time <= end + 1e-9)
    if inside.sum() < 8:
        raise ModelError(f"{record.name}: there are fewer than 8 points between {begin:g} s and {end:g} s.")
    return Series(record.time[inside], record.values[inside], record.unit, record.name, record.long_name)


def _actual_period(record: Series, period: float) -> float:
    from scipy.optimize import minimize_scalar

    def left(candidate: float) -> float:
        return _harmonic(record, candidate)[1]

    tries = period * np.linspace(0.9, 1.1, 81)
    best = int(np.argmin([left(candidate) for candidate in tries]))
    if best in (0, tries.size - 1):
        raise ModelError(
            f"{record.name}: no wave within 10 % of a period of {period:g} s stands out between {record.time[0]:g} s "
            f"and {record.time[-1]:g} s."
        )
    found = minimize_scalar(left, bounds=(tries[best - 1], tries[best + 1]), method="bounded", options={"xatol": 1e-9})
    return float(found.x)


def _harmonic(record: Series, period: float) -> tuple[complex, float, float]:
    """Complex amplitude about the time 0 of the record, standard deviation of the rest, error of the amplitude."""
    angle = 2 * math.pi / period * record.time
    basis = np.column_stack([np.ones(angle.size), np.cos(angle), -np.sin(angle)])
    weights = np.linalg.lstsq(basis, record.values, rcond=None)[0]
    rest = record.values - basis @ weights
    error = math.sqrt(2 * float(rest @ rest) / max(rest.size - 3, 1) / rest.size)
    return complex(weights[1], weights[2]), float(rest.std()), error
