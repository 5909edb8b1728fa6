"""Cases that cannot be run are refused before anything runs, each with a sentence, its name and its line."""

import time
from pathlib import Path

import pytest

from fowtlib.cases import check_cases, read_cases
from fowtlib.language.errors import ModelFileError
from fowtlib.modelfile import load

FILE = """fowtlib_cases: 1
model: oc3_spar_rigid
defaults: {solver: fixed, outputs: [surge, turbine.rotor_speed]}
sets:
  - name: ok
  - name: mine_{wind_speed}
    vary: {wind_speed: [8, 12]}
    wind: {kind: kaimal, mean_speed: wind_speed}
    sea: jonswap:Hs=6,Tp=10
    set: {sea.heading: 30 deg}
"""

WRONG = [
    ("set: {sea.heading: 30 deg}", "set: {se.heading: 3}", ":10: case 'mine_8': .*no part 'se'; did you mean 'sea'"),
    ("set: {sea.heading: 30 deg}", "set: {sea.headng: 3}", ":10: case 'mine_8': .*no parameter 'headng'"),
    ("set: {sea.heading: 30 deg}", "set: {sea.heading: 30 kg}", ":10: case 'mine_8': sea.heading: got '30 kg', wh"),
    ("set: {sea.heading: 30 deg}", "set: {wind.stations: [[0, 90]]}", ":10: case 'mine_8': wind.stations is str"),
    ("set: {sea.heading: 30 deg}", "set: {wind.seed: 1.5}", ":10: case 'mine_8': wind.seed: got 1.5; a whole"),
    ("set: {sea.heading: 30 deg}", "set: {wind.seed: Hss}", ":10: case 'mine_8': wind.seed: 'Hss' is neither"),
    ("set: {sea.heading: 30 deg}", "set: {wind.file: no.csv}", ":10: case 'mine_8': wind: .*no parameter 'file'"),
    ("mean_speed: wind_speed", "mean_speed: -1 * wind_speed", ":8: case 'mine_8': wind.mean_speed = -8 m/s is below"),
    ("{kind: kaimal, mean_speed: wind_speed}", "'input:{wind_speed}'", ":8: case 'mine_8': wind.kind: .*of its own"),
    ("{kind: kaimal,", "{kind: kaimul,", ":8: case 'mine_8': wind.kind.*kaimul.*did you mean 'kaimal'"),
    ("{kind: kaimal, mean_speed: wind_speed}", "{kind: file, interpolation: linear, shear_exponent: wind_speed}",
     ":8: case 'mine_8': wind.file has no value; wind 'file' needs it"),
    ("{kind: kaimal, mean_speed: wind_speed}", "'file:no_such_{wind_speed}.csv'", ":8: case 'mine_8': .*no_such_8.csv"),
    ("Hs=6,Tp=10", "Hs=9,Tp=7", ":9: case 'mine_8': a sea of Hs 9 m and Tp 7 s is steeper .*at most 5.1 m"),
    ("Hs=6,Tp=10", "Hs=260,Tp=90", ":9: case 'mine_8': waves of 260 m break in water 320 m deep"),
    ("Hs=6,Tp=10", "Hs=1,Tp=0", ":9: case 'mine_8': sea.peak_period = 0 s is not above 0 s"),
    ("jonswap:Hs=6,Tp=10", "regular:H=15,T=8", ":9: case 'mine_8': a regular wave of 8 s breaks at 14.2 m"),
    ("jonswap:Hs=6,Tp=10", "{spectrum: regular, wave_period: 9}", ":9: case 'mine_8': sea.wave_height has no value"),
    ("outputs: [surge,", "outputs: [surg,", ":3: case 'ok': outputs: there is no result 'surg'; did you mean 'surge'"),
    ("turbine.rotor_speed", "turbine.nothing", ":3: case 'ok': outputs: 'turbine.nothing'"),
    ("solver: fixed", "solver: fast", ":3: case 'ok': solver: 'fast' is not 'idas' or 'fixed'"),
    ("model: oc3_spar_rigid", "model: broken.yaml", ":2: model: .*broken.yaml:2"),
]


def checked(folder: Path, text: str) -> None:
    (folder / "broken.yaml").write_text("fowtlib: 1\nparts: {a: {class: Nothing}}\n")
    path = folder / "cases.yaml"
    path.write_text(text)
    check_cases(read_cases(path))


def test_what_can_be_run_passes(tmp_path):
    checked(tmp_path, FILE)


@pytest.mark.parametrize(("old", "new", "message"), WRONG, ids=[new[:30] for _, new, _ in WRONG])
def test_what_cannot_be_run_is_a_sentence(tmp_path, old, new, message):
    assert old in FILE
    with pytest.raises(ModelFileError, match=message):
        checked(tmp_path, FILE.replace(old, new, 1))


def test_a_steep_sea_that_is_known_to_occur_is_allowed(tmp_path):
    checked(tmp_path, FILE.replace("Hs=6,Tp=10", "Hs=9,Tp=7\n    steep_sea: allow"))


def test_a_model_is_loaded_once_and_a_thousand_cases_are_checked_quickly(tmp_path):
    path = tmp_path / "cases.yaml"
    path.write_text(FILE + "  - {name: 's{seed_number}', seeds: 1000, wind: 'kaimal:9,seed={seed}'}\n")
    loaded = []

    def counted(name):
        loaded.append(name)
        return load(name)

    cases = read_cases(path)
    check_cases(cases, counted)
    begin = time.process_time()
    check_cases(cases)
    assert loaded == ["oc3_spar_rigid"] and time.process_time() - begin < 2.0


EVENTS = [
    ("turbine.grid_loss at 100 s, delay=0.5 s", None),
    ("{event: turbine.safety.grid_loss, at: wind_speed * 10}", None),
    ("turbine.grid_los at 100 s", ":8: case 'mine_8': events: there is no event 'turbine.grid_los'; did you mean"),
    ("turbine.grid_loss at 5000 s", ":8: case 'mine_8': events: 'turbine.grid_loss' is to happen at 5000 s, and"),
    ("mooring.loss at 5 s", ":8: case 'mine_8': events: 'mooring.loss' can happen at 3 places"),
    ("turbine.grid_loss", "events: 'turbine.grid_loss' is no event"),
    ("{event: turbine.grid_loss}", "events: the event 'turbine.grid_loss' needs its time"),
]


@pytest.mark.parametrize(("event", "message"), EVENTS)
def test_events(tmp_path, event, message):
    text = FILE.replace("vary: {wind_speed: [8, 12]}", "vary: {wind_speed: [8, 12]}\n    events:\n    - " + event)
    if message is None:
        checked(tmp_path, text)
        return
    with pytest.raises(ModelFileError, match=message):
        checked(tmp_path, text)


def test_a_sea_of_the_site_is_checked_for_the_wind_of_the_case(tmp_path):
    states = "{spectrum: nss, states: [[4, 1, 8], [10, 12, 9]]}"
    text = FILE.replace("jonswap:Hs=6,Tp=10", states)
    with pytest.raises(ModelFileError, match=":10: case 'mine_8': a sea of Hs 8.333 m and Tp 8.667 s is steeper"):
        checked(tmp_path, text.replace("[8, 12]", "[4, 8]").replace("    sea:", "    solver: fixed\n    sea:"))
    with pytest.raises(ModelFileError, match=":9: case 'mine_12': .*covers wind of 4 to 10 m/s, and there is one"):
        checked(tmp_path, text.replace("[8, 12]", "[4, 12]"))
