"""A flat model and a compiled plant are values: what is asked of them changes nothing."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Array, RealInput, Scalar, der, eq, param, port, var
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.solving.layout import Layout


class Filter(fw.Component):
    """Two filters of one input, weighted by a matrix."""

    u: RealInput = port(default=0.5, doc="what is filtered")
    time_constant: Scalar = param(default=2.0, unit="s", min=0.1, doc="time constant")
    weights: Array = param(default=[[1.0, 2.0], [3.0, 4.0]], shape=(2, 2), doc="weights")
    y: Array = var(unit="1", shape=(2,), start=[0.1, 0.2], doc="filtered")
    sum: Array = var(unit="1", shape=(2,), doc="weighted")

    def equations(self):
        return [
            eq(self.time_constant * der(self.y[0]), self.u - self.y[0]),
            eq(self.time_constant * der(self.y[1]), self.y[0] - self.y[1]),
            eq(self.sum, self.weights @ self.y),
        ]


@pytest.fixture
def plant():
    return fw.load(Filter()).compile()


def test_a_flat_model_cannot_be_changed(plant):
    dae = plant.dae
    with pytest.raises(FrozenInstanceError):
        dae.ode = dae.x
    for table in (dae.inputs, dae.parameters, dae.observed, dae.units, dae.docs, dae.stats):
        with pytest.raises(TypeError):
            table["y"] = 0
    for items in (dae.states, dae.algebraics, dae.externals, dae.events, dae.residual_paths):
        assert isinstance(items, tuple)
    with pytest.raises(FrozenInstanceError):
        dae.parameters["time_constant"].value = 3.0
    other = replace(dae, stats={})
    assert other.stats == {}
    assert dae.stats["equations"] > 0


def test_what_is_asked_of_a_plant_changes_nothing(plant):
    before = plant.parameter_values()
    before["time_constant"][...] = 99.0
    first = plant.simulate(1.0, 0.5)["y[0]"].values
    plant.simulate(1.0, 0.5, parameters={"time_constant": 5.0}, inputs={"u": 3.0})
    plant.equilibrium({"time_constant": 5.0})
    plant.linearize(plant.initial_state(), ["weights"])
    np.testing.assert_array_equal(plant.simulate(1.0, 0.5)["y[0]"].values, first)
    assert plant.parameter_values()["time_constant"] == 2.0


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"time_constant": [1.0, 2.0]}, r"time_constant = \[1.0, 2.0\] does not fit: it takes one number \[s\]"),
        ({"weights": [1.0, 2.0, 3.0]}, r"weights = .* does not fit: it takes numbers of shape \(2, 2\)"),
        ({"time_constant": float("nan")}, "time_constant = nan is not a finite number"),
        ({"weights": [[1.0, 2.0], [3.0, float("inf")]]}, "weights = .* is not a finite number"),
        ({1: 2.0}, "parameters: a path is a text, as in 'wind.mean_speed', and 1 is not"),
        ([1.0], r"parameters are given by path, as in .*, and this is a list: \[1.0\]"),
        ("time_constant", "and this is a str: 'time_constant'"),
    ],
)
def test_parameters_that_a_run_cannot_take(plant, parameters, words):
    with pytest.raises(ParameterError, match=words):
        plant.simulate(1.0, 0.5, parameters=parameters)
    with pytest.raises(ParameterError, match=words):
        plant.initial_state(parameters)


@pytest.mark.parametrize("name", ["duration", "output_step", "discard"])
@pytest.mark.parametrize("value", [float("inf"), float("nan"), -1.0])
def test_times_that_a_run_cannot_have(name, value):
    with pytest.raises(ParameterError, match=f"{name} is .* s[;,] (it must be|which is not a finite)"):
        fw.Conditions(**{name: value})


def test_an_output_step_longer_than_the_run_is_told(plant):
    with pytest.warns(UserWarning, match=r"the output step of 5 s is longer than the run of 2 s, whose results are"):
        assert plant.simulate(2.0, 5.0).time.tolist() == [0.0, 2.0]


def test_what_is_given_by_path_where_a_state_is_sought(plant):
    """Start values, inputs and targets as something else: one sentence, which says where a state goes."""
    state, result = plant.initial_state(), plant.simulate(1.0, 0.5)
    for start, kind in ((state, "State"), (result, "Result"), ("rest", "str"), ([1.0], "list"), (3, "int")):
        words = f"^start: start values are given by path, .* and this is a {kind}: (.|\n)* A State goes to "
        with pytest.raises(ParameterError, match=f"{words}near="):
            plant.equilibrium(start=start)
        with pytest.raises(ParameterError, match=f"{words}base="):
            plant.initial_state(start=start)
    for asked in (plant.equilibrium, plant.initial_state):
        with pytest.raises(ParameterError, match=r"^inputs are given by path, as in .*, and this is a list: \[1.0\]"):
            asked(inputs=[1.0])
    with pytest.raises(ParameterError, match=r"^targets are given by path, as in .*, and this is a list: \['y'\]"):
        plant.equilibrium(free=["time_constant"], targets=["y"])


def test_what_is_no_state_and_no_list_of_names_is_a_sentence(plant):
    state = plant.initial_state()
    for asked in (lambda: plant.linearize(3), lambda: plant.equilibrium(near=3), lambda: plant.initial_state(base=3)):
        with pytest.raises(
            ModelError, match=r"is a state of the model, as plant\.equilibrium\(\) .* gives it, not 3\."
        ):
            asked()
    names = r"are a list of names, as in \['pitch'\], not 3\."
    with pytest.raises(ParameterError, match=f"inputs {names}"):
        plant.linearize(state, inputs=3)
    with pytest.raises(ParameterError, match=f"outputs {names}"):
        plant.linearize(state, outputs=3)
    with pytest.raises(ParameterError, match=f"outputs {names}"):
        plant.simulate(1.0, 0.5, outputs=3)
    with pytest.raises(ParameterError, match=r"outputs are a list of names, as in \['sum'\], not a text"):
        plant.simulate(1.0, 0.5, outputs="sum")
    with pytest.raises(ParameterError, match=f"freed parameters {names}"):
        plant.equilibrium(free=3, targets={"sum": 1.0})
    with pytest.raises(ParameterError, match="states to hold are given by path"):
        plant.equilibrium(hold=3)


def test_what_a_run_takes_in_cannot_be_changed(plant):
    for parameters in (None, {"time_constant": 5.0, "weights": 1.0}):
        binding = plant.binding(parameters)
        with pytest.raises(ValueError, match="read-only"):
            binding.p[0] = 7.0
        with pytest.raises(ValueError, match="read-only"):
            binding.values["weights"][0, 0] = 7.0
        with pytest.raises(TypeError):
            binding.values["weights"] = 7.0


def test_packing_by_path(plant):
    layout = Layout(plant.dae)
    p = plant.binding({"weights": [[1.0, 5.0], [6.0, 4.0]], "time_constant": "1 min"}).p
    assert p[layout.p["time_constant"]] == 60.0
    np.testing.assert_array_equal(p[layout.p["weights"]], [1.0, 6.0, 5.0, 4.0])  # column by column
    np.testing.assert_array_equal(layout.inputs(), [0.5])
    np.testing.assert_array_equal(layout.inputs({"u": 2}), [2.0])
    symbols, labels = layout.symbols("weights")
    assert [str(s) for s in symbols] == [str(plant.dae.p[i]) for i in range(*layout.p["weights"].indices(9))]
    assert labels == [f"weights[{i}]" for i in range(4)]
    x, z, d = np.zeros(2), np.zeros(len(layout.z)), np.zeros(0)
    assert layout.put({"y[1]": 3.0}, x, z, d) == {layout.x["y[1]"]}
    assert x[layout.x["y[1]"]] == 3.0
    with pytest.raises(ParameterError, match=r"^'y\[3\]' is not a state .* did you mean 'y\[0\]'"):
        layout.put({"y[3]": 3.0}, x, z, d)
    with pytest.raises(ParameterError, match=r"time_constant = 0.01 is below its minimum 0.1 s"):
        plant.binding({"time_constant": 0.01})


def test_a_weighted_sum_by_hand(plant):
    state = plant.initial_state({"weights": [[1.0, 5.0], [6.0, 4.0]]})
    np.testing.assert_allclose(state["sum"], [1.1, 1.4])
    slopes = plant.linearize(state, ["weights", "u"], ["sum"])
    assert slopes.inputs == ["weights[0]", "weights[1]", "weights[2]", "weights[3]", "u"]
    np.testing.assert_allclose(slopes.matrices["D"], [[0.1, 0, 0.2, 0, 0], [0, 0.1, 0, 0.2, 0]], atol=1e-15)
