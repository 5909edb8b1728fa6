"""Reader of rotor coefficients, its messages, and the continued table."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import fowtlib.models
from fowtlib.components.aero import BladeElementRotor, coefficient_table, read_blade, read_coefficients
from fowtlib.language.errors import ModelError

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"
CSV, WHOLE = str(DATA / "rotor_coefficients.csv"), str(DATA / "rotor_coefficients_whole.csv")
HEADER = "tip_speed_ratio,blade_pitch_deg,thrust_coefficient,torque_coefficient"


def small(path, header=HEADER, leave_out=None, replace=None):
    rows = [f"{a},{b},{0.1 * a},{0.01 * b}" for a in (1, 2, 3, 4) for b in (0, 5, 10, 15)]
    if leave_out is not None:
        del rows[leave_out]
    if replace is not None:
        rows[2] = replace
    path.write_text("\n".join(["# a comment", header, *rows]) + "\n")
    return str(path)


def test_shipped_table():
    table = read_coefficients(CSV)
    assert table.values.shape == (26, 36, 2)
    assert (table.tip_speed_ratio[[0, -1]] == [2, 14.5]).all()
    assert np.degrees(table.blade_pitch[[0, -1]]) == pytest.approx([-5, 30])
    thrust, torque = table(7.0, 0.0)
    assert (float(thrust), float(torque)) == (pytest.approx(0.741, abs=1e-3), pytest.approx(0.0661, abs=1e-4))


def test_spline_passes_through_the_table():
    table = read_coefficients(CSV)
    thrust, torque = table(table.tip_speed_ratio[:, None], table.blade_pitch[None, :])
    assert thrust == pytest.approx(table.thrust, abs=1e-9)
    assert torque == pytest.approx(table.torque, abs=1e-9)


def test_best_power_coefficient():
    """The table has 0.466 at 7.5; the definition of the turbine (NREL/TP-500-38060, table 7-2) 0.482 at 7.55."""
    table = read_coefficients(CSV)
    power = table.torque * table.tip_speed_ratio[:, None] * np.cos(np.radians(2.5))
    row, column = np.unravel_index(power.argmax(), power.shape)
    assert power.max() == pytest.approx(0.482, rel=0.04)
    assert table.tip_speed_ratio[row] == pytest.approx(7.55, abs=0.25)
    assert table.blade_pitch[column] == 0


def test_rows_in_any_order_and_other_columns(tmp_path):
    header, *rows = Path(small(tmp_path / "a.csv")).read_text().splitlines()[1:]
    shuffled = [row + ",9" for row in rows[::-1]]
    (tmp_path / "b.csv").write_text("\n".join([header + ",other", *shuffled]))
    first, second = (read_coefficients(str(tmp_path / name)) for name in ("a.csv", "b.csv"))
    assert (first.values == second.values).all()


def test_continued_table():
    """Inside unchanged; above it follows blade element theory; elsewhere it ends, and says so."""
    table, wide = read_coefficients(CSV), read_coefficients(CSV, extended=True)
    tips, pitches = np.meshgrid(np.linspace(3, 14.5, 20), np.radians(np.linspace(-5, 28, 20)))
    assert np.abs(np.array(wide(tips, pitches)) - table(tips, pitches)).max() < 2e-3
    with pytest.raises(
        ModelError, match=r"cover tip speed ratio 2 to 25, and not 0\.2; give a table that covers the st"
    ):
        wide(0.2, 0.0)
    with pytest.raises(ModelError, match=r"cover blade pitch \[deg\] -5 to 30, and not 90; give a table"):
        wide([3.0, 3.0], np.radians([0, 90]))
    speeds = np.linspace(14.5, 22, 30)
    thrust, torque = wide(speeds, 0.0)
    assert np.all(np.abs(np.diff(thrust)) < 0.02) and np.all(np.diff(torque) < 0)
    assert 0 < np.interp(0, -torque, speeds) - 17.5 < 1.5  # the speed of a rotor that nothing brakes


@pytest.mark.parametrize(
    ("wind", "speed", "pitch"), [(50, 0, 90), (40, 0.05, 82), (25, 0, 90), (8, 0, 0), (50, -0.1, 85), (30, 0.2, 55)]
)
def test_parked_and_idling_rotors(wind, speed, pitch):
    """The whole table against the polars without induction, within 3 % of the largest of all pitches at standstill."""
    whole, radius = read_coefficients(WHOLE), 63 * np.cos(np.radians(2.5))
    pressure = 0.5 * 1.225 * np.pi * radius**2 * wind**2
    thrust, torque = (
        float(c) * pressure * s for c, s in zip(whole(speed * 63 / wind, np.radians(pitch)), (1, radius), strict=True)
    )
    expected = polars_alone(wind, speed, np.radians(pitch))
    scale = [0.07 * pressure, 0.03 * pressure * radius]  # flat to the wind; best torque at standstill
    assert np.abs(np.array([thrust, torque]) - expected) / scale == pytest.approx([0, 0], abs=0.03)
    if (wind, pitch) == (50, 90):
        assert (thrust, torque) == (pytest.approx(93e3, rel=0.01), pytest.approx(-3.2e6, rel=0.02))


def polars_alone(wind, speed, pitch):
    """Thrust and torque of a rotor with cone in axial wind, without induction."""
    blade, cone = (
        read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), 1.5, 63.0),
        np.radians(2.5),
    )
    r, axial = blade.radius * np.cos(cone), wind * np.cos(cone)
    angle, W = np.arctan2(axial, speed * r), np.hypot(axial, speed * r)
    foils = [blade.airfoils[name] for name in blade.airfoil]
    coefficients = [
        PchipInterpolator(f.angle, f.coefficients)(a) for f, a in zip(foils, angle - blade.twist - pitch, strict=True)
    ]
    lift, drag = np.array(coefficients)[:, :2].T
    area = 3 * 1.225 / 2 * W**2 * blade.chord * blade.length
    normal, forward = lift * np.cos(angle) + drag * np.sin(angle), lift * np.sin(angle) - drag * np.cos(angle)
    return [np.sum(area * normal) * np.cos(cone), np.sum(area * forward * r)]


def test_the_whole_table_continues_the_published_one():
    table, whole = read_coefficients(CSV), read_coefficients(WHOLE)
    tips, pitches = np.meshgrid(table.tip_speed_ratio, table.blade_pitch)
    assert np.array(whole(tips, pitches)) == pytest.approx(np.array(table(tips, pitches)), abs=1e-7)
    for path in (np.linspace(-1, 60, 1221), np.linspace(-5, 100, 421)):  # no jump at a border
        at = (path, np.radians(2.0)) if path[0] == -1 else (1.5, np.radians(path))
        for values in whole(*at):
            steps = np.abs(np.diff(values))
            assert steps.max() < 6 * np.median(steps) + 0.02


@pytest.mark.parametrize(("pitch", "tolerance"), [(-5, 1e-3), (0, 1e-3), (20, 1e-3), (90, 1e-3), (2.5, 6e-3)])
def test_a_rotor_that_is_fast_for_the_wind_is_braked(pitch, tolerance):
    """Above a tip speed ratio of 25 the whole table is blade-element theory, also between its rows and pitch angles."""
    whole, ratios = read_coefficients(WHOLE), np.linspace(25, 160, 100)
    assert whole.tip_speed_ratio[-1] >= 12.1 * np.pi / 30 * 63 / 0.5  # rated speed in the least wind of the rotor
    blade = read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), 1.5, 63.0)
    theory = coefficient_table(BladeElementRotor(blade), ratios, np.radians([pitch]), precone=np.radians(2.5))
    thrust, torque = whole(ratios, np.radians(pitch))
    assert thrust == pytest.approx(theory.thrust[:, 0], abs=tolerance * np.abs(thrust).max())
    assert torque == pytest.approx(theory.torque[:, 0], abs=tolerance * np.abs(torque).max() + 0.02)
    assert torque.max() < -0.01


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"header": HEADER.replace("thrust", "drag")}, r"a\.csv:2: column thrust_coefficient is missing; there are"),
        ({"replace": "1,10,0.1,x"}, r"a\.csv:5: '1,10,0\.1,x' is not a row of numbers under tip_speed_ratio, "),
        ({"replace": "1,10,0.1"}, r"a\.csv:5: '1,10,0\.1' is not a row of numbers"),
        ({"leave_out": 6}, r"15 rows do not make a full table of 4 tip speed ratios and 4 pitch angles"),
        ({"replace": "1,5,0.1,0.05"}, r"16 rows do not make a full table of 4 tip speed ratios and 4 pitch angles"),
    ],
)
def test_messages_of_the_reader(tmp_path, arguments, message):
    with pytest.raises(ModelError, match=message):
        read_coefficients(small(tmp_path / "a.csv", **arguments))


def test_files_without_a_table(tmp_path):
    with pytest.raises(ModelError, match=r"none\.csv: cannot read the rotor coefficients: No such file"):
        read_coefficients(str(tmp_path / "none.csv"))
    (tmp_path / "empty.csv").write_text("# nothing\n")
    with pytest.raises(ModelError, match=r"empty\.csv: no rotor coefficients; the columns tip_speed_ratio"):
        read_coefficients(str(tmp_path / "empty.csv"))
