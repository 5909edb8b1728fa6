"""Short functions of time for the sea and the wind, as expressions of the equation kernel."""

from __future__ import annotations

from typing import Any

from fowtlib.language import assert_
from fowtlib.language import math as m


def progress(time: Any, start: Any, duration: Any) -> Any:
    """0 before `start`, 1 after `start` + `duration`, a straight line between (all in s)."""
    return m.fmin(m.fmax((time - start) / duration, 0), 1)


def smooth_step(s: Any) -> Any:
    """10 s^3 - 15 s^4 + 6 s^5: from 0 to 1 for s in [0, 1], twice continuously differentiable with `progress`."""
    return s**3 * (10 + s * (6 * s - 15))


def extreme_gust(s: Any) -> Any:
    """-0.37 sin(3 pi s) (1 - cos(2 pi s)) for s in [0, 1]: dip, peak and dip of IEC 61400-1 ed. 3, (18); peak 0.74.

    Twice continuously differentiable with `progress`.
    """
    return -0.37 * m.sin(3 * m.pi * s) * (1 - m.cos(2 * m.pi * s))


def cosine_gust(s: Any) -> Any:
    """(1 - cos(2 pi s)) / 2 for s in [0, 1]: one hump of height 1; its second derivative jumps at both ends."""
    return 0.5 * (1 - m.cos(2 * m.pi * s))


def warn_of_repetition(time: Any, period: float, what: str) -> Any:
    """A warning, once, when a run is longer than the period [s] after which the waves or the wind repeat themselves."""
    message = f"the {what} repeats itself after {period:g} s; set repetition_period to the duration of the run."
    return assert_(time < period * (1 + 1e-9), message, level="warning")
