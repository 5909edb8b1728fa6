"""Conditions of level "step": what is too quick for the steps or the output points of a run is told once."""

from __future__ import annotations

import warnings

import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, assert_, der, eq, param, var
from fowtlib.language.errors import StructureError
from fowtlib.solving.engines.twin import FixedStepTwin


class Cooling(Component):
    """It is quick where it is below a half, and steps of 20 ms resolve it."""

    seconds: Scalar = param(default=0.02, unit="s", doc="what resolves it")
    x: Scalar = var(unit="1", start=1.0, state="prefer", doc="state")

    def equations(self):
        said = "x is {x}, and needs steps of {seconds} s"
        return [eq(der(self.x), -self.x), assert_(self.x > 0.5, said, "step", seconds=self.seconds, x=self.x)]


def told(plant, output_step, **more):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        result = plant.simulate(1.0, output_step, **more)
    said = [str(one.message) for one in found]
    assert result.attributes["warnings"] == "\n".join(said)
    return said


def test_a_run_is_told_once_what_of_it_is_too_coarse():
    plant = fw.load(Cooling()).compile()
    assert told(plant, 0.02, solver="fixed", step=0.02) == []
    (said,) = told(plant, 0.1, solver="fixed", step=0.05)
    expected = "needs steps of 0.02 s; this run has steps of 0.05 s and output points every 0.1 s (t = 0.7 s)."
    assert said.endswith(expected)
    (said,) = told(plant, 0.1, solver="fixed", step=0.02)
    assert said.endswith("; this run has output points every 0.1 s (t = 0.7 s).")
    assert told(plant, 0.1, solver="fixed", step=0.05, parameters={"seconds": 0.1}) == []
    (said,) = told(plant, 0.1, solver="idas")
    assert said.endswith("; this run has output points every 0.1 s (t = 0.7 s).")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plant.initial_state(start={"x": 0.1})
    assert FixedStepTwin(plant.at(), 0.05, 1e-6, 0.8).attributes["step"] == 0.05


def test_it_must_say_what_resolves_it():
    class Silent(Component):
        x: Scalar = var(unit="1", start=1.0, state="prefer", doc="state")

        def equations(self):
            return [eq(der(self.x), -self.x), assert_(self.x > 0.5, "x is quick", "step")]

    with pytest.raises(StructureError, match="needs the value `seconds`"):
        fw.load(Silent()).compile()
