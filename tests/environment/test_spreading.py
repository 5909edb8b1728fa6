"""Short-crested seas: how the energy is shared among directions, in a run and in the frequency domain."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import fowtlib as fw
from fowtlib.components.environment import JonswapSea
from fowtlib.components.environment.spreading import directions_of, spread_directions
from fowtlib.components.environment.waves import jonswap
from fowtlib.frequency import PreparedGradient
from fowtlib.language.errors import ParameterError
from fowtlib.modelfile.short_forms import WAVES, WIND

STORM = {"significant_wave_height": 4.0, "peak_period": 10.0}


def spread(exponent):
    """D of DNV-RP-C205 (2010), 3.5.8.7, a function of the angle [rad]."""
    factor = math.gamma(1 + exponent / 2) / (math.sqrt(math.pi) * math.gamma(0.5 + exponent / 2))
    return lambda angle: factor * math.cos(angle) ** exponent


@pytest.mark.parametrize("exponent", [1.0, 2.0, 4.5, 12.0])
@pytest.mark.parametrize(
    "of", [lambda a: 1.0, math.cos, lambda a: math.cos(a) ** 2, lambda a: math.cos(2 * math.sin(a))]
)
def test_nine_directions_stand_for_all(exponent, of):
    angles, shares = spread_directions(exponent, 9)
    D = spread(exponent)
    whole = quad(lambda angle: D(angle) * of(angle), -math.pi / 2, math.pi / 2, epsabs=1e-12)[0]
    # exact but for cos, which is no polynomial of the sine: 6e-4 at n = 1, 2e-5 at n = 2
    assert sum(shares * [of(angle) for angle in angles]) == pytest.approx(whole, rel=1e-3 if of is math.cos else 1e-10)


def sea(**given):
    top = fw.load("oc3_spar_rigid", set={"sea.spectrum": "jonswap"}).root
    top.sea = JonswapSea(**STORM, **given)
    return top.sea


def test_each_direction_has_its_share_of_each_band():
    waves = sea(spreading=4.0, random_amplitudes=False).components()
    angles, shares = spread_directions(4.0, 9)
    near = np.abs(waves.omega - 2 * np.pi / 10) < 0.1  # the band of the peak, 130 harmonics
    energy = waves.amplitude[near] ** 2
    for angle, share in zip(angles, shares, strict=True):
        assert energy[waves.directions[near] == angle].sum() / energy.sum() == pytest.approx(share, abs=0.03)
    along = np.sum(energy * np.cos(waves.directions[near]) ** 2) / energy.sum()
    assert along == pytest.approx(5 / 6, abs=0.01)  # (n + 1)/(n + 2)


def test_seeds_take_the_directions_in_another_order_and_the_phases_stay():
    one, two = (sea(seed=seed, spreading=4.0).components() for seed in (1, 2))
    long = sea(seed=1).components()
    assert np.any(one.directions != two.directions)
    assert np.array_equal(one.phase, long.phase) and np.array_equal(one.amplitude, long.amplitude)
    assert np.array_equal(directions_of(np.arange(50.0), 4.0, 9, 1), directions_of(np.arange(50.0), 4.0, 9, 1))


def test_kinematics_are_the_sum_of_the_harmonics():
    waves = sea(spreading=2.0, heading=0.4).components()
    point, t = np.array([[12.0, -30.0, -7.0]]), 20.0
    way = waves.heading + waves.directions
    angle = waves.omega * t + waves.phase - waves.wave_number * (12.0 * np.cos(way) - 30.0 * np.sin(way))
    elevation = np.sum(waves.amplitude * np.cos(angle))
    assert waves.evaluate(waves.elevation_transfer(point), t)[0, 0] == pytest.approx(elevation)
    k, h = waves.wave_number, waves.depth
    decay = waves.amplitude * waves.omega * np.cosh(k * (h - 7.0)) / np.sinh(k * h)
    wanted = [np.sum(decay * np.cos(angle) * np.cos(way)), np.sum(decay * np.cos(angle) * np.sin(way))]
    assert waves.evaluate(waves.velocity_transfer(point)[:, 0, :2], t)[0] == pytest.approx(wanted)


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid").compile()


CALM = {"wind.kind": "none", "sea.spectrum": "jonswap", "sea.significant_wave_height": 4.0, "sea.peak_period": 10.0}
MOTIONS = ["surge", "sway", "heave", "pitch", "roll"]


def test_what_is_alike_all_round_moves_by_the_mean_squares_of_cosine_and_sine(spar):
    """The spar answers alike to waves from all sides, but for its lines, which waves of 10 s hardly feel."""
    long, short = (fw.response(spar, outputs=MOTIONS, parameters=CALM | more) for more in ({}, {"sea.spreading": 4.0}))
    across = math.sqrt(1 / 6)  # 1/(n + 2); drag, which has both directions, changes it by less than 1e-3
    assert short.std("surge") == pytest.approx(math.sqrt(5 / 6) * long.std("surge"), rel=1e-3)
    assert short.std("sway") == pytest.approx(across * long.std("surge"), rel=2e-3)
    assert short.std("pitch") == pytest.approx(math.sqrt(5 / 6) * long.std("pitch"), rel=1e-3)
    assert short.std("roll") == pytest.approx(across * long.std("pitch"), rel=2e-3)
    assert short.std("heave") == pytest.approx(long.std("heave"), rel=1e-3)


def test_the_spectra_of_the_directions_add_up(spar):
    omega = np.linspace(0.2, 3.0, 50)
    found = sea(spreading=6.0, directions=5).spectral_density(omega)
    assert found.shape == (50, 5, 5)
    assert np.trace(found, axis1=1, axis2=2) == pytest.approx(jonswap(omega, 4.0, 10.0))


def test_the_response_is_that_of_a_run(spar):
    """One repetition of 1024 s; what the order of the directions leaves to chance is 1 % in sway and less elsewhere."""
    given = CALM | {"sea.spreading": 4.0, "sea.heading": 0.3, "sea.random_amplitudes": False, "sea.build_up": 50.0,
                    "sea.repetition_period": 1300.0}  # fmt: skip
    found = fw.response(spar, outputs=MOTIONS, parameters=given)
    run = spar.simulate(1300.0, 0.5, start="equilibrium", solver="fixed", parameters=given)
    for name in MOTIONS:
        assert np.asarray(run[name])[run.time > 276].std() == pytest.approx(found.std(name), rel=0.03)


def test_slopes_by_sizes_go_through_all_directions(spar):
    """Against differences of the values at the same frequencies; those of sizes go by the places of the strips."""
    given = {"wind.kind": "steady", "wind.mean_speed": 18.0, "sea.spectrum": "jonswap", "sea.peak_period": 10.5,
             "sea.significant_wave_height": 4.0, "sea.spreading": 4.0, "sea.directions": 5}  # fmt: skip
    by = ["platform.drag.drag_coefficient", "sea.spreading"]
    prepared = PreparedGradient(spar, ["std sway", "std pitch"], by=by, parameters=given)
    _, slopes = prepared.evaluate()
    for k, value in enumerate(prepared.start):
        step = 1e-4 * value * np.eye(2)[k]
        up, down = (prepared.values(prepared.start + side * step) for side in (1, -1))
        assert (up - down) / (2e-4 * value) == pytest.approx(slopes[:, k], rel=2e-6)


def test_the_words_of_the_command_line():
    assert WAVES.parse("jonswap:Hs=3,Tp=10,spreading=4")["sea.spreading"] == 4
    assert WIND.parse("turbulence:12,spectrum=von_karman")["wind.field_spectrum"] == "von_karman"
    with pytest.raises(ParameterError, match="spreading"):
        WAVES.parse("regular:H=3,T=10,spreading=4")
