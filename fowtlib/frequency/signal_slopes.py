"""How signals per channel of their process change with elements of parameters: of waves on the parts of a hull.

They are functions of frequency in Python, and slopes are differences of them alone. Runs about one design in other
weather have them in common: what is computed is kept, at the frequencies of all of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fowtlib.language.component import Component
from fowtlib.solving.excited import Signal
from fowtlib.solving.known_slopes import Known
from fowtlib.solving.together import slopes_together
from fowtlib.solving.tuned import Tuned, TunedRun

DECAYED = 1e-9  # of the largest change of a signal, a change that does not count


class SignalSlopes:
    """Slopes of signals at frequencies omega (q,) [rad/s], by the elements of a run."""

    def __init__(self, run: TunedRun, signals: Sequence[Signal], omega: np.ndarray):
        self.run, self.signals, self.omega = run, list(signals), omega
        self.names = [("signal", item.path, item.columns.start) for item in self.signals]
        self.known = [run.known(name) for name in self.names]
        everywhere = run.asked(omega)
        for signal, known in zip(self.signals, self.known, strict=True):
            self._prepare(signal, known, everywhere)
        self._learn_together()

    def of(self, item: Tuned) -> Mapping[int, np.ndarray]:
        """Slopes (q, signals, channels) by an element, by the numbers of those signals that depend on it."""
        self._learn(item)
        return {k: one.slopes[item.name][1][np.searchsorted(one.slopes[item.name][0], self.omega)]
                for k, one in enumerate(self.known) if one.slopes.get(item.name) is not None}  # fmt: skip

    def _prepare(self, signal: Signal, known: Known, everywhere: np.ndarray) -> None:
        """What is known of a signal, at all frequencies where it is of use; its slopes there are not known yet."""
        if known.there is not None and np.all(np.isin(self.omega, known.there[0], assume_unique=True)):
            return
        with self.run.beside().here() as (tree, read):
            here = signal.response(tree, everywhere)
        known.note(read, self.run.contents)
        known.there, known.before, known.slopes, known.apart = (everywhere, np.array(here)), known.mattered, {}, None

    def _learn_together(self) -> None:
        """Slopes by those elements of which it is known to which signals they mattered before."""
        steps: dict[str, float] = {}
        asked: dict[str, list[int]] = {}
        for item in self.run.elements:
            unknown = [k for k, one in enumerate(self.known) if item.name not in one.slopes and item.path in one.paths]
            if unknown and self.run.moves_freely(item) and all(item.name in self.known[k].before for k in unknown):
                steps[item.name], asked[item.name] = self.run.step(item), unknown
        if len(steps) < 2:
            return
        affects = {name: {k: mask for k in unknown if (mask := self.known[k].before[name]) is not None}
                   for name, unknown in asked.items()}  # fmt: skip
        here = {k: _flat(self.known[k].there[1]) for unknown in asked.values() for k in unknown}

        def computed(shifts: Mapping[str, float], numbers: Sequence[int]) -> list[np.ndarray]:
            with self.run.beside().at(self.run.shifted(shifts)) as root:
                return [_flat(self._response(k, root)) for k in numbers]

        found = slopes_together(steps, affects, here, computed, DECAYED)
        for name, slopes in (found or {}).items():
            for k in asked[name]:
                omega, values = self.known[k].there
                self.known[k].slopes[name] = None
                if (slope := slopes.get(k)) is not None:
                    self.known[k].slopes[name] = omega, slope.view(complex).reshape(values.shape)

    def _learn(self, item: Tuned) -> None:
        """The slopes of signals by an element that are not known yet; None of those that do not depend on it."""
        asked: list[int] = []
        for k, known in enumerate(self.known):
            if item.name in known.slopes:
                continue
            known.slopes[item.name] = None
            if item.path in known.paths and item.name not in self._apart(k):
                asked.append(k)
        if not asked:
            return
        here = np.concatenate([_flat(self.known[k].there[1]) for k in asked])

        def computed(value: float) -> np.ndarray:
            with self.run.tree_at(item, value) as root:
                return np.concatenate([_flat(self._response(k, root)) for k in asked])

        slope, first = self.run.slope(item, computed, here), 0
        for k in asked:
            omega, values = self.known[k].there
            part = slope[first : first + 2 * values.size]
            first += part.size
            if part.any():
                self.known[k].slopes[item.name] = omega, part.view(complex).reshape(values.shape)
            else:
                self.run.set_apart(self.names[k], item)

    def _apart(self, k: int) -> set[str]:
        known = self.known[k]
        items = [item for item in self.run.elements if item.path in known.paths]
        return self.run.kept_apart(self.names[k], known, items, known.there[1], lambda root: self._response(k, root))

    def _response(self, k: int, root: Component) -> np.ndarray:
        return self.signals[k].response(root, self.known[k].there[0])


def _flat(values: np.ndarray) -> np.ndarray:
    """Complex numbers as real ones."""
    return np.ascontiguousarray(values, dtype=complex).ravel().view(float)
