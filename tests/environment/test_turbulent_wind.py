"""Fields that are made when a run starts: those of the generator, made anew when they are gone, none left behind."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import field_store, generate_field
from fowtlib.language.errors import ParameterError

WIND = {"wind.kind": "turbulence", "wind.mean_speed": 11, "wind.point_spacing": 40, "wind.sample_step": 0.2,
        "wind.repetition_period": 60, "wind.rotor_diameter": 126}  # fmt: skip
RUN = {"solver": "fixed", "start": "file"}


@pytest.fixture(scope="module")
def plant():
    return fw.load("oc3_spar_rigid").compile()


def run(plant, **more):
    return plant.simulate(5.0, 0.5, parameters={**WIND, **{f"wind.{key}": value for key, value in more.items()}}, **RUN)


def test_it_is_the_field_of_the_generator(plant, tmp_path):
    made = run(plant, seed=3, turbulence_class="A")
    numbers = plant.binding({**WIND, "wind.seed": 3, "wind.turbulence_class": "A"}).root.find("wind").numbers()
    assert numbers["width"] == pytest.approx(1.3 * 126) and numbers["bottom"] == pytest.approx(90 - 0.65 * 126)
    assert (numbers["columns"], numbers["rows"]) == (6, 6)  # 40 m apart at most
    generate_field(tmp_path / "same.bts", **numbers)
    given = {"wind.kind": "field", "wind.file": str(tmp_path / "same.bts")}
    same = plant.simulate(5.0, 0.5, parameters=given, **RUN)
    assert np.array_equal(made.array("wind_speed"), same.array("wind_speed"))
    assert np.allclose(made.array("thrust"), same.array("thrust"), rtol=0.01)  # started at another mean: 11, 10.98 m/s


def test_a_field_that_has_gone_is_made_again_the_same(plant):
    first = run(plant, seed=1).array("wind_speed")
    others = [run(plant, seed=seed).array("wind_speed") for seed in range(2, 2 + field_store.KEPT)]
    assert len(field_store._files) == field_store.KEPT
    assert np.array_equal(run(plant, seed=1).array("wind_speed"), first)
    assert all(np.abs(other - first).max() > 0.1 for other in others)


def test_strength_and_seed_and_shear_change_it(plant):
    weak = run(plant, turbulence_intensity=0.01).array("wind_speed")
    strong = run(plant, turbulence_intensity=0.2).array("wind_speed")
    assert np.ptp(weak) < 0.1 * np.ptp(strong)
    assert np.allclose(np.diff(strong) / 20, np.diff(weak), atol=2e-3)  # of one seed, in the steps of int16


def test_extreme_turbulence_is_that_of_the_point_series(plant):
    both = {"wind.mean_speed": 14, "wind.turbulence_class": "A", "wind.wind_class": "II"}
    made = plant.binding({**WIND, **both, "wind.turbulence_model": "etm"}).root.find("wind").numbers()
    point = plant.binding({**both, "wind.kind": "etm"}).root.find("wind").standard_deviation()
    assert made["turbulence_intensity"] * 14 == pytest.approx(point, rel=1e-12)


def test_no_field_is_made_for_a_mean(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a field is made")

    monkeypatch.setattr("fowtlib.components.environment.wind.turbulent.made_field", refuse)
    wind = fw.load("oc3_spar_rigid", set={**WIND, "wind.seed": 77}).root.find("wind")
    assert wind.mean_at() == 11 and wind.in_the_mean() == {
        "kind": "steady", "mean_speed": 11, "shear_exponent": 0.14,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"repetition_period": 1}, "wind: cannot generate the wind field: 5 time steps"),
        ({"rotor_diameter": 500, "point_spacing": 0.5}, "cannot generate the wind field: .* points, expected 1"),
        ({"file": "a.bts"}, "file"),
    ],
)
def test_what_cannot_be_made_is_said(plant, change, words):
    with pytest.raises(ParameterError, match=words):
        run(plant, **change)


def test_nothing_is_left_on_the_disk(tmp_path):
    script = (
        "import fowtlib as fw; from fowtlib.components.environment import field_store\n"
        "w = fw.load('oc3_spar_rigid', set={'wind.kind': 'turbulence', 'wind.mean_speed': 9, 'wind.point_spacing': 50,"
        " 'wind.repetition_period': 10}).root.find('wind')\n"
        "w.lookup(); print(field_store._folder[0], len(list(field_store._folder[0].glob('*.bts'))))"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
    assert said[1] == "1" and not Path(said[0]).exists()
