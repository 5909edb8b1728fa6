"""Every expansion that a model file can ask for has a limit and a sentence, and what is within it takes no time."""

from __future__ import annotations

import time

import numpy as np
import pytest

from fowtlib.language.errors import ModelError, ModelFileError
from fowtlib.modelfile import load
from fowtlib.modelfile.nodes import LARGEST, parse

HEAD = "fowtlib: 1\n"
BALL = "parts: {b: {class: PointMass, mass: q}}"


def loaded(folder, text):
    (folder / "model.yaml").write_text(text)
    return load(folder / "model.yaml")


def refused(folder, text):
    started = time.process_time()
    with pytest.raises(ModelFileError) as error:
        loaded(folder, text)
    assert time.process_time() - started < 5
    assert "model.yaml" in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("text", ["a: [" + ",".join(["1.5"] * 50_000) + "]", "a:\n" + "- 1.5\n" * 50_000,
                                  "a:\n" + "".join(f"  k{i}: {i}\n" for i in range(40_000))])  # fmt: skip
def test_long_lists_are_read_in_linear_time(text):
    started = time.process_time()
    top = parse(text, "a.yaml")
    assert time.process_time() - started < 1
    last = list(top.walk())[-1]
    assert last.place.line == text.rstrip().count("\n") + 1


def chain(count, formula):
    lines = [f"  q{i}: {formula.format(f'q{i - 1}')}" for i in range(1, count)]
    return "\n".join([HEAD.strip(), "parameters:", "  q0: 0.5", *lines])


@pytest.mark.parametrize("formula", ["{0} + {0}", "max({0}, {0})", "({0} + {0} + {0}) / 3"])
def test_a_chain_of_parameters_takes_no_time(tmp_path, formula):
    started = time.process_time()
    model = loaded(tmp_path, chain(40, formula) + "\nparts:\n  ball: {class: PointMass, mass: q39}\n")
    mass = model.root.find("ball").parameter_value("mass")
    assert time.process_time() - started < 2
    assert mass == pytest.approx(0.5 * 2**39 if formula == "{0} + {0}" else 0.5)


def test_a_structural_chain_is_as_fast_and_its_number_has_a_limit(tmp_path):
    one = chain(40, "max({0}, {0})").replace("q0: 0.5", "q0: 3")
    assert loaded(tmp_path, one + "\nparts: {sum: {class: Sum, n: q39}}").root.find("sum").parameter_value("n") == 3
    two = chain(40, "{0} + {0}").replace("q0: 0.5", "q0: 1")
    assert "above 10000" in refused(tmp_path, two + "\nparts: {sum: {class: Sum, n: q39}}")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 60 + "]" * 60, "nested too deeply; the limit is 50"),
        ("{class: " * 90 + "}" * 90, "nested too deeply; the limit is 50"),
        (HEAD + "a: " + "[" * 100_000, "nested too deeply"),
        (HEAD + "#" * LARGEST, "4 MB"),
        (chain(400, "{0} + 1") + "\nparts: {b: {class: PointMass, mass: q399}}", "chain of more than 100"),
        (HEAD + "parts: {s: {class: Sum, n: 1e18}}", "n = 1000000000000000000 is above 10000"),
        (HEAD + "parts: {s: {class: Sum, n: 20000}}", "n = 20000 is above 10000"),
        (HEAD + "parts: {t: {class: FlexibleTower, heights: [0, 80], diameters: [6, 4], "
         "wall_thicknesses: [0.03, 0.02], hinges: 1000000000}}", "hinges = 1000000000 is above 10000"),
        (HEAD + "parts: {p: {use: " + "m" * 300 + "}}", "too long for the name of a file"),
        (HEAD + "parts: {p: {use: " + "m" * 300 + "/x}}", "too long for the name of a file"),
        (HEAD + "parts: {t: {class: BladeElementAerodynamics, airfoils: ./" + "m" * 300 + "/x.csv}}", "model.yaml:2"),
        (HEAD + "parts: {p: {use: " + "m/" * 3000 + "}}", "letters; the limit is 1000"),
        (HEAD + "parameters: {q: {value: 3, max: [1, [2]]}}\n" + BALL, "one number"),
        (HEAD + "parameters: {q: {value: 3, min: [[1]]}}\n" + BALL, "a bound is one number"),
        (HEAD + "parameters: {q: {value: [1, [2]]}}\n" + BALL, "rows of numbers"),
        (HEAD + "parameters: {q: {value: [[[1]]]}}\n" + BALL, "nested too deeply"),
        (HEAD + "simulation: {duration: .inf}", "a finite number is expected"),
        (HEAD + "simulation: {output_step: 1e400 s}", "a finite number is expected"),
        (HEAD + "parts: {b: {class: PointMass, mass: nan}}", "'nan' is not a finite number; a mass in kg is expected"),
        (HEAD + "parts: {b: {class: PointMass, mass: 2*nan}}", "'2*nan' is not a finite number"),
    ],
)  # fmt: skip
def test_a_limit_is_said(tmp_path, text, words):
    assert words in refused(tmp_path, text)


def test_each_in_each_is_stopped(tmp_path):
    rounds = ", ".join(f"{{{{v{{0}}: {k}}}}}" for k in range(100))
    inner = "parts: {p_{v0}_{v1}_{v2}_{v3}: {class: PointMass, mass: 1}}"
    for level in (3, 2, 1, 0):
        inner = f"each: [{{for: [{rounds.format(level)}], {inner}}}]"
    assert "more than 20000 parts" in refused(tmp_path, HEAD + inner)


def test_definitions_that_fan_out_are_stopped(tmp_path):
    for level in range(6):
        inner = f"use: level_{level + 1}" if level < 5 else "class: PointMass, mass: 1"
        parts = "".join(f"  p{i}: {{{inner}}}\n" for i in range(10))
        (tmp_path / f"level_{level}.yaml").write_text(f"fowtlib: 1\nparts:\n{parts}")
    started = time.process_time()
    with pytest.raises(ModelFileError, match="more than 20000 parts"):
        load(tmp_path / "level_0.yaml")
    assert time.process_time() - started < 10


RAMP = HEAD + "parts: {c: {class: Constant, value: 1}, i: {class: Integrator}}\nconnect: [[c.y, i.u]]"


@pytest.fixture(scope="module")
def plant(tmp_path_factory):
    return loaded(tmp_path_factory.mktemp("ramp"), RAMP).compile()


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), -1.0, 0.0, "1e400 s", np.float64("nan")])
@pytest.mark.parametrize("name", ["t_end", "output_step", "step"])
def test_times_are_finite_and_above_zero(plant, name, value):
    given = {"t_end": 1.0, "output_step": 0.1, "solver": "fixed", "step": 0.1} | {name: value}
    with pytest.raises(ModelError):
        plant.simulate(**given)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), "1e999"])
def test_parameters_and_starts_are_finite(plant, value):
    with pytest.raises(ModelError, match="finite"):
        plant.simulate(1.0, 0.1, parameters={"i.gain": value})
    with pytest.raises(ModelError, match="finite"):
        plant.initial_state(start={list(plant.layout.x)[0]: value})


def test_a_run_of_too_many_points_is_refused(plant):
    with pytest.raises(ModelError, match="output points"):
        plant.simulate(1e12, 0.1)
