"""The first mode of water in tanks against closed forms, alone and coupled with a body."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import jnp_zeros

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, RoundTank
from fowtlib.components.flooding.sloshing import ROUND, XI, box_mode, round_mode
from fowtlib.components.mechanics import Prismatic, RigidBody
from fowtlib.language.errors import ModelError

GRAVITY, RHO = 9.80665, 1025.0


def sliding(tank: object, mass: float) -> fw.Plant:
    """A tank on a body that slides along x without friction."""
    model = fw.Assembly("sliding tank")
    model.world = World()
    model.slide = Prismatic(n=(1, 0, 0))
    model.body = RigidBody(mass=mass, inertia=((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    model.tank = tank
    model.connect(model.world.frame, model.slide.frame_a)
    model.connect(model.slide.frame_b, model.body.frame_a)
    model.connect(model.slide.frame_b, model.tank.frame)
    return fw.load(model).compile()


def frequencies(plant: fw.Plant) -> list[float]:
    A = plant.linearize(plant.initial_state()).A.values
    found = np.linalg.eigvals(A)
    return sorted(abs(value) for value in found if value.imag > 1e-6)


@pytest.mark.parametrize("depth", [0.5, 2.0, 6.0])
def test_a_box_sloshes_at_the_frequencies_of_linear_waves(depth):
    """omega^2 = g pi / a tanh(pi h / a) along each side, of a tank that is held; of a free one heavier by m_1."""
    a, b = 5.0, 3.0
    tank = BoxTank(length=a, width=b, height=8, volume_start=a * b * depth, sloshing=True, slosh_damping=0)
    m1 = RHO * a * b * depth * 8 * a / (math.pi**3 * depth) * math.tanh(math.pi * depth / a)
    along, across = (math.sqrt(GRAVITY * math.pi / side * math.tanh(math.pi * depth / side)) for side in (a, b))
    held = frequencies(sliding(tank, 1e12))
    assert held == pytest.approx(sorted([along, across]), rel=1e-6)
    body = 2e4
    tank = BoxTank(length=a, width=b, height=8, volume_start=a * b * depth, sloshing=True, slosh_damping=0)
    free = frequencies(sliding(tank, body))
    total = body + RHO * a * b * depth
    assert free == pytest.approx(sorted([along * math.sqrt(total / (total - m1)), across]), rel=1e-9)


def test_a_round_tank_sloshes_at_the_first_zero_of_the_bessel_derivative():
    xi = jnp_zeros(1, 1)[0]
    assert xi == pytest.approx(XI, rel=1e-12)
    tank = RoundTank(diameter=4, height=6, volume_start=4 * math.pi * 3, sloshing=True, slosh_damping=0)
    omega = math.sqrt(GRAVITY * xi / 2 * math.tanh(xi * 3 / 2))
    assert frequencies(sliding(tank, 1e12)) == pytest.approx([omega, omega], rel=1e-6)


def test_the_modes_have_the_force_and_moment_of_potential_flow():
    """Of a mode of unit amplitude the pressures on walls and floor are integrated; a mass on a spring has the same.

    phi ~ sin(k x) cosh(k (z + h)), the force on the walls F and the moment about the middle of the surface; a mass m_1
    at z_1 that is moved by y: F = m_1 omega^2 y, M = z_1 F + m_1 g y.
    """
    a, b, h = 5.0, 3.0, 2.3
    k, mode = math.pi / a, box_mode(a, b, h, RHO, GRAVITY)
    z = np.linspace(-h, 0, 20001)
    x = np.linspace(-a / 2, a / 2, 20001)
    wall = np.cosh(k * (z + h)) / math.cosh(k * h)  # pressure over rho g, of a rise of 1 at the wall
    force = 2 * b * RHO * GRAVITY * np.trapezoid(wall, z)
    floor = b * RHO * GRAVITY * np.trapezoid(x * np.sin(k * x), x) / math.cosh(k * h)
    moment = 2 * b * RHO * GRAVITY * np.trapezoid(z * wall, z) + floor
    moved = 1 / float(mode.rise)
    assert float(mode.mass * mode.omega2 * moved) == pytest.approx(force, rel=1e-6)
    height = float(mode.height) - h
    assert height * force + float(mode.mass) * GRAVITY * moved == pytest.approx(moment, rel=1e-6)


def test_the_mode_of_a_round_tank_shares_the_free_surface_as_the_sum_over_all_modes_says():
    """m_n g / omega_n^2 over all modes adds up to rho pi R^4 / 4: sum 8 / (xi_n^2 (xi_n^2 - 1)) = 1."""
    xi = jnp_zeros(1, 400)
    assert np.sum(8 / (xi**2 * (xi**2 - 1))) == pytest.approx(1, abs=1e-7)
    mode = round_mode(2.0, 3.0, RHO, GRAVITY)
    assert float(mode.mass) * GRAVITY / float(mode.omega2) / (RHO * math.pi * 4) == pytest.approx(ROUND, rel=1e-12)


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_the_mode_swings_out_as_its_damping_says(solver):
    """Y = y_0 exp(-zeta omega t) (cos + zeta / sqrt(1 - zeta^2) sin)(omega_d t), of a tank that stands still."""
    a, b, depth, zeta = 5.0, 3.0, 2.0, 0.03
    model = fw.Assembly("standing tank")
    model.world = World()
    model.tank = BoxTank(
        length=a, width=b, height=8, volume_start=a * b * depth, sloshing=True, slosh_damping=zeta, walls_wet=True
    )
    model.connect(model.world.frame, model.tank.frame)
    more = {"step": 0.004} if solver == "fixed" else {"tolerance": 1e-9}
    result = fw.load(model).compile().simulate(20, 0.1, solver=solver, start={"tank.slosh[0]": 0.2}, **more)
    t = result.time
    omega = math.sqrt(GRAVITY * math.pi / a * math.tanh(math.pi * depth / a))
    damped = omega * math.sqrt(1 - zeta**2)
    swing = np.cos(damped * t) + zeta * omega / damped * np.sin(damped * t)
    assert np.max(np.abs(result["tank.slosh"].values[:, 0] - 0.2 * np.exp(-zeta * omega * t) * swing)) < 2e-4 * 0.2
    force, mass = result["tank.frame.f"].values[:, 0], box_mode(a, b, depth, RHO, GRAVITY).mass
    assert np.max(np.abs(force - float(mass) * result["tank.slosh_acceleration"].values[:, 0])) < 1e-9 * np.max(force)


def test_a_sloshing_wave_that_comes_to_the_roof_stops_the_run():
    tank = BoxTank(length=5, width=3, height=2, volume_start=27, sloshing=True)
    plant = sliding(tank, 1e3)
    with pytest.raises(ModelError, match="sloshes along x by .* m at the wall, to its floor or roof"):
        plant.simulate(5, 0.1, start={"tank.slosh_velocity[0]": 1.0})


def test_a_ring_has_no_modes_and_damping_without_sloshing_does_nothing():
    with pytest.raises(ModelError, match="modes are known of box tanks and round tanks without an inner wall"):
        RoundTank(diameter=4, inner_diameter=1, height=2, volume_start=5, sloshing=True)
    with pytest.raises(ModelError, match="slosh_damping is given and would do nothing"):
        BoxTank(length=5, width=3, height=2, volume_start=5, slosh_damping=0.05)
