"""An FMU at work: unpacked, started in a process of its own, stepped, freed."""

from __future__ import annotations

import importlib.util
import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.components.fmu.archive import Archive
from fowtlib.components.fmu.description import REALS, Description, FmuVariable
from fowtlib.components.fmu.native import TIME_SIZE, Group, groups
from fowtlib.components.fmu.signals import FmuSignal
from fowtlib.components.isolation import Inside, Outside, Unit, private_folder, remove
from fowtlib.language.errors import SimulationError

NO_FMPY = "an FMU runs through the Python package fmpy, which is not installed: pip install 'fowtlib[fmi]'."
NATIVE = Path(__file__).with_name("native.py")


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
    outputs hold from this one on. In a process of its own a call may take `patience` [s].
    """

    archive: Archive
    description: Description
    content: bytes
    inputs: Sequence[FmuSignal]
    outputs: Sequence[FmuSignal]
    start_values: dict[str, list[Any]]
    period: float
    patience: float = 60.0
    in_process: bool = False
    time_factor: float = 1.0
    """Seconds of the FMU in one second of the model; `period` is in those of the FMU."""

    @property
    def keeps_state(self) -> bool:
        """Whether its sessions can save and restore what they remember."""
        return self.description.keeps_state

    def start(self) -> FmuSession:
        """A fresh instance."""
        return FmuSession(self)

    def given(self, folder: Path) -> dict[str, Any]:
        """What the process of the FMU is told; see native.py."""
        own = self.description
        return {
            "version": own.version, "token": own.token, "identifier": own.identifier, "folder": str(folder),
            "period": self.period,
            "start": [[*_address(own, own.variables[name]), values] for name, values in self.start_values.items()],
            "inputs": [_signal(own, signal.variable) for signal in _in_calls(self.inputs)],
            "outputs": [_signal(own, signal.variable) for signal in _in_calls(self.outputs)],
        }  # fmt: skip


class FmuSession:
    """One instance of an FMU. Raises SimulationError with what the FMU says when it fails."""

    def __init__(self, process: FmuProcess):
        self.process = process
        self.unit: Unit | None = None
        if importlib.util.find_spec("fmpy") is None:
            raise SimulationError(NO_FMPY)
        self.folder = private_folder()
        try:
            if process.archive.description() != process.content:
                raise SimulationError(f"'{process.archive.path}' has changed since the model was made.")
            files = self.folder / "unit"
            files.mkdir()
            process.archive.unpack(files)
            self.unit = self._unit(files)
        except BaseException:
            self.close()
            raise

    def _unit(self, files: Path) -> Unit:
        process, given = self.process, self.process.given(files)
        inputs, end = groups(given["inputs"], given["version"], TIME_SIZE)
        outputs, size = groups(given["outputs"], given["version"], end)
        if process.in_process:
            unit: Unit = Inside(NATIVE, given, size)
        else:
            what = f"the FMU '{process.archive.path.name}'"
            unit = Outside(NATIVE, given, size, what=what, folder=self.folder, patience=process.patience, cwd=files)
        self._time = np.frombuffer(unit.memory, float, 1)
        self._inputs = _Columns(process.inputs, inputs, unit.memory)
        self._outputs = _Columns(process.outputs, outputs, unit.memory)
        return unit

    def step(self, t: float, inputs: np.ndarray) -> np.ndarray:
        """See FmuProcess."""
        self._time[0] = t * self.process.time_factor
        self._inputs.put(inputs)
        self.unit.step()
        return self._outputs.take()

    def saved_state(self) -> bytes:
        """All that the instance remembers. SimulationError where it cannot save it."""
        if not self.process.keeps_state:
            raise SimulationError(
                f"'{self.process.archive.path.name}' does not say that it can save its state (canGetAndSetFMUstate, "
                "canSerializeFMUstate)"
            )
        return self.unit.save()

    def restore_state(self, state: bytes) -> None:
        """Go on as the instance whose state was saved; in a fresh session too."""
        self.unit.restore(state)

    def close(self) -> None:
        """End the instance and its process, and delete its files."""
        unit, self.unit = self.unit, None
        try:
            if unit is not None:
                unit.close()
        finally:
            remove(self.folder)


class _Columns:
    """All inputs or all outputs at once, between an SI column of the model and the memory of the FMU.

    FMI orders a matrix row by row, the model holds it column by column.
    """

    def __init__(self, signals: Sequence[FmuSignal], calls: Sequence[Group], memory: Any):
        sizes = [signal.variable.size for signal in signals]
        first = dict(zip((signal.port for signal in signals), np.cumsum([0, *sizes]).tolist(), strict=False))
        order, factor, offset = [np.zeros(0, int)], [np.zeros(0)], [np.zeros(0)]
        whole: list[FmuSignal | None] = []  # of each element that is no real number, its signal
        for signal in _in_calls(signals):
            size, shape = signal.variable.size, signal.variable.shape
            order.append((first[signal.port] + np.arange(size)).reshape(shape, order="F").ravel())
            factor.append(np.full(size, signal.scale.factor))
            offset.append(np.full(size, signal.scale.offset))
            whole += [None if signal.variable.kind in REALS else signal] * size
        self.order = np.concatenate(order)  # where in the SI column an element of the FMU is
        self.factor, self.offset = np.concatenate(factor), np.concatenate(offset)
        self.sections = _sections(calls, memory)
        self.real = [(places, part) for places, part in self.sections if whole[places.start] is None]
        self.whole = [
            (part, k - places.start, k, signal)
            for places, part in self.sections
            for k, signal in enumerate(whole[places], places.start)
            if signal is not None
        ]

    def put(self, column: np.ndarray) -> None:
        """Into the memory."""
        own = column.take(self.order)
        np.subtract(own, self.offset, own)
        np.divide(own, self.factor, own)
        for places, part in self.real:
            part[:] = own[places]
        for part, place, k, signal in self.whole:
            part[place] = signal.whole(own.item(k))

    def take(self) -> np.ndarray:
        """Out of the memory."""
        own, column = np.empty(self.order.size), np.empty(self.order.size)
        for places, part in self.sections:
            own[places] = part
        np.multiply(own, self.factor, own)
        np.add(own, self.offset, own)
        column[self.order] = own
        return column


def _sections(calls: Sequence[Group], memory: Any) -> list[tuple[slice, np.ndarray]]:
    """The elements of one type, which elements of all they are, and their place in the memory."""
    found, first = [], 0
    for call in calls:
        places = slice(first, first := first + call.count)
        found.append((places, np.frombuffer(memory, call.kind, call.count, call.offset)))
    return found


def _in_calls(signals: Sequence[FmuSignal]) -> list[FmuSignal]:
    """Those of one type side by side, so that few calls do: they go to the FMU in this order."""

    def rank(signal: FmuSignal) -> tuple[bool, bool, str]:
        own = signal.variable
        return own.kind not in REALS, bool(own.shape), own.kind

    return sorted(signals, key=rank)


def _address(own: Description, variable: FmuVariable) -> tuple[str, int]:
    """The word behind get and set, and the reference."""
    enumeration = "Integer" if own.version == "2.0" else "Int64"
    return enumeration if variable.kind == "Enumeration" else variable.kind, variable.reference


def _signal(own: Description, variable: FmuVariable) -> list[Any]:
    return [*_address(own, variable), variable.size, bool(variable.shape)]
