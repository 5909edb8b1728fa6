"""Every command writes to any output: on Windows a file or a pipe has cp1252, on a bare Linux ASCII."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys

import pytest

import fowtlib as fw
from fowtlib.cli import encoding
from fowtlib.cli.app import main

COMMANDS = [
    ["--help"], ["run", "--help"], ["tree", "M"], ["check", "M"], ["equations", "M"], ["equations", "M", "--csv"],
    ["parameters", "M"], ["parameters", "M", "--json"], ["equilibrium", "M"], ["eigen", "M"],
    ["run", "M", "--time", "1"], ["run", "M", "--time", "1", "--csv"],
    ["decay", "M", "--dof", "höhe", "--offset", "5", "--time", "20"],
    ["models"], ["parts"], ["parts", "--json"], ["parts", "--markdown"], ["parts", "RigidBody"],
    ["schema"], ["view", "M"],
    ["export", "M", "--kind", "me"],
]  # fmt: skip


def written(monkeypatch: pytest.MonkeyPatch, name: str, argv: list[str]) -> tuple[int, str]:
    """Exit status and what is written to an output of this encoding, with strict errors as a pipe has them."""
    target = io.BytesIO()
    stream = io.TextIOWrapper(target, encoding=name, errors="strict", write_through=True)
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setattr(sys, "stderr", io.TextIOWrapper(io.BytesIO(), encoding=name, errors="strict"))
    try:
        status = main(argv)
    except SystemExit as ended:
        status = int(ended.code or 0)
    return status, target.getvalue().decode(name)


@pytest.fixture
def foreign(shipped_pendulum, monkeypatch):
    """The pendulum with a title and results in letters that cp1252 or ASCII lack."""
    model = fw.load("pendulum")
    model.title = "Wahadło Ω – 振り子"
    model.outputs = {"höhe": model.outputs["pitch"], "ω→": fw.Output("hinge.w", "deg/s", "prędkość in °/s")}
    monkeypatch.setattr(fw, "load", lambda name, **_: model)


@pytest.mark.usefixtures("foreign")
@pytest.mark.parametrize("name", ["cp1252", "latin-1", "ascii"])
@pytest.mark.parametrize("argv", COMMANDS, ids=" ".join)
def test_every_command_writes_to_any_encoding(monkeypatch, argv, name):
    status, text = written(monkeypatch, name, argv)
    assert status == 0 and (text or argv[0] in ("view", "export"))


@pytest.mark.usefixtures("foreign")
def test_the_tree_in_plain_characters(monkeypatch):
    assert "├── hinge: Revolute" in written(monkeypatch, "utf-8", ["tree", "M"])[1]
    lines = written(monkeypatch, "cp1252", ["tree", "M"])[1].splitlines()
    assert lines[0] == "Wahadlo ? – ???: Assembly"  # cp1252 has the dash
    assert "|-- hinge: Revolute" in lines and "`-- ground: FixedFlange" in lines


@pytest.mark.usefixtures("foreign")
def test_json_loses_nothing(monkeypatch):
    text = written(monkeypatch, "ascii", ["run", "M", "--time", "1", "--json"])[1]
    assert {row["result"] for row in json.loads(text)} == {"höhe", "ω→"}


def test_plain_text():
    assert encoding.plain("┌─┐ 3° ± 0.1 µm, é à") == "+-+ 3deg +- 0.1 um, e a"
    assert encoding.plain("plain") == "plain"


def test_a_message_on_stderr_and_a_pipe_of_a_real_process(tmp_path):
    """`fowt` as Windows has it: the interpreter is told the encoding of its output."""
    environment = {**os.environ, "PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"}
    run = subprocess.run([sys.executable, "-m", "fowtlib.cli", "tree", "oc3_spar_rigid"], capture_output=True,
                         env=environment, cwd=tmp_path)  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert b"|-- world: World" in run.stdout
    run = subprocess.run([sys.executable, "-m", "fowtlib.cli", "tree", "Ω"], capture_output=True, env=environment,
                         cwd=tmp_path)  # fmt: skip
    assert run.returncode == 2 and b"'?'" in run.stderr
