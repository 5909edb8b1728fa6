"""An FMU loaded, started, stepped and freed, through fmpy: what runs in the process of the FMU.

This file is loaded by itself there, so it imports nothing of fowtlib.
"""

from __future__ import annotations

import ctypes
import itertools
import os
import struct
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, NamedTuple

PROGRESS = struct.Struct("<qd")  # samples so far, and when the first one was [s]
WARNING, FATAL = 1, 4  # the last status that is no failure; the one after which nothing of the FMU may be called
TIME_SIZE = 8  # bytes at the start of the memory
C_TYPES = {
    "Real": ctypes.c_double, "Integer": ctypes.c_int, "Float64": ctypes.c_double, "Float32": ctypes.c_float,
    "Int8": ctypes.c_int8, "Int16": ctypes.c_int16, "Int32": ctypes.c_int32, "Int64": ctypes.c_int64,
    "UInt8": ctypes.c_uint8, "UInt16": ctypes.c_uint16, "UInt32": ctypes.c_uint32, "UInt64": ctypes.c_uint64,
}  # fmt: skip


class FmuFailure(Exception):
    """What is said when the FMU fails."""


class Group(NamedTuple):
    """Signals that go in one call, and where their `count` values of a C type `kind` lie in the memory [bytes]."""

    access: str
    references: list[int]
    kind: Any
    count: int
    offset: int


def groups(signals: Sequence[Sequence[Any]], version: str, offset: int) -> tuple[list[Group], int]:
    """Neighbours of one type go in one call, an array goes alone; and the next free place in the memory.

    signals: [access, reference, size, is an array] of each, where access is the word behind get and set.
    """
    found: list[Group] = []
    for (access, _), some in itertools.groupby(signals, lambda one: (one[0], one[1] if one[3] else None)):
        references, count = [], 0
        for _, reference, size, _ in some:
            references.append(reference)
            count += size
        if access == "Boolean":
            kind: Any = ctypes.c_int if version == "2.0" else ctypes.c_bool
        else:
            kind = C_TYPES[access]
        found.append(Group(access, references, kind, count, offset))
        offset += (count * ctypes.sizeof(kind) + 7) // 8 * 8  # any type may begin there
    return found, offset


class Native:
    """One instance of an FMU.

    given: version, token, identifier and folder of the FMU, its `period` [s]; `start`: lists of [access, reference,
    values]; `inputs` and `outputs`: see `groups`. memory: the time (double precision), then the values of the inputs
    and of the outputs, in the units, the types and the order of the FMU, as `groups` lays them out: the FMU itself
    reads and writes there.
    """

    def __init__(self, given: dict[str, Any], memory: Any):
        self.failures = _failures()
        self.given, self.second = given, given["version"] == "2.0"
        self.memory: Any = memory
        self.setting: list[Any] = []  # calls with all their arguments, made once: a step allocates nothing
        self.getting: list[Any] = []
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
        self._prepare()

    def _prepare(self) -> None:
        inputs, end = groups(self.given["inputs"], self.given["version"], TIME_SIZE)
        outputs, _ = groups(self.given["outputs"], self.given["version"], end)
        self.setting = [self._call("Set", group) for group in inputs]
        self.getting = [self._call("Get", group) for group in outputs]
        self.time = ctypes.c_double.from_buffer(self.memory)
        self.last = ctypes.c_double(0.0)
        arguments = [ctypes.c_void_p(self.unit.component), self.last, ctypes.c_double(self.given["period"])]
        if self.second:
            arguments.append(ctypes.c_int(1))  # no state before this step is set again
        else:
            self.event, self.terminate, self.early = (ctypes.c_bool() for _ in range(3))
            self.reached = ctypes.c_double()
            results = (self.event, self.terminate, self.early, self.reached)
            arguments += [ctypes.c_bool(True), *map(ctypes.byref, results)]
        self.stepped = self._function("DoStep"), tuple(arguments)

    def _function(self, word: str) -> Any:
        """A function of the library, with the name that a failure tells."""
        return self.unit.dll[f"fmi{2 if self.second else 3}{word}"]

    def _call(self, verb: str, group: Group) -> tuple[Any, tuple[Any, ...]]:
        size = len(group.references)
        values = (group.kind * group.count).from_buffer(self.memory, group.offset)
        references = (ctypes.c_uint32 * size)(*group.references)
        arguments = (ctypes.c_void_p(self.unit.component), references, ctypes.c_size_t(size), values)
        count = () if self.second else (ctypes.c_size_t(group.count),)
        return self._function(verb + group.access), arguments + count

    def _note(self, status: int, text: bytes | None) -> None:
        if status and text:
            self.said = [*self.said[-2:], text.decode("utf-8", "replace").strip()]

    # --- stepping ------------------------------------------------------------------------------------------------

    def step(self) -> str:
        """Take time and inputs from the memory, leave the outputs there."""
        try:
            if self.samples:
                self._advance()
            else:
                self._initialise()
            self.samples += 1
            for function, arguments in self.getting:
                if (status := function(*arguments)) > WARNING:
                    raise self._refused(function, status)
        except FmuFailure:
            raise
        except Exception as error:
            raise self._failure(error) from error
        return ""

    def _initialise(self) -> None:
        unit, self.begin = self.unit, self.time.value
        for access, reference, values in self.given["start"]:
            getattr(unit, f"set{access}")([reference], values)
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
        last = self.last.value = self.begin + (self.samples - 1) * period
        function, arguments = self.stepped
        if (status := function(*arguments)) > WARNING:
            raise self._refused(function, status)
        if self.second:
            return
        if self.terminate.value:
            raise FmuFailure("the FMU asks to end the simulation")
        if self.early.value and self.reached.value < last + 0.999999 * period:
            raise FmuFailure(f"the FMU stops early, at t = {self.reached.value:g} s")

    def _set_inputs(self) -> None:
        for function, arguments in self.setting:
            if (status := function(*arguments)) > WARNING:
                raise self._refused(function, status)

    def _refused(self, function: Any, status: int) -> Exception:
        return self.failures(function=function.__name__, status=status)

    def _guarded(self, action: Any) -> Any:
        """What `action` gives; its failure as an error with the words of the FMU."""
        try:
            return action()
        except FmuFailure:
            raise
        except Exception as error:
            raise self._failure(error) from error

    def _failure(self, error: Exception) -> FmuFailure:
        self.fatal = isinstance(error, self.failures) and error.status == FATAL
        said = f": {' '.join(self.said)}" if self.said else ""
        return FmuFailure(f"the FMU fails: {str(error).strip().rstrip('.')}{said}")

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
        self.memory = self.time = None
        self.setting = self.getting = []
        if unit is None or self.fatal:
            return
        if not unit.component:
            unit.freeLibrary()
            return
        if self.stepping:
            with suppress(self.failures):
                unit.terminate()
        unit.freeInstance()


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
