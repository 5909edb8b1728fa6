"""Limits of standards on a model: its natural periods, against fowtlib.design.rules.standards."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fowtlib.analysis.plants import MOTIONS, compiled
from fowtlib.design.rules.standards import PERIOD, SPAR_PERIODS, Limit, Verdict
from fowtlib.language.errors import ModelError
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
