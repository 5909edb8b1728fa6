"""A turbine downwind of its tower: the nacelle turned round, mirror images of the air, the wake of the tower."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.aero import TowerShadow

RIGID = {
    "tower.hinges": 0, "turbine.assembly.blade_hinges": 0, "wind.kind": "steady", "wind.mean_speed": 11.0,
    "wind.shear_exponent": 0.0, "tower_flow.active": False, "tower_drag.active": False,
}  # fmt: skip
SPEEDS = {"turbine.rotor_speed_start": 1.2, "turbine.blade_pitch_start": 0.0}
HUB = "turbine.assembly.nacelle.hub.r"
AZIMUTH = "turbine.assembly.nacelle.azimuth_start"


def state_of(**changes):
    return fw.load("nrel5mw_land", set={**RIGID, **SPEEDS, **changes}).compile().initial_state()


def value(state, path):
    return np.array(state[path], dtype=float).ravel()


def test_what_hangs_on_the_tower_is_turned_round():
    """Hub and blades lie behind the tower as they lay in front of it, and their weight bends it the other way."""
    calm = {"world.air_density": 0.0, "turbine.rotor_speed_start": 0.0}
    up, down = state_of(**calm), state_of(**calm, **{"turbine.downwind": True})
    for node in (0, 16):
        assert value(down, f"turbine.assembly.nodes[{node}].r")[0] > 0
    assert value(down, HUB) == pytest.approx([-1, 1, 1] * value(up, HUB))
    assert value(up, HUB) == pytest.approx(
        [-5.0191 * np.cos(np.radians(5)), 0, 87.6 + 1.96256 + 5.0191 * np.sin(np.radians(5))]
    )
    moments = [float(state["tower_base_fore_aft_moment"]) for state in (up, down)]
    assert moments[1] == pytest.approx(-moments[0], rel=1e-6)
    assert abs(moments[0]) > 1e6


@pytest.mark.parametrize("yaw", [0.0, 20.0])
def test_its_air_is_that_of_the_upwind_rotor_seen_in_a_mirror(yaw):
    """A mirror from z to -z turns an upwind rotor, tilted and coned, into one that turns the other way and looks down.

    That is a rotor downwind of its tower with its cone reversed: thrust, torque and the force of the air agree to
    rounding, and the force upward has the other sign. Blade 1 hangs in the one and stands in the other.
    """
    oblique = {"wind.direction": np.radians(yaw)}
    other = {"turbine.downwind": True, "turbine.assembly.rotation": -1, "turbine.assembly.hub.precone": "-2.5 deg"}
    up, down = state_of(**oblique, **{AZIMUTH: 0.0}), state_of(**oblique, **other, **{AZIMUTH: "180 deg"})
    for name in ("thrust", "torque", "aero_power"):
        path = f"turbine.aerodynamics.{name}"
        assert float(down[path]) == pytest.approx(float(up[path]), rel=1e-9)
    force = value(up, "turbine.aerodynamics.force")
    assert value(down, "turbine.aerodynamics.force") == pytest.approx(force * [1, 1, -1], rel=1e-9)
    assert abs(force[2]) > 1e4


def test_in_mirrored_wind_a_downwind_machine_does_the_mirror_image():
    """A mirror from y to -y: wind from the other side, blades that turn the other way."""
    one = state_of(**{"turbine.downwind": True, "wind.direction": "15 deg", AZIMUTH: "40 deg"})
    two = state_of(**{
        "turbine.downwind": True, "wind.direction": "-15 deg", AZIMUTH: "40 deg", "turbine.assembly.rotation": -1,
    })  # fmt: skip
    for name in ("thrust", "aero_power", "tower_base_fore_aft_moment"):
        assert float(two[name]) == pytest.approx(float(one[name]), rel=1e-9)
    for name in ("tower_base_side_side_moment", "tower_base_torsion"):
        assert float(two[name]) == pytest.approx(-float(one[name]), rel=1e-9)


def test_the_rotor_of_coefficients_downwind():
    """Its shaft points up behind the tower, and its body lies before the hub: the pitching moment is reversed."""
    calm = {"wind.kind": "steady", "wind.mean_speed": 10.0, "sea.spectrum": "still", "platform.motion.heave_start": 0}
    up, down = (
        fw.load("oc3_spar_rigid", set={**calm, "turbine.downwind": side}).compile().initial_state()
        for side in (False, True)
    )
    assert float(down["thrust"]) == pytest.approx(float(up["thrust"]), rel=1e-12)
    force = [value(state, "turbine.rotor.frame.f") for state in (up, down)]
    assert force[1] == pytest.approx(force[0] * [1, 1, -1], rel=1e-12)
    assert abs(force[0][2]) > 1e4
    arm = [value(s, "turbine.body.frame_a.r")[0] - value(s, "turbine.frame.r")[0] for s in (up, down)]
    assert arm == pytest.approx([0, 0], abs=1e-9)


@pytest.fixture(scope="module")
def shadowed_turbine():
    """The land turbine downwind of its tower, which has a wake."""
    model = fw.load("nrel5mw_land", set={**RIGID, "turbine.downwind": True, "tower_flow.active": True})
    root = model.root
    wake = root.add("tower_shadow", TowerShadow(diameters=[6.0, 3.87]))
    root.connect(root.world.frame, wake.nodes[0])
    root.connect(root.tower.frame_b, wake.nodes[1])
    return model


def test_a_blade_has_less_thrust_in_the_shadow_once_a_turn(shadowed_turbine):
    """The flapwise moment dips while a blade hangs; in front of the tower the dam takes far less."""
    run = shadowed_turbine.compile().simulate(12.0, 0.05, parameters=SPEEDS)
    azimuth, flap = np.asarray(run["azimuth"]) % 360, np.asarray(run["blade_root_flapwise_moment_1"])
    late = np.asarray(run.time) > 2
    behind, beside = late & (abs(azimuth - 180) < 4), late & (abs(azimuth - 150) < 6)
    assert behind.sum() > 2 and beside.sum() > 2
    upwind = fw.load("nrel5mw_land", set={**RIGID, "tower_flow.active": True}).compile()
    other = upwind.simulate(12.0, 0.05, parameters=SPEEDS)
    dip = flap[beside].mean() - flap[behind].mean()
    front = np.asarray(other["blade_root_flapwise_moment_1"])
    azimuth = np.asarray(other["azimuth"]) % 360
    small = front[late & (abs(azimuth - 150) < 6)].mean() - front[late & (abs(azimuth - 180) < 4)].mean()
    assert dip > 3 * abs(small)
    assert dip > 0.15 * flap[late].mean()
