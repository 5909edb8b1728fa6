"""The FMUs of the tests, see controller_fmu.py."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from fowtlib.language.native import compiler

sys.path.insert(0, str(Path(__file__).parent))

import controller_fmu


@pytest.fixture(scope="session")
def fmu_files(tmp_path_factory) -> Callable[..., dict[str, bytes | str]]:
    """The files of a good FMU of a version, 2 or 3, with another description where one is given."""
    pytest.importorskip("fmpy")
    if not compiler():
        pytest.skip("no C compiler")
    folder, libraries = tmp_path_factory.mktemp("libraries"), {}

    def files(version: int = 2, description: str = "") -> dict[str, bytes | str]:
        if version not in libraries:
            libraries[version] = controller_fmu.compiled(version, folder)
        return controller_fmu.files(version, libraries[version], description)

    return files


@pytest.fixture(scope="session")
def archive() -> Callable[[Path, Mapping[str, bytes | str]], Path]:
    """Writes a zip archive of files."""
    return controller_fmu.write


@pytest.fixture(scope="session")
def fmu(fmu_files, archive, tmp_path_factory) -> Callable[..., str]:
    """The path of an FMU of a version; `change` replaces one text of its description by another."""
    folder, made = tmp_path_factory.mktemp("fmus"), {}

    def make(version: int = 2, change: tuple[str, str] = ("", "")) -> str:
        if (version, change) not in made:
            text = controller_fmu.description_2() if version == 2 else controller_fmu.description_3()
            assert change[0] in text
            files = fmu_files(version, text.replace(*change) if change[0] else text)
            made[version, change] = archive(folder / f"controller_{len(made)}.fmu", files)
        return str(made[version, change])

    return make


@pytest.fixture(autouse=True)
def temporary_files_of_its_own(tmp_path_factory, monkeypatch):
    """What a test leaves there is its own, whatever runs beside it."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path_factory.mktemp("temporary")))
