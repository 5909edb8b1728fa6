"""A rotor that is a thrust: by hand, in place of the rotor of coefficients, with and without its notch."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import ThrustCurve, ThrustRotor, read_thrust_curve
from fowtlib.components.blocks import BandPass, Sine
from fowtlib.components.environment import Wind
from fowtlib.components.mechanics import FreeMotion, RigidBody, World
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError, SimulationError

CURVE = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "thrust_curve.csv")
AREA = np.pi * (63 * np.cos(np.radians(2.5))) ** 2
SPAR = """
fowtlib: 1
title: OC3-Hywind spar with a thrust on top
world: {class: World, water_depth: 320 m, water_density: 1025 kg/m^3}
sea: {class: Sea, spectrum: still}
wind: {class: Wind, kind: steady, mean_speed: 8 m/s}
parts:
  platform: {use: platforms/oc3_hywind}
  tower:
    class: RigidBody
    mass: 249718 kg
    r_cm: [0, 0, 43.348]
    inertia: [[120252000, 0, 0], [0, 120252000, 0], [0, 0, 1818460]]
  tower_to_hub: {class: FixedTranslation, r: [-5, 0, 90]}
  turbine: {use: turbines/nrel5mw_thrust}
connect:
  - [world.frame, platform.world]
  - [platform.frame, tower.frame_a, tower_to_hub.frame_a]
  - [tower_to_hub.frame_b, turbine.frame]
outputs:
  surge: platform.motion.surge
  pitch: {of: platform.motion.pitch, unit: deg}
  thrust: {of: turbine.thrust, unit: kN}
"""


@pytest.fixture(scope="module")
def spar(tmp_path_factory):
    """The file of the spar."""
    path = tmp_path_factory.mktemp("thrust") / "spar.yaml"
    path.write_text(SPAR)
    return path


@pytest.fixture(scope="module")
def plant(spar):
    return fw.load(str(spar)).compile()


def moving(speed, **rotor):
    """A hub that moves downwind at a speed, in 12 m/s."""
    model = Assembly("hub")
    model.world, model.wind = World(), Wind(kind="steady", mean_speed=12.0, shear_exponent=0.0)
    model.motion = FreeMotion(heave_start=90, velocity_start=(speed, 0, 0))
    model.body = RigidBody(mass=1e6, inertia=((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    model.rotor = ThrustRotor(curve=CURVE, radius=63.0, precone="2.5 deg", **rotor)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    model.connect(model.motion.frame_b, model.rotor.frame)
    return fw.load(model).compile()


@pytest.mark.parametrize("speed", [0.0, 1.5, -2.25])
@pytest.mark.parametrize("side", [False, True])
def test_the_thrust_is_that_of_the_relative_wind(speed, side):
    tilt = np.radians(6.0)
    state = moving(speed, tilt=tilt, downwind=side).initial_state()
    U = (12.0 - speed) * np.cos(tilt)
    curve = read_thrust_curve(CURVE)
    C = float(PchipInterpolator(curve.wind_speed, curve.thrust_coefficient)(U))
    thrust = 1.225 / 2 * AREA * C * U**2
    assert float(state["rotor.thrust"]) == pytest.approx(thrust, rel=1e-6)
    assert float(state["rotor.relative_wind"]) == pytest.approx(U, rel=1e-12)
    force = -np.ravel(state["rotor.frame.f"])
    up = 1 if side else -1
    assert force == pytest.approx(float(state["rotor.thrust"]) * np.array([np.cos(tilt), 0, up * np.sin(tilt)]))


@pytest.mark.parametrize("wind", [8.0, 11.0, 18.0])
def test_in_place_of_the_rotor_of_coefficients_the_spar_has_the_same_mean(plant, wind):
    """Surge, pitch and thrust at equilibrium: the curve is that of this rotor and its controller."""
    whole = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "wind.mean_speed": wind, "sea.spectrum": "still"})
    other = whole.compile().equilibrium()
    own = plant.equilibrium({"wind.mean_speed": wind})
    for name in ("thrust", "surge", "pitch"):
        assert float(own[name]) == pytest.approx(float(other[name]), rel=5e-3)
    assert not [item.path for item in plant.dae.states if "turbine" in item.path]


def pitch_damping(model, wind):
    """Damping ratio and frequency [Hz] of the mode in which the platform pitches most, about its mean."""
    at = model.compile()
    linear = at.linearize(at.equilibrium({"wind.mean_speed": wind}), outputs=[])
    share = "platform.motion.pitch"
    mode = max((m for m in linear.modes() if np.isfinite(m.period) and m.period < 60),
               key=lambda mode: mode.participation[share])  # fmt: skip
    return mode.damping_ratio, 1 / mode.period


def test_above_rated_wind_the_thrust_drives_the_pitch_and_the_notch_takes_that_away(spar):
    """Damping ratios: 0.040 without air, -0.011 at 16 m/s, 0.046 there with the notch, 0.216 at 8 m/s.

    What the air adds goes with the slope of the thrust, dT/dU = -26.7 kN s/m at 16 and 88.3 kN s/m at 8 m/s.
    """
    plain = fw.load(str(spar))
    without, frequency = pitch_damping(fw.load(str(spar), set={"turbine.air_loads": 0}), 16.0)
    driven, _ = pitch_damping(plain, 16.0)
    notched, _ = pitch_damping(
        fw.load(str(spar), set={"turbine.rotor.notch_frequency": f"{frequency} Hz"}), 16.0
    )
    below, _ = pitch_damping(plain, 8.0)
    assert driven < 0 < without < below
    assert notched == pytest.approx(without, abs=0.3 * (without - driven))
    assert notched > 0
    curve, along = read_thrust_curve(CURVE), np.cos(np.radians(5))

    def slope(wind):
        ends = [(U, np.interp(U, curve.wind_speed, curve.thrust_coefficient)) for U in (wind - 0.5, wind + 0.5)]
        return np.diff([C * U**2 for U, C in ends])[0]

    added = (driven - without) / (below - without)
    assert added == pytest.approx(slope(16 * along) / slope(8 * along), rel=0.1)


def test_below_its_wind_the_notch_does_nothing(spar, plant):
    notched = fw.load(str(spar), set={"turbine.rotor.notch_frequency": "0.034 Hz"}).compile()
    start = {"platform.motion.pitch": np.radians(3.0)}
    runs = [at.simulate(30.0, 0.5, start=at.initial_state(start=start)) for at in (plant, notched)]
    assert np.asarray(runs[0]["pitch"]) == pytest.approx(np.asarray(runs[1]["pitch"]), abs=1e-4)


def test_a_thrust_without_air_and_without_wind(plant):
    assert float(plant.initial_state({"turbine.air_loads": 0})["thrust"]) == 0
    assert float(plant.initial_state({"wind.kind": "none"})["thrust"]) == 0
    run = plant.simulate(2.0, 0.1, events=["turbine.air_off at 1.05 s"])
    assert np.asarray(run["thrust"])[10] > 300 and np.all(np.asarray(run["thrust"])[11:] == 0)


def test_outside_of_its_curve_the_run_stops():
    with pytest.raises(SimulationError, match=r"thrust curve of rotor.*relative wind \[m/s\]"):
        moving(13.0).simulate(1.0, 0.1)


def test_a_band_pass_passes_its_frequency_alone():
    """At its centre all, at twice and half of it 1 / sqrt(1 + (3 / (4 zeta))^2), with opposite phases."""
    for factor in (1.0, 2.0, 0.5):
        model = Assembly("filter")
        model.source, model.band = Sine(amplitude=1.0, frequency=0.1 * factor), BandPass(frequency="0.1 Hz")
        model.connect(model.source.y, model.band.u)
        late = fw.load(model).compile().simulate(200.0, 0.05, solver="idas", outputs=["band.y"])
        largest = np.abs(np.asarray(late["band.y"])[np.asarray(late.time) > 100]).max()
        zeta = 0.5
        assert largest == pytest.approx(1 / np.hypot(1, (factor - 1 / factor) / (2 * zeta)), rel=2e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wind_speed_m_s,thrust\n1,2\n", "column thrust_coefficient is missing; there are wind_speed_m_s, thrust"),
        ("wind_speed_m_s,thrust_coefficient\n1,a\n", ":2: '1,a' is not a row of numbers"),
        ("wind_speed_m_s,thrust_coefficient\n1,1\n3,1\n2,1\n4,1\n", "3 m/s is followed by 2 m/s"),
        ("wind_speed_m_s,thrust_coefficient\n1,1\n3,1\n", "four wind speeds or more"),
    ],
)
def test_a_curve_that_is_none(tmp_path, text, message):
    path = tmp_path / "curve.csv"
    path.write_text(text)
    with pytest.raises(ParameterError, match=message) as caught:
        read_thrust_curve(str(path))
    assert "curve.csv" in str(caught.value)
    with pytest.raises(ParameterError, match="finite"):
        ThrustCurve([0, 1, 2, np.nan], [1, 1, 1, 1])


def test_a_notch_that_nobody_asked_for():
    with pytest.raises(ParameterError, match="notch_frequency"):
        moving(0.0, notch_width=0.3)
