"""Systems of other fields with analytic solutions: drive trains, oscillators, events, sampling, electrical circuits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import fowtlib as fw
from fowtlib.components.blocks import Constant, SampledPI, Sine, Sum, TransferFunction
from fowtlib.components.mechanics import (
    AngleSource,
    FixedTranslation,
    IdealGear,
    Inertia,
    PointMass,
    Prismatic,
    SpeedSensor,
    SpringDamper,
    TorqueSource,
    World,
)
from fowtlib.language import (
    Component,
    Connector,
    Scalar,
    assert_,
    assign,
    der,
    eq,
    flow,
    initial,
    param,
    part,
    port,
    potential,
    reinit,
    var,
    when,
)


def simulate(model, t_end=10.0, output_step=0.05, tolerance=1e-10):
    return fw.load(model).compile().simulate(t_end, output_step=output_step, tolerance=tolerance)


def values(result, path):
    return np.asarray(result[path])


def times(result, path):
    return np.asarray(result[path].time)


def linear_response(A, x0, time):
    """x(t) of x' = A x at the given times."""
    return np.stack([expm(A * t) @ x0 for t in time])


# --- drive trains: index reduction -------------------------------------------------------------------------------


def gear_train(j1=3.0, j2=0.02, n=12.0, torque=5.0):
    """Slow shaft driven by a torque, geared up to a fast shaft: one degree of freedom, two inertias."""
    model = fw.Assembly("gear train")
    model.slow, model.fast = Inertia(inertia=j1), Inertia(inertia=j2)
    model.gear = IdealGear(ratio=n)
    model.motor, model.command = TorqueSource(), Constant(value=torque)
    model.sensor = SpeedSensor()
    model.connect(model.command.y, model.motor.torque)
    model.connect(model.motor.flange, model.slow.flange_a)
    model.connect(model.slow.flange_b, model.gear.flange_b)
    model.connect(model.gear.flange_a, model.fast.flange_a)
    model.connect(model.fast.flange_b, model.sensor.flange)
    return model


def test_gear_train_has_one_degree_of_freedom():
    j1, j2, n, torque = 3.0, 0.02, 12.0, 5.0
    plant = fw.load(gear_train(j1, j2, n, torque)).compile()
    assert len(plant.initial_state().x) == 2
    result = plant.simulate(4.0, output_step=0.1, tolerance=1e-10)
    time = times(result, "slow.w")
    acceleration = torque / (j1 + n**2 * j2)
    assert np.allclose(values(result, "slow.w"), acceleration * time, atol=1e-8)
    assert np.allclose(values(result, "fast.phi"), n * acceleration * time**2 / 2, atol=1e-7)
    assert np.allclose(values(result, "sensor.w"), n * acceleration * time, atol=1e-7)
    assert np.allclose(values(result, "fast.flange_a.tau"), j2 * n * acceleration, atol=1e-8)


@pytest.mark.parametrize("names", [("first", "second"), ("second", "first")])
def test_a_given_start_counts_more_than_a_default(names):
    """Two wheels on one shaft: the speed given to one of them is the speed of both, in any order of the parts."""
    wheels = {"first": Inertia(inertia=1.0, w_start=2.0), "second": Inertia(inertia=3.0)}
    model = fw.Assembly("shaft")
    for name in names:
        model.add(name, wheels[name])
    model.connect(wheels["first"].flange_b, wheels["second"].flange_a)
    assert fw.load(model).compile().initial_state()["second.w"] == 2.0


def test_a_prescribed_angle_gives_the_torque_it_needs():
    """The derivatives of the input signal are taken by the kernel: tau = J d2(phi)/dt2."""
    model = fw.Assembly("crank")
    model.angle, model.source, model.wheel = Sine(amplitude=0.3, frequency=0.5), AngleSource(), Inertia(inertia=2.0)
    model.connect(model.angle.y, model.source.phi)
    model.connect(model.source.flange, model.wheel.flange_a)
    result = simulate(model, t_end=4.0)
    w = 2 * np.pi * 0.5
    time = times(result, "wheel.w")
    assert np.allclose(values(result, "wheel.w"), 0.3 * w * np.cos(w * time), atol=1e-9)
    assert np.allclose(values(result, "wheel.flange_a.tau"), -2.0 * 0.3 * w**2 * np.sin(w * time), atol=1e-8)


# --- driven oscillator --------------------------------------------------------------------------------------------


def test_driven_two_mass_oscillator():
    """Two masses on slides, three springs, a sinusoidal force on the first: exact by the exponential of the system."""
    m1, m2, k1, k2, k3, c, gap, force, frequency = 2.0, 1.5, 40.0, 25.0, 30.0, 0.8, 1.0, 3.0, 0.6
    model = fw.Assembly("two masses")
    model.world = World()
    model.slide_1, model.slide_2 = Prismatic(n=(1, 0, 0), s_start=gap + 0.2), Prismatic(n=(1, 0, 0), s_start=2 * gap)
    model.mass_1, model.mass_2 = PointMass(mass=m1), PointMass(mass=m2)
    model.end = FixedTranslation(r=(3 * gap, 0, 0))
    model.spring_1 = SpringDamper(stiffness=k1, damping=c, natural_length=gap)
    model.spring_2 = SpringDamper(stiffness=k2, damping=c, natural_length=gap)
    model.spring_3 = SpringDamper(stiffness=k3, damping=c, natural_length=gap)
    model.shaker = Sine(amplitude=force, frequency=frequency)
    ground, one, two = model.world.frame, model.mass_1.frame_a, model.mass_2.frame_a
    for slide, mass in ((model.slide_1, one), (model.slide_2, two)):
        model.connect(ground, slide.frame_a)
        model.connect(slide.frame_b, mass)
    model.connect(ground, model.end.frame_a)
    places = (ground, one, two, model.end.frame_b)
    for i, spring in enumerate((model.spring_1, model.spring_2, model.spring_3)):
        model.connect(places[i], spring.frame_a)
        model.connect(places[i + 1], spring.frame_b)
    model.connect(model.shaker.y, model.slide_1.force)
    result = simulate(model)

    w = 2 * np.pi * frequency
    A = np.zeros((6, 6))  # displacements, velocities, and the sine and cosine of the force
    A[0, 2] = A[1, 3] = 1
    A[2] = [-(k1 + k2) / m1, k2 / m1, -2 * c / m1, c / m1, force / m1, 0]
    A[3] = [k2 / m2, -(k2 + k3) / m2, c / m2, -2 * c / m2, 0, 0]
    A[4, 5], A[5, 4] = w, -w
    exact = linear_response(A, np.array([0.2, 0, 0, 0, 0, 1.0]), times(result, "slide_1.s"))
    assert np.max(np.abs(values(result, "slide_1.s") - gap - exact[:, 0])) < 1e-7
    assert np.max(np.abs(values(result, "slide_2.s") - 2 * gap - exact[:, 1])) < 1e-7
    assert np.max(np.abs(values(result, "slide_2.v") - exact[:, 3])) < 1e-6


# --- state events -------------------------------------------------------------------------------------------------


class Ball(Component):
    """A ball that falls and bounces: v jumps to -restitution v where the height becomes negative."""

    gravity: Scalar = param(default=9.81, unit="m/s^2", doc="acceleration of gravity")
    restitution: Scalar = param(default=0.8, doc="speed after an impact over speed before it")
    height_start: Scalar = param(default=2.0, unit="m", doc="initial height")

    height: Scalar = var(unit="m", start=height_start, state="always", doc="height over the floor")
    v: Scalar = var(unit="m/s", state="always", doc="upward velocity")
    impacts: Scalar = var(discrete=True, doc="number of impacts so far")
    last: Scalar = var(unit="s", discrete=True, doc="time of the last impact")

    def equations(self):
        return [
            eq(der(self.height), self.v),
            eq(der(self.v), -self.gravity),
            when(
                self.height < 0,
                reinit(self.v, -self.restitution * self.v),
                assign(self.impacts, self.impacts + 1),
                assign(self.last, self.time),
            ),
        ]


def test_bouncing_ball_hits_the_floor_on_time():
    model = fw.Assembly("ball")
    model.ball = Ball()
    result = simulate(model, t_end=4.8, output_step=0.01)
    g, e, h0 = 9.81, 0.8, 2.0
    fall = np.sqrt(2 * h0 / g)
    flights = 2 * fall * e ** np.arange(1, 12)
    impacts = fall + np.concatenate([[0.0], np.cumsum(flights)])
    time = times(result, "ball.height")

    last, count = values(result, "ball.last"), values(result, "ball.impacts")
    for n in range(1, int(count[-1]) + 1):
        assert last[count == n][0] == pytest.approx(impacts[n - 1], abs=1e-6)
    assert count[-1] == np.sum(impacts <= time[-1]) == 8

    def exact(t):
        if t < impacts[0]:
            return h0 - g * t**2 / 2
        n = np.searchsorted(impacts, t, side="right") - 1
        since, speed = t - impacts[n], g * fall * e ** (n + 1)
        return speed * since - g * since**2 / 2

    assert np.max(np.abs(values(result, "ball.height") - [exact(t) for t in time])) < 1e-6


class Thermostat(Component):
    """A room with a heater that switches on below one temperature and off above another one."""

    time_constant: Scalar = param(default=50.0, unit="s", doc="time constant of the room")
    low: Scalar = param(default=19.0, doc="temperature at which the heater switches on")
    high: Scalar = param(default=21.0, doc="temperature at which the heater switches off")

    temperature: Scalar = var(start=15.0, state="always", doc="temperature of the room")
    on: Scalar = var(discrete=True, start=1.0, doc="1 while the heater is on")

    def equations(self):
        return [
            eq(self.time_constant * der(self.temperature), 30.0 * self.on - self.temperature),
            when(self.temperature > self.high, assign(self.on, 0.0)),
            when(self.temperature < self.low, assign(self.on, 1.0)),
            assert_(self.temperature < 22, "too hot"),
        ]


def test_thermostat_switches_with_hysteresis():
    model = fw.Assembly("thermostat")
    model.room = Thermostat()
    result = simulate(model, t_end=100.0, output_step=0.1)
    heating = 50.0 * np.log((30.0 - 15.0) / (30.0 - 21.0))
    cooling, again = 50.0 * np.log(21.0 / 19.0), 50.0 * np.log((30.0 - 19.0) / (30.0 - 21.0))
    switches = heating + np.concatenate([[0.0], np.cumsum([cooling, again] * 10)])
    time, on = times(result, "room.on"), values(result, "room.on")
    flips = time[1:][np.diff(on) != 0]
    expected = switches[switches < 100.0]
    assert len(flips) == len(expected)
    assert np.max(np.abs(flips - expected)) < 0.1001  # the output step
    assert values(result, "room.temperature").max() < 21.0 + 1e-6


# --- sampled control ----------------------------------------------------------------------------------------------


def sampled_loop(period=0.2, kp=0.8, ki=0.6):
    model = fw.Assembly("sampled PI loop")
    model.setpoint = Constant(value=1.0)
    model.error = Sum(gains=(1, -1))
    model.control = SampledPI(proportional_gain=kp, integral_gain=ki, period=period)
    model.plant = TransferFunction(numerator=[1.0], denominator=[1.0, 1.0, 0.5])
    model.connect(model.setpoint.y, model.error.u[0])
    model.connect(model.plant.y, model.error.u[1])
    model.connect(model.error.y, model.control.u)
    model.connect(model.control.y, model.plant.u)
    return model


def test_sampled_pi_on_a_continuous_plant():
    """Between samples the input is constant, so the plant is exact by the matrix exponential."""
    period, kp, ki, steps = 0.2, 0.8, 0.6, 100
    result = simulate(sampled_loop(period, kp, ki), t_end=steps * period, output_step=period / 2, tolerance=1e-9)

    A = np.array([[0, 1, 0], [-0.5, -1, 1], [0, 0, 0.0]])  # the last state is the held input
    half = expm(A * period / 2)
    x, integral, outputs, inputs = np.zeros(3), 0.0, [], []
    for _ in range(steps):
        error = 1.0 - x[0]
        integral += period * ki * error
        x[2] = kp * error + integral
        for _ in range(2):
            outputs.append(x[0])
            inputs.append(x[2])
            x = half @ x
    outputs.append(x[0])
    y, u = values(result, "plant.y"), values(result, "control.y")
    assert np.max(np.abs(y - outputs)) < 1e-6
    assert np.max(np.abs(u[1:-1:2] - inputs[1::2])) < 1e-6  # in the middle of each interval
    assert abs(y[-1] - 1.0) < 1e-2


# --- another field with its own connectors ------------------------------------------------------------------------


class Pin(Connector):
    """Electrical pin."""

    v = potential(unit="V", doc="potential")
    i = flow(unit="A", doc="current into the component")


class TwoPins(Component):
    """Partial: voltage and current of a two-pole."""

    p: Pin = port(doc="positive pin")
    n: Pin = port(doc="negative pin")

    voltage: Scalar = var(unit="V", state="prefer", doc="p against n")

    def two_pole(self):
        return [eq(self.voltage, self.p.v - self.n.v), eq(self.p.i + self.n.i, 0)]


class Resistor(TwoPins):
    """Ohm's law."""

    resistance: Scalar = param(unit="ohm", doc="resistance")

    def equations(self):
        return [self.two_pole(), eq(self.voltage, self.resistance * self.p.i)]


class Capacitor(TwoPins):
    """i = C dv/dt."""

    capacitance: Scalar = param(unit="F", doc="capacitance")

    def equations(self):
        return [self.two_pole(), eq(self.capacitance * der(self.voltage), self.p.i)]


class Source(TwoPins):
    """Constant voltage."""

    level: Scalar = param(unit="V", doc="voltage")

    def equations(self):
        return [self.two_pole(), eq(self.voltage, self.level)]


class Ground(Component):
    """Potential zero."""

    pin: Pin = port(doc="grounded pin")

    def equations(self):
        return [eq(self.pin.v, 0)]


class Cell(Component):
    """One resistor along, one capacitor to ground."""

    resistance: Scalar = param(default=100.0, unit="ohm", doc="resistance of the cell")
    capacitance: Scalar = param(default=1e-3, unit="F", doc="capacitance of the cell")

    left: Pin = port(doc="from the source")
    right: Pin = port(doc="to the next cell")
    earth: Pin = port(doc="ground")

    resistor = part(Resistor, resistance=resistance)
    capacitor = part(Capacitor, capacitance=capacitance)

    def build(self):
        self.connect(self.left, self.resistor.p)
        self.connect(self.resistor.n, self.capacitor.p)
        self.connect(self.capacitor.p, self.right)
        self.connect(self.capacitor.n, self.earth)


def ladder(cells):
    model = fw.Assembly("RC ladder")
    model.source, model.ground, model.load = Source(level=10.0), Ground(), Resistor(resistance=500.0)
    model.connect(model.source.n, model.ground.pin)
    last = model.source.p
    for i in range(cells):
        cell = model.add(f"cell_{i}", Cell(resistance=100.0 + 10 * i))
        model.connect(last, cell.left)
        model.connect(cell.earth, model.ground.pin)
        last = cell.right
    model.connect(last, model.load.p)
    model.connect(model.load.n, model.ground.pin)
    return model


def test_rc_ladder_charges_exactly():
    cells, capacitance = 6, 1e-3
    result = simulate(ladder(cells), t_end=2.0, output_step=0.05)
    along = 1 / (100.0 + 10 * np.arange(cells))
    A = np.zeros((cells + 1, cells + 1))  # capacitor voltages and the constant source
    for i in range(cells):
        A[i, i] -= along[i]
        A[i, i - 1 if i else cells] += along[i]
        if i + 1 < cells:
            A[i, i] -= along[i + 1]
            A[i, i + 1] += along[i + 1]
    A[cells - 1, cells - 1] -= 1 / 500.0
    A[:cells] /= capacitance
    start = np.zeros(cells + 1)
    start[-1] = 10.0
    exact = linear_response(A, start, times(result, "source.voltage"))
    for i in range(cells):
        assert np.max(np.abs(values(result, f"cell_{i}.capacitor.voltage") - exact[:, i])) < 1e-7
    assert np.allclose(values(result, "source.p.i"), -(10.0 - exact[:, 0]) / 100.0, atol=1e-9)


def test_parallel_capacitors_make_one_state():
    """Two capacitors in parallel: an algebraic constraint between states, which the kernel finds."""
    model = fw.Assembly("parallel capacitors")
    model.source, model.ground, model.resistor = Source(level=5.0), Ground(), Resistor(resistance=50.0)
    model.one, model.two = Capacitor(capacitance=2e-3), Capacitor(capacitance=3e-3)
    model.connect(model.source.n, model.ground.pin)
    model.connect(model.source.p, model.resistor.p)
    for capacitor in (model.one, model.two):
        model.connect(model.resistor.n, capacitor.p)
        model.connect(capacitor.n, model.ground.pin)
    plant = fw.load(model).compile()
    assert len(plant.initial_state().x) == 1
    result = plant.simulate(1.0, output_step=0.02, tolerance=1e-10)
    time = times(result, "one.voltage")
    voltage = 5.0 * (1 - np.exp(-time / (50.0 * 5e-3)))
    assert np.max(np.abs(values(result, "two.voltage") - voltage)) < 1e-8
    assert np.allclose(values(result, "one.p.i"), 2e-3 * (5.0 - voltage) / 0.25, atol=1e-7)


# --- algebra and initial equations ---------------------------------------------------------------------------------


class Tank(Component):
    """Outflow by Torricelli through a valve whose flow follows from a nonlinear balance with friction."""

    area: Scalar = param(default=2.0, unit="m^2", doc="cross-section of the tank")
    orifice: Scalar = param(default=0.05, unit="m^2", doc="cross-section of the outlet")
    gravity: Scalar = param(default=9.81, unit="m/s^2", doc="acceleration of gravity")
    flow_start: Scalar = param(default=0.2, unit="m^3/s", doc="initial outflow")

    level: Scalar = var(unit="m", start=1.0, state="always", doc="level over the outlet")
    outflow: Scalar = var(unit="m^3/s", start=0.1, doc="volume flow")

    def equations(self):
        return [
            eq(self.area * der(self.level), -self.outflow),
            eq(self.outflow**2, 2 * self.gravity * self.level * self.orifice**2),
            initial(self.outflow, self.flow_start),
        ]


def test_an_initial_equation_sets_a_state_through_the_algebra():
    model = fw.Assembly("tank")
    model.tank = Tank()
    result = simulate(model, t_end=8.0)
    time = times(result, "tank.level")
    start = 0.2**2 / (2 * 9.81 * 0.05**2)
    exact = (np.sqrt(start) - 0.05 / 2.0 * np.sqrt(9.81 / 2) * time) ** 2
    assert values(result, "tank.level")[0] == pytest.approx(start, rel=1e-8)
    assert np.max(np.abs(values(result, "tank.level") - exact)) < 1e-7
