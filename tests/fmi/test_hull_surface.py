"""The surface of a hull that floats at any attitude travels in an archive."""

from __future__ import annotations

import numpy as np

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.hydro.linear_loads import LinearDamping
from fowtlib.components.mechanics import FreeMotion, RigidBody
from fowtlib.components.platform import Floater, LumpedMass, MemberHydrostatics, RectangularMember


def test_a_box_capsizes_in_an_archive_as_it_does_here(as_unit):
    root = fw.Assembly("box")
    root.world, root.motion = World(water_depth=50.0), FreeMotion(roll_start=0.3)
    root.hull, root.spin = Floater(), RigidBody(mass=0.0, inertia=np.diag([2e7, 2e7, 2e7]).tolist())
    root.damping = LinearDamping(translation=(2e5, 2e5, 2e5), rotation=(4e6, 4e6, 4e6))
    root.hull.box = RectangularMember(start=(-10, 0, 0), end=(10, 0, 0), widths=6.0, heights=10.0, wall_thickness=0.0)
    root.hull.box.load = LumpedMass(mass=615e3, place=(0, 0, 2.0))
    root.hull.hydrostatics = MemberHydrostatics()
    root.connect(root.world.frame, root.motion.frame_a)
    for frame in (root.hull.frame, root.spin.frame_a, root.damping.frame):
        root.connect(root.motion.frame_b, frame)
    model = fw.Model(root, "box", {"roll": fw.Output("motion.roll")}, {"output_step": 0.5}, name="box")
    plant = model.compile()
    unit = as_unit(plant, step=0.02)
    rows = unit.simulate("cs", 20.0, 0.5, ["roll"])
    here = plant.simulate(20.0, solver="fixed", step=0.02)
    assert np.ptp(rows["roll"]) > 1.5
    np.testing.assert_allclose(rows["roll"], np.asarray(here["roll"]), rtol=0, atol=1e-6)
