"""The shipped fault cases of two rotors: what they say, and that models with two turbines offer it."""

from pathlib import Path

import pytest

import fowtlib as fw
import fowtlib.models

CASES = Path(fowtlib.models.__file__).parent / "cases"
FILES = {"two_rotor_faults": "two_rotor_spar", "oo_star_faults": "oo_star_feedback"}
BLOCKED, AWAY = "turbine_left.bearing_1.stuck", "turbine_left.bearing_1.runaway"


@pytest.mark.parametrize("name", FILES)
def test_they_are_those_of_the_source(name):
    """Five load cases in four winds; the fault at 600 s, the shutdown of both rotors at 600.1 s."""
    cases = {case.name: case for case in fw.read_cases(CASES / f"{name}.yaml")}
    assert len(cases) == 20
    for wind, height, period in ((8, 2.5, 9.9), (11.5, 3.2, 10), (14, 3.6, 10.3), (22, 4.2, 10.5)):
        for kind, events in (("1A", []), ("2A", [BLOCKED]), ("3A", [AWAY]), ("2B", [BLOCKED, "*.normal_shutdown"]),
                             ("3B", [AWAY, "*.normal_shutdown"])):  # fmt: skip
            case = cases[f"{kind}_u{wind}_s1"]
            assert [event["event"] for event in case.events] == events
            assert [event["at"] for event in case.events] == [600.0, 600.1][: len(events)]
            sea = [case.parameters[f"sea.{key}"] for key in ("significant_wave_height", "peak_period")]
            assert sea == pytest.approx([height, period]) and case.parameters["wind.mean_speed"] == wind


@pytest.mark.parametrize("name", FILES)
def test_the_model_offers_what_they_ask_for(name):
    models = fw.check_cases(fw.read_cases(CASES / f"{name}.yaml"))
    assert list(models) == [FILES[name]]
