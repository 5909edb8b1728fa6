"""How a run is made: as it is asked for, else as the model file says, else by default."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from fowtlib.language.errors import ParameterError
from fowtlib.language.units import to_si

OUTPUT_STEP = 0.1  # s, where neither a run nor its model says another one
MOST_POINTS = 2e7  # output points of one run


class Settings(dict[str, Any]):
    """`simulation` of a model file, SI; `places` says where in the file each stands.

    A file is read whatever a run of it will ask for. What its settings make together is judged after what the run
    overrides, by the run and by a check of the model.
    """

    def __init__(self, values: Mapping[str, Any] | None = None, places: Mapping[str, str] | None = None):
        super().__init__(values or {})
        self.places = dict(places or {})


def place_of(settings: Mapping[str, Any], *keys: str) -> str:
    """Where the first of these settings that a model file gives stands in it; "" for one that no file gives."""
    places = settings.places if isinstance(settings, Settings) else {}
    return next((places[key] for key in keys if key in settings and key in places), "")


def without(settings: Mapping[str, Any], key: str) -> Settings:
    """The same settings but one."""
    places = settings.places if isinstance(settings, Settings) else {}
    return Settings({name: value for name, value in settings.items() if name != key}, places)


def duration_settings(
    t_end: Any, output_step: Any, tolerance: Any, settings: Mapping[str, Any]
) -> tuple[float, float, float]:
    """The end [s], the output step [s] and the tolerance of a run: as given, else the model's, else the defaults."""
    given = {"duration": t_end, "output_step": output_step, "tolerance": tolerance}
    end, interval, relative = (
        float(to_si(settings.get(key, default) if given[key] is None else given[key], unit, key))
        for key, default, unit in (
            ("duration", 600.0, "s"), ("output_step", OUTPUT_STEP, "s"), ("tolerance", 1e-6, "1"),
        )
    )

    def error(message: str, *keys: str) -> ParameterError:
        return ParameterError(message).at(place_of(settings, *(key for key in keys if given[key] is None)))

    for key, seconds in (("duration", end), ("output_step", interval)):
        if not 0 < seconds < math.inf:
            what = key.replace("_", " ")
            raise error(f"the {what} is {seconds:g} s; it must be a finite number above zero.", key)
    if end / interval > MOST_POINTS:
        raise error(
            f"{end:g} s with an output step of {interval:g} s are {end / interval:.3g} output points, and the limit is "
            f"{MOST_POINTS:g}; give a longer output step, or run it in pieces that go on from each other.",
            "output_step", "duration",
        )  # fmt: skip
    if not 0 < relative < 1:
        raise error(
            f"the tolerance is {relative:g}; it must lie between 0 and 1, usually 1e-4 to 1e-9.", "tolerance"
        )
    return end, interval, relative
