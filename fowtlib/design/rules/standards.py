"""Limits of standards and guidelines for floating turbines, and what keeps them and what does not.

A limit has a name, bounds and a source; a verdict is a value against it, with a sentence. Values are numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fowtlib.language.errors import ModelError, did_you_mean

PERIOD = "period of "


@dataclass(frozen=True)
class Limit:
    """What a quantity must keep: at least `lower`, at most `upper`, in `unit`; both ends are allowed."""

    quantity: str
    lower: float
    upper: float
    unit: str
    source: str

    def of(self, value: float) -> Verdict:
        """A value against it; ModelError for what is not a number."""
        value = float(value)
        if math.isnan(value):
            raise ModelError(f"{self.quantity} is not a number, so that no limit can be said to hold for it.")
        return Verdict(self, value)

    @property
    def text(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.upper == math.inf:
            return f"at least {self.lower:g}{unit}"
        return f"at most {self.upper:g}{unit}" if self.lower == -math.inf else f"{self.lower:g} to {self.upper:g}{unit}"


@dataclass(frozen=True)
class Verdict:
    """A value against a limit."""

    limit: Limit
    value: float

    @property
    def kept(self) -> bool:
        return self.limit.lower <= self.value <= self.limit.upper

    @property
    def sentence(self) -> str:
        unit = "" if self.limit.unit == "1" else f" {self.limit.unit}"
        asked = f"{self.limit.text} is asked for ({self.limit.source})"
        return f"{self.limit.quantity} is {self.value:.4g}{unit}" + ("." if self.kept else f", and {asked}.")


_RP = "DNV-RP-F205"
_GUIDE = "C. Serret (2019), 4.2"

SPAR_PERIODS = tuple(
    Limit(PERIOD + motion, lower, upper, "s", _RP)
    for motions, lower, upper in (
        (("surge", "sway", "yaw"), 100.0, math.inf), (("heave",), 20.0, 35.0), (("roll", "pitch"), 50.0, 90.0)
    )
    for motion in motions
)  # fmt: skip
"""Typical natural periods of deep-water spars, by DNV-RP-F205 as C. Serret (EngD thesis, 2019) quotes it."""

WAVE_BAND = (5.0, 25.0)
"""Periods [s] at which a sea has its energy, which no rigid motion should have."""

SPAR_AT_REST = (
    Limit("metacentric height", 1.0, math.inf, "m", _GUIDE),
    Limit("heel", -math.inf, math.radians(4.5), "rad", _GUIDE),
    Limit("area ratio", 1.30, math.inf, "1", "IMO MODU Code, 3.3.1, of column-stabilised units"),
    Limit("nacelle acceleration", -math.inf, 0.3 * 9.80665, "m/s^2", _GUIDE),
    Limit("highest wave over significant", 1.87, math.inf, "1", _GUIDE),
)
"""Limits on what a spar does at rest and in a sea, in SI: those that C. Serret (2019, 4.2 and 6.5) designs for."""

SPAR = SPAR_PERIODS + SPAR_AT_REST


def check_limits(values: Mapping[str, float], limits: Sequence[Limit] = SPAR) -> tuple[Verdict, ...]:
    """Verdicts on values by the name of their quantity, in the units of the limits; limits on others are left out.

    Raises ModelError for a quantity that no limit is for, or that is no number.
    """
    known = {limit.quantity: limit for limit in limits}
    for name in values:
        if name not in known:
            raise ModelError(f"there is no limit on '{name}'{did_you_mean(name, known)}")
    return tuple(known[name].of(value) for name, value in values.items())


def check_periods(periods: Mapping[str, float], limits: Sequence[Limit] = SPAR_PERIODS) -> tuple[Verdict, ...]:
    """Verdicts on the natural periods [s] of motions: {"surge": 169.3, "heave": 28.6, ...}."""
    return check_limits({PERIOD + motion: value for motion, value in periods.items()}, limits)


def within_wave_band(periods: Mapping[str, float], band: tuple[float, float] = WAVE_BAND) -> list[str]:
    """The motions whose natural period lies where waves have their energy."""
    return [motion for motion, period in periods.items() if band[0] < period < band[1]]


def broken(verdicts: Sequence[Verdict]) -> list[str]:
    """Sentences of those that are not kept."""
    return [verdict.sentence for verdict in verdicts if not verdict.kept]
