"""Runs of one process by what `case_statistics` has kept of a channel, where their series are kept no more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.case_statistics import CROSSING_STEP
from fowtlib.analysis.maximum import sign_of
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_CONSTANT = 1e-9  # a standard deviation below this part of the mean is rounding
_WHOLE = 1e-6  # how near to a kept level, in steps, a level is taken for it


@dataclass(frozen=True)
class KeptRuns:
    """Mean, standard deviation and smallest value of all runs together, and what is needed to count passages.

    Of side "min" everything is of the negative of the channel, so that outward is upward. spans: lengths of the runs
    [s]. passed: of each run its own mean and deviation, and how often it passes its mean + k steps upward, by k.
    """

    mean: float
    std: float
    lowest: float
    spans: np.ndarray
    passed: tuple[tuple[float, float, np.ndarray, np.ndarray], ...]

    def passages(self, levels: ArrayLike) -> np.ndarray:
        """How often each run passes each level upward, (runs, levels); linear between the levels that were counted.

        They are 0.1 standard deviations apart: with Rice's rates that is up to (0.1 z)^2/8 too many z deviations from
        the mean, 1 % at z = 3.
        """
        rows = []
        for mean, std, steps, counts in self.passed:
            wanted = (np.asarray(levels, dtype=float) - mean) / (CROSSING_STEP * std)
            whole = np.round(wanted)
            wanted = np.where(np.abs(wanted - whole) < _WHOLE, whole, wanted)
            rows.append(np.interp(wanted, steps, counts, left=0.0, right=0.0))
        return np.array(rows)

    @property
    def mean_rate(self) -> float:
        """Upward passages of the mean [1/s]."""
        return float(self.passages([self.mean]).sum() / self.spans.sum())


def is_constant(mean: float, std: float) -> bool:
    """Whether a standard deviation is 0, but for rounding."""
    return not std > _CONSTANT * max(abs(mean), 1e-300)


def kept_runs(channels: Sequence[Mapping[str, Any]], spans: Sequence[float], name: str, side: str = "max") -> KeptRuns:
    """Of the rows of one channel in the "channels" of `case_statistics`, a row for each run, and their lengths [s].

    Raises ModelError for a constant, and for statistics without counts of passages 0.1 standard deviations apart.
    """
    sign = sign_of(side)
    outer, inner = ("above", "below") if sign > 0 else ("below", "above")
    weights = np.asarray(spans, dtype=float)
    means, stds = (np.array([row[key] for row in channels], dtype=float) for key in ("mean", "std"))
    if any(map(is_constant, means, stds)):
        raise ModelError(f"{name}: it does not change.")
    share = weights / weights.sum()
    mean = float(share @ means)
    std = float(np.sqrt(share @ (stds**2 + (means - mean) ** 2)))
    passed = []
    for row, own_mean, own_std in zip(channels, sign * means, stds, strict=True):
        crossings = row.get("crossings")
        if not crossings or crossings["step"] > CROSSING_STEP * (1 + 1e-9):
            raise ModelError(
                f"{name}: the statistics that are kept do not count passages at the levels that are needed."
            )
        finer = CROSSING_STEP / crossings["step"]
        above, below = crossings[outer], crossings[inner][1:]  # downward passages: upward ones but for one
        counts = np.array([0, *below[::-1], *above, 0], dtype=float)
        steps = np.arange(-len(below) - 1, len(above) + 1) / finer
        passed.append((float(own_mean), float(own_std), steps, counts))
    lowest = min(sign * row["min" if sign > 0 else "max"] for row in channels)
    return KeptRuns(sign * mean, std, float(lowest), weights, tuple(passed))
