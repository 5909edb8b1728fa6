"""OpenFAST's binary output: what other readers find in our files, and what we find in every form of theirs."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result
from fowtlib.solving.results.openfast import CHANNELS, channel_of, result_of
from fowtlib.solving.results.outb import Channels, read_outb, write_outb

TIME = np.linspace(2.0, 12.0, 101)


def decoded(path: Path) -> tuple[list[str], list[str], np.ndarray, str]:
    """Names, units and table (time first) of a file of form 4, read from its description field by field."""
    data = path.read_bytes()
    form, length, n, m, first, step = struct.unpack_from("<hhiidd", data)
    assert form == 4
    at = 28
    scale, offset = (struct.unpack_from(f"<{n}f", data, at + 4 * n * k) for k in range(2))
    at += 8 * n
    (size,) = struct.unpack_from("<i", data, at)
    description = data[at + 4 : at + 4 + size].decode("ascii")
    at += 4 + size
    texts = [data[at + k * length : at + (k + 1) * length].decode("ascii").strip() for k in range(2 * n + 2)]
    at += length * (2 * n + 2)
    assert at + 2 * n * m == len(data)
    table = np.empty((m, n + 1))
    for i in range(m):
        table[i, 0] = first + step * i
        for j, number in enumerate(struct.unpack_from(f"<{n}h", data, at + 2 * n * i)):
            table[i, j + 1] = (number - offset[j]) / scale[j]
    return texts[: n + 1], texts[n + 1 :], table, description


def test_channels_of_a_floating_turbine(tmp_path):
    """Names and units of OpenFAST; values within 1/60000 of their range."""
    values = {
        "surge": 3 + np.sin(TIME), "generator_torque": 43093.55 + 100 * np.cos(TIME), "thrust": 700 + TIME,
        "aero_power": 5296.6 + 0 * TIME, "azimuth": 72.0 * TIME, "fairlead_tension_2": 900 + TIME**2,
        "blade_root_edgewise_moment_3": 1e6 * np.sin(TIME),
    }  # fmt: skip
    units = {
        "surge": "m", "generator_torque": "N m", "thrust": "kN", "aero_power": "kW", "azimuth": "deg",
        "fairlead_tension_2": "kN", "blade_root_edgewise_moment_3": "N*m",
    }  # fmt: skip
    Result(TIME, values, units, attributes={"title": "a spar"}).save(tmp_path / "r.outb")
    names, written, table, description = decoded(tmp_path / "r.outb")
    assert names == ["Time", "PtfmSurge", "GenTq", "RtAeroFxh", "RtAeroPwr", "Azimuth", "FAIRTEN2", "RootMxb3"]
    assert written == ["(s)", "(m)", "(kN-m)", "(N)", "(W)", "(deg)", "(N)", "(kN-m)"]
    factors = np.array([1, 1e-3, 1e3, 1e3, 1, 1e3, 1e-3])
    expected = np.column_stack(list(values.values())) * factors
    expected[:, 4] %= 360
    assert table[:, 0] == pytest.approx(TIME, rel=1e-12)
    assert np.all(np.abs(table[:, 1:] - expected) <= np.ptp(expected, axis=0) / 60000 + 1e-9 * np.abs(expected))
    assert description.startswith("fowtlib ") and "a spar" in description


def test_a_result_comes_back_in_its_own_names_and_units(tmp_path):
    names = [c.result.replace("#", "2") for c in CHANNELS if c.result not in ("blade_pitch", "azimuth")]
    values = {name: np.sin(TIME + k) for k, name in enumerate(names)}
    units = {c.result.replace("#", "2"): c.unit for c in CHANNELS}
    values["my_own.thing[1]"] = TIME
    result = Result(TIME, values, {**units, "my_own.thing[1]": "kg*m"})
    back = Result.open(result.save(tmp_path / "r.outb"))
    assert back.names == result.names
    for name, given_values in values.items():
        assert back.unit(name) == result.unit(name)
        assert back.array(name) == pytest.approx(given_values, abs=2 * np.ptp(given_values) / 60000)
    assert back.time == pytest.approx(TIME)


@pytest.mark.parametrize(
    ("result", "unit", "channel"),
    [
        ("rotor_speed_left", "rpm", "RotSpeed_left"),
        ("blade_pitch_right", "deg", "BldPitch1_right"),
        ("blade_pitch_2_left", "deg", "BldPitch2_left"),
        ("blade_pitch_left_2", "deg", "BldPitch2_left"),
        ("blade_pitch[0]", "rad", "BldPitch1"),
        ("blade_root_flapwise_moment_1", "N*m", "RootMyb1"),
        ("yaw_error", "deg", "yaw_error"),  # not the platform's
        ("thrust_coefficient", "1", "thrust_coefficient"),
        ("thrust", "m", "thrust"),  # not a force
        ("line.force[2]", "N", "line.force[2]"),
    ],
)
def test_names_of_channels(result, unit, channel):
    assert channel_of(result, unit).name == channel


def test_two_results_of_one_channel_and_names_that_differ_in_capitals_only(tmp_path):
    values = {"blade_pitch": TIME, "blade_pitch_1": 2 * TIME, "Force": TIME, "force": TIME}
    Result(TIME, values, {"blade_pitch": "deg", "blade_pitch_1": "deg"}).save(tmp_path / "r.outb")
    assert decoded(tmp_path / "r.outb")[0] == ["Time", "BldPitch1", "blade_pitch_1", "Force", "force_2"]


def test_pitch_of_one_blade_and_of_all():
    assert result_of("BldPitch1", "deg").name == "blade_pitch"
    assert result_of("BldPitch1", "deg", ["BldPitch1", "BldPitch2"]).name == "blade_pitch_1"
    assert result_of("RtFldFxh", "N").name == "thrust" and result_of("RtFldFxh", "N").factor == 1e-3
    assert result_of("NcIMUTAxs", "m/s^2").name == "NcIMUTAxs"


def by_hand(form: int) -> bytes:
    """Two channels at three times, in each form, of what the format says and nothing else."""
    names = b"".join(text.ljust(10) for text in (b"Time", b"PtfmSurge", b"Own", b"(s)", b"(m)", b"(kN\xb7m)"))
    head = struct.pack("<h", form) + (struct.pack("<h", 10) if form == 4 else b"") + struct.pack("<ii", 2, 3)
    head += struct.pack("<dd", *((100.0, -5.0) if form == 1 else (0.5, 0.25)))
    head += b"" if form == 3 else struct.pack("<4f", 100.0, 0.5, -50.0, 10.0)
    head += struct.pack("<i", 4) + b"test" + names
    if form == 3:
        return head + struct.pack("<6d", 1.5, -20, 2.5, 0, 3.5, 20)
    head += struct.pack("<3i", 45, 70, 95) if form == 1 else b""
    return head + struct.pack("<6h", 100, 0, 200, 10, 300, 20)


@pytest.mark.parametrize("form", [1, 2, 3, 4])
def test_every_form_is_read(tmp_path, form):
    (tmp_path / "x.outb").write_bytes(by_hand(form))
    channels = read_outb(tmp_path / "x.outb")
    assert channels.names == ("PtfmSurge", "Own") and channels.units == ("m", "kN-m")
    assert channels.description == "test"
    assert channels.time == pytest.approx([0.5, 0.75, 1.0])
    assert channels.values == pytest.approx(np.array([[1.5, -20], [2.5, 0], [3.5, 20]]))
    result = Result.open(tmp_path / "x.outb")
    assert result.names == ["surge", "Own"] and result.attributes["status"] == "read from x.outb."


@given(
    st.lists(st.floats(-1e30, 1e30), min_size=1, max_size=20),
    st.sampled_from([1.0, 1e-30, 1e-9]),
    st.floats(-1e12, 1e12),
)
def test_any_numbers_keep_their_digits(tmp_path_factory, numbers, size, middle):
    """1/60000 of the range; where a channel hardly moves about a large mean, some parts in 1e10 of the mean."""
    values = np.clip(np.array(numbers) * size + middle, -1e30, 1e30)[:, None]
    path = tmp_path_factory.mktemp("outb") / "x.outb"
    write_outb(path, Channels(np.arange(len(numbers)) * 0.1, ("a",), ("m",), values))
    back = read_outb(path).values
    allowed = np.ptp(values) / 60000 + 1e-9 * np.abs(values).max() + 1e-30
    assert np.all(np.abs(back - values) <= allowed)


def test_what_the_format_cannot_hold(tmp_path):
    path = tmp_path / "x.outb"
    late = np.array([0.0, 0.1, 0.2, 0.25])
    message = r"x\.outb: the file format knows evenly spaced times only, and .* not: 0\.2 s is followed by 0\.25 s"
    with pytest.raises(ModelError, match=message):
        Result(late, {"surge": late}).save(path)
    values = np.sin(TIME)
    values[7] = np.nan
    with pytest.raises(ModelError, match=r"the value of PtfmSurge at 2\.7 s is nan, which the file format cannot hold"):
        Result(TIME, {"surge": values}, {"surge": "m"}).save(path)
    values[7] = 1e31
    with pytest.raises(ModelError, match=r"the value of PtfmSurge at 2\.7 s is 1e\+31, which"):
        Result(TIME, {"surge": values}, {"surge": "m"}).save(path)
    assert not list(tmp_path.iterdir())


def test_files_that_are_none(tmp_path):
    path = tmp_path / "x.outb"
    path.write_bytes(by_hand(4)[:-3])
    with pytest.raises(ModelError, match="is not a binary output file of OpenFAST, or it is cut off"):
        Result.open(path)
    path.write_text("Time PtfmSurge")
    with pytest.raises(ModelError, match="it begins with 26964, not with 1 to 4"):
        read_outb(path)
    path.write_bytes(b"")
    with pytest.raises(ModelError, match="cut off"):
        read_outb(path)
    with pytest.raises(ModelError, match=r"none\.outb: cannot be read: No such file or directory"):
        read_outb(tmp_path / "none.outb")
