"""Derivatives of smooth Python functions of one number: central differences with Richardson's extrapolation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fowtlib.language.errors import SimulationError

STEP = 1e-3  # of the size of the value; the error is of the fourth power of it
SHORT = 3e-5  # the same of two values alone; of the second power
SMOOTH = 0.05  # change of a difference with half the step, or from one side to the other, from which on there is a kink
ROUNDING = 1e-12  # of the size of the values: what is no difference


def derivative(function: Callable[[float], np.ndarray], value: float, *, here: np.ndarray | None = None,
               low: float | None = None, high: float | None = None, size: float | None = None,
               quick: bool = False, what: str = "the function") -> np.ndarray:  # fmt: skip
    """Slope of an array by a number, with an error of about 1e-12 of something smooth.

    quick: of two values in place of four, with an error of about 1e-9. here: the array at the value, where it is
    known. low, high: bounds that the argument must not pass; at one of them the derivative is taken from the other
    side, to about 1e-9. size: of the value, for the step; None: its own, or 1 where it is zero. what: for the message.
    Raises SimulationError where the function has a kink or a jump there.
    """
    step = (SHORT if quick else STEP) * (size or abs(value) or 1.0)
    below, above = low is None or value - step >= low, high is None or value + step <= high
    here = np.asarray(function(value) if here is None else here, dtype=float)
    if below and above and quick:
        at = [np.asarray(function(value + shift * step), dtype=float) for shift in (1.0, -1.0)]
        found = coarse = fine = (at[0] - at[1]) / (2 * step)
        bent = (at[0] - 2 * here + at[1]) / step  # of the second order, or a kink
    elif below and above:
        at = [np.asarray(function(value + shift * step), dtype=float) for shift in (1.0, -1.0, 0.5, -0.5)]
        coarse, fine = (at[0] - at[1]) / (2 * step), (at[2] - at[3]) / step
        found = (4 * fine - coarse) / 3
        bent = (4 * (at[2] - 2 * here + at[3]) - (at[0] - 2 * here + at[1])) / step  # of the fourth order, or a kink
    else:
        step = STEP / SHORT * step if quick else step
        step = step if above else -step
        at = [np.asarray(function(value + step / part), dtype=float) for part in (1.0, 2.0, 4.0)]
        first, coarse, fine = ((item - here) / (step / part) for item, part in zip(at, (1.0, 2.0, 4.0), strict=True))
        found, bent = (4 * (2 * fine - coarse) - (2 * coarse - first)) / 3, np.zeros_like(here)
    largest = max(float(np.max(np.abs(item), initial=0.0)) for item in (here, *at))
    limit = SMOOTH * np.max(np.abs(found), initial=0.0) + ROUNDING * largest / abs(step)
    if np.any(np.abs(fine - coarse) > limit) or np.any(np.abs(bent) > limit):
        raise SimulationError(
            f"{what} has a kink or a jump at {value:g}, and no derivative there. Take another value, beside it."
        )
    return found
