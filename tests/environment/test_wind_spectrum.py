"""The spectrum of turbulence stands beside its time functions: what one says of the other, and of what it drives."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import KaimalWind, World
from fowtlib.language import Scalar, der, eq, outer, param, var

LAG, PERIOD, STEP = 3.0, 256.0, 0.25
STATIONS = ((0.0, 90.0), (15.0, 90.0))


def kaimal(**more):
    given = {"mean_speed": 12.0, "turbulence_intensity": 0.15, "stations": STATIONS, "repetition_period": PERIOD}
    return KaimalWind(**given | more, sample_step=STEP)


def test_the_integral_is_the_variance():
    omega = np.geomspace(1e-5, 1e3, 20001)
    density = kaimal().spectral_density(omega)
    whole = np.trapezoid(density * omega[:, None, None], np.log(omega), axis=0)
    assert np.diag(whole) == pytest.approx([(0.15 * 12.0) ** 2] * 2, rel=5e-3)
    assert 0 < whole[0, 1] < whole[0, 0] and whole[0, 1] == whole[1, 0]


def test_realisations_have_it():
    """Mean of the periodograms of 80 realisations in bands: spectrum of each station, and cross-spectrum of the two."""
    n = round(PERIOD / STEP)
    omega = 2 * np.pi * np.arange(1, n // 4) / PERIOD
    found = np.zeros((omega.size, 2, 2))
    for seed in range(80):
        amplitude = np.fft.rfft(kaimal(seed=seed).turbulence().values, axis=0)[1 : n // 4] / n
        found += (amplitude[:, :, None] * amplitude[:, None, :].conj()).real / 80
    found *= 2 * PERIOD / (2 * np.pi)  # one-sided, per rad/s
    expected = kaimal().spectral_density(omega)
    for band in np.array_split(np.arange(2, omega.size), 8):
        largest = expected[band].mean(axis=0).max()
        assert found[band].mean(axis=0) == pytest.approx(expected[band].mean(axis=0), rel=0.08, abs=0.04 * largest)


class Thermometer(fw.Component):
    """Follows a signal with a lag: far from any wind turbine."""

    lag: Scalar = param(default=LAG, unit="s", doc="time constant")
    wind: KaimalWind = outer(KaimalWind)
    y: Scalar = var(unit="m/s", start=12.0, fixed=True, doc="what it shows")

    def equations(self):
        return [eq(self.lag * der(self.y), self.wind.speed[0] - self.y)]


def test_what_it_drives_has_the_variance_of_the_response_spectrum():
    """Variance of a lag in steady periodic motion: integral of S / (1 + (omega lag)^2)."""
    root = fw.Assembly()
    root.world, root.wind, root.thermometer = World(), kaimal(stations=STATIONS[:1]), Thermometer()
    result = fw.load(root).compile().simulate(2 * PERIOD, output_step=STEP)
    shown = np.asarray(result["thermometer.y"])[-round(PERIOD / STEP) :]  # the start is forgotten after 85 lags
    low, high = 2 * np.pi * 0.5 / PERIOD, 2 * np.pi / (4 * STEP)
    omega = np.geomspace(low, high, 4001)
    density = root.wind.spectral_density(omega)[:, 0, 0] / (1 + (omega * LAG) ** 2)
    assert shown.mean() == pytest.approx(12.0, abs=1e-3)
    assert shown.var() == pytest.approx(np.trapezoid(density, omega), rel=0.01)
