"""The OC3-Hywind spar (model oc3_spar_rigid) against published numbers. docs/verification.md has the tables.

[T] O. El Beshbichi, PhD thesis, University of Stavanger (2023): a Modelica model of the same physics, beside FAST.
Elsewhere: the spectrum of wave realisations in tests/environment/test_waves.py, the share of the K11 kernel that two
states hold in tests/hydro/test_radiation_identification.py, single lines in tests/mooring.
"""

import numpy as np
import pytest
import verification_cases as cases

import fowtlib as fw

# Natural frequencies [Hz]: the smaller and the larger of the Modelica model and FAST, [T] tables 2.7 and 3.2.
FREQUENCIES = {"surge": (0.0080, 0.0081), "heave": (0.0314, 0.032), "pitch": (0.034, 0.035), "yaw": (0.121, 0.122)}
NEAR = 0.02  # of the ends of these intervals
OFFSETS = {"surge": 10.0, "heave": 5.0, "pitch": 10.0, "yaw": 8.0}  # m or deg

# One line, fairlead 250 m above the seabed: distance [m], tensions H, V, T [kN], length on the seabed [m], by an
# independent solution of the elastic catenary (902.2 m, 698.09 N/m in water, EA 384.243 MN).
LINE = [
    (800, 179.1, 304.8, 353.5, 465.6), (820, 300.4, 367.6, 474.8, 375.6), (840, 546.9, 470.0, 721.1, 228.9),
    (848.67, 736.9, 535.7, 911.1, 134.8), (855, 933.9, 596.2, 1107.9, 48.2), (865, 1509.0, 756.8, 1688.1, 0),
    (880, 5353, 1837, 5660, 0),
]  # fmt: skip


@pytest.fixture(scope="module")
def calm():
    return cases.calm_plant("oc3_spar_rigid")


@pytest.fixture(scope="module")
def modes(calm):
    return cases.modes_by_motion(calm)


@pytest.fixture(scope="module")
def decays(calm):
    return cases.free_decays(calm, OFFSETS)


def within(value, interval):
    low, high = interval
    return (1 - NEAR) * low <= value <= (1 + NEAR) * high


@pytest.mark.parametrize("motion", FREQUENCIES)
def test_natural_frequencies_of_the_linear_model(modes, motion):
    assert within(modes[motion].frequency_hz, FREQUENCIES[motion])


@pytest.mark.parametrize("motion", FREQUENCIES)
def test_frequencies_of_free_decays(decays, motion):
    assert within(decays[motion].frequency, FREQUENCIES[motion])


def test_a_round_spar_moves_alike_across(modes):
    """Up to the centre of mass of rotor and nacelle, 0.41 m beside the axis."""
    for along, across in (("surge", "sway"), ("pitch", "roll")):
        assert modes[across].frequency_hz == pytest.approx(modes[along].frequency_hz, rel=1e-3)


def test_damping_of_free_decays_lies_near_fast(decays):
    """Decays from 10 m and 10 deg, [T] load case 2.3: surge FAST 0.097 and Modelica 0.143, pitch 0.063 and 0.088."""
    assert decays["surge"].damping_ratio == pytest.approx(0.097, rel=0.15)
    assert decays["pitch"].damping_ratio == pytest.approx(0.063, rel=0.15)


def test_surge_and_pitch_agree_with_an_independent_computation(modes):
    model = fw.load("oc3_spar_rigid")
    own = cases.surge_pitch(model)
    assert 1 / modes["surge"].frequency_hz == pytest.approx(own.surge_period, rel=5e-3)
    assert 1 / modes["pitch"].frequency_hz == pytest.approx(own.pitch_period, rel=5e-3)


def test_rest(calm):
    """The spar floats at the published waterline, and leans 0.06 deg against the wind, where its rotor is."""
    state = calm.equilibrium()
    assert abs(float(state["heave"])) < 0.01
    assert float(state["pitch"]) == pytest.approx(-0.063, abs=0.005)


@pytest.mark.parametrize(("distance", "H", "V", "T", "seabed"), LINE)
def test_catenary_table_through_the_model(calm, distance, H, V, T, seabed):
    line = cases.oc3_line_at(calm, distance)
    assert (line["H"], line["V"], line["T"]) == pytest.approx((H, V, T), rel=5e-3)
    assert line["seabed"] == pytest.approx(seabed, rel=5e-3, abs=0.1)


def test_heave_follows_long_waves():
    """A free spar would follow with 1; the lines hold it back: C33 / (C33 + K), with their heave stiffness K."""
    limit = cases.heave_limit()
    assert limit == pytest.approx(0.966, abs=1e-3)
    assert cases.oc3_rao([0.004]).amplitude("heave")[0] == pytest.approx(limit, rel=5e-3)


def test_linear_response_is_that_of_runs_in_regular_waves():
    """Without drag, waves of 1 m: amplitude and phase within 0.5 % of the operator; measured: 0.01 %."""
    frequencies = [0.02, 0.05, 0.1]
    linear, runs = cases.oc3_rao(frequencies), cases.oc3_rao_of_runs(frequencies)
    assert np.abs(runs.response / linear.response - 1).max() < 5e-3


def test_mean_surge_of_load_case_5_1():
    """8 m/s and regular waves of 6 m: codes in OC3 between 8.37 m and 15.10 m ([T] chapter 2)."""
    surge = cases.oc3_load_case_5_1()["surge"]
    assert 8.4 < surge.mean < 15.1
