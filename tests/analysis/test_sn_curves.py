"""S-N curves: the printed numbers of the practice, their two lines, thickness, and Miner's sum by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.analysis.fatigue import Cycles, SNCurve, rainflow_cycles, sn_curve, sn_curves
from fowtlib.analysis.series import Series
from fowtlib.language.errors import ModelError

ENVIRONMENTS = ("air", "cathodic protection", "free corrosion")
# "Fatigue limit at 10^7 cycles" [MPa], a column of table 2-1 of DNVGL-RP-C203 (2016) that the data file does not have
LIMITS = {
    "B1": 106.97, "B2": 93.59, "C": 73.10, "C1": 65.50, "C2": 58.48, "D": 52.63, "E": 46.78, "F": 41.52, "F1": 36.84,
    "F3": 32.75, "G": 29.24, "W1": 26.32, "W2": 23.39, "W3": 21.05, "T": 67.09,
}  # fmt: skip


def steady(stress_range: float, number: float, unit: str = "MPa") -> Cycles:
    return Cycles(np.array([stress_range]), np.zeros(1), np.array([number]), 600.0, unit, "stress")


@pytest.mark.parametrize("name", sn_curves("air"))
def test_every_curve_reaches_the_printed_limit_at_ten_million_cycles(name):
    for environment in ("air", "cathodic protection"):
        # intercepts have three decimals, that of T two
        assert sn_curve(name, environment).endurance(LIMITS[name] * 1e6) == pytest.approx(
            1e7, rel=0.013 if name == "T" else 0.003
        )


def test_every_curve_changes_its_slope_at_the_printed_number_of_cycles():
    for environment, cycles in (("air", 1e7), ("cathodic protection", 1e6)):
        for name in sn_curves(environment):
            curve = sn_curve(name, environment)
            wanted = 1.8e6 if (name, environment) == ("T", "cathodic protection") else cycles
            assert curve.endurance(curve.knee) == pytest.approx(wanted, rel=0.013 if name == "T" else 0.003)


def test_the_d_curve():
    """Intercept 12.164 with m 3 and 15.606 with m 5, knee at 52.63 MPa; protected 11.764, knee at 83.41 MPa."""
    air, sea, bare = (sn_curve("D", environment) for environment in ENVIRONMENTS)
    assert air.endurance(100e6) == pytest.approx(10**12.164 / 100**3, rel=1e-12)
    assert air.endurance(20e6) == pytest.approx(10**15.606 / 20**5, rel=1e-12)
    assert air.knee == pytest.approx(52.63e6, rel=1e-3)
    assert sea.endurance(100e6) == pytest.approx(10**11.764 / 100**3, rel=1e-12)
    assert sea.endurance(20e6) == air.endurance(20e6)
    assert sea.knee == pytest.approx(83.41e6, rel=1e-3)
    assert bare.endurance(20e6) == pytest.approx(10**11.687 / 20**3, rel=1e-12)
    assert bare.knee == 0.0
    assert np.isinf(air.endurance(0.0))


def test_curves_in_order_and_air_is_kindest():
    names = [name for name in sn_curves("free corrosion") if name != "T"]
    assert names == ["B1", "B2", "C", "C1", "C2", "D", "E", "F", "F1", "F3", "G", "W1", "W2", "W3"]
    ranges = np.geomspace(1e6, 1e9, 40)
    for environment in ENVIRONMENTS:
        lives = np.array([sn_curve(name, environment).endurance(60e6) for name in names])
        assert np.all(np.diff(lives) < 0)
    for name in names:
        air, sea, bare = (sn_curve(name, environment).endurance(ranges) for environment in ENVIRONMENTS)
        assert np.all(sea <= air * (1 + 1e-9))
        low = ranges < 50e6
        assert np.all(bare[low] < sea[low])


def test_thickness_and_concentration():
    curve = sn_curve("D")
    thick = sn_curve("D", thickness=0.060)
    assert thick.factor == pytest.approx((60 / 25) ** 0.2, rel=1e-12)
    assert thick.endurance(100e6) == pytest.approx(10**12.164 / (100 * 2.4**0.2) ** 3, rel=1e-12)
    assert thick.knee == pytest.approx(curve.knee / 2.4**0.2, rel=1e-12)
    assert sn_curve("D", thickness=0.020) == curve  # thinner walls gain nothing
    assert sn_curve("B1", thickness=0.1) == sn_curve("B1")  # no weld
    hot = sn_curve("D", thickness=0.060, concentration=1.5)
    assert hot.name == "D, air, 60 mm, stress x 1.5"
    assert hot.endurance(50e6) == pytest.approx(thick.endurance(75e6), rel=1e-12)
    assert sn_curve("T", thickness=0.032).factor == pytest.approx(2**0.25)  # the reference of joints is 16 mm
    assert sn_curve("T", thickness=0.032, concentration=12).factor == pytest.approx(12 * 2**0.30)


def test_damage_with_two_slopes_by_hand():
    """10^6 cycles of 80 MPa and 10^8 of 20 MPa on D in air."""
    cycles = Cycles(np.array([80.0, 20.0]), np.zeros(2), np.array([1e6, 1e8]), 1.0, "MPa")
    by_hand = 1e6 * 80**3 / 10**12.164 + 1e8 * 20**5 / 10**15.606
    assert sn_curve("D").damage(cycles) == pytest.approx(by_hand, rel=1e-12)
    assert sn_curve("D").damage(steady(52.63, 1e7)) == pytest.approx(1.0, rel=0.003)


@given(st.floats(0.1, 500), st.sampled_from(["Pa", "kPa", "N/m^2", "1", "GPa"]))
@settings(max_examples=40, deadline=None)
def test_stresses_in_any_unit(megapascals, unit):
    size = {"Pa": 1e6, "kPa": 1e3, "N/m^2": 1e6, "1": 1e6, "GPa": 1e-3}[unit]
    curve = sn_curve("E", "cathodic protection")
    assert curve.damage(steady(megapascals * size, 3.0, unit)) == pytest.approx(
        curve.damage(steady(megapascals, 3.0)), rel=1e-9
    )


@given(st.floats(1e3, 1e9), st.floats(1.0, 3.0), st.sampled_from(sn_curves("air")))
@settings(max_examples=60, deadline=None)
def test_larger_stresses_do_more_damage_between_the_two_slopes(stress, factor, name):
    curve = sn_curve(name)
    growth = curve.endurance(stress) / curve.endurance(stress * factor)
    assert factor**curve.m1 * (1 - 1e-9) <= growth <= factor**curve.m2 * (1 + 1e-9)


def test_a_curve_of_ones_own():
    mine = SNCurve(m1=4.0, log_a1=14.0, name="mine")
    assert mine.damage(steady(10.0, 1e5)) == pytest.approx(1e5 * 1e4 / 1e14)
    t = np.arange(0, 100.01, 0.1)
    stress = Series(t, 5e6 * np.cos(2 * np.pi * t), "Pa", "weld")
    assert mine.damage(rainflow_cycles(stress)) == pytest.approx(100 * 10.0**4 / 1e14, rel=1e-9)


def test_the_figure(tmp_path):
    figure = sn_curve("D").plot(tmp_path / "d.svg")
    assert (tmp_path / "d.svg").stat().st_size > 1000
    axis = figure.axes[0]
    cycles, ranges = axis.lines[0].get_data()
    np.testing.assert_allclose(cycles, sn_curve("D").endurance(ranges * 1e6))
    assert axis.get_legend().get_texts()[0].get_text() == "D, air"


def message(action) -> str:
    with pytest.raises(ModelError) as caught:
        action()
    return str(caught.value)


def test_errors():
    assert message(lambda: sn_curve("D", "water")) == (
        "there is no environment 'water' of S-N curves; there are 'air', 'cathodic protection' and 'free corrosion'."
    )
    assert message(lambda: sn_curve("F2")).startswith("there is no S-N curve 'F2' for air; did you mean 'F'")
    assert message(lambda: sn_curve("T", "free corrosion")).startswith(
        "there is no S-N curve 'T' for free corrosion; there are 'B1', 'B2', 'C',"
    )
    assert message(lambda: sn_curve("D", thickness=-1.0)) == ("D, air: the thickness of a wall is above 0 m, not -1 m.")
    assert message(lambda: sn_curve("D", concentration=0.0)) == (
        "D, air: a stress concentration factor is above 0, not 0."
    )
    assert message(lambda: SNCurve(5.0, 15.6, 3.0, 12.1)) == (
        "an S-N curve: the second slope must be larger than the first, 5; it is 3. "
        "The first line is that of large ranges."
    )
    assert (
        message(lambda: SNCurve(3.0, 12.1, 5.0))
        == "an S-N curve: the second line takes both m2 and log_a2, finite numbers."
    )
    assert message(lambda: SNCurve(3.0, 12.1, thickness_exponent=-0.1)) == (
        "an S-N curve: thicker walls are not better: thickness_exponent is 0 or above."
    )
    assert message(lambda: SNCurve(0.0, 12.1)).startswith(
        "an S-N curve: m1, factor and reference_thickness are above 0"
    )
    assert message(lambda: sn_curve("D").damage(steady(1.0, 1.0, "kN m"))) == (
        "stress is in kN m; an S-N curve takes stresses, in Pa or a multiple of it."
    )
    assert message(lambda: sn_curve("D").endurance([-1.0])) == "D, air: stress ranges are numbers of 0 Pa or more."
