"""Rings of equal parts: how a Newton matrix that turns with a rotor serves the fixed-step engine."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, cyclic_symmetry, der, eq, var
from fowtlib.language.native import compiler
from fowtlib.solving.engines.reduction import reduction
from fowtlib.solving.engines.symmetry import cyclic_unknowns

WIND = {"wind.kind": "steady", "wind.mean_speed": 9.0}
needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")


@pytest.fixture(scope="module")
def plant():
    return fw.load("nrel5mw_land", set={**WIND, "turbine.assembly.blade_hinges": 2}).compile()


def test_unknowns_of_three_blades_are_found(plant):
    """Two hinges a blade, each with two angular accelerations; the pitch bearings are driven by their own rates."""
    dae = plant.dae
    (found,) = cyclic_unknowns(dae, reduction(dae))
    assert dae.states[found.state].path == "turbine.assembly.nacelle.bearing.phi"
    paths = [quantity.path for quantity in dae.algebraics] + [dae.states[i].path for i in reduction(dae).free]
    named = [tuple(paths[i].replace(f"_{k}.", "_*.", 1) for k, i in enumerate(group, 1)) for group in found.unknowns]
    for group in named:
        assert len(set(group)) == 1
    assert sum("blade_*" in group[0] for group in named) == 4
    assert sum("bearing_*" in group[0] for group in named) == 1
    assert len(found.rows) == len(found.unknowns)


@needs_compiler
def test_the_matrix_that_turns_leads_to_the_same_motion_with_less_work(plant, leads_to_the_same_motion_with_less_work):
    """Without the hint a step needs more evaluations; the motions agree as far as Newton's method is exact."""
    leads_to_the_same_motion_with_less_work(plant, "symmetries")


class _Line(Component):
    """Three masses that follow each other; the angle of the symmetry is given by the caller."""

    def build(self):
        for k in range(3):
            self.add(f"mass_{k + 1}", _Mass())

    def equations(self):
        return [cyclic_symmetry(self.parts["mass_1"].x, list(self.parts.values()))]


class _Mass(Component):
    """x'' = -x."""

    x: Scalar = var(doc="place", start=1.0)
    v: Scalar = var(doc="speed")

    def equations(self):
        return [eq(der(self.x), self.v), eq(der(self.v), -self.x)]


@needs_compiler
def test_a_wrong_hint_does_no_harm():
    """The angle of this symmetry is the place of one of its own masses, and nothing turns: x = cos t all the same."""
    result = fw.load(_Line()).compile().simulate(3.0, 0.1, solver="fixed", step=0.001)
    assert np.abs(result["mass_2.x"].values - np.cos(result.time)).max() < 1e-5


@pytest.mark.parametrize("name", ["oc3_spar", "two_rotor_spar", "nrel5mw_land"])
def test_balances_are_left_over_next_to_the_world(name):
    """The Newton-Euler recursion goes from the tips of the blades inwards, whatever else there is in a model."""
    paths = fw.load(name).compile().dae.residual_paths
    assert not [path for path in paths if "sum of the flows" in path and "blade" in path]
