"""The short language of wind and waves: KIND[:VALUE][,key=value...], and of `--set`: path=value.

`kaimal:11.4,class=B,seed=1` and `jonswap:Hs=6,Tp=10,seed=1` become values of the parameters of the model's parts `wind`
and `sea`. Numbers are in SI, headings in degrees; a number may carry a unit ("Tp=0.2 min").
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fowtlib.language.errors import ParameterError, did_you_mean, one_of


@dataclass(frozen=True)
class Key:
    """One quantity of a condition: the parameter it sets, and its unit.

    The unit "" is text, "#" a whole number, "path" a file, "deg" an angle that is given in degrees.
    """

    parameter: str
    unit: str = "1"
    required: bool = False
    choices: tuple[str, ...] = ()

    def read(self, text: str, where: str, folder: Path = Path()) -> Any:
        """The value that `text` stands for; relative paths of files begin at `folder`."""
        if self.choices and text not in self.choices:
            raise ParameterError(f"{where}: '{text}' is not {one_of(self.choices)}.")
        if self.unit == "":
            return text
        if self.unit == "path":
            return str((folder / Path(text).expanduser()).resolve())
        from fowtlib.language.units import to_si  # the short forms are read by `fowt --help`, and units need NumPy

        if self.unit == "#":
            if not text.isdecimal():
                raise ParameterError(f"{where}: '{text}' is not a whole number{' from 0 on' * text.startswith('-')}.")
            return int(text)
        if self.unit == "deg":
            try:
                degrees = float(text)
            except ValueError:
                return to_si(text, "rad", where)
            if abs(degrees) > 360:  # said here, where it is not yet a number in rad that nobody wrote
                raise ParameterError(f"{where}: {text} deg is more than a full turn; it is in degrees.")
            return math.radians(degrees)
        return to_si(text, self.unit, where)


@dataclass(frozen=True)
class Kind:
    """What may follow the name of a kind: the key of a bare value behind the colon, and the keys.

    either: keys of which one alone may be given, because each makes the others void.
    """

    keys: Mapping[str, Key]
    bare: str = ""
    either: tuple[str, ...] = ()


@dataclass(frozen=True)
class Condition:
    """The grammar of one option: the part it sets, the parameter that holds the kind, the kinds."""

    option: str
    part: str
    selector: str
    kinds: Mapping[str, Kind]

    @property
    def usage(self) -> str:
        """The kinds with their keys, for the help text."""
        return "\n".join(self.form(name) for name in self.kinds)

    def form(self, name: str) -> str:
        """How a kind is written: `regular:H=..,T=..[,heading=..]`."""
        kind = self.kinds[name]
        bare = [f"{kind.bare.upper()}"] if kind.bare else []
        named = {key: value for key, value in kind.keys.items() if key != kind.bare}
        needed = [f"{key}=.." for key, value in named.items() if value.required]
        spare = [f"{key}=.." for key, value in named.items() if not value.required]
        inner = ",".join([*bare, *needed]) + "".join(f"[,{item}]" for item in spare)
        inner = inner.replace("[,", "[", 1) if inner.startswith("[,") else inner
        return f"{name}:{inner}" if inner else name

    def parse(self, text: str, folder: Path = Path()) -> dict[str, Any]:
        """Values by parameter path; relative paths of files begin at `folder`."""
        name, _, rest = text.partition(":")
        name = name.strip()
        if name not in self.kinds:
            hint = did_you_mean(name, self.kinds, list_up_to=len(self.kinds))
            raise ParameterError(f"{self.option}: unknown kind '{name}'{hint}")
        kind = self.kinds[name]
        if kind.bare and kind.keys[kind.bare].unit == "path":
            file, rest = _file_first(kind, rest)  # a file name may hold anything
            words = self._words(name, kind, rest) | ({kind.bare: file} if file else {})
        else:
            words = self._words(name, kind, rest)
        missing = [key for key, value in kind.keys.items() if value.required and key not in words]
        if missing:
            raise ParameterError(f"{self.option}: '{name}' needs {one_of(missing, 'and')}; write {self.form(name)}")
        values = {f"{self.part}.{self.selector}": name}
        for key, word in words.items():
            item = kind.keys[key]
            values[f"{self.part}.{item.parameter}"] = item.read(word, f"{self.option}: {key}", folder)
        return values

    def _words(self, name: str, kind: Kind, rest: str) -> dict[str, str]:
        words: dict[str, str] = {}
        if rest.strip() and not kind.keys:
            raise ParameterError(f"{self.option}: nothing follows '{name}', but there is '{rest.strip()}'.")
        for index, item in enumerate(filter(None, (item.strip() for item in rest.split(",")))):
            key, equals, word = (piece.strip() for piece in item.partition("="))
            if not equals:
                if index or not kind.bare:
                    raise ParameterError(f"{self.option}: '{item}' should be key=value; write {self.form(name)}")
                key, word = kind.bare, item
            if key not in kind.keys:
                raise ParameterError(f"{self.option}: '{name}' has no '{key}'{did_you_mean(key, kind.keys)}")
            if key in words:
                raise ParameterError(f"{self.option}: '{key}' is given twice.")
            words[key] = word
        if len([key for key in kind.either if key in words]) > 1:
            raise ParameterError(f"{self.option}: '{name}' takes {one_of(kind.either)}, not both.")
        return words


def _file_first(kind: Kind, text: str) -> tuple[str, str]:
    """The file in FILE[,key=value...], and the rest: what follows the first comma from which on all are keys."""
    pieces = text.split(",")
    behind = len(pieces)
    while behind > 1 and pieces[behind - 1].partition("=")[0].strip() in kind.keys and "=" in pieces[behind - 1]:
        behind -= 1
    return ",".join(pieces[:behind]).strip(), ",".join(pieces[behind:])


def settings(pairs: Sequence[str]) -> dict[str, Any]:
    """`--set path=value`: numbers and true/false as in JSON, lists as in YAML, anything else is text ("12.1 rpm")."""
    values: dict[str, Any] = {}
    for pair in pairs:
        path, equals, text = (piece.strip() for piece in pair.partition("="))
        if not equals or not path or not text:
            raise ParameterError(f"--set: '{pair}' should be path=value, for example --set sea.peak_period=12")
        if path in values:
            raise ParameterError(f"--set: '{path}' is given twice.")
        try:
            values[path] = json.loads(text)
        except json.JSONDecodeError:
            values[path] = _list(path, text) if text.startswith("[") else text
    return values


def _list(path: str, text: str) -> Any:
    import yaml

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise ParameterError(f"--set: {path}: '{text}' is not a list; write [1, 2] or [60 deg, 180 deg].") from None


_SPEED = {"speed": Key("mean_speed", "m/s", required=True)}
_SHEAR = {"shear": Key("shear_exponent"), "direction": Key("direction", "deg")}
_CLASS = {"class": Key("turbulence_class", "", choices=("A+", "A", "B", "C"))}
_WIND_CLASS = {
    "wind_class": Key("wind_class", "", choices=("I", "II", "III")), "reference": Key("reference_speed", "m/s"),
}  # fmt: skip
_EVENT = {**_SPEED, "at": Key("start_time", "s"), **_CLASS, "diameter": Key("rotor_diameter", "m"), **_SHEAR}
_SIGN = {"sign": Key("sign", "1")}
_EITHER_REFERENCE = ("wind_class", "reference")
_PERIOD = {"period": Key("return_period", "#")}
_DIRECTION = {"direction": Key("direction", "deg")}
_HEADING = {"heading": Key("heading", "deg"), "misalignment": Key("misalignment", "deg")}
_AIM = ("heading", "misalignment")
_HEIGHTS = {"Hs50": Key("height_50", "m"), "Hs1": Key("height_1", "m"), **_PERIOD}
_IRREGULAR = {"gamma": Key("gamma"), "seed": Key("seed", "#"), "spreading": Key("spreading"), **_HEADING}

WIND = Condition(
    "--wind",
    "wind",
    "kind",
    {
        "none": Kind({}),
        "steady": Kind({**_SPEED, **_SHEAR}, bare="speed"),
        "step": Kind(
            {
                **_SPEED,
                "to": Key("step_speed", "m/s", required=True),
                "at": Key("start_time", "s"),
                "within": Key("step_duration", "s"),
                **_SHEAR,
            },
            bare="speed",
        ),
        "veer": Kind(
            {
                **_SPEED,
                "by": Key("turn", "deg", required=True),
                "at": Key("start_time", "s"),
                "within": Key("turn_duration", "s"),
                **_SHEAR,
            },
            bare="speed",
        ),
        "gust": Kind(
            {
                **_SPEED,
                "at": Key("start_time", "s"),
                "height": Key("gust_speed", "m/s"),
                "duration": Key("gust_duration", "s"),
                "shape": Key("gust_shape", "", choices=("eog", "1-cos")),
                **_CLASS,
                **_SHEAR,
            },
            bare="speed",
            either=("height", "class"),
        ),
        "kaimal": Kind(
            {**_SPEED, **_CLASS, "intensity": Key("turbulence_intensity"), "seed": Key("seed", "#"), **_SHEAR},
            bare="speed",
            either=("class", "intensity"),
        ),
        "nwp": Kind({**_SPEED, **_SHEAR}, bare="speed"),
        "ntm": Kind(
            {**_SPEED, **_CLASS, "quantile": Key("quantile"), "seed": Key("seed", "#"), **_SHEAR}, bare="speed"
        ),
        "etm": Kind(
            {**_SPEED, **_CLASS, **_WIND_CLASS, "seed": Key("seed", "#"), **_SHEAR},
            bare="speed",
            either=_EITHER_REFERENCE,
        ),
        "ewm": Kind({**_WIND_CLASS, **_PERIOD, "seed": Key("seed", "#"), **_DIRECTION}, either=_EITHER_REFERENCE),
        "ewm_steady": Kind({**_WIND_CLASS, **_PERIOD, **_DIRECTION}, either=_EITHER_REFERENCE),
        "eog": Kind({**_EVENT, **_WIND_CLASS}, bare="speed", either=_EITHER_REFERENCE),
        "edc": Kind({**_EVENT, **_SIGN}, bare="speed"),
        "ecd": Kind({**_SPEED, "at": Key("start_time", "s"), **_SIGN, **_SHEAR}, bare="speed"),
        "ews": Kind({**_EVENT, "plane": Key("plane", "", choices=("vertical", "horizontal")), **_SIGN}, bare="speed"),
        "file": Kind({"file": Key("file", "path", required=True)}, bare="file"),
        "field": Kind({"file": Key("file", "path", required=True)}, bare="file"),
        "turbulence": Kind(
            {
                **_SPEED,
                **_CLASS,
                "intensity": Key("turbulence_intensity"),
                "model": Key("turbulence_model", "", choices=("ntm", "etm")),
                "spectrum": Key("field_spectrum", "", choices=("kaimal", "von_karman")),
                "wind_class": Key("wind_class", "", choices=("I", "II", "III")),
                "seed": Key("seed", "#"),
                "spacing": Key("point_spacing", "m"),
                "components": Key("components", "", choices=("uvw", "uv", "uw", "u")),
                "lateral": Key("lateral_coherence", "", choices=("none", "iec")),
                "period": Key("repetition_period", "s"),
                **_SHEAR,
            },
            bare="speed",
            either=("class", "intensity"),
        ),
        "input": Kind({"speed": Key("mean_speed", "m/s"), **_SHEAR}, bare="speed"),
    },
)

WAVES = Condition(
    "--waves",
    "sea",
    "spectrum",
    {
        "still": Kind({}),
        "regular": Kind(
            {"H": Key("wave_height", "m", required=True), "T": Key("wave_period", "s", required=True), **_HEADING},
            either=_AIM,
        ),
        "jonswap": Kind(
            {
                "Hs": Key("significant_wave_height", "m", required=True),
                "Tp": Key("peak_period", "s", required=True),
                **_IRREGULAR,
            },
            either=_AIM,
        ),
        "nss": Kind({"wind": Key("wind_speed", "m/s"), **_IRREGULAR}, either=_AIM),
        "sss": Kind(
            {
                "wind": Key("wind_speed", "m/s"),
                "Hs": Key("significant_wave_height", "m"),
                "Tp": Key("peak_period", "s"),
                **_IRREGULAR,
            },
            either=_AIM,
        ),
        "ess": Kind({**_HEIGHTS, "Tp": Key("peak_period", "s"), "hours": Key("hours", "#"), **_IRREGULAR}, either=_AIM),
        "ewh": Kind({**_HEIGHTS, "T": Key("wave_period", "s"), **_HEADING}, either=_AIM),
        "record": Kind(
            {
                "file": Key("file", "path", required=True),
                "start": Key("start", "s"),
                "low": Key("lowest_frequency", "rad/s"),
                "high": Key("highest_frequency", "rad/s"),
                **_HEADING,
            },
            bare="file",
            either=_AIM,
        ),
        "input": Kind({}),
    },
)
