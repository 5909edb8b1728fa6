"""Individual pitch control: Coleman's axes, the loop in closed form, limits; and what it takes off a rotor."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.servo import IndividualPitchController
from fowtlib.language import Component, RealInput, RealOutput, Scalar, eq, param, port
from fowtlib.language import math as m

SPEED = 1.27


class Loads(Component):
    """Root moments of n blades: a mean, parts that go with cosine and sine of the azimuth, less slope times pitch."""

    n: int = param(default=3, doc="blades")
    tilt: Scalar = param(default=1.0e6, unit="N*m", doc="part with the cosine")
    yaw: Scalar = param(default=-0.5e6, unit="N*m", doc="part with the sine")
    slope: Scalar = param(default=0.0, unit="N*m/rad", doc="moment that a pitch takes off")
    off: Scalar = param(default=1e9, unit="s", doc="time at which the control goes off")

    pitch: RealInput = port(size="n", unit="rad", doc="individual pitch")
    azimuth: RealOutput = port(unit="rad", doc="azimuth of blade 1")
    moments: RealOutput = port(size="n", unit="N*m", doc="moments")
    enabled: RealOutput = port(doc="1 until it goes off")

    def equations(self):
        psi = [self.azimuth + 2 * np.pi * k / self.n for k in range(self.n)]
        return [
            eq(self.azimuth, 0.3 + SPEED * self.time),
            [eq(self.moments[k], 8e6 + self.tilt * m.cos(a) + self.yaw * m.sin(a) - self.slope * self.pitch[k])
             for k, a in enumerate(psi)],
            eq(self.enabled, m.if_else(self.time < self.off, 1, 0)),
        ]  # fmt: skip


def simulated(end=60.0, n=3, loads=None, events=(), **control):
    model = fw.Assembly("rotor")
    model.loads, model.control = Loads(n=n, **(loads or {})), IndividualPitchController(blades=n, **control)
    model.connect(model.loads.azimuth, model.control.azimuth)
    model.connect(model.loads.enabled, model.control.enabled)
    for k in range(n):
        model.connect(model.loads.moments[k], model.control.moments[k])
        model.connect(model.control.pitch[k], model.loads.pitch[k])
    names = [*(f"control.{name}[{i}]" for name in ("moment", "cyclic") for i in (0, 1)),
             *(f"control.pitch[{k}]" for k in range(n))]  # fmt: skip
    result = fw.load(model).compile().simulate(end, 0.1, outputs=names, tolerance=1e-8, events=list(events))
    return np.asarray(result.time), [np.asarray(result[name]) for name in names]


@pytest.mark.parametrize("n", [3, 4])
def test_the_axes_of_coleman(n):
    """The parts with cosine and sine come out, without the mean; the pitches of the blades add up to none."""
    t, (tilt, yaw, first, second, *pitch) = simulated(10.0, n=n, proportional_gain=1e-8, integral_gain=0.0)
    np.testing.assert_allclose(tilt, 1e6, rtol=1e-9)
    np.testing.assert_allclose(yaw, -0.5e6, rtol=1e-9)
    for k in range(n):
        psi = 0.3 + SPEED * t + 2 * np.pi * k / n
        np.testing.assert_allclose(pitch[k], 1e-8 * (1e6 * np.cos(psi) - 0.5e6 * np.sin(psi)), atol=1e-10)
    np.testing.assert_allclose(sum(pitch), 0, atol=1e-12)


def test_the_loop_takes_the_load_off_by_an_exponential():
    """With the slope S the moment falls as exp(-K_I S t), and the pitch ends at the moment over S."""
    t, (tilt, yaw, first, second, *_) = simulated(loads={"slope": 50e6}, integral_gain=3e-9)
    fall = np.exp(-3e-9 * 50e6 * t)
    np.testing.assert_allclose(tilt, 1e6 * fall, atol=10.0)
    np.testing.assert_allclose(second, -0.5 / 50 * (1 - fall), atol=1e-7)


def test_with_a_proportional_part():
    """(1 + K_P S) M' = -K_I S M from M_0 / (1 + K_P S) on."""
    t, (tilt, *_) = simulated(loads={"slope": 50e6}, integral_gain=3e-9, proportional_gain=4e-9)
    np.testing.assert_allclose(tilt, 1e6 / 1.2 * np.exp(-0.15 / 1.2 * t), atol=10.0)


def test_limit_without_windup():
    """The limit is reached and held; the band before it takes the integral there smoothly."""
    _, (tilt, _, first, _, *pitch) = simulated(loads={"slope": 50e6}, integral_gain=3e-8, greatest_pitch=0.01)
    assert first.max() <= 0.01 + 1e-7 and first[-1] == pytest.approx(0.01, rel=1e-3)
    assert tilt[-1] == pytest.approx(0.5e6, rel=1e-3) and np.abs(pitch).max() < 0.0142


def test_it_fades_out_when_it_is_switched_off():
    t, (_, _, first, *_) = simulated(loads={"slope": 50e6, "off": 40.0}, integral_gain=3e-9, fade_time=2.0)
    late = t > 40.05
    np.testing.assert_allclose(first[late], first[399] * np.exp(-(t[late] - 40) / 2), rtol=2e-3, atol=1e-7)


@pytest.mark.parametrize("event, wrong", [
    ("sensor_1.offset at 2 s, by=1 MN*m", lambda moment: 1e6),
    ("sensor_1.drop_out at 2 s", lambda moment: -moment),
    ("sensor_1.scaled at 2 s, by=0.8", lambda moment: -0.2 * moment),
    ("sensor_1.stuck at 2 s", lambda moment: moment[20] - moment),
])  # fmt: skip
def test_a_sensor_that_fails_puts_its_error_into_the_axes(event, wrong):
    """2/n of the error, times cosine and sine of the azimuth of blade 1, comes on top of tilt and yaw moments."""
    t, (tilt, yaw, *_) = simulated(5.0, events=[f"control.{event}"], integral_gain=0.0)
    psi = 0.3 + SPEED * t
    error = wrong(8e6 + 1e6 * np.cos(psi) - 0.5e6 * np.sin(psi)) * (t > 2.05)
    late = np.abs(t - 2) > 0.05
    np.testing.assert_allclose(tilt[late], (1e6 + 2 / 3 * error * np.cos(psi))[late], rtol=1e-6, atol=1.0)
    np.testing.assert_allclose(yaw[late], (-0.5e6 + 2 / 3 * error * np.sin(psi))[late], rtol=1e-6, atol=1.0)


def test_a_sensor_that_is_restored_leaves_no_trace():
    events = ["control.sensor_2.drop_out at 2 s", "control.sensor_2.restored at 3 s"]
    t, (tilt, yaw, *_) = simulated(5.0, events=events, integral_gain=0.0)
    assert np.abs(tilt - 1e6)[(t > 2.05) & (t < 2.95)].max() > 1e6
    np.testing.assert_allclose(tilt[t > 3.05], 1e6, rtol=1e-9)
    np.testing.assert_allclose(yaw[t > 3.05], -0.5e6, rtol=1e-9)


def test_it_takes_the_shear_off_the_blades_of_a_turbine():
    """Rigid blades by blade elements in sheared wind: the once-per-turn part of the root moment goes."""
    model = fw.load("oc3_spar_rigid_bem")
    root, turbine = model.root, model.root.turbine
    root.individual = IndividualPitchController(integral_gain=0.0)
    root.connect(turbine.azimuth, root.individual.azimuth)
    for k in range(3):
        root.connect(turbine.assembly.rotor_blades[k].flapwise_moment, root.individual.moments[k])
        root.connect(root.individual.pitch[k], turbine.assembly.individual_pitch[k])
    plant, found = model.compile(), []
    moment = "turbine.assembly.blade_1.flapwise_moment"
    for gain in (0.0, 3e-9):
        parameters = {"wind.kind": "steady", "wind.mean_speed": 18.0, "wind.shear_exponent": 0.14,
                      "sea.spectrum": "still", "individual.integral_gain": gain}  # fmt: skip
        result = plant.simulate(60, 0.1, solver="fixed", parameters=parameters, outputs=[moment])
        t, values = np.asarray(result.time)[350:], np.asarray(result[moment])[350:]
        turns = np.column_stack([np.ones_like(t), t, *(f(1.267 * t) for f in (np.cos, np.sin))])
        found.append(np.hypot(*np.linalg.lstsq(turns, values, rcond=None)[0][2:]))
    assert found[0] > 0.8e6 and found[1] < 0.15 * found[0]
