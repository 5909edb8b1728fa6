"""Oye's dynamic inflow: its filters in closed form, the steady rotor, pitch steps against an integration of its own."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import (
    BladeElementAerodynamics,
    BladeElementRotor,
    DynamicInflow,
    RigidRotor,
    coefficient_table,
)
from fowtlib.components.environment import Wind, World
from fowtlib.components.servo import BaselineController
from fowtlib.components.support import RigidTower
from fowtlib.components.turbine import Drivetrain, Hub, Nacelle, RotorNacelleAssembly, Turbine
from fowtlib.language import Scalar, eq, param, part, var, when
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError
from fowtlib.language.native import compiler

needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"
RADIUS, LENGTH, TIP = [20.0, 40.0, 60.0], [20.0, 20.0, 6.0], 63.0
STEP = 1.0


class Stepped(fw.Component):
    """Dynamic inflow alone: the quasi-steady speed steps after a second."""

    before: Scalar = param(unit="m/s")
    after: Scalar = param(unit="m/s")
    inflow: DynamicInflow = part(DynamicInflow, radius=RADIUS, length=LENGTH, tip_radius=TIP)

    def equations(self):
        stepped = m.if_else(self.time > STEP, self.after, self.before)
        return [
            eq(self.inflow.quasi_steady, stepped * np.ones(3)),
            eq(self.inflow.wind_speed, 10.0),
            when(self.time > STEP),
        ]


@pytest.mark.parametrize(
    ("before", "after", "induction"),
    [(-1.0, -2.0, 0.0), (6.0, 8.0, 0.5), (3.0, 3.0003, 0.3), (3.0, 2.9997, 0.3)],
)
def test_a_step_has_two_time_constants(before, after, induction):
    """Where the induction factor is at its bounds, or hardly changes, the time constants are constant.

    After the step W_int = W_1 + (1 - k) d exp(-t/tau_1), d = W_0 - W_1, and W follows with tau_2.
    """
    plant = fw.load(Stepped(before=before, after=after)).compile()
    result = plant.simulate(61.0, output_step=0.5, tolerance=1e-10)
    time = result.time - STEP
    tau_1 = 1.1 / (1 - 1.3 * induction) * TIP / 10.0
    for i, r in enumerate(RADIUS):
        tau_2 = (0.39 - 0.26 * (r / TIP) ** 2) * tau_1
        slow = (1 - 0.6) * tau_1 / (tau_1 - tau_2)
        t = np.maximum(time, 0)
        exact = after + (before - after) * (slow * np.exp(-t / tau_1) + (1 - slow) * np.exp(-t / tau_2))
        found = result.array("inflow.induced")[:, i]
        assert found == pytest.approx(exact, abs=2e-5 * abs(after - before) + 1e-9 * abs(after))


def test_time_constants():
    """The NREL 5 MW rotor at a = 1/3 in 10 m/s: tau_1 = 12.2 s; tau_2 = 4.8 s at the axis, 1.6 s at the tip."""
    plant = fw.load(Stepped(before=10 / 3, after=0.0)).compile()
    state = plant.initial_state()
    assert state["inflow.induction"] == pytest.approx(1 / 3)
    assert state["inflow.slow_time"] == pytest.approx(1.1 / (1 - 1.3 / 3) * 6.3)
    assert np.ravel(state["inflow.induced"]) == pytest.approx(10 / 3)


def test_without_wind_the_time_constant_is_finite():
    class Still(fw.Component):
        inflow: DynamicInflow = part(DynamicInflow, radius=RADIUS, length=LENGTH, tip_radius=TIP)

        def equations(self):
            return [eq(self.inflow.quasi_steady, np.zeros(3)), eq(self.inflow.wind_speed, -0.5)]

    state = fw.load(Still()).compile().initial_state()
    assert state["inflow.slow_time"] == pytest.approx(1.1 * TIP)


class PitchStep(fw.Component):
    """A rotor at a given speed in uniform wind, shaft along the wind: its blades pitch after a second."""

    rotor: object = param()
    wind_speed: float = param(unit="m/s")
    speed: float = param(unit="rad/s")
    before: float = param(unit="rad")
    after: float = param(unit="rad")
    thrust: Scalar = var(unit="N")
    torque: Scalar = var(unit="N*m")

    def build(self):
        b = self.rotor.blade
        self.inflow = DynamicInflow(radius=b.radius.tolist(), length=b.length.tolist(), tip_radius=b.tip_radius)

    def equations(self):
        rotor, rigid = self.rotor, RigidRotor(self.rotor)
        values, arm = split(rotor, rigid.inputs([self.wind_speed, 0, 0], self.speed))
        pitch = m.if_else(self.time > STEP, self.after, self.before)
        axes = [ca.DM(a.reshape(3, 3).T) @ m.rotation_z(-pitch) for a in values["orientation"].reshape(-1, 9)]
        values |= {"orientation": m.vertcat(*[m.vec(R) for R in axes]), "induced": self.inflow.induced}
        outputs = rotor.external(**values)
        loads, n, stations = outputs["loads"], rotor.nodes, len(rotor.blade.radius)
        forces = [loads[6 * i : 6 * i + 3] for i in range(n)]
        mean = sum(outputs["quasi_steady"][k * stations : (k + 1) * stations] for k in range(rotor.blades))
        torque = sum(m.cross(ca.DM(arm[i]), f)[0] + loads[6 * i + 3] for i, f in enumerate(forces))
        return [
            eq(self.inflow.quasi_steady, mean / rotor.blades),
            eq(self.inflow.wind_speed, self.wind_speed),
            eq(self.thrust, sum(f[0] for f in forces)),
            eq(self.torque, torque),
            when(self.time > STEP),
        ]


def split(rotor, inputs):
    values = dict(zip(rotor.inputs, np.split(inputs, np.cumsum(list(rotor.inputs.values()))[:-1]), strict=True))
    return values, values["position"].reshape(-1, 3) - values["hub_position"]


@pytest.fixture(scope="module")
def straight(blade):
    return BladeElementRotor(replace(blade, curve=None, sweep=None), dynamic_inflow=True)


def integrated(rotor, wind, speed, pitch, start, times):
    """Thrust after a pitch step, by another integrator, with the first form of the filters: W_int as the state.

    The quasi-steady speed is constant after the step, so that W_int jumps by k of its change and needs no derivative.
    """
    rigid, b = RigidRotor(rotor), rotor.blade
    before, after = (rigid.quasi_steady(rigid.inputs([wind, 0, 0], speed, p)) for p in (start, pitch))
    weights = b.radius * b.length / (b.radius * b.length).sum()

    def rates(_, y):
        between, induced = y.reshape(2, -1)
        a = min(max(weights @ induced / wind, 0), 0.5)
        slow = 1.1 / (1 - 1.3 * a) * b.tip_radius / wind
        fast = (0.39 - 0.26 * (b.radius / b.tip_radius) ** 2) * slow
        return np.concatenate([(after - between) / slow, (between - induced) / fast])

    first = np.concatenate([before + 0.6 * (after - before), before])
    found = solve_ivp(rates, (0, times[-1]), first, t_eval=times, rtol=1e-9, atol=1e-10).y
    return np.array([rigid.thrust_and_torque([wind, 0, 0], speed, pitch, induced=y[len(before) :]) for y in found.T])


@needs_compiler
@pytest.mark.parametrize(("start", "pitch"), [(0.0, 3.7), (3.7, 0.0)])
def test_a_pitch_step_overshoots_and_settles(straight, start, pitch):
    """Steps of 3.7 deg near the best tip speed ratio, like those on the Tjaereborg turbine (Snel and Schepers 1995).

    The first load after the step is that of the old induced speed; it settles at the quasi-steady rotor's.
    """
    wind, speed = 8.7, 1.05
    p0, p1 = np.radians([start, pitch])
    model = PitchStep(rotor=straight, wind_speed=wind, speed=speed, before=p0, after=p1)
    result = fw.load(model).compile().simulate(STEP + 80.0, output_step=1.0, tolerance=1e-8)
    rigid = RigidRotor(replace(straight, dynamic_inflow=False))
    old, new = (np.array(rigid.thrust_and_torque([wind, 0, 0], speed, p)) for p in (p0, p1))
    found = np.transpose([result.array(name) for name in ("thrust", "torque")])
    assert found[0] == pytest.approx(old, rel=1e-8)
    exact = integrated(straight, wind, speed, p1, p0, np.arange(1.0, 81.0))
    assert found[2:] == pytest.approx(exact, rel=1e-5)
    assert found[-1] == pytest.approx(new, rel=2e-3)
    overshoot = (found[2] - new) / (new - old)
    assert np.all(overshoot > 0.25)  # the quasi-steady rotor has none
    assert np.all(np.diff(np.abs(found[2:] - new), axis=0) < 0)  # and back without a wave


@needs_compiler
def test_the_load_at_the_step_is_that_of_the_old_induction(straight):
    """Held at the quasi-steady speed of a state, the loads are the quasi-steady ones; exactly."""
    steady, rigid = RigidRotor(replace(straight, dynamic_inflow=False)), RigidRotor(straight)
    for wind, speed, pitch in ((8.0, 1.0, 0.0), (18.0, 1.26, 0.25), (5.0, 1.2, 0.0)):
        induced = rigid.quasi_steady(rigid.inputs([wind, 0, 0], speed, pitch))
        held = rigid.loads(rigid.inputs([wind, 0, 0], speed, pitch, induced=induced))
        free = steady.loads(steady.inputs([wind, 0, 0], speed, pitch))
        assert held == pytest.approx(free, rel=1e-9, abs=1e-9 * np.abs(free).max())


@needs_compiler
def test_steady_tables_are_quasi_steady(straight):
    steady = replace(straight, dynamic_inflow=False)
    tables = [coefficient_table(rotor, [6.0, 7.0, 8.0, 9.0], [0.0, 0.05, 0.1, 0.2]) for rotor in (straight, steady)]
    assert tables[0].thrust == pytest.approx(tables[1].thrust, rel=1e-12)
    induced = RigidRotor(straight).quasi_steady(RigidRotor(straight).inputs([9.0, 0, 0], 1.0))
    swept = RigidRotor(straight).sweep(np.array([9.0]), 1.0, 0.0, induced=induced)[0]
    assert swept == pytest.approx(RigidRotor(steady).thrust_and_torque([9.0, 0, 0], 1.0), rel=1e-9)
    with pytest.raises(ParameterError, match="an output of a rotor with dynamic_inflow only"):
        RigidRotor(steady).quasi_steady(RigidRotor(steady).inputs([9.0, 0, 0], 1.0))


def turbine_on_a_tower(dynamic_inflow):
    """The NREL 5-MW turbine with stiff blades and no tilt in uniform wind."""
    model = fw.Assembly("turbine")
    model.world = World()
    model.wind = Wind(kind="steady", mean_speed=9.0)
    air = BladeElementAerodynamics(
        blade=str(DATA / "blade_aerodynamics.csv"), airfoils=str(DATA / "airfoils.csv"), tip_radius=63,
        dynamic_inflow=dynamic_inflow,
    )  # fmt: skip
    assembly = RotorNacelleAssembly(
        blade_properties=str(DATA / "blade_structure.csv"), blade_hinges=0, hub=Hub(precone=0.04, radius=1.5),
        nacelle=Nacelle(mass=240e3, shaft_height=2.0, tilt=0.0, overhang=5.0),
        drivetrain=Drivetrain(gear_ratio=97, stiffness=867637000.0, generator_inertia=534.116),
    )  # fmt: skip
    control = BaselineController(proportional_gain=0.006, integral_gain=0.0009)
    model.tower = RigidTower(height=88.0, mass=1.0, centre_of_mass=40.0)
    model.turbine = Turbine(assembly=assembly, aerodynamics=air, control=control)
    model.connect(model.world.frame, model.tower.frame_a)
    model.connect(model.tower.frame_b, model.turbine.frame)
    return fw.load(model).compile()


@needs_compiler
def test_a_steady_turbine_is_the_quasi_steady_one():
    """In uniform wind along the shaft every blade meets the mean of its annulus: the same loads, 34 more states."""
    quasi_steady, dynamic = (turbine_on_a_tower(flag) for flag in (False, True))
    free, held = quasi_steady.initial_state(), dynamic.initial_state()
    for name in ("turbine.thrust", "turbine.aerodynamics.torque"):
        assert held[name] == pytest.approx(free[name], rel=1e-8)
    assert len(dynamic.dae.states) == len(quasi_steady.dae.states) + 34
    induced = np.ravel(held["turbine.aerodynamics.inflow.induced"])
    assert induced == pytest.approx(np.ravel(held["turbine.aerodynamics.inflow.quasi_steady"]))
    assert 0.2 < float(held["turbine.aerodynamics.inflow.induction"]) < 0.4
    assert float(held["turbine.aerodynamics.inflow.wind_speed"]) == pytest.approx(9.0)
