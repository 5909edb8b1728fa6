"""Every signal block against scipy.signal or a closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline
from scipy.linalg import expm

import fowtlib as fw
from fowtlib.components.blocks import (
    PI,
    ButterworthLowPass,
    Constant,
    Demux,
    Derivative,
    DiscreteTransferFunction,
    FirstOrder,
    Gain,
    Integrator,
    Limiter,
    Mux,
    Product,
    Ramp,
    SampledPI,
    Sampler,
    SecondOrderActuator,
    Sine,
    SlewRateLimiter,
    StateSpace,
    Step,
    Sum,
    Table1D,
    Table2D,
    TimeTable,
    TransferFunction,
)
from fowtlib.language.errors import ModelError, ParameterError

STEP = 0.01


def run(t_end=4.0, output_step=STEP, tolerance=1e-9, connect=(), **blocks):
    """Simulate blocks by name; `connect` lists pairs of ports as "block.port" or "block.port[i]"."""
    model = fw.Assembly("blocks")
    for name, block in blocks.items():
        model.add(name, block)

    def port(text):
        block, _, name = text.partition(".")
        name, _, index = name.partition("[")
        found = getattr(model.parts[block], name)
        return found[int(index.rstrip("]"))] if index else found

    for a, b in connect:
        model.connect(port(a), port(b))
    return fw.load(model).compile().simulate(t_end, output_step=output_step, tolerance=tolerance)


def values(result, path):
    return np.asarray(result[path])


def response(block, t_end=4.0, **source):
    """Output of a block u -> y for a sine of 0.7 Hz (or the given source), with time and input."""
    drive = source.pop("drive", None) or Sine(amplitude=1.3, frequency=0.7, **source)
    result = run(t_end, source=drive, block=block, connect=[("source.y", "block.u")])
    time = np.asarray(result["block.y"].time)
    return time, values(result, "source.y"), values(result, "block.y")


def linear(system, time, sines=((1.3, 0.7, 0.0),), x0=None):
    """Exact output of a linear system whose inputs are sines (amplitude, frequency, phase), by expm."""
    A, B, C, D = system if len(system) == 4 else signal.tf2ss(*system)
    n = len(A)
    full = np.zeros((n + 2 * len(sines), n + 2 * len(sines)))  # the states, and sine and cosine of each input
    full[:n, :n] = A
    state = np.concatenate([np.zeros(n) if x0 is None else x0, *([np.sin(p), np.cos(p)] for _, _, p in sines)])
    for i, (amplitude, frequency, _) in enumerate(sines):
        full[:n, n + 2 * i] = amplitude * B[:, i]
        full[n + 2 * i, n + 2 * i + 1] = 2 * np.pi * frequency
        full[n + 2 * i + 1, n + 2 * i] = -2 * np.pi * frequency
    out = np.hstack([C, np.zeros((len(C), 2 * len(sines)))])
    out[:, n::2] = D * [amplitude for amplitude, _, _ in sines]
    step, outputs = expm(full * STEP), []
    for _ in time:
        outputs.append(out @ state)
        state = step @ state
    return np.squeeze(outputs)


# --- without memory -----------------------------------------------------------------------------------------------


def test_gain_sum_product():
    result = run(
        1.0,
        a=Sine(frequency=1.0),
        b=Sine(frequency=0.5, offset=2.0),
        gain=Gain(gain=-2.5),
        sum=Sum(n=3, gains=(1, -2, 0.5)),
        product=Product(n=3),
        connect=[
            ("a.y", "gain.u"),
            *((f"{s}.y", f"{block}.u[{i}]") for block in ("sum", "product") for i, s in enumerate(("a", "b", "gain"))),
        ],
    )
    a, b, gain = (values(result, f"{name}.y") for name in ("a", "b", "gain"))
    assert np.allclose(gain, -2.5 * a)
    assert np.allclose(values(result, "sum.y"), a - 2 * b + 0.5 * gain)
    assert np.allclose(values(result, "product.y"), a * b * gain)


def test_mux_and_demux():
    result = run(
        1.0,
        a=Sine(frequency=1.0),
        b=Constant(value=3.0),
        mux=Mux(n=2),
        demux=Demux(n=2),
        connect=[("a.y", "mux.u[0]"), ("b.y", "mux.u[1]"), ("mux.y", "demux.u")],
    )
    assert values(result, "mux.y").shape[1] == 2
    assert np.allclose(values(result, "demux.y[0]"), values(result, "a.y"))
    assert np.allclose(values(result, "demux.y[1]"), 3.0)


def test_limiter_exact_and_smooth():
    time, u, y = response(Limiter(lower=-0.5, upper=1.0))
    assert np.allclose(y, np.clip(u, -0.5, 1.0), atol=1e-12)
    rounding = 0.05
    time, u, y = response(Limiter(lower=-0.5, upper=1.0, rounding=rounding))
    assert np.max(np.abs(y - np.clip(u, -0.5, 1.0))) <= rounding
    assert np.max(np.abs(y - np.clip(u, -0.5, 1.0))) > 0.1 * rounding


# --- sources ------------------------------------------------------------------------------------------------------


def test_sources():
    result = run(
        2.0,
        constant=Constant(value=(1.0, -2.0)),
        sine=Sine(amplitude=2.0, frequency=0.5, phase=0.3, offset=-1.0),
        step=Step(height=3.0, start_time=0.515, offset=1.0),
        late=Step(start_time=-1.0, height=2.0),
        ramp=Ramp(height=-2.0, duration=0.5, start_time=1.0, offset=1.0),
    )
    time = np.asarray(result["sine.y"].time)
    assert np.allclose(values(result, "constant.y"), [1.0, -2.0])
    assert np.allclose(values(result, "sine.y"), -1 + 2 * np.sin(np.pi * time + 0.3))
    assert np.allclose(values(result, "step.y"), np.where(time > 0.515, 4.0, 1.0))
    assert np.allclose(values(result, "late.y"), 2.0)
    assert np.allclose(values(result, "ramp.y"), 1 - 2 * np.clip((time - 1.0) / 0.5, 0, 1))


def test_time_table_is_a_spline_and_repeats():
    step = 0.1
    n = 20
    samples = np.sin(2 * np.pi * np.arange(n) / n) + 0.2 * np.cos(6 * np.pi * np.arange(n) / n)
    result = run(5.0, table=TimeTable(values=samples, step=step, periodic=True))
    time = np.asarray(result["table.y"].time)
    spline = CubicSpline(step * np.arange(n + 1), np.append(samples, samples[0]), bc_type="periodic")
    assert np.max(np.abs(values(result, "table.y") - spline(time % (n * step)))) < 1e-9


def test_time_table_that_ends_too_early_stops_the_run():
    with pytest.raises(ModelError, match="table"):
        run(5.0, table=TimeTable(values=np.arange(11.0), step=0.1))


# --- linear, continuous -------------------------------------------------------------------------------------------


def test_integrator_and_derivative():
    time, u, y = response(Integrator(gain=2.0, y_start=0.5))
    w = 2 * np.pi * 0.7
    assert np.allclose(y, 0.5 + 2.0 * 1.3 / w * (1 - np.cos(w * time)), atol=1e-7)
    time, u, y = response(Derivative(gain=2.0, time_constant=0.05))
    assert np.allclose(y, linear(([2.0, 0.0], [0.05, 1.0]), time), atol=1e-6)


def test_first_order():
    time, u, y = response(FirstOrder(gain=3.0, time_constant=0.4, initialization="value", y_start=1.0))
    assert np.allclose(y, linear(([3.0], [0.4, 1.0]), time) + np.exp(-time / 0.4), atol=1e-6)


@pytest.mark.parametrize("damping", [0.02, 0.7, 1.3])
def test_second_order_actuator(damping):
    time, u, y = response(SecondOrderActuator(natural_frequency=3.0, damping_ratio=damping))
    w0 = 2 * np.pi * 3.0
    assert np.allclose(y, linear(([w0**2], [1.0, 2 * damping * w0, w0**2]), time), atol=1e-6)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 8])
def test_butterworth_is_the_one_of_scipy(order):
    time, u, y = response(ButterworthLowPass(order=order, cutoff_frequency=0.9))
    assert np.allclose(y, linear(signal.butter(order, 2 * np.pi * 0.9, analog=True), time), atol=1e-6)


@pytest.mark.parametrize(
    "block",
    [
        FirstOrder(time_constant=0.4),
        SecondOrderActuator(natural_frequency=1.0, damping_ratio=0.5),
        ButterworthLowPass(order=3, cutoff_frequency=0.5),
        SlewRateLimiter(rising_rate=1.0),
    ],
    ids=lambda block: type(block).__name__,
)
def test_filters_start_at_rest(block):
    _, _, y = response(block, drive=Constant(value=7.5))
    assert np.allclose(y, 7.5, atol=1e-9)


def test_state_space_with_several_inputs_and_outputs():
    A, B = np.array([[-0.5, 2.0], [-2.0, -0.1]]), np.array([[1.0, 0.0], [0.3, -1.0]])
    C, D = np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]]), np.array([[0.0, 0.1], [0.0, 0.0], [-0.4, 0.0]])
    x0 = np.array([0.2, -0.3])
    result = run(
        a=Sine(frequency=0.7),
        b=Sine(frequency=0.3, phase=1.0),
        mux=Mux(n=2),
        block=StateSpace(A=A, B=B, C=C, D=D, x_start=x0),
        connect=[("a.y", "mux.u[0]"), ("b.y", "mux.u[1]"), ("mux.y", "block.u")],
    )
    time = np.asarray(result["block.y"].time)
    exact = linear((A, B, C, D), time, [(1.0, 0.7, 0.0), (1.0, 0.3, 1.0)], x0)
    assert np.allclose(values(result, "block.y"), exact, atol=1e-6)


def test_state_space_refuses_matrices_that_do_not_fit():
    with pytest.raises(ParameterError, match=r"StateSpace\.C has the shape \(1, 3\); \(1, 2\) fits the others"):
        StateSpace(A=np.eye(2), B=[[1.0], [0.0]], C=[[1.0, 0.0, 0.0]])


def test_transfer_function():
    numerator, denominator = [0.5, 1.0, 3.0], [1.0, 0.8, 4.0, 1.5]
    time, u, y = response(TransferFunction(numerator=numerator, denominator=denominator))
    assert np.allclose(y, linear((numerator, denominator), time), atol=1e-6)
    time, u, y = response(TransferFunction(numerator=[2.0, 1.0, 3.0], denominator=[2.0, 0.8, 4.0]))
    assert np.allclose(y, linear(([2.0, 1.0, 3.0], [2.0, 0.8, 4.0]), time), atol=1e-6)


@pytest.mark.parametrize(
    "numerator, denominator", [([1.0, 0.0], [1.0]), ([1.0, 0.0, 0.0], [1.0, 1.0]), ([1.0], [0.0, 1.0])]
)
def test_transfer_function_must_be_proper(numerator, denominator):
    with pytest.raises(ParameterError, match="is not proper"):
        fw.load(_driven(TransferFunction(numerator=numerator, denominator=denominator))).compile()


def _driven(block):
    model = fw.Assembly("driven block")
    model.source, model.block = Sine(frequency=0.7), block
    model.connect(model.source.y, model.block.u)
    return model


def test_slew_rate_limiter():
    rising, falling, lag = 2.0, 1.0, 0.02
    time, u, y = response(SlewRateLimiter(rising_rate=rising, falling_rate=falling, time_constant=lag))
    rate = np.diff(y) / STEP
    assert rate.max() < rising + 1e-3 and rate.min() > -falling - 1e-3
    assert rate.max() > rising - 1e-2 and rate.min() < -falling + 1e-2
    # slow enough an input comes through, late by the lag
    slow = Sine(amplitude=0.2, frequency=0.5)
    time, u, y = response(SlewRateLimiter(rising_rate=rising, falling_rate=falling, time_constant=lag), drive=slow)
    exact = linear(([1.0], [lag, 1.0]), time, [(0.2, 0.5, 0.0)])
    assert np.allclose(y, exact, atol=1e-6)


def test_slew_rate_limiter_after_a_step():
    lag = 0.05
    limiter = SlewRateLimiter(rising_rate=0.5, time_constant=lag)
    time, _, y = response(limiter, drive=Step(height=1.0, start_time=0.5))
    reached = 0.5 + (1.0 - 0.5 * lag) / 0.5  # the rate stays at its limit until u - y = rate * lag
    settling = 1 - 0.5 * lag * np.exp(-np.maximum(time - reached, 0.0) / lag)
    exact = np.where(time < reached, np.clip(0.5 * (time - 0.5), 0, None), settling)
    assert np.allclose(y, exact, atol=1e-6)


# --- controllers --------------------------------------------------------------------------------------------------


def test_pi_without_limits_is_linear():
    time, u, y = response(PI(proportional_gain=2.0, integral_gain=0.5, integral_start=0.3))
    assert np.allclose(y, 0.3 + linear(([2.0, 0.5], [1.0, 0.0]), time), atol=1e-6)


def test_pi_with_a_constant_gain_is_the_same_on_integrand_and_integral():
    for kind in ("integrand", "integral"):
        result = run(
            source=Sine(frequency=0.7),
            gain=Constant(value=3.0),
            block=PI(proportional_gain=2.0, integral_gain=0.5, gain_on=kind),
            connect=[("source.y", "block.u"), ("gain.y", "block.gain")],
        )
        time = np.asarray(result["block.y"].time)
        exact = linear(([6.0, 1.5], [1.0, 0.0]), time, [(1.0, 0.7, 0.0)])
        assert np.allclose(values(result, "block.y"), exact, atol=1e-6)


def test_pi_gain_schedule_moves_the_output_only_on_the_integral():
    """With zero error and a moving gain: the integrand form stays, the integral form follows the gain."""
    for kind, follows in (("integrand", False), ("integral", True)):
        result = run(
            source=Constant(value=0.0),
            gain=Sine(frequency=0.7, offset=2.0),
            block=PI(proportional_gain=2.0, integral_gain=0.5, integral_start=1.5, gain_on=kind),
            connect=[("source.y", "block.u"), ("gain.y", "block.gain")],
        )
        expected = 1.5 * values(result, "gain.y") if follows else 1.5
        assert np.allclose(values(result, "block.y"), expected, atol=1e-9)


def test_pi_does_not_wind_up():
    """After ten seconds of a large error the output leaves the limit as soon as the error changes sign."""
    kp, ki, tracking = 1.0, 2.0, 0.1
    controller = PI(proportional_gain=kp, integral_gain=ki, lower=-1.0, upper=1.0, tracking_time=tracking)
    time, u, y = response(controller, t_end=12.0, drive=Step(height=-2.2, offset=2.0, start_time=10.0))
    assert np.allclose(y[(time > 1) & (time < 10)], 1.0)
    # at the limit the integral rests where k_i u + (1 - k_p u - x) / tracking = 0: x = 1 - k_p u + tracking k_i u
    x = 1.0 - kp * 2.0 + tracking * ki * 2.0
    after = (time > 10.0) & (time < 10.45)  # before the other limit
    assert np.allclose(y[after], x - kp * 0.2 - ki * 0.2 * (time[after] - 10.0), atol=1e-6)


# --- sampled ------------------------------------------------------------------------------------------------------


def test_sampler_holds():
    period = 0.25
    time, u, y = response(Sampler(period=period))
    middle = np.isclose((time / period) % 1.0, 0.52)
    samples = 1.3 * np.sin(2 * np.pi * 0.7 * np.floor(time / period) * period)
    assert np.count_nonzero(middle) > 10
    assert np.allclose(y[middle], samples[middle], atol=1e-8)


def test_discrete_transfer_function_is_lfilter():
    period = 0.1
    b, a = signal.butter(3, 0.3)
    time, u, y = response(DiscreteTransferFunction(numerator=b, denominator=a, period=period))
    samples = 1.3 * np.sin(2 * np.pi * 0.7 * period * np.arange(41))
    filtered = signal.lfilter(b, a, samples)
    assert np.allclose(y[5::10], filtered[:40], atol=1e-8)  # in the middle of each interval


def test_sampled_pi_follows_its_recursion_and_its_limits():
    period, kp, ki = 0.1, 0.4, 1.5
    block = SampledPI(proportional_gain=kp, integral_gain=ki, lower=-0.2, upper=0.3, period=period)
    time, u, y = response(block)
    integral, outputs = 0.0, []
    for k in range(40):
        error = 1.3 * np.sin(2 * np.pi * 0.7 * period * k)
        integral = np.clip(integral + period * ki * error, -0.2, 0.3)
        outputs.append(np.clip(kp * error + integral, -0.2, 0.3))
    assert np.allclose(y[5::10], outputs, atol=1e-8)


# --- tables -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("smoothness, spline", [("c2", lambda x, y: CubicSpline(x, y)), ("c1", PchipInterpolator)])
def test_table_of_one_argument(smoothness, spline):
    x = np.array([-1.5, -0.7, -0.2, 0.1, 0.5, 1.0, 1.5])
    y = np.array([0.0, 0.1, 1.0, 0.9, 1.4, 1.4, 2.0])
    _, u, out = response(Table1D(x=x, values=y, smoothness=smoothness))
    assert np.allclose(out, spline(x, y)(u), atol=1e-9)


def test_table_of_two_arguments():
    x, y = np.linspace(-2, 2, 9), np.linspace(-1, 3, 7)
    table = np.sin(x)[:, None] * np.cos(y)[None, :] + 0.1 * x[:, None]
    result = run(
        a=Sine(amplitude=1.5, frequency=0.7),
        b=Sine(amplitude=1.2, frequency=0.4, offset=1.0),
        block=Table2D(x=x, y=y, values=table),
        connect=[("a.y", "block.u"), ("b.y", "block.v")],
    )
    exact = RectBivariateSpline(x, y, table).ev(values(result, "a.y"), values(result, "b.y"))
    assert np.allclose(values(result, "block.z"), exact, atol=1e-9)


def test_a_table_left_at_its_edge_stops_the_run():
    with pytest.raises(ModelError, match="block"):
        response(Table1D(x=[-1.0, -0.5, 0.5, 1.0], values=[0.0, 1.0, 2.0, 3.0]))


@pytest.mark.parametrize(
    "block",
    [
        FirstOrder(time_constant=1.0, y_start=2.0),
        SecondOrderActuator(natural_frequency=1.0, damping_ratio=0.7, y_start=2.0),
        ButterworthLowPass(cutoff_frequency=1.0, y_start=2.0),
        SlewRateLimiter(rising_rate=1.0, y_start=2.0),
    ],
    ids=lambda block: type(block).__name__,
)
def test_a_start_value_beside_a_steady_start_is_refused(block):
    with pytest.raises(fw.ModelError) as error:
        response(block)
    assert str(error.value).endswith(
        ".y_start is given and would do nothing, because initialization is steady (value starts at y_start); "
        "leave one of them out, or change it."
    )
