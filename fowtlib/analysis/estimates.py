"""A number that was found from data, with its standard error and its interval of confidence."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fowtlib.language.errors import ModelError


@dataclass(frozen=True)
class Estimate:
    """A value with its standard error; freedom: degrees of freedom behind the error, infinite where it is known."""

    value: float
    error: float
    freedom: float = math.inf

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Lower and upper end of the interval of confidence, by Student's t."""
        from scipy.stats import t

        if not 0.0 < level < 1.0:
            raise ModelError(f"a level of confidence lies between 0 and 1, such as 0.95, not {level:g}.")
        reach = float(t.ppf(0.5 + level / 2, self.freedom)) * self.error
        return self.value - reach, self.value + reach

    def holds(self, value: float, level: float = 0.95) -> bool:
        """Whether a value lies in the interval."""
        low, high = self.interval(level)
        return low <= value <= high

    def __float__(self) -> float:
        return self.value

    def __repr__(self) -> str:
        low, high = self.interval()
        return f"{self.value:.5g} ({low:.5g} to {high:.5g})"


def covariance_of(jacobian: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Covariance of the parameters of a least-squares fit: s^2 (J' J)^-1, s^2 = r'r / (n - p), independent residuals.

    Columns are scaled first, so that parameters in different units do not matter. Raises ModelError where the data
    say nothing of a combination of parameters.
    """
    count, width = jacobian.shape
    if count <= width:
        raise ModelError(f"{count} values do not tell {width} parameters.")
    sizes = np.linalg.norm(jacobian, axis=0)
    if not sizes.all():
        raise ModelError("a parameter has no influence on the data, so they do not tell it.")
    _, singular, rows = np.linalg.svd(jacobian / sizes, full_matrices=False)
    if singular[-1] < 1e-10 * singular[0]:
        raise ModelError("the data tell a combination of parameters only, not each of them.")
    inverse = (rows.T / singular**2) @ rows / np.outer(sizes, sizes)
    return float(residual @ residual) / (count - width) * inverse


def of_formula(gradient: np.ndarray, covariance: np.ndarray) -> float:
    """Standard error of a number with this gradient by the parameters, to first order."""
    return math.sqrt(max(float(gradient @ covariance @ gradient), 0.0))
