"""An FMU at work: unpacked, loaded, started, stepped and freed, through fmpy."""

from __future__ import annotations

import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.components.fmu.archive import Archive
from fowtlib.components.fmu.description import Description, FmuVariable
from fowtlib.components.fmu.signals import FmuSignal
from fowtlib.language.errors import ModelError, SimulationError

NO_FMPY = "an FMU runs through the Python package fmpy, which is not installed: pip install 'fowtlib[fmi]'."


def platform_folder(version: str) -> str:
    """The folder below binaries/ for this machine: linux64 and the like in FMI 2.0, x86_64-linux in 3.0."""
    bits = "64" if sys.maxsize > 2**32 else "32"
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    if version == "2.0":
        return {"windows": "win"}.get(system, system) + bits
    arm = platform.machine().lower() in ("aarch64", "arm64")
    return f"{'aarch64' if arm else 'x86_64' if bits == '64' else 'x86'}-{system}"


@dataclass(frozen=True)
class FmuProcess:
    """An FMU that can be run again and again; each run has an instance of its own, from files unpacked for it.

    At the first sample, t0, the instance is initialised with the inputs of t0; its outputs hold from t0 on. At each
    later sample the inputs of that instant are set, the instance steps from the last sample to this one, and its
    outputs hold from this one on.
    """

    archive: Archive
    description: Description
    content: bytes
    inputs: Sequence[FmuSignal]
    outputs: Sequence[FmuSignal]
    start_values: dict[str, list[Any]]
    period: float

    def start(self) -> FmuSession:
        """A fresh instance."""
        return FmuSession(self)


@dataclass
class _Messages:
    """What the FMU has said last."""

    lines: list[str] = field(default_factory=list)

    def add(self, status: int, text: bytes | None) -> None:
        if status and text:
            self.lines = [*self.lines[-2:], text.decode("utf-8", "replace").strip()]


class FmuSession:
    """One instance of an FMU. Raises SimulationError with what the FMU says when it fails."""

    def __init__(self, process: FmuProcess):
        self.process = process
        self.samples = 0
        self.fatal = self.stepping = False
        self.unit: Any = None
        self.messages = _Messages()
        try:
            import fmpy.fmi1
        except ImportError:
            raise SimulationError(NO_FMPY) from None
        self.failures = fmpy.fmi1.FMICallException
        self.folder = Path(tempfile.mkdtemp(prefix="fowtlib_fmu_"))
        try:
            if process.archive.description() != process.content:
                raise SimulationError(f"'{process.archive.path}' has changed since the model was made.")
            process.archive.unpack(self.folder)
            self._guarded(self._load)
        except BaseException:
            self.close()
            raise

    def _load(self) -> None:
        given, second = self.process.description, self.process.description.version == "2.0"
        if second:
            from fmpy.fmi2 import FMU2Slave as Slave
        else:
            from fmpy.fmi3 import FMU3Slave as Slave
        where = os.getcwd()
        try:
            self.unit = Slave(
                guid=given.token, modelIdentifier=given.identifier, unzipDirectory=str(self.folder), instanceName="unit"
            )
        finally:
            os.chdir(where)  # fmpy goes into the folder of the library, and stays there if it cannot be loaded
        (self.folder / "resources").mkdir(exist_ok=True)
        if second:
            self.unit.instantiate(callbacks=_callbacks_2(self.messages))
        else:
            self.unit.instantiate(logMessage=lambda _, status, category, text: self.messages.add(status, text))

    # --- stepping ------------------------------------------------------------------------------------------------

    def step(self, t: float, inputs: np.ndarray) -> np.ndarray:
        """See FmuProcess."""
        self._guarded(self._advance if self.samples else self._initialise, t, inputs)
        self.samples += 1
        return self._guarded(self._outputs)

    def _initialise(self, t: float, inputs: np.ndarray) -> None:
        unit, given = self.unit, self.process.description
        self.begin = t
        for name, values in self.process.start_values.items():
            self._set(given.variables[name], values)
        if given.version == "2.0":
            unit.setupExperiment(startTime=t)
            unit.enterInitializationMode()
        else:
            unit.enterInitializationMode(startTime=t)
        self._set_inputs(inputs)
        unit.exitInitializationMode()
        self.stepping = True

    def _advance(self, t: float, inputs: np.ndarray) -> None:
        self._set_inputs(inputs)
        period = self.process.period
        last = self.begin + (self.samples - 1) * period
        done = self.unit.doStep(currentCommunicationPoint=last, communicationStepSize=period)
        if done is not None:  # FMI 3.0
            _, terminate, early, reached = done
            if terminate:
                raise SimulationError("the FMU asks to end the simulation")
            if early and reached < last + 0.999999 * period:
                raise SimulationError(f"the FMU stops early, at t = {reached:g} s")

    def _set_inputs(self, inputs: np.ndarray) -> None:
        first = 0
        for signal in self.process.inputs:
            size = signal.variable.size
            self._set(signal.variable, signal.to_fmu(inputs[first : first + size]))
            first += size

    def _set(self, variable: FmuVariable, values: list[Any]) -> None:
        getattr(self.unit, f"set{self._access(variable)}")([variable.reference], values)

    def _access(self, variable: FmuVariable) -> str:
        """The word behind get and set."""
        if variable.kind != "Enumeration":
            return variable.kind
        return "Integer" if self.process.description.version == "2.0" else "Int64"

    def _outputs(self) -> np.ndarray:
        columns = [np.zeros(0)]
        for signal in self.process.outputs:
            variable = signal.variable
            count = {"nValues": variable.size} if variable.shape else {}
            values = getattr(self.unit, f"get{self._access(variable)}")([variable.reference], **count)
            columns.append(signal.from_fmu(values))
        return np.concatenate(columns)

    def _guarded(self, action: Callable[..., Any], *arguments: Any) -> Any:
        """What `action` gives; its failure as an error with the words of the FMU."""
        try:
            return action(*arguments)
        except ModelError:
            raise
        except Exception as error:
            self.fatal = isinstance(error, self.failures) and error.status == 4
            said = f": {' '.join(self.messages.lines)}" if self.messages.lines else ""
            raise SimulationError(f"the FMU fails: {str(error).strip().rstrip('.')}{said}") from error

    def close(self) -> None:
        """End the instance, unload its library and delete its files."""
        unit, self.unit = self.unit, None
        try:
            if unit is not None and not self.fatal and unit.component:
                if self.stepping:
                    with suppress(self.failures):
                        unit.terminate()
                unit.freeInstance()
            elif unit is not None and not self.fatal:
                unit.freeLibrary()
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)


def _callbacks_2(messages: _Messages) -> Any:
    """Callback functions of FMI 2.0 that keep the messages of the FMU."""
    from fmpy import calloc, fmi2, free

    def log(environment: Any, name: bytes, status: int, category: bytes, text: bytes) -> None:
        messages.add(status, text)

    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(log)
    callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
    return callbacks
