"""The recipes and the scripts of fmus/: every recipe is complete, the checker finds what is wrong, the scripts run."""

from __future__ import annotations

import importlib.util
import re
import shutil
import sys
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import yaml

import fowtlib as fw
from fowtlib.language.errors import ModelError
from fowtlib.modelfile.short_forms import WAVES, WIND

FMUS = Path(__file__).parents[2] / "fmus"
RECIPES = sorted((FMUS / "recipes").glob("*.yaml"))
sys.path.append(str(FMUS))  # as where a script of the folder is run


def script(name):
    """A script of the folder as a module."""
    spec = importlib.util.spec_from_file_location(f"fmus_{name}", FMUS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


build = script("build")


@lru_cache
def results_of(model):
    return fw.load(model).outputs


def recipe(name):
    return build.Recipe.read(FMUS / "recipes" / f"{name}.yaml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Archives of the recipes that the scripts ask for; the rigid spar stands for the one in irregular waves, too."""
    place = tmp_path_factory.mktemp("built")
    for name in ("spar_rigid", "spar_without_mooring", "spar_open_control"):
        recipe(name).build(place)
    shutil.copy(place / "spar_rigid.fmu", place / "spar_in_waves.fmu")
    return place


@pytest.fixture(scope="module")
def mooring(folder):
    """The checked FMU of the mooring lines."""
    return build.Check(recipe("mooring"), folder).run()


@pytest.fixture(autouse=True)
def figures(monkeypatch):
    """Every picture of a test has axes with units."""
    from matplotlib import pyplot

    pyplot.switch_backend("Agg")
    yield
    for number in pyplot.get_fignums():
        for axis in pyplot.figure(number).axes:
            assert axis.get_ylabel().endswith("]") and axis.lines
            assert axis.get_xlabel().endswith("]") or axis.get_shared_x_axes().joined(axis, pyplot.gcf().axes[-1])
    pyplot.close("all")


# --- recipes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_recipes_are_complete(path):
    read = build.Recipe.read(path)
    assert read.about and read.expected
    assert 0 < read.same_within <= 1e-3
    for item in read.expected:
        assert set(item) == {"result", "value", "within", "over", "from"}
        assert item["result"].partition("[")[0] in results_of(read.model)
        assert item["over"] <= read.time


@pytest.mark.parametrize("name", ["run_in_fmpy", "external_controller", "connect_two", "software_in_the_loop"])
def test_every_archive_that_a_script_opens_has_a_recipe(name):
    text = (FMUS / f"{name}.py").read_text()
    opened = set(re.findall(r'"(\w+\.fmu)"', text))
    assert opened and opened <= {f"{path.stem}.fmu" for path in RECIPES}
    assert len(text.splitlines()) < 90  # short enough to read


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"modle": 1}, "a recipe has no 'modle'; it has about, expected, fmi, inputs, kind, model, "),
        ({"model": None}, "the recipe lacks 'model'."),
    ],
)
def test_mistakes_in_a_recipe_are_named(tmp_path, change, message):
    data = yaml.safe_load((FMUS / "recipes" / "mooring.yaml").read_text()) | change
    path = tmp_path / "x.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in data.items() if value is not None}))
    with pytest.raises(ModelError) as refused:
        build.Recipe.read(path)
    assert str(refused.value).startswith(f"{path}: {message}")


def test_checker_finds_nothing_wrong_with_the_mooring(mooring):
    assert mooring.passed
    found = {what: (shown, expected) for what, shown, expected, _ in mooring.rows}
    assert found["valid"] == ("yes", "yes")
    assert "fairlead_force_1[2]" in found and any(what.startswith("model exchange") for what in found)


def test_checker_finds_what_is_wrong(mooring, monkeypatch):
    """Another figure, another model in this process, an archive that is too large."""
    (first, *rest) = mooring.recipe.expected
    wrong = replace(mooring.recipe, expected=[first | {"value": "-540 kN"}, *rest], model_exchange=None)
    monkeypatch.setattr(mooring, "recipe", wrong)
    assert [what for what, *_, good in mooring.run().rows if not good] == ["fairlead_force_1[2]"]
    monkeypatch.setattr(mooring, "recipe", replace(mooring.recipe, expected=[], set={"line_1.length": "900 m"}))
    monkeypatch.setattr(mooring, "plant", mooring.recipe.plant())
    monkeypatch.setattr(build, "LARGEST", 1e3)
    failed = [what for what, *_, good in mooring.run().rows if not good]
    assert failed == ["size of the archive", "co-simulation, 1 s"]


def test_exit_status_and_message(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(build, "HERE", tmp_path)
    (tmp_path / "recipes").mkdir()
    (tmp_path / "recipes" / "bad.yaml").write_text("model: no_such_model\ntime: 1\nsame_within: 1.0e-5\nexpected: []\n")
    assert build.main([]) == 1
    said = capsys.readouterr().out
    assert "FAILED: " in said and "no_such_model" in said and said.endswith("failed: bad\n")
    assert build.main(["other"]) == 2
    assert capsys.readouterr().err == "there is no recipe 'other'; there are bad.\n"


# --- scripts --------------------------------------------------------------------------------------------------------


def test_parameters_are_changed_without_a_new_export(folder):
    module = script("run_in_fmpy")
    results = module.main(folder, 2.0)
    assert (folder / "run_in_fmpy.png").stat().st_size > 10_000
    tension = {name: rows["fairlead_tension_2"][0] for name, rows in results.items()}
    whole = fw.load("oc3_spar_rigid")
    line = whole.root.parts["platform"].parts["mooring"]
    for name, values in module.VARIANTS.items():
        line.length = values.get("platform.mooring.length", 902.2)
        state = line.static_load()[1][1]
        assert tension[name] == pytest.approx(np.hypot(state["horizontal"], state["vertical"]), rel=1e-5)
    assert tension["lines 5 m shorter"] > 1.1 * tension["as exported"]


def test_controller_outside_acts_as_the_one_inside(folder):
    """The sampled controller of the library computes the same, at the same instants."""
    module = script("external_controller")
    times, rows = module.main(folder, 5.0)
    conditions = WIND.parse("step:18,to=20,at=20") | WAVES.parse("regular:H=2,T=8")
    model = fw.load("oc3_spar_rigid").with_parameters(conditions | {"turbine.control.sample_period": module.PERIOD})
    run = model.compile().simulate(5.0, module.PERIOD, step=module.PERIOD)
    assert times == pytest.approx(run.time)
    for values, (name, (_, factor)) in zip(rows.T, module.OUTPUTS.items(), strict=True):
        reference = np.asarray(run[name])
        shown = values * factor * (1000 if name == "generator_power" else 1)  # MW, and kW as a result
        assert np.max(np.abs(shown - reference)) < 1e-6 * np.max(np.abs(reference)), name
    assert np.ptp(rows[:, 1]) > 1e-3  # the pitch moves


def test_two_units_converge_to_the_whole(folder, mooring):
    steps = (0.1, 0.05, 0.025)
    found = script("connect_two").main(folder, 8.0, steps)
    late = np.array(found[False])
    assert late[:-1] / late[1:] == pytest.approx(2.0, rel=0.02)  # half a step of delay
    assert np.max(found[True]) < 0.1 * late[-1]


def test_a_hull_with_the_turbine_in_software(folder):
    """The winches at the hub do nearly what a turbine does, and late ones do it worse."""
    recipe = build.Recipe.read(FMUS / "recipes" / "turbine_alone.yaml")
    fw.export_fmu(recipe.plant(), folder / "turbine_alone.fmu", kind="cs", step=0.0125)
    found = script("software_in_the_loop").main(folder, 20.0, (0.4, 0.0125))
    (*_, late), (surge, pitch, soon) = found[0.4, False], found[0.0125, False]
    assert max(surge, pitch, soon) < 0.06
    assert late > 1.5 * soon
    assert (folder / "software_in_the_loop.png").stat().st_size > 10_000
