"""What the registry keeps of the results of one case, as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fowtlib.analysis.case_statistics import case_statistics
from fowtlib.analysis.fatigue import equivalent_loads
from fowtlib.analysis.fatigue.loads import is_load
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.solving.results import Result

FEWEST_POINTS = 3


def statistics_of(result: Result) -> tuple[dict[str, dict[str, Any]], dict[str, Any]]:
    """Statistics by output, and what concerns several of them: see `case_statistics`, whose "channels" they are.

    The second also holds "equivalent_loads": of each force, moment and stress by exponent, at 1 Hz; and under
    "refused", by output, why something could not be computed.
    """
    if result.time.size < FEWEST_POINTS:
        points = "statistics take 3 points of time or more"
        return {}, {"points": int(result.time.size), "refused": dict.fromkeys(result.names, points)}
    rest = case_statistics(result)
    channels = rest.pop("channels")
    rest["equivalent_loads"] = {}
    for name in channels:
        try:
            found = equivalent_loads(result, names=[name]) if is_load(channels[name]["unit"]) else {}
        except ModelError as error:
            rest["refused"][name] = str(error)
            continue
        rest["equivalent_loads"] |= {
            key: {f"{exponent:g}": load for exponent, load in loads.items()} for key, loads in found.items()
        }
    return channels, rest

