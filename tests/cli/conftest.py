"""A damped pendulum of 1 m on the command line, under the name `pendulum`."""

from __future__ import annotations

import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import FixedFlange, FixedTranslation, PointMass, Revolute, TorsionSpringDamper


def pendulum() -> fw.Model:
    root = fw.Assembly("pendulum")
    root.world = World(gravity=9.81)
    root.hinge = Revolute(n=(0, 1, 0), phi_start="20 deg")
    root.rod = FixedTranslation(r=(0, 0, -1.0))
    root.bob = PointMass(mass=2.0)
    root.damper = TorsionSpringDamper(stiffness=0.0, damping=0.5)
    root.ground = FixedFlange()
    root.connect(root.world.frame, root.hinge.frame_a)
    root.connect(root.hinge.frame_b, root.rod.frame_a)
    root.connect(root.rod.frame_b, root.bob.frame_a)
    root.connect(root.hinge.flange, root.damper.flange_b)
    root.connect(root.damper.flange_a, root.ground.flange)
    outputs = {"pitch": fw.Output("hinge.phi", "deg", "angle of the rod")}
    return fw.Model(root, "a pendulum", outputs, {"duration": 5.0, "output_step": 0.02}, name="pendulum")


@pytest.fixture
def shipped_pendulum(monkeypatch: pytest.MonkeyPatch, tmp_path):
    """`fowt COMMAND pendulum`, in an empty folder."""
    monkeypatch.setattr(fw, "load", lambda name, **_: pendulum(), raising=False)
    monkeypatch.chdir(tmp_path)
