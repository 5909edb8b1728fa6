"""An FMU loaded, started, stepped and freed, through fmpy: what runs in the process of the FMU.

This file is loaded by itself there, so it imports nothing of fowtlib.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

PROGRESS = struct.Struct("<qd")  # samples so far, and when the first one was [s]
FATAL = 4  # status after which nothing of the FMU may be called


class FmuFailure(Exception):
    """What is said when the FMU fails."""


class Native:
    """One instance of an FMU.

    given: version, token, identifier and folder of the FMU, its `period` [s]; `start`, `inputs` and `outputs`: lists of
    [access, reference, values or size, is an array], where access is the word behind get and set. memory: numbers of
    double precision: time, inputs, outputs, in the units and in the order of the FMU.
    """

    def __init__(self, given: dict[str, Any], memory: Any):
        self.failures = _failures()
        self.given, self.second = given, given["version"] == "2.0"
        self.numbers = memoryview(memory).cast("d")
        self.inputs, first = _groups(given["inputs"], 1)
        self.outputs, _ = _groups(given["outputs"], first)
        self.said: list[str] = []
        self.samples, self.begin = 0, 0.0
        self.fatal = self.stepping = False
        self.unit: Any = None
        try:
            self._guarded(self._load)
        except BaseException:
            self.close()
            raise

    def _load(self) -> None:
        given = self.given
        if self.second:
            from fmpy.fmi2 import FMU2Slave as Slave
        else:
            from fmpy.fmi3 import FMU3Slave as Slave
        where = os.getcwd()
        try:
            self.unit = Slave(
                guid=given["token"], modelIdentifier=given["identifier"], unzipDirectory=given["folder"],
                instanceName="unit",
            )  # fmt: skip
        finally:
            os.chdir(where)  # fmpy goes into the folder of the library, and stays there if it cannot be loaded
        os.makedirs(os.path.join(given["folder"], "resources"), exist_ok=True)
        if self.second:
            self.unit.instantiate(callbacks=_callbacks_2(self._note))
        else:
            self.unit.instantiate(logMessage=lambda _, status, category, text: self._note(status, text))

    def _note(self, status: int, text: bytes | None) -> None:
        if status and text:
            self.said = [*self.said[-2:], text.decode("utf-8", "replace").strip()]

    # --- stepping ------------------------------------------------------------------------------------------------

    def step(self) -> str:
        """Take time and inputs from the memory, leave the outputs there."""
        self._guarded(self._advance if self.samples else self._initialise)
        self.samples += 1
        self._guarded(self._get_outputs)
        return ""

    def _initialise(self) -> None:
        unit, self.begin = self.unit, self.numbers[0]
        for access, reference, values, _ in self.given["start"]:
            self._set(access, [reference], values)
        if self.second:
            unit.setupExperiment(startTime=self.begin)
            unit.enterInitializationMode()
        else:
            unit.enterInitializationMode(startTime=self.begin)
        self._set_inputs()
        unit.exitInitializationMode()
        self.stepping = True

    def _advance(self) -> None:
        self._set_inputs()
        period = self.given["period"]
        last = self.begin + (self.samples - 1) * period
        done = self.unit.doStep(currentCommunicationPoint=last, communicationStepSize=period)
        if done is not None:  # FMI 3.0
            _, terminate, early, reached = done
            if terminate:
                raise FmuFailure("the FMU asks to end the simulation")
            if early and reached < last + 0.999999 * period:
                raise FmuFailure(f"the FMU stops early, at t = {reached:g} s")

    def _set(self, access: str, references: Sequence[int], values: Sequence[Any]) -> None:
        getattr(self.unit, f"set{access}")(references, values)

    def _set_inputs(self) -> None:
        numbers = self.numbers.tolist()
        for access, references, places, _ in self.inputs:
            values = [numbers[place] for place in places]
            if access not in _REALS:
                kind = bool if access == "Boolean" else int
                values = [kind(value) for value in values]
            self._set(access, references, values)

    def _get_outputs(self) -> None:
        for access, references, places, array in self.outputs:
            count = {"nValues": len(places)} if array else {}
            values = getattr(self.unit, f"get{access}")(references, **count)
            for place, value in zip(places, values, strict=True):
                self.numbers[place] = float(value)

    def _guarded(self, action: Any) -> Any:
        """What `action` gives; its failure as an error with the words of the FMU."""
        try:
            return action()
        except FmuFailure:
            raise
        except Exception as error:
            self.fatal = isinstance(error, self.failures) and error.status == FATAL
            said = f": {' '.join(self.said)}" if self.said else ""
            raise FmuFailure(f"the FMU fails: {str(error).strip().rstrip('.')}{said}") from error

    # --- what it remembers ---------------------------------------------------------------------------------------

    def save(self) -> bytes:
        """Progress and the state of the FMU."""
        return PROGRESS.pack(self.samples, self.begin) + self._guarded(self._state)

    def _state(self) -> bytes:
        state = self.unit.getFMUState()
        try:
            return self.unit.serializeFMUState(state)
        finally:
            self.unit.freeFMUState(state)

    def restore(self, content: bytes) -> None:
        """Progress and state of another instance of the same FMU, too."""

        def put() -> None:
            state = self.unit.deserializeFMUState(content[PROGRESS.size :])
            try:
                self.unit.setFMUState(state)
            finally:
                self.unit.freeFMUState(state)

        self._guarded(put)
        self.samples, self.begin = PROGRESS.unpack_from(content)
        self.stepping = self.samples > 0

    def close(self) -> None:
        """End the instance and unload its library."""
        unit, self.unit = self.unit, None
        self.numbers.release()
        if unit is None or self.fatal:
            return
        if not unit.component:
            unit.freeLibrary()
            return
        if self.stepping:
            with suppress(self.failures):
                unit.terminate()
        unit.freeInstance()


_REALS = ("Real", "Float64", "Float32")


def _failures() -> type[Exception]:
    """The error of fmpy. Its import brings numpy, whose linear algebra would start threads that nobody needs here."""
    name = "OPENBLAS_NUM_THREADS"
    before = os.environ.get(name)
    os.environ[name] = "1"
    try:
        import fmpy.fmi1
    finally:
        del os.environ[name]
        if before is not None:
            os.environ[name] = before
    return fmpy.fmi1.FMICallException


def _groups(signals: Sequence[Sequence[Any]], first: int) -> tuple[list[tuple[str, list[int], list[int], bool]], int]:
    """Signals that go in one call: (access, references, places in the memory, is an array); and the next place."""
    scalars: dict[str, tuple[list[int], list[int]]] = {}
    found: list[tuple[str, list[int], list[int], bool]] = []
    for access, reference, size, array in signals:
        places = list(range(first, first + size))
        first += size
        if array:
            found.append((access, [reference], places, True))
        else:
            references, taken = scalars.setdefault(access, ([], []))
            references.append(reference)
            taken += places
    return [(access, *both, False) for access, both in scalars.items()] + found, first


def _callbacks_2(note: Any) -> Any:
    """Callback functions of FMI 2.0 that keep the messages of the FMU."""
    from fmpy import calloc, fmi2, free

    def log(environment: Any, name: bytes, status: int, category: bytes, text: bytes) -> None:
        note(status, text)

    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(log)
    callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
    return callbacks
