"""The gyroscopic moment of turning rotors on a body that pitches, against I Omega times the pitch rate."""

from __future__ import annotations

import numpy as np
import pytest
from verification_cases import rotor_masses

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import FixedTranslation, FreeMotion, RigidBody
from fowtlib.components.turbine import Drivetrain, Hub, Nacelle, RotorNacelleAssembly
from fowtlib.modelfile import data_path

TILT, SPEED, RATE = np.radians(5.0), 1.267, 0.02  # rad, rad/s of the rotors, rad/s of pitch


def pitching(senses, half_span=69.3):
    """Rigid turbines in vacuum, side by side on a heavy body that pitches at a constant rate."""
    model = fw.Assembly("pitching turbines")
    model.world = World(gravity=0.0)
    model.motion = FreeMotion(angle_rates_start=(0, RATE, 0))
    model.body = RigidBody(mass=1e15, inertia=1e18 * np.eye(3))  # so heavy that the moment does not turn it
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    for k, sense in enumerate(senses):
        arm = model.add(f"arm_{k}", FixedTranslation(r=(0, half_span * (1 - 2 * k), 90.0)))
        turbine = model.add(f"turbine_{k}", RotorNacelleAssembly(
            nacelle=Nacelle(mass=240e3, centre_of_mass=(1.9, 0, 1.75), inertia=np.diag([0, 0, 1741490.0]),
                            shaft_height=1.96256, tilt=TILT, overhang=5.0191, azimuth_start=0.4),
            hub=Hub(precone="2.5 deg", radius=1.5, mass=56780.0, inertia=115926.0),
            drivetrain=Drivetrain(gear_ratio=97.0, stiffness=867637000.0, generator_inertia=534.116),
            blade_properties=str(data_path("nrel5mw/blade_structure.csv")), blade_hinges=0, rotation=sense,
            rotor_speed_start=SPEED,
        ))  # fmt: skip
        model.connect(model.motion.frame_b, arm.frame_a)
        model.connect(arm.frame_b, turbine.frame)
    return fw.load(model).compile().initial_state()


@pytest.mark.parametrize("senses", [(1,), (-1,), (1, 1), (1, -1)])
def test_gyroscopic_moment_of_turning_rotors(senses):
    """One rotor, two that turn the same way (twice the moment), two that turn against each other (none).

    The spin of a rotor is h = s I Omega n, with the sense s and the shaft n = (cos tilt, 0, -sin tilt). Turned with the
    pitch rate q about y it changes by dh/dt = q y x h = -s I Omega q (cos tilt z + sin tilt x), so the rotor puts the
    moment +s I Omega q (cos tilt z + sin tilt x) on its tower: clockwise (s = 1) it yaws to port while its spar pitches
    downwind. Everything else about this motion (weights left out, centripetal forces) lies in the plane of x and z of
    each turbine and has moments about y only, but for its forces at the tip of an arm, which two turbines cancel.
    The inertia I is that of the table of the blades and of the hub, summed in numpy.
    """
    state = pitching(senses)
    turbines = range(len(senses))
    moments = np.array([-np.ravel(state[f"turbine_{k}.frame.t"]) for k in turbines])  # of the turbine on its tower
    spin = rotor_masses(0)[3] * SPEED * RATE
    expected = np.outer(senses, spin * np.array([np.sin(TILT), np.cos(TILT)]))
    assert moments[:, [0, 2]] == pytest.approx(expected, abs=1e-5 * spin)
    assert moments[:, 2].sum() == pytest.approx(sum(senses) * spin * np.cos(TILT), abs=1e-5 * spin)
