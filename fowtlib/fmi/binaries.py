"""The shared libraries of an FMU: by the compiler of this machine for its own platform, by ziglang for the others."""

from __future__ import annotations

import importlib.util
import platform
import struct
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from fowtlib.language.errors import CompilerError, ParameterError, did_you_mean
from fowtlib.language.native import compiler, no_compiler, run_compiler


@dataclass(frozen=True)
class Platform:
    """A platform: targets of zig, the folder of the library in FMI 2.0, that of each target in 3.0, ending."""

    targets: tuple[str, ...]
    folder: str
    tuples: tuple[str, ...]
    ending: str


PLATFORMS = {
    "linux64": Platform(("x86_64-linux-gnu.2.17",), "linux64", ("x86_64-linux",), ".so"),
    "linux-arm64": Platform(("aarch64-linux-gnu.2.17",), "linux64", ("aarch64-linux",), ".so"),
    "win64": Platform(("x86_64-windows-gnu",), "win64", ("x86_64-windows",), ".dll"),
    "darwin": Platform(
        ("aarch64-macos", "x86_64-macos"), "darwin64", ("aarch64-darwin", "x86_64-darwin"), ".dylib"
    ),
}  # fmt: skip
"""By name. darwin is every Mac, with an Apple or an Intel processor: FMI 2.0 has one place for a library for both."""

FLAGS = ("-std=c11", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno")
APPLE = {"aarch64-macos": "arm64", "x86_64-macos": "x86_64"}


def host() -> str:
    """The platform of this machine."""
    if sys.platform == "win32":
        return "win64"
    if sys.platform == "darwin":
        return "darwin"
    return "linux-arm64" if platform.machine() in ("aarch64", "arm64") else "linux64"


def chosen(names: Sequence[str] | None) -> list[str]:
    """The platforms asked for, this machine's without any; ParameterError for one there is not."""
    for name in names or ():
        if name not in PLATFORMS:
            raise ParameterError(f"there is no platform '{name}'{did_you_mean(name, PLATFORMS)}")
    return list(dict.fromkeys(names or [host()]))


def require_platforms(names: Sequence[str], version: str) -> None:
    """CompilerError where this machine cannot compile for a platform, ParameterError where two share one place."""
    folders = [PLATFORMS[name].folder for name in names]
    for number, name in enumerate(names):
        if version == "2" and folders[number] in folders[:number]:
            other = names[folders.index(folders[number])]
            raise ParameterError(f"FMI 2.0 has one place for '{other}' and '{name}'; choose one of them, or FMI 3.0.")
        _command(name, PLATFORMS[name].targets[0])


def compile_platform(
    folder: Path, units: Sequence[tuple[str, str]], name: str, identifier: str, version: str
) -> dict[str, Path]:
    """The shared libraries of the sources in `folder` for a platform, by their paths in an FMU.

    units: file and optimization; version: "2" or "3".
    """
    there = PLATFORMS[name]
    made = [
        _compile(folder, units, name, target, folder / "out" / target / f"{identifier}{there.ending}")
        for target in there.targets
    ]
    if version == "3":
        return {f"binaries/{place}/{path.name}": path for place, path in zip(there.tuples, made, strict=True)}
    both = made[0] if len(made) == 1 else join_mac_libraries(made, folder / "out" / name / made[0].name)
    return {f"binaries/{there.folder}/{both.name}": both}


def _compile(folder: Path, units: Sequence[tuple[str, str]], name: str, target: str, out: Path) -> Path:
    """The shared library for one target of a platform."""
    command, ending = _command(name, target), PLATFORMS[name].ending
    flags = FLAGS if ending == ".dll" else (*FLAGS, "-fPIC")  # those of Windows are always movable
    objects = [folder / f"{unit}.{target}.o" for unit, _ in units]

    def compile_one(place: int) -> None:
        unit, optimization = units[place]
        run_compiler([*command, *flags, optimization, "-c", str(folder / unit), "-o", str(objects[place])], unit)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(compile_one, range(len(units))))
    out.parent.mkdir(parents=True, exist_ok=True)
    extra = {".so": ["-s", "-lm"], ".dll": ["-s"], ".dylib": []}[ending]
    run_compiler([*command, "-shared", *map(str, objects), "-o", str(out), *extra], out.name)
    for path in objects:
        path.unlink()
    return out


def join_mac_libraries(paths: Sequence[Path], out: Path) -> Path:
    """One library of several Mach-O libraries for different processors, as the tool lipo makes it.

    A head of big-endian numbers says of each processor, its variant, place, size and alignment as a power of two
    (Apple, mach-o/fat.h); the libraries follow, untouched, so that their signatures stay true.
    """
    alignment, contents = 14, [path.read_bytes() for path in paths]
    head, body, place = struct.pack(">II", 0xCAFEBABE, len(paths)), b"", 1 << alignment
    for content in contents:
        _, processor, variant = struct.unpack_from("<III", content)
        head += struct.pack(">IIIII", processor, variant, place, len(content), alignment)
        padded = content + bytes(-len(content) % (1 << alignment))
        body, place = body + padded, place + len(padded)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_bytes(head.ljust(1 << alignment, b"\0") + body)
    return out


def _command(name: str, target: str) -> list[str]:
    """The compiler for a target of a platform."""
    if name == host() and compiler():
        return [*compiler(), *(["-arch", APPLE[target]] if target in APPLE else [])]
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc", "-target", target]
    if name == host():
        raise CompilerError(f"an FMU holds a compiled library, and {no_compiler()}")
    raise CompilerError(
        f"a library for {name} is compiled here by the Python package ziglang, which is not installed: "
        "pip install 'fowtlib[compiler]'. Without it there is only this machine's own platform, "
        f"{host()}."
    )
