"""How far two records of the same quantity agree over time: correlation and root mean square of their difference.

Every number says what it is divided by: published comparisons of tests and simulations mix denominators.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.analysis.series import as_series
from fowtlib.language.errors import ModelError, one_of

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike

DENOMINATORS = ("test", "larger", "smaller", "mean")


@dataclass(frozen=True)
class Agreement:
    """Of a first record (a simulation) with a second one (the test), over the time that both have.

    correlation   of their changes about the mean, -1 to 1: blind for amplitude and offset
    rmse          sqrt(mean((first - second)^2)), in the unit of the second
    test_std      standard deviation of the second, and test_range its maximum - minimum: what to divide by
    """

    name: str
    unit: str
    correlation: float
    rmse: float
    test_std: float
    test_range: float

    @property
    def rmse_of_std(self) -> float:
        """RMSE over the standard deviation of the test."""
        return self.rmse / self.test_std if self.test_std > 0 else math.nan

    @property
    def rmse_of_range(self) -> float:
        """RMSE over maximum - minimum of the test."""
        return self.rmse / self.test_range if self.test_range > 0 else math.nan


def agreement(
    first: SeriesLike, second: SeriesLike, *, window: tuple[float, float] | None = None, name: str = ""
) -> Agreement:
    """Agreement of two records at the times of the second, the first interpolated linearly between its own.

    window: from and to [s]; None: the time that both have. Raises ModelError: no common time, other units.
    """
    one, test = as_series(first, name), as_series(second, name)
    if one.unit != test.unit and "1" not in (one.unit, test.unit):
        raise ModelError(f"{test.name} is in {test.unit}, and the other record in {one.unit}; convert one of them.")
    low, high = max(one.time[0], test.time[0]), min(one.time[-1], test.time[-1])
    if window is not None:
        low, high = max(low, window[0]), min(high, window[1])
    inside = (test.time >= low - 1e-9) & (test.time <= high + 1e-9)
    if inside.sum() < 3:
        raise ModelError(f"{test.name}: the two records have no time in common{' in this window' if window else ''}.")
    wanted = test.values[inside]
    found = np.interp(test.time[inside], one.time, one.values)
    spread = float(found.std() * wanted.std())
    together = float(np.mean((found - found.mean()) * (wanted - wanted.mean())))
    rmse = math.sqrt(float(np.mean((found - wanted) ** 2)))
    return Agreement(
        test.name, test.unit, together / spread if spread > 0 else math.nan, rmse, float(wanted.std()),
        float(np.ptp(wanted)),
    )  # fmt: skip


def denominator(first: float, test: float, of: str = "test") -> float:
    """The size of the test, the larger or smaller size of both, or their mean size."""
    if of not in DENOMINATORS:
        raise ModelError(f"a difference is over {one_of(DENOMINATORS)}, not '{of}'.")
    sizes = abs(first), abs(test)
    return {"test": sizes[1], "larger": max(sizes), "smaller": min(sizes), "mean": sum(sizes) / 2}[of]


def percent_difference(first: float, test: float, of: str = "test") -> float:
    """100 (first - test) over the size of the test, of the larger or smaller of both, or of their mean."""
    below = denominator(first, test, of)
    if below == 0.0:
        raise ModelError(f"a difference over a {of} value of zero has no percent.")
    return 100.0 * (first - test) / below
