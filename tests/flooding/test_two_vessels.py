"""Two vessels joined by a pipe level out: period, decay, energy and volume."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, Pipe, RoundTank

GRAVITY = 9.80665


def vessels(pipe: Pipe, high: float = 3.2, low: float = 2.8) -> fw.Assembly:
    """A round and a square vessel of the same floor, 3 m2 each, with these levels."""
    model = fw.Assembly("two vessels")
    model.world = World()
    model.left = RoundTank(diameter=math.sqrt(12 / math.pi), height=6, volume_start=3 * high)
    model.right = BoxTank(length=2, width=1.5, height=6, volume_start=3 * low)
    model.pipe = pipe
    model.connect(model.world.frame, model.left.frame)
    model.connect(model.world.frame, model.right.frame)
    model.connect(model.left.water[0], model.pipe.water_a)
    model.connect(model.pipe.water_b, model.right.water[0])
    return model


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_water_swings_between_two_vessels_at_the_period_of_a_u_tube(solver):
    """Without turbulence: omega^2 = 2 g A_p / (A L), decay 32 nu / D^2 / 2 per second (Poiseuille), energy included."""
    L, D, nu, A = 12.0, 0.4, 2e-3, 3.0
    pipe = Pipe(length=L, diameter=D, viscosity=nu, loss_factor=0, roughness=0, inertia=True)
    plant = fw.load(vessels(pipe, 3.001, 2.999)).compile()
    more = {"step": 0.01} if solver == "fixed" else {"tolerance": 1e-9}
    result = plant.simulate(60, 0.05, solver=solver, **more)
    t, apart = result.time, result["pipe.head_drop"].values
    omega0, delta = math.sqrt(2 * GRAVITY * math.pi / 4 * D**2 / (A * L)), 16 * nu / D**2
    omega = math.sqrt(omega0**2 - delta**2)
    expected = 0.002 * np.exp(-delta * t) * (np.cos(omega * t) + delta / omega * np.sin(omega * t))
    assert np.max(np.abs(apart - expected)) < 2e-4 * 0.002
    total = result["left.volume"].values + result["right.volume"].values
    assert np.max(np.abs(total - 18.0)) < 1e-12


def test_the_energy_of_the_water_goes_into_friction():
    """Potential and kinetic energy fall by the integral of rho g Q times the head that is lost, at any speed."""
    pipe = Pipe(length=12, diameter=0.4, inertia=True)
    result = fw.load(vessels(pipe, 4.0, 2.0)).compile().simulate(80, 0.02, tolerance=1e-9)
    rho, area = 1025.0, math.pi / 4 * 0.4**2
    flow, drop = result["pipe.volume_flow"].values, result["pipe.head_drop"].values
    potential = sum(rho * GRAVITY * result[f"{side}.volume"].values ** 2 / 6 for side in ("left", "right"))
    kinetic = rho * 12 * flow**2 / area / 2
    lost = rho * GRAVITY * flow * (drop - 12 / (GRAVITY * area) * np.gradient(flow, result.time, edge_order=2))
    spent = np.concatenate([[0], np.cumsum((lost[1:] + lost[:-1]) / 2 * np.diff(result.time))])
    energy = potential + kinetic
    assert energy[0] - energy[-1] > 0.8 * rho * GRAVITY * 3.0  # 1 m apart of the mean on 3 m2 each
    assert np.max(np.abs(energy + spent - energy[0])) < 2e-4 * (energy[0] - energy[-1])


def test_two_vessels_are_level_at_rest_with_the_water_they_started_with():
    state = fw.load(vessels(Pipe(length=12, diameter=0.4), 5.0, 1.0)).compile().equilibrium()
    assert state["left.level"] == pytest.approx(3.0, abs=1e-6)
    assert state["left.volume"] + state["right.volume"] == pytest.approx(18.0, abs=1e-9)
