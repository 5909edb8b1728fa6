"""The supervision of a turbine: it starts and stops by wind and speed, and by what happens to it."""

from __future__ import annotations

from functools import reduce
from itertools import pairwise

from fowtlib.components.environment.wind import Wind
from fowtlib.components.environment.wind.base import station_height
from fowtlib.components.servo.safety_system import SafetySystem
from fowtlib.language import RealOutput, Scalar, assert_, assign, der, eq, initial, on, outer, param, port, var, when
from fowtlib.language import math as m

IDLING, START_UP, PRODUCTION, STORM, NORMAL_STOP, OVERSPEED, EMERGENCY_STOP, RESTART = range(8)
STATES = ("idling", "start-up", "production", "storm", "normal stop", "overspeed", "emergency stop", "restart")
"""Names of the values of Supervisor.state, in their order."""
NEARLY = 0.01
"""Pitch [rad] by which the blades may be short of feather when a stop has ended."""


class Supervisor(SafetySystem):
    """A safety system that decides by itself what the turbine does.

    state: 0 idling, 1 start-up, 2 production, 3 storm, 4 normal stop, 5 overspeed, 6 emergency stop, 7 restart.
    It waits at feather for a mean wind between start_wind and restart_wind, pitches down at start_rate, and produces
    from production_speed on. It stops at stop_rate, the generator braking, in calm (until start_wind) and storm (until
    restart_wind); a stop in overspeed is faster and waits restart_delay, and after most_overspeeds of them no turbine
    starts again by itself. Above emergency_speed, seen by a sensor of its own, the generator is off and the brake on
    until somebody starts it (the event start_up). After an event that stops it, it waits for that too. The wind is that
    of the station, undisturbed, through a low-pass of first order. Transitions are state events, at their instants.
    Reference: IEC 61400-1, 2019, chapter 8; speeds and winds of the NREL 5 MW: NREL/TP-500-38060, tables 1-1 and 7-2.
    """

    memory = "supervisor"

    station: int = param(default=0, min=0, doc="number of the wind's station at this turbine")
    averaging_time: Scalar = param(default=60.0, unit="s", min=1e-3, doc="time constant of the mean wind")
    start_wind: Scalar = param(default=3.5, unit="m/s", min=1e-3, doc="mean wind above which it starts")
    stop_wind: Scalar = param(default=3.0, unit="m/s", min=1e-3, doc="mean wind below which it stops")
    storm_wind: Scalar = param(default=25.0, unit="m/s", min=1e-3, doc="mean wind above which it stops")
    restart_wind: Scalar = param(default=22.0, unit="m/s", min=1e-3, doc="mean wind below which it starts again")
    production_speed: Scalar = param(default="700 rpm", unit="rad/s", min=1e-3, doc="speed that ends a start-up")
    idle_speed: Scalar = param(default="200 rpm", unit="rad/s", min=1e-3, doc="speed at which a stop has ended")
    overspeed: Scalar = param(default="1408.4 rpm", unit="rad/s", min=1e-3, doc="measured speed of a stop: 1.2 rated")
    emergency_speed: Scalar = param(default="1525.8 rpm", unit="rad/s", min=1e-3, doc="speed of an emergency stop")
    start_rate: Scalar = param(default="2 deg/s", unit="rad/s", min=0, doc="pitch rate of a start-up")
    stop_rate: Scalar = param(default="2 deg/s", unit="rad/s", min=0, doc="pitch rate of a normal stop")
    overspeed_rate: Scalar = param(default="4 deg/s", unit="rad/s", min=0, doc="pitch rate of a stop in overspeed")
    settling_time: Scalar = param(default=1.0, unit="s", min=1e-3, doc="least time in a state, but for overspeed")
    start_delay: Scalar = param(default=10.0, unit="s", min=1e-3, doc="least time of idling before a start")
    start_time: Scalar = param(default=300.0, unit="s", min=1e-3, doc="longest time of a start-up")
    restart_delay: Scalar = param(default=60.0, unit="s", min=1e-3, doc="least time before it starts again")
    most_overspeeds: Scalar = param(default=3.0, min=0, doc="stops in overspeed after which it stays in emergency stop")

    wind: Wind = outer(Wind)
    yaw_allowed: RealOutput = port(doc="1 while the nacelle may yaw, 0 in an emergency stop")

    mean_wind: Scalar = var(unit="m/s", state="prefer", doc="low-pass filtered wind")
    state: Scalar = var(
        discrete=True, start=lambda self: PRODUCTION * (1 - self.idling), doc="what it is doing, see Supervisor"
    )
    entered: Scalar = var(unit="s", discrete=True, start=0.0, doc="time at which that began")
    waits: Scalar = var(discrete=True, start=0.0, doc="1 while it does not start by itself")
    overspeeds: Scalar = var(discrete=True, start=0.0, doc="stops in overspeed since somebody has started it")

    def equations(self):
        station_height(self.wind, self.station)  # refuses a station that does not exist
        blows, mean = self.wind.speed[self.station], self.mean_wind
        return [
            super().equations(),
            [eq(self.averaging_time * der(mean), blows - mean), initial(mean, self.wind.base[self.station])],
            eq(self.yaw_allowed, m.if_else(_within(self, EMERGENCY_STOP) > 0, 0, 1)),
            _by_events(self),
            _starts(self),
            _stops(self),
            _protection(self),
            _rising("m/s", stop_wind=self.stop_wind, start_wind=self.start_wind, restart_wind=self.restart_wind,
                    storm_wind=self.storm_wind),
            _rising("rad/s", idle_speed=self.idle_speed, production_speed=self.production_speed,
                    overspeed=self.overspeed, emergency_speed=self.emergency_speed),
        ]  # fmt: skip


def _within(unit: Supervisor, *states):
    """1/2 in one of the states, else -1/2."""
    return sum(m.if_else(m.abs(unit.state - state) < 0.5, 1, 0) for state in states) - 0.5


def _enter(unit: Supervisor, state):
    return [assign(unit.state, state), assign(unit.entered, unit.time)]


def _go(unit: Supervisor, states, to, *conditions, then=()):
    """From one of the states to another as soon as all conditions are above zero."""
    margin = _within(unit, *states)
    for condition in conditions:
        margin = m.fmin(margin, condition)
    return when(margin > 0, *_enter(unit, to), *then)


def _above(value, limit):
    return value / limit - 1


def _below(value, limit):
    return 1 - value / limit


def _after(unit: Supervisor, delay):
    """It has been in its state for a time."""
    return _above(unit.time - unit.entered, delay)


def _rising(unit, **limits):
    """Limits out of order would leave a state as soon as it is entered, or never enter it."""
    values = list(limits.values())
    steps = [above - below for below, above in pairwise(values)]
    told = ", ".join(f"{{{name}}}" for name in limits)
    text = f"{', '.join(limits)} must go up in this order; they are {told} {unit}"
    return assert_(reduce(m.fmin, steps) >= 0, text, **limits)


def _emergency(unit: Supervisor):
    """Actions of an emergency stop."""
    brake = unit.brake
    return [*unit.pitch.ramp_at(unit.greatest_rate), assign(unit.generator.connected, 0), assign(unit.waits, 1),
            *brake.on_at(unit.brake_torque)]  # fmt: skip


def _by_events(unit: Supervisor):
    """What the events of a safety system are to the state."""
    stop, waits = _enter(unit, NORMAL_STOP), assign(unit.waits, 1)
    return [
        on(unit.normal_shutdown, *stop, waits),
        on(unit.grid_loss, *stop, waits),
        on(unit.emergency_shutdown, *_enter(unit, EMERGENCY_STOP), waits),
        on(unit.start_up, *_enter(unit, START_UP), assign(unit.waits, 0), assign(unit.overspeeds, 0)),
    ]


def _starts(unit: Supervisor):
    mean, then, again = unit.mean_wind, unit.start_at(unit.start_rate), _after(unit, unit.restart_delay)
    free = 0.5 - unit.waits, _above(mean, unit.start_wind), _below(mean, unit.restart_wind)
    slow = _below(unit.sensor.measured, unit.idle_speed)
    fast = _above(unit.sensor.measured, unit.production_speed)
    return [
        _go(unit, [IDLING], START_UP, *free, _after(unit, unit.start_delay), then=then),
        _go(unit, [STORM], START_UP, *free, slow, again, then=then),
        _go(unit, [RESTART], START_UP, *free, again, then=then),
        _go(unit, [START_UP], PRODUCTION, fast, _after(unit, unit.settling_time)),
    ]


def _stops(unit: Supervisor):
    mean, settled = unit.mean_wind, _after(unit, unit.settling_time)
    stop = unit.stop_at(unit.stop_rate, unit.production_speed)
    ended = _below(unit.sensor.measured, unit.idle_speed), unit.pitch.output - unit.feather_pitch + NEARLY, settled
    return [
        _go(unit, [PRODUCTION], NORMAL_STOP, _below(mean, unit.stop_wind), settled, then=stop),
        _go(unit, [START_UP], NORMAL_STOP, _after(unit, unit.start_time), then=stop),
        _go(unit, [START_UP, PRODUCTION], STORM, _above(mean, unit.storm_wind), settled, then=stop),
        _go(unit, [NORMAL_STOP], IDLING, *ended),
        _go(unit, [OVERSPEED], RESTART, *ended),
    ]


def _protection(unit: Supervisor):
    """Against overspeed, at once in any state; the later of two at one instant counts."""
    running, count = [START_UP, PRODUCTION, STORM, NORMAL_STOP], unit.overspeeds + 1
    fast, tired = _above(unit.sensor.measured, unit.overspeed), count - unit.most_overspeeds - 0.5
    counted, stop = assign(unit.overspeeds, count), unit.stop_at(unit.overspeed_rate, unit.production_speed)
    over = _above(unit.generator.speed, unit.emergency_speed)
    return [
        _go(unit, running, OVERSPEED, fast, -tired, then=[*stop, counted]),
        _go(unit, running, EMERGENCY_STOP, fast, tired, then=[*_emergency(unit), counted]),
        _go(unit, [*running, IDLING, OVERSPEED, RESTART], EMERGENCY_STOP, over, then=_emergency(unit)),
    ]
