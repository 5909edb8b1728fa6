"""The journal of an optimisation: a line of JSON for each design that was evaluated, on the disk before the next one.

The first line says what problem it is of. A line that a kill has cut off is left out, so that after Ctrl-C, a kill or a
power cut the work goes on from the best design that was found.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from fowtlib.design.problem import Point
from fowtlib.language.errors import ModelError

VERSION = 1


@dataclass(frozen=True, eq=False)
class Kept:
    """A design of a journal: which start led to it, its variables [SI], objective, violation, and why it failed."""

    start: int
    x: np.ndarray
    objective: float
    violation: float
    iterate: bool = False
    failure: str = ""


@dataclass(frozen=True)
class Earlier:
    """What a journal holds: designs in their order, and the starts that have ended, with their reasons."""

    designs: tuple[Kept, ...] = ()
    ended: Mapping[int, tuple[bool, str]] = field(default_factory=dict)

    def best(self, start: int) -> Kept | None:
        """Of a start: the feasible one with the least objective, else the one with the least violation."""
        from fowtlib.design.problem import FEASIBLE

        sound = [kept for kept in self.designs if kept.start == start and not kept.failure]
        return min(sound, key=lambda kept: (kept.violation > FEASIBLE, kept.objective if kept.violation <= FEASIBLE
                                            else kept.violation), default=None)  # fmt: skip


class Journal:
    """Writes the journal of a problem at `path`; `about` identifies the problem."""

    def __init__(self, path: str | os.PathLike[str], about: Mapping[str, Any]):
        self.path = Path(path)
        self.about = json.loads(json.dumps(about, default=str))
        text = json.dumps(self.about, sort_keys=True)
        self.digest = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
        self._file: TextIO | None = None

    def begin(self, resume: bool) -> Earlier:
        """Open it; with `resume`, what is in it already. ModelError where it is of another problem, or not writable."""
        earlier = self.read() if resume and self.path.exists() else Earlier()
        try:
            if resume and self.path.exists():
                self._mend()
                self._file = self.path.open("a", encoding="utf-8")
            else:
                self._file = self.path.open("w", encoding="utf-8")
                self._write({"fowtlib_design_journal": VERSION, "digest": self.digest, "about": self.about})
        except OSError as error:
            raise ModelError(f"{self.path}: cannot be written: {error.strerror}.") from None
        return earlier

    def read(self) -> Earlier:
        """What it holds."""
        lines = self._lines()
        if not lines or lines[0].get("fowtlib_design_journal") != VERSION:
            raise ModelError(f"{self.path}: this is no journal of a design.")
        if lines[0].get("digest") != self.digest:
            changed = _changed(lines[0].get("about"), self.about)
            raise ModelError(f"{self.path}: the journal is of another design{changed}; begin without resuming, or name "
                             "another journal.")  # fmt: skip
        designs = tuple(
            Kept(line["start"], np.array(line["x"], dtype=float), _number(line["objective"]),
                 _number(line["violation"]), line.get("iterate", False), line.get("failure", ""))
            for line in lines[1:] if "x" in line
        )  # fmt: skip
        ended = {line["ended"]: (line["converged"], line["reason"]) for line in lines[1:] if "ended" in line}
        return Earlier(designs, ended)

    def _lines(self) -> list[dict[str, Any]]:
        found = []
        try:
            text = self.path.read_text(encoding="utf-8", errors="replace")
        except OSError as error:
            raise ModelError(f"{self.path}: cannot be read: {error.strerror}.") from None
        for line in text.splitlines():
            try:
                item = json.loads(line)
            except ValueError:
                continue  # cut off by a kill, or damaged: the others are sound
            if isinstance(item, dict):
                found.append(item)
        return found

    def _mend(self) -> None:
        """End a line that was cut off, so that the next one is whole."""
        with self.path.open("rb+") as file:
            if file.seek(0, os.SEEK_END):
                file.seek(-1, os.SEEK_END)
                if file.read(1) != b"\n":
                    file.write(b"\n")

    def design(self, start: int, point: Point, iterate: bool = False) -> None:
        """Add a design."""
        line: dict[str, Any] = {"start": start, "x": point.x.tolist(), "objective": _plain(point.objective),
                                "violation": _plain(max(point.violation, 0.0)), "worst": point.worst}  # fmt: skip
        line |= {"iterate": True} if iterate else {}
        line |= {"failure": point.failure} if point.failure else {}
        self._write(line)

    def end(self, start: int, converged: bool, reason: str) -> None:
        """Say that a start has come to its end."""
        self._write({"ended": start, "converged": converged, "reason": reason})

    def _write(self, line: Mapping[str, Any]) -> None:
        assert self._file is not None
        try:
            self._file.write(json.dumps(line) + "\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise ModelError(f"{self.path}: cannot be written: {error.strerror}.") from None

    def close(self) -> None:
        if self._file is not None:
            with suppress(OSError):  # a line that could not be written, which was said
                self._file.close()
            self._file = None


def _plain(value: float) -> float | str | None:
    return float(value) if np.isfinite(value) else None


def _number(value: float | None) -> float:
    return np.inf if value is None else float(value)


def _changed(before: Any, now: Any) -> str:
    if not isinstance(before, dict):
        return ""
    keys = [key for key in {**before, **now} if before.get(key) != now.get(key)]
    return f" ({', '.join(keys)} changed)" if keys else ""
