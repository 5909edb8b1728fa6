"""Builds with setuptools, and makes an editable install visible to type checkers and editors.

The packages lie in fowtlib/, components/ and models/, and are imported as fowtlib, fowtlib.components and
fowtlib.models. An editable install of setuptools finds them by a hook that runs in Python, and who only reads files
(pyright, mypy, an editor) finds nothing. Here the wheel of such an install also names a folder `.editable` beside this
file, in which links show the packages as they are imported. Python itself asks the hook first, so that its paths are
those of the sources. Where links cannot be made the install is that of setuptools.
"""

from __future__ import annotations

import base64
import hashlib
import os
import tomllib
import zipfile
from pathlib import Path
from typing import Any

from setuptools.build_meta import (
    build_editable as _build_editable,
)
from setuptools.build_meta import (
    build_sdist,
    build_wheel,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]
ROOT = Path(__file__).parent
HOOK_FIRST = "import sys, {0}; m = sys.meta_path; m.remove({0}._EditableFinder); m.insert(0, {0}._EditableFinder)"


def build_editable(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """The wheel of an editable install (PEP 660)."""
    name = _build_editable(wheel_directory, config_settings, metadata_directory)
    try:
        folder = link_packages(ROOT)
    except OSError:  # Windows gives links to developers and administrators only
        return name
    _add_path(Path(wheel_directory) / name, folder)
    return name


def link_packages(root: Path) -> Path:
    """The folder `.editable` of a project, with links to its packages as they are imported."""
    settings = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    places = {package.split(".")[1]: root / folder for package, folder in settings["package-dir"].items()}
    sources = {path.name: path for path in (root / "fowtlib").iterdir() if path.name != "__pycache__"} | places
    links = root / ".editable" / "fowtlib"
    links.mkdir(parents=True, exist_ok=True)
    for old in links.iterdir():
        old.unlink()
    for name, source in sources.items():
        (links / name).symlink_to(os.path.relpath(source, links), target_is_directory=source.is_dir())
    return links.parent


def _add_path(wheel: Path, folder: Path) -> None:
    """Name a folder in the .pth of the wheel, behind the hook that the .pth installs."""
    with zipfile.ZipFile(wheel) as old:
        files = {info.filename: old.read(info) for info in old.infolist()}
    pth = next((name for name in files if name.endswith(".pth")), None)
    if pth is None or b"install()" not in files[pth]:  # config_settings asked for another kind of install
        return
    hook = next(name for name in files if name.endswith("_finder.py")).removesuffix(".py")
    files[pth] = files[pth].rstrip() + f"\n{HOOK_FIRST.format(hook)}\n{folder}\n".encode()
    record = next(name for name in files if name.endswith(".dist-info/RECORD"))
    digest = base64.urlsafe_b64encode(hashlib.sha256(files[pth]).digest()).rstrip(b"=").decode()
    lines = files[record].decode().splitlines()
    entry = f"{pth},sha256={digest},{len(files[pth])}"
    files[record] = ("\n".join(entry if line.startswith(f"{pth},") else line for line in lines) + "\n").encode()
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as new:
        for name, content in files.items():
            new.writestr(name, content)
