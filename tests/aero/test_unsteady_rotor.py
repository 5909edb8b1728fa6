"""Unsteady airfoils in a whole turbine: the start, the turning of sections, both engines, the setting by its word."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.aero import AIRFOIL_MODELS, BladeElementRotor, RigidRotor
from fowtlib.language.errors import ModelError
from fowtlib.language.native import compiler
from fowtlib.solving.engines.reduction import reduction

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
SETTING = "turbine.aerodynamics.airfoil_model"


def turbine(word, **more):
    """The NREL 5 MW turbine on land with stiff blades; its wind rises from 9 to 12 m/s in 1 s."""
    wind = {"kind": "step", "mean_speed": 9.0, "step_speed": 12.0, "start_time": 0.1, "step_duration": 1.0}
    given = {f"wind.{name}": value for name, value in wind.items()}
    return fw.load("nrel5mw_land", set={**given, "turbine.assembly.blade_hinges": 0, SETTING: word, **more}).compile()


@pytest.fixture(scope="module")
def plants():
    return {word: turbine(word) for word in ("steady", "beddoes_leishman")}


def test_the_start_is_that_of_steady_airfoils(plants):
    steady, unsteady = (plant.initial_state() for plant in plants.values())
    for name in ("turbine.thrust", "turbine.aerodynamics.torque"):
        assert unsteady[name] == pytest.approx(float(steady[name]), rel=1e-8)
    assert np.abs(unsteady["turbine.aerodynamics.airfoil_states.downwash_rate"]).max() < 1e-6
    one, other = (plant.dae for plant in plants.values())
    assert len(other.states) == len(one.states) + 4 * 51
    assert len(reduction(other).free) == len(reduction(one).free)  # no unknown of a step more


def test_both_engines_give_the_same(plants):
    """The fixed-step engine with an error that falls with the square of the step."""
    fixed, half, exact = (
        plants["beddoes_leishman"].simulate(0.6, 0.05, **how)
        for how in ({"solver": "fixed", "step": 0.0125}, {"solver": "fixed", "step": 0.00625},
                    {"solver": "idas", "tolerance": 1e-7})
    )  # fmt: skip
    for name in ("turbine.thrust", "turbine.aerodynamics.airfoil_states.delayed[33]"):
        right = exact.array(name)
        errors = [np.sqrt(np.mean((run.array(name) - right) ** 2)) / right.std() for run in (fixed, half)]
        assert errors[0] < 0.01
        assert errors[1] < 0.4 * errors[0]


@pytest.mark.parametrize("rotation", [1, -1])
def test_sections_that_turn_to_feather_have_less_lift(blade, rotation):
    """As with a pitch that is greater; with the states held, by what acts at once."""
    rotor = BladeElementRotor(blade, rotation=rotation, airfoil_model=AIRFOIL_MODELS["beddoes_leishman"])
    rigid, n = RigidRotor(rotor), rotor.nodes
    inputs = rigid.inputs([10.0, 0, 0], 1.1)
    turned = inputs.copy()
    start = sum(list(rotor.inputs.values())[: list(rotor.inputs).index("turn_rate")])
    turned[start : start + n] = -rotation * 0.2  # rad/s about the blades: to feather, see section_axes
    thrust, more_pitch, turning = (
        rigid.loads(u)[:, 0].sum() for u in (inputs, rigid.inputs([10.0, 0, 0], 1.1, 0.01), turned)
    )
    assert more_pitch < 0.99 * thrust
    assert turning < 0.999 * thrust


def test_a_wrong_word_is_told():
    with pytest.raises(ModelError, match="beddoes_leishman"):
        fw.load("nrel5mw_land", set={SETTING: "beddoes"})
