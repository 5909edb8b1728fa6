"""Generator torque of a variable-speed turbine over the speed of its generator, in NumPy or in equations.

Regions of J. Jonkman et al., NREL/TP-500-38060 (2009), section 7.2: no torque (1), a ramp (1.5), K speed^2, which holds
the best tip speed ratio (2), the slope of an induction machine with a slip (2.5), and rated torque or rated power (3).
The corners between them are rounded; away from a corner, by ROUNDING of the rated torque, the law is exact.

A band of speeds in region 2 may be left out, as where a multiple of the speed is a frequency of the tower: `exclusion`
adds torque at its lower edge and takes it off at its upper one. In between the torque falls with the speed, faster
than that of the rotor does, so that no speed there is steady: the rotor waits at an edge, until the wind takes it over
to the other. The idea of the band: E. Bossanyi, Wind Energy 3 (2000) 149-163; this curve is our own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language import Component

ROUNDING = 0.01
"""Width of the rounded corners of the torque law, as a share of the rated torque."""
EDGE = 0.25
"""Share of the half width of an excluded band that its edge takes, in which the torque rises."""
FIRM = 2.0
"""Fall of the torque over the band, over the least one at which no speed within is steady."""


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
    excluded_speed: float | None = None
    excluded_range: float | None = None


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
    lawful = smaller(larger(below, slip_line, width, xp), region_3_torque(speed, law, xp), width, xp)
    return lawful + exclusion(speed, law, xp) if excludes(law) else lawful


def excludes(law: Any) -> bool:
    """Whether the law, or the component that has its parameters, leaves out a band of speeds."""
    value = law.parameter_value if isinstance(law, Component) else lambda name: getattr(law, name)
    return value("excluded_speed") is not None


def exclusion(speed: Any, law: Any, xp: Any = np) -> Any:
    """What an excluded band adds to the torque [N m]: above zero in its lower half, below zero in its upper half.

    At the middle c of the band the torque of the rotor in a wind whose best speed that is falls with the speed by K c,
    and that of region 2 rises by 2 K c; what falls faster than by 3 K c has no steady speed.
    """
    place = (speed - law.excluded_speed) / law.excluded_range
    height = FIRM * 3 * law.region_2_constant * law.excluded_speed * law.excluded_range * (1 - EDGE)

    def below(way: Any) -> Any:
        return xp.fmax(xp.fmin((1 - way) / EDGE, way / (1 - EDGE)), 0)

    return height * (below(-place) - below(place))


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
