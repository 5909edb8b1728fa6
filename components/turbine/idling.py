"""The speed at which a rotor idles: where the mean torque of the air and that of its brake are in balance. NumPy."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from fowtlib.components.aero import BladeElementRotor
from fowtlib.components.aero.bem_steady import RigidRotor
from fowtlib.components.servo.overrides import SLOW

AZIMUTHS = 5  # in the angle between two blades, after which a rotor stands as before
FASTEST = 12.0  # tip speed ratio up to which a balance is sought
FIRST, STEPS = 1e-3, 16  # least tip speed ratio that is looked at beside standstill, and how many up to the fastest
ROUNDS = 8  # looks at STEPS speeds, each between the two neighbours of the balance that the last one found


def idling_speed_of(turbine: Any, wind: tuple[float, float, float], pitch: float) -> float:
    """That of a Turbine [rad/s], whose blades do not bend and whose nacelle does not pitch, with its brake.

    wind: uniform [m/s], in the axes of the frame behind the yaw drive; pitch [rad].
    """
    body, safety = turbine.assembly, turbine.safety
    gear = body.drivetrain.parameter_value("gear_ratio")
    torque = gear * safety.parameter_value("brake_torque") * safety.parameter_value("braked")
    return idling_speed(
        turbine.aerodynamics.steady_rotor, wind, pitch, body.hub.parameter_value("precone"),
        body.nacelle.parameter_value("tilt"), turbine.world.parameter_value("air_density"), (torque, SLOW / gear),
    )  # fmt: skip


@lru_cache(maxsize=16)
def idling_speed(
    rotor: BladeElementRotor, wind: tuple[float, float, float], pitch: float, precone: float = 0.0, tilt: float = 0.0,
    air_density: float = 1.225, brake: tuple[float, float] = (0.0, 1.0), azimuth: float | None = None,
) -> float:  # fmt: skip
    """Speed [rad/s] of a rotor of rigid blades without generator torque, started at standstill; below 0: backwards.

    wind: uniform [m/s], in the frame whose x is the horizontal projection of the shaft, downwind; pitch of all blades,
    precone and tilt [rad]. brake: its torque on the shaft [N m] and the speed [rad/s] of the shaft around standstill
    within which it is viscous, see ShaftBrake. The torque of the air is the mean over a turn at constant speed, or that
    at an azimuth [rad]: a slow rotor in wind from the side follows the latter, within its time constant of inertia over
    slope of the torque, and may come to rest where it is 0. 0 where there is no balance below tip speed ratio 12.
    """
    rigid, strong = RigidRotor(rotor, precone, tilt), float(np.linalg.norm(wind))
    if strong == 0:
        return 0.0
    azimuths = 2 * np.pi / rotor.blades * np.arange(AZIMUTHS) / AZIMUTHS if azimuth is None else [azimuth]

    def surplus(speeds: np.ndarray) -> np.ndarray:
        air = [rigid.over_speeds(wind, speeds, pitch, azimuth=a, air_density=air_density)[:, 1] for a in azimuths]
        return np.mean(air, axis=0) - brake[0] * speeds / np.hypot(speeds, brake[1])

    there = np.concatenate([[0.0], np.geomspace(FIRST, FASTEST, STEPS)]) * strong / rotor.blade.tip_radius
    sign = np.sign(surplus(np.zeros(1))[0])
    if not sign:
        return 0.0
    for _ in range(ROUNDS):
        turned = np.flatnonzero(sign * surplus(sign * there) <= 0)
        if not turned.size:
            return 0.0
        there = np.linspace(there[turned[0] - 1], there[turned[0]], STEPS)
    return float(sign * there.mean())
