"""The registry of a batch: one SQLite file beside the results, which says what became of each case.

Only the process that runs the batch writes it, one transaction for what has happened, on the disk (fsync) before it
goes on; others may read it meanwhile. A process that is killed leaves it as it was before or after a transaction.
"""

from __future__ import annotations

import json
import os
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from fowtlib.cases.case import Case
from fowtlib.language.errors import ModelError

NAME = "registry.sqlite"
LOCK = ".lock"
VERSION = 1
DUE, RUNNING, DONE, FAILED = STATES = ("due", "running", "done", "failed")
_MARK = 0x666F7774  # "fowt": what SQLite calls the application of a file
_PATIENCE = 30.0  # s to wait for another process that is reading or writing
_TABLES = """
CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE cases (
    name TEXT PRIMARY KEY, place INTEGER, data TEXT NOT NULL, digest TEXT NOT NULL, state TEXT NOT NULL,
    why TEXT NOT NULL DEFAULT '', message TEXT NOT NULL DEFAULT '', warnings TEXT NOT NULL DEFAULT '',
    seconds REAL, processor REAL, simulated REAL, began TEXT, ended TEXT, worker TEXT NOT NULL DEFAULT '',
    result TEXT NOT NULL DEFAULT '', bytes INTEGER, files TEXT NOT NULL DEFAULT '{}',
    statistics TEXT NOT NULL DEFAULT '{}', more BLOB
);
"""


class RegistryError(ModelError):
    """A registry cannot be read or written: damaged, of a newer version, no room, no permission."""


@dataclass(frozen=True)
class Row:
    """What is known of one case.

    state: due, running, done or failed. why: a case that was done before is due again. message: what went wrong.
    seconds: of the clock, processor: of it that the case used [s]; simulated [s]. files: digest by path of all that the
    result depends on besides the case. statistics: by channel, its unit and numbers by name, as the "channels" of
    fowtlib.analysis.case_statistics. result: the name of its file in the folder, "" where none is kept; bytes: its
    size. digest: that of the case.
    """

    case: Case
    state: str = DUE
    why: str = ""
    message: str = ""
    warnings: str = ""
    seconds: float | None = None
    processor: float | None = None
    simulated: float | None = None
    began: str | None = None
    ended: str | None = None
    worker: str = ""
    result: str = ""
    bytes: int | None = None
    files: Mapping[str, str] = field(default_factory=dict)
    statistics: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    digest: str = ""

    @property
    def name(self) -> str:
        """Of the case."""
        return self.case.name


class Registry:
    """The rows of a batch, in the order of its cases; those that are no longer among them stay, unseen."""

    def __init__(self, folder: Path, *, write: bool = False):
        self.path = folder / NAME
        if not write and not self.path.is_file():
            raise RegistryError(f"{folder}: is not the folder of a batch (there is no {NAME} in it).")
        with self._sentences():
            # who may write puts back what a process that was killed has left half done; others cannot
            mode = "rw" if os.access(self.path, os.W_OK) else "ro"
            target = self.path if write else f"{self.path.resolve().as_uri()}?mode={mode}"
            self._base = sqlite3.connect(target, timeout=_PATIENCE, uri=not write, check_same_thread=False,
                                         isolation_level=None)  # fmt: skip
            try:
                self._check_version(write)
            except BaseException:
                self._base.close()
                raise

    def _check_version(self, write: bool) -> None:
        version = self._base.execute("PRAGMA user_version").fetchone()[0]
        mark = self._base.execute("PRAGMA application_id").fetchone()[0]
        tables = self._base.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if (tables and mark != _MARK) or (not tables and not write):
            raise RegistryError(f"{self.path}: is not the registry of a batch of fowtlib.")
        if version > VERSION:
            raise RegistryError(
                f"{self.path}: was made by a newer fowtlib (registry of version {version}; this one reads up to "
                f"{VERSION}). Update fowtlib, or run the batch in another folder."
            )
        if write:
            self._base.execute("PRAGMA synchronous = EXTRA")
        if not tables:
            made = f"BEGIN;{_TABLES}PRAGMA application_id = {_MARK};PRAGMA user_version = {VERSION};COMMIT;"
            self._base.executescript(made)

    def close(self) -> None:
        """Let the file go."""
        self._base.close()

    # --- what is said of the batch -----------------------------------------------------------------------------------

    @property
    def about(self) -> dict[str, Any]:
        """What holds for all cases, by key."""
        with self._sentences():
            return {key: json.loads(value) for key, value in self._base.execute("SELECT key, value FROM about")}

    def say(self, **values: Any) -> None:
        """Keep what holds for all cases."""
        with self._transaction() as base:
            rows = [(key, json.dumps(value)) for key, value in values.items()]
            base.executemany("INSERT INTO about VALUES (?, ?) ON CONFLICT DO UPDATE SET value = excluded.value", rows)

    # --- rows --------------------------------------------------------------------------------------------------------

    def rows(self, *, all_of_them: bool = False, statistics: bool = True) -> list[Row]:
        """The rows of the cases of the batch; all_of_them: also of cases that it had before. statistics: with them."""
        return list(self._rows("" if all_of_them else "WHERE place IS NOT NULL", statistics=statistics))

    def row(self, name: str) -> Row | None:
        """The row of a case; None where there is none."""
        return next(self._rows("WHERE name = ?", name), None)

    def names(self) -> list[str]:
        """The names of all cases, of those of the batch first."""
        with self._sentences():
            return [name for (name,) in self._base.execute("SELECT name FROM cases ORDER BY place IS NULL, place")]

    def counts(self) -> dict[str, int]:
        """How many cases of the batch are in each state."""
        with self._sentences():
            found = dict(self._base.execute(
                "SELECT state, count(*) FROM cases WHERE place IS NOT NULL GROUP BY state"))  # fmt: skip
        return {state: found.get(state, 0) for state in STATES}

    def _rows(self, where: str, *values: str, statistics: bool = True) -> Iterator[Row]:
        columns = ("data", "state", "why", "message", "warnings", "seconds", "processor", "simulated", "began", "ended",
                   "worker", "result", "bytes", "files", "digest", "statistics" if statistics else "'{}'")  # fmt: skip
        query = f"SELECT {', '.join(columns)} FROM cases {where} ORDER BY place IS NULL, place, name"
        with self._sentences():
            found = self._base.execute(query, values).fetchall()
        for item in found:
            told = dict(zip(columns, item, strict=True))
            case = Case.from_plain(json.loads(told.pop("data")))
            files, numbers = json.loads(told.pop("files")), json.loads(told.pop(columns[-1]))
            yield Row(case, **told, files=files, statistics=numbers)

    def statistics(self, name: str) -> dict[str, Any]:
        """All statistics of a case as fowtlib.analysis.case_statistics gives them; empty where there are none."""
        with self._sentences():
            found = self._base.execute("SELECT statistics, more FROM cases WHERE name = ?", (name,)).fetchone()
        if found is None or found[1] is None:
            return {}
        return {**json.loads(zlib.decompress(found[1])), "channels": json.loads(found[0])}

    def plan(self, rows: Iterable[Row]) -> None:
        """These are the cases of the batch, in this order and these states; what else is known of them stays.

        A case that is due loses what was known of its last run, but for the statistics and the result, which stay until
        there are new ones.
        """
        with self._transaction() as base:
            base.execute("UPDATE cases SET place = NULL")
            base.executemany(
                "INSERT INTO cases (name, place, data, digest, state, why) VALUES (?, ?, ?, ?, ?, ?) "
                "ON CONFLICT (name) DO UPDATE SET "
                "place = excluded.place, data = excluded.data, digest = excluded.digest, "
                "state = excluded.state, why = excluded.why, "
                "message = CASE excluded.state WHEN 'due' THEN '' ELSE message END",
                [(row.name, place, _text(row.case.plain()), row.digest, row.state, row.why)
                 for place, row in enumerate(rows)],
            )  # fmt: skip

    def started(self, name: str, worker: str = "") -> None:
        """A case is being computed."""
        with self._transaction() as base:
            base.execute("UPDATE cases SET state = ?, began = ?, worker = ? WHERE name = ?",
                         (RUNNING, _now(), worker, name))  # fmt: skip

    def put_back(self, why: str) -> list[str]:
        """Cases that were being computed are due again; their names."""
        with self._transaction() as base:
            found = [name for (name,) in base.execute("SELECT name FROM cases WHERE state = ?", (RUNNING,))]
            base.execute("UPDATE cases SET state = ?, why = ? WHERE state = ?", (DUE, why, RUNNING))
        return found

    def lost(self, name: str, why: str) -> None:
        """A case is due again."""
        with self._transaction() as base:
            base.execute("UPDATE cases SET state = ?, why = ? WHERE name = ?", (DUE, why, name))

    def ended(self, name: str, state: str, outcome: Mapping[str, Any]) -> None:
        """A case is done or has failed; outcome: the other fields of a Row by name, with all statistics."""
        told = {"why": "", "message": "", "warnings": "", "ended": _now(), **outcome}
        statistics = dict(told.get("statistics", {}))
        told["files"] = _text(told.get("files", {}))
        told["statistics"] = _text(statistics.pop("channels", {}))
        told["more"] = zlib.compress(_text(statistics).encode()) if statistics else None
        with self._transaction() as base:
            columns = ", ".join(f"{key} = ?" for key in told)
            base.execute(f"UPDATE cases SET state = ?, {columns} WHERE name = ?", (state, *told.values(), name))

    # --- files and errors --------------------------------------------------------------------------------------------

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        with self._sentences():
            self._base.execute("BEGIN IMMEDIATE")
            try:
                yield self._base
                self._base.execute("COMMIT")
            except BaseException:
                if self._base.in_transaction:
                    self._base.execute("ROLLBACK")
                raise

    @contextmanager
    def _sentences(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise RegistryError(f"{self.path}: {_reason(error)}") from None


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold a batch, so that no other process runs it; let go when this one ends, however it does."""
    try:
        lock = sqlite3.connect(folder / LOCK, timeout=0.0, isolation_level=None)
    except sqlite3.Error as error:
        raise RegistryError(f"{folder}: {_reason(error)}") from None
    try:
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.OperationalError as error:
        lock.close()
        if "locked" in str(error):
            raise RegistryError(
                f"{folder}: this batch is running already, in another process; fowt batch status says how far it is."
            ) from None
        raise RegistryError(f"{folder}: {_reason(error)}") from None
    try:
        yield
    finally:
        lock.close()


def _reason(error: sqlite3.Error) -> str:
    """What SQLite says, in a sentence for who runs a batch."""
    text = str(error)
    for words, sentence in (
        ("disk is full", "there is no room on the disk. What is finished is kept; make room and run the batch again."),
        ("readonly", "cannot be written: no permission. Allow it, or run the batch in another folder."),
        ("unable to open", "cannot be opened or written; is the folder there, and may you write in it?"),
        ("disk I/O error", "the disk does not take it (full, or taken away). What is finished is kept; run it again."),
        ("locked", "another process holds it for long; try again when that is done."),
        ("malformed", "the registry is damaged. Put it aside; the results beside it can be read without it."),
        (
            "not a database",
            "is damaged, or no registry. Put it aside; the results beside it can be read without it.",
        ),
    ):
        if words in text:
            return sentence
    return f"the registry cannot be read or written: {text}."


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def _now() -> str:
    return datetime.now().astimezone().isoformat(timespec="seconds")
