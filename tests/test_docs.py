"""The examples of README.md and docs/ run.

Of each page, in order: a block ```yaml title="NAME" is written to a file NAME; a ```python block is executed, and the
blocks of a page share their names; of a ```console block every line behind "$ " is run, and what follows it up to the
next one must be what it prints ("..." stands for any text). Blocks marked ```sh are for reading only.
"""

from __future__ import annotations

import doctest
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n(?P<text>.*?)^```$", re.M | re.S)
READ_ONLY = {"sh", "text", "json", "bibtex"}


def blocks(page: Path) -> Iterator[tuple[int, str, str, str]]:
    """The fenced blocks of a page as (line, language, title, text)."""
    text = page.read_text()
    for match in BLOCK.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        yield line, match["language"], match["title"] or "", match["text"]


def run_console(text: str, where: str) -> None:
    for command, expected in re.findall(r"^\$ ([^\n]*)\n((?:(?!\$ ).*\n)*)", text, re.M):
        run = subprocess.run(command, shell=True, capture_output=True, text=True)
        assert run.returncode == 0, f"{where}: {command}\n{run.stdout}{run.stderr}"
        flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        same = doctest.OutputChecker().check_output(expected, run.stdout, flags)
        assert not expected.strip() or same, f"{where}: {command} prints\n{run.stdout}\nand not\n{expected}"


@pytest.mark.parametrize("page", [page for page in PAGES if BLOCK.search(page.read_text())], ids=lambda page: page.stem)
def test_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    names: dict[str, object] = {"__name__": f"example_{page.stem}"}
    for line, language, title, text in blocks(page):
        where = f"{page.name}:{line}"
        if title:
            Path(title).write_text(text)
        elif language == "python":
            exec(compile("\n" * line + text, str(page), "exec"), names)
        elif language == "console":
            run_console(text, where)
        else:
            assert language in READ_ONLY, f"{where}: a block of {language} needs a title, or to be marked sh or text"


def test_every_page_is_in_the_table_of_contents():
    nav = tomllib.loads((ROOT / "zensical.toml").read_text())["project"]["nav"]
    listed = [page for entry in nav for page in entry.values()]
    assert sorted(listed) == sorted(page.name for page in PAGES if page.parent.name == "docs")


def test_the_catalogue_is_up_to_date():
    from fowtlib.cli import catalogue

    written = (ROOT / "docs" / "catalogue.md").read_text()
    assert written == catalogue.markdown(catalogue.classes()), "run `make catalogue`"


@pytest.mark.parametrize(
    ("name", "script"),
    [("verification", "verification"), ("load_cases", "load_cases"), ("dtu10mw", "verification_dtu10mw")],
)
def test_every_computed_table_has_its_command(name: str, script: str):
    source = (ROOT / "benchmarks" / f"{script}.py").read_text()
    computed = re.findall(r"^@section\ndef (\w+)", source, re.M)
    page = (ROOT / "docs" / f"{name}.md").read_text()
    filled = re.findall(r"<!-- begin (\w+) -->\n\|", page)
    assert sorted(filled) == sorted(computed), f"run `python benchmarks/{script}.py`"


def test_the_house_is_drawn_as_it_stands():
    """Every package of the project has its place on the page about the architecture."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    rooms = [name for name in packages if name != "fowtlib" and not name.startswith("fowtlib.components.")]
    missing = [name for name in rooms if f"| `{name}` |" not in text]
    of_parts = [name.split(".")[-1] for name in packages if name.startswith("fowtlib.components.")]
    missing += [name for name in of_parts if f"`{name}`" not in text]
    assert not missing
    named = re.findall(r"^\| `(fowtlib[\w.]*)` \|", text, re.M)
    assert sorted(named) == sorted(rooms)
