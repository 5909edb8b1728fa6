"""A line with dynamics in an archive: its shape at rest is numbers of the run, its axial modes are stiff."""

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import World
from fowtlib.components.mechanics.forced_motion import ForcedOscillation
from fowtlib.components.mooring import DynamicLine
from fowtlib.flattening.flat_dae import Check
from fowtlib.fmi.guards import by_step, guarded


@pytest.fixture(scope="module")
def moved():
    root = fw.Assembly("line")
    root.world = World(water_depth=320)
    root.drive = ForcedOscillation(r=(858.67, 0, -70), speed_amplitude=1.2, period=10)
    root.line = DynamicLine(lengths=902.2, elements=6, anchor_position=(0, 0, -320), axial_stiffness=384.243e6,
                            mass_per_length=77.7066, diameter=0.09)  # fmt: skip
    root.connect(root.drive.frame, root.line.fairlead)
    outputs = {"tension": fw.Output("line.tension"), "middle": fw.Output("line.positions[2,3]")}
    return fw.Model(root, "line", outputs, {"output_step": 0.1}, name="line").compile()


@pytest.mark.long
def test_an_archive_runs_as_the_model_does(moved, as_unit):
    unit = as_unit(moved, step=0.0125)
    run = moved.simulate(10.0, output_step=0.1, solver="fixed", step=0.0125)
    rows = unit.simulate("cs", 10.0, 0.1, ["tension", "middle"])
    for name in ("tension", "middle"):
        np.testing.assert_allclose(rows[name], run[name], rtol=1e-9)
    assert np.ptp(rows["tension"]) > 2e5


def test_an_archive_tells_of_steps_that_are_too_long_for_a_snap(moved):
    """The condition on steps is a warning of the engine inside, broken where its steps are longer and it is quick."""
    inside = guarded(moved, moved.binding(None), 0.0125).dae
    assert "step" in {check.level for check in moved.dae.checks}
    (check,) = [check for check in inside.checks if "its ends part at" in check.message]
    assert check.level == "warning" and check.message.endswith("; the engine inside has steps of 0.0125 s")
    calm, seconds = ca.SX.sym("calm"), ca.SX.sym("seconds")
    warning = by_step(Check(calm, "said", "step", {"seconds": seconds}, "line"), 0.0125)
    holds = ca.Function("holds", [calm, seconds], [warning.condition])
    assert [float(holds(*given)) for given in ((0, 0.0124), (0, 0.0125), (1, 0.001))] == [0, 1, 1]
