"""Conditions: what differs between two runs of one compiled model."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import KaimalWind, NoWind, SteadyWind, Wind
from fowtlib.flattening import assembler
from fowtlib.language import Component, ModelError, Scalar, der, eq, outer, param, var


class Vane(Component):
    """A vane that follows the wind."""

    wind: Wind = outer(Wind)
    lag: Scalar = param(default=2.0, unit="s", min=0.1, doc="time constant")
    v: Scalar = var(unit="m/s", start=0, fixed=True, doc="filtered wind")

    def equations(self):
        return [eq(self.lag * der(self.v), self.wind.speed[0] - self.v)]


@pytest.fixture(scope="module")
def plant():
    top = fw.Assembly("vane")
    top.wind, top.vane = SteadyWind(mean_speed=10), Vane()
    return fw.load(top).compile()


def test_all_of_a_run(plant):
    conditions = fw.Conditions(
        parts={"wind": SteadyWind(mean_speed=6)}, parameters={"vane.lag": "1 s"}, start={"vane.v": 2.0},
        duration="5 s", output_step=0.5, discard=2, outputs=["vane.v"],
    )  # fmt: skip
    result = plant.simulate(conditions=conditions, tolerance=1e-9)
    np.testing.assert_allclose(result.time, np.arange(2, 5.01, 0.5))
    assert list(result) == ["vane.v"]
    np.testing.assert_allclose(result["vane.v"], 6 - 4 * np.exp(-result.time), atol=1e-6)
    beside = plant.simulate(conditions=conditions, parameters={"vane.lag": 2.0}, t_end=4.0, tolerance=1e-9)
    np.testing.assert_allclose(beside["vane.v"], 6 - 4 * np.exp(-beside.time / 2), atol=1e-6)
    assert beside.time[-1] == 4


def test_a_run_goes_on_under_its_conditions(plant):
    windy = fw.Conditions(parts={"wind": KaimalWind(seed=2)}, duration=8, output_step=0.5)
    whole = plant.simulate(conditions=windy)
    first = plant.simulate(conditions=windy.but(duration=4))
    rest = plant.simulate(conditions=windy.but(start=first))
    assert float(rest["vane.v"][-1]) == pytest.approx(float(whole["vane.v"][-1]), abs=1e-4)
    state = plant.initial_state(windy.values)
    from_state = plant.simulate(conditions=fw.Conditions(start=state, duration=8, output_step=0.5))
    np.testing.assert_allclose(from_state["vane.v"], whole["vane.v"], atol=1e-9)  # a state knows its wind


def test_conditions_over_others():
    below = fw.Conditions(parts={"wind": NoWind()}, parameters={"a": 1, "b": 2}, duration=10, discard=1)
    above = fw.Conditions(parameters={"b": 3}, duration=20)
    both = above.over(below)
    assert (both.duration, both.discard, both.output_step) == (20, 1, None)
    assert both.parameters == {"a": 1, "b": 3}
    assert type(both.values["wind"]) is NoWind


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fw.Conditions(duration=0), "duration is 0 s; it must be above zero"),
        (lambda: fw.Conditions(discard="-1 s"), "discard is -1 s; it must be zero or more"),
        (lambda: fw.Conditions(duration="5 m"), "duration"),
        (lambda: fw.Conditions(parts={"wind": "steady"}), "parts: 'wind' is given 'steady'"),
        (lambda: fw.Conditions().but(durations=3), "Conditions have no 'durations'; did you mean 'duration'"),
    ],
)
def test_wrong_conditions(make, words):
    with pytest.raises(ModelError, match=words):
        make()


def test_nothing_left(plant):
    with pytest.raises(ModelError, match="discard is 5 s, and the run is 5 s long; nothing would be left"):
        plant.simulate(conditions=fw.Conditions(duration=5, discard=5))


def test_other_data_do_not_build_a_model_anew(monkeypatch):
    model = fw.load("oc3_spar_rigid")
    from fowtlib.modelfile import document

    monkeypatch.setattr(document, "read", lambda *_, **__: pytest.fail("the file is read again"))
    steady = model.with_parameters({"wind.kind": "steady", "wind.mean_speed": "8 m/s", "wind.shear_exponent": 0.1})
    assert (type(steady.root.wind), type(model.root.wind)) == (SteadyWind, KaimalWind)
    assert steady.root.wind.parameter_value("mean_speed") == 8
    windy = steady.with_parameters({"wind.kind": "kaimal", "wind.seed": 7})
    assert (windy.root.wind.seed, windy.root.wind.parameter_value("mean_speed")) == (7, 8)
    monkeypatch.undo()
    again = windy.with_parameters({"wind.kind": "input"})
    assert again.root.wind.kind == "input"  # other equations: built anew, with what was set before
    assert again.root.wind.parameter_value("mean_speed") == 8


def test_one_flattening_for_many_conditions(plant, monkeypatch):
    monkeypatch.setattr(assembler._Flattening, "run", lambda self: pytest.fail("flattened again"))
    last = [
        float(plant.simulate(conditions=fw.Conditions(parts={"wind": wind}, duration=3, output_step=1))["vane.v"][-1])
        for wind in (NoWind(), SteadyWind(mean_speed=5), KaimalWind(mean_speed=5), KaimalWind(mean_speed=5, seed=2))
    ]
    assert len(set(last)) == 4
    assert last[0] == 0


@pytest.mark.parametrize("wind", [NoWind(), KaimalWind(mean_speed=7, seed=4), SteadyWind(mean_speed=5)])
def test_a_saved_result_knows_its_wind(plant, tmp_path, wind):
    conditions = fw.Conditions(parts={"wind": wind}, duration=3, output_step=0.5, outputs=["vane.v"])
    run = plant.simulate(conditions=conditions)
    run.save(tmp_path / "run.nc")
    again = fw.Result.open(tmp_path / "run.nc", plant=plant)
    np.testing.assert_allclose(again["wind.speed"], run["wind.speed"], rtol=0, atol=1e-12)
    assert type(again.root.wind) is type(wind)
