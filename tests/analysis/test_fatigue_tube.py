"""Stress around a tube against integrals over its section, and damage around it against waves with known cycles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.analysis.fatigue import TubeSection, sn_curve, tube_damage
from fowtlib.analysis.series import Series
from fowtlib.language.errors import ModelError

TOWER = TubeSection(6.5, 0.027)  # base of the OC3 tower


def test_a_rod_and_a_thin_ring():
    rod = TubeSection(2.0, 1.0)
    assert rod.area == pytest.approx(np.pi)
    assert rod.second_moment == pytest.approx(np.pi / 4)
    thin = TubeSection(6.0, 1e-6)
    assert thin.area == pytest.approx(np.pi * 6.0 * 1e-6, rel=1e-6)
    assert thin.second_moment == pytest.approx(np.pi * 3.0**3 * 1e-6, rel=1e-6)


def test_the_tower_of_the_oc3_spar():
    """Its table has EI 603.903e9 N m^2 and EA 115.302e9 N at the base, with E 210e9 Pa (Jonkman, 2010)."""
    assert 210e9 * TOWER.second_moment == pytest.approx(603.903e9, rel=2e-6)
    assert 210e9 * TOWER.area == pytest.approx(115.302e9, rel=4e-6)


@given(st.floats(-1e7, 1e7), st.floats(-1e8, 1e8), st.floats(-1e8, 1e8), st.floats(0.5, 10), st.floats(0.001, 0.5))
@settings(max_examples=60, deadline=None)
def test_the_stresses_carry_the_loads(force, about_x, about_y, diameter, part):
    """N, M_x and M_y come back from integrals of s, y s and -x s over the section."""
    section = TubeSection(diameter, part * diameter)
    a = 2 * np.pi * (np.arange(64) + 0.5) / 64
    nodes, weights = np.polynomial.legendre.leggauss(4)
    inner, outer = section.inner_diameter / 2, section.outer_radius
    r = inner + (outer - inner) * (nodes + 1) / 2
    area = np.outer(weights * (outer - inner) / 2 * r, np.full(64, 2 * np.pi / 64))
    at_rim = section.stress(force, about_x, about_y, a)
    stress = force / section.area + np.outer(r / outer, at_rim - force / section.area)  # plane sections stay plane
    x, y = np.outer(r, np.cos(a)), np.outer(r, np.sin(a))
    size = abs(force) * diameter + abs(about_x) + abs(about_y) + 1e-9
    assert np.sum(area * stress) == pytest.approx(force, abs=1e-9 * size / diameter)
    assert np.sum(area * stress * y) == pytest.approx(about_x, abs=1e-9 * size)
    assert np.sum(area * stress * -x) == pytest.approx(about_y, abs=1e-9 * size)


def test_thrust_pulls_on_the_upwind_side():
    moment = 80e6  # about y: of a rotor that the wind pushes along x
    upwind, downwind, port = TOWER.stress(0.0, 0.0, moment, np.radians([180, 0, 90]))
    assert upwind == pytest.approx(moment * 3.25 / TOWER.second_moment)
    assert downwind == pytest.approx(-upwind)
    assert port == pytest.approx(0.0, abs=1e-6)
    weight = TOWER.stress(-6e6, 0.0, 0.0, [0.0, 1.0])
    assert weight == pytest.approx([-6e6 / TOWER.area] * 2)  # compression all around


def waves(about_x=0.0, about_y=0.0, lag=0.0):
    """Moments of 200 cycles of 0.1 Hz, in N*m."""
    t = np.arange(0, 2000.01, 0.25)
    turn = 2 * np.pi * 0.1 * t
    return (t, about_x * np.cos(turn - lag)), (t, about_y * np.cos(turn))


def test_bending_about_one_axis():
    curve = sn_curve("D")
    found = tube_damage(TOWER, curve, *waves(about_y=50e6), points=8)
    stress = 2 * 50e6 * 3.25 / TOWER.second_moment
    assert found.worst == pytest.approx(200 / curve.endurance(stress), rel=1e-6)
    assert np.degrees(found.worst_angle) in (0.0, 180.0)
    assert found.damage[[0, 4]] == pytest.approx([found.worst] * 2)
    assert found.damage[[2, 6]] == pytest.approx([0.0, 0.0], abs=1e-20)
    assert found.damage[1] == pytest.approx(200 / curve.endurance(stress * np.sqrt(0.5)), rel=1e-6)
    assert found.duration == 2000.0
    assert found.life(2.0) == pytest.approx(2000.0 / found.worst / 2.0)


def test_bending_in_a_plane_between_the_axes_and_all_around():
    together = tube_damage(TOWER, sn_curve("D"), *waves(30e6, 30e6), points=8)
    assert np.degrees(together.worst_angle) in (135.0, 315.0)  # s = M R/I (sin a - cos a)
    around = tube_damage(TOWER, sn_curve("D"), *waves(30e6, 30e6, lag=np.pi / 2), points=8)
    np.testing.assert_allclose(around.damage[::2], around.worst, rtol=1e-2)
    assert around.damage.min() > 0.9 * around.worst


@given(st.floats(1e6, 1e8), st.floats(1e6, 1e8), st.floats(0, 6.3))
@settings(max_examples=20, deadline=None)
def test_opposite_points_and_mirrored_loads(about_x, about_y, lag):
    (t, one), (_, two) = waves(about_x, about_y, lag)
    found = tube_damage(TOWER, sn_curve("D"), (t, one), (t, two), points=12)
    np.testing.assert_allclose(found.damage, np.roll(found.damage, 6), rtol=1e-6, atol=1e-20)
    mirrored = tube_damage(TOWER, sn_curve("D"), (t, -one), (t, two), points=12)
    np.testing.assert_allclose(mirrored.damage, np.roll(found.damage[::-1], 1), rtol=1e-6, atol=1e-20)


def test_loads_with_units_axial_force_and_goodman():
    (t, side), (_, fore) = waves(10e6, 50e6)
    plain = tube_damage(TOWER, sn_curve("D"), (t, side), (t, fore))
    labelled = tube_damage(
        TOWER,
        sn_curve("D"),
        Series(t, side / 1e3, "kN m", "side"),
        Series(t, fore / 1e6, "MN m", "fore"),
        Series(t, np.full(t.size, -6e3), "kN", "weight"),
    )
    np.testing.assert_allclose(labelled.damage, plain.damage, rtol=1e-6, atol=1e-20)
    corrected = tube_damage(TOWER, sn_curve("D"), (t, side), (t, fore), (t, np.full(t.size, -6e6)), ultimate=500e6)
    assert corrected.worst > 1.05 * plain.worst
    late = tube_damage(TOWER, sn_curve("D"), (t, side), (t, fore), discard=1000.0)
    assert late.worst == pytest.approx(plain.worst / 2, rel=1e-6)


def test_the_rose(tmp_path):
    found = tube_damage(TOWER, sn_curve("D"), *waves(10e6, 50e6), points=12)
    axis = found.plot(tmp_path / "rose.png").axes[0]
    angles, share = axis.lines[0].get_data()
    assert share.max() == 1.0 and len(angles) == 13
    assert f"{found.worst:.3g}" in axis.get_title(loc="left")


def message(action) -> str:
    with pytest.raises(ModelError) as caught:
        action()
    return str(caught.value)


def test_errors():
    side, fore = waves(10e6, 50e6)
    curve = sn_curve("D")
    assert message(lambda: TubeSection(6.0, 4.0)) == (
        "a tube with an outer diameter of 6 m takes a wall above 0 m and at most of half of it, not of 4 m."
    )
    assert message(lambda: TubeSection(6.0, 0.0)).startswith("a tube with an outer diameter of 6 m takes a wall above")
    assert message(lambda: tube_damage(TOWER, curve, side, fore, points=0)) == (
        "damage is computed at 1, 2, 3 ... points around a tube, not at 0."
    )
    shorter = Series(fore[0][:-1], fore[1][:-1], "kN m", "fore-aft")
    assert message(lambda: tube_damage(TOWER, curve, side, shorter)) == (
        "fore-aft and the series have different points of time; take them from one run."
    )
    force = Series(fore[0], fore[1], "kN", "thrust")
    assert message(lambda: tube_damage(TOWER, curve, side, force)) == (
        "thrust is in kN; a tube takes moments, in N*m or a multiple of it."
    )
    gap = Series(fore[0], np.where(fore[0] == 10.0, np.nan, fore[1]), "N*m", "fore-aft")
    assert message(lambda: tube_damage(TOWER, curve, side, gap)) == (
        "fore-aft: the value at 10 s is not a finite number."
    )
