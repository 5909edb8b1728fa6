"""netCDF files with checksums: what has changed is named, wherever it lies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import netcdf_file

from fowtlib.language.netcdf_files import CHECKSUM, HEAD, add_variable, read_netcdf, set_attributes, write_netcdf


def fill(file):
    set_attributes(file, {"title": "Öl", "count": 3, "ratio": 0.25})
    add_variable(file, "time", "d", ("time",), [0.0, 0.5, 1.0], units="s")
    add_variable(file, "load", "d", ("time", "row"), [[1.0, -0.0], [np.nan, 2.0], [3.0, np.inf]], units="N", order=2)
    add_variable(file, "odd", "b", ("odd_bytes",), np.arange(7, dtype=np.int8))
    add_variable(file, "depth", "d", (), 320.0, units="m")


@pytest.fixture
def path(tmp_path):
    write_netcdf(tmp_path / "a.nc", fill)
    return tmp_path / "a.nc"


def test_what_was_written_is_read(path):
    contents = read_netcdf(path)
    assert not contents.damaged
    assert dict(contents.attributes) == {"title": "Öl", "count": 3, "ratio": 0.25}
    assert dict(contents.variables["load"].attributes) == {"units": "N", "order": 2}
    np.testing.assert_array_equal(contents.variables["load"].values, [[1.0, -0.0], [np.nan, 2.0], [3.0, np.inf]])
    assert contents.variables["odd"].values.tolist() == list(range(7)) and contents.variables["depth"].values == 320.0


def test_every_byte_that_turns_is_noticed_or_has_no_meaning(path):
    data, good, refused = path.read_bytes(), read_netcdf(path), 0
    for place in range(len(data)):
        for bit in (1, 0x20, 0x80):
            path.write_bytes(data[:place] + bytes([data[place] ^ bit]) + data[place + 1 :])
            try:
                contents = read_netcdf(path)
            except ValueError:
                refused += 1
                continue
            if contents.damaged:
                refused += 1
                continue
            assert repr(contents) == repr(good), f"byte {place}, bit {bit:#x}"
    assert refused > 2.5 * len(data)


def test_what_is_damaged_has_a_name(path):
    data = bytearray(path.read_bytes())
    data[data.index(np.array([1.0, -0.0], ">f8").tobytes())] ^= 1
    path.write_bytes(data)
    assert read_netcdf(path).damaged == ("load",)
    assert read_netcdf(path).damage == "the numbers or the attributes of load are not those that were written"
    data[data.index(b"title")] ^= 1
    path.write_bytes(data)
    assert read_netcdf(path).damaged == (HEAD, "load")


@pytest.mark.parametrize("find", [bytearray.index, bytearray.rindex], ids=["of the file", "of a variable"])
def test_a_checksum_that_is_gone_is_damage_too(path, find):
    data = bytearray(path.read_bytes())
    data[find(data, CHECKSUM.encode())] ^= 2
    path.write_bytes(data)
    assert read_netcdf(path).damaged


def test_a_file_without_checksums_is_read(tmp_path):
    with netcdf_file(tmp_path / "b.nc", "w") as file:
        fill(file)
    assert not read_netcdf(tmp_path / "b.nc").damaged


def test_of_a_file_that_is_cut_off_the_beginning_is_read(path):
    data = path.read_bytes()
    path.write_bytes(data[: data.index(np.array([1.0, -0.0], ">f8").tobytes()) + 8])
    with pytest.raises(ValueError, match="not a netCDF file of format 3, or damaged"):
        read_netcdf(path)
    contents = read_netcdf(path, cut=True)
    assert "load" in contents.damaged and len(contents.damaged) < 4
    path.write_bytes(data[:200])
    with pytest.raises(ValueError, match="damaged"):
        read_netcdf(path, cut=True)
