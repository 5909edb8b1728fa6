"""What stands between a controller and the machine: shutdowns and loss of the grid, over the head of the controller."""

from __future__ import annotations

from fowtlib.components.servo.measurements import AngleMeasurement, SpeedMeasurement
from fowtlib.components.servo.overrides import NEVER, GeneratorSwitch, PitchRamp, ShaftBrake
from fowtlib.components.servo.turbine_controller import TurbineController
from fowtlib.language import Component, OfferedEvent, Scalar, assign, event, on, param, part
from fowtlib.language.declarations import PortReference


class SafetyActuators(Component):
    """Partial: what acts over the head of a controller, and its sensors, which may fail."""

    feather_pitch: Scalar = param(default="90 deg", unit="rad", doc="pitch at which the turbine is shut down")
    greatest_rate: Scalar = param(default="8 deg/s", unit="rad/s", min=0, doc="pitch rate of an emergency shutdown")
    brake_torque: Scalar = param(default=0.0, unit="N*m", min=0, doc="torque of the brake, on the high speed side")
    brake_time: Scalar = param(default=0.6, unit="s", min=1e-3, doc="time in which the brake comes up")
    idling: Scalar = param(
        default=0.0, min=0, max=1, doc="1: shut down at the start, at feather_pitch; 0: in operation"
    )
    braked: Scalar = param(default=0.0, min=0, max=1, doc="1: the brake is on at the start; with idling: parked")

    sensor: SpeedMeasurement = part(SpeedMeasurement)
    yaw_sensor: AngleMeasurement = part(AngleMeasurement)
    pitch: PitchRamp = part(PitchRamp, highest=feather_pitch, feathered=idling)
    generator: GeneratorSwitch = part(GeneratorSwitch, open=idling)
    brake: ShaftBrake = part(ShaftBrake, rise_time=brake_time, rated_torque=brake_torque, on=braked)

    def around(
        self, control: TurbineController, speed: PortReference, yaw: PortReference
    ) -> list[tuple[PortReference, PortReference]]:
        """The connections of a controller, of the speed of the generator, and of the yaw of the platform."""
        sensor, pitch, generator, brake = self.sensor, self.pitch, self.generator, self.brake
        seen = [(self.yaw_sensor.measured, control.yaw)] if "yaw" in control.ports else []
        return [
            *((speed, part.speed) for part in (sensor, generator, brake)), (sensor.measured, control.generator_speed),
            (control.blade_pitch, pitch.demand), (control.generator_torque, generator.demand),
            (yaw, self.yaw_sensor.angle), *seen,
        ]  # fmt: skip

    def stop_at(self, rate, cut_out_speed, delay=0.0):
        """Actions: the blades pitch to feather, and the generator brakes on down to a speed."""
        return [*self.pitch.ramp_at(rate, delay), assign(self.generator.cut_out_speed, cut_out_speed)]

    def start_at(self, rate):
        """Actions: the blades pitch towards operation, the generator is there, the brake is off."""
        return [
            *self.pitch.ramp_at(-rate), *self.brake.off(), assign(self.generator.connected, 1),
            assign(self.generator.cut_out_speed, NEVER),
        ]  # fmt: skip


class SafetySystem(SafetyActuators):
    """Leaves speed, pitch and torque of a controller as they are until an event; then it acts over its head.

    In a shutdown the blades pitch from where they are up to feather_pitch, in a start-up down again, until the
    controller asks for more. The controller goes on by itself and is not told; an external library cannot know of the
    event but by what it measures. The events of a turbine may follow each other; the later one counts.
    Reference: IEC 61400-1, 2019, 7.4 (load cases with faults) and 8 (protection functions).
    """

    normal_shutdown: OfferedEvent = event(
        doc="the blades pitch to feather; the generator brakes on down to a speed",
        rate=param(default="2 deg/s", unit="rad/s", min=0, doc="pitch rate"),
        delay=param(default=0.0, unit="s", min=0, doc="time until the blades begin to pitch"),
        cut_out_speed=param(default=0.0, unit="rad/s", min=0, doc="generator speed below which there is no torque"),
    )  # fmt: skip
    emergency_shutdown: OfferedEvent = event(
        doc="the blades pitch to feather at the greatest rate, the generator is off, and the brake comes on",
        rate=param(default=SafetyActuators.greatest_rate, unit="rad/s", min=0, doc="pitch rate"),
        delay=param(default=0.0, unit="s", min=0, doc="time until the blades begin to pitch"),
        brake_torque=param(
            default=SafetyActuators.brake_torque, unit="N*m", min=0, doc="torque of the brake, on the high speed side"
        ),
        brake_delay=param(default=0.0, unit="s", min=0, doc="time until the brake comes on"),
        generator=param(default=0.0, min=0, max=1, doc="1: the generator brakes on; 0: it is off at once"),
    )  # fmt: skip
    grid_loss: OfferedEvent = event(
        doc="the generator torque is gone at once; after a delay the blades pitch to feather",
        delay=param(default=0.2, unit="s", min=0, doc="time until the blades begin to pitch"),
        rate=param(default=SafetyActuators.greatest_rate, unit="rad/s", min=0, doc="pitch rate; 0: no stop follows"),
    )  # fmt: skip
    start_up: OfferedEvent = event(
        doc="the blades pitch towards operation, grid and generator are there, the brake is off",
        rate=param(default="2 deg/s", unit="rad/s", min=0, doc="pitch rate, until the controller takes over"),
    )  # fmt: skip

    def equations(self):
        normal, emergency, grid, start = self.normal_shutdown, self.emergency_shutdown, self.grid_loss, self.start_up
        generator, brake, ramp = self.generator, self.brake, self.pitch.ramp_at
        return [
            on(normal, *self.stop_at(normal.rate, normal.cut_out_speed, normal.delay)),
            on(
                emergency, *ramp(emergency.rate, emergency.delay),
                *brake.on_at(emergency.brake_torque, emergency.brake_delay),
                assign(generator.connected, generator.connected * emergency.generator),
            ),
            on(grid, *ramp(grid.rate, grid.delay), assign(generator.connected, 0)),
            on(start, *self.start_at(start.rate)),
        ]  # fmt: skip
