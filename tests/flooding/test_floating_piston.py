"""A piston that floats in a shaft: levels, period, lifting, energy, momentum, loads of a leaning shaft, limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant, Integrator
from fowtlib.components.flooding import CompartmentRing, RoundTank
from fowtlib.components.flooding.connectors import Water
from fowtlib.components.flooding.floating_piston import FloatingPiston
from fowtlib.components.mechanics import (
    EndStop,
    FixedRotation,
    FixedTranslation,
    Latch,
    Prismatic,
    Revolute,
    RigidBody,
    SlidingFriction,
    World,
)
from fowtlib.language import Component, RealInput, RealOutput, eq, port
from fowtlib.language.errors import ModelError, ParameterError, SimulationError

G, RHO = 9.80665, 1025.0
MASS, SHAFT, PISTON, HEIGHT = 9.0e5, 7.0, 6.4, 30.0
AREA, SMALL = math.pi / 4 * SHAFT**2, math.pi / 4 * PISTON**2
DEPTH = MASS / (RHO * SMALL)


class Inflow(Component):
    """A flow into what it is joined to, given by a signal, and the power that it gives against the pressure there."""

    flow: RealInput = port(unit="m^3/s", doc="flow")
    water: Water = port(doc="where it goes")
    power: RealOutput = port(unit="W", doc="rho g head times flow")

    def equations(self):
        return [eq(self.water.volume_flow, -self.flow), eq(self.power, RHO * G * self.water.head * self.flow)]


def volume(s, immersion=DEPTH):
    """Water for a piston at s that is in it by its immersion."""
    return AREA * s + (AREA - SMALL) * immersion


def machine(s=20.0, v=0.0, flow=0.0, carrier=None, **shaft):
    """A piston in a shaft whose floor is fixed, or on a carrier with frames a and b; with a stop, and no losses."""
    model = fw.Assembly("machine")
    model.world = World(gravity=G, water_density=RHO)
    floor = model.world.frame
    if carrier is not None:
        model.carrier = carrier
        model.connect(floor, carrier.frame_a)
        floor = carrier.frame_b
    model.slide = Prismatic(n=(0, 0, 1), s_start=s, v_start=v)
    model.body = RigidBody(mass=MASS, inertia=np.diag([1e8, 1e8, 1e7]), r_cm=(0, 0, 40.0))
    model.stop = EndStop(place=0.2, reference_force=MASS * G, restitution_loss=0.5)
    given = {"gap_loss": 0.0, "gap_friction": 0.0, "volume_start": volume(s)} | shaft
    model.shaft = FloatingPiston(diameter=SHAFT, height=80.0, piston_diameter=PISTON, piston_height=HEIGHT, **given)
    model.flow = Constant(value=flow)
    model.inflow = Inflow()
    model.connect(floor, model.slide.frame_a)
    model.connect(floor, model.shaft.frame_a)
    model.connect(model.slide.frame_b, model.body.frame_a)
    model.connect(model.slide.frame_b, model.shaft.frame_b)
    model.connect(model.slide.axis, model.shaft.axis)
    model.connect(model.slide.axis, model.stop.axis)
    model.connect(model.flow.y, model.inflow.flow)
    model.connect(model.inflow.water, model.shaft.water)
    return model


def metered(model, *parts):
    """Integrals of the power that parts take out, and of that of the pump."""
    for name in parts:
        model.add(f"{name}_loss", Integrator())
        model.connect(model.find(name).lost_power, model.find(f"{name}_loss").u)
    model.pumped = Integrator()
    model.connect(model.inflow.power, model.pumped.u)
    return model


def run(model, t_end, step=0.1, **options):
    return fw.load(model).compile().simulate(t_end, step, **{"tolerance": 1e-10, **options})


def array(result, path):
    return np.asarray(result[path])


def test_a_floating_piston_rests_at_the_depth_that_carries_it():
    result = run(machine(), 10.0)
    assert np.abs(array(result, "slide.s") - 20).max() < 1e-6
    s, V = array(result, "slide.s")[-1], volume(20.0)
    assert array(result, "shaft.level")[-1] == pytest.approx((V - SMALL * s) / (AREA - SMALL), rel=1e-12)
    assert array(result, "shaft.lift")[-1] == pytest.approx(MASS * G, rel=1e-7)


@pytest.mark.parametrize("piston", [5.6, 6.4, 6.9])
def test_its_period_is_that_of_a_pendulum_as_long_as_it_is_deep(piston):
    """T = 2 pi sqrt(d/g), whatever the gap: stiffness rho g A_c A_s/A_a, inertia m + rho A_c^2 d/A_a, m = rho A_c d."""
    small = math.pi / 4 * piston**2
    depth = MASS / (RHO * small)
    model = machine(10.0, volume_start=AREA * 10 + (AREA - small) * depth)
    model.shaft.piston_diameter, model.shaft.piston_height = piston, 60.0
    plant = fw.load(model).compile()
    omega = max(abs(np.linalg.eigvals(plant.linearize(plant.initial_state()).A.values).imag))
    assert omega == pytest.approx(math.sqrt(G / depth), rel=1e-6)
    stiffness = RHO * G * small * AREA / (AREA - small)
    assert omega**2 * (MASS + RHO * small**2 * depth / (AREA - small)) == pytest.approx(stiffness, rel=1e-6)


def test_pumping_lifts_it_by_the_section_of_the_shaft_once_it_floats():
    """On its feet nothing moves until the water is deep enough; the force on the stop falls to zero by then."""
    flow = 0.5
    model = machine(0.2, flow=flow, volume_start=volume(0.2, 0.5 * DEPTH), gap_friction=0.02, gap_loss=1.5)
    model.rubbing = SlidingFriction(viscous=2e6)
    model.connect(model.slide.axis, model.rubbing.axis)
    result = run(model, 400.0, 1.0)
    s, V, force = (array(result, path) for path in ("slide.s", "shaft.volume", "stop.force"))
    assert V[-1] == pytest.approx(volume(0.2, 0.5 * DEPTH) + 400 * flow, rel=1e-10)
    floats = (volume(0.2) - V[0]) / flow
    before, after = (result.time > 60) & (result.time < floats - 10), result.time > floats + 60
    expected = MASS * G - RHO * G * SMALL * array(result, "shaft.immersion")
    assert np.abs(force - expected)[before].max() < 2e-3 * MASS * G
    assert force[after].max() == 0 and s[before].max() < 0.201
    slope = np.polyfit(s[after], V[after], 1)[0]
    assert slope == pytest.approx(AREA, rel=2e-3)


def test_energy_of_set_water_pump_stop_and_gap_is_accounted_for():
    """A piston falls into the water, hits the stop, and is pumped up; the sum stays to 1e-6 of the energy it had."""
    falling = machine(4.0, v=-1.0, flow=2.0, volume_start=volume(0.3, 0.6 * DEPTH), gap_loss=1.5)
    model = metered(falling, "stop", "shaft")
    result = run(model, 40.0, 0.05)
    s, v, elastic, water = (array(result, path) for path in ("slide.s", "slide.v", "stop.energy", "shaft.energy"))
    losses = array(result, "stop_loss.y") + array(result, "shaft_loss.y")
    total = MASS * v**2 / 2 + MASS * G * s + elastic + water + losses - array(result, "pumped.y")
    assert np.abs(total - total[0]).max() < 1e-6 * MASS * G * 4.0
    assert array(result, "stop.impacts")[-1] >= 1 and array(result, "stop_loss.y")[-1] > 0
    assert array(result, "shaft_loss.y")[-1] > 0.05 * MASS * G


def test_shaft_piston_and_water_fall_together_by_their_whole_momentum():
    """Without support the momentum of all is -M g t; that of the water relative to the shaft is -rho A_c c v."""
    model = machine(20.0, v=0.5, carrier=Prismatic(n=(0, 0, 1)), gap_loss=1.5)
    model.hull = RigidBody(mass=2e6, inertia=np.diag([1e9, 1e9, 1e8]))
    model.connect(model.carrier.frame_b, model.hull.frame_a)
    result = run(model, 4.0, 0.02)
    c, v, Z = (array(result, path) for path in ("shaft.immersion", "slide.v", "carrier.v"))
    water = RHO * volume(20.0)
    momentum = (2e6 + water) * Z + MASS * (Z + v) - RHO * SMALL * c * v
    expected = momentum[0] - (2e6 + water + MASS) * G * result.time
    assert np.abs(momentum - expected).max() < 1e-7 * abs(expected[-1])
    assert np.abs(v - v[0]).max() > 0.02


def test_a_leaning_shaft_carries_water_whose_surface_is_level():
    """Force and moment at the floor against the weight of the water summed over its columns, and that of the piston.

    The moment of the level surface is taken linear in the slope here, the rest is of its third power.
    """
    angle, s = 0.05, 10.0
    lean = FixedRotation(n=(0, 1, 0), angle=angle)
    result = run(machine(s, carrier=lean), 0.1)
    R = array(result, "carrier.frame_b.R")[-1]
    across, up = np.meshgrid(*[(np.arange(700) + 0.5) * SHAFT / 700 - SHAFT / 2] * 2, indexing="ij")
    radius = np.hypot(across, up)
    dA = (SHAFT / 700) ** 2
    whole = radius < SHAFT / 2
    surface = array(result, "shaft.level")[-1] + across * math.tan(angle)
    top = np.where(radius < PISTON / 2, s, surface)
    mass = RHO * (top * whole).sum() * dA
    first = RHO * dA * np.array([(across * top * whole).sum(), (up * top * whole).sum(), (top**2 / 2 * whole).sum()])
    weight = (0, 0, -G)
    moment = np.cross(R @ first, weight) + np.cross(R @ (0, 0, s + 40.0), MASS * np.array(weight))
    assert array(result, "carrier.frame_a.f")[-1] == pytest.approx([0, 0, (MASS + mass) * G], rel=1e-4, abs=1)
    assert array(result, "carrier.frame_a.t")[-1][1] == pytest.approx(-moment[1], rel=3e-5)
    assert array(result, "shaft.centre")[-1] == pytest.approx(first / mass, rel=1e-3, abs=1e-9)


@pytest.mark.parametrize(
    "changes, says",
    [
        ({"piston_height": DEPTH - 1}, "stands over the top of the piston"),
        ({"height": 20.0 + DEPTH + 1}, "over the top of the shaft"),
    ],
)
def test_a_run_stops_where_there_is_too_much_water(changes, says):
    model = machine(flow=1.0, volume_start=volume(20.0, DEPTH - 2))
    model.slide.s_start = 20.0
    for name, value in changes.items():
        setattr(model.shaft, name, value)
    model.rubbing = SlidingFriction(viscous=1e8)
    model.connect(model.slide.axis, model.rubbing.axis)
    with pytest.raises(SimulationError, match=says):
        run(model, 200.0, 0.5)


def test_a_piston_is_narrower_than_its_shaft():
    with pytest.raises(ParameterError, match=r"piston_diameter = 8 m must be below its diameter, 7 m: no water fits"):
        FloatingPiston(diameter=7.0, height=50.0, piston_diameter=8.0, piston_height=30.0, volume_start=100.0)
    model = machine(flow=0.0, volume_start=volume(20.0, DEPTH))
    with pytest.raises(ModelError, match="its piston_diameter, 7.5 m, must be below its diameter, 7 m"):
        fw.load(model).compile().simulate(1.0, parameters={"shaft.piston_diameter": 7.5})


@pytest.mark.parametrize("kind", [RoundTank, CompartmentRing])
def test_a_ring_is_wider_than_its_hole(kind):
    with pytest.raises(ParameterError, match=r"inner_diameter = 9 m must be below its diameter, 6 m"):
        kind(diameter=6.0, inner_diameter=9.0, height=3.0, volume_start=1.0)


def test_a_run_stops_where_the_shaft_is_pumped_dry():
    with pytest.raises(SimulationError, match="the shaft is empty"):
        run(machine(0.2, flow=-1.0, volume_start=20.0), 60.0, 0.5)


def test_a_shaft_with_water_swings_as_a_column_with_a_free_surface():
    """(I - rho i l_s) w^2 = g sum(m l) - rho g i: slabs move with the shaft, the surface with what it feels.

    I: hull and column about the pivot; l: depths of centres below it, l_s of the surface; the piston hangs dry above.
    """
    depth, h, hull, dry = 60.0, 12.0, 5e6, 40.0
    model = fw.Assembly("swing")
    model.world = World(gravity=G, water_density=RHO)
    model.pivot = Revolute(n=(0, 1, 0), phi_start=1e-4)
    model.rod = FixedTranslation(r=(0, 0, -depth))
    model.hull = RigidBody(mass=hull, inertia=np.diag([1e9, 1e9, 1e9]))
    model.slide = Prismatic(n=(0, 0, 1), s_start=dry)
    model.latch = Latch(place=dry, stiffness=1e12, damping=1e9, closed_start=1)
    model.body = RigidBody(mass=1e3, inertia=np.diag([1.0, 1.0, 1.0]))
    model.shaft = FloatingPiston(
        diameter=SHAFT, height=80.0, piston_diameter=PISTON, piston_height=HEIGHT, volume_start=AREA * h
    )
    model.connect(model.world.frame, model.pivot.frame_a)
    model.connect(model.pivot.frame_b, model.rod.frame_a)
    model.connect(model.rod.frame_b, model.hull.frame_a)
    for part in (model.slide, model.shaft):
        model.connect(model.rod.frame_b, part.frame_a)
    for part in (model.body.frame_a, model.shaft.frame_b):
        model.connect(model.slide.frame_b, part)
    for part in (model.shaft.axis, model.latch.axis):
        model.connect(model.slide.axis, part)
    plant = fw.load(model).compile()
    values = np.linalg.eigvals(plant.linearize(plant.initial_state()).A.values)
    omega = min(abs(value.imag) for value in values if abs(value.imag) > 1e-3)
    water, second, surface = RHO * AREA * h, math.pi / 64 * SHAFT**4, depth - h
    column = RHO * AREA * (depth**3 - surface**3) / 3
    inertia = 1e9 + hull * depth**2 + column + 1 + 1e3 * (depth - dry) ** 2
    levers = hull * depth + water * (depth - h / 2) + 1e3 * (depth - dry)
    expected = math.sqrt((G * levers - RHO * G * second) / (inertia - RHO * second * surface))
    assert omega == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("count", [3, 8])
def test_compartments_take_less_off_the_stability(count):
    """Second moments of the compartments about their own middles, summed on a grid over the section."""
    ring = CompartmentRing(diameter=29.3, inner_diameter=7.7, height=6.0, compartments=count, volume_start=100.0)
    radius, angle = np.meshgrid(
        3.85 + (14.65 - 3.85) * (np.arange(400) + 0.5) / 400, 2 * np.pi * (np.arange(2400) + 0.5) / 2400, indexing="ij"
    )
    dA = radius * (14.65 - 3.85) / 400 * 2 * np.pi / 2400
    x, number = radius * np.cos(angle), np.floor(angle / (2 * np.pi / count)).astype(int)
    second = 0.0
    for k in range(count):
        mine = number == k
        middle = (x * dA)[mine].sum() / dA[mine].sum()
        second += ((x - middle) ** 2 * dA)[mine].sum()
    model = fw.Assembly("ring")
    model.world = World(gravity=G, water_density=RHO)
    model.lean = FixedRotation(n=(0, 1, 0), angle=0.02)
    model.ring = ring
    model.connect(model.world.frame, model.lean.frame_a)
    model.connect(model.lean.frame_b, model.ring.frame)
    moment = array(run(model, 0.1), "lean.frame_a.t")[-1][1]
    h = 100.0 / (np.pi * (14.65**2 - 3.85**2))
    expected = RHO * G * (100.0 * h / 2 * math.sin(0.02) + second * math.sin(0.02) * (1 + math.tan(0.02) ** 2 / 2))
    assert -moment == pytest.approx(expected, rel=1e-4)
