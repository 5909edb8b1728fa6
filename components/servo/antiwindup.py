"""One rule by which the integrals of controllers stay within their limits."""

from __future__ import annotations

from fowtlib.components.servo.torque_law import smaller
from fowtlib.language import math as m


def held_within(rate, value, lowest, highest, band):
    """The rate of an integral that fades out within a band of a limit, and only towards that limit.

    Outside of the limits it turns round, at most to its negative, so that a value which got there comes back. So the
    integral rests at the limit, and leaves it as soon as what it integrates changes its sign.
    """
    room = m.if_else(rate > 0, highest - value, value - lowest) / band
    return rate * m.fmax(smaller(room, 1, 0.2, m), -1)
