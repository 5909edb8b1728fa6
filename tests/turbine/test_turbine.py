"""The NREL 5 MW turbine on a rigid tower: steady operation, steps, turbulence, start values."""

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import CoefficientRotor, read_coefficients
from fowtlib.components.blocks import Constant
from fowtlib.components.environment.wind import Wind
from fowtlib.components.mechanics import Fixed, FixedRotation, FixedTranslation, Revolute, World
from fowtlib.components.mechanics.attitude import heading_at_start
from fowtlib.components.mechanics.wire import AxialWire
from fowtlib.components.servo import ONSHORE_GAINS, BaselineController, TorqueLaw
from fowtlib.components.turbine import RotorNacelle, SteadyTurbine, start_point
from fowtlib.language import Assembly, Component, RealInput, RealOutput, eq, port
from fowtlib.language.errors import ModelError, ParameterError

CSV = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients.csv")
WHOLE = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients_whole.csv")
RPM = np.pi / 30

# Wind speed [m/s], electrical power [kW], thrust [kN]: NREL/turbine-models, NREL_Reference_5MW_126.csv (OpenFAST).
PUBLISHED = [
    (4, 177.67, 121.90), (6, 737.59, 236.23), (8, 1771.17, 384.00), (10, 3448.38, 597.48), (12, 5000.0, 595.94),
    (15, 5000.02, 426.43), (18, 5000.03, 354.36), (20, 5000.04, 324.77), (25, 5000.04, 275.29),
]  # fmt: skip
# Wind speed [m/s], blade pitch [deg]: NREL/TP-500-38060 (2009), table 7-1.
PITCH = {12: 3.83, 13: 6.60, 14: 8.70, 15: 10.45, 16: 12.06, 18: 14.92, 20: 17.47, 22: 19.94, 25: 23.47}
STEADY = SteadyTurbine(read_coefficients(CSV), 63.0, TorqueLaw(), 97.0, precone=np.radians(2.5))
RESULTS = [f"turbine.{name}" for name in ("rotor_speed", "blade_pitch", "generator_power", "thrust")]


def onshore(wind_speed, kind="steady", *, wind=None, rotor=None, control=None, **turbine):
    model = Assembly("NREL 5 MW on a rigid tower")
    model.world, model.tower = World(), Fixed(r=(0, 0, 90))
    speed = {} if kind == "none" else {"mean_speed": wind_speed}
    model.wind = Wind(kind=kind, **speed, **(wind or {}))
    rotor_data = {"coefficients": CSV, "radius": 63.0, "precone": "2.5 deg", "inertia": 38759227.0, **(rotor or {})}
    model.turbine = RotorNacelle(
        **{
            "mass": 350e3,
            "gear_ratio": 97.0,
            "generator_inertia": 534.116,
            "generator_efficiency": 0.944,
            "rotor": CoefficientRotor(**rotor_data),
            "control": BaselineController(**{**ONSHORE_GAINS, **(control or {})}),
            **turbine,
        }
    )
    model.connect(model.tower.frame, model.turbine.frame)
    return model


@pytest.mark.parametrize(("wind", "power", "thrust"), PUBLISHED)
def test_published_steady_curve(wind, power, thrust):
    """Within 4 %: the power of the coefficients of a rigid rotor peaks 3 % below that of the published curve."""
    point = STEADY.operating_point(wind)
    assert 0.944 * point.aero_power / 1e3 == pytest.approx(power, rel=0.04)
    assert point.thrust / 1e3 == pytest.approx(thrust, rel=0.04)


@pytest.mark.parametrize(("wind", "pitch"), PITCH.items())
def test_published_pitch(wind, pitch):
    assert np.degrees(STEADY.operating_point(wind).blade_pitch) == pytest.approx(pitch, abs=0.5)


def test_rated_operation():
    point = STEADY.operating_point(11.5)
    assert point.rotor_speed / RPM == pytest.approx(12.1, abs=1e-6)
    assert point.aero_power == pytest.approx(5.2966e6, rel=1e-4)
    assert point.generator_torque == pytest.approx(43093.55, rel=1e-6)
    thrusts = [STEADY.operating_point(wind).thrust for wind in np.arange(9, 14, 0.1)]
    assert 700e3 < max(thrusts) < 810e3


def test_region_2_is_near_the_best_tip_speed_ratio():
    for wind in (8.5, 9.5, 10.0):
        assert STEADY.operating_point(wind).tip_speed_ratio == pytest.approx(7.55, rel=0.02)


def test_wind_without_steady_operation():
    with pytest.raises(
        ModelError, match=r"there is no steady operation at 2\.5 m/s within the table of the rotor, tip"
    ):
        STEADY.operating_point(2.5)
    with pytest.raises(ModelError, match=r"^turbine: there is no steady operation at 60 m/s .* give rotor_speed_start"):
        fw.load(onshore(60.0)).compile()


def test_a_rotor_at_a_station_without_wind():
    with pytest.raises(ParameterError, match="station 1 of wind does not exist .it has 1, counted from 0.; set its"):
        fw.load(onshore(9.0, rotor={"station": 1})).compile()


@pytest.mark.parametrize("wind", [4.0, 8.0, 11.4, 12.0, 18.0, 25.0])
def test_a_simulation_starts_and_stays_at_the_operating_point(wind):
    plant = fw.load(onshore(wind)).compile()
    point = STEADY.operating_point(wind)
    result = plant.simulate(30.0, 1.0, outputs=RESULTS)
    expected = (point.rotor_speed, point.blade_pitch, 0.944 * point.aero_power, point.thrust)
    for name, value in zip(RESULTS, expected, strict=True):
        assert result[name].to_numpy() == pytest.approx(value, rel=1e-6, abs=1e-9)
    state = plant.equilibrium()
    assert float(state["turbine.rotor_speed"]) == pytest.approx(point.rotor_speed, rel=1e-6)


def test_drive_train_of_one_inertia():
    """Rotor and generator on the low speed side: 43,784,725 kg m^2 (NREL/TP-500-38060, section 7.3)."""
    plant = fw.load(onshore(10.0, rotor={"filtered": False}, rotor_speed_start=1.0)).compile()
    state = plant.initial_state()
    surplus = float(state["turbine.rotor.torque"]) - 97 * float(state["turbine.generator_torque"])
    result = plant.simulate(0.02, 0.01, tolerance=1e-10, outputs=["turbine.rotor_speed"])
    rate = float(np.diff(result["turbine.rotor_speed"].to_numpy())[0]) / 0.01
    assert rate == pytest.approx(surplus / 43784725, rel=1e-3)


def test_step_across_rated_wind():
    """From region 2 to region 3 and rest at the operating point of the new wind; the pitch never leaves its limits."""
    step = {"step_speed": 18.0, "start_time": 5.0, "step_duration": 20.0}
    plant = fw.load(onshore(8.0, "step", wind=step, rotor={"filtered": False})).compile()
    result = plant.simulate(80.0, 0.1, outputs=RESULTS)
    point, speed = STEADY.operating_point(18.0), result["turbine.rotor_speed"].to_numpy()
    assert speed[-1] == pytest.approx(point.rotor_speed, rel=1e-5)
    assert float(result["turbine.blade_pitch"][-1]) == pytest.approx(point.blade_pitch, abs=1e-4)
    assert speed.max() < 1.2 * point.rotor_speed
    assert float(result["turbine.blade_pitch"].min()) >= -1e-12  # rounding
    settled = speed[result["turbine.rotor_speed"].time.to_numpy() > 60]
    assert np.abs(settled / point.rotor_speed - 1).max() < 2e-3


def test_step_down_to_region_2():
    step = {"step_speed": 8.0, "start_time": 5.0, "step_duration": 5.0}
    plant = fw.load(onshore(18.0, "step", wind=step, rotor={"filtered": False})).compile()
    result = plant.simulate(150.0, 0.5, outputs=RESULTS)
    point = STEADY.operating_point(8.0)
    assert float(result["turbine.rotor_speed"][-1]) == pytest.approx(point.rotor_speed, rel=1e-4)
    assert float(result["turbine.thrust"][-1]) == pytest.approx(point.thrust, rel=1e-3)


def test_sampled_control_is_the_same_control():
    gust = {"gust_shape": "1-cos", "gust_speed": 3.0, "gust_duration": 3.0, "start_time": 1.003}
    runs = [
        fw.load(onshore(14.0, "gust", wind=gust, control={"sample_period": period})).compile()
        for period in (None, 0.0125)
    ]
    continuous, sampled = (plant.simulate(4.0, 0.1, outputs=RESULTS) for plant in runs)
    time = sampled[RESULTS[0]].time.to_numpy()
    for name, tolerance in zip(RESULTS, (2e-3, 2e-3, 2e4, 1e4), strict=True):
        expected = np.interp(time, continuous[name].time.to_numpy(), continuous[name].to_numpy())
        assert sampled[name].to_numpy() == pytest.approx(expected, abs=tolerance)


def test_turbulent_wind_below_and_above_rated():
    for wind, power in ((8.0, 1771e3), (18.0, 5000e3)):
        plant = fw.load(onshore(wind, "kaimal", wind={"seed": 3}, rotor={"coefficients": WHOLE})).compile()
        result = plant.simulate(300.0, 0.5, outputs=RESULTS)
        assert float(result["turbine.generator_power"].mean()) == pytest.approx(power, rel=0.15)
        assert float(result["turbine.blade_pitch"].min()) >= -1e-12  # rounding
        assert float(result["turbine.rotor_speed"].max()) < 1.25 * 12.1 * RPM


def test_without_wind_the_rotor_stands_still():
    result = fw.load(onshore(0, "none")).compile().simulate(20.0, 5.0, outputs=RESULTS)
    for name in RESULTS:
        assert result[name].to_numpy() == pytest.approx(0.0, abs=1e-12)


def test_constant_power_above_rated():
    plant = fw.load(onshore(18.0, "kaimal", control={"region_3": "constant_power"})).compile()
    result = plant.simulate(60.0, 0.5, outputs=RESULTS)
    assert float(result["turbine.generator_power"].std()) < 0.01 * 5e6


def test_start_values_given():
    model = onshore(12.0, rotor_speed_start="10 rpm", blade_pitch_start="2 deg")
    state = fw.load(model).compile().initial_state()
    assert float(state["turbine.rotor_speed"]) == pytest.approx(10 * RPM)
    assert float(state["turbine.blade_pitch"]) == pytest.approx(np.radians(2))


def test_start_point_of_a_station_in_sheared_wind():
    wind = {"stations": [(0, 90), (0, 140)], "shear_exponent": 0.2}
    model = onshore(10.0, wind=wind, rotor={"station": 1})
    assert start_point(model.turbine, 1).wind_speed == pytest.approx(10 * (140 / 90) ** 0.2)


class FixedControl(Component):
    """A controller of someone else's."""

    generator_speed: RealInput = port(unit="rad/s", doc="generator speed")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")

    def equations(self):
        return [eq(self.blade_pitch, 0), eq(self.generator_torque, 2.33 * self.generator_speed**2)]


def test_a_controller_of_ones_own_needs_start_values():
    with pytest.raises(
        ParameterError, match=r"turbine: with this rotor or controller give rotor_speed_start and blade"
    ):
        fw.load(own_control()).compile()
    plant = fw.load(own_control(rotor_speed_start=1.0, blade_pitch_start=0.0)).compile()
    assert float(plant.initial_state()["turbine.generator_torque"]) == pytest.approx(2.33 * 97**2)


def own_control(**start):
    data = {"mass": 350e3, "gear_ratio": 97.0, "generator_inertia": 534.116, **start}
    rotor = CoefficientRotor(coefficients=CSV, radius=63.0, inertia=38759227.0)
    other = Assembly()
    other.world, other.wind, other.tower = World(), Wind(kind="steady", mean_speed=9.0), Fixed(r=(0, 0, 90))
    other.turbine = RotorNacelle(rotor=rotor, control=FixedControl(), **data)
    other.connect(other.tower.frame, other.turbine.frame)
    return other


def test_rate_of_the_pitch_loop():
    """The PI loop at 13 m/s is a damped oscillation near its design of 0.6 rad/s and 0.7."""
    plant = fw.load(onshore(13.0, rotor={"filtered": False})).compile()
    poles = np.linalg.eigvals(np.array(plant.linearize(plant.initial_state()).A))
    loop = poles[poles.imag > 1e-3]
    assert len(loop) == 1
    assert 0.35 < abs(loop[0]) < 0.75
    assert 0.3 < -loop[0].real / abs(loop[0]) < 0.9


@pytest.mark.parametrize(("direction", "thrust"), [(60, 120.3e3), (30, 292e3), (-75, None)])
def test_yawed_wind_starts_at_the_wind_along_the_shaft(direction, thrust):
    """Filter, rotor speed and thrust start where they stay: a steady wind of V cos(direction) cos(tilt)."""
    wind, tilt = {"direction": f"{direction} deg"}, np.radians(5.0)
    model = onshore(8.0, wind=wind, rotor={"tilt": "5 deg", "coefficients": WHOLE})
    plant = fw.load(model).compile()
    along = 8.0 * np.cos(np.radians(direction))
    result = plant.simulate(60.0, 10.0, outputs=[*RESULTS, "turbine.rotor.mean_wind", "turbine.rotor.normal_wind"])
    for name in ("mean_wind", "normal_wind"):
        assert result[f"turbine.rotor.{name}"].to_numpy() == pytest.approx(along * np.cos(tilt), rel=1e-9)
    table = read_coefficients(WHOLE)
    steady = SteadyTurbine(table, 63.0, TorqueLaw(), 97.0, precone=np.radians(2.5), tilt=tilt).operating_point(along)
    assert start_point(model.turbine, 0).thrust == pytest.approx(steady.thrust, rel=1e-9)
    assert result["turbine.rotor_speed"].to_numpy() == pytest.approx(steady.rotor_speed, rel=1e-6)
    assert result["turbine.thrust"].to_numpy() == pytest.approx(steady.thrust, rel=1e-6)
    if thrust is not None:
        assert steady.thrust == pytest.approx(thrust, rel=0.01)


@pytest.mark.parametrize(("speed", "direction"), [(0, 0), (8, 90), (8, 180), (8, -120)])
def test_no_wind_along_the_shaft_starts_at_standstill(speed, direction):
    plant = fw.load(onshore(speed, wind={"direction": f"{direction} deg"}, rotor={"coefficients": WHOLE})).compile()
    state = plant.initial_state()
    assert float(state["turbine.rotor_speed"]) == 0
    assert float(state["turbine.blade_pitch"]) == 0
    along = speed * np.cos(np.radians(direction))
    assert float(state["turbine.rotor.mean_wind"]) == pytest.approx(along, abs=1e-12)


def test_shipped_spar_in_yawed_wind_and_in_none():
    """`fowt run oc3_spar_rigid --wind steady:8,direction=60` starts in 8 cos(60 deg) cos(5 deg) m/s; at 0 it stands."""
    model = fw.load("oc3_spar_rigid")
    model.root.wind = Wind(kind="steady", mean_speed=8.0, direction="60 deg")
    state = model.compile().initial_state()
    assert float(state["turbine.rotor.mean_wind"]) == pytest.approx(3.985, abs=1e-3)
    assert float(state["turbine.thrust"]) == pytest.approx(120.3e3, rel=0.01)
    model = fw.load("oc3_spar_rigid")
    model.root.wind = Wind(kind="steady", mean_speed=0.0)
    assert float(model.compile().initial_state()["turbine.rotor_speed"]) == 0


LULLS = [  # each left a table that ends at tip speed ratio 25, after the time in the comment
    ("oc3_spar_rigid", 6, {"significant_wave_height": 1.0, "seed": 1}, ["turbine"], 300),  # 286 s
    ("two_rotor_spar_rigid", 38373629, {"significant_wave_height": 5.0, "peak_period": 14.0, "seed": 116937156},
     ["turbine_left", "turbine_right"], 60),  # 50 s
    ("two_rotor_spar_rigid", 1536558342, {"significant_wave_height": 5.0, "peak_period": 8.0, "seed": 1214556571},
     ["turbine_left", "turbine_right"], 10),  # 3 s
]  # fmt: skip


@pytest.mark.parametrize(("name", "seed", "sea", "turbines", "end"), LULLS)
def test_shipped_spars_pass_the_lulls_of_a_light_wind(name, seed, sea, turbines, end):
    """4 m/s of class B: where the mean wind falls below 2 m/s the air brakes the rotors."""
    wind = {"wind.mean_speed": 4.0, "wind.turbulence_class": "B", "wind.seed": seed}
    plant = fw.load(name, set={**wind, **{f"sea.{key}": value for key, value in sea.items()}}).compile()
    names = [f"{turbine}.rotor.{of}" for turbine in turbines for of in ("tip_speed_ratio", "torque_coefficient", "w")]
    result = plant.simulate(end, 0.25, outputs=names)
    ratio, torque, speed = (np.stack([result[n].to_numpy() for n in names[i::3]]) for i in range(3))
    assert result.time[-1] == end and 25 < ratio.max() < 60
    assert torque[ratio > 25].max() < 0 and speed.min() > 0.3 and speed.max() < 12.1 * RPM


@pytest.mark.parametrize(("direction", "yaw"), [(0, 40), (30, 30), (-20, 25)])
def test_a_spar_that_starts_turned_has_the_wind_along_its_shaft(direction, yaw):
    """By the model, and by a parameter of the run; yaw 30 deg in wind from 30 deg is no yaw at all."""
    along = 8.0 * np.cos(np.radians(direction - yaw))
    model = fw.load("oc3_spar_rigid", set={"platform.motion.yaw_start": np.radians(yaw)})
    model.root.wind = Wind(kind="steady", mean_speed=8.0, direction=np.radians(direction))
    plant = model.compile()
    point = start_point(model.root.turbine, 0)
    assert point.wind_speed == pytest.approx(along, rel=1e-12)
    state = plant.initial_state()
    for name in ("mean_wind", "normal_wind"):
        assert float(state[f"turbine.rotor.{name}"]) == pytest.approx(along * np.cos(np.radians(5)), rel=1e-3)
    assert float(state["turbine.rotor_speed"]) == pytest.approx(point.rotor_speed)
    straight = plant.initial_state({"platform.motion.yaw_start": np.radians(direction)})
    assert float(straight["turbine.rotor.mean_wind"]) == pytest.approx(8.0 * np.cos(np.radians(5)), rel=1e-12)
    assert float(straight["turbine.rotor_speed"]) > 1.01 * point.rotor_speed or along == 8.0


@pytest.mark.parametrize("platform", [0, 15])
@pytest.mark.parametrize("nacelle", [0, -35])
def test_a_nacelle_that_starts_turned_has_the_wind_along_its_shaft(platform, nacelle):
    """The flexible turbine on a beam, its yaw drive at a constant command, on a platform that starts turned."""
    model = fw.load("oc3_spar", set={"platform.motion.yaw_start": np.radians(platform)})
    root = model.root
    root.wind = Wind(kind="steady", mean_speed=9.0, direction=np.radians(10))
    root.command = Constant(value=np.radians(nacelle))
    root.connect(root.command.y, root.turbine.yaw_command)
    along = 9.0 * np.cos(np.radians(10 - platform - nacelle))
    assert start_point(root.turbine, 0).wind_speed == pytest.approx(along, rel=1e-12)


def test_the_heading_of_a_frame_at_the_start():
    """Along joints, links and fixed frames, in both directions; what holds no orientation leads nowhere."""
    root = fw.Assembly("mast")
    root.base = Fixed(angles=(0, 0, 0.2))
    root.mast = FixedRotation(n=(0, 0, 1), angle=0.3)
    root.hinge = Revolute(n=(0, 0, -1), phi_start=0.1)
    root.link = FixedTranslation(r=(0, 0, 3))
    root.wire = AxialWire(length=2.0, axial_stiffness=1.0)
    root.connect(root.base.frame, root.mast.frame_a)
    root.connect(root.mast.frame_b, root.hinge.frame_b)  # the other way round
    root.connect(root.hinge.frame_a, root.link.frame_a)
    root.connect(root.link.frame_b, root.wire.frame_a)
    assert heading_at_start(root.link, "frame_b") == pytest.approx(0.2 + 0.3 + 0.1)
    assert heading_at_start(root.hinge, "frame_b") == pytest.approx(0.2 + 0.3)
    assert heading_at_start(root.wire, "frame_b") == 0
