"""A controller in a shared library with the Bladed interface, such as ROSCO."""

from __future__ import annotations

import math
from pathlib import Path

from fowtlib.components.servo.bladed_library import LENGTH, PITCH, TORQUE, BladedProcess
from fowtlib.components.servo.turbine_controller import TurbineController
from fowtlib.language import Array, Number, RealInput, RealOutput, Scalar, call, eq, param, port, sampled, var
from fowtlib.language.errors import ParameterError

# Record of the swap array of each input.
MEASURED = {
    "generator_speed": 20, "rotor_speed": 21, "yaw_error": 24, "wind_speed": 27, "yaw": 37,
    "fore_aft_acceleration": 53, "side_side_acceleration": 54, "azimuth": 60, "nacelle_pitch_acceleration": 83,
}  # fmt: skip
_OWN = {1, 2, 3, 10, 14, 15, 28, 35, 49, 50, 51, 61, 129}  # records that are not for the user


class BladedController(TurbineController):
    """Blade pitch and generator torque by a controller library with the Bladed interface (DISCON), such as ROSCO.

    The library is called once every `period`, in a process of its own, with what is measured at that instant; its
    demands hold from then on. Several controllers, and several runs, do not share anything, and a library that crashes,
    or hangs longer than `patience`, stops the simulation with an error. As measured pitch and torque it gets its last
    demands; connect others through `measurements`. The library is native code that runs with the rights of the user:
    load only one you trust.
    It fits in the place of a BaselineController; then connect rotor_speed and wind_speed too.
    Source of the records: OpenFAST 3.5, ServoDyn, table of the Bladed interface; ROSCO 2.10, ReadSetParameters.
    """

    in_own_units = {"": "a controller library has gains and units of its own"}

    file: str = param(native=True, doc="path of the shared library (.so, .dll, .dylib)")
    input_file: str = param(default="", doc="path of its input file, such as DISCON.IN; the library runs in its folder")
    procedure: str = param(default="DISCON", doc="name of the procedure in the library")
    output_root: str = param(default="", doc="start of the paths of the files it writes; by default they are deleted")
    period: Number = param(default=0.0125, unit="s", min=1e-6, doc="time between two calls")
    blades: int = param(default=3, min=1, doc="number of blades, 1 to 3")
    individual: bool = param(default=False, doc="pitch of each blade from records 42 to 44, not of all from record 45")
    efficiency: Number = param(default=1.0, min=0, max=1, doc="electrical over mechanical power, for record 15")
    measurements: dict = param(default={}, doc="further inputs: name of the port and number of its record, from 1")
    demands: dict = param(default={}, doc="further outputs: name of the port and number of its record")
    records: dict = param(default={}, doc="records that stay at a value: number and value")
    patience: Number = param(default=60.0, unit="s", min=1e-3, doc="wall time one call may take")
    in_process: bool = param(default=False, doc="run it in the process of the simulation, which a crash then ends")
    pitch_start: Scalar = param(default=0.0, unit="rad", doc="blade pitch before the first call")
    torque_start: Scalar = param(default=0.0, unit="N*m", doc="torque before the first call")

    rotor_speed: RealInput = port(unit="rad/s", doc="rotor speed")
    wind_speed: RealInput = port(unit="m/s", doc="wind speed at the hub, as an anemometer shows it")
    yaw: RealInput = port(default=0.0, unit="rad", doc="yaw angle of the nacelle in the world")
    yaw_error: RealInput = port(default=0.0, unit="rad", doc="direction of the wind seen from the nacelle")
    azimuth: RealInput = port(default=0.0, unit="rad", doc="azimuth of blade 1")
    fore_aft_acceleration: RealInput = port(default=0.0, unit="m/s^2", doc="of the tower top, downwind")
    side_side_acceleration: RealInput = port(default=0.0, unit="m/s^2", doc="of the tower top, to port")
    nacelle_pitch_acceleration: RealInput = port(default=0.0, unit="rad/s^2", doc="angular, about y")
    blade_pitch: RealOutput = port(unit="rad", doc="demanded blade pitch, the mean of all blades")
    individual_pitch: RealOutput = port(size="blades", unit="rad", doc="demanded pitch of each blade less the mean")
    generator_torque: RealOutput = port(unit="N*m", doc="demanded generator torque; none while the contactor is open")

    pitch: Array = var(shape="blades", unit="rad", start=pitch_start, discrete=True, doc="demanded pitch of the blades")
    torque: Scalar = var(unit="N*m", start=torque_start, discrete=True, doc="demanded torque")

    def build(self):
        _check(self)
        for name, number in self.measurements.items():
            self.declare(str(name), RealInput, port(doc=f"record {number} of the controller"))
        for name, number in self.demands.items():
            self.declare(str(name), RealOutput, port(doc=f"record {number} of the controller"))
            self.declare(f"{name}_held", Scalar, var(discrete=True, start=0.0, doc="held until the next sample"))

    def equations(self):
        mean = sum(self.pitch[i] for i in range(self.blades)) / self.blades
        inputs = [self.pitch, self.torque, *(getattr(self, name) for name in (*MEASURED, *self.measurements))]
        held = [getattr(self, f"{name}_held") for name in self.demands]
        return [
            sampled(self.period, call([self.pitch, *held, self.torque], _process(self), inputs)),
            [eq(self.blade_pitch, mean), eq(self.generator_torque, self.torque)],
            [eq(self.individual_pitch[i], self.pitch[i] - mean) for i in range(self.blades)],
            [eq(getattr(self, name), value) for name, value in zip(self.demands, held, strict=True)],
        ]


def _process(controller: BladedController) -> BladedProcess:
    root = controller.output_root
    return BladedProcess(
        library=str(Path(controller.file).absolute()), procedure=controller.procedure,
        input_file=str(Path(controller.input_file).absolute()) if controller.input_file else "",
        output_root=str(Path(root).absolute()) if root else "", period=controller.period, blades=controller.blades,
        individual=controller.individual, efficiency=controller.efficiency,
        measured=[*PITCH[: controller.blades], TORQUE, *MEASURED.values(), *controller.measurements.values()],
        demanded=list(controller.demands.values()),
        fixed={int(number): float(value) for number, value in controller.records.items()},
        patience=controller.patience, in_process=controller.in_process,
    )  # fmt: skip


def _check(controller: BladedController) -> None:
    """Refuse files that are not there and records that cannot be."""
    for name in ("file", "input_file"):
        given = getattr(controller, name)
        if given and not Path(given).is_file():
            raise ParameterError(f"{name}: there is no file '{given}'.")
    root = controller.output_root
    if root and not Path(root).absolute().parent.is_dir():
        raise ParameterError(f"output_root: there is no folder '{Path(root).absolute().parent}'.")
    if controller.blades > len(PITCH):
        raise ParameterError(f"blades: the Bladed interface has {len(PITCH)} at most, not {controller.blades}.")
    for name in ("measurements", "demands", "records"):
        if not isinstance(getattr(controller, name), dict):
            raise ParameterError(f"{name}: got {getattr(controller, name)!r}, and a mapping is expected.")
    taken = {number: name for name, number in MEASURED.items()}
    for name, records in (
        ("measurements", controller.measurements.values()),
        ("demands", controller.demands.values()),
        ("records", controller.records),
    ):
        for given in records:
            number = _record(given, name)
            if name != "demands" and number in taken:
                raise ParameterError(f"{name}: record {number} is the port '{taken[number]}'.")
    for number, value in controller.records.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ParameterError(f"records: record {number} is {value!r}, and a finite number is expected.")


def _record(given: object, where: str) -> int:
    text = str(given)
    number = int(text) if text.isdecimal() and text.isascii() and len(text) < 6 else 0
    if not 1 <= number <= LENGTH:
        raise ParameterError(f"{where}: {given!r} is not the number of a record, 1 to {LENGTH}.")
    if number in _OWN and where != "demands":
        raise ParameterError(f"{where}: record {number} is set by the interface itself.")
    return number
