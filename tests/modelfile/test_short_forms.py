"""The short language of --wind, --waves and --set."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from fowtlib.components.environment import Sea, Wind
from fowtlib.language.errors import ModelError
from fowtlib.modelfile.short_forms import WAVES, WIND, settings


@pytest.mark.parametrize(
    ("condition", "text", "values"),
    [
        (WIND, "none", {"wind.kind": "none"}),
        (WIND, "steady:8", {"wind.kind": "steady", "wind.mean_speed": 8.0}),
        (
            WIND,
            "steady:speed=8,shear=0.14",
            {"wind.kind": "steady", "wind.mean_speed": 8.0, "wind.shear_exponent": 0.14},
        ),
        (WIND, "steady:28.8 km/h", {"wind.kind": "steady", "wind.mean_speed": pytest.approx(8.0)}),
        (
            WIND,
            "kaimal:11.4,class=B,seed=1",
            {"wind.kind": "kaimal", "wind.mean_speed": 11.4, "wind.turbulence_class": "B", "wind.seed": 1},
        ),
        (WIND, "file:a=b,c.csv", {"wind.kind": "file", "wind.file": str(Path("a=b,c.csv").resolve())}),
        (WIND, "field:a.bts", {"wind.kind": "field", "wind.file": str(Path("a.bts").resolve())}),
        (WAVES, "still", {"sea.spectrum": "still"}),
        (
            WAVES,
            "regular:H=6,T=10,heading=30",
            {
                "sea.spectrum": "regular",
                "sea.wave_height": 6.0,
                "sea.wave_period": 10.0,
                "sea.heading": pytest.approx(math.radians(30)),
            },
        ),
        (
            WAVES,
            "jonswap: Hs=6 m, Tp=10 s, seed=1",
            {
                "sea.spectrum": "jonswap",
                "sea.significant_wave_height": 6.0,
                "sea.peak_period": 10.0,
                "sea.seed": 1,
            },
        ),
    ],
)
def test_a_condition_sets_parameters(condition, text, values):
    assert condition.parse(text) == values


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("record:buoy.csv", {"file": "buoy.csv"}),
        ("record:a=b, c.csv,heading=30,start=120 s", {"file": "a=b, c.csv", "heading": 30, "start": 120.0}),
        ("record:buoy,2.csv, heading=-90", {"file": "buoy,2.csv", "heading": -90}),
    ],
)
def test_a_record_of_waves_has_a_file_and_more(text, values):
    found = WAVES.parse(text)
    assert found.pop("sea.spectrum") == "record"
    assert found.pop("sea.file") == str(Path(values.pop("file")).resolve())
    if "heading" in values:
        assert found.pop("sea.heading") == pytest.approx(math.radians(values.pop("heading")))
    assert found == {f"sea.{name}": value for name, value in values.items()}


SPEED = "a speed in m/s is expected, e.g. '11.4 m/s'."
RECORD = "record:FILE[,start=..][,low=..][,high=..][,heading=..][,misalignment=..]"
REGULAR = "regular:H=..,T=..[,heading=..][,misalignment=..]"


@pytest.mark.parametrize(
    ("condition", "text", "message"),
    [
        (WIND, "kamal:8", "--wind: unknown kind 'kamal'; did you mean 'kaimal'?"),
        (
            WIND,
            "",
            "--wind: unknown kind ''; there are 'none', 'steady', 'step', 'veer', 'gust', 'kaimal', 'nwp', 'ntm', "
            "'etm', 'ewm', 'ewm_steady', 'eog', 'edc', 'ecd', 'ews', 'file', 'field', 'turbulence' and 'input'.",
        ),
        (WIND, "steady", "--wind: 'steady' needs 'speed'; write steady:SPEED[,shear=..][,direction=..]"),
        (WIND, "steady:fast", f"--wind: speed: got 'fast'; {SPEED}"),
        (WIND, "steady:3 kg", f"--wind: speed: got '3 kg', which is a mass; {SPEED}"),
        (WIND, "steady:8,sheer=0.2", "--wind: 'steady' has no 'sheer'; did you mean 'shear'?"),
        (WIND, "kaimal:8,class=D", "--wind: class: 'D' is not 'A+', 'A', 'B' or 'C'."),
        (WIND, "kaimal:8,seed=1.5", "--wind: seed: '1.5' is not a whole number."),
        (WIND, "kaimal:8,seed=-1", "--wind: seed: '-1' is not a whole number from 0 on."),
        (WIND, "steady:8,direction=400", "--wind: direction: 400 deg is more than a full turn; it is in degrees."),
        (WAVES, "regular:H=1,T=9,heading=-1000",
         "--waves: heading: -1000 deg is more than a full turn; it is in degrees."),
        (WAVES, "jonswap:Hs=1,Tp=9,misalignment=361",
         "--waves: misalignment: 361 deg is more than a full turn; it is in degrees."),
        (WIND, "file", "--wind: 'file' needs 'file'; write file:FILE"),
        (WAVES, "regular:6,10", f"--waves: '6' should be key=value; write {REGULAR}"),
        (WAVES, "regular:H=6", f"--waves: 'regular' needs 'T'; write {REGULAR}"),
        (WAVES, "regular", f"--waves: 'regular' needs 'H' and 'T'; write {REGULAR}"),
        (WAVES, "regular:H=6,T=10,H=5", "--waves: 'H' is given twice."),
        (WAVES, "record", f"--waves: 'record' needs 'file'; write {RECORD}"),
        (WAVES, "still:3", "--waves: nothing follows 'still', but there is '3'."),
        (WIND, "kaimal:8,class=A,intensity=0.1", "--wind: 'kaimal' takes 'class' or 'intensity', not both."),
        (WIND, "ewm:50", "--wind: '50' should be key=value; write ewm:[wind_class=..][,reference=..][,period=..]"
         "[,seed=..][,direction=..]"),
        (WIND, "ewm:wind_class=I,reference=57", "--wind: 'ewm' takes 'wind_class' or 'reference', not both."),
        (WAVES, "ess:Hs50=12,Hs1=9", "--waves: 'ess' takes 'Hs50' or 'Hs1', not both."),
        (WAVES, "ewh:Hs50=12,Hs1=9,period=1", "--waves: 'ewh' takes 'Hs50' or 'Hs1', not both."),
        (WAVES, "ess:Hs1=9", "--waves: 'Hs1' of 'ess' does nothing with period=50; leave it out, or give period=1."),
        (WAVES, "ewh:Hs50=9,period=1",
         "--waves: 'Hs50' of 'ewh' does nothing with period=1; leave it out, or give period=50."),
        (WAVES, "sss:Hs=9,wind=20", "--waves: 'sss' takes 'Hs' or 'wind', not both."),
        (WIND, "turbulence:9,intensity=0.1,model=etm", "--wind: 'turbulence' takes 'model' or 'intensity', not both."),
        (WIND, "turbulence:9,wind_class=II",
         "--wind: 'wind_class' of 'turbulence' does nothing with model=ntm; leave it out, or give model=etm."),
        (WIND, "turbulence:9,components=u,lateral=iec",
         "--wind: 'lateral' of 'turbulence' does nothing with components=u; leave it out, or give components=uvw or "
         "components=uv or components=uw."),
        (WAVES, "ess:heading=10,misalignment=20", "--waves: 'ess' takes 'heading' or 'misalignment', not both."),
    ],
)  # fmt: skip
def test_a_mistake_in_a_condition_is_named(condition, text, message):
    with pytest.raises(ModelError) as caught:
        condition.parse(text)
    assert str(caught.value) == message


def test_the_kinds_and_parameters_are_those_of_the_parts():
    for condition, part in ((WIND, Wind), (WAVES, Sea)):
        own = {kind: cls for kind, cls in part.family.kinds.items() if cls.__module__.startswith("fowtlib.")}
        assert list(condition.kinds) == list(own)
        for name, kind in condition.kinds.items():
            parameters = (part if part.family is None else part.family.kinds[name]).parameters
            for key in kind.keys.values():
                assert key.parameter in parameters
                if key.choices:
                    assert key.choices == parameters[key.parameter].choices


def test_settings_are_numbers_lists_or_text():
    pairs = ["a.b=12.1 rpm", "n=3", "r=[0, 0, 1.5]", "flag=true", "name = data:x.nc", "h=[60 deg, 1.5]"]
    plain = {"a.b": "12.1 rpm", "n": 3, "r": [0, 0, 1.5], "flag": True, "name": "data:x.nc"}
    assert settings(pairs) == {**plain, "h": ["60 deg", 1.5]}


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        (["mass"], "--set: 'mass' should be path=value, for example --set sea.peak_period=12"),
        (["=3"], "--set: '=3' should be path=value, for example --set sea.peak_period=12"),
        (["a=1", "a=2"], "--set: 'a' is given twice."),
        (["a=[1, 2"], "--set: a: '[1, 2' is not a list; write [1, 2] or [60 deg, 180 deg]."),
    ],
)
def test_a_mistake_in_a_setting_is_named(pairs, message):
    with pytest.raises(ModelError) as caught:
        settings(pairs)
    assert str(caught.value) == message
