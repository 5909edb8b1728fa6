"""Libraries of FMUs for this machine and for others: what they export and need, and that they compute the same.

Libraries for other machines need ziglang; that of Windows is run where wine is there, else only read.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path
from urllib.parse import quote
from xml.etree import ElementTree as et

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.fmi.binaries import PLATFORMS, host, join_mac_libraries
from fowtlib.language.native import compiler

HERE = Path(__file__).parent
WINE = shutil.which("wine64") or shutil.which("wine") or (p if os.path.isfile(p := "/usr/lib/wine/wine64") else None)
zig = pytest.mark.skipif(
    not importlib.util.find_spec("ziglang"), reason="libraries for other machines need the package ziglang"
)
linux = pytest.mark.skipif(host() != "linux64", reason="reads libraries of Linux, and compiles with gcc")

C_AND_WINDOWS = ("kernel32.dll", "ntdll.dll", "ucrtbase.dll", "msvcrt.dll", "api-ms-win-crt-")
C_AND_UNIX = ("libc.so.6", "libm.so.6", "ld-linux", "/usr/lib/libSystem.B.dylib")


# --- readers of the three kinds of libraries ------------------------------------------------------------------------


def text_at(data, place):
    return data[place : data.index(b"\0", place)].decode()


def read_elf(data):
    """Exported names and needed libraries (System V ABI, ELF-64, little-endian)."""
    assert data[:6] == b"\x7fELF\x02\x01"
    start, size, count = struct.unpack_from("<Q", data, 40)[0], *struct.unpack_from("<HH", data, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, start + k * size) for k in range(count)]
    exported, needed = set(), set()
    for _, kind, _, _, place, length, link, _, _, entry in sections:
        strings = sections[link][4] if link < count else 0
        for at in range(place, place + length, entry) if kind in (6, 11) else ():
            if kind == 11:  # dynamic symbols: those with a section of their own are exported
                name, _, _, section, _, _ = struct.unpack_from("<IBBHQQ", data, at)
                if name and section:
                    exported.add(text_at(data, strings + name))
            else:
                tag, value = struct.unpack_from("<QQ", data, at)
                if tag == 1:
                    needed.add(text_at(data, strings + value))
    return exported, needed


def read_pe(data):
    """Exported names and needed libraries (Microsoft, PE Format, PE32+)."""
    head = struct.unpack_from("<I", data, 60)[0]
    machine, sections = struct.unpack_from("<HH", data, head + 4)
    assert (data[head : head + 4], machine) == (b"PE\0\0", 0x8664)
    optional = head + 24
    table = optional + struct.unpack_from("<H", data, head + 20)[0]
    parts = [struct.unpack_from("<IIII", data, table + 40 * k + 8) for k in range(sections)]

    def place(address):
        return next(raw + address - start for size, start, length, raw in parts if start <= address < start + length)

    exports, imports = struct.unpack_from("<I4xI", data, optional + 112)
    count, names = struct.unpack_from("<I4xI", data, place(exports) + 24)
    exported = {text_at(data, place(a)) for a in struct.unpack_from(f"<{count}I", data, place(names))}
    needed, at = set(), place(imports)
    while (name := struct.unpack_from("<I", data, at + 12)[0]) != 0:
        needed.add(text_at(data, place(name)))
        at += 20
    return exported, needed


def trie(data, start):
    """The names of an export trie: a node has data, led by their size, and edges with the places of other nodes."""

    def number(at):
        value = shift = 0
        while True:
            value, at, shift, more = value | (data[at] & 127) << shift, at + 1, shift + 7, data[at] & 128
            if not more:
                return value, at

    names, open_nodes = set(), [("", start)]
    while open_nodes:
        name, at = open_nodes.pop()
        size, at = number(at)
        if size:
            names.add(name.removeprefix("_"))
        edges, at = data[at + size], at + size + 1
        for _ in range(edges):
            part = text_at(data, at)
            place, at = number(at + len(part) + 1)
            open_nodes.append((name + part, start + place))
    return names


def read_mach(data):
    """Exported names, needed libraries, processor and whether it is signed (Apple, mach-o/loader.h)."""
    magic, processor, _, _, count, _ = struct.unpack_from("<IIIIII", data)
    assert magic == 0xFEEDFACF
    exported, needed, signed, at = set(), set(), False, 32
    for _ in range(count):
        command, size = struct.unpack_from("<II", data, at)
        if command in (0x80000022, 0x80000033):  # LC_DYLD_INFO_ONLY, LC_DYLD_EXPORTS_TRIE
            exported |= trie(data, struct.unpack_from("<I", data, at + (40 if command == 0x80000022 else 8))[0])
        elif command == 12:
            needed.add(text_at(data, at + struct.unpack_from("<I", data, at + 8)[0]))
        signed |= command == 29
        at += size
    return exported, needed, processor, signed


def slices(data):
    """The libraries in a universal one."""
    magic, count = struct.unpack_from(">II", data)
    assert magic == 0xCAFEBABE
    for k in range(count):
        processor, _, place, size, power = struct.unpack_from(">IIIII", data, 8 + 20 * k)
        assert place % (1 << power) == 0
        yield processor, data[place : place + size]


def functions(version):
    """All functions of a version of the standard, of the kinds an FMU can be: as fmpy declares them."""
    import fmpy

    text = (Path(fmpy.__file__).parent / "c-code" / f"fmi{version}Functions.h").read_text()
    return set(re.findall(rf"fmi{version}FullName\((fmi{version}\w+)\)", text))


def only(names, known):
    return all(name.lower().startswith(tuple(k.lower() for k in known)) for name in names)


# --- the library of this machine ------------------------------------------------------------------------------------


@linux
def test_library_of_this_machine_shows_the_standard_and_needs_the_c_library(unit):
    (library,) = Path(unit.folder, "binaries").rglob("*.so")
    exported, needed = read_elf(library.read_bytes())
    assert exported == functions(unit.version)
    assert only(needed, C_AND_UNIX) and needed


@linux
def test_sources_can_be_built_by_an_importer(as_unit, plant, tmp_path):
    """FMI 3.0: by buildDescription.xml, without the flags of fowtlib."""
    unit = as_unit(plant)
    build = et.parse(Path(unit.folder, "sources", "buildDescription.xml")).getroot()
    (files,) = build.iter("SourceFileSet")
    names = [str(Path(unit.folder, "sources", item.get("name"))) for item in files]
    (library,) = Path(unit.folder, "binaries").rglob("*.so")
    before = unit.simulate("cs", 0.5, 0.05, ["place", "bounces"])
    link = [f"-l{item.get('name')}" for item in build.iter("Library")]
    command = [*compiler(), "-std=c11", "-fPIC", "-shared", *files.get("compilerOptions").split(), *names, *link]
    subprocess.run([*command, "-o", str(library)], check=True)
    assert read_elf(library.read_bytes())[0] == functions("3")
    assert np.allclose(unit.simulate("cs", 0.5, 0.05, ["place", "bounces"]).tolist(), before.tolist(), rtol=1e-12)


# --- a hostile importer ---------------------------------------------------------------------------------------------

SANITIZERS = ["-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=undefined"]


@linux
def test_no_order_of_calls_and_no_value_breaks_an_instance(unit, tmp_path):
    """hostile.c: wrong orders, odd values, spoilt saved states; under the sanitizers where the compiler has them."""
    probe = tmp_path / "probe.c"
    probe.write_text("int main(void) { return 0; }\n")
    built = str(probe.with_suffix(""))
    there = subprocess.run([*compiler(), *SANITIZERS, str(probe), "-o", built], capture_output=True)
    if there.returncode == 0:
        there = subprocess.run([built], capture_output=True)  # some kernels do not run it
    sources = Path(unit.folder, "sources")
    command = [*compiler(), "-std=c11", "-O1", *(SANITIZERS if there.returncode == 0 else []), f"-I{sources}"]
    model = [str(sources / name) for name in ("model.c", "equations.c", "equations_wide.c")]
    program = [str(HERE / "hostile.c"), *model, "-o", str(tmp_path / "hostile"), "-lm"]
    subprocess.run([*command, f"-DINTERFACE={unit.version}", *program], check=True)
    folder = str(Path(unit.folder, "resources"))
    run = subprocess.run([str(tmp_path / "hostile"), folder, "7", "300"], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, ""), run.stdout + run.stderr
    assert run.stdout.endswith("characters heard\n")


# --- libraries for other machines -----------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["2", "3"])
def archive(request, tmp_path_factory):
    """The rigid spar, whose tables lie in the resources, for three platforms, unpacked in a folder with an odd name."""
    folder = tmp_path_factory.mktemp("other") / "Jürgen 50%"
    path = folder.parent / "spar.fmu"
    plant = fw.load("oc3_spar_rigid").compile()
    fw.export_fmu(plant, path, fmi=request.param, kind="cs", platforms=["linux64", "win64", "darwin"])
    zipfile.ZipFile(path).extractall(folder)
    return request.param, folder


@zig
def test_libraries_for_other_machines(archive):
    version, folder = archive
    names = "linux64 win64 darwin64" if version == "2" else "x86_64-linux x86_64-windows x86_64-darwin aarch64-darwin"
    assert {p.name for p in (folder / "binaries").iterdir()} == set(names.split())
    standard, processors = functions(version), {}
    for library in (folder / "binaries").rglob("spar.*"):
        data = library.read_bytes()
        assert len(data) < 5e6
        if library.suffix == ".so":
            exported, needed = read_elf(data)
            assert exported == standard and only(needed, C_AND_UNIX)
        elif library.suffix == ".dll":
            exported, needed = read_pe(data)
            assert exported == standard and only(needed, C_AND_WINDOWS)
        else:
            for processor, part in slices(data) if version == "2" else [(None, data)]:
                exported, needed, own, signed = read_mach(part)
                assert exported - {"_mh_dylib_header", "__dso_handle"} == standard  # those two are made by zig's linker
                assert only(needed, C_AND_UNIX) and processor in (None, own)
                processors[own] = (library.parent.name, signed)
    arm, intel = processors[0x0100000C], processors[0x01000007]
    assert arm[1]  # a Mac with an Apple processor loads signed libraries only
    expected = ("darwin64", "darwin64") if version == "2" else ("aarch64-darwin", "x86_64-darwin")
    assert (arm[0], intel[0]) == expected


@zig
@linux
def test_library_of_windows_computes_as_that_of_linux(archive, tmp_path):
    if WINE is None:
        pytest.skip("wine is not installed: of the library of Windows only the symbols are checked")
    version, folder = archive
    root = et.parse(folder / "modelDescription.xml").getroot()
    token = root.get("guid") or root.get("instantiationToken")
    numbers = [v.get("valueReference") for v in root.find("ModelVariables") if v.get("causality") == "output"][:50]
    program, windows = tmp_path / "host", tmp_path / "host.exe"
    subprocess.run([*compiler(), str(HERE / "host.c"), "-o", str(program), "-ldl"], check=True)
    cc = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS["win64"].targets[0], "-O1"]
    subprocess.run([*cc, str(HERE / "host.c"), "-o", str(windows)], check=True)
    rows = []
    for drive, run, ending in (("", [str(program)], "so"), ("Z:", [WINE, str(windows)], "dll")):
        (library,) = (folder / "binaries").rglob(f"*.{ending}")
        plain = shutil.copy(library, tmp_path)  # the name of the library itself is the importer's business
        place = drive + quote(str(folder / "resources"))
        place = f"file://{'/' if drive else ''}{place}" if version == "2" else f"{place}/"
        ran = subprocess.run(
            [*run, f"{drive}{plain}", version, token, place, "200", "0.05", *numbers], capture_output=True, text=True,
            env={**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine")},
        )  # fmt: skip
        assert ran.returncode == 0, ran.stderr
        rows.append(np.array([line.split() for line in ran.stdout.splitlines()], dtype=float))
    assert rows[0].shape == rows[1].shape == (200, len(numbers))
    scale = np.max(np.abs(rows[0]), axis=0) + 1e-300
    assert np.max(np.abs(rows[1] - rows[0]) / scale) < 1e-9  # sines and powers differ in their last digit


def test_a_library_for_every_mac(tmp_path):
    """The head of a universal library, as Apple's lipo writes it: two libraries at multiples of 16 KB."""
    parts = []
    for name, processor, size in (("arm", 0x0100000C, 20000), ("intel", 0x01000007, 70)):
        parts.append(tmp_path / name)
        parts[-1].write_bytes(struct.pack("<III", 0xFEEDFACF, processor, 3).ljust(size, b"x"))
    both = join_mac_libraries(parts, tmp_path / "both").read_bytes()
    assert struct.unpack_from(">12I", both) == (
        0xCAFEBABE, 2, 0x0100000C, 3, 16384, 20000, 14, 0x01000007, 3, 49152, 70, 14,
    )  # fmt: skip
    assert [part for _, part in slices(both)] == [path.read_bytes() for path in parts]
