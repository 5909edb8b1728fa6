"""Folders that stand in for the cache: those of processes that were killed go, those in use and of others stay."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time

import pytest

from fowtlib.language import left_over
from fowtlib.language.stand_in import PREFIX

pytestmark = pytest.mark.skipif(left_over.fcntl is None, reason="no program can tell on Windows")
MAKER = """
import errno, sys, time, warnings
from pathlib import Path
from fowtlib.language import cache_folder, stand_in
warnings.simplefilter("ignore")
print(stand_in.make_stand_in(cache_folder.named_folder(), OSError(errno.EROFS, "Read-only file system")), flush=True)
if sys.argv[1] == "parent":
    import subprocess
    user = "from fowtlib.language import cache_folder; print(cache_folder.cache_folder(), flush=True); input()"
    subprocess.Popen([sys.executable, "-c", user], stdin=0)
time.sleep(60)
"""


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """An empty temporary folder, for this process and those it starts."""
    for name in ("TMPDIR", "TEMP", "TMP"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.delenv("FOWTLIB_CACHE_STAND_IN", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", None)
    yield tmp_path
    tempfile.tempdir = None


def started(kind="alone"):
    """A process with a folder of its own, and that folder."""
    process = subprocess.Popen([sys.executable, "-c", MAKER, kind], stdout=subprocess.PIPE, stdin=subprocess.PIPE,
                               text=True)  # fmt: skip
    return process, process.stdout.readline().strip()


def killed(process):
    process.send_signal(signal.SIGKILL)
    process.wait()


def aged(folder):
    """As if nothing had been done there for a day."""
    os.utime(folder, (time.time() - 86400,) * 2)


def test_the_folder_of_a_process_that_was_killed_goes_once_it_is_old(temporary):
    process, folder = started()
    killed(process)
    left_over.remove_left_over(PREFIX)
    assert os.path.isdir(folder)  # a moment old
    aged(folder)
    left_over.remove_left_over(PREFIX)
    assert not os.path.exists(folder)


def test_a_folder_in_use_stays(temporary):
    process, folder = started()
    aged(folder)
    left_over.remove_left_over(PREFIX)
    assert os.path.isdir(folder)
    killed(process)
    left_over.remove_left_over(PREFIX)
    assert not os.path.exists(folder)


def test_a_folder_stays_that_a_process_uses_whose_parent_was_killed(temporary):
    process, folder = started("parent")
    assert process.stdout.readline().strip() == folder  # the second one uses it too
    killed(process)
    aged(folder)
    left_over.remove_left_over(PREFIX)
    assert os.path.isdir(folder)
    process.stdin.write("\n")
    process.stdin.close()  # the second one ends
    assert process.stdout.read() == ""
    for _ in range(100):
        left_over.remove_left_over(PREFIX)
        if not os.path.exists(folder):
            break
        time.sleep(0.05)
    assert not os.path.exists(folder)


def test_what_was_never_held_or_is_of_another_machine_stays(temporary):
    strange, other = temporary / f"{PREFIX}strange", temporary / f"{PREFIX}other"
    for folder in (strange, other):
        folder.mkdir()
    (other / left_over.LOCK).write_text("another-machine")
    link = temporary / f"{PREFIX}link"
    link.symlink_to(other)
    for folder in (strange, other):
        aged(folder)
    left_over.remove_left_over(PREFIX)
    assert strange.is_dir() and other.is_dir() and link.is_symlink()
