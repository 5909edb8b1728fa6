"""Named sets of load cases: the design load cases of IEC 61400-3-1 and -3-2 as a cases file.

The table of the cases is data, load_cases.yaml beside this module.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.cases.lists import spread
from fowtlib.cases.plant_facts import (
    event_paths,
    has_blade_elements,
    hub_height,
    idling_parameters,
    rated_wind_speed,
    require_weather,
    rotors_for_front_wind,
)
from fowtlib.cases.site import Site, site_error
from fowtlib.components.environment import Wind, iec
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.modelfile.nodes import Place, parse, read_text
from fowtlib.modelfile.yaml_text import to_text
from fowtlib.solving.model import Model

TABLE = Path(__file__).with_name("load_cases.yaml")
CLASS = re.compile(r"(I{1,3})(A\+|A|B|C)")
BEFORE, AFTER = 30.0, 300.0  # s of a short run about an event, after what is discarded: before the event, and after it
SEAS = {"normal": "normal_sea", "severe": "severe_sea"}
FORMS = {"sign": ":+d", "yaw_error": ":+.0f", "misalignment": ":+.0f", "wind_speed": ":04.1f", "delay": ":.2f"}
"""How values stand in the names of cases."""


@dataclass(frozen=True)
class Request:
    """What named sets are asked for.

    model: its name as the file has it; wind_class: such as "IB"; wind: wind speeds in operation, first:last:step [m/s];
    rated: rated wind speed [m/s], None for that of the model; time: length that is judged [s]; discard: time before it
    [s]; misalignment: of waves and wind [deg].
    """

    numbers: Sequence[str]
    model: str
    site: Site
    wind_class: str = "IB"
    wind: str = "4:24:2"
    seeds: int = 6
    rated: float | None = None
    time: float = 3600.0
    discard: float = 400.0
    misalignment: Sequence[float] = (0.0,)


@cache
def load_case_table() -> dict[str, Any]:
    """The table as plain data: source, factors, winds, load_cases, others."""
    return parse(read_text(TABLE, TABLE.name), TABLE.name).plain()


def load_cases_of(numbers: Sequence[str]) -> list[str]:
    """The numbers of load cases, those of a set in place of its name."""
    sets = load_case_table()["sets"]
    found = [one for name in numbers for one in (sets[name]["load_cases"] if name in sets else [name])]
    return list(dict.fromkeys(found))


def write_dlc(request: Request, model: Model) -> str:
    """The text of a cases file with these load cases.

    Raises ModelError for a load case that there is not, or for which model, site or request lack something.
    """
    return to_text(_Writer(request, model).document())


class _Writer:
    """Makes the sets of one request."""

    def __init__(self, request: Request, model: Model):
        self.request, self.model, self.site = request, model, request.site
        self.table = load_case_table()
        found = CLASS.fullmatch(request.wind_class)
        if found is None:
            raise ParameterError(
                f"'{request.wind_class}' is not a class of IEC 61400-1: I, II or III, then A+, A, B or C, such as IB."
            )
        self.wind_class, self.turbulence_class = found[1], found[2]
        self.operating = _speeds(request.wind)
        require_weather(model)
        height = hub_height(model)
        if abs(height - self.site.hub_height) > 0.5:
            raise ParameterError(
                f"the wind of the site '{self.site.name}' is at {self.site.hub_height:g} m, and wind.reference_height "
                f"of the model is {height:g} m; give the site for that height."
            )
        self.tables: dict[str, Any] = {}
        self.variables: dict[str, Any] = {}

    def document(self) -> dict[str, Any]:
        """The whole file as plain data."""
        numbers = load_cases_of(self.request.numbers)
        sets = [self.set(number) for number in numbers]
        about = f"DLC {', '.join(numbers)}, class {self.request.wind_class}"
        sources = [item["source"] for name, item in self.table["sets"].items() if name in self.request.numbers]
        source = " ".join(sources) if len(sources) == len(self.request.numbers) else self.table["source"]
        document: dict[str, Any] = {
            "fowtlib_cases": 1,
            "title": f"{about}, {self.site.title}",
            "description": f"Load cases: {source} Site: {self.site.source}",
            "model": self.request.model,
        }
        if self.variables:
            document["variables"] = self.variables
        if self.tables:
            document["tables"] = self.tables
        document["defaults"] = {"discard": f"{self.request.discard:g} s"} if self.request.discard else {}
        document["sets"] = sets
        return {key: value for key, value in document.items() if value}

    def set(self, number: str) -> dict[str, Any]:
        """One load case as a set of the file."""
        entry = self._entry(number)
        vary = self._vary(number, entry)
        transient, idling = entry.get("transient", False), entry.get("idling", False)
        made: dict[str, Any] = {"group": f"DLC {number}"}
        events, over = self._events(number, entry)
        vary |= over
        made["name"] = f"dlc{number}" + "".join(f"_{_short(key)}{{{key}{FORMS.get(key, '')}}}" for key in vary) \
            + "_s{seed_number}"  # fmt: skip
        made |= {"vary": vary} if vary else {}
        made["seeds"] = self.request.seeds
        made |= self._weights(entry)
        made["safety_factor"] = self.table["factors"][entry["factor"]]
        made["start"] = "rest" if idling else "turning"
        length = BEFORE + AFTER if transient else self.request.time
        made["duration"] = f"{self.request.discard + length:g} s"
        made["wind"], made["sea"] = self._wind(entry, vary, made["duration"]), self._sea(number, entry, vary)
        if SEAS.get(entry["sea"]):
            made["look_up"] = SEAS[entry["sea"]]
        if idling:
            paths = idling_parameters(self.model)
            if not paths:
                raise ModelError(f"DLC {number} is of a turbine that idles, and no part of {self.request.model} has "
                                 "the parameter 'idling', as SafetySystem has.")  # fmt: skip
            made["set"] = dict.fromkeys(paths, 1)
        if events:
            made["events"] = events
        if "event_time" in str((made["wind"], events)):
            self.variables["event_time"] = f"{self.request.discard + BEFORE:g} s"
        return made

    def _entry(self, number: str) -> dict[str, Any]:
        known = dict(self.table["load_cases"])
        for item in self.table["sets"].values():
            known |= item["load_cases"]
        if number in self.table["others"]:
            raise ModelError(f"DLC {number} is not written: {self.table['others'][number]}.")
        if number not in known:
            raise ModelError(f"there is no DLC '{number}'; there are {', '.join(known)}.")
        return known[number]

    def _vary(self, number: str, entry: dict[str, Any]) -> dict[str, Any]:
        vary: dict[str, Any] = {}
        speeds = self._wind_speeds(entry["speeds"])
        if speeds is not None:
            if entry["sea"] in SEAS:
                self._check_speeds(number, SEAS[entry["sea"]], speeds)
            vary["wind_speed"] = speeds
        vary |= entry.get("vary", {})
        self._check_yaw(number, vary.get("yaw_error", []))
        if entry.get("misalignment") and tuple(self.request.misalignment) != (0.0,):
            vary["misalignment"] = [f"{angle:g} deg" for angle in self.request.misalignment]
        return vary

    def _check_yaw(self, number: str, errors: str | list[str]) -> None:
        """Rotors with coefficients know no wind from behind."""
        items = spread(errors, Place("yaw_error")) if isinstance(errors, str) else []
        angles = [abs(float(item.label)) for item in items or ()]
        rotors = rotors_for_front_wind(self.model)
        if rotors and max(angles, default=0.0) >= 90:
            raise ModelError(f"DLC {number} has wind from behind, for which the coefficients of {rotors[0]} do not "
                             "hold; take a model with rotors of blade elements, such as oc3_spar.")  # fmt: skip

    def _wind_speeds(self, word: str) -> str | list[float] | None:
        first, last = self.operating[0], self.operating[-1]
        if word == "extreme":
            return None
        if word == "operating":
            return self.request.wind
        if word == "standing":
            step = self.operating[1] - first if len(self.operating) > 1 else 2.0
            above = np.arange(last + step, 0.7 * iec.REFERENCE_SPEED[self.wind_class] + 1e-9, step)
            below = np.arange(first - step, 0.5 * step, -step)[::-1]
            return [_plain(v) for v in (*below, *above)]
        rated = self.rated
        about = [rated - 2, rated, rated + 2]
        ends = (about[0], about[2], last)
        found = {"rated": about, "faults": ends, "starts": (first, *ends)}[word]
        return [_plain(v) for v in sorted(set(found))]

    @cached_property
    def rated(self) -> float:
        """Rated wind speed [m/s], as asked for or that of the model."""
        if self.request.rated is not None:
            return self.request.rated
        found = rated_wind_speed(self.model)
        if found is None:
            raise ModelError("the rated wind speed does not follow from the model; give it: --rated 11.4")
        return round(found, 1)

    def _check_speeds(self, number: str, name: str, speeds: str | list[float]) -> None:
        table = self.site.seas.get(name)
        if table is None:
            raise site_error(self.site, f"'{name}'", number)
        numbers = _speeds(speeds) if isinstance(speeds, str) else speeds
        low, high = float(table.at_values[0]), float(table.at_values[-1])
        outside = [v for v in numbers if not low <= v <= high]
        if outside:
            raise ModelError(f"DLC {number} runs at {outside[0]:g} m/s, and '{name}' of the site '{self.site.name}' "
                             f"goes from {low:g} to {high:g} m/s.")  # fmt: skip
        columns = {"wind_speed": table.at_values, **{key: table.values[key] for key in table.columns}}
        self.tables[name] = {key: [_plain(value) for value in values] for key, values in columns.items()}

    def _wind(self, entry: dict[str, Any], vary: dict[str, Any], duration: str) -> dict[str, Any]:
        name = entry["wind"]
        field = self.in_fields and name in self.table["fields"]
        wind = dict(self.table["fields" if field else "winds"][name])
        kind = Wind.family.kinds[wind["kind"]]
        known = [key for key in kind.parameters if key not in kind.void]
        classes = {"turbulence_class": self.turbulence_class, "wind_class": self.wind_class}
        if field:
            wind["repetition_period"] = duration
            if "mean_speed" not in wind:
                reference, years = iec.REFERENCE_SPEED[self.wind_class], int(name.removeprefix("ewm_"))
                wind["mean_speed"] = _plain(iec.extreme_speed(reference, years, turbulent=True))
            if "turbulence_intensity" in wind:
                classes = {}
            elif wind.get("turbulence_model") != "etm":
                del classes["wind_class"]
        wind |= {key: value for key, value in classes.items() if key in known}
        return wind | ({"direction": "yaw_error"} if "yaw_error" in vary else {})

    @cached_property
    def in_fields(self) -> bool:
        """Whether the rotors of the model need fields of turbulence."""
        return has_blade_elements(self.model)

    def _sea(self, number: str, entry: dict[str, Any], vary: dict[str, Any]) -> dict[str, Any]:
        height: Any = "Hs"
        period: Any = "Tp"
        if entry["sea"] not in SEAS:
            years = entry["sea"].removeprefix("extreme_")
            if years not in self.site.extreme:
                raise site_error(self.site, f"'extreme_sea' of {years} years", number)
            height, period = self.site.extreme[years]
        turned = [name for name in ("yaw_error", "misalignment") if name in vary]
        return {
            "spectrum": "jonswap", "significant_wave_height": height, "peak_period": period, "seed": "wave_seed",
            "heading": " + ".join(turned) or 0,
        }  # fmt: skip

    def _weights(self, entry: dict[str, Any]) -> dict[str, Any]:
        """The share of the lifetime, where a set goes through the wind speeds of one; else none."""
        if entry["wind"] == "ntm" and entry["factor"] in "EF" and not entry.get("transient"):
            scale, shape = self.site.weibull
            width = self.operating[1] - self.operating[0] if len(self.operating) > 1 else 2.0
            return {"weights": {"weibull": {"scale": scale, "shape": shape}, "width": _plain(width)}}
        return {"weight": 0}

    def _events(self, number: str, entry: dict[str, Any]) -> tuple[list[dict[str, Any]], dict[str, Any]]:
        events: list[dict[str, Any]] = []
        vary: dict[str, Any] = {}
        for item in entry.get("events", ()):
            part = item.get("part", "")
            paths = [path for path in event_paths(self.model, item["name"]) if not part or part in path.split(".")]
            if not paths:
                of = f" of a part '{part}'" if part else ""
                raise ModelError(f"DLC {number} needs the event '{item['name']}'{of}, which no part of "
                                 f"{self.request.model} offers.")  # fmt: skip
            chosen = paths
            if item.get("of") == "first":
                chosen = paths[:1]
            elif item.get("of") == "each":
                vary["part"] = [path.removesuffix(f".{item['name']}") for path in paths]
                chosen = [f"{{part}}.{item['name']}"]
            events += [{"event": path, "at": item["at"]} for path in chosen]
        return events, vary


def _speeds(text: str) -> list[float]:
    """The wind speeds of a range, or of a list `8,12`."""
    place = Place("wind")
    items = spread(text, place)
    try:
        speeds = [float(item.written) for item in items] if items else [float(word) for word in text.split(",")]
    except ValueError:
        raise ParameterError(f"wind: '{text}' is not first:last:step in m/s, such as 4:24:2.") from None
    if min(speeds) <= 0 or sorted(set(speeds)) != speeds:
        raise ParameterError(f"wind: the speeds '{text}' must rise from above zero.")
    return speeds


def _plain(value: float) -> int | float:
    value = round(float(value), 6)
    return int(value) if value.is_integer() else value


def _short(name: str) -> str:
    return {"wind_speed": "u", "yaw_error": "yaw", "misalignment": "mis", "part": "", "plane": ""}.get(name, name)
