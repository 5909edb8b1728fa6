"""Ctrl-C while C code is compiled beside the command, and by the command itself."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fowtlib.language import cache_folder as store
from fowtlib.language.native import compiler

pytestmark = pytest.mark.skipif(not compiler() or sys.platform == "win32", reason="a compiler in a script of the shell")
DEADLINE = 300  # s, of a machine with far more work than cores


def _heeded():
    """As in a terminal: a shell may have given the tests a signal that is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("whole_group", [True, False], ids=["group", "process"])
@pytest.mark.parametrize("texts", [2, 3], ids=["beside", "waited_for"])
def test_a_run_stops_while_it_compiles(tmp_path, texts, whole_group):
    """texts: how many compilers have begun; for the third the command waits, the first, of the processor, is done.

    A terminal stops the whole group.
    """
    told, go, script, cache = (tmp_path / name for name in ("told", "go", "slow_cc", "cache"))
    command = shlex.join(compiler())
    lines = [f'case "$1" in --version) exec {command} --version;; esac', f"echo text >> {told}",
             f'[ "$(wc -l < {told})" -gt 1 ] || exec {command} "$@"',
             f"while [ ! -e {go} ]; do sleep 0.02; done", f'exec {command} "$@"']  # fmt: skip
    script.write_text("\n".join(["#!/bin/sh", *lines, ""]))
    script.chmod(0o700)
    fowt = Path(sys.executable).with_name("fowt")
    process = subprocess.Popen(
        [fowt, "run", "oc3_spar_rigid", "--solver=fixed", "--start=file", "--time=1", "--output=run.nc"],
        cwd=tmp_path, env=os.environ | {"FOWTLIB_CACHE": str(cache), "FOWTLIB_CC": str(script)},
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, preexec_fn=_heeded,
    )  # fmt: skip
    try:
        began = time.monotonic()
        while not told.exists() or told.read_text().count("\n") < texts:
            assert process.poll() is None and time.monotonic() - began < DEADLINE
            time.sleep(0.02)
        done = {*cache.glob("processor_*")}
        assert {*cache.glob("*.so")} < done
        (os.killpg if whole_group else os.kill)(process.pid, signal.SIGINT)
        assert process.wait(DEADLINE) == 130
    finally:
        go.touch()  # a compiler that was left comes to its end
        said = process.communicate()
    assert said[1] == "fowt run: stopped; nothing was saved.\n" and not said[0]
    left = list(cache.iterdir()) if cache.exists() else []
    for path in {*left} - done:  # what is there is whole
        assert path.is_file() and path.suffix == ".json" and not store._problem(path)
    assert not list(tmp_path.glob("run.nc*"))
