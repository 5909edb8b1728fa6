"""The report of an error inside the program: what a maintainer needs to find it, in a file that the user can read."""

from __future__ import annotations

import argparse
import os
import platform
import sys
import tempfile
import traceback
from datetime import UTC, datetime
from pathlib import Path

PACKAGES = ("fowtlib", "casadi", "numpy", "scipy", "xarray", "pyyaml")
HOW_TO_SEND = (
    "If you report this, send this file and, where you may, the files named in it; CONTRIBUTING.md says how. It holds "
    "the command, versions, digests and the places in the program, and no content of your files."
)


def write_report(arguments: argparse.Namespace, error: BaseException) -> Path | None:
    """Write the report of an error and give its path; None where no file can be written."""
    try:
        handle, name = tempfile.mkstemp(prefix="fowt_report_", suffix=".txt")
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write("\n".join(_lines(arguments, error)) + "\n")
    except OSError:
        return None
    return Path(name)


def _lines(arguments: argparse.Namespace, error: BaseException) -> list[str]:
    lines = [HOW_TO_SEND, "", f"date: {datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC", f"command: fowt {arguments.command}"]
    lines += [f"  {key}: {value!r}"[:500] for key, value in sorted(vars(arguments).items()) if not callable(value)]
    lines += [f"system: {platform.platform()}, Python {sys.version.split()[0]}"]
    lines += [f"{name}: {_version(name)}" for name in PACKAGES]
    lines += [f"file: {path}" for path in _files(arguments)]
    return [*lines, "", "".join(traceback.format_exception(error))]


def _version(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _files(arguments: argparse.Namespace) -> list[str]:
    """The files that the command line names, with their digests; for the name of a shipped model its file."""
    from fowtlib.language.data_files import digest_of
    from fowtlib.modelfile.files import shipped_models

    found = []
    for value in vars(arguments).values():
        if not isinstance(value, (str, os.PathLike)):
            continue
        try:
            path = shipped_models().get(str(value), Path(value))
            if path.is_file():
                found.append(f"{path} {path.stat().st_size} bytes sha256:{digest_of(path)}")
        except (OSError, ValueError):
            continue
    return found
