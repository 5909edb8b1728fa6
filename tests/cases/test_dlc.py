"""Named sets of load cases: every file that is written passes its own reader and the check, and says what it should."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fowtlib import case_files
from fowtlib.analysis.load_matrix import ultimate_loads
from fowtlib.cases import CaseSet, check_cases, read_cases, run_batch
from fowtlib.cases import batch as batches
from fowtlib.cases.dlc import Request, load_case_table, write_dlc
from fowtlib.cases.job import carry_out
from fowtlib.cases.plant_facts import rated_wind_speed
from fowtlib.cases.pool import Event
from fowtlib.cases.site import read_site
from fowtlib.cli.app import main
from fowtlib.components.environment import Wind
from fowtlib.components.environment.waves import steepest_sea
from fowtlib.language.errors import ModelError, ModelFileError
from fowtlib.language.units import to_si
from fowtlib.metocean import bins, cases_file, contour, radius, shipped
from fowtlib.metocean import site as metocean_site
from fowtlib.modelfile import load

TABLE = load_case_table()
NORWAY = case_files.read_site("norway_5", 90.0)
OF_BLADES = ("2.2", "6.2", "7.1")  # a drive of each blade, or wind from behind: not with a rotor of coefficients
RIGID = [number for number in TABLE["load_cases"] if number not in OF_BLADES]


@pytest.fixture(scope="module")
def rigid():
    return load("oc3_spar_rigid")


def written(numbers, model="oc3_spar_rigid", **request) -> CaseSet:
    text = write_dlc(Request(numbers, model, NORWAY, **request), load(model))
    return read_cases("dlc.yaml", text=text)


@pytest.mark.parametrize(("model", "numbers"), [("oc3_spar_rigid", RIGID), ("oc3_spar", ["1.2", *OF_BLADES])])
def test_every_load_case_is_written_read_and_can_be_run(model, numbers):
    cases = written(numbers, model, seeds=1)
    check_cases(cases)
    assert {case.group for case in cases} == {f"DLC {number}" for number in numbers}
    for case in cases:
        entry = TABLE["load_cases"][case.group.removeprefix("DLC ")]
        assert case.safety_factor == TABLE["factors"][entry["factor"]]
        kinds = TABLE["winds"] | (TABLE["fields"] if model == "oc3_spar" else {})  # elements of blades feel fields
        assert case.parameters["wind.kind"] == kinds[entry["wind"]]["kind"]
        assert bool(case.events) == bool(entry.get("events"))
        assert ("turbine.safety.idling" in case.parameters) == entry.get("idling", False)


def test_the_safety_factors_and_the_kinds_of_wind_are_those_of_the_standard():
    factor = {number: TABLE["factors"][entry["factor"]] for number, entry in TABLE["load_cases"].items()}
    assert factor["1.1"] == 1.25 and factor["1.2"] == 1.0 and factor["6.4"] == 1.0
    normal = ("1.3", "1.4", "1.5", "1.6", "2.1", "3.2", "3.3", "4.2", "5.1", "6.1", "6.3")
    assert {factor[number] for number in normal} == {1.35}
    assert {factor[number] for number in ("2.2", "2.3", "6.2", "7.1", "9.1", "10.1")} == {1.1}
    assert {wind["kind"] for wind in TABLE["winds"].values()} <= set(Wind.family.kinds)
    assert not set(TABLE["others"]) & set(TABLE["load_cases"])


def test_fields_are_as_strong_as_series_and_as_long_as_the_run():
    cases = written(["1.2", "1.3", "6.1"], "oc3_spar", wind_class="IIA", wind="12:12:2", seeds=1, time=100.0,
                    discard=20.0)  # fmt: skip
    normal, extreme, storm = (next(case for case in cases if case.group == f"DLC {n}") for n in ("1.2", "1.3", "6.1"))
    assert {case.parameters["wind.repetition_period"] for case in cases} == {"120 s"}
    assert normal.parameters["wind.turbulence_class"] == "A" and "wind.turbulence_model" not in normal.parameters
    assert extreme.parameters["wind.turbulence_model"] == "etm" and extreme.parameters["wind.wind_class"] == "II"
    assert storm.parameters["wind.mean_speed"] == 42.5 and storm.parameters["wind.turbulence_intensity"] == 0.11


def test_class_speeds_directions_and_times(rigid):
    cases = written(["1.3", "1.4", "6.3"], wind_class="IIA+", wind="5:23:3", seeds=1, time=100.0, discard=20.0,
                    misalignment=(-30.0, 30.0))  # fmt: skip
    by_group: dict[str, list] = {}
    for case in cases:
        by_group.setdefault(case.group, []).append(case)
    etm, gust, idling = (by_group[f"DLC {number}"] for number in ("1.3", "1.4", "6.3"))
    assert [case.labels["wind_speed"] for case in etm] == [5, 8, 11, 14, 17, 20, 23]
    assert etm[0].parameters["wind.turbulence_class"] == "A+" and etm[0].parameters["wind.wind_class"] == "II"
    assert etm[0].duration == 120 and etm[0].discard == 20 and etm[0].start == "turning"
    rated = round(rated_wind_speed(rigid), 1)
    assert sorted({case.labels["wind_speed"] for case in gust}) == [rated - 2, rated, rated + 2]
    assert gust[0].parameters["wind.start_time"] == "50 s" and gust[0].duration == 350
    assert {(case.labels["yaw_error"], case.labels["misalignment"]) for case in idling} == {
        (yaw, wave) for yaw in (-20, 20) for wave in (-30, 30)}  # fmt: skip
    case = next(case for case in idling if case.labels["yaw_error"] == -20 and case.labels["misalignment"] == -30)
    assert to_si(case.parameters["sea.heading"], "rad") == pytest.approx(-math.radians(50)) and case.start == "rest"


def test_the_rated_wind_speed_follows_from_the_model(rigid):
    assert rated_wind_speed(rigid) == pytest.approx(11.4, abs=0.2)  # NREL/TP-500-38060: 11.4 m/s


def test_weights_of_fatigue_cover_the_lifetime_once():
    cases = written(["1.2", "6.4"], seeds=2)
    scale, shape = NORWAY.weibull
    above = lambda speed: math.exp(-((speed / scale) ** shape))  # noqa: E731
    # 6.4 goes on where 1.2 ends, to 0.7 V_ref = 35 m/s: bins from 1 to 35 m/s
    assert sum(case.weight for case in cases) == pytest.approx(above(1) - above(35))


@pytest.mark.parametrize("name", shipped())
def test_the_shipped_sites_are_no_steeper_than_seas_are(name):
    site = case_files.read_site(name, 90.0)
    for table in site.seas.values():
        assert all(h <= steepest_sea(t) for h, t in zip(table.values["Hs"], table.values["Tp"], strict=True))
    assert all(h <= steepest_sea(t) for h, t in site.extreme.values())


def test_the_seas_of_a_joint_distribution():
    assert NORWAY.extreme["50"][0] == pytest.approx(15.4, abs=0.1)  # its 50-year Hs, as others have found it
    assert NORWAY.weibull == pytest.approx((9.409 * 9**0.1, 2.029))
    severe, normal = NORWAY.seas["severe_sea"], NORWAY.seas["normal_sea"]
    highest = contour(metocean_site("norway_5").at(90.0), radius(50.0), points=2000)
    assert max(severe.values["Hs"]) == pytest.approx(max(highest.wave_height), rel=0.01)
    assert all(severe.values["Hs"] > normal.values["Hs"])


WRONG = [
    (["1.9"], {}, "there is no DLC '1.9'"),
    (["2.4"], {}, "DLC 2.4 is not written: the faults of a year"),
    (["1.2"], {"wind_class": "IVB"}, "'IVB' is not a class of IEC 61400-1"),
    (["1.2"], {"wind": "4:44:2"}, "DLC 1.2 runs at 42 m/s, and 'normal_sea' of the site 'norway_5' goes from 2 to 40"),
    (["1.2"], {"wind": "four"}, "'four' is not first:last:step"),
    (["1.2"], {"wind": "-4:4:2"}, "must rise from above zero"),
    (["6.2"], {}, "DLC 6.2 has wind from behind, for which the coefficients of turbine.rotor do not hold"),
    (["2.2"], {}, "DLC 2.2 needs the event 'runaway' of a part 'bearing_1', which no part of oc3_spar_rigid offers"),
]


@pytest.mark.parametrize(("model", "part"), [("nrel5mw_land", "sea"), ("two_rotor_support", "wind")])
def test_a_model_without_wind_or_sea_is_a_sentence(model, part):
    with pytest.raises(ModelError, match=f"^the model has no part '{part}', which load cases give their {part} to"):
        write_dlc(Request(["1.2"], model, NORWAY), load(model))


@pytest.mark.parametrize(("numbers", "request_", "message"), WRONG)
def test_what_cannot_be_written_is_a_sentence(rigid, numbers, request_, message):
    with pytest.raises(ModelError, match=message):
        write_dlc(Request(numbers, "oc3_spar_rigid", NORWAY, **request_), rigid)


SITE = """fowtlib_site: 1
title: Bay
hub_height: 90 m
wind: {weibull: {scale: 8 m/s, shape: 2}}
normal_sea: {wind_speed: [2, 30], Hs: [1, 4], Tp: [7, 9]}
"""
WRONG_SITES = [
    ("fowtlib_site: 1", "fowtlib: 1", ":1: this is not a site"),
    ("hub_height", "hubheight", ":3: 'hubheight' is not a key of a site; did you mean 'hub_height'"),
    ("shape: 2", "shape: -2", ":4: weibull: shape is -2"),
    ("Hs: [1, 4]", "Hs: [1, 0]", ":5: 'normal_sea': 'Hs' holds what is not above zero"),
    ("Hs: [1, 4], Tp", "Tp: [1, 4], Hs", ":5: 'normal_sea' has the columns wind_speed, Hs, Tp"),
    ("title: Bay", "extreme_sea: {100: {Hs: 1, Tp: 9}}", ":2: extreme_sea: there are return periods of 1 and 50"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG_SITES)
def test_a_mistake_in_a_site_has_its_line(tmp_path, old, new, message):
    path = tmp_path / "bay.yaml"
    path.write_text(SITE.replace(old, new))
    with pytest.raises(ModelFileError, match=message):
        read_site(path)


def test_what_a_site_does_not_say_is_asked_for(tmp_path, rigid):
    (tmp_path / "bay.yaml").write_text(SITE)
    site = read_site(tmp_path / "bay.yaml")
    with pytest.raises(ModelError, match="DLC 6.1 needs 'extreme_sea' of 50 years, and the site 'bay' does not say it"):
        write_dlc(Request(["6.1"], "oc3_spar_rigid", site), rigid)


def test_the_command_writes_shows_and_lists(tmp_path: Path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["cases", "dlc", "1.2", "6.1", "--model", "oc3_spar_rigid", "--wind", "8:12:4", "--seeds", "2",
             "--time", "60", "--discard", "0", "--output", "dlc.yaml"]  # fmt: skip
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "8 cases of oc3_spar_rigid, 0.1333 h in all" in out and "DLC 6.1" in out
    assert main(words) == 2 and "is there already" in capsys.readouterr().err
    assert main(["cases", "dlc.yaml", "--list", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["case"] for row in rows][:2] == ["dlc1.2_u08.0_s1", "dlc1.2_u08.0_s2"] and rows[0]["duration [s]"] == 60
    assert main(["cases", "dlc.yaml", "--output", "table.csv"]) == 0 and (tmp_path / "table.csv").is_file()
    assert main(["cases", "dlc.yaml", "--seeds", "3"]) == 2 and "belongs to load cases" in capsys.readouterr().err
    assert main(["cases", "dlc"]) == 2 and "which load cases?" in capsys.readouterr().err
    assert main(["cases", "no.yaml"]) == 2 and "there is no file 'no.yaml'" in capsys.readouterr().err
    path = tmp_path / "dlc.yaml"
    path.write_text(path.read_text().replace("spectrum: jonswap", "spectrum: jonswop", 1))
    assert main(["cases", "dlc.yaml"]) == 2
    assert "dlc.yaml:" in (err := capsys.readouterr().err) and "did you mean 'jonswap'" in err


JOINT = """fowtlib_cases: 1
model: oc3_spar_rigid
distributions: {north: {site: norway_5, height: 90 m}}
sets:
  - {name: "u{wind_speed}", vary: {wind_speed: [8, 24]}, look_up: north, sea: "jonswap:Hs={Hs},Tp={Tp}",
     wind: "ntm:{wind_speed}"}
"""


def test_a_joint_distribution_gives_the_sea_of_the_wind():
    cases = case_files.read_cases("joint.yaml", text=JOINT)
    for case in cases:
        height, period = metocean_site("norway_5").at(90.0).conditional(case.labels["wind_speed"])
        assert (case.parameters["sea.significant_wave_height"], case.parameters["sea.peak_period"]) == (height, period)


@pytest.mark.parametrize(("old", "new", "message"), [
    ("24]", "300]", r"^joint.yaml:5: norway_5: at 300 m/s of wind .* beyond the form"),
    ("24]", "-3]", r"^joint.yaml:5: norway_5: at -3 m/s"),
    ("norway_5", "norway_7", r"^joint.yaml:3: there is no site 'norway_7'; did you mean 'norway_5'"),
    (", height: 90 m", "", "^joint.yaml:3: the distribution 'north' needs 'height'"),
])  # fmt: skip
def test_a_distribution_outside_its_range_is_a_sentence(old, new, message):
    with pytest.raises(ModelFileError, match=message):
        case_files.read_cases("joint.yaml", text=JOINT.replace(old, new))


def test_the_list_of_runs_of_the_long_term_is_a_cases_file(tmp_path):
    joint = metocean_site("norway_5").at(90.0)
    states = bins(joint, [8.0, 12.0, 16.0], [2.0, 4.0], [9.0, 11.0, 13.0])
    cases = read_cases(tmp_path / "bins.yaml", text=cases_file(states, "oc3_spar_rigid", seeds=2))
    assert len(cases) == 2 * len(states)
    assert sum(case.weight for case in cases) == pytest.approx(sum(states.probability))


LEVENMOUTH = TABLE["sets"]["levenmouth"]["load_cases"]


def test_the_set_of_levenmouth():
    """18 load cases of five seeds (Serret, 2019, tables 3.1 and 3.2): five at three speeds, and three parked ones.

    The speeds are V_r and 2 m/s about it; the gust is that of edition 2, and the grid is lost 2.45 s after it begins.
    """
    cases = list(written(["levenmouth"], wind_class="IA", seeds=5, time=600.0, discard=100.0))
    assert len(cases) == 90 and len({case.name.rpartition("_s")[0] for case in cases}) == 18
    counts = {number: sum(case.group == f"DLC {number}" for case in cases) for number in LEVENMOUTH}
    assert counts == dict.fromkeys(("L1.1", "L1.3", "L2.2", "L2.3", "L4.2"), 15) | dict.fromkeys(
        ("L6.1", "L6.2", "L6.3"), 5
    )
    factors = {case.group: case.safety_factor for case in cases}
    assert {factors[f"DLC {number}"] for number in ("L2.2", "L2.3", "L6.2")} == {1.1}
    assert {factors[f"DLC {number}"] for number in ("L1.1", "L1.3", "L4.2", "L6.1", "L6.3")} == {1.35}
    for case in cases:
        if case.group in ("DLC L2.3", "DLC L4.2"):
            assert (case.parameters["wind.edition"], case.parameters["wind.gust_years"]) == (2, 50)
            assert case.events[0]["at"] == pytest.approx(to_si(case.parameters["wind.start_time"], "s") + 2.45)
    check_cases(written(["levenmouth"], seeds=1))
    assert [case.group for case in written(["L6.2"], seeds=1)] == ["DLC L6.2"]


def test_a_short_variant_of_the_set_gives_a_sound_load_matrix(tmp_path, monkeypatch):
    """Three of its cases, cut short, as a batch; each row of the matrix is of one moment of one case."""
    monkeypatch.chdir(tmp_path)
    chosen = ("dlcL1.1_u11.5_s1", "dlcL2.3_u11.5_s1", "dlcL6.2_yaw+45_s1")
    sets = written(["levenmouth"], wind_class="IA", seeds=1, time=4.0, discard=2.0)
    cases = [replace(case, duration=min(case.duration, 6.0)) for case in sets if case.name in chosen]
    cases = [replace(case, parameters=case.parameters | _sooner(case), events=_at(case, 1.0)) for case in cases]
    monkeypatch.setattr(batches, "_workers", lambda *_: Here())
    batch = run_batch(cases, "levenmouth.batch")
    assert [row.state for row in batch] == ["done"] * 3
    results = {row.name: batch.result(row.name) for row in batch}
    channels = ("thrust", "fairlead_tension_2", "pitch")
    factors = {case.name: case.safety_factor for case in cases}
    matrix = ultimate_loads(results, channels, factors, discard=2.0)
    assert matrix.broken_rules() == [] and len(matrix.rows) == 6
    for row in matrix.rows:
        result = results[row.case]
        k = int(np.argmin(np.abs(result.time - row.time)))
        assert row.safety_factor == factors[row.case]
        assert row.values == pytest.approx([row.safety_factor * result.array(name)[k] for name in channels])


class Here:
    """Workers that compute in this process."""

    def carry_out(self, jobs):
        for job in jobs:
            yield Event("ended", job.name, "here", outcome=carry_out(job))


def _sooner(case):
    """The gust begins after a second."""
    return {"wind.start_time": 1.0} if "wind.start_time" in case.parameters else {}


def _at(case, time):
    return tuple({**event, "at": time + 2.45} for event in case.events)
