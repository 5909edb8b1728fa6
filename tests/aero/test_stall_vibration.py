"""A parked blade in a storm: its edgewise damping by formula, by the linear model and in time; its air as mass."""

import sys
from pathlib import Path

import numpy as np
import pytest

from fowtlib.language.native import compiler

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from stall_vibration import at, damping, decrement, edge_mode, parked_blade, quasi_steady_damping

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")


@pytest.fixture(scope="module")
def steady():
    return parked_blade("steady")


@pytest.fixture(scope="module")
def calm():
    """Almost without wind: what damps is the structure. With the added mass, and without."""
    return {added: parked_blade("steady", 0.01, added_mass=added) for added in (False, True)}


@pytest.mark.parametrize("angle", [-20.0, -8.0, 0.0, 8.0, 24.0, 44.0])
def test_linear_model_has_the_damping_of_the_formula(steady, calm, angle):
    """The rest is what the blade bends and twists away from rest, and what the mode has out of phase."""
    still, _ = edge_mode(calm[False], 0.0)
    assert damping(still) == pytest.approx(0.477, rel=0.02)  # of the definition of the blade
    value, shape = edge_mode(steady, angle)
    assert quasi_steady_damping(angle, shape, still) == pytest.approx(damping(value), rel=0.06, abs=0.07)


def test_in_time_as_by_the_linear_model(steady):
    for angle, expected in ((-8.0, 1.56), (16.0, -0.098)):
        assert damping(edge_mode(steady, angle)[0]) == pytest.approx(expected, rel=0.02)
        assert decrement(steady, angle, 24.0, 6.0) == pytest.approx(expected, rel=0.05)


def test_delay_of_separation_takes_the_instability_away(steady):
    """From 16 to 28 deg of the angle of attack, where the steady airfoils are negatively damped; the wake does not."""
    delayed, wake = parked_blade("beddoes_leishman"), parked_blade("attached")
    for angle in (16.0, 20.0, 24.0, 28.0):
        by_model = [damping(edge_mode(plant, angle)[0]) for plant in (steady, wake, delayed)]
        assert by_model[0] < 0
        assert by_model[1] < 0
        assert by_model[2] > 0.4


def test_added_mass_lowers_the_flapwise_frequency(calm):
    """By half of the air's share of the modal mass, which is greater at the tip than the 4 % of the whole blade."""
    found = []
    for plant in calm.values():
        modes = plant.linearize(plant.equilibrium(parameters=at(0.0)), outputs=[]).modes()
        found.append([mode.frequency_hz for mode in modes[:2]])
    flap, edge = np.array(found[1]) / found[0]
    assert 0.97 < flap < 0.98
    assert 0.999 < edge < 1
