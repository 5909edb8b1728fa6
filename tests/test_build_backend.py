"""The editable install: Python finds the sources, and who only reads files finds the packages under their names."""

from __future__ import annotations

import base64
import hashlib
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("setuptools")
ROOT = Path(__file__).parents[1]
PROJECT = """
[build-system]
requires = ["setuptools"]
build-backend = "build_backend"
backend-path = ["."]

[project]
name = "fowtlib"
version = "0.0.1"

[tool.setuptools]
packages = ["fowtlib", "fowtlib.language", "fowtlib.components"]

[tool.setuptools.package-dir]
"fowtlib.components" = "components"
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    project = tmp_path_factory.mktemp("project")
    for folder in ("fowtlib", "fowtlib/language", "components"):
        (project / folder).mkdir()
        (project / folder / "__init__.py").write_text(f"NAME = '{folder}'\n")
    (project / "pyproject.toml").write_text(PROJECT)
    shutil.copy(ROOT / "build_backend.py", project)
    (project / "out").mkdir()
    code = "import build_backend as b; print(b.build_editable('out'))"
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code], cwd=project, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return project / "out" / run.stdout.split()[-1]


def test_python_finds_the_sources(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = (
        f"import site; site.addsitedir({str(tmp_path)!r}); site.addsitedir({str(tmp_path)!r})\n"
        "import fowtlib.components, fowtlib.language; print(fowtlib.components.__file__, fowtlib.language.__file__)"
    )
    run = subprocess.run([sys.executable, "-S", "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    project = wheel.parents[1]
    expected = [project / "components" / "__init__.py", project / "fowtlib" / "language" / "__init__.py"]
    assert [Path(path) for path in run.stdout.split()] == expected


def test_who_reads_files_finds_the_packages(wheel):
    with zipfile.ZipFile(wheel) as archive:
        pth = next(name for name in archive.namelist() if name.endswith(".pth"))
        lines = archive.read(pth).decode().splitlines()
        digest = base64.urlsafe_b64encode(hashlib.sha256(archive.read(pth)).digest()).rstrip(b"=").decode()
        record = next(name for name in archive.namelist() if name.endswith("RECORD"))
        assert f"{pth},sha256={digest},{len(archive.read(pth))}" in archive.read(record).decode().splitlines()
    folder = next(Path(line) for line in lines if not line.startswith("import"))
    for name in ("", "language", "components"):
        text = (folder / "fowtlib" / name / "__init__.py").read_text()
        assert text == f"NAME = '{('fowtlib/' + name).strip('/') if name != 'components' else name}'\n"


def test_the_source_archive_brings_the_backend(wheel):
    """Without it nothing can be built from the archive."""
    project = wheel.parents[1]
    shutil.copy(ROOT / "MANIFEST.in", project)
    code = "import build_backend as b; print(b.build_sdist('out'))"
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code], cwd=project, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    with tarfile.open(project / "out" / run.stdout.split()[-1]) as archive:
        assert "fowtlib-0.0.1/build_backend.py" in archive.getnames()
