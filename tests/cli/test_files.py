"""Files that are there already are refused before the work, and written over with --force."""

from __future__ import annotations

import os
from contextlib import nullcontext

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


# --- what a run that was killed has left -----------------------------------------------------------------------------


@pytest.fixture
def killed(shipped_pendulum, monkeypatch, capsys):
    """Lets `fowt run` to run.nc end at a time as by a kill, with pieces as short as can be."""
    import fowtlib as fw

    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)

    class Killed(BaseException):
        pass

    def kill(at: float, *more: str) -> None:
        def report(t: float, t_end: float) -> None:
            if t >= at:
                raise Killed

        with monkeypatch.context() as patch, pytest.raises(Killed):
            patch.setattr("fowtlib.cli.run.progress_bar", lambda begin: nullcontext(report))
            main(["run", "pendulum", "--time", "30", "--output", "run.nc", *more])
        capsys.readouterr()

    assert fw.load("pendulum").name == "pendulum"
    return kill


def whole() -> bytes:
    assert main(["run", "pendulum", "--time", "30", "--output", "whole.nc", "--force"]) == 0
    return numbers("whole.nc")


def numbers(name: str) -> bytes:
    result = fw_result(name)
    return result.time.tobytes() + result.raw.x.tobytes() + result.array("pitch").tobytes()


def fw_result(name: str):
    from fowtlib.solving.results import Result

    return Result.open(name)


def test_a_run_that_was_killed_goes_on(killed, capsys, tmp_path):
    killed(20.0)
    said = told(capsys, ["run", "pendulum", "--time", "30", "--output", "run.nc"], 2)
    assert "run.nc.part: a run to this file was killed" in said and "--resume run.nc" in said
    killed(27.0, "--resume", "run.nc")
    told(capsys, ["run", "pendulum", "--time", "30", "--resume", "run.nc", "--output", "run.nc"], 0)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert numbers("run.nc") == whole()


def test_a_run_that_was_killed_before_anything_was_written_begins_anew(killed, capsys, tmp_path):
    killed(0.0)
    said = told(capsys, ["run", "pendulum", "--time", "30", "--resume", "run.nc", "--output", "run.nc"], 0)
    assert "run.nc.part, which a run that was killed has left, holds nothing to go on from; the run begins anew" in said
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert numbers("run.nc") == whole()


def test_what_reaches_further_counts(killed, capsys, tmp_path):
    told(capsys, ["run", "pendulum", "--time", "12", "--output", "run.nc"], 0)
    killed(20.0, "--resume", "run.nc")
    assert fw_result("run.nc").time[-1] == 12.0
    said = told(capsys, ["run", "pendulum", "--time", "30", "--resume", "run.nc", "--output", "run.nc"], 0)
    assert "goes on from run.nc.part, which a run that was killed has left: it reaches further than run.nc" in said
    assert numbers("run.nc") == whole()
    told(capsys, ["run", "pendulum", "--time", "36", "--resume", "run.nc", "--output", "run.nc"], 0)


def test_a_damaged_journal_beside_a_result(killed, capsys, tmp_path):
    told(capsys, ["run", "pendulum", "--time", "12", "--output", "run.nc"], 0)
    killed(20.0, "--resume", "run.nc")
    (tmp_path / "run.nc.part").write_bytes(b"nothing of the kind")
    said = told(capsys, ["run", "pendulum", "--time", "30", "--resume", "run.nc", "--output", "run.nc"], 0)
    assert "run.nc.part, which a run that was killed has left, cannot be read; the run goes on from run.nc" in said
    assert numbers("run.nc") == whole()


def test_what_a_resumed_run_has_left_is_not_written_over(killed, capsys, tmp_path):
    told(capsys, ["run", "pendulum", "--time", "12", "--output", "first.nc"], 0)
    killed(20.0, "--resume", "first.nc")
    again = ["run", "pendulum", "--time", "30", "--resume", "first.nc", "--output", "run.nc"]
    assert "To go on from there: --resume run.nc" in told(capsys, again, 2)
    told(capsys, ["run", "pendulum", "--time", "30", "--resume", "run.nc", "--output", "run.nc"], 0)
    assert numbers("run.nc") == whole()
