"""Aerodynamic inertia and damping: closed form, forced oscillation, any support, and the words of mistakes."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import CoefficientRotor, read_coefficients
from fowtlib.components.environment.wind import SteadyWind
from fowtlib.components.mechanics import ForcedOscillation, RigidBody, World
from fowtlib.components.servo import BaselineController
from fowtlib.components.turbine import RotorNacelle
from fowtlib.language import Assembly
from fowtlib.language.errors import ModelError

WHOLE = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients_whole.csv")
PERIODS = np.array([20.0, 31.3, 50.0, 100.0, 181.8])
RADIUS, PRECONE, RATIO, ROTOR, GENERATOR = 63.0, np.radians(2.5), 97.0, 38759227.0, 534.116
CORNER = 2 * np.pi * 0.25


@functools.cache
def moved():
    """An NREL 5 MW turbine whose hub is moved along a shaft without tilt."""
    model = Assembly("moved turbine")
    model.world, model.wind, model.mount = World(), SteadyWind(mean_speed=16.0), ForcedOscillation(r=(0, 0, 90))
    model.turbine = RotorNacelle(
        mass=350e3, gear_ratio=RATIO, generator_inertia=GENERATOR, generator_efficiency=0.944,
        rotor=CoefficientRotor(coefficients=WHOLE, radius=RADIUS, precone=PRECONE, inertia=ROTOR, filtered=False),
        control=BaselineController(proportional_gain=0.006275604, integral_gain=0.0008965149,
                                   region_3="constant_torque"),
    )  # fmt: skip
    model.connect(model.mount.frame, model.turbine.frame)
    return fw.Model(model, outputs={"thrust": "turbine.thrust", "pitch": "turbine.blade_pitch"}).compile()


def closed_form(wind, omega):
    """X(omega) of the hub's displacement, for a PI controller behind a filter and constant torque, (20) and (25)."""
    state = fw.mean_state(moved(), {"wind.mean_speed": wind})
    speed, pitch = float(state["turbine.rotor.w"]), float(state["turbine.blade_pitch"])
    table, R = read_coefficients(WHOLE), RADIUS * np.cos(PRECONE)

    def loads(v, w, theta):
        C_t, C_q = table(w * RADIUS / v, theta)
        return 0.5 * 1.225 * np.pi * R**2 * v**2 * np.array([C_t, R * C_q])

    def slope(step, h):
        up, down = (loads(*(np.array([wind, speed, pitch]) + s * h * np.array(step))) for s in (1, -1))
        return (up - down) / (2 * h)

    (T_v, Q_v), (T_w, Q_w), (T_p, Q_p) = slope((1, 0, 0), 1e-3), slope((0, 1, 0), 1e-5), slope((0, 0, 1), 1e-5)
    s, share = 1j * omega, pitch / np.radians(6.302336)  # half the gain at 6.302336 deg, NREL/TP-500-38060
    scheduled = 1 / (1 + 2 * share + 0.05 * s * (1 + share))  # with the gain on the integral too, and 0.05 s of delay
    control = (0.006275604 * s + 0.0008965149) * RATIO * scheduled / (1 + s / CORNER)  # pitch per azimuth
    inertia = ROTOR + RATIO**2 * GENERATOR
    azimuth = s * Q_v / (inertia * omega**2 + Q_w * s + control * Q_p)
    return s * T_v - (T_w * s + T_p * control) * azimuth


@pytest.mark.parametrize("wind", [14.0, 18.0, 24.0])
def test_coefficients_are_those_of_the_closed_form(wind):
    omega = 2 * np.pi / PERIODS
    found = fw.aerodynamic_coefficients(moved(), 1 / PERIODS, parameters={"wind.mean_speed": wind})
    X = closed_form(wind, omega)
    assert found.damping == pytest.approx(X.imag / omega, rel=2e-3, abs=20)
    assert found.inertia == pytest.approx(-X.real / omega**2, rel=2e-3, abs=200)


@pytest.mark.parametrize("wind", [8.0, 16.0])
def test_a_small_forced_oscillation_gives_the_same(wind):
    frequency = 1 / np.array([30.0, 60.0])
    calm = {"wind.mean_speed": wind}
    linear = fw.aerodynamic_coefficients(moved(), frequency, parameters=calm)
    forced = fw.forced_oscillation(moved(), frequency, parameters=calm, speed_amplitude=0.05, solver="fixed", step=0.05)
    assert forced.transfer == pytest.approx(linear.transfer, rel=0.01, abs=0.01 * np.abs(linear.transfer).max())
    assert forced.method == "forced oscillation"


def test_a_floating_hub_has_them_whatever_carries_it():
    frequency, given = 1 / np.array([20.0, 50.0, 100.0]), {"wind.mean_speed": 16.0, "wind.kind": "steady"}
    spar = fw.load("oc3_spar_rigid", set={"turbine.rotor.filtered": False}).compile()
    floating = fw.aerodynamic_coefficients(spar, frequency, parameters=given)
    lean = np.radians(5) + float(fw.mean_state(spar, {**given, "sea.spectrum": "still"})["platform.motion.pitch"])
    alone = fw.aerodynamic_coefficients(moved(), frequency,
                                        parameters={"wind.mean_speed": 16.0, "turbine.rotor.tilt": lean})  # fmt: skip
    assert floating.transfer == pytest.approx(alone.transfer, rel=1e-3, abs=1e-3 * np.abs(alone.transfer).max())


def test_tables_and_matrices(tmp_path):
    found = fw.aerodynamic_coefficients(moved(), 1 / PERIODS)
    added, damping = found.matrices(90.0)
    assert added.shape == damping.shape == (5, 3, 3)
    assert damping[:, 2, 2] == pytest.approx(8100 * found.damping)
    assert not added[:, 1].any()
    assert found.dataset["damping"].attrs["units"] == "N s/m"
    found.save(tmp_path / "coefficients.csv")
    assert np.loadtxt(tmp_path / "coefficients.csv", delimiter=",", skiprows=1)[:, 2] == pytest.approx(found.damping)
    found.plot(tmp_path / "coefficients.png", beside=[found])
    assert (tmp_path / "coefficients.png").stat().st_size > 1000
    assert "turbine" in repr(found)


def test_mistakes_are_named():
    with pytest.raises(ModelError, match="'rotor' is not a turbine"):
        fw.aerodynamic_coefficients(moved(), [0.05], turbine="rotor")
    with pytest.raises(ModelError, match="positive numbers in Hz"):
        fw.aerodynamic_coefficients(moved(), [0.0])
    with pytest.raises(ModelError, match="no ForcedOscillation"):
        fw.forced_oscillation(fw.load("oc3_spar_rigid"), [0.05])
    hull = Assembly("no turbine")
    hull.world = World()
    hull.mount, hull.body = ForcedOscillation(), RigidBody(mass=1.0, inertia=np.eye(3))
    hull.connect(hull.mount.frame, hull.body.frame_a)
    with pytest.raises(ModelError, match="no turbine"):
        fw.aerodynamic_coefficients(fw.Model(hull), [0.05])
