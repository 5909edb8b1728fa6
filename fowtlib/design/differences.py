"""Results of a model with slopes by central differences.

Each difference begins at the equilibrium of its middle and has the frequencies of it, so that two values differ by the
step alone. A step is a share of the scale of its variable; at a bound, and beside a point without results, three points
on one side give the slope with an error of the same order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from fowtlib.design.evaluation import Evaluated, Key
from fowtlib.design.measures import Measured, Meter, Statistics
from fowtlib.design.terms import DesignCase
from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError
from fowtlib.language.stopping import STOP_ASKED

STEP = 1e-4  # of the scale of a variable
CLOSE = 0.1  # of the scales of variables, within which the frequencies of a response stay the same

Results = dict[Key, np.ndarray]


class Differences:
    """An evaluator of a compiled model (fowtlib.design.evaluation.Evaluator); keys: what is asked, by case.

    balance: the case in which parameters are freed, which the others take as they are there; None: in each its own.
    """

    def __init__(self, plant: Any, space: Space, cases: Sequence[DesignCase], keys: Sequence[Key], *, free: Any = None,
                 targets: Mapping[str, Any] | None = None, statistics: Statistics | None = None,
                 balance: str | None = None, step: float = STEP):  # fmt: skip
        self.space, self.step, self.keys, self.balance = space, step, list(keys), balance
        self.freed = [path.partition("[")[0] for path in free or ()]
        self.meters: dict[str, Meter] = {}
        for case in sorted(cases, key=lambda case: case.name != balance):  # what the others take comes first
            names = [name for own, name in keys if own == case.name]
            if names or case.name == balance:
                own = (free, targets) if balance in (None, case.name) else (None, None)
                self.meters[case.name] = Meter(plant, case, names, *own, statistics)
        self.near: dict[str, Measured] = {}
        self._last: tuple[bytes, dict[str, Measured]] | None = None
        self._chosen: np.ndarray | None = None  # where the frequencies were chosen

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        middle = self._measured(x)
        units = {name: unit for found in middle.values() for name, unit in found.units.items()}
        values = self._columns(middle)
        slopes = self._slopes(x, middle, values) if jacobian else None
        return Evaluated(values, units, slopes, {name: found.state for name, found in middle.items()})

    def _measured(self, x: np.ndarray) -> dict[str, Measured]:
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            close = self._chosen is not None and np.max(np.abs(x - self._chosen) / self.space.scale) <= CLOSE
            found = self._all(x, self.near, fixed=bool(close))
            self._chosen = self._chosen if close else x
            self._last, self.near = (key, found), found
        return self._last[1]

    def _all(self, x: np.ndarray, near: Mapping[str, Measured], fixed: bool) -> dict[str, Measured]:
        """All cases; what is freed in one of them counts in the others."""
        found: dict[str, Measured] = {}
        parameters = self.space.parameters(x)
        for name in self.meters:
            found[name] = self._one(name, parameters, near.get(name), fixed)
            if name == self.balance:
                parameters |= {path: found[name].state.parameters[path] for path in self.freed}
        return found

    def _one(self, case: str, parameters: Mapping[str, Any], near: Measured | None, fixed: bool) -> Measured:
        try:
            return self.meters[case].measure(parameters, near, fixed)
        except ModelError as error:
            if len(self.meters) > 1:
                error.at(f"case {case}")
            raise

    def _columns(self, found: Mapping[str, Measured]) -> Results:
        return {key: found[key[0]].values[key[1]] for key in self.keys}

    def _slopes(self, x: np.ndarray, middle: Mapping[str, Measured], values: Results) -> Results:
        slopes = {key: np.zeros((value.size, x.size)) for key, value in values.items()}

        def at(moved: np.ndarray) -> Results:
            return self._columns(self._all(moved, middle, fixed=True))

        stop = STOP_ASKED.get()
        for k in range(x.size):
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
            for key, slope in self._slope(x, k, values, at).items():
                slopes[key][:, k] = slope
        return slopes

    def _slope(self, x: np.ndarray, k: int, middle: Results, at: Callable[[np.ndarray], Results]) -> Results:
        h, failure = self.step * self.space.scale[k], ""
        room = {+1: self.space.upper[k] - x[k], -1: x[k] - self.space.lower[k]}

        def moved(steps: float) -> Results:
            other = x.copy()
            other[k] += steps * h
            return at(other)

        def size(steps: float) -> float:
            return (x[k] + steps * h) - x[k]  # as rounding leaves it

        if min(room.values()) >= h:
            try:
                ahead, behind = moved(+1), moved(-1)
                return {key: (ahead[key] - behind[key]) / (size(+1) - size(-1)) for key in middle}
            except ModelError as error:
                failure = str(error)
        for side in sorted(room, key=lambda one: -room[one]):
            try:
                if room[side] >= 2 * h:
                    one, two = moved(side), moved(2 * side)
                    return {key: (4 * one[key] - 3 * middle[key] - two[key]) / size(2 * side) for key in middle}
            except ModelError as error:
                failure = str(error)
        what = f"no slope by {self.space.elements[k]}, on neither side are there results"
        raise ModelError(f"{what}: {failure or 'the bounds are too close'}")
