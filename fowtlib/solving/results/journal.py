"""The journal of a run: its results on disk in pieces while it goes on, and the last point to go on from exactly.

Beside `run.nc` lies `run.nc.part`: a line that says what it is, then blocks, each with its length and a digest. The
first says what the results are called; the others hold output points, and where the run has gone on from an earlier
one the checkpoint of that. `run.nc.part.state` is the last checkpoint, replaced in one step, with the name of its
journal and the length that this had: it counts only where all that it follows is sound. Both are on the disk (fsync)
before the run goes on, and go when the final file is there. While a run writes, its process holds a lock on the
journal, where the system has such; it goes with the process.
"""

from __future__ import annotations

import os
import struct
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import replace_file
from fowtlib.solving.results.data import RawTrajectory, Stored
from fowtlib.solving.results.packing import packed, packed_pieces, unpacked

try:
    import fcntl
except ImportError:  # Windows: who starts two runs to one file there is not warned
    fcntl = None  # type: ignore[assignment]

FIRST = b"fowtlib journal 1\n"
ENDING, STATE = ".part", ".state"


def journal_of(path: Path) -> Path:
    """Where the journal of a run lies whose results go to `path`."""
    return path.with_name(path.name + ENDING)


def state_of(journal: Path) -> Path:
    """Where the checkpoint beside a journal lies."""
    return journal.with_name(journal.name + STATE)


class NothingKept(ModelError):
    """A run was killed before it had written anything to go on from."""


class Journal:
    """The journal beside a file of results.

    A disk that is full does not stop the run: what could not be written stays in memory and is tried again with the
    next piece; a warning says so.
    """

    def __init__(self, output: Path):
        self.path = journal_of(Path(output))
        self._waiting: list[bytes | memoryview] = []
        self._length = 0  # of what is sound on the disk
        self._name = ""
        self._troubled = False
        self._lock: BinaryIO | None = None

    def require_free(self) -> None:
        """Raise ModelError where a living process writes this journal."""
        try:
            with self.path.open("r+b") as file:
                held = not _locked(file)
        except OSError:  # not there, or not ours to write, which is found elsewhere
            return
        if held:
            raise ModelError(
                f"{self.path}: a run to this file is going on in another process; wait for its end, stop it, or choose "
                "another output."
            )

    def begin(self, about: Mapping[str, Any], earlier: Stored | None = None, checkpoint: bytes = b"") -> None:
        """Start anew, in one step: what a killed run has left there stays until all that it goes on from is here.

        about: what `Stored` holds besides numbers; earlier: what comes before the first piece; checkpoint: where the
        run goes on from.
        """
        self.require_free()
        self._name = os.urandom(8).hex()
        self._waiting = _block({"about": dict(about), "journal": self._name}, {})
        if earlier is not None and earlier.raw is not None:
            self._waiting += _rows(earlier.raw, earlier.values)
        if checkpoint:
            self._waiting += _block({}, {"checkpoint": np.frombuffer(checkpoint, np.uint8)})
        self._flush(new=True)

    def write(self, raw: RawTrajectory | None, values: Mapping[str, np.ndarray], checkpoint: bytes) -> None:
        """Add output points, where there are some, and replace the checkpoint."""
        if raw is not None:
            self._waiting += _rows(raw, values)
        if self._flush():
            try:
                about = {"journal": self._name, "length": self._length}
                replace_file(state_of(self.path), packed(about, {"checkpoint": np.frombuffer(checkpoint, np.uint8)}))
            except OSError as error:
                self._trouble(error)

    def close(self) -> None:
        """The run has ended, and another one may go on from here."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def remove(self) -> None:
        """Take both files away: the results are safe elsewhere."""
        self.close()
        for path in (self.path, state_of(self.path)):
            path.unlink(missing_ok=True)

    def _flush(self, new: bool = False) -> bool:
        size = sum(len(piece) for piece in self._waiting)
        try:
            if new or not self._length:
                replace_file(self.path, b"".join([FIRST, *self._waiting]))
                self._length = len(FIRST) + size
                self._hold()
                state_of(self.path).unlink(missing_ok=True)
            else:
                with self.path.open("r+b") as file:
                    file.truncate(self._length)  # without what a full disk has left half written
                    file.seek(self._length)
                    file.writelines(self._waiting)
                    file.flush()
                    os.fsync(file.fileno())
                self._length += size
        except OSError as error:
            self._trouble(error)
            return False
        self._waiting = []
        return True

    def _hold(self) -> None:
        self.close()
        self._lock = self.path.open("r+b")
        _locked(self._lock)

    def _trouble(self, error: OSError) -> None:
        if self._troubled:
            return
        self._troubled = True
        warnings.warn(
            f"{self.path}: cannot be written ({error.strerror or error}). The run goes on and keeps its results in "
            "memory; each piece is tried again. Make room on the disk before the run ends.", stacklevel=4,
        )  # fmt: skip


def _locked(file: BinaryIO) -> bool:
    """Whether this process has the lock of a file now; also where there are no locks, as on some disks of networks."""
    try:
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def _block(text: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> list[bytes | memoryview]:
    pieces = packed_pieces(text, arrays)
    return [struct.pack("<q", sum(len(piece) for piece in pieces)), *pieces]


def _rows(raw: RawTrajectory, values: Mapping[str, np.ndarray]) -> list[bytes | memoryview]:
    arrays = {"time": raw.time, "x": raw.x, "z": raw.z, "d": raw.d}
    return _block({"names": list(values)}, {**arrays, **{f"value {name}": array for name, array in values.items()}})


def read_journal(path: Path) -> Stored:
    """The results up to the last sound block, with the checkpoint; ModelError where nothing is sound.

    NothingKept where it is sound, and there is neither an output point nor a checkpoint in it.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}.") from None
    if not data.startswith(FIRST):
        raise ModelError(f"{path}: is not the journal of a run of fowtlib, or its beginning is damaged.")
    at, blocks, whole = len(FIRST), [], True
    while at < len(data):
        try:
            length = struct.unpack("<q", data[at : at + 8])[0]
            if not 0 < length <= len(data) - at - 8:
                raise ValueError("cut off")
            blocks.append(unpacked(data[at + 8 : at + 8 + length]))
        except (ValueError, KeyError, struct.error):
            whole = False
            break
        at += 8 + length
    if not blocks or "about" not in blocks[0][0]:
        raise ModelError(f"{path}: the journal is damaged at its beginning; nothing in it can be read.")
    pieces = [arrays for _, arrays in blocks[1:]]
    checkpoint, trouble = _state(path, blocks[0][0].get("journal"), at)
    if not checkpoint:
        checkpoint = next((bytes(arrays["checkpoint"]) for arrays in pieces if "checkpoint" in arrays), b"")
    notes = ["what follows is damaged or was not finished"] * (not whole) + [trouble] * (not checkpoint)
    return _joined(path, blocks[0][0]["about"], [piece for piece in pieces if "time" in piece], checkpoint, notes)


def _state(path: Path, journal: str | None, sound: int) -> tuple[bytes, str]:
    """The checkpoint beside a journal of that name, of which so many bytes are sound; or why there is none."""
    try:
        about, arrays = unpacked(state_of(path).read_bytes())
        of, length, checkpoint = about["journal"], about["length"], bytes(arrays["checkpoint"])
    except OSError as error:
        return b"", f"its checkpoint cannot be read: {error.strerror}"
    except (ValueError, KeyError, TypeError):
        return b"", "its checkpoint is damaged"
    if of != journal:
        return b"", "its checkpoint is of another run"
    if not checkpoint:
        return b"", "it could not save a checkpoint"
    return (checkpoint, "") if length <= sound else (b"", "results before its checkpoint are damaged")


def _joined(path: Path, about: dict[str, Any], pieces: list[dict[str, np.ndarray]], checkpoint: bytes,
            notes: list[str]) -> Stored:  # fmt: skip
    if not pieces and not checkpoint:
        raise NothingKept(f"{path}: the run stopped before its first results were written; start it anew.")
    raw_about, names = about["raw"], list(about["units"])
    empty = dict.fromkeys(("time", "x", "z", "d", *(f"value {name}" for name in names)), np.zeros(0))
    column = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]} if pieces else empty
    time = column["time"]
    raw = RawTrajectory(
        time, column["x"], column["z"], column["d"], *(tuple(raw_about[key]) for key in ("x", "z", "d")),
        raw_about["parameter_hash"], checkpoint,
    )  # fmt: skip
    damage = f" ({'; '.join(notes)})" if notes else ""
    status = f"stopped by force; read from its journal up to t = {raw.last.time:g} s{damage}."
    attributes = {**about["attributes"], "status": status}
    values = {name: column[f"value {name}"] for name in names}
    return Stored(time, values, about["units"], about["long_names"], attributes, raw)
