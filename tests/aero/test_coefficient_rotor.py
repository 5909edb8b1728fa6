"""The rotor by coefficients: loads, relative wind, filter, reaction on the body, edges of its table."""

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import CoefficientRotor, read_coefficients
from fowtlib.components.blocks import Constant
from fowtlib.components.environment.wind import Wind
from fowtlib.components.mechanics import Fixed, FreeMotion, Inertia, Prismatic, RigidBody, SpeedSource, World
from fowtlib.language import Assembly
from fowtlib.language.errors import SimulationError

CSV = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients.csv")
WHOLE = CSV.replace(".csv", "_whole.csv")
RATED = 12.1 * np.pi / 30
AREA = np.pi * (63 * np.cos(np.radians(2.5))) ** 2


def turning(speed=RATED, pitch=0.0, wind=11.4, support=None, wind_kind="steady", **rotor):
    """A rotor at a prescribed speed and pitch, at the hub frame of `support` (fixed, 90 m high, when left out)."""
    model = Assembly("rotor")
    model.world = World()
    settings = {} if wind_kind == "none" else {"mean_speed": wind}
    model.wind = Wind(kind=wind_kind, **settings, **rotor.pop("wind_settings", {}))
    model.rotor = CoefficientRotor(
        **{"coefficients": CSV, "radius": 63.0, "precone": "2.5 deg", "inertia": 3.876e7, "filtered": False, **rotor}
    )
    model.drive, model.speed, model.pitch = SpeedSource(), Constant(value=speed), Constant(value=pitch)
    model.support = support or Fixed(r=(0, 0, 90))
    model.connect(
        model.support.frame if hasattr(support, "frame") or not support else support.frame_b, model.rotor.frame
    )
    model.connect(model.speed.y, model.drive.w)
    model.connect(model.drive.flange, model.rotor.shaft)
    model.connect(model.pitch.y, model.rotor.blade_pitch)
    return model


def values(model, *names, **start):
    state = fw.load(model).compile().initial_state(start=start)
    found = [np.ravel(state[f"rotor.{name}"]) for name in names]
    return [float(value[0]) if value.size == 1 else value for value in found]


@pytest.mark.parametrize(("wind", "pitch"), [(8.0, 0.0), (11.4, 0.0), (18.0, np.radians(14.9))])
def test_thrust_and_torque(wind, pitch):
    thrust, torque, power, tip = values(
        turning(pitch=pitch, wind=wind), "thrust", "torque", "aero_power", "tip_speed_ratio"
    )
    C_t, C_q = read_coefficients(CSV)(RATED * 63 / wind, pitch)
    assert tip == pytest.approx(RATED * 63 / wind)
    assert thrust == pytest.approx(1.225 / 2 * AREA * C_t * wind**2, rel=1e-9)
    assert torque == pytest.approx(1.225 / 2 * AREA * 63 * np.cos(np.radians(2.5)) * C_q * wind**2, rel=1e-9)
    assert power == pytest.approx(torque * RATED, rel=1e-12)


def test_rated_point():
    """12.1 rpm in 11.4 m/s: 5.3 MW at the shaft (NREL/TP-500-38060, table 1-1), and the largest thrust of the curve."""
    thrust, power = values(turning(), "thrust", "aero_power")
    assert power == pytest.approx(5.2966e6, rel=0.02)
    assert 700e3 < thrust < 810e3


def test_wind_along_the_rotor_normal():
    """Tilt and the attitude of the tower turn the normal; the wind along it is the cosine of the angle between them."""
    tilt, yaw, heel = np.radians([5.0, 20.0, 4.0])
    support = Fixed(r=(0, 0, 90), angles=(0, heel, yaw))
    wind, force, thrust = values(turning(support=support, tilt=tilt), "normal_wind", "frame.f", "thrust")
    direction = [np.cos(yaw) * np.cos(tilt + heel), np.sin(yaw) * np.cos(tilt + heel), -np.sin(tilt + heel)]
    assert wind == pytest.approx(11.4 * direction[0])
    assert -force == pytest.approx(thrust * np.array(direction), rel=1e-12)


def on_rails(**parameters):
    model = turning(support=Prismatic(v_start=1.5), **parameters)
    model.base, model.body = Fixed(r=(0, 0, 90)), RigidBody(mass=3.5e5, inertia=np.eye(3))
    model.connect(model.base.frame, model.support.frame_a)
    model.connect(model.support.frame_b, model.body.frame_a)
    return model


def test_velocity_of_the_hub_is_taken_off_the_wind():
    assert values(on_rails(), "relative_wind", "tip_speed_ratio") == pytest.approx([9.9, RATED * 63 / 9.9])
    filtered = values(on_rails(filtered=True), "mean_wind", "relative_wind", "tip_speed_ratio")
    assert filtered == pytest.approx([11.4, 9.9, RATED * 63 / 9.9])


def test_filter_of_the_tip_speed_ratio():
    step = {"wind_settings": {"step_speed": 12.0, "start_time": 20.0, "step_duration": 0.01}, "wind_kind": "step"}
    plant = fw.load(turning(wind=10.0, filtered=True, filter_order=3, **step)).compile()
    result = plant.simulate(400.0, 5.0, outputs=["rotor.mean_wind", "rotor.relative_wind"])
    time, mean = result["rotor.mean_wind"].time.to_numpy(), result["rotor.mean_wind"].to_numpy()
    system = signal.TransferFunction(*signal.butter(3, 2 * np.pi * 0.0033, analog=True))
    _, response = signal.step(system, T=np.arange(0.0, 385.0, 5.0))
    assert mean[time <= 20] == pytest.approx(10.0)
    assert mean[time >= 20] == pytest.approx(10 + 2 * response[: len(mean[time >= 20])], abs=2e-3)
    assert float(result["rotor.relative_wind"][-1]) == pytest.approx(12.0)


@pytest.mark.parametrize("rotation", [1, -1])
def test_the_tower_takes_the_shaft_torque(rotation):
    """A rotor that turns clockwise, seen downwind, turns the nacelle the same way: the generator stands on it."""
    tilt = np.radians(5.0)
    moment, torque = values(turning(rotation=rotation, tilt=tilt), "frame.t", "torque")
    assert -moment == pytest.approx(rotation * torque * np.array([np.cos(tilt), 0, -np.sin(tilt)]), rel=1e-9, abs=1e-3)
    assert values(turning(rotation=rotation, reaction_torque=False), "frame.t")[0] == pytest.approx([0, 0, 0], abs=1e-6)


@pytest.mark.parametrize("rotation", [1, -1])
def test_gyroscopic_moment(rotation):
    """A spinning rotor that pitches forward (angular velocity along y) feels a yaw moment, against its sense."""
    model = turning(rotation=rotation, support=FreeMotion(heave_start=90, angle_rates_start=(0, 0.02, 0)))
    model.body = RigidBody(mass=3.5e5, inertia=1e7 * np.eye(3))
    model.connect(model.world.frame, model.support.frame_a)
    model.connect(model.support.frame_b, model.body.frame_a)
    moment, torque = values(model, "frame.t", "torque")
    assert -moment == pytest.approx([rotation * torque, 0, rotation * 3.876e7 * RATED * 0.02], rel=1e-6)


def test_speed_equation():
    """A rotor on a free shaft accelerates with torque over the inertia of both."""
    model = Assembly()
    model.world, model.wind, model.tower = World(), Wind(kind="steady", mean_speed=10.0), Fixed(r=(0, 0, 90))
    model.rotor = CoefficientRotor(coefficients=CSV, radius=63.0, inertia=3e7, w_start=1.0, filtered=False)
    model.flywheel, model.pitch = Inertia(inertia=1e7), Constant(value=0.0)
    for a, b in (
        (model.tower.frame, model.rotor.frame),
        (model.rotor.shaft, model.flywheel.flange_a),
        (model.pitch.y, model.rotor.blade_pitch),
    ):
        model.connect(a, b)
    result = (
        fw.load(model).compile().simulate(1.0, 0.1, tolerance=1e-9, outputs=["rotor.w", "rotor.torque", "rotor.phi"])
    )
    rise = float(result["rotor.w"][-1]) - 1.0
    mean = float(result["rotor.torque"].mean())
    assert rise == pytest.approx(mean / 4e7, rel=1e-4)
    assert float(result["rotor.phi"][-1]) == pytest.approx(1.0 + rise / 2, rel=1e-3)


def test_no_air_without_wind():
    model = turning(wind_kind="none", speed=0.0)
    assert values(model, "thrust", "torque", "tip_speed_ratio") == [0, 0, 0]


def test_leaving_the_table_stops_the_run():
    with pytest.raises(SimulationError, match=r"table left at its edge: .* rotor at tip speed ratio = 17\.\d+"):
        fw.load(turning(speed=1.4, wind=5.0)).compile().simulate(1.0, 0.1)
    with pytest.raises(SimulationError, match=r"speed ratio = 1\.26, and the table covers 2 to 25; give a table that"):
        fw.load(turning(speed=0.1, wind=5.0, extended=True)).compile().simulate(1.0, 0.1)
    with pytest.raises(SimulationError, match=r"blade pitch \[rad\] = 1\.57.*; give a table that covers the state"):
        fw.load(turning(pitch=np.pi / 2, extended=True)).compile().simulate(1.0, 0.1)
    wide = turning(speed=1.4, wind=5.0, extended=True)
    assert values(wide, "tip_speed_ratio", "thrust_coefficient") == pytest.approx([17.64, 1.17], rel=0.02)


def test_wind_from_behind_stops_the_run():
    model = turning(speed=0.0, wind=8.0, wind_settings={"direction": "180 deg"}, coefficients=WHOLE)
    with pytest.raises(SimulationError, match="the mean wind is from behind the rotor, and its coefficients hold for"):
        fw.load(model).compile().simulate(1.0, 0.1)


def test_wind_across_the_shaft_is_named_where_the_table_is_left():
    across = {"wind_settings": {"direction": "90 deg"}, "coefficients": WHOLE}
    with pytest.raises(
        SimulationError, match=r"blows across the rotor: .* m/s of it go along .* speed ratio of -12\.6"
    ):
        fw.load(turning(speed=-0.1, wind=8.0, **across)).compile().simulate(1.0, 0.1)
    assert values(turning(speed=0.0, wind=8.0, **across), "thrust") == pytest.approx([0.0], abs=1.0)  # stands, no loads


def test_a_search_for_the_mean_tells_what_was_wrong_where_it_began():
    model = fw.load("oc3_spar_rigid").compile()
    behind = {"wind.kind": "steady", "wind.mean_speed": 12.0, "wind.direction": np.pi, "sea.spectrum": "still"}
    with pytest.raises(
        SimulationError, match=r"no equilibrium .* breaks a condition: turbine\.rotor: the mean wind is "
    ):
        model.equilibrium(behind)


def test_a_feathered_rotor_in_a_storm():
    """50 m/s from standstill at 85 deg with nothing that brakes: it idles where the torque of the table is 0."""
    free = Assembly("idling")
    free.world, free.wind, free.support = World(), Wind(kind="steady", mean_speed=50.0), Fixed(r=(0, 0, 90))
    free.rotor = CoefficientRotor(coefficients=WHOLE, radius=63.0, precone="2.5 deg", inertia=3.876e7, filtered=False)
    free.pitch, free.flywheel = Constant(value=np.radians(85)), Inertia(inertia=1e6)
    free.connect(free.rotor.shaft, free.flywheel.flange_a)
    free.connect(free.support.frame, free.rotor.frame)
    free.connect(free.pitch.y, free.rotor.blade_pitch)
    result = fw.load(free).compile().simulate(200.0, 1.0, outputs=["rotor.w", "rotor.thrust", "rotor.torque"])
    speed = float(result["rotor.w"][-1])
    assert 0.5 < speed * 30 / np.pi < 2.5
    assert float(result["rotor.torque"][-1]) == pytest.approx(0, abs=1e3)
    thrust, torque = values(
        turning(speed=speed, pitch=np.radians(85), wind=50.0, coefficients=WHOLE), "thrust", "torque"
    )
    assert float(result["rotor.thrust"][-1]) == pytest.approx(thrust, rel=1e-4)
    assert 50e3 < thrust < 110e3
