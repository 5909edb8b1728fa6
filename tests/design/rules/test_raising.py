"""Rules of a tower in a shaft: the numbers of C. Serret (2019), and levels of water worked out by its volume."""

import math

import pytest

from fowtlib.design import rules
from fowtlib.language.errors import ModelError

RHO, G = 1025.0, 9.80665


def test_printed_numbers():
    """800 t on 30 m of height: 5.76 m of diameter, which fits in the shaft of 7 m; a metre of stroke takes 38.5 m^3."""
    assert rules.flotation_diameter(8e5, 30.0) == pytest.approx(5.76, abs=0.005)
    assert rules.flotation_draft(8e5, rules.flotation_diameter(8e5, 30.0)) == pytest.approx(30.0)
    metre = rules.shaft_water(7.0, 6.5, 28.5, 11.0) - rules.shaft_water(7.0, 6.5, 28.5, 10.0)
    assert metre == pytest.approx(38.5, abs=0.02)


@pytest.mark.parametrize("diameter", [3.0, 6.5, 6.9])
def test_water_and_stiffness_follow_from_the_volume(diameter):
    """The level over the floor is (V + A_c s)/A_s with the cylinder dipped to s; its force is rho g A_c (level - s)."""
    shaft, cylinder = math.pi / 4 * 7.0**2, math.pi / 4 * diameter**2
    draft, stroke = 20.0, 12.0
    volume = rules.shaft_water(7.0, diameter, draft, stroke)

    def lift(s):
        level = (volume - cylinder * s) / (shaft - cylinder)
        return RHO * G * cylinder * (level - s)

    assert lift(stroke) == pytest.approx(RHO * G * cylinder * draft)
    slope = (lift(stroke - 1e-3) - lift(stroke + 1e-3)) / 2e-3
    assert rules.shaft_stiffness(7.0, diameter) == pytest.approx(slope, rel=1e-6)


def test_mistakes():
    with pytest.raises(ModelError, match="gap is -0.5"):
        rules.shaft_water(7.0, 7.5, 10.0, 1.0)
    with pytest.raises(ModelError, match="stroke is -1"):
        rules.shaft_water(7.0, 6.5, 10.0, -1.0)
