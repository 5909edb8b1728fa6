"""The .bts file: bytes as TurbSim writes them, a round trip exact to the quantisation, and all that can be wrong."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest

from fowtlib.components.environment.field_file import FieldGrid, create_field, encode, read_field, write_field
from fowtlib.language import ModelError

GRID = FieldGrid(3, 2, 5, 10.0, 12.0, 0.25, 8.0, 90.0, 80.0, description="a test")


def speeds(grid=GRID, seed=1):
    size = (grid.steps, grid.rows, grid.columns, 3)
    return np.random.default_rng(seed).normal((8, 0, 0), (1, 0.8, 0.5), size)


def test_round_trip_within_half_a_step_of_the_numbers(tmp_path):
    values = speeds()
    field = write_field(tmp_path / "a.bts", GRID, values)
    error = np.abs(field.speeds(field.plane) - values)
    assert np.all(error <= (0.5 + 1e-9) / np.array(field.grid.slope))
    assert (field.grid.y.tolist(), field.grid.z.tolist()) == ([-6, 6], [80, 90, 100])
    assert (field.grid.duration, field.grid.description) == (1.25, "a test")
    assert replace(field.grid, slope=GRID.slope, offset=GRID.offset) == GRID
    # the stored numbers survive a second writing exactly
    again = create_field(tmp_path / "b.bts", field.grid)
    again.stored[:] = encode(field.speeds(field.stored), field.grid.slope, field.grid.offset)
    again.stored.flush()
    assert (tmp_path / "a.bts").read_bytes() == (tmp_path / "b.bts").read_bytes()


def test_order_of_the_numbers_and_the_tower(tmp_path):
    grid = replace(GRID, tower_points=2, periodic=False)
    values, tower = speeds(), np.arange(30.0).reshape(5, 2, 3)
    field = write_field(tmp_path / "a.bts", grid, values, tower)
    raw = (tmp_path / "a.bts").read_bytes()
    assert struct.unpack("<h4i6f", raw[:42])[:5] == (7, 3, 2, 2, 5)
    assert struct.unpack("<6f", raw[18:42]) == (10.0, 12.0, 0.25, 8.0, 90.0, 80.0)
    number = 70 + 6 + 2 * (3 * (1 * (6 + 2) + 2 * 2 + 1) + 1)  # step 1, row 2, column 1, v
    stored = struct.unpack_from("<h", raw, number)[0]
    assert (stored - field.grid.offset[1]) / field.grid.slope[1] == pytest.approx(values[1, 2, 1, 1], abs=1e-3)
    assert field.grid.tower_z.tolist() == [70, 60]
    np.testing.assert_allclose(field.speeds(field.tower), tower, atol=1e-3)
    assert field.grid.duration == 1.0


def test_a_component_that_does_not_change(tmp_path):
    values = speeds()
    values[..., 0], values[..., 2] = 25.0, 0.0
    field = write_field(tmp_path / "a.bts", GRID, values)
    np.testing.assert_allclose(field.speeds(field.plane), values, atol=1e-4)


def test_the_data_stay_in_the_file(tmp_path):
    field = write_field(tmp_path / "a.bts", GRID, speeds())
    assert isinstance(field.stored, np.memmap)
    assert isinstance(field.plane, np.memmap)
    assert field.stored.dtype == np.int16


def damaged(path, change):
    write_field(path, GRID, speeds())
    raw = bytearray(path.read_bytes())
    path.write_bytes(change(raw) or raw)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda raw: raw[:50], "50 bytes, less than the header of a .bts wind field."),
        (lambda raw: struct.pack_into("<h", raw, 0, 5), "begins with 5, a .bts wind field begins with 7 or 8."),
        (
            lambda raw: struct.pack_into("<h", raw, 0, -99),
            "begins with -99, a .bts wind field begins with 7 or 8. It may be one of Bladed (.wnd); TurbSim "
            "writes both.",
        ),
        (
            lambda raw: struct.pack_into("<f", raw, 38, -63.0),
            "the lowest row of the wind field is at z = -63 m; heights in a .bts file are those above the ground or "
            "the sea, and not from the hub.",
        ),
        (
            lambda raw: raw[:-40],
            "truncated: 140 bytes of data, and 5 steps of 6 points need 180; it ends in step 4.",
        ),
        (
            lambda raw: struct.pack_into("<f", raw, 50, np.nan),
            "the scale of v is damaged: slope = nan, offset = ",
        ),
        (lambda raw: struct.pack_into("<f", raw, 42, 0.0), "the scale of u is damaged: slope = 0, offset = "),
        (lambda raw: struct.pack_into("<i", raw, 2, -3), "rows = -3 in the header of the wind field."),
        (lambda raw: struct.pack_into("<f", raw, 26, 0.0), "dt = 0 in the header of the wind field, expected more"),
        (lambda raw: struct.pack_into("<f", raw, 34, np.inf), "hub_height = inf in the header of the wind field."),
        (lambda raw: struct.pack_into("<i", raw, 66, -1), "the description has -1 characters; the header is damaged."),
    ],
)
def test_a_damaged_file(tmp_path, change, message):
    path = tmp_path / "a.bts"
    damaged(path, change)
    with pytest.raises(ModelError) as error:
        read_field(path)
    assert str(error.value).startswith(f"{path}: {message}")


def test_a_long_file_in_parts(tmp_path):
    """Every part has a mapping of its own, and together they are the file."""
    field = write_field(tmp_path / "a.bts", GRID, speeds())
    parts = list(field.blocks(2 * 36))  # two steps of 6 points
    assert [start for start, _ in parts] == [0, 2, 4]
    np.testing.assert_array_equal(np.concatenate([stored for _, stored in parts]), field.stored)
    with pytest.raises(ValueError, match="read-only"):
        parts[0][1][:] = 0
    new = create_field(tmp_path / "b.bts", field.grid)
    for start, stored in new.blocks(2 * 36):
        stored[:] = field.stored[start : start + 2]
    np.testing.assert_array_equal(read_field(new.path).stored, field.stored)


def test_other_mistakes(tmp_path):
    with pytest.raises(ModelError, match=r"none.bts: cannot read the wind field: No such file"):
        read_field(tmp_path / "none.bts")
    with pytest.raises(ModelError, match=r"none.a.bts: cannot be written: No such file"):
        write_field(tmp_path / "none" / "a.bts", GRID, speeds())
    with pytest.raises(ModelError, match=r"speeds \(5, 2, 3, 3\) and tower \(5, 0, 3\), the grid needs"):
        write_field(tmp_path / "a.bts", GRID, speeds().transpose(0, 2, 1, 3))
    values = speeds()
    values[0, 0, 0, 0] = np.nan
    with pytest.raises(ModelError, match="must be finite numbers"):
        write_field(tmp_path / "a.bts", GRID, values)
