"""The shared libraries of an FMU: by the compiler of this machine for its own platform, by ziglang for the others."""

from __future__ import annotations

import importlib.util
import platform
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from fowtlib.language.errors import CompilerError, ParameterError, did_you_mean
from fowtlib.language.native import NO_COMPILER, compiler


@dataclass(frozen=True)
class Platform:
    """A platform: target of zig, folder of the binary in FMI 2.0 and 3.0, ending of the library."""

    target: str
    folder: str
    tuple: str
    ending: str


PLATFORMS = {
    "linux64": Platform("x86_64-linux-gnu.2.17", "linux64", "x86_64-linux", ".so"),
    "win64": Platform("x86_64-windows-gnu", "win64", "x86_64-windows", ".dll"),
    "darwin": Platform("aarch64-macos", "darwin64", "aarch64-darwin", ".dylib"),
    "darwin64": Platform("x86_64-macos", "darwin64", "x86_64-darwin", ".dylib"),
}
"""By name: darwin is a Mac with an Apple processor, darwin64 with an Intel one; both have one place in FMI 2.0."""

FLAGS = ("-std=c11", "-fvisibility=hidden", "-ffp-contract=off")


def host() -> str:
    """The platform of this machine."""
    if sys.platform == "win32":
        return "win64"
    if sys.platform == "darwin":
        return "darwin" if platform.machine() == "arm64" else "darwin64"
    return "linux64"


def chosen(names: Sequence[str] | None) -> list[str]:
    """The platforms asked for, this machine's without any; ParameterError for one there is not."""
    for name in names or ():
        if name not in PLATFORMS:
            raise ParameterError(f"there is no platform '{name}'{did_you_mean(name, PLATFORMS)}")
    return list(dict.fromkeys(names or [host()]))


def compile_binary(folder: Path, units: Sequence[tuple[str, str]], name: str, out: Path) -> Path:
    """The shared library of the sources in `folder` for a platform; units: file and optimization."""
    command, windows = _command(name), PLATFORMS[name].ending == ".dll"
    flags = FLAGS if windows else (*FLAGS, "-fPIC")  # those of Windows are always movable
    objects = [folder / f"{unit}.{name}.o" for unit, _ in units]

    def compile_one(place: int) -> None:
        unit, optimization = units[place]
        _run([*command, *flags, optimization, "-c", str(folder / unit), "-o", str(objects[place])], unit)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(compile_one, range(len(units))))
    out.parent.mkdir(parents=True, exist_ok=True)
    extra = ["-s"] if windows or name == "linux64" else []
    _run([*command, "-shared", *extra, *map(str, objects), "-o", str(out), *([] if windows else ["-lm"])], out.name)
    for path in objects:
        path.unlink()
    return out


def _command(name: str) -> list[str]:
    """The compiler for a platform."""
    if name == host() and compiler():
        return list(compiler())
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[name].target]
    if name == host():
        raise CompilerError(f"an FMU holds a compiled library, and {NO_COMPILER}")
    raise CompilerError(
        f"a library for {name} is compiled here by the Python package ziglang, which is not installed: "
        "pip install 'fowtlib[compiler]'. Without it there is only this machine's own platform, "
        f"{host()}."
    )


def _run(command: list[str], name: str) -> None:
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        lines = [line for line in run.stderr.splitlines() if line.strip()]
        first = next((line for line in lines if "error" in line), lines[0] if lines else "no message")
        raise CompilerError(f"{name}: its C code does not compile: {first}")
