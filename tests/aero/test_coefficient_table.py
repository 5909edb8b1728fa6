"""Reader of rotor coefficients, its messages, and the continued table."""

from pathlib import Path

import numpy as np
import pytest

import fowtlib.models
from fowtlib.components.aero import read_coefficients
from fowtlib.language.errors import ModelError

CSV = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients.csv")
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
    """Inside unchanged; outside it holds its edge, and above it follows blade element theory."""
    table, wide = read_coefficients(CSV), read_coefficients(CSV, extended=True)
    tips, pitches = np.meshgrid(np.linspace(3, 14.5, 20), np.radians(np.linspace(-5, 28, 20)))
    assert np.abs(np.array(wide(tips, pitches)) - table(tips, pitches)).max() < 2e-3
    assert np.ravel(wide(0.2, 0.0)) == pytest.approx([table.thrust[0, 5], table.torque[0, 5]], abs=1e-3)
    assert np.ravel(wide(3.0, np.radians(70))) == pytest.approx([table.thrust[2, -1], table.torque[2, -1]], abs=1e-4)
    speeds = np.linspace(14.5, 22, 30)
    thrust, torque = wide(speeds, 0.0)
    assert np.all(np.abs(np.diff(thrust)) < 0.02) and np.all(np.diff(torque) < 0)
    assert 0 < np.interp(0, -torque, speeds) - 17.5 < 1.5  # the speed of a rotor that nothing brakes


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
    with pytest.raises(ModelError, match=r"cannot read the rotor coefficients .*none\.csv: No such file"):
        read_coefficients(str(tmp_path / "none.csv"))
    (tmp_path / "empty.csv").write_text("# nothing\n")
    with pytest.raises(ModelError, match=r"empty\.csv: no rotor coefficients; the columns tip_speed_ratio"):
        read_coefficients(str(tmp_path / "empty.csv"))
