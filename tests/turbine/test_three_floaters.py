"""The shipped load cases of two rotors on three floaters: what they say, that they run, and what holds at rest."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.cases import read_cases
from fowtlib.language.errors import ModelFileError
from fowtlib.language.native import compiler

FILE = Path(fowtlib.models.__file__).parent / "cases" / "three_floaters.yaml"
STATES = {1: (8, 2.5, 9.8), 2: (11.4, 3.1, 10.1), 3: (14, 3.6, 10.2), 4: (18, 4.4, 10.6), 5: (25, 5.9, 11.3),
          6: (50, 12.7, 14.1)}  # fmt: skip
FLOATERS = ("two_rotor_spar", "tlp_two_rotor", "oo_star")


@pytest.fixture(scope="module")
def cases():
    return {case.name: case for case in fw.read_cases(FILE)}


def test_they_are_those_of_the_source(cases):
    assert len(cases) == 6 * 4
    for number, (wind, height, period) in STATES.items():
        for structure in (*FLOATERS, "two_rotor_land"):
            case = cases[f"LC{number}_{structure}"]
            assert case.model == f"{structure}_rigid_bem" and case.parameters["wind.mean_speed"] == wind
            assert (case.parameters.get("*.safety.idling") == 1) == (number > 4)
            assert case.duration - case.discard == 3600
            if structure in FLOATERS:
                sea = [case.parameters[f"sea.{key}"] for key in ("significant_wave_height", "peak_period")]
                assert sea == pytest.approx([height, period])


def test_the_models_take_them():
    models = fw.check_cases(fw.read_cases(FILE))
    assert list(models) == [f"{name}_rigid_bem" for name in (*FLOATERS, "two_rotor_land")]


@pytest.fixture(scope="module")
def tlp():
    return fw.load("tlp_two_rotor_rigid_bem").compile()


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
@pytest.mark.parametrize("number", STATES)
def test_each_runs(cases, tlp, number):
    """Ten seconds from the file's start values; the rotors of LC 5 and 6 stand at feather and make no power."""
    case = cases[f"LC{number}_tlp_two_rotor"]
    coarse = {"wind.repetition_period": "20 s", "wind.sample_step": 0.2, "wind.point_spacing": 30.0}
    case = replace(case, duration=10.0, discard=5.0, start="file", parameters={**case.parameters, **coarse})
    result = tlp.simulate(conditions=case.conditions(), solver="fixed")
    for name in tlp.outputs:
        assert np.all(np.isfinite(np.asarray(result[name]))), name
    pitch, power, speed = (
        np.asarray(result[f"{name}_left"]) for name in ("blade_pitch", "generator_power", "rotor_speed")
    )
    if number > 4:
        assert np.all(pitch == pytest.approx(90)) and np.all(power == 0) and abs(speed).max() < 1.5
    else:
        assert np.all(pitch < 30) and np.all(power > 100) and np.all(speed > 6)


@pytest.mark.parametrize(("word", "idling", "braked"), [("operation", 0, 0), ("idling", 1, 0), ("parked", 1, 1)])
def test_turbines_are_a_word_of_a_cases_file(tmp_path, word, idling, braked):
    path = tmp_path / "storm.yaml"
    path.write_text(
        f"fowtlib_cases: 1\nmodel: two_rotor_spar_rigid\nsets:\n  - name: a\n    duration: 10 s\n    turbines: {word}\n"
        "    set: {turbine_right.safety.braked: 0}\n"
    )
    cases = read_cases(path)
    model = fw.check_cases(cases)["two_rotor_spar_rigid"].with_parameters(cases[0].parameters)
    for side in ("left", "right"):
        safety = model.root.find(f"turbine_{side}.safety")
        assert safety.parameter_value("idling") == idling
        assert safety.parameter_value("braked") == (braked if side == "left" else 0)  # a whole path has the last word


def test_another_word_is_refused_with_its_line(tmp_path):
    path = tmp_path / "storm.yaml"
    path.write_text(
        "fowtlib_cases: 1\nmodel: oc3_spar_rigid\nsets:\n  - name: a\n    duration: 10 s\n    turbines: stopped\n"
    )
    with pytest.raises(ModelFileError, match=r"storm.yaml:6: turbines: 'stopped' is not"):
        read_cases(path)
    path.write_text(path.read_text().replace("turbines: stopped", 'set: {"*.idle": 1}'))
    with pytest.raises(ModelFileError, match=r"storm.yaml:6: case 'a': no part has a parameter that fits '\*.idle'"):
        fw.check_cases(read_cases(path))
