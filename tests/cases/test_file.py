"""A cases file becomes cases: products, conditional values, names, seeds, weights; and each mistake has its line."""

import json
import math
import random
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.cases import Case, check_cases, read_cases
from fowtlib.language.errors import ModelFileError
from fowtlib.modelfile.short_forms import WAVES, WIND
from fowtlib.modelfile.yaml_text import to_text

FILE = """fowtlib_cases: 1
title: normal operation
model: oc3_spar_rigid
variables: {exponent: 0.14}
tables:
  site: {wind_speed: [4, 12, 24], Hs: [1, 2, 5], Tp: [8, 9, 12]}
defaults:
  duration: 10 min
  discard: 100 s
  start: turning
  outputs: [surge, pitch]
  look_up: site
  wind: {kind: kaimal, mean_speed: wind_speed, turbulence_class: B, seed: seed}
  sea: {spectrum: jonswap, significant_wave_height: Hs, peak_period: Tp, seed: wave_seed, heading: heading}
  set: {wind.shear_exponent: exponent}
sets:
  - group: DLC 1.2
    name: u{wind_speed:02.0f}_h{heading:.0f}_s{seed_number}
    vary: {wind_speed: 4:24:4, heading: [0 deg, 30 deg]}
    seeds: 3
    weights: {weibull: {scale: 11.2, shape: 2.1}}
    safety_factor: 1
"""


def written(folder: Path, text: str = FILE, **files: str) -> Path:
    for name, content in files.items():
        (folder / name.replace("__", ".")).write_text(content)
    path = folder / "cases.yaml"
    path.write_text(text)
    return path


def test_a_product_with_conditional_values(tmp_path):
    cases = read_cases(written(tmp_path))
    assert len(cases) == 6 * 2 * 3
    assert [case.name for case in cases][:4] == ["u04_h0_s1", "u04_h0_s2", "u04_h0_s3", "u04_h30_s1"]
    case = next(case for case in cases if case.name == "u08_h30_s2")
    assert case.group == "DLC 1.2" and case.duration == 600 and case.discard == 100 and case.start == "turning"
    values = case.parameters
    assert values["wind.kind"] == "kaimal" and values["wind.mean_speed"] == 8 and values["sea.heading"] == "30 deg"
    assert values["sea.significant_wave_height"] == 1.5 and values["sea.peak_period"] == 8.5
    assert values["wind.seed"] != values["sea.seed"]
    assert case.labels["wind_speed"] == 8 and case.labels["heading"] == 30 and case.labels["Hs"] == 1.5
    assert cases.place(case.name, "sea.peak_period").line == 14
    assert cases.files == ((tmp_path / "cases.yaml").resolve(),)


def test_weights_are_the_share_of_the_wind_speed(tmp_path):
    cases = read_cases(written(tmp_path))
    above = lambda speed: math.exp(-((speed / 11.2) ** 2.1))  # noqa: E731
    assert sum(case.weight for case in cases) == pytest.approx(above(2) - above(26))
    of_12 = [case.weight for case in cases if case.labels["wind_speed"] == 12]
    assert of_12 == pytest.approx([(above(10) - above(14)) / 6] * 6)


def test_seeds_differ_between_states_and_stay_when_states_are_added(tmp_path):
    few = {case.name: case.parameters["wind.seed"] for case in read_cases(written(tmp_path))}
    more = {
        case.name: case.parameters["wind.seed"]
        for case in read_cases(written(tmp_path, FILE.replace("4:24:4", "4:24:2").replace("seeds: 3", "seeds: 4")))
    }
    assert len(set(few.values())) == len(few) and all(more[name] == seed for name, seed in few.items())


def test_short_forms_defaults_and_formulas(tmp_path):
    text = """fowtlib_cases: 1
model: oc3_spar_rigid
variables: {rated: 22 kn}
defaults: {wind: {kind: kaimal, mean_speed: 9, turbulence_class: B}, set: {sea.heading: 0.1, wind.shear_exponent: 0.2}}
sets:
  - {name: a, wind: {mean_speed: 1.5 * rated}}
  - {name: b, wind: {kind: steady, mean_speed: rated}}
  - {name: "c{k}", vary: {k: [1]}, wind: "kaimal:{rated},class=C,seed={k}", sea: "regular:H=2,T=9,heading=30"}
  - {name: d, set: {sea.heading: 20 deg}}
"""
    cases = {case.name: case.parameters for case in read_cases(written(tmp_path, text))}
    assert cases["a"]["wind.mean_speed"].endswith(" m/s") and cases["a"]["wind.turbulence_class"] == "B"
    assert "wind.turbulence_class" not in cases["b"] and cases["b"]["wind.shear_exponent"] == 0.2
    assert cases["c1"]["wind.mean_speed"] == pytest.approx(22 * 1852 / 3600) and cases["c1"]["wind.seed"] == 1
    assert cases["c1"]["sea.wave_height"] == 2 and cases["c1"]["sea.heading"] == 0.1  # `set` has the last word
    assert cases["d"]["sea.heading"] == "20 deg"


def test_zip_csv_and_a_distribution_object(tmp_path):
    class Linear:
        def conditional(self, wind_speed):
            return 0.2 * wind_speed, 8 + 0.1 * wind_speed

    text = """fowtlib_cases: 1
model: oc3_spar_rigid
sets:
  - group: scatter
    vary: {zip: states.csv, sea_seed: [1, 2]}
    weights: {scatter: weights.csv}
    sea: {spectrum: jonswap, significant_wave_height: Hs, peak_period: Tp, seed: sea_seed, heading: from}
  - name: joint_{wind_speed}
    vary: {zip: {wind_speed: 4:8:2, heading: [0, 1, 2]}}
    look_up: north_sea
    wind: steady:{wind_speed}
    sea: {spectrum: jonswap, significant_wave_height: Hs, peak_period: Tp, heading: heading}
"""
    states = "# states\nHs [m], Tp, from [deg]\n1, 7, 0\n2, 8, 90\n"
    files = {"states__csv": states, "weights__csv": "Tp,weight\n7,3\n8,1\n"}
    made = read_cases(written(tmp_path, text, **files), distributions={"north_sea": Linear()})
    cases = made.cases
    assert [case.name for case in cases[:4]] == ["scatter_0001", "scatter_0002", "scatter_0003", "scatter_0004"]
    assert cases[2].parameters["sea.significant_wave_height"] == "2 m"
    assert cases[2].parameters["sea.heading"].endswith(" rad") and cases[2].parameters["sea.seed"] == 1
    assert [case.weight for case in cases[:4]] == [1.5, 1.5, 0.5, 0.5]
    assert cases[5].parameters["sea.significant_wave_height"] == pytest.approx(1.2)
    assert cases[5].labels["heading"] == 1
    assert {path.name for path in made.files} == {"cases.yaml", "states.csv", "weights.csv"}


OWN_WIND = "{kind: kaimal, mean_speed: wind_speed, turbulence_class: B, seed: seed}"
WRONG = [
    ("fowtlib_cases: 1", "fowtlib_cases: 2", ":1: got 'fowtlib_cases: 2'"),
    ("fowtlib_cases: 1", "fowtlib: 1", ":1: this is a model file"),
    ("title:", "titel:", ":2: 'titel' is not a key of a cases file; did you mean 'title'?"),
    ("oc3_spar_rigid", "oc3_spar_rigd", ":3: model: there is no model 'oc3_spar_rigd'.*did you mean 'oc3_spar_rigid'"),
    ("vary:", "varry:", ":19: 'varry' is not a key of a set of cases; did you mean 'vary'?"),
    ("duration: 10 min", "duration: 10 m", ":8: duration: got '10 m', which is a length"),
    ("duration: 10 min", "duration: -1", ":8: duration is -1 s; it must be above zero"),
    ("discard: 100 s", "discard: 700 s", ":9: discard: 700 s of a run of 600 s leave nothing"),
    ("start: turning", "start: turnning", ":10: start: 'turnning' is not"),
    ("look_up: site", "look_up: sight", ":12: look_up: there is no table and no distribution 'sight'"),
    ("4:24:4", "4:26:2", ":17: wind_speed = 26 lies outside of the table 'site', which goes from 4 to 24"),
    ("4:24:4", "4:25:4", ":19: the range 4:25:4 does not end at 25; write 4:24:4"),
    ("4:24:4", "24:4:4", ":19: the range 24:4:4 does not lead from 24 to 4"),
    ("4:24:4", "0:1:1e-9", "more than 100000 values"),
    ("seeds: 3", "seeds: 10000", "with this set of 120000 cases the file has 120000; the limit is 100000"),
    ("seeds: 3", "seeds: 2.5", ":20: seeds is 2.5"),
    ("_s{seed_number}", "", ":18: two cases are called 'u04_h0'; the first is of"),
    ("u{wind_speed:02.0f}", "../u{wind_speed}", ":18: '../u4_h0_s1' cannot be the name of a case"),
    ("{wind_speed:02.0f}", "{wind_sped}", "there is no variable 'wind_sped'; did you mean 'wind_speed'"),
    ("{wind_speed:02.0f}", "{wind_sped}", ":18: name: .*no.* 'wind_sped'|:18: .*'wind_sped' is not a formula"),
    ("{wind_speed:02.0f}", "{wind_speed:99999d}", ":18: .*is not how a number is written"),
    (", heading: heading}", "}", ":19: 'heading' varies, and nothing in the cases depends on it"),
    ("seed: seed}", "seed: 1}", None),  # the sea still uses a seed
    ("scale: 11.2, shape: 2.1", "scale: 11.2", ":21: 'weibull' needs 'shape'"),
    ("scale: 11.2", "scale: -1", ":21: weibull: scale is -1"),
    ("mean_speed: wind_speed", "mean_speed: wind_speed + exponnt",
     ":13: .*no variable 'exponnt'; did you mean 'exponent'"),
    ("safety_factor: 1", "safety_factor: 0", ":22: safety_factor is 0"),
    ("Hs: [1, 2, 5]", "Hs: [1, 2]", ":6: the columns of the table 'site' have the same length"),
    ("wind_speed: [4, 12, 24]", "wind_speed: [4, 12, 12]", ":6: the table 'site': 'wind_speed', its first column"),
    (OWN_WIND, "kaimul:9", ":13: wind: unknown kind 'kaimul'"),
    (OWN_WIND, "kaimal:wind_speed", ":13: .*A variable stands in braces here: {wind_speed}"),
    ("    seeds: 3\n", "    values: {seed: wave_seed, wave_seed: seed}\n",
     "'seed' needs itself|'wave_seed' needs itself"),
    ("    seeds: 3\n", "    seeds: 3\n    values: {Hs: 3}\n", ":17: 'Hs' is given twice"),
    ("    seeds: 3\n", "    seeds: 3\n    values: {H: 3}\n", ":21: nothing uses the value 'H'"),
    ("variables: {exponent: 0.14}", "variables: {pi: 3}", ":4: 'pi' has a meaning in formulas"),
    ("variables: {exponent: 0.14}", "variables: {exponent: 0.14, spare: 3}", ":4: nothing uses the variable 'spare'"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG, ids=[new[:30] for _, new, _ in WRONG])
def test_a_mistake_is_a_sentence_with_its_line(tmp_path, old, new, message):
    assert old in FILE
    path = written(tmp_path, FILE.replace(old, new, 1))
    if message is None:
        read_cases(path)
        return
    with pytest.raises(ModelFileError, match=message):
        read_cases(path)


names = st.from_regex(r"[a-z][a-z_]{2,8}", fullmatch=True).filter(lambda name: name not in ("min", "max", "sin"))
numbers = st.one_of(st.integers(-1000, 1000), st.floats(-1e6, 1e6).map(lambda x: round(x, 6)))
axes = st.dictionaries(names, st.lists(numbers, min_size=1, max_size=4, unique_by=float), min_size=1, max_size=3)


@settings(max_examples=25, deadline=None)
@given(axes=axes)
def test_a_product_has_every_combination_once_and_cases_go_through_json(tmp_path_factory, axes):
    axes = {f"v_{name}": values for name, values in axes.items()}
    document = {"fowtlib_cases": 1, "model": "oc3_spar_rigid", "sets": [
        {"vary": axes, "set": {f"part.{name}": name for name in axes}}]}  # fmt: skip
    path = tmp_path_factory.mktemp("product") / "cases.yaml"
    path.write_text(to_text(document))
    cases = read_cases(path).cases
    assert len(cases) == math.prod(map(len, axes.values()))
    states = {tuple(case.parameters[f"part.{name}"] for name in axes) for case in cases}
    assert len(states) == len(cases)
    for name, values in axes.items():
        assert {case.parameters[f"part.{name}"] for case in cases} == set(values)
    assert len({case.name.lower() for case in cases}) == len(cases)
    assert all(Case.from_plain(json.loads(json.dumps(case.plain()))) == case for case in cases)


JUNK = ["null", "[]", "{}", "-1", "1e400", "nan", "true", "'{'", "{a}", "4:8:0", "1:2:1 kg", "*x", "[[1]]", "pi",
        "1/0", "2**9999", "é", "../..", "data:x", "5 deg", "heading - 3", "[1, a]", "1 furlong", "{seed_number}{", "}",
        "x.csv", "turbine.grid_loss at 3 s", "kaimal:", "jonswap:Hs=", "sqrt(-1)", "{wind_speed + }", "wind_speed",
        ""]  # fmt: skip


def test_no_mistake_shows_a_traceback_or_loses_its_line(tmp_path):
    generator, words = random.Random(1), list(re.finditer(r"[\w.{}:+'\[\]-]+", FILE))
    refused = 0
    for _ in range(150):
        text = FILE
        for word in sorted(generator.sample(words, generator.choice([1, 1, 2])), key=lambda word: -word.start()):
            new = generator.choice(words)[0] if generator.random() < 0.3 else generator.choice(JUNK)
            text = text[: word.start()] + new + text[word.end() :]
        try:
            check_cases(read_cases(tmp_path / "cases.yaml", text=text))
        except ModelFileError as error:
            refused += 1
            assert re.search(r"cases\.yaml:\d+: ", str(error)), f"{error}\n{text}"
    assert refused > 110


def test_the_file_the_command_line_and_the_model_file_build_the_same_conditions(tmp_path):
    text = """fowtlib_cases: 1
model: oc3_spar_rigid
sets:
  - {name: words, wind: {kind: kaimal, mean_speed: 12, turbulence_class: C, seed: 3}, sea: {spectrum: regular,
     wave_height: 3, wave_period: 9}}
  - {name: short, wind: "kaimal:12,class=C,seed=3", sea: "regular:H=3,T=9"}
  - {name: varied, vary: {v: [12]}, wind: "kaimal:{v},class=C,seed=3", sea: "regular:H=3,T={v - 3}"}
"""
    words, short, varied = read_cases(tmp_path / "cases.yaml", text=text)
    of_command_line = WIND.parse("kaimal:12,class=C,seed=3") | WAVES.parse("regular:H=3,T=9")
    assert words.parameters == short.parameters == varied.parameters == of_command_line
    assert words.conditions() == short.conditions() and len({case.digest() for case in (words, short, varied)}) == 1


OUTSIDE = [
    ("model: oc3_spar_rigid", "model: ../model.yaml", ":2: model: '../model.yaml' is refused: it lies outside"),
    ("zip: here.csv", "zip: ../there.csv", ":4: '../there.csv' is refused"),
    ("set: {sea.heading: a}", "set: {sea.heading: a, wind.file: ../wind.csv}", ":5: wind.file: '.*' is refused"),
    ("wind: steady:8", "wind: file:../wind.csv", ":6: wind.file: '.*wind.csv' is refused"),
    ("start: rest", "start: ../end.nc", ":7: start: '../end.nc' is refused"),
]


@pytest.mark.parametrize(("old", "new", "message"), OUTSIDE)
def test_a_file_reads_beside_itself_and_elsewhere_with_leave(tmp_path, old, new, message):
    text = """fowtlib_cases: 1
model: oc3_spar_rigid
sets:
  - vary: {zip: here.csv}
    set: {sea.heading: a}
    wind: steady:8
    start: rest
"""
    folder = tmp_path / "inner"
    folder.mkdir()
    path = written(folder, text.replace(old, new), here__csv="a\n0\n1\n")
    written(tmp_path, "", there__csv="a\n0\n1\n", wind__csv="", end__nc="", model__yaml="fowtlib: 1\n")
    with pytest.raises(ModelFileError, match=message):
        read_cases(path)
    cases = read_cases(path, allow=tmp_path)
    assert len(cases) == 2 and len(cases.files) == (2 if "there" in new else 3)
    assert all(file.is_absolute() for file in cases.files)
