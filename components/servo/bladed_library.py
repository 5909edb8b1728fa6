"""A Bladed-style controller library at work: the swap array, and the process that calls the library."""

from __future__ import annotations

import math
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtlib.components.servo import bladed_worker
from fowtlib.language.errors import SimulationError

LENGTH = 3300  # records, as many as the extended interface of OpenFAST 3.5 has
PATIENCE = 60.0  # s that one call may take
STATUS, TIME, PERIOD, TORQUE_DEMAND = 1, 2, 3, 47  # numbers of records, from 1
PITCH_DEMAND, COLLECTIVE_DEMAND, PITCH, TORQUE, AZIMUTH = (42, 43, 44), 45, (4, 33, 34), 23, 60
MESSAGE_SIZE, INPUT_SIZE, OUTPUT_SIZE = 49, 50, 51
FIRST, LATER, LAST = 0, 1, -1
# What a controller may ask for that the model does not do: record, value that asks for nothing, what it is.
UNKNOWN_DEMANDS = ((36, 0, "the shaft brake"), (55, 0, "the pitch of its host"), (56, 0, "the torque of its host"))
CONTACTOR = 35  # 1: the generator is on


@dataclass(frozen=True)
class BladedProcess:
    """A controller library that can be run again and again, each time in a process of its own.

    measured: the record of each input. demanded: the record of each further output. fixed: records and their values.
    """

    library: str
    procedure: str
    input_file: str
    output_root: str
    period: float
    blades: int
    individual: bool
    efficiency: float
    measured: Sequence[int]
    demanded: Sequence[int]
    fixed: Mapping[int, float]

    def start(self) -> BladedSession:
        """A fresh copy of the controller."""
        return BladedSession(self)


class BladedSession:
    """One run of a controller library. Raises SimulationError with what the library says when it fails."""

    def __init__(self, process: BladedProcess):
        self.process = process
        self.samples = 0
        self.asked: float | None = None  # since when an answer is waited for
        self.ended = threading.Event()
        self.warned: set[str] = set()
        self.folder = Path(tempfile.mkdtemp(prefix="fowtlib_bladed_"))
        self.output_root = process.output_root or str(self.folder / "controller")
        arguments = [process.library, process.procedure, process.input_file, self.output_root, str(LENGTH)]
        self.printed = (self.folder / "printed.txt").open("w+b")
        self.worker = subprocess.Popen(
            [sys.executable, "-I", bladed_worker.__file__, *arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.printed,
            cwd=Path(process.input_file).parent if process.input_file else self.folder,
            start_new_session=True,  # Ctrl-C is for the simulation, which then ends the worker
        )  # fmt: skip
        self.swap = np.zeros(LENGTH, np.float32)
        threading.Thread(target=self._watch, daemon=True).start()
        try:
            self.asked = time.monotonic()
            self._answer("loaded")
        except BaseException:
            self.close()
            raise

    # --- stepping ------------------------------------------------------------------------------------------------

    def step(self, t: float, inputs: np.ndarray) -> np.ndarray:
        """The demanded pitch of each blade, the further records that are asked for, and the demanded torque."""
        given, swap = self.process, self.swap
        self._set(PERIOD, given.period)
        self._set(61, given.blades)
        self._set(28, float(given.individual))
        self._set(MESSAGE_SIZE, bladed_worker.MESSAGE_LENGTH)
        self._set(INPUT_SIZE, len(given.input_file.encode()) + 1)
        self._set(OUTPUT_SIZE, len(self.output_root.encode()) + 1)
        self._set(129, LENGTH)
        for number, value in given.fixed.items():
            self._set(number, value)
        for number, value in zip(given.measured, inputs, strict=True):
            self._set(number, value % (2 * math.pi) if number == AZIMUTH else value)
        power = float(swap[20 - 1]) * float(swap[TORQUE - 1])
        self._set(14, power)
        self._set(15, given.efficiency * power)
        if not self.samples:
            self._set(CONTACTOR, 1)
        self._call(FIRST if not self.samples else LATER, t)
        self.samples += 1
        return self._demands()

    def _set(self, number: int, value: float) -> None:
        self.swap[number - 1] = value

    def _demands(self) -> np.ndarray:
        given, swap = self.process, self.swap
        for number, nothing, what in UNKNOWN_DEMANDS:
            if swap[number - 1] != nothing:
                raise SimulationError(f"the controller asks for {what} (record {number}), which the model has not")
        numbers = PITCH_DEMAND[: given.blades] if given.individual else (COLLECTIVE_DEMAND,) * given.blades
        torque = swap[TORQUE_DEMAND - 1] if round(float(swap[CONTACTOR - 1])) == 1 else 0.0
        return np.array([*(swap[number - 1] for number in (*numbers, *given.demanded)), torque], dtype=float)

    def _call(self, status: int, t: float) -> None:
        self._set(STATUS, status)
        self._set(TIME, t)
        self.asked = time.monotonic()
        with suppress(BrokenPipeError, OSError):
            self.worker.stdin.write(self.swap.tobytes())
            self.worker.stdin.flush()
        self._answer("called")

    # --- the other process ---------------------------------------------------------------------------------------

    def _answer(self, what: str) -> None:
        head = self.worker.stdout.read(8)
        if len(head) == 8:
            flag, length = struct.unpack("ii", head)
            message = self.worker.stdout.read(length).decode("utf-8", "replace").strip()
            content = self.worker.stdout.read(4 * LENGTH)
        if len(head) < 8 or len(content) < 4 * LENGTH:
            raise SimulationError(self._death(what))
        self.asked = None
        self.swap = np.frombuffer(content, np.float32).copy()
        if flag < 0:
            raise SimulationError(self._refusal(what, message or self._last_words()))
        if flag > 0 and message not in self.warned:
            self.warned.add(message)
            warnings.warn(f"the controller library says: {message or 'no message'}", stacklevel=3)

    def _refusal(self, what: str, message: str) -> str:
        """What the library says against a call; or the system, against loading it."""
        if what != "loaded":
            return f"the controller library reports an error: {message}"
        beside = "; a library that was unpacked from a wheel finds those it needs beside it: leave it in its folder"
        hint = beside if "cannot open shared object" in message or "Library not loaded" in message else ""
        return f"the controller library cannot be loaded: {message}{hint}."

    def _death(self, what: str) -> str:
        waited = self.asked is not None and time.monotonic() - self.asked > PATIENCE
        code = self.worker.wait()
        why = f"it took longer than {PATIENCE:g} s" if waited else f"it ended its process with the code {code}"
        if not waited and code < 0:
            why = f"it crashed ({signal.Signals(-code).name})"
        return f"the controller library cannot be {what}: {why}; it printed: {self._last_words()}"

    def _last_words(self) -> str:
        self.printed.seek(0)
        lines = self.printed.read()[-4000:].decode("utf-8", "replace").split("\n")
        return " ".join(line.strip() for line in lines if line.strip())[-400:] or "nothing"

    def _watch(self) -> None:
        while not self.ended.wait(1.0):
            if self.asked is not None and time.monotonic() - self.asked > PATIENCE:
                self.worker.kill()
                return

    def close(self) -> None:
        """Make the last call, end the process and delete its files."""
        try:
            if self.samples and self.worker.poll() is None and self.asked is None:
                self._call(LAST, float(self.swap[TIME - 1]))
        finally:
            self.ended.set()
            with suppress(OSError):
                self.worker.stdin.close()
            try:
                self.worker.wait(5)
            except subprocess.TimeoutExpired:
                self.worker.kill()
                self.worker.wait()
            self.worker.stdout.close()
            self.printed.close()
            shutil.rmtree(self.folder, ignore_errors=True)
