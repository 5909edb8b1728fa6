"""Moments of the results of a response whose drag has settled to a tolerance: values without slopes, in less time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fowtlib.analysis.plants import refuse_unstable
from fowtlib.analysis.spectra import widths
from fowtlib.frequency.driven import Grid
from fowtlib.frequency.quantities import ORDERS
from fowtlib.solving.excited import ExcitedModel


class SettledResponse:
    """The response of a model with these gains of drag; see RandomResponse, which has slopes too."""

    def __init__(self, excited: ExcitedModel, grid: Grid, gains: Sequence[np.ndarray]):
        linear = excited.with_gains(gains)
        refuse_unstable(linear)
        self.frequency = grid.frequency
        answers = grid.answers(linear, excited.results)
        self._densities = {path: ((H @ grid.spectra[path]) * H.conj()).sum(axis=2).real.T
                           for path, H in answers.items()}  # fmt: skip

    def moments(self, result: int, process: str | None = None) -> np.ndarray:
        """Spectral moments of a result, of orders 0, 1, 2 and 4 [unit^2 Hz^n]."""
        of = self._densities.values() if process is None else [self._densities[process]]
        density = sum(one[result] for one in of)
        return np.array([np.sum(self.frequency**n * density * widths(self.frequency)) for n in ORDERS])
