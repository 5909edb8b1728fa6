"""Fits of extremes against exact samples, Gaussian processes and published numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from fowtlib.analysis.case_statistics import case_statistics
from fowtlib.analysis.extremes import GaussianMaximum, Gumbel, block_maxima, fit_gumbel, gaussian_maximum
from fowtlib.analysis.peaks import Peaks, PeakTail, fit_peaks, peaks
from fowtlib.analysis.series import Series
from fowtlib.analysis.statistics import up_crossings
from fowtlib.analysis.tails import CrossingRates, CrossingTail, crossing_rates, fit_crossings, fit_rates, rates_of_case
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

HOUR = 3600.0
# Annual maxima of the sea level at Port Pirie, 1923-1987, m: Coles (2001), example 1.1, also in R's package ismev.
PORT_PIRIE = [
    4.03, 3.83, 3.65, 3.88, 4.01, 4.08, 4.18, 3.80, 4.36, 3.96, 3.98, 4.69, 3.85, 3.96, 3.85, 3.93, 3.75, 3.63, 3.57,
    4.25, 3.97, 4.05, 4.24, 4.22, 3.73, 4.37, 4.06, 3.71, 3.96, 4.06, 4.55, 3.79, 3.89, 4.11, 3.85, 3.86, 3.86, 4.21,
    4.01, 4.11, 4.24, 3.96, 4.21, 3.74, 3.85, 3.88, 3.66, 4.11, 3.71, 4.18, 3.90, 3.78, 3.91, 3.72, 4.00, 3.66, 3.62,
    4.33, 4.55, 3.75, 4.08, 3.90, 3.88, 3.94, 4.33,
]  # fmt: skip


def gaussian(seed: int, duration: float, step: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """A Gaussian process of mean 2, deviation 3 and mean crossing rate 0.1020 1/s."""
    rng, count = np.random.default_rng(seed), int(duration / step)
    f = np.fft.rfftfreq(count, step)
    density = np.exp(-0.5 * ((f - 0.1) / 0.02) ** 2)
    amplitude = np.sqrt(density / density.sum()) * count / 2
    values = np.fft.irfft(amplitude * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)), count)
    return np.arange(count) * step, 2.0 + 3.0 * values


EXACT = GaussianMaximum(2.0, 3.0, 0.1 * np.sqrt(1.04))


# -- Gumbel -----------------------------------------------------------------------------------------------------------


def test_the_moments_of_the_reference():
    maxima = [5.0, 6.0, 7.5, 6.2, 5.1, 9.0]
    fit = fit_gumbel(maxima, HOUR)
    scale = np.sqrt(6) * np.std(maxima, ddof=1) / np.pi
    assert fit.scale == pytest.approx(scale, rel=1e-12)
    assert fit.location == pytest.approx(np.mean(maxima) - 0.57722 * scale, rel=1e-5)
    assert fit.expected() == pytest.approx(np.mean(maxima))
    assert fit.std == pytest.approx(np.std(maxima, ddof=1))


def test_port_pirie():
    """Coles (2001), section 3.4.1: location 3.87 with a standard error of 0.03, scale 0.195 with 0.019."""
    fit = fit_gumbel(PORT_PIRIE, 1.0, method="likelihood")
    assert fit.location == pytest.approx(3.87, abs=0.005)
    assert fit.scale == pytest.approx(0.195, abs=0.0005)
    bounds = fit.bounds(1.0, count=200, parametric=True)  # of the value at 1/e, which is the location
    assert (bounds.high - bounds.low) / (2 * 1.96) == pytest.approx(0.03, abs=0.006)


@pytest.mark.parametrize("method", ["moments", "likelihood"])
@pytest.mark.parametrize("side", ["max", "min"])
def test_an_exact_sample_gives_its_parameters_back(method, side):
    sign = 1 if side == "max" else -1
    quantiles = (np.arange(20000) + 0.5) / 20000
    sample = sign * (10.0 - 2.0 * np.log(-np.log(quantiles)))
    fit = fit_gumbel(sample, 600.0, method=method, side=side)
    assert fit.location == pytest.approx(sign * 10.0, rel=1e-3)
    assert fit.scale == pytest.approx(2.0, rel=2e-3)
    assert fit.side == side


def test_a_longer_time_moves_the_location():
    """xi_p = mu + beta (ln(T / D) - ln(-ln p)): 50 years over 105 h are the exponent 4174, over 680 h 645."""
    fit = Gumbel(10.0, 2.0, 1.0)
    years = 50 * 365.25 * 24
    for hours, exponent in ((105.0, 4174), (680.0, 645)):
        assert round(years / hours) == exponent
        value = Gumbel(10.0, 2.0, hours).return_value(years, 0.5)
        assert value == pytest.approx(10.0 + 2.0 * (np.log(years / hours) - np.log(np.log(2.0))), rel=1e-12)
        assert fit.distribution(value, 1.0) ** exponent == pytest.approx(0.5, rel=2e-3)


def test_bounds_hold_the_truth_as_often_as_they_say():
    truth, held, rng = Gumbel(10.0, 2.0, HOUR), 0, np.random.default_rng(2)
    for seed in range(60):
        fit = fit_gumbel(rng.gumbel(10.0, 2.0, 40), HOUR, method="moments")
        bounds = fit.bounds(10 * HOUR, 0.9, confidence=0.9, count=150, seed=seed, parametric=True)
        held += bounds.low <= truth.return_value(10 * HOUR, 0.9) <= bounds.high
    assert 46 <= held <= 60  # 54 expected of a binomial number with deviation 2.3; small samples hold a little less


def test_equal_seeds_give_equal_bounds():
    fit = fit_gumbel(PORT_PIRIE, 1.0)
    one, same, other = (fit.bounds(100.0, count=100, seed=seed) for seed in (1, 1, 2))
    assert one == same != other
    assert one.low < one.value < one.high
    wide = fit.bounds(100.0, count=100, seed=1, confidence=0.99)
    assert wide.low < one.low < one.high < wide.high


@given(st.lists(st.floats(-1e3, 1e3), min_size=5, max_size=30), st.floats(0.1, 10.0), st.floats(-100.0, 100.0))
def test_units_and_sides_do_not_matter(values, factor, shift):
    if np.ptp(values) < 1e-3:
        return
    fit = fit_gumbel(values, 600.0)
    other = fit_gumbel(factor * np.array(values) + shift, 600.0)
    mirror = fit_gumbel(-np.array(values), 600.0, side="min")
    for duration, p in ((600.0, 0.5), (HOUR, 0.9), (100 * HOUR, 0.01)):
        value = fit.return_value(duration, p)
        assert other.return_value(duration, p) == pytest.approx(factor * value + shift, rel=1e-6, abs=1e-6)
        assert mirror.return_value(duration, p) == pytest.approx(-value, rel=1e-9, abs=1e-9)
        assert fit.distribution(value, duration) == pytest.approx(p, rel=1e-6)


def test_maxima_of_blocks():
    time = np.arange(0.0, 10.5, 0.5)  # 21 points, 10 s: blocks of [0, 3), [3, 6), [6, 9)
    values = np.arange(21.0)
    assert block_maxima((time, values), 3.0).tolist() == [5.0, 11.0, 17.0]
    assert block_maxima((time, values), 3.0, side="min").tolist() == [0.0, 6.0, 12.0]
    assert block_maxima((time, values), 4.0, discard=2.0).tolist() == [11.0, 19.0]
    assert block_maxima((time[:-1], values[:-1]), 5.0).tolist() == [9.0, 19.0]  # 20 points are two blocks of 5 s


# -- Gaussian processes -----------------------------------------------------------------------------------------------


# mean, deviation, extreme of one hour of the tower base moment [MN m] and of its zero up-crossing rate [Hz], which was
# worked out from them: Hegseth (2020), paper 1, tables 6 to 11
@pytest.mark.parametrize(
    ("mean", "std", "extreme", "rate"),
    [(260.8, 89.4, 575.7, 0.137), (127.8, 100.8, 491.7, 0.188), (52.3, 106.3, 415.4, 0.095),
     (101.3, 115.1, 491.3, 0.086), (329.4, 104.8, 699.3, 0.141), (66.5, 118.4, 469.9, 0.092)],
)  # fmt: skip
def test_extremes_of_one_hour(mean, std, extreme, rate):
    assert GaussianMaximum(mean, std, rate).return_value(HOUR) == pytest.approx(extreme, rel=1e-3)


def test_the_fractile_of_a_gaussian_maximum():
    process = GaussianMaximum(0.0, 1.0, 0.1)
    assert process.return_value(HOUR, 0.9) == pytest.approx(np.sqrt(2 * np.log(360 / np.log(1 / 0.9))), rel=1e-12)
    assert process.distribution(process.return_value(HOUR, 0.9), HOUR) == pytest.approx(0.9)


def test_maxima_of_a_gaussian_process():
    """The mean of 200 maxima of one hour lies within its own error of Cartwright and Longuet-Higgins' formula."""
    time, values = gaussian(1, 200 * HOUR)
    maxima = block_maxima((time, values), HOUR)
    assert maxima.size == 200
    spread = (
        3.0 * np.pi / np.sqrt(6.0) / np.sqrt(2 * np.log(0.102 * HOUR))
    )  # of a maximum of one hour: std pi/(sqrt(6) k)
    assert maxima.std(ddof=1) == pytest.approx(spread, rel=0.15)
    assert maxima.mean() == pytest.approx(EXACT.expected(HOUR), abs=3 * spread / np.sqrt(200))
    measured = gaussian_maximum((time, values))
    assert measured.mean_rate == pytest.approx(EXACT.mean_rate, rel=0.01)
    assert measured.return_value(HOUR) == pytest.approx(EXACT.return_value(HOUR), rel=0.02)
    bounds = measured.bounds(HOUR, count=50)
    assert bounds.low < EXACT.return_value(HOUR) < bounds.high


def test_every_method_finds_the_extreme_of_a_gaussian_process():
    """From 40 hours the value of 100 hours, and of minima its mirror image."""
    time, values = gaussian(3, 40 * HOUR)
    exact = EXACT.return_value(100 * HOUR)
    assert exact == pytest.approx(2.0 + 3.0 * 4.585, abs=0.01)
    for side, target in (("max", exact), ("min", 4.0 - exact)):
        fits = {
            "gumbel": fit_gumbel(block_maxima((time, values), 0.5 * HOUR, side=side), 0.5 * HOUR, side=side),
            "pareto": fit_peaks(peaks((time, values), 2.0 + (7.0 if side == "max" else -7.0), side=side)),
            "crossings": fit_crossings((time, values), side=side, pieces=20),
            "gaussian": gaussian_maximum((time, values), side=side),
        }
        for name, fit in fits.items():
            assert fit.return_value(100 * HOUR) == pytest.approx(target, abs=0.07 * 13.8), name
            assert fit.side == side
    process = fits["gaussian"]  # of this record; its deviation is 1.4 % below that of the process
    assert process.return_value(100 * HOUR) == pytest.approx(2.0 - values.std() * 4.585, abs=0.05)


def test_crossing_rates_of_a_gaussian_process_have_its_tail():
    rng_seeds = range(4)
    fit = fit_crossings([gaussian(seed, 50 * HOUR) for seed in rng_seeds])
    levels = np.linspace(8.0, 15.0, 8)
    np.testing.assert_allclose(np.log(fit.rate(levels)), np.log(EXACT.rate(levels)), atol=0.3)
    assert fit.return_value(100 * HOUR) == pytest.approx(EXACT.return_value(100 * HOUR), rel=0.02)
    bounds = fit.bounds(100 * HOUR, count=40)
    assert bounds.low < EXACT.return_value(100 * HOUR) < bounds.high
    assert bounds.high - bounds.low < 2.0


def test_the_statistics_of_a_case_hold_its_rates():
    """A fit from them is the fit from the series at the same levels."""
    time, values = gaussian(5, 10 * HOUR)
    told = case_statistics(Result(time, {"pitch": values}, {"pitch": "deg"}))
    for side, exact in (("max", EXACT.return_value(10 * HOUR)), ("min", 4.0 - EXACT.return_value(10 * HOUR))):
        rates = rates_of_case(told, "pitch", side=side)
        sign = 1 if side == "max" else -1
        counted = [up_crossings((time, sign * values), level=sign * level).count for level in rates.levels]
        assert rates.counts.tolist() == [counted]
        assert abs(rates.levels[0] - values.mean()) == pytest.approx(1.4 * values.std())
        assert fit_rates(rates, side=side).return_value(10 * HOUR) == pytest.approx(exact, abs=0.07 * 13.8)
    for name, words in (("roll", "no channel 'roll'"), ("pitch", "nothing lies beyond 9 standard")):
        with pytest.raises(ModelError, match=words):
            rates_of_case(told, name, threshold=9.0)


def test_exact_rates_give_their_parameters_back():
    """A series that passes each level exactly as often as q exp(-a (y - b)^c) says, in a time of 1e7 s."""
    levels = np.linspace(5.0, 9.0, 40)
    truth = CrossingTail(0.1, 0.3, 2.0, 1.6, 5.0)
    counts = truth.rate(levels) * 1e6
    rates = CrossingRates(levels, np.tile(counts, (10, 1)), np.full(10, 1e6), -4.0)
    fit = fit_rates(rates)
    np.testing.assert_allclose(np.log(fit.rate(levels)), np.log(truth.rate(levels)), atol=1e-5)
    for rate in (1e-4, 1e-7, 1e-10):
        assert fit.level(rate) == pytest.approx(truth.level(rate), rel=1e-4)
    assert (fit.b, fit.c) == pytest.approx((2.0, 1.6), rel=0.01)


def test_a_tail_that_bends_outward_is_said():
    """A mixture of a calm process and rare storms falls more and more slowly."""
    levels = np.linspace(3.0, 12.0, 40)
    counts = 1e6 * (np.exp(-(levels**2) / 2) + 1e-3 * np.exp(-(levels**2) / 200))
    with pytest.warns(UserWarning, match="surge: the power c of the tail lies at its least, 0.5"):
        fit_rates(CrossingRates(levels, np.tile(counts, (10, 1)), np.full(10, 1e6), -4.0), name="surge")


# -- peaks over a threshold -------------------------------------------------------------------------------------------


def test_peaks_are_one_per_passage_of_the_mean():
    values = np.array([0, 3, 2, 4, 0, -5, 0, 5, -1, 2.5, -1, -3, 0, 6, 6, 0, -9, -9, -9.0])
    found = peaks((np.arange(values.size) * 1.0, values), 2.0)
    assert values.mean() < 0
    assert found.values.tolist() == [4.0, 5.0, 2.5, 6.0]
    assert found.time.tolist() == [3.0, 7.0, 9.0, 13.0]
    assert peaks((found.time, np.zeros(4) + [0, 1, 0, 1])).values.size == 0
    merged = peaks((np.arange(values.size) * 1.0, values), 2.0, separation=5.0)
    assert merged.values.tolist() == [5.0, 6.0]
    below = peaks((np.arange(values.size) * 1.0, -values), -2.0, side="min")
    assert below.values.tolist() == [-4.0, -5.0, -2.5, -6.0]


@pytest.mark.parametrize("shape", [-0.4, -0.1, 0.0, 0.2, 0.5])
def test_pareto_is_fitted_as_by_scipy(shape):
    excess = stats.genpareto.rvs(shape, scale=2.0, size=300, random_state=4)
    fit = fit_peaks(Peaks(np.zeros(300), 10.0 + excess, 10.0, HOUR))
    best_shape, _, best_scale = stats.genpareto.fit(excess, floc=0.0)
    ours, theirs = (stats.genpareto.logpdf(excess, k, scale=s).sum()
                    for k, s in ((fit.shape, fit.scale), (best_shape, best_scale)))  # fmt: skip
    assert ours >= theirs - 1e-6
    assert fit.shape == pytest.approx(best_shape, abs=1e-3)
    assert fit.scale == pytest.approx(best_scale, rel=1e-3)
    assert fit.shape == pytest.approx(shape, abs=0.15)
    levels = np.array([11.0, 12.0, 13.0])
    expected = stats.genpareto.sf(levels - 10.0, fit.shape, scale=fit.scale) * 300 / HOUR
    np.testing.assert_allclose(fit.rate(levels), expected, rtol=1e-9)


def test_exponential_peaks():
    rng = np.random.default_rng(1)
    sample = Peaks(np.zeros(400), -(5.0 + rng.exponential(0.7, 400)), -5.0, 4 * HOUR, "min")
    fit = fit_peaks(sample, shape=0.0)
    assert (fit.shape, fit.scale) == (0.0, pytest.approx(0.7, rel=0.1))
    assert fit.return_value(HOUR) == pytest.approx(-5.0 - fit.scale * np.log(100.0))
    for parametric in (False, True):
        bounds = fit.bounds(100 * HOUR, count=100, parametric=parametric)
        assert bounds.low < -5.0 - 0.7 * np.log(10000.0) < bounds.high


def test_a_tail_with_an_end():
    tail = PeakTail(10.0, 2.0, -0.5, 0.01)
    assert tail.distribution([13.9, 14.0, 15.0], 1e9)[1:].tolist() == [1.0, 1.0]
    assert tail.return_value(1e12) == pytest.approx(14.0, abs=1e-3)


@given(
    st.floats(-0.6, 0.6), st.floats(0.1, 5), st.floats(1e-4, 0.1), st.floats(0.01, 0.99), st.sampled_from([1.0, -1.0])
)
def test_levels_and_rates_are_inverse(shape, scale, rate, p, sign):
    duration = 1e3 / rate
    for tail in (PeakTail(3.0, scale, shape, rate, sign=sign), Gumbel(3.0, scale, 600.0, sign=sign),
                 GaussianMaximum(3.0, scale, rate, sign=sign),
                 CrossingTail(rate, scale, 3.0, 1.0 + p, 3.0, sign=sign)):  # fmt: skip
        value = tail.return_value(duration, p)
        assert tail.distribution(value, duration) == pytest.approx(p, rel=1e-6)
        assert sign * tail.return_value(2 * duration, p) >= sign * value


def test_several_records_are_one_process():
    """Two halves of a record have the extremes of the whole, but for what lies at the cut."""
    time, values = gaussian(7, 20 * HOUR)
    half = time.size // 2
    parts = [(time[:half], values[:half]), (time[half:], values[half:])]
    assert block_maxima(parts, HOUR).tolist() == block_maxima((time, values), HOUR).tolist()
    whole, cut = peaks((time, values), 8.0), peaks(parts, 8.0)
    assert abs(whole.values.size - cut.values.size) <= 1
    assert cut.span == pytest.approx(whole.span, rel=1e-4)
    one, other = gaussian_maximum((time, values)), gaussian_maximum(parts)
    assert other.std == pytest.approx(one.std, rel=1e-12)
    assert other.mean_rate == pytest.approx(one.mean_rate, rel=2e-3)


# -- errors -----------------------------------------------------------------------------------------------------------

TIME = np.arange(1000.0)
SINE = np.sin(TIME)


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda: fit_gumbel([1.0, 2.0, 3.0], 600.0, name="surge"), "surge, maxima of blocks: there are 3, and a"),
        (lambda: fit_gumbel([1, 2, np.nan, 4, 5], 600.0), "number 3 of 5 is not a finite"),
        (lambda: fit_gumbel([2.0] * 9, 600.0, side="min"), "minima of blocks: all 9 are equal to 2; a constant has no"),
        (lambda: fit_gumbel([1, 2, 3, 4, 5], 600.0, method="guess"), "'moments' or by 'likelihood', not by 'guess'"),
        (lambda: fit_gumbel([1, 2, 3, 4, 5], 600.0, side="top"), "'max' or 'min', not 'top'"),
        (lambda: fit_gumbel([1, 2, 3, 4, 5], 0.0), "must be above 0, not 0 s"),
        (lambda: block_maxima((TIME, SINE), 2000.0), "has no block of 2000 s"),
        (lambda: block_maxima((TIME, SINE), 0.0), "has no block of 0 s"),
        (lambda: peaks((TIME, np.ones(1000))), "all 1000 are equal to 1"),
        (lambda: peaks((TIME, SINE), -0.5), "inner side of the mean"),
        (lambda: fit_peaks(peaks((TIME, SINE), 1.5)), "there are 0, and a fit takes 10 or more"),
        (lambda: crossing_rates((TIME, SINE), 1.5), "nothing lies beyond the threshold 1.5"),
        (lambda: crossing_rates([]), "no records"),
        (lambda: peaks([Series(TIME, SINE, "m"), Series(TIME, SINE, "cm")]), "different units: m, cm"),
        (lambda: fit_crossings((TIME[:50], SINE[:50])), "levels beyond .* are passed often enough"),
        (lambda: fit_crossings((TIME, np.where(TIME == 5, np.nan, SINE))), "the value at 5 s is not a finite"),
        (lambda: gaussian_maximum((TIME, np.ones(1000))), "a constant has no distribution"),
        (lambda: Gumbel(1.0, 1.0, 600.0).bounds(HOUR), "without the sample"),
        (lambda: Gumbel(1.0, 1.0, 600.0).return_value(HOUR, 1.0), "between 0 and 1"),
        (lambda: Gumbel(1.0, 1.0, 600.0).return_value(-1.0), "must be above 0"),
        (lambda: EXACT.return_value(1.0), "Take a longer duration"),
        (lambda: PeakTail(1.0, 1.0, 0.0, 0.001).return_value(600.0), "Lower the threshold"),
        (lambda: CrossingTail(0.1, 1.0, 0.0, 2.0, 3.0).return_value(60.0), "Lower the threshold"),
        (lambda: fit_gumbel([1, 1, 1, 1, 2], 600.0).bounds(HOUR), "samples of the bootstrap have no fit"),
        (lambda: fit_gumbel(PORT_PIRIE, 600.0).bounds(HOUR, count=3), "at least 20 samples"),
        (lambda: gaussian_maximum((TIME, SINE)).bounds(HOUR, parametric=True), "no parametric"),
    ],
)  # fmt: skip
def test_errors_are_sentences(action, words):
    with pytest.raises(ModelError, match=words) as caught:
        action()
    assert str(caught.value).endswith(".")
