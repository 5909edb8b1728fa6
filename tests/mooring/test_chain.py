"""Chain by its diameter: printed numbers, and a mooring whose diameter is a variable."""

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, World
from fowtlib.components.mooring import ChainMooring, catenary, chain
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError

SPAR = {"headings": np.radians([60.0, 180.0, 300.0]), "fairlead_radius": 7.0, "fairlead_depth": 10.7,
        "anchor_radius": 1440.0, "anchor_depth": 320.0, "length": 1497.2}  # fmt: skip


def test_the_printed_chain_of_81_mm():
    assert chain.weight_in_water(0.081) == pytest.approx(1230.2, abs=0.1)
    assert chain.axial_stiffness(0.081) == pytest.approx(590.5e6, rel=1e-4)
    assert chain.breaking_load(0.081) == pytest.approx(6.745e6, rel=1e-4)
    assert chain.breaking_load(0.081, "R5") > chain.breaking_load(0.081, "R4S") > chain.breaking_load(0.081, "R4")
    # mass and displaced water give the weight back
    again = catenary.weight_in_water(chain.mass(0.081), chain.bar_diameter(0.081), 9.80665, 1025.0)
    assert again == pytest.approx(1230.2, abs=0.1)
    assert chain.mass(0.081) / 0.081**2 == pytest.approx(21.9e3, rel=5e-3)  # stud link chain, catalogues of makers
    with pytest.raises(ParameterError, match="grade 'R6' of chain: there are R3"):
        chain.breaking_load(0.081, "R6")


def test_formulas_of_arrays_and_expressions():
    D = np.array([0.06, 0.081, 0.1])
    d = ca.SX.sym("d")
    for formula in (chain.weight_in_water, chain.mass, chain.bar_diameter, chain.axial_stiffness, chain.breaking_load):
        value = ca.Function("f", [d], [formula(d), ca.jacobian(formula(d), d)])
        for one, of_array in zip(D, formula(D), strict=True):
            out, slope = (float(item) for item in value(one))
            assert out == pytest.approx(of_array, rel=1e-12)
            step = 1e-5
            assert slope == pytest.approx((formula(one + step) - formula(one - step)) / (2 * step), rel=1e-6)


def moored(**values):
    model = Assembly("moored")
    model.world = World(water_depth=320.0)
    model.hull = Fixed(r=(0, 0, 0))
    model.mooring = ChainMooring(**{**SPAR, "chain_diameter": 0.081, **values})
    model.connect(model.hull.frame, model.mooring.frame)
    return fw.load(model).compile()


def test_the_diameter_of_a_mooring_is_tunable():
    """Changed in a run it is as at build, and the catenary of that chain."""
    plant = moored()
    for diameter in (0.07, 0.081, 0.12):
        state = plant.initial_state({"mooring.chain_diameter": diameter})
        fresh = moored(chain_diameter=diameter).initial_state()
        weight = chain.weight_in_water(diameter)
        H, V = catenary.fairlead_tension(1433.0, 309.3, catenary.Line(1497.2, weight, chain.axial_stiffness(diameter)))
        for k in (1, 2, 3):
            assert float(state[f"mooring.line_{k}.tension"]) == pytest.approx(np.hypot(H, V), rel=1e-6)
            assert float(fresh[f"mooring.line_{k}.tension"]) == pytest.approx(np.hypot(H, V), rel=1e-6)
            assert float(state[f"mooring.line_{k}.weight"]) == pytest.approx(weight, rel=1e-9)


def test_what_is_given_takes_the_place_of_a_formula():
    plant = moored(axial_stiffness=4e8, grade="R3")
    state = plant.initial_state()
    H, V = catenary.fairlead_tension(1433.0, 309.3, catenary.Line(1497.2, chain.weight_in_water(0.081), 4e8))
    assert float(state["mooring.line_1.tension"]) == pytest.approx(np.hypot(H, V), rel=1e-6)
    with pytest.raises(ParameterError):
        moored(grade="R9")
    with pytest.raises(ParameterError):
        moored(chain_diameter=0.5)


def test_a_chain_that_moves():
    """Mass and diameter are there, which dynamics need."""
    plant = moored(dynamics="coupled")
    state = plant.initial_state()
    assert float(state["mooring.line_1.generalised_mass"]) > 1e5
