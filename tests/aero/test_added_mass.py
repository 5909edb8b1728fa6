"""Added mass of the blade sections: masses against closed forms, impedance against Theodorsen, rotors in operation."""

import numpy as np
import pytest
from scipy.special import hankel2

import fowtlib as fw
from fowtlib.components.aero import Airfoil, BladeAerodynamics, BladeElementAerodynamics
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import Wind, World
from fowtlib.components.mechanics import Fixed, Prismatic, Revolute, RigidBody
from fowtlib.components.mechanics.rotational import TorqueSource
from fowtlib.language.native import compiler

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
CHORD, LENGTH, DENSITY, MASS, INERTIA = 2.0, 3.0, 1.225, 40.0, 7.0
HALF = CHORD / 2


def flat_plate():
    angle = np.radians(np.concatenate([[-180, -90], np.arange(-20, 21, 1.0), [90, 180]]))
    lift = np.where(np.abs(angle) < 0.4, 2 * np.pi * angle, 0.0)
    return Airfoil("plate", angle, np.column_stack([lift, np.zeros((len(angle), 2))]))


def section(word, speed, rotation=1, twist=0.0, added_mass=True, chord=CHORD):
    """A section that plunges along x, the normal of the rotor, and pitches about its quarter chord; wind along y."""
    blade = BladeAerodynamics(
        8.5, 11.5, np.array([10.0]), np.array([chord]), np.array([twist]), ["plate"], {"plate": flat_plate()},
        np.array([LENGTH]),
    )  # fmt: skip
    model = fw.Assembly("section")
    model.world = World(air_density=DENSITY)
    model.wind = Wind(kind="steady", mean_speed=speed, direction=f"{90 * rotation} deg", stations=[(0, 10)])
    model.hub, model.base = Fixed(), Fixed(r=(0, 0, 10))
    model.plunge, model.pitch, model.drive = Prismatic(), Revolute(n=(0, 0, rotation)), TorqueSource()
    model.body = RigidBody(mass=MASS, r_cm=(0, 0, 0), inertia=((INERTIA, 0, 0), (0, INERTIA, 0), (0, 0, INERTIA)))
    model.air = BladeElementAerodynamics(
        blade=blade, hub_radius=8.5, tip_radius=11.5, blades=1, rotation=rotation, airfoil_model=word,
        added_mass=added_mass,
    )  # fmt: skip
    model.push, model.twist = Constant(value=0.0), Constant(value=0.0)
    for pair in (
        (model.hub.frame, model.air.hub), (model.base.frame, model.plunge.frame_a), (model.push.y, model.plunge.force),
        (model.plunge.frame_b, model.pitch.frame_a), (model.pitch.frame_b, model.body.frame_a),
        (model.body.frame_a, model.air.nodes[0]), (model.pitch.flange, model.drive.flange),
        (model.twist.y, model.drive.torque),
    ):  # fmt: skip
        model.connect(*pair)
    return fw.load(model).compile()


def response(plant, frequencies):
    """(frequencies, 2, 2): plunge along x and nose-up angle by force along x and nose-up moment."""
    linear = plant.linearize(
        plant.initial_state(), inputs=["push.value", "twist.value"], outputs=["plunge.s", "pitch.phi"]
    )
    return linear.frequency_response(frequencies)


def inertia_of_air(chord=CHORD):
    """Of plunging and pitching about the quarter of the chord, per air density and length."""
    b = chord / 2
    return np.pi * b**2 * np.array([[1, -b / 2], [-b / 2, b**2 * (1 / 8 + 1 / 4)]])


def theodorsen(frequencies, speed, circulation):
    """What the air adds to the impedance: minus lift and moment about the quarter chord by x and angle.

    Theodorsen (1935) with a = -1/2 and h = -x, which is along the lift.
    """
    s, b, V = 1j * frequencies[:, None, None], HALF, speed
    lift_of = np.array([[-s[:, 0, 0], V + b * s[:, 0, 0]]]).transpose(2, 0, 1)  # downwash at 3/4 of the chord
    apparent = s**2 * inertia_of_air() + s * np.pi * b**2 * V * np.array([[0, -1], [0, b]])
    bound = -2 * np.pi * V * b * circulation[:, None, None] * lift_of
    return DENSITY * LENGTH * (apparent + np.concatenate([bound, 0 * bound], axis=1))


@pytest.mark.parametrize("rotation", [1, -1])
@pytest.mark.parametrize("chord", [2.0, 0.5])
def test_masses_in_still_air(rotation, chord):
    """pi/4 c^2 against plunging, c/4 off the axis, and Theodorsen's b^4 (1/8 + 1/4) against pitching."""
    plant = section("steady", 1e-3, rotation, chord=chord)
    linear = plant.linearize(plant.initial_state(), ["push.value", "twist.value"], ["plunge.a", "pitch.a"])
    mass = np.linalg.inv(np.asarray(linear.D)) - np.diag([MASS, INERTIA])
    assert mass == pytest.approx(DENSITY * LENGTH * inertia_of_air(chord), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("rotation", [1, -1])
def test_impedance_is_that_of_theodorsen(rotation):
    """Lift and moment by plunging and pitching: with Jones's lags to the last digits, with the exact ones 2.4 %."""
    speed, k = 40.0, np.array([0.05, 0.2, 0.5, 1.0])
    omega = k * speed / HALF
    total = np.linalg.inv(response(section("attached", speed, rotation), omega))
    found = total + omega[:, None, None] ** 2 * np.diag([MASS, INERTIA])
    jones = 1 - 0.165 / (1 - 0.0455j / k) - 0.335 / (1 - 0.3j / k)
    assert found == pytest.approx(theodorsen(omega, speed, jones), rel=1e-5, abs=1e-5 * np.abs(found).max())
    exact = hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k))
    lift = theodorsen(omega, speed, exact)[:, 0]
    assert np.all(np.abs(found[:, 0] - lift) < 0.024 * np.abs(lift))
    without = np.linalg.inv(response(section("attached", speed, rotation, added_mass=False), omega))
    missing = (total - without) / omega[:, None, None] ** 2
    assert missing == pytest.approx(-DENSITY * LENGTH * inertia_of_air() + 0 * missing, rel=1e-6, abs=1e-9)


def test_a_rotor_in_steady_operation_has_no_such_loads():
    """Coned, tilted, with twisted and swept blades: the velocities along the normals do not change, on average."""
    thrust = []
    for added_mass in (False, True):
        given = {"wind.kind": "steady", "wind.mean_speed": 9.0, "tower_flow.active": False}
        given |= {"turbine.assembly.blade_hinges": 0, "turbine.aerodynamics.added_mass": added_mass}
        result = fw.load("nrel5mw_land", set=given).compile().simulate(40.0, 0.1)
        thrust.append(np.asarray(result["thrust"])[np.asarray(result.time) > 20].mean())
    assert thrust[1] == pytest.approx(thrust[0], rel=2e-5)
