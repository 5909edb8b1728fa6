"""The turbine with a blade-element rotor: its loads against the same theory with independent kinematics, symmetry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import BladeElementAerodynamics, RigidRotor
from fowtlib.components.environment import Wind, World, generate_field
from fowtlib.components.servo import BaselineController
from fowtlib.components.support import RigidTower
from fowtlib.components.turbine import Drivetrain, Hub, Nacelle, RotorNacelleAssembly, Turbine
from fowtlib.language.errors import ParameterError

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"
PITCH, SPEED, SHEAR = 0.05, 1.2, 0.2
TILT, CONE = np.radians(5), np.radians(2.5)


def turbine(rotation=1, **options):
    air = BladeElementAerodynamics(
        blade=str(DATA / "blade_aerodynamics.csv"), airfoils=str(DATA / "airfoils.csv"), tip_radius=63, **options
    )
    nacelle = Nacelle(mass=240e3, shaft_height=1.96256, tilt=TILT, overhang=5.0191)
    drivetrain = Drivetrain(gear_ratio=97, stiffness=867637000.0, generator_inertia=534.116)
    assembly = RotorNacelleAssembly(
        rotation=rotation, blade_properties=str(DATA / "blade_structure.csv"), blade_hinges=0, nacelle=nacelle,
        hub=Hub(precone=CONE, radius=1.5), drivetrain=drivetrain,
    )  # fmt: skip
    control = BaselineController(proportional_gain=0.006, integral_gain=0.0009)
    return Turbine(
        assembly=assembly, aerodynamics=air, control=control, rotor_speed_start=SPEED, blade_pitch_start=PITCH
    )


def on_a_tower(machine):
    model = fw.Assembly("turbine on a rigid tower")
    model.world = World()
    model.wind = Wind(kind="steady", mean_speed=11.0, shear_exponent=SHEAR, direction=np.radians(10))
    model.tower = RigidTower(height=87.6, mass=1.0, centre_of_mass=40.0)
    model.turbine = machine
    model.connect(model.world.frame, model.tower.frame_a)
    model.connect(model.tower.frame_b, model.turbine.frame)
    return fw.load(model).compile()


@pytest.fixture(scope="module")
def states():
    return {rotation: on_a_tower(turbine(rotation)).initial_state() for rotation in (1, -1)}


@pytest.mark.parametrize("rotation", [1, -1])
def test_loads_are_those_of_the_rigid_rotor(states, rotation):
    """RigidRotor places the nodes by its own rotations; the wind over its nodes is sheared and skewed here."""
    state, hub = states[rotation], np.array([-5.0191 * np.cos(TILT), 0, 87.6 + 1.96256 + 5.0191 * np.sin(TILT)])
    rigid = RigidRotor(turbine(rotation).aerodynamics.rotor, CONE, TILT)
    position = rigid.inputs([1, 0, 0], SPEED, PITCH, hub=hub)[: 3 * rigid.rotor.nodes].reshape(-1, 3)
    speed = 11.0 * (position[:, 2] / 90) ** SHEAR
    wind = speed[:, None] * [np.cos(np.radians(10)), np.sin(np.radians(10)), 0]
    thrust, torque = rigid.thrust_and_torque(wind, SPEED, PITCH, hub=hub)
    assert state["turbine.thrust"] == pytest.approx(thrust, rel=1e-9)
    assert state["turbine.aerodynamics.torque"] == pytest.approx(torque, rel=1e-9)
    assert state["turbine.aero_power"] == pytest.approx(SPEED * torque, rel=1e-9)


def test_the_wind_thrusts_the_tower(states):
    """The load of the nodes arrives at the tower top: thrust along the tilted shaft and the weight below it."""
    state = states[1]
    force, moment = np.ravel(state["turbine.aerodynamics.force"]), np.ravel(state["turbine.aerodynamics.moment"])
    shaft = np.array([np.cos(TILT), 0, -np.sin(TILT)])
    assert shaft @ force == pytest.approx(state["turbine.thrust"])
    assert shaft @ moment == pytest.approx(state["turbine.aerodynamics.torque"])
    assert state["turbine.thrust"] > 4e5


def test_a_mirrored_rotor_in_mirrored_wind():
    """Y to -y: thrust and torque are the same, side force and yaw moment change sign."""
    found = []
    for rotation, direction in ((1, 10.0), (-1, -10.0)):
        plant = on_a_tower(turbine(rotation))
        state = plant.initial_state({"wind.direction": np.radians(direction)})
        loads = [np.ravel(state[f"turbine.aerodynamics.{name}"]) for name in ("force", "moment")]
        found.append((state["turbine.thrust"], state["turbine.aerodynamics.torque"], *loads))
    right, left = found
    assert left[:2] == pytest.approx(right[:2])
    assert left[2] == pytest.approx(right[2] * [1, -1, 1])
    assert left[3] == pytest.approx(right[3] * [-1, 1, -1])


def test_the_start_is_steady_operation():
    """In steady wind on land the rotor keeps the speed it starts with: aerodynamic against generator torque."""
    model = fw.load("nrel5mw_land", set={"wind.kind": "steady", "wind.mean_speed": 8.0, "tower.hinges": 0,
                                            "turbine.assembly.blade_hinges": 0})  # fmt: skip
    plant = model.compile()
    state = plant.initial_state()
    braking = 97 * state["turbine.generator_torque"]
    assert state["turbine.aerodynamics.torque"] == pytest.approx(braking, rel=0.02)
    assert float(state["turbine.rotor_speed"]) * 30 / np.pi == pytest.approx(9.2, abs=0.3)


def test_what_the_hub_radius_is_for():
    air = BladeElementAerodynamics(
        blade=str(DATA / "blade_aerodynamics.csv"), airfoils=str(DATA / "airfoils.csv"), tip_radius=63
    )
    with pytest.raises(ParameterError) as error:
        air.rotor  # noqa: B018
    assert str(error.value) == (
        "BladeElementAerodynamics.hub_radius has no value: distance of the blade roots from the shaft."
    )


def test_a_wind_field_that_does_not_cover_the_rotor_is_refused(tmp_path):
    """Hub at 90 m, radius 63 m: the disk reaches from -63 to 63 m and from 27 to 153 m."""
    path, conditions = str(tmp_path / "small.bts"), {"wind.kind": "field", "turbine.assembly.blade_hinges": 0}
    generate_field(path, mean_speed=11.4, width=160, height=100, columns=9, rows=6, duration=10, time_step=0.5)
    with pytest.raises(ParameterError) as error:
        fw.load("nrel5mw_land", set={**conditions, "wind.file": path}).compile()
    assert str(error.value) == (
        f"{path}: the wind field is too small: the rotor of turbine.aerodynamics, of radius 63 m about station 0 of "
        "the wind at (0, 90) m, needs z = 27 to 153 m, and the field covers 40 to 140 m; make one at least 126 m wide, "
        "and 27 to 153 m high, and more for the motion of a floating platform."
    )
    large = str(tmp_path / "large.bts")
    generate_field(large, mean_speed=11.4, width=160, height=130, columns=9, rows=6, duration=10, time_step=0.5)
    model = fw.load("nrel5mw_land", set={**conditions, "wind.file": large, "tower.hinges": 0})
    assert model.compile().initial_state()["turbine.aerodynamics.thrust"] > 0
    with pytest.raises(ParameterError, match=r"station 1 of wind does not exist \(it has 1, counted from 0\)"):
        model.with_parameters({"turbine.aerodynamics.station": 1}).compile()
