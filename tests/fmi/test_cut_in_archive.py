"""A step that is not solved is cut in an archive as it is in a run in Python, and an importer hears of it once."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Scalar, der, eq, var
from fowtlib.language import math as m


class Block(fw.Component):
    """A block that friction of 4 N/kg brings to rest, and that sticks from 0.5 s on."""

    x: Scalar = var(unit="m", fixed=True, state="prefer", doc="way")
    v: Scalar = var(unit="m/s", start=2.0, fixed=True, state="prefer", doc="speed")

    def equations(self):
        return [eq(der(self.x), self.v), eq(der(self.v), -4 * m.tanh(self.v / 3e-3))]


def test_a_step_is_cut_as_in_python(as_unit, instance_of):
    root = fw.Assembly("block")
    root.block = Block()
    settings = {"solver": "fixed", "step": 0.05, "rho_inf": 0.0, "output_step": 0.05}
    plant = fw.Model(root, "block", {"way": fw.Output("block.x")}, settings, name="block").compile()
    with pytest.warns(UserWarning, match=r"the step at t = 0\.5 s was not solved at once") as told:
        run = plant.simulate(1.0)
    one = instance_of(as_unit(plant)).begin()
    rows = one.run(["way"], 20, 0.05)
    np.testing.assert_array_equal(rows[:, 0], run.array("way")[1:])
    (said,) = [text for status, text in one.said if status == 1]  # fmi3Warning
    alike = str(told[0].message).partition(" Something")[0].removesuffix(".")
    assert said.startswith(f"block: {alike}") and "solver.step" in said
