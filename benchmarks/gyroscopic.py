"""Spars with turning rotors that pitch, and the yaw that follows: models, and one oscillator in plain numpy.

Still water, vacuum, no torque of the generators: nothing but the spin of the rotors makes the spar yaw. For
docs/load_cases.md and its tests.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import verification_cases as cases
from scipy.signal import StateSpace, lsim

import fowtlib as fw
from fowtlib.components.mechanics import RigidBody
from fowtlib.solving.plant import Plant
from fowtlib.solving.state import State

SPEED = 12.1 * np.pi / 30  # rad/s
TURBINES = {"oc3_spar": ("turbine",), "two_rotor_spar": ("turbine_left", "turbine_right")}
BEARING, GENERATOR = "assembly.nacelle.bearing", "assembly.drivetrain.generator.speed"


@dataclass(frozen=True)
class YawOscillator:
    """Yaw of an upright spar about its axis: inertia psi'' + damping psi' + stiffness psi = moment. SI."""

    inertia: float
    damping: float
    stiffness: float

    def response(self, time: np.ndarray, moment: np.ndarray) -> np.ndarray:
        """Yaw [rad] from rest under a moment [N m] at equally spaced times."""
        k, b = self.stiffness / self.inertia, self.damping / self.inertia
        system = StateSpace([[0, 1], [-k, -b]], [[0], [1 / self.inertia]], [[1, 0]], [[0]])
        return np.asarray(lsim(system, moment, time)[1])


@dataclass(frozen=True)
class PitchDecay:
    """A decay of the platform's pitch with turning rotors. Angles in deg, moments in N m.

    rate: pitch rate of the nacelles [rad/s], mean of both; spin: the sum of s I Omega over the rotors [N m s];
    moment = spin cos(tilt) rate; expected: yaw of the oscillator under this moment.
    """

    time: np.ndarray
    pitch: np.ndarray
    yaw: np.ndarray
    rate: np.ndarray
    spin: float
    moment: np.ndarray
    expected: np.ndarray


def plant_of(name: str, senses: tuple[int, ...], blade_hinges: int = 0) -> Plant:
    """A shipped model in calm water and vacuum, its rotors turning freely, each in its sense (1: clockwise)."""
    settings: dict[str, object] = {**cases.CALM, "world.air_density": 0.0}
    if len(senses) > 1:
        settings["yaw_gain"] = 0.0
    for turbine, sense in zip(TURBINES[name], senses, strict=True):
        settings[f"{turbine}.assembly.rotation"] = sense
        settings[f"{turbine}.assembly.blade_hinges"] = blade_hinges
        settings[f"{turbine}.control.torque.greatest_torque"] = 0.0
    return fw.load(name, set=settings).compile()


def pitch_decay(
    name: str, senses: tuple[int, ...], offset: float = 5.0, duration: float = 120.0, blade_hinges: int = 0
) -> PitchDecay:
    """The spar let go from a pitch angle [deg] off its rest, the rotors at 12.1 rpm."""
    plant, turbines = plant_of(name, senses, blade_hinges), TURBINES[name]
    still = {f"{turbine}.{BEARING}.{state}": 0.0 for turbine in turbines for state in ("phi", "w")}
    rest = plant.equilibrium(hold=still)
    moved = {"platform.motion.pitch": float(rest["platform.motion.pitch"]) + np.radians(offset)}
    for turbine in turbines:
        moved |= {f"{turbine}.{BEARING}.w": SPEED, f"{turbine}.{GENERATOR}": 97 * SPEED}
    rates = [f"{turbine}.assembly.nacelle.body.frame_a.w" for turbine in turbines]
    result = plant.simulate(duration, 0.05, start=plant.initial_state(start=moved, base=rest), solver="fixed",
                            outputs=["pitch", "yaw", *rates])  # fmt: skip
    rate = np.mean([result.array(path)[:, 1] for path in rates], axis=0)
    spin = sum(senses) * cases.rotor_masses(0)[3] * SPEED
    moment = spin * np.cos(cases.TILT) * rate
    expected = np.degrees(yaw_oscillator(plant, rest).response(result.time, moment))
    return PitchDecay(result.time, result.array("pitch"), result.array("yaw"), rate, spin, moment, expected)


def yaw_oscillator(plant: Plant, rest: State) -> YawOscillator:
    """Inertia of all bodies about the axis, in numpy; frequency and damping of the yaw mode with the rotors at rest.

    The tower and the arms of two rotors give way in yaw, which a sum of springs would leave out.
    """
    inertia = 0.0
    for body in plant.root.walk():
        if isinstance(body, RigidBody):
            R = np.reshape(rest[f"{body.path}.frame_a.R"], (3, 3))
            place = np.ravel(rest[f"{body.path}.frame_a.r"]) - np.ravel(rest["platform.motion.frame_b.r"])
            place = place + R @ np.ravel(body.parameter_value("r_cm"))
            own = R @ np.reshape(body.parameter_value("inertia"), (3, 3)) @ R.T
            inertia += body.parameter_value("mass") * float(place[0] ** 2 + place[1] ** 2) + float(own[2, 2])
    modes = [mode for mode in plant.linearize(rest, outputs=[]).modes() if np.isfinite(mode.period)]
    yaw = max(modes, key=lambda mode: mode.participation["platform.motion.yaw"])
    w = 2 * np.pi * yaw.frequency_hz
    return YawOscillator(inertia, 2 * yaw.damping_ratio * w * inertia, w**2 * inertia)
