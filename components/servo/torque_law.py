"""Generator torque of a variable-speed turbine over the speed of its generator, in NumPy or in equations.

Regions of J. Jonkman et al., NREL/TP-500-38060 (2009), section 7.2: no torque (1), a ramp (1.5), K speed^2, which holds
the best tip speed ratio (2), the slope of an induction machine with a slip (2.5), and rated torque or rated power (3).
The corners between them are rounded; away from a corner, by ROUNDING of the rated torque, the law is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

ROUNDING = 0.01
"""Width of the rounded corners of the torque law, as a share of the rated torque."""


@dataclass(frozen=True)
class TorqueLaw:
    """Speeds [rad/s] and torque [N m] of the generator. The defaults are those of the NREL 5 MW turbine."""

    cut_in_speed: float = 670 * np.pi / 30
    region_2_speed: float = 871 * np.pi / 30
    region_3_speed: float = 1161.963 * np.pi / 30
    rated_speed: float = 1173.7 * np.pi / 30
    rated_torque: float = 43093.55
    region_2_constant: float = 0.0255764 * (30 / np.pi) ** 2
    slip: float = 0.1
    region_3: str = "constant_torque"


def larger(a: Any, b: Any, width: Any, xp: Any = np) -> Any:
    """max(a, b), with its corner rounded where |a - b| < width, twice continuously differentiable; exact elsewhere."""
    near = xp.fmin(xp.fmax((a - b) / width, -1), 1)
    return xp.fmax(a, b) + width * (3 + 6 * near**2 - near**4 - 8 * xp.fmax(near, -near)) / 16


def smaller(a: Any, b: Any, width: Any, xp: Any = np) -> Any:
    """min(a, b), rounded as in `larger`."""
    return -larger(-a, -b, width, xp)


def region_3_torque(speed: Any, law: Any, xp: Any = np) -> Any:
    """Torque [N m] of region 3; that of constant power holds its value below the start of region 2."""
    if law.region_3 == "constant_torque":
        return law.rated_torque + 0 * speed
    return law.rated_torque * law.rated_speed / xp.fmax(speed, law.region_2_speed)


def torque_of(speed: Any, law: Any, xp: Any = np) -> Any:
    """Torque [N m] at a generator speed [rad/s]; `law` has the attributes of TorqueLaw, `xp` is the mathematics."""
    width = ROUNDING * law.rated_torque
    ramp = _slope_1_5(law) * (speed - law.cut_in_speed)
    below = larger(smaller(ramp, law.region_2_constant * speed**2, width, xp), 0, width, xp)
    slip_line = _slope_2_5(law, xp) * (speed - law.region_3_speed / (1 + law.slip))
    return smaller(larger(below, slip_line, width, xp), region_3_torque(speed, law, xp), width, xp)


def region_2_end(law: Any) -> float:
    """Generator speed [rad/s] at which K speed^2 meets the slip line: the start of region 2.5."""
    slope, K = _slope_2_5(law, np), law.region_2_constant
    synchronous = law.region_3_speed / (1 + law.slip)
    return float((slope - np.sqrt(slope * (slope - 4 * K * synchronous))) / (2 * K))


def _slope_1_5(law: Any) -> Any:
    return law.region_2_constant * law.region_2_speed**2 / (law.region_2_speed - law.cut_in_speed)


def _slope_2_5(law: Any, xp: Any) -> Any:
    synchronous = law.region_3_speed / (1 + law.slip)
    return region_3_torque(law.region_3_speed, law, xp) / (law.region_3_speed - synchronous)
