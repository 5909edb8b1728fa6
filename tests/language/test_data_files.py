"""Tables are read whatever saved them, and read again when they change."""

import os
from pathlib import Path

import numpy as np
import pytest

import fowtlib.models
from fowtlib.components.aero import read_airfoils, read_blade, read_coefficients
from fowtlib.components.environment import read_series
from fowtlib.components.mechanics import read_beam
from fowtlib.language.data_files import digest_of, lines_of, remembered, text_of
from fowtlib.language.errors import ModelError, ParameterError

DATA = Path(fowtlib.models.__file__).parent / "data"
AIRFOILS = str(DATA / "nrel5mw" / "airfoils.csv")
READERS = {
    "nrel5mw/rotor_coefficients.csv": lambda path: read_coefficients(path).thrust,
    "nrel5mw/airfoils.csv": lambda path: read_airfoils(path)["DU21_A17"].coefficients,
    "nrel5mw/blade_aerodynamics.csv": lambda path: read_blade(path, AIRFOILS, 1.5, 63.0).chord,
    "nrel5mw/blade_structure.csv": lambda path: read_beam(path).mass_per_length,
    "oc3_hywind/tower.csv": lambda path: read_beam(path).stiffness_x,
}
SAVED_BY = {
    "a spreadsheet, CSV UTF-8": lambda text: text.encode("utf-8-sig"),
    "Windows, line ends": lambda text: text.replace("\n", "\r\n").encode("utf-8-sig"),
    "an old Mac": lambda text: text.replace("\n", "\r").encode(),
    "Unicode text": lambda text: text.encode("utf-16"),
    "Windows, Latin letters": lambda text: ("# Größe in °\n" + text).encode("cp1252"),
    "blank lines": lambda text: text.replace("\n", "\n\n").encode(),
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("saved_by", SAVED_BY)
def test_every_table_is_read_whatever_saved_it(name, saved_by, tmp_path):
    text, copy = (DATA / name).read_text(encoding="utf-8"), tmp_path / "copy.csv"
    copy.write_bytes(SAVED_BY[saved_by](text))
    assert np.array_equal(READERS[name](str(copy)), READERS[name](str(DATA / name)))


@pytest.mark.parametrize("saved_by", SAVED_BY)
def test_a_wind_series(saved_by, tmp_path):
    path = tmp_path / "wind.csv"
    path.write_bytes(SAVED_BY[saved_by]("time,speed\n0,8\n1,9\n2,10\n3,11\n"))
    assert read_series(str(path), 1).values[:, 0].tolist() == [8.0, 9.0, 10.0, 11.0]


@pytest.mark.parametrize("name", READERS)
def test_a_file_that_changes_is_read_again(name, tmp_path):
    """Also when it gets its old time back."""
    path = tmp_path / "table.csv"
    text = (DATA / name).read_text(encoding="utf-8")
    path.write_text(text)
    first, state = READERS[name](str(path)), path.stat()
    assert READERS[name](str(path)) is first or np.array_equal(READERS[name](str(path)), first)
    path.write_text("# changed\n" + text)
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))
    assert READERS[name](str(path)) is not first


def test_the_same_content_is_the_same_object(tmp_path):
    beams = [read_beam(str(DATA / "oc3_hywind/tower.csv")) for _ in range(2)]
    assert beams[0] is beams[1]
    path = tmp_path / "tower.csv"
    path.write_text("z_m,mass_per_length_kg_per_m,bending_stiffness_fore_aft_N_m2,bending_stiffness_side_side_N_m2\n"
                    "0,1000,1e9,1e9\n10,1000,1e9,1e9\n")  # fmt: skip
    old = read_beam(str(path))
    path.write_text(path.read_text().replace("10,1000", "10,2000"))  # as many bytes, perhaps within one tick
    assert read_beam(str(path)).mass_per_length.tolist() == [1000.0, 2000.0]
    path.write_text(path.read_text().replace("10,2000", "10,1000"))
    assert read_beam(str(path)) is old


def test_a_blade_is_read_again_when_its_airfoils_change(tmp_path):
    airfoils = tmp_path / "airfoils.csv"
    airfoils.write_text(Path(AIRFOILS).read_text())
    blade = str(DATA / "nrel5mw/blade_aerodynamics.csv")
    first = read_blade(blade, str(airfoils), 1.5, 63.0)
    assert read_blade(blade, str(airfoils), 1.5, 63.0) is first
    airfoils.write_text("# another line\n" + Path(AIRFOILS).read_text())
    assert read_blade(blade, str(airfoils), 1.5, 63.0) is not first


def test_what_is_no_text(tmp_path):
    path = tmp_path / "numbers.csv"
    path.write_bytes(bytes(range(256)))
    for read in (text_of, lines_of, read_beam, read_airfoils, read_coefficients):
        with pytest.raises(ModelError, match="numbers.csv: cannot read .*: this is not a text file"):
            read(str(path))
    with pytest.raises(ParameterError, match=r"none.csv: cannot read the table: No such file or directory"):
        read_airfoils(str(tmp_path / "none.csv"))


def test_the_numbers_of_the_lines_are_those_of_the_file(tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(b"\xef\xbb\xbf# comment\r\n\r\na,b\r\n  # another\r\n1,2")
    assert lines_of(path) == [(3, "a,b"), (5, "1,2")]


def test_a_digest_is_that_of_the_content(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_bytes(b"abc")
    two.write_bytes(b"abc")
    assert digest_of(one) == digest_of(two) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    os.utime(one, (1e9, 1e9))
    assert digest_of(one) == digest_of(two)
    one.write_bytes(b"abd")
    assert digest_of(one) != digest_of(two)


def test_a_reader_forgets_the_oldest(tmp_path):
    calls = []

    @remembered()
    def read(path, factor=1):
        calls.append(path)
        return object()

    paths = [tmp_path / str(i) for i in range(40)]
    for path in paths:
        path.write_text("x")
        read(path)
    read(paths[-1])
    read(paths[-1], factor=2)
    read(paths[0])
    assert len(calls) == 42
