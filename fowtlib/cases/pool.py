"""Worker processes on this computer, and what they tell."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fowtlib.cases.job import FAILED, STOPPED, Job, Outcome
from fowtlib.language.errors import ModelError

MOST_TRIES = 3  # of a case whose worker ends under it
TICK = 0.2  # s after which a pool gives way, so that its user can look at other things
_PATIENCE = 3.0  # s for a worker to end by itself
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS",
               "NUMEXPR_NUM_THREADS", "BLIS_NUM_THREADS")  # fmt: skip


@dataclass(frozen=True)
class Event:
    """What has happened: to which case, "" for nothing.

    kind: started, at (it is at the time `at` of `end` [s]), ended (with `outcome`), lost (its worker has ended; it is
    tried again) or nothing. worker: in words.
    """

    kind: str = "nothing"
    name: str = ""
    worker: str = ""
    at: float = 0.0
    end: float = 0.0
    outcome: Outcome | None = None
    words: str = ""


@dataclass
class _Worker:
    process: subprocess.Popen[bytes]
    ready: bool = False
    job: Job | None = None
    name: str = field(init=False)

    def __post_init__(self) -> None:
        self.name = f"process {self.process.pid}"


class LocalWorkers:
    """So many processes, each with the plants it has compiled. log: the file for what they print."""

    def __init__(self, count: int, log: Path):
        self.count, self.log = count, log
        self._workers: list[_Worker] = []
        self._heard: queue.SimpleQueue[tuple[_Worker, dict[str, Any] | None]] = queue.SimpleQueue()

    def carry_out(self, jobs: Sequence[Job]) -> Iterator[Event]:
        """Carry out jobs, and tell what happens; when the iterator is closed all processes end at once."""
        waiting, tries, in_vain = deque(jobs), Counter[str](), 0
        try:
            for _ in range(min(self.count, len(waiting))):
                self._start()
            while waiting or any(worker.job for worker in self._workers):
                try:
                    worker, message = self._heard.get(timeout=TICK)
                except queue.Empty:
                    yield Event()
                    continue
                job = worker.job
                if message is None:  # it has ended
                    self._workers.remove(worker)
                    words = _ending(worker.process.wait())
                    in_vain = 0 if worker.ready else in_vain + 1
                    if in_vain >= MOST_TRIES:
                        raise ModelError(f"the worker processes end before they can do anything ({words}); what they "
                                         f"say is in {self.log}.")  # fmt: skip
                    if job is not None:
                        tries[job.name] += 1
                        again = tries[job.name] < MOST_TRIES
                        if again:
                            waiting.appendleft(job)
                    if len(self._workers) < min(self.count, len(waiting)):
                        self._start()
                    if job is not None and again:
                        yield Event("lost", job.name, worker.name, words=words)
                    elif job is not None:
                        text = f"its worker process ended {MOST_TRIES} times while it computed this case: {words}."
                        yield Event("ended", job.name, worker.name, outcome=Outcome(FAILED, text))
                elif "at" in message and job is not None:
                    yield Event("at", job.name, worker.name, *message["at"])
                elif "ready" in message:
                    worker.ready = True
                    yield from self._next(worker, waiting)
                elif "outcome" in message and job is not None:
                    outcome = Outcome(**message["outcome"])
                    if outcome.state == STOPPED:  # somebody has asked this process to end
                        waiting.append(job)
                        yield Event("lost", job.name, worker.name, words="it was asked to end")
                        yield from self._next(worker, waiting)
                    else:
                        following = list(self._next(worker, waiting))  # it goes on while this is written down
                        yield Event("ended", job.name, worker.name, outcome=outcome)
                        yield from following
        finally:
            self._end()

    def _next(self, worker: _Worker, waiting: deque[Job]) -> Iterator[Event]:
        worker.job = waiting.popleft() if waiting else None
        if worker.job is None:
            return
        line = json.dumps(worker.job.plain()).encode() + b"\n"
        with suppress(OSError):  # where it has ended we are told
            worker.process.stdin.write(line)
            worker.process.stdin.flush()
        yield Event("started", worker.job.name, worker.name)

    def _start(self) -> None:
        environment = {**os.environ, **dict.fromkeys(_ONE_THREAD, "1")}
        with self.log.open("ab") as log:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "fowtlib.cases.worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=log, env=environment,
            )  # fmt: skip
        worker = _Worker(process)
        self._workers.append(worker)
        threading.Thread(target=self._listen, args=(worker,), daemon=True).start()

    def _listen(self, worker: _Worker) -> None:
        for line in worker.process.stdout:
            try:
                message = json.loads(line)
            except ValueError:  # cut off
                break
            self._heard.put((worker, message))
        self._heard.put((worker, None))

    def _end(self) -> None:
        for worker in self._workers:
            with suppress(OSError):
                worker.process.stdin.close()
        for worker in self._workers:
            try:
                worker.process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                worker.process.kill()
                worker.process.wait()
        self._workers.clear()


def _ending(status: int) -> str:
    """How a process has ended, in words."""
    if status >= 0:
        return f"it ended with status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    if name == "SIGKILL":
        return "it was ended by force (SIGKILL; where nobody did that, the memory was full)"
    return f"it was ended by {name}"
