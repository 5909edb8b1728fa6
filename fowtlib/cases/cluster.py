"""Cases computed by the workers of a Dask cluster; the registry and the results are the same as on one computer.

A case goes out as a few hundred bytes and comes back as its statistics. Its file of results is written by the worker
into the folder of the batch where it sees that, and else kept by the worker until it has been fetched in pieces: never
more than one piece goes through the scheduler, which keeps nothing of it.
"""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cases.job import DONE, FAILED, STOPPED, Job, Outcome, carry_out
from fowtlib.cases.pool import MOST_TRIES, TICK, Event
from fowtlib.language.data_files import digest_of
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.language.whole_files import write_whole

if TYPE_CHECKING:
    from distributed import Client, Future

PIECE = 2**22  # bytes of a file that come back together
_TOKEN = ".here"  # a file by which a worker knows that it sees the folder of the batch
_LOOK = 2.0  # s between two questions about what the workers compute
_ANSWER = 10.0  # s for a scheduler to answer

# --- on a worker -----------------------------------------------------------------------------------------------------

_one_at_a_time = threading.Lock()  # of the threads of a worker: a plant is used by one
_stopped: set[str] = set()  # tokens of batches that were stopped


def compute(job: dict[str, Any], folder: str, token: str) -> dict[str, Any]:
    """Compute a case; its outcome, the worker, and where the file lies that is to be fetched ("" for none)."""
    from distributed import get_worker

    def report(t: float, end: float) -> None:
        if token in _stopped:
            raise KeyboardInterrupt

    given = Job(**job)
    with _one_at_a_time:
        shared = _sees(folder, token)
        place = folder if shared else tempfile.mkdtemp(prefix="fowtlib_batch_")
        paths = {key: os.path.join(place, os.path.basename(getattr(given, key))) if getattr(given, key) else ""
                 for key in ("result", "partial")}  # fmt: skip
        here = {} if shared else {"starts": "", "journal": ""}
        outcome = carry_out(replace(given, **paths, **here), report)
        left = os.path.join(place, outcome.result) if outcome.result and not shared else ""
        if not shared and not left:
            shutil.rmtree(place, ignore_errors=True)
        check = digest_of(left) if left else ""
    return {"outcome": outcome.plain(), "worker": get_worker().address, "left": left, "check": check}


def _sees(folder: str, token: str) -> bool:
    with suppress(OSError):
        return (Path(folder) / _TOKEN).read_text() == token
    return False


def piece(path: str, offset: int) -> bytes:
    """A piece of a file that this worker keeps."""
    with open(path, "rb") as file:
        file.seek(offset)
        return file.read(PIECE)


def forget(path: str) -> None:
    """Take away a file that has been fetched."""
    shutil.rmtree(os.path.dirname(path), ignore_errors=True)


def stop(token: str) -> None:
    """End the cases of a batch soon."""
    _stopped.add(token)


# --- where the batch is run ------------------------------------------------------------------------------------------


def version() -> str:
    """Of fowtlib, here."""
    return importlib.metadata.version("fowtlib")


class ClusterWorkers:
    """The workers of a cluster. cluster: the address of its scheduler, a Client, or a cluster object of Dask."""

    def __init__(self, cluster: Any, folder: Path):
        try:
            import distributed  # noqa: F401
        except ImportError:
            raise ModelError("to compute on a cluster, install Dask: pip install 'fowtlib[cluster]'.") from None
        self.cluster, self.folder = cluster, folder.resolve()

    def carry_out(self, jobs: Sequence[Job]) -> Iterator[Event]:
        """Carry out jobs, and tell what happens; when the iterator is closed all cases are taken back."""
        client, own = _client(self.cluster)
        token = os.urandom(8).hex()
        try:
            _check_versions(client)
            (self.folder / _TOKEN).write_text(token)
            yield from self._carry_out(client, jobs, token)
        finally:
            with suppress(OSError):
                (self.folder / _TOKEN).unlink(missing_ok=True)
            if own:
                with suppress(Exception):  # the scheduler may be gone
                    client.close()

    def _carry_out(self, client: Client, jobs: Sequence[Job], token: str) -> Iterator[Event]:
        from distributed import as_completed

        tries = Counter[str]()
        known: dict[str, Job] = {}  # by the key of the task

        def submit(job: Job) -> Future:
            tries[job.name] += 1
            key = f"fowtlib-{token}-{job.name}-{tries[job.name]}"
            known[key] = job
            return client.submit(compute, job.plain(), str(self.folder), token, key=key, pure=False)

        waiting = {future.key: future for future in map(submit, jobs)}
        ready = as_completed(waiting.values(), loop=client.loop, raise_errors=False)
        running: set[str] = set()
        looked = 0.0
        try:
            while waiting:
                if not ready.has_ready():
                    if client.status not in ("running", "newly-created"):
                        raise ModelError(f"the scheduler has gone ({client.status}). What is finished is kept; run the "
                                         "batch again.")  # fmt: skip
                    if time.monotonic() - looked > _LOOK:
                        looked = time.monotonic()
                        yield from _started(client, known, waiting, running)
                    time.sleep(TICK)
                    yield Event()
                    continue
                future = next(ready)
                job = known[future.key]
                del waiting[future.key]
                event = self._ended(client, future, job)
                future.release()
                if event.kind == "lost" and tries[job.name] < MOST_TRIES:
                    again = submit(job)
                    waiting[again.key] = again
                    ready.add(again)
                elif event.kind == "lost":
                    text = f"it was computed {MOST_TRIES} times, and its results were lost with the worker each time."
                    event = Event("ended", job.name, outcome=Outcome(FAILED, text))
                yield event
        finally:
            if waiting:
                with suppress(Exception):
                    client.cancel(list(waiting.values()), force=True)
                    client.run(stop, token, on_error="ignore")

    def _ended(self, client: Client, future: Future, job: Job) -> Event:
        """What became of a task."""
        from distributed import KilledWorker

        if future.status == "cancelled" or future.status == "lost":
            return Event("lost", job.name, words="the cluster has dropped it")
        if future.status != "finished":
            error = future.exception()
            if isinstance(error, KilledWorker):
                text = f"{error.allowed_failures + 1} workers ended while they computed this case."
                return Event("ended", job.name, outcome=Outcome(FAILED, text))
            raise ModelError(f"the workers of the cluster cannot compute cases: {type(error).__name__}: {error}")
        told = future.result()
        outcome, worker = Outcome(**told["outcome"]), told["worker"]
        if outcome.state == STOPPED:
            return Event("lost", job.name, worker, words="it was asked to end")
        if told["left"]:
            target = self.folder / outcome.result
            try:
                write_whole(target, lambda path: _fetch(client, worker, told["left"], path, outcome.bytes or 0))
            except ModelError as error:
                raise ModelError(f"{error} What is finished is kept; make room, and run the batch again.") from None
            except (OSError, KeyError, ValueError, RuntimeError) as error:
                return Event("lost", job.name, worker, words=f"its results cannot be fetched: {error}")
            if digest_of(target) != told["check"]:
                return Event("lost", job.name, worker, words="its results have come back damaged")
            with suppress(Exception):
                client.run(forget, told["left"], workers=[worker], on_error="ignore")
        if outcome.state == DONE:
            with suppress(OSError):
                os.unlink(job.partial)
        return Event("ended", job.name, worker, outcome=outcome)


def _fetch(client: Client, worker: str, left: str, target: Path, size: int) -> None:
    """Bring a file here, piece by piece."""
    with target.open("wb") as file:
        while file.tell() < size:
            data = client.run(piece, left, file.tell(), workers=[worker])[worker]
            if not data:
                raise ValueError(f"{left} ends too early")
            file.write(data)


def _started(client: Client, known: dict[str, Job], waiting: dict[str, Any], running: set[str]) -> Iterator[Event]:
    """Cases that a worker has got since the last look."""
    try:
        processing = client.processing()
    except Exception:  # asked between two connections; it is only for show
        return
    for worker, keys in processing.items():
        for key in map(str, keys):
            if key in waiting and key not in running:
                running.add(key)
                yield Event("started", known[key].name, worker)


def _client(cluster: Any) -> tuple[Client, bool]:
    """A client of the cluster, and whether it was made here."""
    from distributed import Client
    from distributed.comm import resolve_address

    if isinstance(cluster, Client):
        return cluster, False
    if not isinstance(cluster, str) and not hasattr(cluster, "scheduler_address"):
        raise ParameterError(f"cluster is {cluster!r}; give the address of a scheduler, a Client or a cluster of Dask.")
    try:
        if isinstance(cluster, str):
            resolve_address(cluster)  # a Client that fails at this closes itself late, with a traceback
        return Client(cluster, timeout=_ANSWER, set_as_default=False), True
    except (OSError, TimeoutError):
        raise ModelError(f"no Dask scheduler answers at {cluster} within {_ANSWER:g} s. Is it running, and is its port "
                         "open to this computer?") from None  # fmt: skip
    except ValueError as error:
        raise ModelError(f"'{cluster}' is not the address of a Dask scheduler, such as tcp://10.0.0.1:8786 "
                         f"({error}).") from None  # fmt: skip


def _check_versions(client: Client) -> None:
    """Workers that are there have to have the same fowtlib."""
    try:
        found = client.run(importlib.metadata.version, "fowtlib")
    except ModuleNotFoundError as error:
        raise ModelError(f"a worker of the cluster has no fowtlib ({error}); install the same one there.") from None
    for worker, theirs in found.items():
        if theirs != version():
            raise ModelError(f"the worker {worker} has fowtlib {theirs}, and here is {version()}; results would not be "
                             "the same. Install the same one there.")  # fmt: skip
