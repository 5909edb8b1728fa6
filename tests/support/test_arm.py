"""Arms: axes, signs and sizes of their loads, cuts, and mistakes."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import BeamProperties, Fixed, PointMass, World, WorldForce, WorldTorque
from fowtlib.components.support import Arm, FlexibleTower
from fowtlib.language import Component, RealOutput, Vector, eq, param, port
from fowtlib.language.errors import ParameterError

G = 9.80665
TUBE = {"diameters": [4.79, 1.79], "wall_thicknesses": [0.028, 0.010]}


class Source(Component):
    """Three constant numbers."""

    value: Vector = param(doc="the numbers")
    y: RealOutput = port(shape=(3,), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


def loaded_arm(to, force=(0, 0, 0), torque=(0, 0, 0), gravity=0.0, head=1.0, **arm):
    model = fw.Assembly("arm")
    model.world, model.base, model.arm = World(gravity=gravity), Fixed(), Arm(to=to, **{**TUBE, **arm})
    model.head, model.force, model.torque = PointMass(mass=head), WorldForce(), WorldTorque()
    model.f, model.t = Source(value=force), Source(value=torque)
    for a, b in ((model.base.frame, model.arm.frame_a), (model.arm.tip, model.head.frame_a),
                 (model.f.y, model.force.force), (model.arm.tip, model.force.frame),
                 (model.arm.tip, model.torque.frame), (model.t.y, model.torque.torque)):  # fmt: skip
        model.connect(a, b)
    return fw.load(model).compile()


def moments(state, k=None):
    names = [f"cut_{n}[{k}]" if k is not None else f"root_{n}" for n in
             ("vertical_moment", "horizontal_moment", "torsion")]  # fmt: skip
    return [float(state[f"arm.{name}"]) for name in names]


@pytest.mark.parametrize("side", [1, -1])
def test_both_sides_have_equal_loads(side):
    """A weight bends down, a thrust downwind, a thrust above the arm twists: positive on both sides."""
    plant = loaded_arm((0, side * 50.0, 0), (3e5, 0, -2e5), (0, 4e5, 0), hinges=0, root_radius=2.0, cuts=[0.0, 18.0])
    state = plant.initial_state()
    assert moments(state) == pytest.approx([2e5 * 48, 3e5 * 48, 4e5], rel=1e-9)
    assert moments(state, 0) == pytest.approx(moments(state), rel=1e-9)
    assert moments(state, 1) == pytest.approx([2e5 * 30, 3e5 * 30, 4e5], rel=1e-9)
    R = np.reshape(state["arm.tip.R"], (3, 3))
    assert pytest.approx(np.eye(3), abs=1e-12) == R
    assert np.ravel(state["arm.tip.r"]) == pytest.approx([0, side * 50.0, 0])


@pytest.mark.parametrize("heading", [0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
@pytest.mark.parametrize("rise", [0.0, 0.3])
def test_any_direction(heading, rise):
    """Weight at the tip: weight times level distance, all of it vertical bending; no horizontal, no torsion."""
    a = np.radians(heading)
    state = loaded_arm((40 * np.cos(a), 40 * np.sin(a), 40 * rise), (0, 0, -1e5), hinges=0).initial_state()
    assert moments(state) == pytest.approx([1e5 * 40, 0, 0], rel=1e-9, abs=1e-4)
    push = loaded_arm((40 * np.cos(a), 40 * np.sin(a), 40 * rise), (1e5, 0, 0), hinges=0).initial_state()
    assert moments(push)[1] == pytest.approx(1e5 * 40 * np.hypot(1, rise) * abs(np.sin(a)), rel=1e-9, abs=1e-4)


def test_deflection_and_torsion():
    """Small loads on a tapered arm: unit loads integrated, in the axes of frame_a; the twist by the torque over GJ."""
    force, torque, L = (2e3, 0, -1e3), (0, 5e3, 0), 68.0
    plant = loaded_arm((0, 70.0, 0), force, torque, hinges=3, root_radius=2.0, torsion=True)
    state = plant.equilibrium()
    s = np.linspace(0, L, 8001)
    D, t = 4.79 - 3.0 * s / L, 0.028 - 0.018 * s / L
    inertia = np.pi / 64 * (D**4 - (D - 2 * t) ** 4)
    bend = np.trapezoid((L - s) ** 2 / (210e9 * inertia), s)
    assert np.ravel(state["arm.tip_displacement"]) == pytest.approx([2e3 * bend, 0, -1e3 * bend], rel=2e-3, abs=1e-6)
    twist = np.trapezoid(5e3 / (80.8e9 * 2 * inertia), s)
    R = np.reshape(state["arm.tip.R"], (3, 3))
    assert R[0, 2] == pytest.approx(twist, rel=2e-3)
    assert moments(state) == pytest.approx([1e3 * L, 2e3 * L, 5e3], rel=1e-3)


def test_damping_of_each_direction():
    plant = loaded_arm((0, 70.0, 0), head=1e5, hinges=2, damping_horizontal=0.004, damping_vertical=0.001)
    first = plant.linearize(plant.initial_state()).modes()[:2]
    found = sorted(mode.damping_ratio / (np.pi * mode.frequency_hz) for mode in first)
    assert found == pytest.approx([0.001, 0.004], rel=1e-6)


def test_section_loads_of_a_tower():
    """A weight off the axis of a tower bends it alike at any height; thrust bends it by the lever."""
    model = fw.Assembly("tower")
    model.world, model.base = World(gravity=G), Fixed()
    model.tower = FlexibleTower(heights=[0, 50], diameters=[5, 4], wall_thicknesses=[0.03, 0.02], hinges=2,
                                cuts=[0.0, 20.0, 50.0])  # fmt: skip
    model.arm = Arm(to=(0, 10.0, 0), hinges=0, table=BeamProperties.uniform(10.0, 1e-6, 1e12))
    model.head, model.push, model.thrust = PointMass(mass=2e3), WorldForce(), Source(value=(1e4, 0, 0))
    for a, b in ((model.base.frame, model.tower.frame_a), (model.tower.frame_b, model.arm.frame_a),
                 (model.arm.tip, model.head.frame_a), (model.tower.frame_b, model.push.frame),
                 (model.thrust.y, model.push.force)):  # fmt: skip
        model.connect(a, b)
    state = fw.load(model).compile().equilibrium()
    for k, height in enumerate([0.0, 20.0, 50.0]):
        assert state[f"tower.cut_side_side_moment[{k}]"] == pytest.approx(-2e3 * G * 10, rel=5e-3)
        assert state[f"tower.cut_fore_aft_moment[{k}]"] == pytest.approx(1e4 * (50 - height), rel=5e-3, abs=200)
    for name in ("fore_aft_moment", "side_side_moment", "torsion"):
        for k, end in ((0, "base"), (2, "top")):
            there = float(state[f"tower.{end}_{name}"])
            assert state[f"tower.cut_{name}[{k}]"] == pytest.approx(there, rel=1e-9, abs=1e-6)


def test_mistakes():
    with pytest.raises(ParameterError, match="Arm: an arm that points along z has no horizontal normal"):
        Arm(to=(0, 0, 5.0), **TUBE)
    with pytest.raises(ParameterError, match="Arm: the root, at 6 m, must lie before the tip"):
        Arm(to=(0, 5.0, 0), root_radius=6.0, **TUBE)
    with pytest.raises(ParameterError, match="the properties are those of 4 m, the arm is 5 m long"):
        Arm(to=(0, 5.0, 0), table=BeamProperties.uniform(4.0, 1.0, 1.0))
    with pytest.raises(ParameterError, match="Arm: give either properties, or diameters and wall_thicknesses"):
        Arm(to=(0, 5.0, 0), table=BeamProperties.uniform(5.0, 1.0, 1.0), **TUBE)
    with pytest.raises(ParameterError, match="Arm: heights, outer diameters and walls of a tube: as many of each"):
        Arm(to=(0, 5.0, 0), diameters=[4.0, 3.0], wall_thicknesses=[0.1])
