"""Worker processes: they compute the same, a lost one costs only its case, and none outlives who has started it."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cases import Batch, Case, run_batch
from fowtlib.cases import pool as pools
from fowtlib.cases.job import DONE, FAILED, Job
from fowtlib.cases.pool import LocalWorkers
from fowtlib.language.errors import ModelError

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
RUN = """
import json, sys
from fowtlib.cases import Case, run_batch
cases, folder, workers = json.load(sys.stdin)
run_batch([Case.from_plain(case) for case in cases], folder, workers=workers)
"""


MODEL = """fowtlib: 1
python: own.py
world: {class: World}
hinge: {class: Revolute, n: [0, 1, 0], phi_start: 20 deg}
rod: {class: FixedTranslation, r: [0, 0, -1]}
bob: {class: PointMass, mass: 2 kg}
connect: [[world.frame, hinge.frame_a], [hinge.frame_b, rod.frame_a], [rod.frame_b, bob.frame_a]]
"""


def spars(count, duration=100.0, **changes):
    return [Case(f"s{k}", "oc3_spar_rigid", {"wind.kind": "steady", "wind.mean_speed": 7.0 + 0.1 * k},
                 start="file", duration=duration, output_step=0.5, outputs=("surge", "pitch"), **changes)
            for k in range(count)]  # fmt: skip


def started(cases, folder, workers):
    process = subprocess.Popen([sys.executable, "-c", RUN], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)  # fmt: skip
    json.dump([[case.plain() for case in cases], str(folder), workers], process.stdin)
    process.stdin.close()
    return process


def children(pid: int) -> list[int]:
    """The worker processes of a process."""
    path = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(word) for word in path.read_text().split()] if path.exists() else []


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until(true, seconds=60.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_two_processes_compute_what_this_one_does(tmp_path):
    batch = run_batch(spars(4), tmp_path / "b.batch", workers=2)
    assert batch.counts["done"] == 4, [row.message for row in batch]
    plant = fw.load("oc3_spar_rigid").compile()
    for case in spars(4)[1:3]:
        alone = plant.simulate(conditions=case.conditions())
        result = batch.result(case.name)
        assert result.names == ["surge", "pitch"]
        assert np.array_equal(result.array("surge"), alone.array("surge"))
    assert {row.worker for row in batch} and (tmp_path / "b.batch/workers.log").read_text() == ""


def test_workers_use_one_thread_each(tmp_path, monkeypatch):
    """What a worker prints goes to its log, and does not get between what it tells."""
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    names = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"
    (tmp_path / "own.py").write_text(f"import os\nprint('threads', *map(os.environ.get, {names}))\n")
    (tmp_path / "m.yaml").write_text(MODEL)
    case = Case("a", str(tmp_path / "m.yaml"), duration=1.0)
    with pytest.raises(ModelError, match="the file wants to run the Python code in 'own.py'"):
        run_batch([case], tmp_path / "b.batch")
    run_batch([case], tmp_path / "b.batch", allow_python=True)
    assert (tmp_path / "b.batch/workers.log").read_text().startswith("threads 1 1\n")


@posix
def test_a_case_whose_worker_dies_is_tried_again_and_then_given_up(tmp_path, monkeypatch):
    kills = {"s1": 1, "s2": 9}

    def events():
        jobs = [Job(case.plain(), case.model, "", "") for case in spars(4, 2000.0)]
        for event in LocalWorkers(2, tmp_path / "log").carry_out(jobs):
            if event.kind == "started" and kills.get(event.name):
                kills[event.name] -= 1
                os.kill(int(event.worker.split()[1]), signal.SIGKILL)
            yield event

    told = list(events())
    ended = {event.name: event.outcome for event in told if event.kind == "ended"}
    assert {name: outcome.state for name, outcome in ended.items()} == {
        "s0": DONE,
        "s1": DONE,
        "s2": FAILED,
        "s3": DONE,
    }
    assert [event.name for event in told if event.kind == "lost"].count("s2") == pools.MOST_TRIES - 1
    assert "ended 3 times" in ended["s2"].message and "SIGKILL" in ended["s2"].message


def test_workers_that_cannot_start_are_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(ModelError, match="end before they can do anything .it ended with status 1"):
        run_batch(spars(2), tmp_path / "b.batch", workers=1)
    assert Batch.open(tmp_path / "b.batch").counts["due"] == 2


@posix
@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_a_batch_that_is_asked_to_end_does_so_soon(tmp_path, asked):
    folder = tmp_path / "b.batch"
    process = started([*spars(1, 10.0), Case("long", "oc3_spar_rigid", start="file", duration=1e6, output_step=10.0)],
                      folder, 1)  # fmt: skip
    wait_until(lambda: (folder / "batch.log").exists() and "started long" in (folder / "batch.log").read_text())
    workers = children(process.pid)
    process.send_signal(asked)
    process.wait(8)
    assert process.returncode != 0 and not any(map(alive, workers))
    rows = Batch.open(folder).rows()
    assert [row.state for row in rows] == ["done", "due"] and rows[1].why == "the batch was stopped"


@posix
def test_killed_at_any_moment_no_finished_case_is_lost_and_the_next_run_goes_on(tmp_path):
    """20 kills of the process that runs the batch or of a worker; FOWTLIB_TEST_KILLS asks for more."""
    kills, count = int(os.environ.get("FOWTLIB_TEST_KILLS", "20")), 60
    cases, folder = spars(count, 20.0), tmp_path / "b.batch"
    run_batch(cases[:1], folder, workers=1)  # what has to be compiled is
    chance, finished, dead = random.Random("kills"), {}, 0
    while dead < kills:
        process = started(cases, folder, 2)
        time.sleep(chance.uniform(0.2, 2.2))
        mine = children(process.pid)
        for victim in [process.pid] if dead % 2 or not mine else [chance.choice(mine)]:
            os.kill(victim, signal.SIGKILL)
            dead += 1
        if dead % 2 == 1 and dead < kills:  # of a worker: the batch itself goes on, and is killed next
            time.sleep(chance.uniform(0.0, 0.3))
            mine = children(process.pid) or mine
            process.kill()
            dead += 1
        process.wait(30)
        wait_until(lambda mine=mine: not any(map(alive, mine)), 5.0)  # none goes on alone
        now = {row.name: (row.ended, row.bytes) for row in Batch.open(folder).rows("done")}
        assert finished.items() <= now.items()  # what was finished was not done again
        for name in now.keys() - finished.keys():
            assert Batch.open(folder).result(name).time[-1] == 20.0
        finished = now
    batch = run_batch(cases, folder, workers=2)
    assert batch.counts == {"due": 0, "running": 0, "done": count, "failed": 0}
    assert finished.items() <= {row.name: (row.ended, row.bytes) for row in batch}.items()
    assert {path.suffix for path in folder.iterdir()} == {".nc", ".sqlite", ".log", ""}
    plant = fw.load("oc3_spar_rigid").compile()
    for case in chance.sample(cases, 3):
        alone = plant.simulate(conditions=case.conditions())
        assert np.array_equal(batch.result(case.name).array("pitch"), alone.array("pitch"))
