"""Limits of standards on a model and on results of runs, against fowtlib.design.rules.standards."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fowtlib.analysis.plants import MOTIONS, compiled
from fowtlib.design.rules.standards import PERIOD, SPAR_AT_REST, SPAR_PERIODS, Limit, Verdict, check_limits
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.units import to_si
from fowtlib.solving import natural_modes


def rigid_periods(model: Any, state: Any = None) -> dict[str, float]:
    """Natural periods [s] of the motions of a floater, undamped or not as the model is, by the name of the motion.

    model: compiled or not; wind and waves are taken from one that is not. A motion is that of the slowest mode that has
    its name; motions without a mode that oscillates are left out. Raises ModelError for a model without any.
    """
    plant, found = compiled(model), dict[str, float]()
    for mode in natural_modes(plant, state):
        for motion in MOTIONS:
            if mode.motion and mode.oscillates and mode.name.split()[-1] == motion:
                found.setdefault(motion, float(mode.period))
    if not found:
        raise ModelError(f"'{plant.title}' has no natural mode of {', '.join(MOTIONS)}; limits on them need a floater.")
    return {motion: found[motion] for motion in MOTIONS if motion in found}


def check_model(model: Any, limits: Sequence[Limit] = SPAR_PERIODS, state: Any = None) -> tuple[Verdict, ...]:
    """Verdicts on the natural periods of a model, on all those that the limits are for."""
    periods, known = rigid_periods(model, state), {limit.quantity: limit for limit in limits}
    return tuple(known[PERIOD + m].of(value) for m, value in periods.items() if PERIOD + m in known)


def check_result(
    result: Any, of: Mapping[str, str], limits: Sequence[Limit] = SPAR_AT_REST, *, discard: float = 0.0
) -> tuple[Verdict, ...]:
    """Verdicts on series of a run: {"heel": "pitch", "nacelle acceleration": "nacelle_acceleration"}.

    Of a limit from above it is the largest size of the series that counts, of one from below the least value; discard:
    seconds left out at the beginning. Raises ModelError for a quantity that no limit is for, a series that the result
    lacks, or a unit that is of something else.
    """
    known, values = {limit.quantity: limit for limit in limits}, {}
    kept = result.time >= result.time[0] + discard - 1e-9
    if not kept.any():
        raise ModelError(f"discarding {discard:g} s leaves nothing of the result.")
    for quantity, name in of.items():
        if quantity not in known:
            raise ModelError(f"there is no limit on '{quantity}'{did_you_mean(quantity, known)}")
        series = np.asarray(result.array(name), dtype=float)[kept]
        unit, limit = result.unit(name), known[quantity]
        found = float(np.abs(series).max() if limit.upper < math.inf else series.min())
        values[quantity] = float(to_si(f"{found!r} {unit}" if unit != "1" else found, limit.unit, name))
    return check_limits(values, limits)
