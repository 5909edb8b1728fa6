"""A short part of the attack: a few hundred inputs of each kind. The long part is `make torture`."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import attempts
import data_files
import pool
import torture

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the attack forks, and asks /proc for its size")


@pytest.fixture(scope="module", autouse=True)
def warmed():
    torture.warm()


def failures(outcomes: list[pool.Outcome]) -> list[str]:
    return [f"{outcome.kind}: {outcome.name}: {outcome.words[-300:]}" for outcome in outcomes if outcome.kind in FAILED]


FAILED = (pool.RAW, pool.HANG, pool.MEMORY, pool.CRASH, pool.CHANGED)


def test_mutated_model_files_are_read_or_refused(tmp_path):
    outcomes = list(pool.run(attempts.model_attempts(300), keep=tmp_path))
    assert not failures(outcomes)
    kinds = Counter(outcome.kind for outcome in outcomes)
    assert kinds[pool.REFUSED] > 200 and kinds[pool.OK] > 10


def test_damaged_data_files_are_read_or_refused(tmp_path):
    outcomes = list(pool.run(attempts.data_attempts(600), keep=tmp_path))
    assert not failures(outcomes)
    assert Counter(outcome.kind for outcome in outcomes)[pool.REFUSED] > 300


def test_a_damaged_archive_never_gives_other_numbers(tmp_path):
    fmu = next(kind for kind in data_files.KINDS if kind.name == "tank.fmu")
    content, known = data_files.good(fmu)
    for at in range(0, len(content), 7):
        damaged = bytearray(content)
        damaged[at] ^= 4
        folder = tmp_path / str(at)
        folder.mkdir()
        (folder / fmu.name).write_bytes(damaged)
        try:
            value = fmu.read(folder / fmu.name)
        except attempts.ModelError:
            continue
        assert data_files.digest(value) == known, f"byte {at}"


def _spins(folder):
    while True:
        pass


def _waits(folder):
    import time

    time.sleep(3600)


def _grows(folder):
    return pool.OK, str(len(bytearray(3 * 10**9)))


def _falls(folder):
    import os
    import signal

    os.kill(os.getpid(), signal.SIGSEGV)


def _raises(folder):
    raise ZeroDivisionError("a fault")


def test_the_pool_tells_what_became_of_an_input(tmp_path):
    acts = {"spins": _spins, "grows": _grows, "falls": _falls, "raises": _raises, "ok": lambda folder: (pool.OK, "")}
    found = pool.run([pool.Attempt(*item) for item in acts.items()], keep=tmp_path, seconds=1)
    kinds = {outcome.name: outcome.kind for outcome in found}
    expected = {"spins": pool.HANG, "grows": pool.MEMORY, "falls": pool.CRASH, "raises": pool.RAW, "ok": pool.OK}
    assert kinds == expected
    assert (tmp_path / "raw_error" / "raises" / "outcome.txt").read_text().count("ZeroDivisionError")


def test_an_input_that_waits_is_ended_by_the_clock(tmp_path):
    (outcome,) = pool.run([pool.Attempt("waits", _waits)], seconds=1, patience=0.5)
    assert outcome.kind == pool.HANG and "no end after 0.5 s" in outcome.words
