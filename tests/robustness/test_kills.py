"""Runs ended from outside: by Ctrl-C and the request to end, which save the results, and by force, to go on from."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")

PIECE = 0.2  # s between two pieces here, so that the runs can be short
COMMAND = f"""
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # as in a terminal; a shell may have taken it away
import fowtlib.solving.run
fowtlib.solving.run.PIECE = {PIECE}
from fowtlib.cli.app import main
raise SystemExit(main())
"""
MODEL = ["run", "oc3_spar_rigid", "--wind", "steady:9", "--waves", "still"]


def started(*words: object) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def wait_for(path: Path, process: subprocess.Popen, newer: float = 0.0) -> None:
    """Until a file is there that was written after a time."""
    end = time.monotonic() + 120  # with what has to be compiled first
    while not path.exists() or path.stat().st_mtime <= newer:
        assert process.poll() is None, process.communicate()[0]
        assert time.monotonic() < end
        time.sleep(0.01)


EARLY = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)

class Finder:
    def find_spec(self, name, *_):
        if name == sys.argv[1]:
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Finder())
from fowtlib.cli import main
raise SystemExit(main())
"""


@pytest.mark.parametrize("name", ["fowtlib.cli.app", "fowtlib.cli.results", "fowtlib.language.errors"])
def test_the_program_is_stopped_while_it_begins(name):
    """Half a second of imports: one line as later, and no traceback."""
    run = subprocess.run([sys.executable, "-c", EARLY, name, "run", "oc3_spar"], capture_output=True, text=True)
    assert (run.returncode, run.stdout, run.stderr) == (130, "", "fowt: stopped; nothing was saved.\n")


COMPILER = """#!/bin/sh
if [ "$1" = --version ]; then echo 1; exit; fi
sh -c 'echo $$ >> "$BEGUN"; exec sleep 60' &
wait
"""
COMPILING = """
import os, signal, sys, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from fowtlib.cli import app
from fowtlib.language import native

def press():
    while not os.path.exists(os.environ["BEGUN"]):
        time.sleep(0.01)
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=press, daemon=True).start()
try:
    native.begin_library("int beside;", "beside") if sys.argv[1] == "beside" else native.compile_library("int a;", "a")
    time.sleep(60)
except KeyboardInterrupt:
    app._leave(130)
"""


@pytest.mark.parametrize("where", ["here", "beside"])
def test_no_compiler_stays_behind(tmp_path, monkeypatch, where):
    """Ctrl-C for the process alone, while a compiler with a process of its own is at work, here or in a thread."""
    compiler, begun = tmp_path / "compiler", tmp_path / "begun"
    compiler.write_text(COMPILER)
    compiler.chmod(0o755)
    monkeypatch.setenv("FOWTLIB_CC", str(compiler))
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("BEGUN", str(begun))
    assert subprocess.run([sys.executable, "-c", COMPILING, where], timeout=50).returncode == 130
    (number,) = map(int, begun.read_text().split())
    end = time.monotonic() + 20  # it would sleep for a minute
    while is_at_work(number):
        assert time.monotonic() < end
        time.sleep(0.01)


def is_at_work(number: int) -> bool:
    said = subprocess.run(["ps", "-o", "stat=", "-p", str(number)], capture_output=True, text=True).stdout.strip()
    return bool(said) and not said.startswith("Z")


@pytest.mark.parametrize(
    ("asked", "status", "solver", "output_step"),
    [
        (signal.SIGINT, 130, "idas", 100),
        (signal.SIGTERM, 130, "idas", 1e5),
        (signal.SIGINT, 130, "fixed", 1e5),
        (signal.SIGTERM, 130, "fixed", 100),
    ],
)
def test_a_run_with_long_output_steps_ends_soon_when_asked_and_keeps_its_results(
    tmp_path, asked, status, solver, output_step
):
    """The whole run would take minutes; with 1e5 s the first output point alone takes longer than this waits."""
    path = tmp_path / "x.nc"
    run = started(*MODEL, "--time", 1e6, "--output-step", output_step, "--solver", solver, "--output", path)
    wait_for(tmp_path / "x.nc.part.state", run)
    run.send_signal(asked)
    said, _ = run.communicate(timeout=100)  # far less than the run takes
    assert run.returncode == status, said
    result = fw.Result.open(path)
    assert result.time[-1] > 0 and "interrupted" in said and str(path) in said
    assert all(np.isfinite(result.array(name)).all() for name in result.names)
    assert [file.name for file in tmp_path.iterdir()] == ["x.nc"]


def test_a_run_whose_equations_cannot_be_stopped_ends_in_order(tmp_path, monkeypatch):
    """Without a compiler CasADi goes on in its thread, and there are no results yet: nothing stays behind."""
    monkeypatch.setenv("FOWTLIB_CC", "none")
    path = tmp_path / "x.nc"
    run = started(*MODEL, "--time", 1e6, "--output-step", 100, "--output", path)
    wait_for(tmp_path / "x.nc.part", run)
    run.send_signal(signal.SIGINT)
    said, _ = run.communicate(timeout=100)  # far less than the run takes
    assert run.returncode == 130, said
    assert "interrupted" in said and not (tmp_path / "x.nc.part").exists()


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_a_run_killed_three_times_equals_one_that_was_not(tmp_path, solver):
    words = [*MODEL, "--time", 24000 if solver == "idas" else 12000, "--output-step", 0.25, "--solver", solver]
    whole, path = tmp_path / "whole.nc", tmp_path / "x.nc"
    said, _ = (run := started(*words, "--output", whole)).communicate()
    assert run.returncode == 0, said
    chance, left, written = random.Random(f"kills {solver}"), tmp_path / "x.nc.part.state", 0.0
    kills = 0
    while kills < 3 and not path.exists():  # on a fast computer the run may come to its end before the third
        run = started(*words, "--output", path, *(["--resume", path] if kills else []))
        while run.poll() is None and not (left.exists() and left.stat().st_mtime > written):
            time.sleep(0.01)
        time.sleep(chance.uniform(0.0, PIECE))
        run.kill()
        said = run.communicate()[0]
        assert run.returncode in (0, -signal.SIGKILL), said
        kills += run.returncode != 0
        written = left.stat().st_mtime if left.exists() else written
    assert kills > 0
    if not path.exists():
        said, _ = (run := started(*words, "--output", path, "--resume", path)).communicate()
        assert run.returncode == 0, said
    one, other = fw.Result.open(whole), fw.Result.open(path)
    assert one.names == other.names
    assert np.array_equal(one.time, other.time)
    for name in one.names:
        assert np.array_equal(one.array(name), other.array(name)), name
    for part in "xzd":
        assert np.array_equal(getattr(one.raw, part), getattr(other.raw, part))
