"""Derivatives of smooth Python functions of one number: central differences with Richardson's extrapolation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fowtlib.language.errors import SimulationError

STEP = 1e-3  # of the size of the value; the error is of the fourth power of it
SMOOTH = 0.05  # relative change of a difference with half the step, from which on the function has a kink or a jump
ROUNDING = 1e-13  # of the size of the values: what is no difference


def derivative(function: Callable[[float], np.ndarray], value: float, *, low: float | None = None,
               high: float | None = None, size: float | None = None,
               what: str = "the function") -> np.ndarray:  # fmt: skip
    """Slope of an array, with an error of about 1e-12 of something smooth.

    low, high: bounds that the argument must not pass; at one of them the derivative is taken from the other side, to
    about 1e-9. size: of the value, for the step; None: its own, or 1 where it is zero. what: for the message.
    Raises SimulationError where the function has a kink or a jump there.
    """
    step = STEP * (size or abs(value) or 1.0)
    below, above = low is None or value - step >= low, high is None or value + step <= high
    if below and above:
        at = [np.asarray(function(value + shift * step), dtype=float) for shift in (1.0, -1.0, 0.5, -0.5)]
        coarse, fine = (at[0] - at[1]) / (2 * step), (at[2] - at[3]) / step
        found = (4 * fine - coarse) / 3
    else:
        step = step if above else -step
        here = np.asarray(function(value), dtype=float)
        at = [np.asarray(function(value + step / part), dtype=float) for part in (1.0, 2.0, 4.0)]
        first, coarse, fine = ((item - here) / (step / part) for item, part in zip(at, (1.0, 2.0, 4.0), strict=True))
        found = (4 * (2 * fine - coarse) - (2 * coarse - first)) / 3
    largest = max(float(np.max(np.abs(item), initial=0.0)) for item in at)
    noise = ROUNDING * largest / abs(step)
    if np.any(np.abs(fine - coarse) > SMOOTH * np.max(np.abs(found), initial=0.0) + noise):
        raise SimulationError(
            f"{what} has a kink or a jump at {value:g}, and no derivative there. Take another value, beside it."
        )
    return found
