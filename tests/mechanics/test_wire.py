"""Wires: a guyed mast against its exact statics, energy, slackness, mass."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import fowtlib as fw
from fowtlib.components.mechanics import (
    AxialWire,
    Fixed,
    FixedTranslation,
    PointMass,
    Prismatic,
    Revolute,
    RigidBody,
    World,
    WorldForce,
)
from fowtlib.language import Component, RealOutput, Vector, eq, param, port

G, HEIGHT, REACH = 9.80665, 30.0, 20.0
GUY = float(np.hypot(HEIGHT, REACH))


class Source(Component):
    """Three constant numbers."""

    value: Vector = param(doc="the numbers")
    y: RealOutput = port(shape=(3,), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


def mast(force=0.0, gravity=G, damping=0.0, **wire):
    """A rigid mast of 5 t, hinged about y at its foot, with two guys in the plane x z and a force on its head."""
    model = fw.Assembly("guyed mast")
    model.world, model.joint = World(gravity=gravity), Revolute(n=(0, 1, 0))
    model.body = RigidBody(mass=5e3, inertia=np.diag([4e5, 4e5, 0]), r_cm=(0, 0, 14.0))
    model.head, model.load, model.source = FixedTranslation(r=(0, 0, HEIGHT)), WorldForce(), Source(value=(force, 0, 0))
    for a, b in ((model.world.frame, model.joint.frame_a), (model.joint.frame_b, model.body.frame_a),
                 (model.joint.frame_b, model.head.frame_a), (model.head.frame_b, model.load.frame),
                 (model.source.y, model.load.force)):  # fmt: skip
        model.connect(a, b)
    for name, x in (("upwind", -REACH), ("downwind", REACH)):
        anchor = model.add(f"anchor_{name}", Fixed(r=(x, 0, 0)))
        guy = model.add(name, AxialWire(length=GUY, damping=damping, **wire))
        model.connect(model.head.frame_b, guy.frame_a)
        model.connect(anchor.frame, guy.frame_b)
    return fw.load(model).compile()


def exact(force, pull):
    """Angle of the mast and tensions of the guys, upwind first; pull(distance) is the law of a guy."""

    def tensions(angle):
        head = HEIGHT * np.array([np.sin(angle), np.cos(angle)])
        lines = [np.array([x, 0.0]) - head for x in (-REACH, REACH)]
        return head, lines, [pull(np.linalg.norm(line)) for line in lines]

    def moment(angle):
        head, lines, found = tensions(angle)
        total = force * head[1] + 5e3 * G * 14.0 * np.sin(angle)
        for line, tension in zip(lines, found, strict=True):
            total += tension / np.linalg.norm(line) * (head[1] * line[0] - head[0] * line[1])
        return total

    angle = brentq(moment, -0.5, 0.5, xtol=1e-14)
    return angle, tensions(angle)[2]


@pytest.mark.parametrize("pretension", [0.0, 6e4])
def test_statics_of_a_guyed_mast(pretension):
    """Large turn (EA is low), both signs of the load are the mirror image of each other."""
    unstretched = GUY / (1 + pretension / 2e6)
    angle, tensions = exact(3e4, lambda d: pretension + 2e6 / unstretched * (d - GUY))
    assert angle > 0.02
    for sign in (1, -1):
        state = mast(sign * 3e4, axial_stiffness=2e6, pretension=pretension).equilibrium()
        assert state["joint.phi"] == pytest.approx(sign * angle, rel=1e-7)
        found = [float(state[f"{name}.tension"]) for name in ("upwind", "downwind")][::sign]
        assert found == pytest.approx(tensions, rel=1e-7)


def test_a_slack_guy_lets_go():
    """Tension only: the lee guy keeps next to nothing, the other carries it all, by the rounded law as documented."""
    law = {"axial_stiffness": 2e6, "tension_only": True, "slack_tension": 100.0}

    def pull(distance):
        linear = 2e6 / GUY * (distance - GUY)
        return (linear + np.hypot(linear, 100.0)) / 2

    angle, tensions = exact(3e4, pull)
    state = mast(3e4, **law).equilibrium()
    assert state["joint.phi"] == pytest.approx(angle, rel=1e-7)
    assert [float(state[f"{name}.tension"]) for name in ("upwind", "downwind")] == pytest.approx(tensions, rel=1e-6)
    assert 0 < tensions[1] < 0.2 < 4e4 < tensions[0]
    assert mast(**law).equilibrium()["upwind.tension"] == pytest.approx(50.0, rel=1e-6)


@pytest.mark.filterwarnings("ignore:.*the wire is in compression")
@pytest.mark.parametrize("tension_only", [False, True])
def test_energy(tension_only):
    """A swinging mast keeps its energy, also through slack guys; the energy of the rounded law is its integral."""
    stiffness, eps = 1e6 / GUY, 2000.0
    plant = mast(axial_stiffness=1e6, tension_only=tension_only, slack_tension=eps)
    result = plant.simulate(6.0, output_step=0.02, start=plant.initial_state(start={"joint.w": 0.25}), tolerance=1e-10)
    phi, w = (np.asarray(result[f"joint.{name}"]) for name in ("phi", "w"))
    energy = 0.5 * (4e5 + 5e3 * 14.0**2) * w**2 + 5e3 * G * 14.0 * (np.cos(phi) - 1)
    slack = 0.0
    for name in ("upwind", "downwind"):
        linear = stiffness * (np.asarray(result[f"{name}.distance"]) - GUY)
        tension = np.asarray(result[f"{name}.tension"])
        if tension_only:
            root = np.hypot(linear, eps)
            energy = energy + (linear**2 + linear * root + eps**2 * np.arcsinh(linear / eps)) / (4 * stiffness)
            slack = max(slack, -linear.min())
            assert tension.min() >= 0
        else:
            energy = energy + linear**2 / (2 * stiffness)
    assert np.ptp(energy) < 1e-6 * np.ptp(0.5 * (4e5 + 5e3 * 14.0**2) * w**2)
    assert slack > 10 * eps or not tension_only


def test_damping_takes_energy_and_cannot_push():
    plant = mast(axial_stiffness=1e6, tension_only=True, slack_tension=500.0, damping=5e4)
    result = plant.simulate(6.0, output_step=0.02, start=plant.initial_state(start={"joint.w": 0.25}), tolerance=1e-8)
    assert min(np.asarray(result[f"{name}.tension"]).min() for name in ("upwind", "downwind")) >= 0
    w = np.asarray(result["joint.w"])
    assert np.abs(w[-50:]).max() < 0.2 * np.abs(w[:50]).max()


def test_natural_frequency_with_the_mass_of_the_wire():
    """A mass on a vertical wire: omega^2 = EA / (l (m + mu l / 2)); at rest the wire carries both weights."""
    mu, l0, m = 12.0, 40.0, 900.0
    model = fw.Assembly("hanging mass")
    model.world, model.top = World(gravity=G), Fixed(r=(0, 0, l0))
    model.rail, model.mass = Prismatic(n=(0, 0, 1)), PointMass(mass=m)
    model.wire = AxialWire(axial_stiffness=3e6, length=l0, mass_per_length=mu)
    for a, b in ((model.world.frame, model.rail.frame_a), (model.rail.frame_b, model.mass.frame_a),
                 (model.rail.frame_b, model.wire.frame_a), (model.top.frame, model.wire.frame_b)):  # fmt: skip
        model.connect(a, b)
    plant = fw.load(model).compile()
    state = plant.equilibrium()
    assert state["wire.tension"] == pytest.approx((m + mu * l0 / 2) * G, rel=1e-9)
    mode = plant.linearize(state).modes()[0]
    assert 2 * np.pi * mode.frequency_hz == pytest.approx(np.sqrt(3e6 / l0 / (m + mu * l0 / 2)), rel=1e-6)


def test_a_wire_that_pushes_is_said():
    plant = mast(3e4, axial_stiffness=2e6)
    with pytest.warns(UserWarning, match="the wire is in compression: give it more pretension, or tension_only"):
        plant.simulate(0.1, output_step=0.05, start=plant.equilibrium())
