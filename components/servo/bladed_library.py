"""A Bladed-style controller library at work: the swap array, and who calls the library with it."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtlib.components.isolation import Inside, Outside, Unit, private_folder, remove
from fowtlib.components.servo.bladed_native import MESSAGE_LENGTH
from fowtlib.language.errors import SimulationError

LENGTH = 3300  # records, as many as the extended interface of OpenFAST 3.5 has
NATIVE = Path(__file__).with_name("bladed_native.py")
NO_REASON = "the controller library reports an error:"
STATUS, TIME, PERIOD, TORQUE_DEMAND = 1, 2, 3, 47  # numbers of records, from 1
PITCH_DEMAND, COLLECTIVE_DEMAND, PITCH, TORQUE, AZIMUTH = (42, 43, 44), 45, (4, 33, 34), 23, 60
MESSAGE_SIZE, INPUT_SIZE, OUTPUT_SIZE = 49, 50, 51
FIRST, LATER = 0, 1
# What a controller may ask for that the model does not do: record, value that asks for nothing, what it is.
UNKNOWN_DEMANDS = ((36, 0, "the shaft brake"), (55, 0, "the pitch of its host"), (56, 0, "the torque of its host"))
CONTACTOR = 35  # 1: the generator is on


@dataclass(frozen=True)
class BladedProcess:
    """A controller library that can be run again and again, each time in a process of its own, or in this one.

    measured: the record of each input. demanded: the record of each further output. fixed: records and their values.
    patience: wall time one call may take, in a process of its own [s].
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
    patience: float = 60.0
    in_process: bool = False

    def start(self) -> BladedSession:
        """A fresh copy of the controller."""
        return BladedSession(self)


class BladedSession:
    """One run of a controller library. Raises SimulationError with what the library says when it fails."""

    def __init__(self, process: BladedProcess):
        self.process = process
        self.samples = 0
        self.warned: set[str] = set()
        self.unit: Unit | None = None
        self.folder = private_folder()
        self.output_root = process.output_root or str(self.folder / "controller")
        try:
            self.unit = self._unit()
        except BaseException:
            self.close()
            raise
        self.swap = np.frombuffer(self.unit.memory, np.float32)
        constants = {
            PERIOD: process.period, 61: process.blades, 28: float(process.individual), MESSAGE_SIZE: MESSAGE_LENGTH,
            INPUT_SIZE: len(process.input_file.encode()) + 1, OUTPUT_SIZE: len(self.output_root.encode()) + 1,
            129: LENGTH, **process.fixed,
        }  # fmt: skip
        self.constants = np.array(list(constants.values()), np.float32)
        self.constant_records, self.measured_records = _places(constants), _places(process.measured)
        self.azimuth = process.measured.index(AZIMUTH) if AZIMUTH in process.measured else None
        pitch = PITCH_DEMAND[: process.blades] if process.individual else (COLLECTIVE_DEMAND,) * process.blades
        self.demanded_records = _places((*pitch, *process.demanded, TORQUE_DEMAND))

    def _unit(self) -> Unit:
        process = self.process
        cwd = Path(process.input_file).parent if process.input_file else self.folder
        given = {
            "library": process.library, "procedure": process.procedure, "input_file": process.input_file,
            "output_root": self.output_root, "folder": str(cwd),
        }  # fmt: skip
        if process.in_process:
            return Inside(NATIVE, given, 4 * LENGTH)
        what = "the controller library"
        return Outside(NATIVE, given, 4 * LENGTH, what=what, folder=self.folder, patience=process.patience, cwd=cwd)

    # --- stepping ------------------------------------------------------------------------------------------------

    def step(self, t: float, inputs: np.ndarray) -> np.ndarray:
        """The demanded pitch of each blade, the further records that are asked for, and the demanded torque."""
        given, swap = self.process, self.swap
        swap[self.constant_records] = self.constants  # each time: the library may write anywhere
        swap[self.measured_records] = inputs
        if self.azimuth is not None:
            self._set(AZIMUTH, inputs[self.azimuth] % (2 * math.pi))
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
        swap = self.swap
        for number, nothing, what in UNKNOWN_DEMANDS:
            if swap[number - 1] != nothing:
                raise SimulationError(f"the controller asks for {what} (record {number}), which the model has not")
        demands = swap[self.demanded_records].astype(float)
        if round(float(swap[CONTACTOR - 1])) != 1:
            demands[-1] = 0.0
        return demands

    def _call(self, status: int, t: float) -> None:
        self._set(STATUS, status)
        self._set(TIME, t)
        try:
            message = self.unit.step()
        except SimulationError as error:
            if str(error) != NO_REASON or not isinstance(self.unit, Outside):
                raise
            raise SimulationError(f"{NO_REASON} {self.unit.last_words() or 'no message'}") from None
        if message and message not in self.warned:
            self.warned.add(message)
            warnings.warn(f"the controller library says: {message}", stacklevel=3)

    def close(self) -> None:
        """Make the last call, end the process and delete its files."""
        unit, self.unit = self.unit, None
        try:
            if unit is not None:
                unit.close()
        finally:
            remove(self.folder)


def _places(records: Iterable[int]) -> np.ndarray:
    """Where records are in the swap array."""
    return np.array(list(records), int) - 1
