"""Files that are there already are refused before the work, and written over with --force."""

from __future__ import annotations

import os

import pytest

from fowtlib.cli.app import main

RUN = ["run", "pendulum", "--time", "1"]


def told(capsys: pytest.CaptureFixture[str], arguments: list[str], status: int) -> str:
    assert main(arguments) == status
    return capsys.readouterr().err


@pytest.mark.usefixtures("shipped_pendulum")
def test_a_result_that_is_there_is_not_written_over(capsys, tmp_path):
    told(capsys, [*RUN, "--output", "run.nc"], 0)
    before = (tmp_path / "run.nc").read_bytes()
    said = told(capsys, [*RUN, "--time", "2", "--output", "run.nc"], 2)
    assert f"run.nc is there already: pendulum, 0 to 1 s, {len(before)} bytes of 20" in said
    assert "Write over it with --force, or choose another name, or go on from it with --resume run.nc" in said
    assert (tmp_path / "run.nc").read_bytes() == before
    told(capsys, [*RUN, "--time", "2", "--output", "run.nc", "--force"], 0)
    assert "pendulum, 0 to 2 s" in told(capsys, [*RUN, "--output", "run.nc"], 2)


@pytest.mark.parametrize(
    "arguments",
    [
        [*RUN, "--output", "there.csv"],
        [*RUN, "--output", "there.outb"],
        [*RUN, "--plot", "there.png"],
        ["view", "pendulum", "-o", "there.html"],
        ["export", "pendulum", "-o", "there.fmu"],
        ["parameters", "pendulum", "-o", "there.csv"],
        ["decay", "pendulum", "--dof", "pitch", "--offset", "1", "--plot", "there.svg"],
    ],
)
@pytest.mark.usefixtures("shipped_pendulum")
def test_no_command_writes_over_a_file(capsys, tmp_path, arguments):
    (path := tmp_path / arguments[-1]).write_text("mine")
    said = told(capsys, arguments, 2)
    assert f"{path.name} is there already: 4 bytes of 20" in said and "--force" in said
    assert path.read_text() == "mine"


@pytest.mark.usefixtures("shipped_pendulum")
def test_a_page_without_a_name_says_what_it_replaces(capsys, tmp_path):
    (tmp_path / "pendulum.html").write_text("mine")
    assert "(0.1 MB) in place of 4 bytes of 20" in told(capsys, ["view", "pendulum"], 0)


@pytest.mark.parametrize(
    ("name", "words"),
    [("n" * 253 + ".nc", r"nnn\.\.\.: the name is too long; take one of at most 220 letters"),
     ("no/run.nc", "the folder no does not exist"), ("run\0.nc", "cannot hold a zero byte")],
)  # fmt: skip
@pytest.mark.usefixtures("shipped_pendulum")
def test_names_that_cannot_be_are_refused_before_the_run(capsys, tmp_path, name, words):
    import re

    said = told(capsys, [*RUN, "--output", name], 2)
    assert re.search(words, said) and "is expected" not in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="needs a folder that cannot be written")
@pytest.mark.usefixtures("shipped_pendulum")
def test_a_folder_that_cannot_be_written_is_refused_before_the_run(capsys, tmp_path):
    (folder := tmp_path / "closed").mkdir(mode=0o500)
    assert "cannot be written: Permission denied" in told(capsys, [*RUN, "--output", str(folder / "run.nc")], 2)
