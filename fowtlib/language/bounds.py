"""What is said of numbers that leave the bounds of their parameter, and of angles that look like degrees."""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np

from fowtlib.language.errors import UnitError

POSITIVE = sys.float_info.min
"""As the `min` of a parameter: it is above zero."""
FULL_TURN = 2 * math.pi
"""An angle [rad] beyond it, given as a number without a unit, was meant in degrees, most likely."""


def shown(number: float, unit: str) -> str:
    """A number with its unit, if it has one."""
    return f"{number:g}" if unit == "1" else f"{number:g} {unit}"


def lower(bound: float, unit: str) -> str:
    """What a number is that lies below a lower bound: "below its minimum 3 m"."""
    return f"not above {shown(0, unit)}" if bound == POSITIVE else f"below its minimum {shown(bound, unit)}"


def upper(bound: float, unit: str) -> str:
    """What a number is that lies above an upper bound."""
    return f"above its maximum {shown(bound, unit)}"


def outside(numbers: Any, low: float | None, high: float | None, unit: str) -> tuple[float, str] | None:
    """The number that leaves its bounds most, and what it is: "below its minimum 0 m"; None where all are inside.

    Of an angle a hint is added where the number would be inside as degrees.
    """
    values = np.asarray(numbers, dtype=float)
    if low is not None and np.any(values < low):
        worst, said = float(values.min()), lower(low, unit)
    elif high is not None and np.any(values > high):
        worst, said = float(values.max()), upper(high, unit)
    else:
        return None
    return worst, said + degrees_hint(worst, low, high, unit)


def degrees_hint(number: float, low: float | None, high: float | None, unit: str) -> str:
    """`; did you mean '35 deg'?` where an angle leaves its bounds and would not as degrees, else nothing."""
    turned = math.radians(number)
    fits = (low is None or turned >= low) and (high is None or turned <= high)
    return f"; did you mean '{number:g} deg'?" if unit == "rad" and fits and abs(number) >= 1 else ""


def refuse_turns(number: float, unit: str) -> None:
    """UnitError for an angle that is more than a full turn, and was given without a unit."""
    if unit == "rad" and math.isfinite(number) and abs(number) > FULL_TURN:
        raise UnitError(
            f"got {number:g} without a unit, and angles are in rad: that is more than a full turn; write "
            f"'{number:g} deg', or '{number:g} rad' if it is meant."
        )
