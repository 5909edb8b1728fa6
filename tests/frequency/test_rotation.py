"""Loads of one blade from the response of the frame that does not turn."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.frequency.rotation import mirrored_spectrum, moved_spectrum, turned_spectra
from fowtlib.language.run_time import TurningRings
from fowtlib.solving.mean_linear import Turning
from fowtlib.solving.random_fields import FieldPlaces, density

FREQUENCY = np.sort(np.concatenate([np.geomspace(1e-4, 3.0, 400), np.linspace(0.05, 2.5, 400)]))


def band(low: float, high: float) -> np.ndarray:
    """A density of 1 between two frequencies."""
    return np.where((low < FREQUENCY) & (high > FREQUENCY), 1.0, 0.0)[None]


def mean_square(density: np.ndarray, low: float = 0.0, high: float = 9.0) -> float:
    inside = (low <= FREQUENCY) & (high >= FREQUENCY)
    return float(np.trapezoid(density[0][inside], FREQUENCY[inside]))


def test_moving_and_mirroring_keep_the_mean_square():
    density = band(0.3, 0.5)
    whole = mean_square(density)
    up, down = moved_spectrum(FREQUENCY, density, 0.2, 1), moved_spectrum(FREQUENCY, density, 0.2, -1)
    assert mean_square(up) == pytest.approx(whole, rel=1e-9)
    assert mean_square(up, 0.49, 0.71) == pytest.approx(whole, rel=1e-6)
    assert mean_square(down, 0.09, 0.31) == pytest.approx(whole, rel=1e-6)
    below, above = mirrored_spectrum(FREQUENCY, density, 0.4), moved_spectrum(FREQUENCY, density, 0.4, -1)
    assert mean_square(below) + mean_square(above) == pytest.approx(whole, rel=1e-3)  # each has its half of the band
    assert mean_square(below, 0.0, 0.1) == pytest.approx(whole / 2, rel=0.05)


def test_results_none_of_which_turns_have_nothing_to_move():
    """Also of a model with two rotors, where all results are of the blades of one."""
    nothing = np.zeros((0, len(FREQUENCY)))
    assert moved_spectrum(FREQUENCY, nothing, 0.2, 1).shape == nothing.shape
    assert mirrored_spectrum(FREQUENCY, nothing, 0.2).shape == nothing.shape


@pytest.mark.parametrize("speed", [1.4, -1.4])
@pytest.mark.parametrize("phase", [1j, -1j, 0.0])
def test_a_blade_has_the_spectrum_of_a_run(speed, phase):
    """A cosine and a sine part from one process, in quadrature or the cosine alone, against a periodogram."""
    f0, width, n, step = 0.45, 0.1, 2**16, 0.1
    density = band(f0 - width, f0 + width)[0]
    H = np.zeros((FREQUENCY.size, 2, 1), dtype=complex)
    H[:, 0], H[:, 1] = 1.0, phase
    turning = Turning("azimuth", speed, 0.0, (0,), slice(0, 1), slice(1, 2))
    found = turned_spectra(FREQUENCY, H, density[:, None, None], turning)
    random = np.random.default_rng(3)
    f = np.fft.rfftfreq(n, step)
    noise = np.where(np.abs(f - f0) < width, random.standard_normal(f.size) + 1j * random.standard_normal(f.size), 0.0)
    cosine, sine = (np.fft.irfft(noise * factor, n) for factor in (1.0, phase))
    time = step * np.arange(n)
    load = cosine * np.cos(speed * time) + sine * np.sin(speed * time)
    shares = np.abs(np.fft.rfft(load)) ** 2
    scale = 2 * width / np.sum(np.abs(noise) ** 2)
    shift = abs(speed) / (2 * np.pi)
    for centre in (f0 - shift, f0 + shift):
        low, high = centre - 1.2 * width, centre + 1.2 * width
        run = scale * shares[(f > low) & (f < high)].sum()
        assert mean_square(found, low, high) == pytest.approx(run, rel=0.03, abs=1e-4)
    assert mean_square(found) == pytest.approx(width * (1 + abs(phase) ** 2), rel=0.02)


class Gusts:
    """A field whose only spectrum is a Gaussian band about three times the speed of what turns in it."""

    WIDTH = 0.25  # rad/s; what three blades of 63 m meet in 8 m/s is as wide

    def density(self, component, omega, places, part, basis):
        ((speed,),) = [[one.speed for one in places]]
        band = np.exp(-(((omega - 3 * speed) / self.WIDTH) ** 2) / 2) / (self.WIDTH * np.sqrt(2 * np.pi))
        return band[:, None, None]


class Root:
    """Finds nothing that counts."""

    def find(self, owner):
        return None


@pytest.mark.parametrize("spread", [0.03, 0.09])  # 3 and 10 % of the speed
def test_a_speed_that_varies_widens_what_blades_meet(spread):
    """A band of the width w about 3 W, W Gaussian: sqrt(w^2 + 9 s^2), as two Gaussian numbers add."""
    rings = TurningRings(np.zeros(3), np.array([40.0]), 0.95, 3)
    omega = np.linspace(0.0, 6.0, 601)
    places = FieldPlaces("blades", "wind", Gusts(), 0, 0, None, rings, np.eye(3), 0, spread)
    width = np.hypot(Gusts.WIDTH, 3 * spread)
    wanted = np.exp(-(((omega - 3 * 0.95) / width) ** 2) / 2) / (width * np.sqrt(2 * np.pi))
    found = density([places], Root(), omega)[:, 0, 0]
    assert found == pytest.approx(wanted, abs=5e-3 * wanted.max())  # seven speeds
    steady = FieldPlaces("blades", "wind", Gusts(), 0, 0, None, rings, np.eye(3), 0)
    assert density([steady], Root(), omega)[:, 0, 0].max() > 1.05 * wanted.max()


@pytest.mark.long
def test_blade_moments_of_a_turbine_in_turbulence_are_those_of_a_run():
    given = {"wind.kind": "turbulence", "wind.mean_speed": 16.0, "wind.repetition_period": 700.0, "wind.seed": 4,
             "turbine.assembly.blade_hinges": 2}  # fmt: skip
    plant = fw.load("nrel5mw_land", set=given).compile()
    names = ["blade_root_flapwise_moment_1", "blade_root_edgewise_moment_1"]
    found = fw.response(plant, outputs=names)
    run = plant.simulate(700.0, 0.1, solver="fixed", start="turning")
    for name, size in zip(names, (0.12, 0.05), strict=True):
        values = run[name].values[run.time >= 100.0]
        assert found.std(name) == pytest.approx(values.std(), rel=size), name
        assert found.std(name, "rotation") < found.std(name)
    assert found.std(names[1], "rotation") > 0.9 * found.std(names[1])  # gravity
