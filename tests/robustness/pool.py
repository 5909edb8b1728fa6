"""Tries inputs one by one, each in a process of its own that a warm parent forks, with limits of time and memory.

A fork of a parent that has imported everything costs milliseconds, so that ten thousand inputs take minutes. What a
child may take beyond what the parent had is limited by the system (RLIMIT_AS), and so is its processor time
(RLIMIT_CPU), which does not grow where others keep the machine busy. A child that waits takes none: the parent, which
has much patience, ends it. POSIX only.
"""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import os
import pickle
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SECONDS = 10  # of processor time
PATIENCE = 60.0  # s of the clock for each of them
BYTES = 10**9

OK, REFUSED = "ok", "refused"
OTHER = "other numbers"  # of a file that has no checksum
CHANGED = "changed in silence"  # numbers of a file whose checksum could have caught it
RAW, HANG, MEMORY, CRASH = "raw error", "hang", "memory", "crash"
FAILURES = (RAW, HANG, MEMORY, CRASH, CHANGED)


@dataclass(frozen=True)
class Outcome:
    """What became of one input: its kind, what was said, processor time [s], memory beyond the parent's [bytes]."""

    name: str
    kind: str
    words: str = ""
    seconds: float = 0.0
    memory: int = 0


@dataclass(frozen=True)
class Attempt:
    """An input: its name, and what is done with it in a folder of its own; gives kind and words."""

    name: str
    act: Callable[[Path], tuple[str, str]] = field(repr=False)


def run(attempts: Iterable[Attempt], workers: int = 1, keep: Path | None = None, seconds: int = SECONDS,
        memory: int = BYTES, patience: float = PATIENCE) -> Iterator[Outcome]:  # fmt: skip
    """The outcomes of attempts, as they come. keep: where the folders of those that failed go.

    seconds: of processor time that one may take. patience: how often that by the clock.
    """
    import multiprocessing  # noqa: F401  its helpers must not be made in a child

    gc.collect()
    gc.freeze()  # the parent's objects are not looked at by the children, and their pages stay shared
    running: dict[int, tuple[int, float, Attempt, Path]] = {}
    source = iter(attempts)
    scratch = Path(tempfile.mkdtemp(prefix="robustness_"))
    number, done = 0, False
    try:
        while running or not done:
            while not done and len(running) < workers:
                attempt = next(source, None)
                if attempt is None:
                    done = True
                    break
                number += 1
                folder = scratch / str(number)
                folder.mkdir()
                pipe, child = _start(attempt, folder, seconds, memory)
                running[pipe] = (child, time.monotonic(), attempt, folder)
            now = time.monotonic()
            waits = [started + patience * seconds - now for _, started, _, _ in running.values()]
            if not running:
                break
            ready, _, _ = select.select(list(running), [], [], max(0.0, min(waits)))
            late = [
                pipe for pipe, (_, started, _, _) in running.items() if time.monotonic() - started >= patience * seconds
            ]
            for pipe in {*ready, *late}:
                child, started, attempt, folder = running.pop(pipe)
                outcome = _finish(pipe, child, attempt.name, time.monotonic() - started, pipe in ready)
                if outcome.kind in FAILURES and keep is not None:
                    target = keep / outcome.kind.replace(" ", "_") / attempt.name
                    shutil.rmtree(target, ignore_errors=True)
                    shutil.copytree(folder, target)
                    (target / "outcome.txt").write_text(f"{outcome.kind}\n{outcome.words}\n")
                shutil.rmtree(folder, ignore_errors=True)
                yield outcome
    finally:
        for pipe, (child, *_) in running.items():
            _end(child)
            os.close(pipe)
        shutil.rmtree(scratch, ignore_errors=True)


def _start(attempt: Attempt, folder: Path, seconds: int, memory: int) -> tuple[int, int]:
    """Fork a child that makes the attempt; the end of the pipe from which its outcome is read, and the child."""
    sys.stdout.flush()
    sys.stderr.flush()
    pipe, out = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks beside threads: those of the parent sleep
        child = os.fork()
    if child:
        os.close(out)
        return pipe, child
    status = 1
    try:
        faulthandler.disable()  # a crash is told by the parent
        os.setsid()  # what it starts ends with it
        os.close(pipe)
        _limit(seconds, memory)
        base = _resident()
        os.chdir(folder)
        os.environ["TMPDIR"] = str(folder)
        with open(folder / ".said", "w+") as said, contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            try:
                kind, words = attempt.act(folder)
            except MemoryError:
                kind, words = MEMORY, "MemoryError"
            except BaseException:
                kind, words = RAW, traceback.format_exc(limit=-6)
        use = resource.getrusage(resource.RUSAGE_SELF)
        grown = max(0, use.ru_maxrss * 1024 - base)
        answer = pickle.dumps((kind, words[:4000], use.ru_utime + use.ru_stime, grown))
        os.write(out, answer)
        status = 0
    finally:
        os._exit(status)


def _limit(seconds: int, memory: int) -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0]) if sys.platform == "linux" else 0
    limit = pages * resource.getpagesize() + memory
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _resident() -> int:
    if sys.platform != "linux":
        return 0
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def _end(child: int) -> int:
    with contextlib.suppress(OSError):
        os.killpg(child, signal.SIGKILL)
    with contextlib.suppress(OSError):
        os.kill(child, signal.SIGKILL)
    return os.waitpid(child, 0)[1]


def _finish(pipe: int, child: int, name: str, seconds: float, answered: bool) -> Outcome:
    answer: Any = b""
    if answered:
        while piece := os.read(pipe, 65536):
            answer += piece
    os.close(pipe)
    status = os.waitpid(child, 0)[1] if answered else _end(child)
    with contextlib.suppress(OSError):
        os.killpg(child, signal.SIGKILL)  # what a child has left running
    if answer:
        kind, words, used, memory = pickle.loads(answer)
        return Outcome(name, kind, words, used, memory)
    if not answered:
        return Outcome(name, HANG, f"no end after {seconds:.1f} s", seconds)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU:
        return Outcome(name, HANG, "no end within its processor time", seconds)
    what = f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else f"exit status {os.WEXITSTATUS(status)}"
    return Outcome(name, CRASH, what, seconds)
