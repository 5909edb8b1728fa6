"""Worker processes: they compute the same, a lost one costs only its case, and none outlives who has started it."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import sys
import time
from contextlib import suppress
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
    monkeypatch.setattr(pools, "MOST_TRIES", 2)
    kills = {"s0": 1, "s1": 9}

    def events():
        jobs = [Job(case.plain(), case.model, "", "") for case in spars(3, 2000.0)]
        for event in LocalWorkers(2, tmp_path / "log").carry_out(jobs):
            if event.kind == "started" and kills.get(event.name):
                kills[event.name] -= 1
                os.kill(int(event.worker.split()[1]), signal.SIGKILL)
            yield event

    told = list(events())
    ended = {event.name: event.outcome for event in told if event.kind == "ended"}
    assert {name: outcome.state for name, outcome in ended.items()} == {"s0": DONE, "s1": FAILED, "s2": DONE}
    assert sorted(event.name for event in told if event.kind == "lost") == ["s0", "s1"]
    assert "ended 2 times" in ended["s1"].message and "SIGKILL" in ended["s1"].message


def test_workers_that_cannot_start_are_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(ModelError, match="end before they can do anything .it ended with status 1"):
        run_batch(spars(2), tmp_path / "b.batch", workers=1)
    assert Batch.open(tmp_path / "b.batch").counts["due"] == 2


@posix
def test_a_batch_that_is_asked_to_end_does_so_soon(tmp_path, python_handler):
    folder, asked, others = tmp_path / "b.batch", [], set(children(os.getpid()))  # of other tests
    cases = [*spars(1, 10.0), Case("long", "oc3_spar_rigid", start="file", duration=1e6, output_step=10.0)]

    def ask(number):
        def report(progress):
            if progress.done and progress.simulated > 10 and len(asked) < number:
                asked.append(time.monotonic())
                workers.extend(set(children(os.getpid())) - others)
                os.kill(os.getpid(), (signal.SIGINT, signal.SIGTERM)[number - 1])

        return report

    for number in (1, 2):
        workers = []
        with pytest.raises(KeyboardInterrupt):
            run_batch(cases, folder, workers=1, progress=ask(number))
        assert time.monotonic() - asked[-1] < 60, "a case of hours was waited for"
        assert workers and not any(map(alive, workers))
        rows = Batch.open(folder).rows()
        assert [row.state for row in rows] == ["done", "due"] and rows[1].why == "the batch was stopped"


@posix
def test_killed_at_any_moment_no_finished_case_is_lost_and_the_next_run_goes_on(tmp_path):
    """20 kills: of a worker, of the other, of the process that runs the batch; FOWTLIB_TEST_KILLS asks for more."""
    kills = int(os.environ.get("FOWTLIB_TEST_KILLS", "20"))
    model, folder = tmp_path / "m.yaml", tmp_path / "b.batch"
    model.write_text(MODEL.replace("python: own.py\n", ""))

    def cases(count):
        return [Case(f"m{k}", str(model), {"bob.mass": 1.0 + k}, duration=1000.0, output_step=0.02, solver="fixed")
                for k in range(count)]  # fmt: skip

    run_batch(cases(1), folder, workers=1)  # what has to be compiled is
    started = multiprocessing.get_context("forkserver")  # of a process without threads, so that no lock stays shut
    started.set_forkserver_preload(["fowtlib.cases"])
    chance, finished, dead = random.Random("kills"), {}, 0

    def number_of_done():
        return Batch.open(folder).counts["done"]

    while dead < kills:
        runs = started.Process(target=run_batch, args=(cases(len(finished) + 8), folder), kwargs={"workers": 2})
        runs.start()
        if chance.random() < 0.7:  # else while the workers start
            before = len(finished)
            wait_until(lambda before=before: number_of_done() > before)
        mine = children(runs.pid)
        for victim in (*chance.sample(mine, len(mine)), runs.pid):
            time.sleep(chance.uniform(0.0, 0.1))
            with suppress(ProcessLookupError):  # all was done already
                os.kill(victim, signal.SIGKILL)
                dead += 1
        runs.join()
        assert runs.exitcode in (-signal.SIGKILL, 0)
        wait_until(lambda mine=mine: not any(map(alive, mine)), 5.0)  # none goes on alone
        now = {row.name: (row.ended, row.bytes) for row in Batch.open(folder).rows("done")}
        assert finished.items() <= now.items()  # what was finished was not done again
        for name in now.keys() - finished.keys():
            assert Batch.open(folder).result(name).time[-1] == 1000.0
        finished = now
    assert len(finished) > 1
    every = cases(len(finished) + 8)
    batch = run_batch(every, folder, workers=2)
    assert batch.counts == {"due": 0, "running": 0, "done": len(every), "failed": 0}
    assert finished.items() <= {row.name: (row.ended, row.bytes) for row in batch}.items()
    assert {path.suffix for path in folder.iterdir()} == {".nc", ".sqlite", ".log", ""}
    done = [line.split()[3] for line in (folder / "batch.log").read_text().splitlines() if " done  " in line]
    assert len(done) == len(set(done)) > len(every) / 2  # none twice
    plant = fw.load(model).compile()
    for case in chance.sample(every, 3):
        alone = plant.simulate(conditions=case.conditions(), solver="fixed")
        assert np.array_equal(batch.result(case.name).array("hinge.phi"), alone.array("hinge.phi"))
