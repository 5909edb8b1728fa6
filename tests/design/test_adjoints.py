"""Slopes by adjoints beside differences, and the rules of design in a file, where both are there."""

from functools import cache

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.design import Design, DesignCase, Variable, read_design
from fowtlib.language.errors import ModelError

frequency = pytest.importorskip("fowtlib.frequency")
exact = pytest.mark.skipif(not hasattr(frequency, "PreparedGradient"), reason="there are no adjoints here")


@cache
def spar():
    return fw.load("two_rotor_spar_design").compile()


def hull(slopes, variables=None):
    variables = variables or [Variable("diameter", 9, 12), Variable("draft", 110, 150)]
    limits = ["pitch < 5 deg", "upwind_tension < 4000 kN", "period of heave > 25 s"]
    return Design(spar(), variables, "hull: mass", limits, free=["ballast"], targets={"heave": 0}, slopes=slopes)


@exact
def test_slopes_with_ballast_that_fills_are_those_of_differences():
    x = np.array([10.7, 133.0])
    one, other = (hull(slopes).results.evaluate(x, jacobian=True) for slopes in ("adjoint", "differences"))
    assert list(one.values) == list(other.values)
    for key, slope in other.jacobian.items():
        assert one.values[key] == pytest.approx(other.values[key], rel=1e-8)
        assert one.jacobian[key] == pytest.approx(slope, rel=1e-5)
        assert one.units[key[1]] == other.units[key[1]]


@exact
def test_slopes_with_the_ballast_of_another_case():
    """The ballast of the case at rest counts under thrust, too, and so does its slope."""
    variables = [Variable("diameter", 9, 12), Variable("draft", 110, 150)]
    cases = [DesignCase("thrust"), DesignCase("rest", {"thrust": 0})]
    one, other = (
        Design(spar(), variables, "hull: mass", ["pitch @ thrust < 5 deg", "heave > -9"], cases, free=["ballast"],
               targets={"heave": 0}, balance="rest", slopes=slopes).results.evaluate(np.array([10.7, 133.0]), True)
        for slopes in ("adjoint", "differences")
    )  # fmt: skip
    for key, slope in other.jacobian.items():
        assert one.values[key] == pytest.approx(other.values[key], rel=1e-7, abs=1e-9)
        assert one.jacobian[key] == pytest.approx(slope, rel=1e-5, abs=1e-7)


@exact
def test_the_same_optimum():
    one, other = hull("adjoint").optimise(), hull("differences").optimise()
    assert one.converged and one.value == pytest.approx(other.value, rel=1e-6) and one.active == other.active


@exact
def test_slopes_of_a_response_are_those_of_differences():
    plant = fw.load("oc3_spar_rigid").compile()
    weather = {"wind.mean_speed": 18.0, "wind.kind": "kaimal", "sea.spectrum": "jonswap",
               "sea.significant_wave_height": 4.0, "sea.peak_period": 10.0}  # fmt: skip
    stiffness, length = "platform.mooring.yaw_stiffness", "platform.mooring.length"
    variables = [Variable(stiffness, 5e7, 2e8), Variable(length, 850, 950)]
    limits = ["largest pitch < 20 deg", "range of fairlead_tension_2 < 1e6", "pitch < 9 deg"]
    one, other = (
        Design(plant, variables, "std of yaw", limits, [DesignCase("storm", weather)], slopes=slopes)
        for slopes in ("adjoint", "differences")
    )
    x = one.space.start
    fine, rough = (design.results.evaluate(x, jacobian=True) for design in (one, other))
    for key, slope in rough.jacobian.items():
        assert fine.values[key] == pytest.approx(rough.values[key], rel=1e-3)  # of other frequencies
        assert fine.jacobian[key] * one.space.scale == pytest.approx(
            slope * one.space.scale, rel=1e-2, abs=1e-4 * abs(float(rough.values[key][0]))
        )


def test_slopes_have_a_name():
    with pytest.raises(ModelError, match="slopes are by 'differences' or 'adjoint', not by 'magic'"):
        hull("magic")


TOWER = """fowtlib_design: 1
model: two_rotor_support_design
set: {pretension: 7240 kN}
variables:
  base_diameter: {lower: 5.5 m, upper: 12 m}
  base_wall: {lower: 15 mm, upper: 60 mm}
functions:
  stress: {formula: -1e6 * 1.485 * s, of: {s: tower_stress}, unit: Pa}
  radius: {formula: (base_diameter - base_wall) / 2, unit: m}
  buckling:
    rule: tower_buckling
    of: {meridional_stress: stress, radius: radius, thickness: base_wall, length: 10}
    take: utilisation
objective: "support: mass"
constraints: [tower_utilization < 0.714, buckling < 1]
optimiser: {method: slsqp}
"""


def test_rules_are_functions_of_a_file(tmp_path):
    rules = pytest.importorskip("fowtlib.design.rules")
    path = tmp_path / "tower.yaml"
    path.write_text(TOWER)
    file = read_design(path)
    found = file.design.optimise(**file.optimiser)
    assert found.converged and found.active == ["buckling <"]
    told = found.results["design"]
    wall, radius = found["base_wall"], (found["base_diameter"] - found["base_wall"]) / 2
    asked = rules.tower_buckling(told["stress"], radius, wall, 10.0)
    assert told["buckling"] == pytest.approx(float(asked.utilisation), rel=1e-9)
    for old, new, message in (
        ("rule: tower_buckling", "rule: tower_bukling", ":11: there is no rule 'tower_bukling'; did you mean"),
        ("radius: radius", "radus: radius", ":12: the rule 'tower_buckling' takes no 'radus'; did you mean 'radius'"),
        ("thickness: base_wall, ", "", ":11: the rule 'tower_buckling' needs 'thickness'"),
        ("take: utilisation", "take: use", "has no 'use'"),
    ):
        path.write_text(TOWER.replace(old, new, 1))
        with pytest.raises(ModelError) as error:
            read_design(path).design.evaluate()
        assert message in str(error.value)
