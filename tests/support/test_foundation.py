"""Foundations and soil: closed forms of beams on springs, laws of sand and clay, and mistakes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import PointMass, RigidBody, World, WorldForce
from fowtlib.components.support import (
    FlexibleTower,
    Foundation,
    PileInClay,
    PileInLinearSoil,
    PileInSand,
)
from fowtlib.components.support.soil_springs import sand_coefficients
from fowtlib.language import Component, RealOutput, Vector, eq, param, port
from fowtlib.language.errors import ParameterError

K = np.diag([2e9, 2e9, 8e9, 3e11, 3e11, 1e11])
K[0, 4] = K[4, 0] = -1.5e10
K[1, 3] = K[3, 1] = 1.5e10


class Source(Component):
    """Three constant numbers."""

    value: Vector = param(doc="the numbers")
    y: RealOutput = port(shape=(3,), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


def loaded(model, frame, force):
    """The equilibrium of a model with a force on a frame."""
    model.load, model.given = WorldForce(), Source(value=force)
    model.connect(model.given.y, model.load.force)
    model.connect(frame, model.load.frame)
    return fw.load(model).compile()


def on_foundation(force=(0, 0, 0), gravity=0.0, **settings):
    model = fw.Assembly("on a foundation")
    model.world, model.base = World(gravity=gravity), Foundation(**{"stiffness": K, **settings})
    model.body = RigidBody(mass=5e5, inertia=np.diag([1e8, 1e8, 1e7]), r_cm=(0, 0, 50.0))
    model.connect(model.world.frame, model.base.frame_a)
    model.connect(model.base.frame_b, model.body.frame_a)
    return loaded(model, model.base.frame_b, force)


def test_a_foundation_gives_way_as_its_matrix_says():
    force = (1e6, -2e5, 0)
    state = on_foundation(force).equilibrium()
    moved = np.linalg.solve(K, [*force, 0, 0, 0])
    found = [*state["base.spring.displacement"], *state["base.spring.angle"]]
    np.testing.assert_allclose(found, moved, rtol=1e-4, atol=1e-12)  # the matrix is linear, the turn is not


def test_a_mass_on_a_tower_on_a_foundation_has_the_frequency_of_its_flexibilities():
    """A massless cantilever: 1 / omega^2 = M (L^3 / 3 EI + compliance of the foundation at the top)."""
    mass, length, diameter, wall = 4e5, 80.0, 6.0, 0.04
    model = fw.Assembly("tower on a foundation")
    model.world, model.base = World(gravity=0), Foundation(stiffness=K)
    model.tower = FlexibleTower(
        heights=[0, length], diameters=[diameter] * 2, wall_thicknesses=[wall] * 2, density=5.0, hinges=10,
        damping_fore_aft=0.0,
    )
    model.head = RigidBody(mass=mass, inertia=np.diag([1.0, 1.0, 1.0]))
    model.foot = RigidBody(mass=1.0, inertia=np.eye(3))
    for a, b in ((model.world.frame, model.base.frame_a), (model.base.frame_b, model.tower.frame_a),
                 (model.base.frame_b, model.foot.frame_a), (model.tower.frame_b, model.head.frame_a)):  # fmt: skip
        model.connect(a, b)
    plant = fw.load(model).compile()
    modes = plant.linearize(plant.initial_state()).modes()
    inner = diameter - 2 * wall
    stiffness = 210e9 * math.pi / 64 * (diameter**4 - inner**4)
    lever = np.array([1, 0, 0, 0, length, 0])
    give = length**3 / (3 * stiffness) + lever @ np.linalg.solve(K, lever)
    expected = 1 / (2 * math.pi * math.sqrt(mass * give))
    assert min(mode.frequency_hz for mode in modes) == pytest.approx(expected, rel=2e-3)


def test_a_foundation_keeps_the_energy():
    plant = on_foundation(gravity=9.80665)
    start = plant.initial_state({"base.motion.surge_start": 0.02})
    result = plant.simulate(5.0, output_step=0.05, solver="idas", tolerance=1e-9, start=start)
    moved = np.column_stack([result["base.spring.displacement"], result["base.spring.angle"]])
    spring = 0.5 * np.einsum("ti,ij,tj->t", moved, K, moved)
    assert np.ptp(spring) > 1e3
    v, w = result["body.v"].values, result["body.frame_a.w"].values
    body = 2.5e5 * (v**2).sum(axis=1) + 0.5 * (w**2) @ [1e8, 1e8, 1e7]
    upright = np.cos(result["base.motion.pitch"].values) * np.cos(result["base.motion.roll"].values)
    height = result["base.spring.displacement"].values[:, 2] + 50 * upright
    total = spring + body + 5e5 * 9.80665 * height
    assert np.ptp(total) < 2e-3 * np.ptp(body)


@pytest.mark.parametrize(("stiffness", "said"), [
    (K + np.eye(6, k=1) * 1e9, "a stiffness is symmetric"),
    (K * np.where(np.eye(6), 1, 2), "positive definite"),
    (np.zeros((6, 6)), "positive definite"),
])  # fmt: skip
def test_a_matrix_that_is_no_stiffness_is_refused(stiffness, said):
    with pytest.raises(ParameterError, match=said):
        on_foundation(stiffness=stiffness)


PILE = {"heights": [-60.0, -20.0, -18.0], "diameters": [3.0] * 3, "wall_thicknesses": [0.05] * 3, "mudline": -20.0}


def piled(pile, force):
    model = fw.Assembly("pile")
    model.world, model.pile, model.head = World(gravity=0), pile, PointMass(mass=1e3)
    for a, b in ((model.world.frame, model.pile.ground), (model.pile.head, model.head.frame_a)):
        model.connect(a, b)
    return loaded(model, model.pile.head, force)


def test_a_long_pile_in_linear_soil_bends_as_hetenyi_says():
    """M. Hetenyi, Beams on Elastic Foundation (1946): head of a half-infinite beam under a force H and a moment M."""
    k, force, arm = 5e7, 1e6, 2.0
    state = piled(PileInLinearSoil(**PILE, hinges=40, springs=40, lateral_stiffness=k), (force, 0, 0)).equilibrium()
    stiffness = 210e9 * math.pi / 64 * (3.0**4 - 2.9**4)
    beta = (k / (4 * stiffness)) ** 0.25
    assert beta * 40 > 4
    assert state["pile.mudline_displacement"][0] == pytest.approx(
        2 * force * beta / k + 2 * force * arm * beta**2 / k, rel=5e-3
    )
    assert state["pile.mudline_fore_aft_moment"] == pytest.approx(force * arm, rel=1e-3)


def test_a_pile_leans_to_where_it_is_pushed():
    """Every direction is alike."""
    pile = PileInSand(**PILE, friction_angle=math.radians(33), modulus_gradient=2e7)
    force = 2e6
    along = piled(pile, (force, 0, 0)).equilibrium()["pile.mudline_displacement"]
    pile = PileInSand(**PILE, friction_angle=math.radians(33), modulus_gradient=2e7)
    aslant = piled(pile, (force * 0.6, force * 0.8, 0)).equilibrium()["pile.mudline_displacement"]
    assert along[1] == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(aslant, [0.6 * along[0], 0.8 * along[0]], rtol=1e-6)


def test_coefficients_of_sand():
    """Read from the chart of API RP 2A, which they draw: 1.9, 2.7, 29 at 30 deg; 4.6, 4.3, 100 at 40 deg; to 5 %."""
    for angle, chart in ((30, (1.9, 2.7, 29)), (40, (4.6, 4.3, 100))):
        np.testing.assert_allclose([float(c) for c in sand_coefficients(math.radians(angle))], chart, rtol=0.05)


def test_sand_and_clay_follow_their_laws():
    depth, diameter = 5.0, 2.0
    pile = {"heights": [-10.0, 0.0], "diameters": [diameter] * 2, "wall_thicknesses": [1.0 - 1e-6] * 2, "mudline": 0.0}
    sand = PileInSand(**pile, springs=1, hinges=0, friction_angle=math.radians(35), modulus_gradient=2e7)
    clay = PileInClay(**pile, springs=1, hinges=0, shear_strength=5e4)
    c1, c2, c3 = (float(c) for c in sand_coefficients(math.radians(35)))
    strength = 1e4 * depth * min(c1 * depth + c2 * diameter, c3 * diameter)
    spring = sand.spring(depth, diameter, place=(0, 0, 0), length=1.0, axial_stiffness=1.0, torsional_stiffness=1.0)
    given = {"friction_angle": math.radians(35), "unit_weight": 1e4, "modulus_gradient": 2e7}
    for distance in (1e-4, 0.01, 0.5):
        expected = 0.9 * strength * math.tanh(2e7 * depth * distance / (0.9 * strength))
        assert _force(spring, distance, given) == pytest.approx(expected, rel=1e-9)
    spring = clay.spring(depth, diameter, place=(0, 0, 0), length=1.0, axial_stiffness=1.0, torsional_stiffness=1.0)
    given = {"shear_strength": 5e4, "unit_weight": 8e3, "strain_50": 0.01, "shape": 0.5, "initial_stiffness": 10.0}
    strength = min(3 + 8e3 * depth / 5e4 + 0.5 * depth / diameter, 9) * 5e4 * diameter
    half = 2.5 * 0.01 * diameter
    assert _force(spring, half, given) == pytest.approx(strength / 2, rel=1e-3)
    assert _force(spring, 8 * half, given) == pytest.approx(strength * 2**-0.05, rel=1e-3)
    assert _force(spring, 20 * half, given) == pytest.approx(strength, rel=1e-3)
    slope = 10 * strength / (diameter * 0.01**0.25)
    assert _force(spring, 1e-7, given) == pytest.approx(slope * 1e-7, rel=1e-3)


def _force(spring, distance, given):
    """P [N/m] at a distance, with numbers for the parameters that a pile hands on."""
    for name, value in given.items():
        setattr(spring, name, value)
    return float(spring.secant(distance)) * distance


def test_a_pile_in_clay_is_solved():
    """The reaction of the soil balances the push; in clay of half the strength the head goes further."""
    pushed = [
        piled(PileInClay(**PILE, springs=10, hinges=10, shear_strength=c), (2e6, 0, 0)).equilibrium()
        for c in (1e5, 5e4)
    ]
    assert pushed[0]["pile.mudline_fore_aft_moment"] == pytest.approx(2e6 * 2.0, rel=1e-3)
    assert pushed[1]["pile.mudline_displacement"][0] > 1.5 * pushed[0]["pile.mudline_displacement"][0] > 0


def test_a_mudline_off_the_pile_is_refused():
    with pytest.raises(ParameterError, match="mudline"):
        piled(PileInLinearSoil(**{**PILE, "mudline": -70.0}, lateral_stiffness=1e7), (0, 0, 0))


def test_the_surrogate_on_its_jacket_has_the_mode_of_the_turbine_it_stands_for():
    """0.3675 Hz: C. Serret (2019), table 3.3; without wind, to 2 %. Tower, rotor and nacelle weigh 800 to 840 t."""
    plant = fw.load("surrogate_7mw_foundation").compile()
    still = plant.equilibrium({"wind.kind": "none"})
    modes = plant.linearize(still, outputs=[]).modes()
    lowest = sorted(mode.frequency_hz for mode in modes if mode.frequency_hz > 0.05 and mode.damping_ratio < 0.5)
    assert lowest[:2] == pytest.approx([0.3675, 0.3675], rel=0.02)
    result = plant.simulate(3.0, output_step=0.1)
    weight = float(np.mean(result["tower_base_Fz"].values[-10:]))
    assert 800 < weight / 9.80665 < 845
