"""A case is data: it goes through JSON unchanged, and its digest knows what a run depends on."""

import json
from dataclasses import replace

import pytest

from fowtlib.cases import Case
from fowtlib.language.errors import ParameterError

CASE = Case(
    "u12_s3", "oc3_spar_rigid", {"wind.kind": "kaimal", "wind.mean_speed": "12 m/s", "wind.seed": 3},
    duration=600.0, discard=100.0, outputs=("surge", "pitch"), labels={"wind_speed": 12, "seed": 3}, weight=0.2,
)  # fmt: skip


def test_a_case_goes_through_json_unchanged():
    assert Case.from_plain(json.loads(json.dumps(CASE.plain()))) == CASE
    assert "events" not in CASE.plain() and "solver" not in CASE.plain()


def test_the_digest_is_of_what_a_run_depends_on():
    assert replace(CASE, name="other", weight=3.0, labels={}, group="DLC 1.2").digest() == CASE.digest()
    others = [replace(CASE, duration=601.0), replace(CASE, parameters={"wind.seed": 4}), replace(CASE, start="rest")]
    assert len({CASE.digest(), *(case.digest() for case in others)}) == 4


def test_an_unknown_key_is_refused():
    with pytest.raises(ParameterError, match="a case has no 'durations'.*duration"):
        Case.from_plain({"name": "a", "model": "b", "durations": 3})


def test_conditions_hold_what_the_case_says():
    conditions = CASE.conditions()
    assert conditions.duration == 600 and conditions.discard == 100 and conditions.outputs == ("surge", "pitch")
    assert conditions.parameters["wind.mean_speed"] == "12 m/s"
