"""The largest tension of a line that moves in one degree of freedom, from deviations: numbers, arrays, expressions."""

from __future__ import annotations

from math import pi
from typing import Any


def harmonic_extreme(
    sizes: Any, tension_std: Any, velocity_std: Any, omega: Any, *, elastic_stiffness: Any, geometric_stiffness: Any,
    mass: Any, drag: Any, axial_mass: Any = 0.0,
) -> Any:  # fmt: skip
    """Tension above the mean [N] in a motion of `sizes` deviations, sqrt(2 ln(N / ln 2)) for the median of N maxima.

    u (k_E + k_G - m w^2 + i w c_L) = k_E x, T = (k_G - m w^2 + i w c_L) u - w^2 m_a x; c_L is sqrt(8/pi) c s_u' in the
    response, whose deviations are given, and 8/(3 pi) c U in the largest motion. What the response has of tension
    beyond that is slow, and grows as a Gaussian. tension_std [N]; velocity_std s_u' [m/s] and omega [rad/s] of the
    velocity of the shape; stiffnesses k_E, k_G [N/m], masses m, m_a [kg], drag c [kg/m] of the line at its mean.
    Of expressions derivatives are exact; a kink where the tension of the response has no slow part.
    """
    held = elastic_stiffness + geometric_stiffness - mass * omega**2

    def squares(damping: Any) -> tuple[Any, Any]:
        """Squares of the velocity of the shape and of the tension, over that of the motion along the line."""
        below, lost = held**2 + (omega * damping) ** 2, omega**2 * axial_mass
        real = elastic_stiffness * (1 - elastic_stiffness * held / below) - lost  # T = k_E (x - u) - w^2 m_a x
        return (omega * elastic_stiffness) ** 2 / below, real**2 + (elastic_stiffness**2 * omega * damping / below) ** 2

    faster, tension = squares((8 / pi) ** 0.5 * drag * velocity_std)
    x = velocity_std**2 / faster  # variance of the motion
    moving, whole = tension * x, tension_std**2
    fast = (moving + whole - abs(moving - whole)) / 2
    # U^2 (held^2/w^2 + (8/(3 pi) c U)^2) = (k_E sizes x)^2, of the amplitude U of u'
    push, own, resisting = elastic_stiffness**2 * sizes**2 * x, (held / omega) ** 2, (8 / (3 * pi) * drag) ** 2
    U = (2 * push / (own + (own**2 + 4 * resisting * push) ** 0.5)) ** 0.5
    growth = squares(8 / (3 * pi) * drag * U)[1] / tension
    return sizes * (whole - fast + fast * growth) ** 0.5
