"""Batches: cases that are run, each once, and a folder that says what became of them.

    batch = run_batch(cases, "dlc12.batch")
    for row in batch.rows():
        print(row.name, row.state, row.statistics["pitch"]["max"])
    batch.result("w12_s3").plot("w12_s3.png")

The folder holds the registry (fowtlib.cases.registry), one file of results a case, `batch.log`, and what the worker
processes print in `workers.log`; `starts` holds the means that runs have started from, each found once.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

from fowtlib.cases.case import Case
from fowtlib.cases.case_set import CaseSet
from fowtlib.cases.check import check_cases
from fowtlib.cases.job import DONE, NO_ROOM, Job, changes, forget_journal
from fowtlib.cases.pool import Event, LocalWorkers
from fowtlib.cases.registry import DUE, FAILED, NAME, Registry, RegistryError, Row, held
from fowtlib.cases.room import workers_that_fit
from fowtlib.language.errors import ModelError, NotFoundError, ParameterError, did_you_mean, one_of
from fowtlib.solving.interrupts import deferred_interrupt
from fowtlib.solving.results import Result

FORMATS, KEPT = ("nc", "outb"), ("all", "statistics")
LOG, WORKERS_LOG, PARTIAL, STARTS = "batch.log", "workers.log", ".partial.nc", "starts"
LONGEST_NAME = 200  # bytes of the name of a case, which is that of a file
_LOGGED = 60.0  # s between two lines on the progress in the log
_FORBIDDEN = set('/\\:*?"<>|')  # in the names of files, somewhere


@dataclass(frozen=True)
class Progress:
    """How far a batch is. done and failed count the cases of the whole batch, with those of earlier runs.

    simulated: what this run of the batch has computed, of `to_simulate` [s]. rate: simulated seconds per second of the
    clock, of all workers; left: seconds of the clock, None while that is not known. words: what has just happened, to
    the case `name`.
    """

    cases: int
    done: int
    failed: int
    running: int
    simulated: float
    to_simulate: float
    rate: float = 0.0
    left: float | None = None
    words: str = ""
    name: str = ""


class Batch:
    """A folder in which cases were run. Nothing is kept open, so that a batch that is running can be looked at."""

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)

    @classmethod
    def open(cls, folder: str | Path) -> Batch:
        """The batch in a folder; RegistryError where there is none, or a newer fowtlib has made it."""
        batch = cls(folder)
        with batch._registry():
            return batch

    def rows(self, state: str | None = None) -> list[Row]:
        """What is known of each case, in the order in which they were given; state: only of those in it."""
        with self._registry() as registry:
            return [row for row in registry.rows() if state in (None, row.state)]

    def row(self, name: str) -> Row:
        """What is known of one case."""
        with self._registry() as registry:
            row = registry.row(name)
            if row is None:
                raise NotFoundError(f"{self.folder}: there is no case '{name}'{did_you_mean(name, registry.names())}")
            return row

    def statistics(self, name: str) -> dict[str, Any]:
        """All statistics of a case, as fowtlib.analysis.case_statistics gives them, with the values at extremes."""
        with self._registry() as registry:
            return registry.statistics(name)

    def path(self, name: str) -> Path | None:
        """The file with the results of a case, of one that has failed with what it had computed; None where none is."""
        row = self.row(name)
        path = self.folder / row.result
        return path if row.result and path.is_file() else None

    def result(self, name: str) -> Result:
        """The results of a case; of one that has failed what it had computed before."""
        path = self.path(name)
        if path is None:
            row = self.row(name)
            reason = row.message or ("only statistics are kept" if row.state == DONE else f"it is {row.state}")
            raise NotFoundError(f"{self.folder}: there are no results of the case '{name}': {reason}")
        return Result.open(path)

    @property
    def counts(self) -> dict[str, int]:
        """How many cases are due, running, done, failed."""
        with self._registry() as registry:
            return registry.counts()

    @property
    def about(self) -> dict[str, Any]:
        """What holds for all cases: source, format, keep, fowtlib_version, made."""
        with self._registry() as registry:
            return registry.about

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows())

    def __len__(self) -> int:
        return sum(self.counts.values())

    def __repr__(self) -> str:
        told = ", ".join(f"{count} {state}" for state, count in self.counts.items() if count)
        return f"<Batch {self.folder}: {told or 'no cases'}>"

    @contextmanager
    def _registry(self) -> Iterator[Registry]:
        registry = Registry(self.folder)
        try:
            yield registry
        finally:
            registry.close()


def run_batch(
    cases: CaseSet | Sequence[Case],
    folder: str | Path,
    *,
    source: str = "",
    workers: int | None = None,
    cluster: Any = None,
    format: str | None = None,
    keep: str | None = None,
    retry: bool = False,
    allow_python: bool = False,
    trust: bool = False,
    allow: Sequence[str | os.PathLike[str]] = (),
    progress: Callable[[Progress], None] | None = None,
) -> Batch:
    """Run the cases that are not done yet, or no longer hold, and give the batch.

    A case is done again where it, its model or a file that it reads has changed since. One that has failed stays so
    until it changes, or with retry. cases: their names are those of the files. folder: is made; one that holds another
    batch is refused. source: what the cases come from, such as the path of a file, by which batches are told apart.
    workers: processes on this computer; None for as many as its cores and memory allow. cluster: the address of a Dask
    scheduler, a Client or a cluster of Dask, to compute there instead. format: of the results, nc (the default) or
    outb; keep: all (the default), or statistics without files. allow_python, trust, allow: see fowtlib.load.
    progress: is told how far it is.

    Ctrl-C and SIGTERM end it in an orderly way (KeyboardInterrupt); what is done is kept, and the next call goes on.
    Raises ModelError for what no case can be run with, and where the disk is full: what is done is kept.
    """
    cases = cases if isinstance(cases, CaseSet) else CaseSet(None, "", tuple(cases))
    folder = Path(folder)
    _check_names(cases)
    _check_choice("format", format, FORMATS)
    _check_choice("keep", keep, KEPT)
    if workers is not None and workers < 1:
        raise ParameterError(f"workers is {workers}; at least one is needed.")
    _make(folder)
    with held(folder):
        registry = Registry(folder, write=True)
        try:
            about = _about(registry, folder, cases, source, format, keep)
            _tidy(folder)
            registry.put_back("the run before was cut off")
            rows = _planned(registry, folder, cases, about, retry)
            registry.plan(rows)
            due = replace(cases, cases=tuple(row.case for row in rows if row.state == DUE))
            if len(due):
                options = {"allow_python": allow_python, "trust": trust, "allow": tuple(map(os.fspath, allow))}
                jobs, durations = _jobs(due, folder.resolve(), about, options)
                count = min(workers or workers_that_fit(), len(jobs))
                _Runner(registry, folder, rows, durations, progress).run(_workers(cluster, count, folder), jobs)
        finally:
            registry.close()
    return Batch(folder)


def _workers(cluster: Any, count: int, folder: Path) -> Any:
    if cluster is None:
        return LocalWorkers(count, folder / WORKERS_LOG)
    from fowtlib.cases.cluster import ClusterWorkers

    return ClusterWorkers(cluster, folder)


# --- before the first case -------------------------------------------------------------------------------------------


def _check_names(cases: CaseSet) -> None:
    seen: dict[str, str] = {}
    for case in cases:
        name = case.name
        bad = sorted(_FORBIDDEN & set(name)) or [repr(c) for c in name if not c.isprintable()]
        if not name or name.startswith(".") or name != name.strip() or bad:
            what = f"cannot hold {bad[0]}" if bad else "is not empty, has no spaces at its ends and no dot at its front"
            raise ParameterError(f"the case '{name}': its name is that of a file, and {what}.")
        if len(name.encode()) > LONGEST_NAME:
            raise ParameterError(f"the case '{name[:40]}...': its name has more than {LONGEST_NAME} letters.")
        if name.casefold() in seen:
            other = seen[name.casefold()]
            both = f"'{name}'" if other == name else f"'{other}' and '{name}', which some systems do not tell apart"
            raise ParameterError(f"there are two cases {both}; each needs a name of its own.")
        seen[name.casefold()] = name
    if not len(cases):
        raise ParameterError("there are no cases to run.")


def _check_choice(what: str, value: str | None, known: Sequence[str]) -> None:
    if value is not None and value not in known:
        raise ParameterError(f"{what} is '{value}'; it must be {one_of(known)}.")


def _make(folder: Path) -> None:
    """Make the folder, or refuse one that holds something else or cannot be written."""
    try:
        if folder.exists() and not folder.is_dir():
            raise RegistryError(f"{folder}: is a file; a batch needs a folder.")
        if folder.is_dir() and not (folder / NAME).exists() and any(folder.iterdir()):
            raise RegistryError(f"{folder}: holds other things, and no batch. Choose a new or an empty folder.")
        folder.mkdir(exist_ok=True)
        if not os.access(folder, os.W_OK | os.X_OK):
            raise RegistryError(f"{folder}: cannot be written: no permission. Choose another folder.")
    except FileNotFoundError:
        raise RegistryError(f"{folder}: the folder {folder.parent} does not exist; make it first.") from None
    except OSError as error:
        raise RegistryError(f"{folder}: cannot be used: {error.strerror or error}.") from None


def _about(registry: Registry, folder: Path, cases: CaseSet, source: str, format: str | None,
           keep: str | None) -> dict[str, Any]:  # fmt: skip
    """What holds for the batch; refuse cases that do not belong to it, and what cannot be changed any more."""
    about = registry.about
    if not about:
        from importlib.metadata import version

        about = {"source": source, "format": format or FORMATS[0], "keep": keep or KEPT[0],
                 "fowtlib_version": version("fowtlib"), "made": f"{datetime.now():%Y-%m-%d %H:%M:%S}"}  # fmt: skip
        registry.say(**about)
        return about
    names = registry.names()
    other = about["source"] != source if source and about["source"] else False
    if other or (names and not {case.name for case in cases} & set(names)):
        whose = f"of {about['source']}" if other else f"with cases such as '{names[0]}'"
        raise RegistryError(f"{folder}: holds another batch, {whose}. Choose another folder; nothing was changed.")
    for key, value in (("format", format), ("keep", keep)):
        if value is not None and value != about[key]:
            raise RegistryError(f"{folder}: this batch was begun with {key} {about[key]}, which cannot be changed to "
                                f"{value}; choose another folder.")  # fmt: skip
    return about


def _tidy(folder: Path) -> None:
    """Take away what processes that were killed were writing."""
    for path in folder.glob(".fowtlib.*"):
        path.unlink(missing_ok=True)


def _planned(registry: Registry, folder: Path, cases: CaseSet, about: Mapping[str, Any],
             retry: bool) -> list[Row]:  # fmt: skip
    """The rows of the cases: which are due, and why."""
    known = {row.name: row for row in registry.rows(all_of_them=True, statistics=False)}
    changed: dict[tuple[tuple[str, str], ...], list[str]] = {}  # the same files for most cases

    def reasons(row: Row, case: Case, digest: str) -> list[str]:
        if row.digest != digest:
            return [f"the case has changed: {_difference(row.case, case)}"]
        files = tuple(row.files.items())
        if files not in changed:
            changed[files] = changes(row.files)
        if changed[files]:
            return changed[files]
        if row.state == DONE and about["keep"] == "all":
            path = folder / row.result
            if not path.is_file():
                return ["its result is gone"]
            if path.stat().st_size != row.bytes:
                return ["its result is not the one that was written"]
        return []

    rows = []
    for case in cases:
        row, digest = known.get(case.name, Row(case)), case.digest()
        if row.digest and row.digest != digest:
            forget_journal(folder / f"{case.name}.{about['format']}")
        if row.state in (DONE, FAILED):
            why = reasons(row, case, digest)
            if not why and retry and row.state == FAILED:
                why = ["it has failed, and is tried again"]
            row = replace(row, state=DUE if why else row.state, why="; ".join(why))
        rows.append(replace(row, case=case, digest=digest))
    return rows


def _difference(old: Case, new: Case) -> str:
    """What differs between two cases, in words."""
    before, now = ({"parameters": {}, **case.plain()} for case in (old, new))
    told = []
    for one, other in ((before.pop("parameters"), now.pop("parameters")), (before, now)):
        for key in sorted({*one, *other} - {"name", "group", "labels", "weight", "safety_factor"}):
            if one.get(key) != other.get(key):
                told.append(f"{key} was {_shown(one.get(key))}, is {_shown(other.get(key))}")
    return ", ".join(told[:3]) + (f" and {len(told) - 3} more" if len(told) > 3 else "")


def _shown(value: Any) -> str:
    text = "not given" if value is None else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _jobs(cases: CaseSet, folder: Path, about: Mapping[str, Any],
          options: Mapping[str, Any]) -> tuple[list[Job], dict[str, float]]:  # fmt: skip
    """The jobs of cases that are due, and how long each simulates [s]; what cannot be run is found here."""
    from fowtlib.language.leave import require_leave
    from fowtlib.modelfile import load, shipped_models
    from fowtlib.modelfile.files import find_model, is_file
    from fowtlib.solving.settings import duration_settings

    models = check_cases(cases, lambda name: load(name, **options))
    names = {}
    for name, model in models.items():
        require_leave(model.root)
        shipped = name in shipped_models() and not is_file(Path(name))
        names[name] = name if shipped else str(find_model(name).resolve())
    jobs, durations = [], {}
    for case in cases:
        result = str(folder / f"{case.name}.{about['format']}") if about["keep"] == "all" else ""
        jobs.append(Job(case.plain(), names[case.model], result, str(folder / f"{case.name}{PARTIAL}"),
                        str(folder / STARTS), str(folder / f"{case.name}.{about['format']}"), **options))  # fmt: skip
        settings = models[case.model].settings
        durations[case.name] = duration_settings(case.duration, case.output_step, case.tolerance, settings)[0]
    return _ordered(jobs), durations


def _ordered(jobs: list[Job]) -> list[Job]:
    """Of cases that are likely to start from the same mean one first, so that no two workers seek it at one time."""
    seen: set[str] = set()
    first, others = [], []
    for job in jobs:
        kept = {path: value for path, value in job.case.get("parameters", {}).items()
                if not path.startswith("sea.") and not path.endswith(".seed")}  # fmt: skip
        key = json.dumps([job.model, job.case.get("start"), kept], sort_keys=True)
        (others if key in seen else first).append(job)
        seen.add(key)
    return first + others


# --- while it runs ---------------------------------------------------------------------------------------------------


class _Runner:
    """Writes down what workers tell, and tells how far the batch is."""

    def __init__(self, registry: Registry, folder: Path, rows: Sequence[Row], durations: Mapping[str, float],
                 progress: Callable[[Progress], None] | None):  # fmt: skip
        self.registry, self.folder, self.durations, self.tell = registry, folder, durations, progress
        self.cases, self.total = len(rows), sum(durations.values())
        self.done = sum(row.state == DONE for row in rows)
        self.failed = sum(row.state == FAILED for row in rows)
        self.again = [row for row in rows if row.state == DUE and row.why]
        self.running: dict[str, float] = {}  # simulated so far [s]
        self.settled = 0.0  # s of the cases that have ended
        self.simulated = 0.0  # s that were really simulated in them
        self.began: float | None = None
        self.logged = time.monotonic()

    def run(self, workers: Any, jobs: Sequence[Job]) -> None:
        """Carry out all jobs, or as many as can be until something stops it."""
        self._log(f"{len(jobs)} of {self.cases} cases are due")
        for row in self.again:
            self._log(f"due     {row.name}: {row.why}")
        why = "the batch was stopped"
        try:
            with deferred_interrupt() as asked, closing(workers.carry_out(jobs)) as events:
                for event in events:
                    self._note(event)
                    if asked.is_set():
                        raise KeyboardInterrupt
        except KeyboardInterrupt:
            self._log("stopped")
            raise
        except ModelError as error:
            why = str(error)
            self._log(f"ended: {error}")
            raise
        finally:
            self.registry.put_back(why)
        self._log(f"ended: {self.done} of {self.cases} cases done, {self.failed} failed")

    def _note(self, event: Event) -> None:
        words = ""
        if event.kind == "started":
            self.registry.started(event.name, event.worker)
            self.running[event.name] = 0.0
            self.began = self.began or time.monotonic()
            self._log(f"started {event.name} ({event.worker})")
        elif event.kind == "at":
            self.running[event.name] = event.at
        elif event.kind == "lost":
            self.running.pop(event.name, None)
            self.registry.lost(event.name, f"its worker was lost: {event.words}")
            words = f"lost    {event.name}: {event.words}; it is tried again"
        elif event.kind == "ended":
            words = self._ended(event)
        if words:
            self._log(words)
        self._report(words, event.name)

    def _ended(self, event: Event) -> str:
        outcome = event.outcome
        if outcome.state == NO_ROOM:
            raise ModelError(f"{outcome.message} What is finished is kept; make room, and run the batch again.")
        self.running.pop(event.name, None)
        state = DONE if outcome.state == DONE else FAILED
        told = {key: value for key, value in outcome.plain().items() if key != "state"}
        self.registry.ended(event.name, state, told)
        self.done, self.failed = self.done + (state == DONE), self.failed + (state == FAILED)
        self.settled += self.durations[event.name]
        self.simulated += outcome.simulated
        if state == FAILED:
            return f"failed  {event.name}: {outcome.message.replace(chr(10), ' ')}"
        pace = outcome.simulated / max(outcome.seconds, 1e-9)
        return f"done    {event.name}: {outcome.simulated:g} s in {outcome.seconds:.1f} s, {pace:.0f} x real time"

    def _report(self, words: str, name: str) -> None:
        running = sum(self.running.values())
        settled, rate = self.settled + running, 0.0
        if self.began is not None:
            rate = (self.simulated + running) / max(time.monotonic() - self.began, 1e-3)
        left = max(0.0, self.total - settled) / rate if rate > 0 else None
        now = Progress(self.cases, self.done, self.failed, len(self.running), settled, self.total, rate, left, words,
                       name)  # fmt: skip
        if time.monotonic() - self.logged > _LOGGED:
            self._log(f"so far: {in_words(now)}")
        if self.tell is not None:
            self.tell(now)

    def _log(self, line: str) -> None:
        self.logged = time.monotonic()
        try:
            with (self.folder / LOG).open("a", encoding="utf-8") as log:
                log.write(f"{datetime.now():%Y-%m-%d %H:%M:%S} {line}\n")
        except OSError:  # the registry is what counts; where nothing can be written it says so
            pass


def in_words(progress: Progress) -> str:
    """How far a batch is, in a line."""
    told = [f"{progress.done} of {progress.cases} cases done"]
    if progress.failed:
        told.append(f"{progress.failed} failed")
    told.append(f"{progress.running} running")
    if progress.rate:
        told.append(f"{progress.rate:.3g} s simulated a second")
    if progress.left is not None:
        told.append(f"{duration_in_words(progress.left)} left")
    return ", ".join(told)


def duration_in_words(seconds: float) -> str:
    """3 s, 12 min, 2 h 10 min."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
