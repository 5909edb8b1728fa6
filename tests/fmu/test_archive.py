"""Archives and descriptions that are wrong, hostile or torn: a clear error, and nothing outside of the folder."""

from __future__ import annotations

import io
import re
import shutil
import stat
import struct
import zipfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fowtlib.components.fmu import FMU
from fowtlib.components.fmu import archive as archives
from fowtlib.components.fmu.archive import Archive
from fowtlib.components.fmu.description import read_description
from fowtlib.components.fmu.running import platform_folder
from fowtlib.language.errors import ModelError

SOME = settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])


def entry(name: str, content: bytes = b"x", **attributes) -> tuple[zipfile.ZipInfo, bytes]:
    info = zipfile.ZipInfo("placeholder")
    info.filename = info.orig_filename = name
    for key, value in attributes.items():
        setattr(info, key, value)
    return info, content


def written(path: Path, *entries: tuple[zipfile.ZipInfo, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as target:
        for info, content in entries:
            target.writestr(info, content)
    return path


OUTSIDE = "would be written outside of its folder"
HOSTILE = [
    (entry("../evil.so"), OUTSIDE), (entry("/etc/evil"), OUTSIDE), (entry("resources/../../evil"), OUTSIDE),
    (entry("C:/evil.dll"), OUTSIDE), (entry("C:evil.dll"), OUTSIDE), (entry("resources\\..\\..\\evil"), OUTSIDE),
    (entry("a\nb"), OUTSIDE), (entry("resources/x", external_attr=(stat.S_IFLNK | 0o777) << 16), "is a symbolic link"),
]  # fmt: skip


@pytest.mark.parametrize(("bad", "text"), HOSTILE)
def test_entries_that_leave_the_folder(tmp_path, bad, text):
    path = written(tmp_path / "bad.fmu", entry("modelDescription.xml"), bad)
    with pytest.raises(ModelError) as caught:
        Archive(path)
    assert str(caught.value).startswith("'bad.fmu' is not a usable FMU: the entry ") and text in str(caught.value)


def test_entries_of_one_name(tmp_path):
    with pytest.warns(UserWarning):
        path = written(tmp_path / "twice.fmu", entry("a.txt"), entry("a.txt"))
    with pytest.raises(ModelError, match=r"it has two entries 'a\.txt'"):
        Archive(path)
    path = written(tmp_path / "case.fmu", entry("a.txt"), entry("A.TXT"))
    with pytest.raises(ModelError, match=r"it has two entries 'A\.TXT'"):
        Archive(path)


FOLDERS = [("extra/", "extra/"), ("a/", "a/x", "a/", "A/"), ("a/b/", "a/", "a/b/", "a/b/c")]


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("names", FOLDERS)
def test_a_folder_that_is_listed_again(tmp_path, good, names):
    """As `cmake -E tar` lists them; a folder holds nothing that could differ."""
    with zipfile.ZipFile(io.BytesIO(good)) as old, zipfile.ZipFile(tmp_path / "twice.fmu", "w") as new:
        for item in old.infolist():
            new.writestr(item, old.read(item))
        for name in names:
            new.writestr(*entry(name, b"" if name.endswith("/") else b"x"))
    assert len(FMU(file=str(tmp_path / "twice.fmu")).ports) == 11
    (tmp_path / "to").mkdir()
    Archive(tmp_path / "twice.fmu").unpack(tmp_path / "to")
    for name in names:
        assert name == "A/" or (tmp_path / "to" / name).exists()


@pytest.mark.parametrize("names", [("a", "a/"), ("a/", "a"), ("A/", "a")])
def test_a_folder_with_the_name_of_a_file(tmp_path, names):
    path = written(tmp_path / "both.fmu", *(entry(name, b"") for name in names))
    with pytest.raises(ModelError, match="it has a folder and a file '" + names[1]):
        Archive(path)


def test_an_encrypted_entry(tmp_path):
    path = written(tmp_path / "secret.fmu", entry("a.txt"))
    content = bytearray(path.read_bytes())
    content[content.index(b"PK\1\2") + 8] |= 1
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"the entry 'a\.txt' is encrypted"):
        Archive(path)


def test_limits(tmp_path, monkeypatch):
    path = written(tmp_path / "large.fmu", entry("modelDescription.xml", b"0" * 3000), entry("b", b"0" * 2000))
    monkeypatch.setattr(archives, "MOST_DESCRIPTION", 2999)
    with pytest.raises(ModelError, match=r"its modelDescription\.xml is larger than the limit of 0\.002999 MB"):
        Archive(path).description()
    monkeypatch.setattr(archives, "MOST_UNPACKED", 4999)
    with pytest.raises(ModelError, match=r"unpacked it has 5e-06 GB, more than the limit of 4\.999e-06 GB"):
        Archive(path)
    monkeypatch.setattr(archives, "MOST_ENTRIES", 1)
    with pytest.raises(ModelError, match="it has 2 entries, more than the limit of 1"):
        Archive(path)


BOMBS = [
    ([("resources/zeros", 20_000_000)], "the entry 'resources/zeros' grows from 19"),
    ([("resources/a", 3_000_000)] * 4, "it grows from "),  # none of them is large
    ([("modelDescription.xml", 15_000_000)], "the entry 'modelDescription.xml' grows from "),
]


@pytest.mark.parametrize(("sizes", "text"), BOMBS)
def test_a_bomb_below_the_limit_of_size_is_refused_for_its_ratio(tmp_path, sizes, text):
    entries = [entry(f"{name}{k or ''}", b"\0" * size, compress_type=zipfile.ZIP_DEFLATED)
               for k, (name, size) in enumerate(sizes)]  # fmt: skip
    with pytest.raises(ModelError) as caught:
        Archive(written(tmp_path / "bomb.fmu", *entries))
    assert str(caught.value).startswith(f"'bomb.fmu' is not a usable FMU: {text}")
    assert str(caught.value).endswith("bytes when it is unpacked, more than the limit of 100 times.")


def test_what_is_packed_well_is_no_bomb(tmp_path):
    text = "".join(f"{k * k % 977} {k % 7}.5\n" for k in range(400_000)).encode()
    path = written(tmp_path / "table.fmu", entry("resources/t", text * 3, compress_type=zipfile.ZIP_DEFLATED))
    (tmp_path / "to").mkdir()
    Archive(path).unpack(tmp_path / "to")
    assert (tmp_path / "to/resources/t").read_bytes() == text * 3


def test_entries_that_overlap(tmp_path):
    """Many entries of the directory that share one packed file: small each, and none with a large ratio."""
    path = written(tmp_path / "quoted.fmu", entry("a", bytes(range(256)) * 4000), entry("b"))
    packed = bytearray(path.read_bytes())
    directory = packed.index(b"PK\1\2")
    end = packed.index(b"PK\5\6")
    record = bytes(packed[directory : packed.index(b"PK\1\2", directory + 4)])
    many = b"".join(record[:46] + name + record[47:] for name in (b"c", b"d", b"e"))
    packed[end:end] = many
    struct.pack_into("<HHI", packed, end + len(many) + 8, 5, 5, end + len(many) - directory)
    path.write_bytes(packed)
    with pytest.raises(ModelError, match="its entries are larger than itself: they overlap"):
        Archive(path)


ABSURD = [
    (entry("n" * 201), "has a path of 201 bytes in 1 parts"), (entry("a/" * 40 + "b"), "in 41 parts"),
    (entry("/".join(["n" * 190] * 8)), "has a path of 1520 bytes"),
    (entry("resources/pipe", external_attr=(stat.S_IFIFO | 0o600) << 16, create_system=3), "is neither a file nor"),
    (entry("resources/disk", external_attr=(stat.S_IFBLK | 0o600) << 16, create_system=3), "is neither a file nor"),
    (entry("resources/x", compress_type=zipfile.ZIP_LZMA), "is packed by the method 14, and FMI has deflate"),
]  # fmt: skip


@pytest.mark.parametrize(("bad", "text"), ABSURD)
def test_entries_that_no_fmu_has(tmp_path, bad, text):
    with pytest.raises(ModelError) as caught:
        Archive(written(tmp_path / "bad.fmu", entry("modelDescription.xml"), bad))
    assert str(caught.value).startswith("'bad.fmu' is not a usable FMU: the entry ") and text in str(caught.value)


@pytest.mark.parametrize("names", [("a", "a/b"), ("a/b/c", "A"), ("x/é", "x/É/y")])
def test_a_file_in_a_file(tmp_path, names):
    with pytest.raises(ModelError, match="which is a file"):
        Archive(written(tmp_path / "bad.fmu", *(entry(name) for name in names)))


BILLION = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-32-be"])
@pytest.mark.parametrize("declared", ["UTF-8", "UTF-16", "UTF-7", "cp037"])
def test_entities_in_any_encoding(fmu_files, encoding, declared):
    text = fmu_files()["modelDescription.xml"].replace("UTF-8", declared).replace("?>", "?>" + BILLION, 1)
    with pytest.raises(ModelError, match=r"has a document type|is in UTF-16 or UTF-32"):
        read_description(text.encode(encoding), "x.fmu")


def test_a_bomb_of_a_thousand_times_its_size_is_refused_before_it_is_unpacked(tmp_path):
    """The sizes of the central directory count; an entry that is larger than it says is cut off by its checksum."""
    info, content = entry("resources/zeros", b"\0" * 3_000_000, compress_type=zipfile.ZIP_DEFLATED)
    path = written(tmp_path / "bomb.fmu", entry("modelDescription.xml"), (info, content))
    packed = path.read_bytes()
    directory = packed.rindex(b"PK\1\2")
    huge = bytearray(packed)
    struct.pack_into("<I", huge, directory + 24, 0xF0000000)
    path.write_bytes(huge)
    with pytest.raises(ModelError, match="more than the limit of 1 GB"):
        Archive(path)
    small = bytearray(packed)
    struct.pack_into("<I", small, directory + 24, 10)
    path.write_bytes(small)
    (tmp_path / "to").mkdir()
    with pytest.raises(ModelError, match="cannot be unpacked"):
        Archive(path).unpack(tmp_path / "to")
    assert (tmp_path / "to/resources/zeros").stat().st_size <= 10


@pytest.mark.parametrize(
    ("content", "text"),
    [(b"", "cannot be read as a zip archive"), (b"PK", "cannot be read as a zip archive"), (None, "there is no file")],
)
def test_files_that_are_no_archive(tmp_path, content, text):
    if content is not None:
        (tmp_path / "a.fmu").write_bytes(content)
    with pytest.raises(ModelError, match=text):
        FMU(file=str(tmp_path / "a.fmu"))
    with pytest.raises(ModelError, match="is a folder"):
        FMU(file=str(tmp_path))


def changed(fmu_files, archive, path: Path, version: int, *changes: tuple[str, str]) -> str:
    files = dict(fmu_files(version))
    for old, new in changes:
        assert old in files["modelDescription.xml"], old
        files["modelDescription.xml"] = files["modelDescription.xml"].replace(old, new)
    return str(archive(path, files))


COSIMULATION = '<CoSimulation modelIdentifier="controller"'
WRONG = [
    (2, ('fmiVersion="2.0"', 'fmiVersion="1.0"'), "it is of FMI version 1.0, and versions 2.0 and 3.0 can be imported"),
    (2, (COSIMULATION, '<ModelExchange modelIdentifier="controller"'), "it has no co-simulation, only ModelExchange"),
    (2, ('modelIdentifier="controller"', 'modelIdentifier="../x"'), "its modelIdentifier '../x' is not the name"),
    (2, ("<?xml version", "<!DOCTYPE x [<!ENTITY a 'b'>]><?xml version"), "has a document type"),
    (2, ("</ModelVariables>", ""), "is not well-formed XML in UTF-8"),
    (2, ('factor="1000"', 'factor="0"'), "the unit 'kNm' has the factor 0"),
    (2, ('factor="1000"', 'factor="much"'), "the unit 'kNm' is 'much', and a number is expected"),
    (2, ('kg="1" m="2"', 'kg="1" m="1e9"'), "the unit 'kNm' is '1e9', and a whole number is expected"),
    (2, ('valueReference="102"', 'valueReference="-1"'), "the valueReference of 'samples' is -1"),
    (2, ('name="samples"', 'name="torque"'), "it has two variables 'torque'"),
    (2, ('<Integer start="2"/>', '<Integer start="two"/>'), "the start value of 'mode' is 'two'"),
    (2, ('<Integer start="2"/>', ""), "its variable 'mode' has no type"),
    (2, ('stepSize="0.0125"', 'stepSize="-1"'), "stepSize is -1, and it must be above zero"),
    (2, ('stepSize="0.0125"', 'stepSize="NaN"'), "stepSize is 'NaN', and a finite number is expected"),
    (3, ('<Dimension start="2"/>', '<Dimension start="0"/>'), "the size of 'array_in' is 0"),
    (3, ('<Dimension start="2"/>', '<Dimension start="99999"/>'), "is an array of 99999 x 99999, which is too much"),
    (3, ('<Dimension start="2"/>', '<Dimension valueReference="5"/>'), "the size of 'array_in' is '0.0008965149'"),
    (3, ('start="0 0 0 0"', 'start="0 0 0"'), "'array_in' has 4 elements and 3 start values"),
]


@pytest.mark.parametrize(("version", "change", "text"), WRONG)
def test_descriptions_that_are_wrong(fmu_files, archive, tmp_path, version, change, text):
    with pytest.raises(ModelError) as caught:
        FMU(file=changed(fmu_files, archive, tmp_path / "w.fmu", version, change))
    assert str(caught.value).startswith("'w.fmu' is not a usable FMU: ") and text in str(caught.value)


def test_what_cannot_be_a_part(fmu_files, archive, tmp_path):
    tool = (COSIMULATION, f'{COSIMULATION} needsExecutionTool="true"')
    with pytest.raises(ModelError, match="it needs the program that made it"):
        FMU(file=changed(fmu_files, archive, tmp_path / "1.fmu", 2, tool))
    text = ('"output" variability="discrete"><Integer/>', '"output" variability="discrete"><String/>')
    path = changed(fmu_files, archive, tmp_path / "2.fmu", 2, text)
    with pytest.raises(ModelError, match=r"the output 'mode_out' is of type String and cannot be a signal; to leave"):
        FMU(file=path)
    assert not {"mode_out", "samples"} & FMU(file=path, ignore=["mode_out", "samples"]).ports.keys()
    unit = ('unit="kNm"', 'unit="KNM"')
    path = changed(fmu_files, archive, tmp_path / "3.fmu", 2, unit)
    with pytest.raises(ModelError, match=r"torque: the file does not define its unit 'KNM'; name a known one"):
        FMU(file=path)
    assert FMU(file=path, units={"torque": "kN*m"}).ports["torque"].unit == "N*m"


def test_a_unit_without_a_definition_is_known_by_its_name(fmu_files, archive, tmp_path):
    rpm = ('<BaseUnit s="-1" rad="1" factor="0.10471975511965977"/>', "")
    path = changed(fmu_files, archive, tmp_path / "u.fmu", 2, rpm)
    assert FMU(file=path).ports["generator_speed"].unit == "rad/s"


def test_a_library_for_another_machine(fmu_files, archive, tmp_path):
    files = {name: content for name, content in fmu_files().items() if not name.startswith("binaries")}
    path = archive(tmp_path / "none.fmu", {**files, "sources/a.c": "int a;"})
    with pytest.raises(ModelError, match="but for no platform. It brings sources"):
        FMU(file=str(path))
    others = {f"binaries/{name}/controller.so": "x" for name in ("amiga", "vax")}
    path = archive(tmp_path / "other.fmu", {**files, **others})
    with pytest.raises(ModelError) as caught:
        FMU(file=str(path))
    here = platform_folder("2.0")
    assert str(caught.value) == f"'other.fmu' has no library for this machine ('{here}'), but for 'amiga' and 'vax'."


def test_no_description(tmp_path):
    with pytest.raises(ModelError, match=r"it has no modelDescription\.xml"):
        FMU(file=str(written(tmp_path / "a.fmu", entry("b"))))


# --- torn and mutated ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def good(fmu_files) -> bytes:
    """A small archive that passes: its library is never loaded."""
    files = {name: content if name.endswith("xml") else b"library" for name, content in fmu_files(3).items()}
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in files.items():
            file.writestr(name, content)
    return target.getvalue()


def attempt(folder: Path, content: bytes) -> None:
    """What is raised is a ModelError, and nothing is written beside the folder."""
    path, target = folder / "fuzz.fmu", folder / "to"
    path.write_bytes(content)
    target.mkdir(exist_ok=True)
    try:
        FMU(file=str(path))
        archive = Archive(path)
        archive.unpack(target)
    except ModelError as error:
        assert str(error)
    assert {item.name for item in folder.iterdir()} == {"fuzz.fmu", "to"}
    shutil.rmtree(target)


def test_the_good_one_passes(tmp_path, good):
    (tmp_path / "good.fmu").write_bytes(good)
    assert len(FMU(file=str(tmp_path / "good.fmu")).ports) == 11


@SOME
@given(length=st.integers(0, 10**4))
def test_truncated_archives(tmp_path, good, length):
    attempt(tmp_path, good[: length % len(good)])


@SOME
@given(at=st.integers(0, 10**4), put=st.binary(max_size=4), cut=st.integers(0, 4))
def test_mutated_archives(tmp_path, good, at, put, cut):
    at %= len(good)
    attempt(tmp_path, good[:at] + put + good[at + cut :])


@SOME
@given(at=st.integers(-600, -1), put=st.binary(min_size=1, max_size=2))
def test_mutated_directories(tmp_path, good, at, put):
    """The end of an archive is its directory: names, sizes, offsets, flags."""
    attempt(tmp_path, good[:at] + put + good[at + len(put) or len(good) :])


def read(text: str | bytes) -> None:
    try:
        read_description(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text, "fuzz.fmu")
    except ModelError as error:
        assert str(error).startswith("'fuzz.fmu' is not a usable FMU: ")


WORDS = ["2.0", "3.0", "-1", "1e400", "NaN", "0", "", "true", "Real", "Float64", "Dimension", "BaseUnit", "<a>", "</",
         '"', "99999999999999999999", "&lt;", "&a;", "start", "valueReference", "\u0000", "\ud800", "Ω"]  # fmt: skip


@SOME
@given(version=st.sampled_from([2, 3]), at=st.integers(0, 10**4), put=st.sampled_from(WORDS) | st.text(max_size=3),
       cut=st.integers(0, 20))  # fmt: skip
def test_mutated_descriptions(fmu_files, version, at, put, cut):
    text = fmu_files(version)["modelDescription.xml"]
    at %= len(text)
    read(text[:at] + put + text[at + cut :])


@SOME
@given(version=st.sampled_from([2, 3]), data=st.data())
def test_values_of_attributes(fmu_files, version, data):
    """Any attribute of the description gets any value."""
    text = fmu_files(version)["modelDescription.xml"]
    found = list(re.finditer(r'="([^"<&]*)"', text))
    which = data.draw(st.sampled_from(found))
    value = data.draw(st.sampled_from(WORDS) | st.text(st.characters(exclude_characters='"<&'), max_size=5))
    read(text[: which.start(1)] + value + text[which.end(1) :])


@SOME
@given(st.binary(max_size=40))
def test_any_bytes(content):
    read(content)
    read(b'<fmiModelDescription fmiVersion="2.0">' + content)
