"""Turbulence against the formulas of IEC 61400-1, and wind files with all that can be wrong in them."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.stats import chi2

from fowtlib.components.environment import iec, turbulence
from fowtlib.components.environment.iec import normal_turbulence, operating_gust
from fowtlib.components.environment.turbulence import (
    coherence,
    kaimal,
    kaimal_series,
    lost_variance,
)
from fowtlib.components.environment.waves import irregular_waves
from fowtlib.components.environment.wind_file import read_series
from fowtlib.language import ModelError

HUB = [(0.0, 90.0)]
TWO = [(-69.3, 90.0), (69.3, 90.0)]


@pytest.mark.parametrize(
    ("speed", "intensity"),
    [(5, 0.262), (8, 0.203), (10, 0.183), (11.4, 0.174), (14, 0.161), (18, 0.149), (25, 0.136), (50, 0.121)],
)
def test_intensity_of_class_b(speed, intensity):
    assert round(normal_turbulence(speed, "B") / speed, 3) == intensity


def test_classes_at_fifteen_metres_a_second():
    # Iref is the expected intensity at 15 m/s; the normal turbulence model takes its 90 % quantile, 12.3 % more
    for name, intensity in (("A", 0.16), ("B", 0.14), ("C", 0.12)):
        assert normal_turbulence(15, name) / 15 == pytest.approx(intensity * (0.75 + 5.6 / 15))


def test_kaimal_spectrum():
    # by hand for V = 11.4 m/s, sigma = 2 m/s, L = 340.2 m, f = 0.1 Hz
    assert float(kaimal(0.1, 11.4, 2.0)) == pytest.approx(4 * 4 * 29.8421 / 18.90526 ** (5 / 3), rel=1e-5)
    variance = quad(lambda f: float(kaimal(f, 11.4, 2.0)), 0, 1, limit=300)[0]
    assert variance == pytest.approx(4 * (1 - float(turbulence.kaimal_above(1.0, 11.4))), rel=1e-8)
    assert iec.turbulence_scale(30) == 21
    assert iec.turbulence_scale(90) == 42


def test_lost_variance_of_the_docstring():
    table = [line for line in turbulence.__doc__.splitlines() if re.match(r" +\d.*%", line)]
    rows = [re.findall(r"[\d.]+", line) for line in table]
    assert len(rows) == 4
    for speed, *percent in rows:
        computed = [*lost_variance(float(speed)), *lost_variance(float(speed), sample_step=0.5)]
        assert [round(100 * value, 1) for value in computed] == [float(value) for value in percent]


@pytest.mark.parametrize("speed", [5.0, 11.4, 25.0])
def test_variance_of_a_series_is_sigma_less_the_stated_loss(speed):
    sigma = normal_turbulence(speed)
    series = kaimal_series(HUB, speed, sigma)
    assert (len(series.values), series.step, series.end) == (16384, 0.25, 4096)
    assert series.values.mean() == pytest.approx(0, abs=1e-12)
    assert series.values.var() == pytest.approx(sigma**2 * (1 - sum(lost_variance(speed))), rel=1e-10)


def test_periodogram_of_the_first_station_is_the_kaimal_spectrum():
    """Deterministic amplitudes: every harmonic has the energy of its band, so no statistics are needed."""
    series = kaimal_series(HUB, 11.4, 2.0, seed=7).values[:, 0]
    density = 2 * np.abs(np.fft.rfft(series) / len(series)) ** 2 * 4096
    frequency = np.arange(len(density)) / 4096
    np.testing.assert_allclose(density[20:4097], kaimal(frequency[20:4097], 11.4, 2.0), rtol=1e-3)
    assert density[4098:].max() < 1e-20  # nothing above the cut-off 1/(4 dt) = 1 Hz


def test_spectrum_of_the_other_station_averages_to_kaimal():
    """The energy of a harmonic is |H21 e^(i a) + H22 e^(i b)|^2 here, with mean 1 and variance 2 H21^2 H22^2 <= 1/2.

    A mean over n values has a standard error of sqrt(1/(2 n)) at most; 4.4 of them are allowed (probability 1e-5).
    """
    seeds, target = 20, None
    energy = []
    for seed in range(seeds):
        series = kaimal_series(TWO, 11.4, 2.0, seed=seed).values[:, 1]
        energy.append(2 * np.abs(np.fft.rfft(series) / len(series))[20:4097] ** 2 * 4096)
    target = kaimal(np.arange(20, 4097) / 4096, 11.4, 2.0)
    for band in np.array_split(np.arange(len(target)), 25):
        ratio = np.mean(np.array(energy)[:, band] / target[band])
        assert ratio == pytest.approx(1, abs=1e-3 + 4.4 * math.sqrt(0.5 / (seeds * len(band))))


def test_coherence_between_two_stations():
    """Over N seeds and a band of n harmonics the cross spectrum averages to Coh, with an error below 1/sqrt(N n)."""
    seeds, distance = 60, 30.0
    cross = []
    for seed in range(seeds):
        first, second = np.fft.rfft(kaimal_series([(0, 90), (0, 120)], 11.4, 2.0, seed=seed).values, axis=0).T
        cross.append((first * second.conj())[1:400])
    frequency = np.arange(1, 400) / 4096
    first_power = np.abs(first[1:400]) ** 2
    for band in np.array_split(np.arange(399), 20):
        found = np.mean(np.array(cross)[:, band] / first_power[band])
        expected = np.mean(coherence(frequency[band], distance, 11.4))
        error = 4.4 / math.sqrt(seeds * len(band))
        assert found.real == pytest.approx(expected, abs=error)
        assert found.imag == pytest.approx(0, abs=error)


def test_coherence_by_the_formula():
    expected = math.exp(-12 * math.sqrt((0.05 * 138.6 / 11.4) ** 2 + (0.12 * 138.6 / 340.2) ** 2))
    assert float(coherence(0.05, 138.6, 11.4)) == pytest.approx(expected, rel=1e-12)
    assert coherence([0.0, 1.0], 0.0, 11.4).tolist() == [1, 1]


def test_stations_do_not_disturb_each_other():
    alone = kaimal_series(TWO[:1], 11.4, 2.0).values
    both = kaimal_series(TWO, 11.4, 2.0).values
    np.testing.assert_allclose(both[:, :1], alone, atol=1e-9)
    same = kaimal_series([(0, 90), (0, 90), (0, 90)], 11.4, 2.0).values
    np.testing.assert_allclose(same[:, 1:], same[:, :1].repeat(2, axis=1), atol=2e-5)


def test_seeds_of_the_wind():
    one, again, other = (kaimal_series(HUB, 11.4, 2.0, seed=seed).values[:, 0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    # sum over harmonics of p_k cos(phase difference): standard deviation sqrt(sum p^2 / 2), p the share of the energy
    share = 2 * np.abs(np.fft.rfft(one) / len(one)) ** 2 / one.var()
    assert abs(np.corrcoef(one, other)[0, 1]) < 4.4 * math.sqrt(np.sum(share**2) / 2)


def test_seeds_are_uncorrelated_on_average():
    """Phases are uniform: their mean resultant over n values has the chi-square distribution, 2 n R^2 ~ chi2(2)."""
    series = kaimal_series(HUB, 11.4, 2.0, seed=1).values[:, 0], kaimal_series(HUB, 11.4, 2.0, seed=2).values[:, 0]
    a, b = (np.angle(np.fft.rfft(s)[1:4097]) for s in series)
    for phase in (a, b, a - b):
        assert 2 * 4096 * abs(np.mean(np.exp(1j * phase))) ** 2 < chi2.ppf(1 - 1e-5, 2)


@pytest.mark.parametrize(("wind_period", "coherent"), [(1024.0, 0.0), (2048.0, math.pi / 4)])
def test_wind_and_sea_of_one_seed(wind_period, coherent):
    """Coherence squared of their harmonics at one frequency over seeds: that of chance with equal periods, 1/n.

    With a wind of twice the period it is what the docstring of irregular_waves warns of.
    """
    seeds = range(1, 121)
    waves = [irregular_waves(4.0, 10.0, 200.0, seed=seed, repetition_period=1024.0) for seed in seeds]
    sea = np.array([each.amplitude * np.exp(1j * each.phase) for each in waves])
    places = np.round(waves[0].omega * wind_period / (2 * math.pi)).astype(int)
    wind = np.array([
        np.fft.rfft(kaimal_series([[0, 90]], 15.0, 2.0, seed=seed, repetition_period=wind_period).values[:, 0])[places]
        for seed in seeds
    ])  # fmt: skip
    cross = np.abs((sea * wind.conj()).mean(axis=0)) ** 2
    found = np.mean(cross / (np.abs(sea) ** 2).mean(axis=0) / (np.abs(wind) ** 2).mean(axis=0))
    assert found == pytest.approx(coherent + (1 - coherent) / len(seeds), abs=0.02)


def test_a_spline_through_the_samples_follows_the_series():
    series = kaimal_series(HUB, 11.4, 2.0)
    value = np.append(series.values[:, 0], series.values[0, 0])
    spline = CubicSpline(np.append(series.time, series.end), value, bc_type="periodic")
    fine = np.fft.irfft(np.fft.rfft(series.values[:, 0]) * 4, 4 * 16384)
    time = np.arange(4 * 16384) / 16
    assert np.std(spline(time) - fine) < 1e-3 * np.std(fine)


def test_operating_gust():
    # V = 11.4 m/s, B: sigma = 1.981, 3.3 sigma / (1 + 0.1 * 126/42) = 5.029; at 25 m/s 8.654, and 1.35 (56 - 25) = 41.9
    assert operating_gust(11.4) == pytest.approx(3.3 * 1.981 / 1.3)
    assert operating_gust(25) == pytest.approx(3.3 * 3.409 / 1.3)
    assert operating_gust(54) == pytest.approx(1.35 * 2)
    assert operating_gust(60) == 0


def test_wrong_turbulence():
    with pytest.raises(ModelError, match=r"^turbulence needs a positive mean speed, got 0 m/s$"):
        kaimal_series(HUB, 0, 1)
    with pytest.raises(ModelError, match=r"^stations must be \(y, z\) pairs, got \[\(0, 0, 90\)\]$"):
        kaimal_series([(0, 0, 90)], 10, 1)
    with pytest.raises(ModelError, match=r"^repetition period 10 s holds too few samples of 1 s$"):
        kaimal_series(HUB, 10, 1, sample_step=1, repetition_period=10)


# --- files


def write(folder, text):
    path = folder / "wind.csv"
    path.write_text(text)
    return str(path)


def test_a_file_with_header_and_comments(tmp_path):
    path = write(tmp_path, "# met mast\ntime,left,right\n0,8,9\n\n0.5,8.5,9.5\n1,9,10\n1.5,9.5,10.5\n")
    series = read_series(path, 2)
    assert (series.start, series.step, series.end, series.periodic) == (0, 0.5, 1.5, False)
    np.testing.assert_array_equal(series.values, [[8, 9], [8.5, 9.5], [9, 10], [9.5, 10.5]])
    np.testing.assert_array_equal(series.time, [0, 0.5, 1, 1.5])


def test_one_column_serves_all_stations_and_rounded_times_pass(tmp_path):
    path = write(tmp_path, "0,8\n0.333,9\n0.667,10\n1.000,11\n1.333,12\n")
    np.testing.assert_array_equal(read_series(path, 3).values, np.repeat([[8], [9], [10], [11], [12]], 3, axis=1))


@pytest.mark.parametrize(
    ("text", "stations", "message"),
    [
        ("time,speed\n0,8\n1,calm\n", 1, "{path}:3: column 2 is 'calm', expected a number"),
        ("0,8\n1,nan\n", 1, "{path}:2: column 2 is 'nan', expected a number"),
        ("time,speed\nt,u\n0,8\n", 1, "{path}:2: column 1 is 't', expected a number"),
        ("0,8,9\n", 1, "{path}:1: 3 columns, expected 2, time and speed"),
        ("0,8,9\n", 3, "{path}:1: 3 columns, expected 4, time and the speed at every station"),
        ("0,8,9\n1,8\n", 2, "{path}:2: 2 columns, but line 1 has 3"),
        ("time;speed\n1;8\n", 1, "{path}:1: 1 column, expected time and speed, separated by commas"),
        ("0,8\n1,8\n", 1, "{path}: 2 lines of data, expected at least 4"),
        ("0,8\n1,8\n1,9\n2,9\n", 1, "{path}:3: time 1 s does not come after 1 s"),
        (
            "0,8\n1,8\n2,9\n4,9\n5,9\n",
            1,
            "{path}:4: time rises by 2 s here and by 1 s elsewhere; resample the series to equal steps",
        ),
    ],
)
def test_errors_of_a_file(tmp_path, text, stations, message):
    path = write(tmp_path, text)
    with pytest.raises(ModelError) as error:
        read_series(path, stations)
    assert str(error.value) == message.format(path=path)


def test_a_missing_file(tmp_path):
    with pytest.raises(ModelError) as error:
        read_series(str(tmp_path / "none.csv"), 1)
    assert str(error.value) == f"{tmp_path / 'none.csv'}: cannot read the wind file: No such file or directory"
