"""From states to runs: plain data that cases are made from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.states import States


def states_to_cases(
    states: States,
    model: str,
    *,
    seeds: int = 1,
    first_seed: int = 1,
    name: str = "state",
    group: str = "",
    parameters: Mapping[str, Any] | None = None,
    wind_kind: str = "kaimal",
    cut_out: float | None = None,
    above_cut_out: Mapping[str, Any] | None = None,
    **settings: Any,
) -> list[dict[str, Any]]:
    """One dict a run, in the form that `fowtlib.cases.Case.from_plain` takes; what JSON can hold.

    states: wind speeds are those at the hub. seeds: runs of each state; wind and sea of a run have the same seed, and
    no two runs of the list share one. name: cases are name_0001_s1, ... . weight: the probability of the state over its
    seeds, or 1 on a contour. parameters: further ones of every run. cut_out [m/s]: above it the mapping above_cut_out
    is laid over the case, such as {"parameters": {...}} or {"start": ...} for a turbine that stands. settings: further
    keys of a case (duration, discard, output_step, step, ...).
    """
    if seeds < 1:
        raise ParameterError(f"each state is run with one seed or more, not {seeds}.")
    if (cut_out is None) != (above_cut_out is None):
        raise ParameterError(
            "give cut_out and above_cut_out together: what a case becomes above the cut-out wind speed."
        )
    digits = max(4, len(str(len(states))))
    cases = []
    for index, (u, h, t) in enumerate(states):
        labels: dict[str, Any] = {"state": index, "wind_speed": u, "wave_height": h, "peak_period": t}
        wind: dict[str, Any] = {"wind.kind": wind_kind, "wind.mean_speed": u}
        if states.turbulence_intensity is not None:
            intensity = float(states.turbulence_intensity[index])
            labels["turbulence_intensity"] = wind["wind.turbulence_intensity"] = intensity
        weight = 1.0 if states.probability is None else float(states.probability[index]) / seeds
        if states.probability is not None:
            labels["probability"] = float(states.probability[index])
        sea = {"sea.spectrum": "jonswap", "sea.significant_wave_height": h, "sea.peak_period": t}
        for number in range(1, seeds + 1):
            seed = first_seed + index * seeds + number - 1
            case = {
                "name": f"{name}_{index + 1:0{digits}d}_s{number}",
                "model": model,
                "parameters": {**wind, "wind.seed": seed, **sea, "sea.seed": seed, **(parameters or {})},
                "labels": {**labels, "seed": seed},
                "weight": weight,
                **({"group": group} if group else {}),
                **settings,
            }
            if cut_out is not None and u > cut_out:
                case = _laid_over(case, above_cut_out or {})
            cases.append(case)
    return cases


def _laid_over(case: dict[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    both = {key: {**case[key], **value} for key, value in change.items() if isinstance(value, Mapping) and key in case}
    return {**case, **change, **both}
