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
            "start": [[*_address(own, own.variables[name]), values, bool(own.variables[name].shape)]
                      for name, values in self.start_values.items()],
            "inputs": [_signal(own, signal.variable) for signal in self.inputs],
            "outputs": [_signal(own, signal.variable) for signal in self.outputs],
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
        own = np.frombuffer(self.unit.memory, float)
        self._given, self._taken = _Columns(process.inputs), _Columns(process.outputs)
        size = self._given.order.size
        self._time, self._inputs, self._outputs = own[:1], own[1 : 1 + size], own[1 + size :]

    def _unit(self, files: Path) -> Unit:
        process = self.process
        size = 8 * (1 + sum(signal.variable.size for signal in (*process.inputs, *process.outputs)))
        if process.in_process:
            return Inside(NATIVE, process.given(files), size)
        what = f"the FMU '{process.archive.path.name}'"
        return Outside(
            NATIVE, process.given(files), size, what=what, folder=self.folder, patience=process.patience, cwd=files
        )

    def step(self, t: float, inputs: np.ndarray) -> np.ndarray:
        """See FmuProcess."""
        self._time[0] = t
        self._given.to_fmu(inputs, self._inputs)
        self.unit.step()
        return self._taken.from_fmu(self._outputs)

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
    """All inputs or all outputs at once: as FmuSignal does it, whose rules for numbers that are no reals it takes."""

    def __init__(self, signals: Sequence[FmuSignal]):
        self.order = np.zeros(0, int)  # where in the SI column an element of the FMU is
        factor, offset = [np.zeros(0)], [np.zeros(0)]
        self.others: list[tuple[FmuSignal, slice]] = []
        for signal in signals:
            first, size = self.order.size, signal.variable.size
            places = first + np.arange(size)
            self.order = np.append(self.order, places.reshape(signal.variable.shape, order="F").ravel())
            factor.append(np.full(size, signal.scale.factor))
            offset.append(np.full(size, signal.scale.offset))
            if signal.variable.kind not in REALS:
                self.others.append((signal, slice(first, first + size)))
        self.factor, self.offset = np.concatenate(factor), np.concatenate(offset)

    def to_fmu(self, column: np.ndarray, into: np.ndarray) -> None:
        """Numbers of the FMU from an SI column."""
        into[:] = (column[self.order] - self.offset) / self.factor
        for signal, places in self.others:
            into[places] = signal.to_fmu(column[places])

    def from_fmu(self, own: np.ndarray) -> np.ndarray:
        """The SI column from numbers of the FMU."""
        column = np.empty(own.size)
        column[self.order] = self.factor * own + self.offset
        return column


def _address(own: Description, variable: FmuVariable) -> tuple[str, int]:
    """The word behind get and set, and the reference."""
    enumeration = "Integer" if own.version == "2.0" else "Int64"
    return enumeration if variable.kind == "Enumeration" else variable.kind, variable.reference


def _signal(own: Description, variable: FmuVariable) -> list[Any]:
    return [*_address(own, variable), variable.size, bool(variable.shape)]
