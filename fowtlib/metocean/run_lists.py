"""From states to runs: plain data that cases are made from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.states import COLUMNS, States


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

    states: wind speeds are those at the hub. seeds: runs of each state; no two seeds of the list, of wind or sea, are
    the same. name: cases are name_0001_s1, ... . weight: the probability of the state over its seeds, or 1 on a
    contour. parameters: further ones of every run. cut_out [m/s]: above it the mapping above_cut_out is laid over the
    case, such as {"parameters": {...}} or {"start": ...} for a turbine that stands. settings: further keys of a case
    (duration, discard, output_step, step, ...).
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
        labels: dict[str, Any] = {"state": index, **dict(zip(COLUMNS, (u, h, t), strict=True))}
        wind: dict[str, Any] = {"wind.kind": wind_kind, "wind.mean_speed": u}
        if states.turbulence_intensity is not None:
            intensity = float(states.turbulence_intensity[index])
            labels["turbulence_intensity"] = wind["wind.turbulence_intensity"] = intensity
        weight = 1.0 if states.probability is None else float(states.probability[index]) / seeds
        if states.probability is not None:
            labels["probability"] = float(states.probability[index])
        sea = {"sea.spectrum": "jonswap", "sea.significant_wave_height": h, "sea.peak_period": t}
        for number in range(1, seeds + 1):
            run = index * seeds + number - 1
            seed = first_seed + 2 * run
            case = {
                "name": f"{name}_{index + 1:0{digits}d}_s{number}",
                "model": model,
                "parameters": {**wind, "wind.seed": seed, **sea, "sea.seed": seed + 1, **(parameters or {})},
                "labels": {**labels, "seed": number},
                "weight": weight,
                **({"group": group} if group else {}),
                **settings,
            }
            if cut_out is not None and _above(u, cut_out):
                case = _laid_over(case, above_cut_out or {})
            cases.append(case)
    return cases


def _above(wind_speed: Any, cut_out: float) -> Any:
    """Whether the wind is stronger; the end of a contour at the cut-out speed is not, but for its last digits."""
    return wind_speed > cut_out * (1 + 1e-9)


def _laid_over(case: dict[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    both = {key: {**case[key], **value} for key, value in change.items() if isinstance(value, Mapping) and key in case}
    return {**case, **change, **both}


def cases_file(
    states: States,
    model: str,
    *,
    title: str = "",
    group: str = "",
    seeds: int = 1,
    duration: float = 4000.0,
    discard: float = 400.0,
    cut_out: float | None = None,
) -> str:
    """The same list as the text of a cases file, for `fowt batch run`; states above the cut-out speed are a set apart.

    The weight of a case is the probability of its state over the number of seeds.
    """
    import yaml

    sets = []
    parts = [(group, np.ones(len(states), dtype=bool))]
    if cut_out is not None:
        above = _above(states.wind_speed, cut_out)
        parts = [(group, ~above), (f"{group} above cut-out".strip(), above)]
    for name, some in parts:
        if not some.any():
            continue
        chosen = states[some]
        rows = {"wind_speed": chosen.wind_speed, "Hs": chosen.wave_height, "Tp": chosen.peak_period}
        item: dict[str, Any] = {"group": name} if name else {}
        if chosen.probability is not None:
            rows["probability"] = chosen.probability
            item["weight"] = f"probability / {seeds}" if seeds > 1 else "probability"
        if chosen.turbulence_intensity is not None:
            rows["turbulence_intensity"] = chosen.turbulence_intensity
        vary = {key: [float(f"{value:.7g}") for value in values] for key, values in rows.items()}
        sets.append({**item, "vary": {"zip": vary}})
    wind = {"kind": "kaimal", "mean_speed": "wind_speed", "seed": "seed"}
    if states.turbulence_intensity is not None:
        wind["turbulence_intensity"] = "turbulence_intensity"
    sea = {"spectrum": "jonswap", "significant_wave_height": "Hs", "peak_period": "Tp", "seed": "wave_seed"}
    top = {
        "fowtlib_cases": 1,
        **({"title": title} if title else {}),
        "model": model,
        "defaults": {
            "duration": f"{duration:g} s",
            "discard": f"{discard:g} s",
            "seeds": seeds,
            "wind": wind,
            "sea": sea,
            "steep_sea": "allow",
        },
        "sets": sets,
    }
    return yaml.safe_dump(top, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True)
