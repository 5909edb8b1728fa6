"""What the registry keeps of the results of one case, as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.solving.results import Result


def statistics_of(result: Result) -> dict[str, Any]:
    """See fowtlib.analysis.case_statistics; of fewer than three points there are none.

    With "equivalent_loads": of each force, moment and stress by exponent, at 1 Hz.
    """
    from fowtlib.analysis import case_statistics, equivalent_loads
    from fowtlib.analysis.fatigue.loads import is_load

    if result.time.size < 3:
        return {}
    told = case_statistics(result)
    told["equivalent_loads"] = loads = {}
    for name, channel in told["channels"].items():
        if is_load(channel["unit"]):
            try:
                found = equivalent_loads(result, names=[name])[name]
            except ModelError as error:
                told["refused"][f"equivalent load of {name}"] = str(error)
            else:
                loads[name] = {f"{exponent:g}": load for exponent, load in found.items()}
    return told
