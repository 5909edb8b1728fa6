"""How signals per channel of their process change with elements of parameters: of waves on the parts of a hull.

They are functions of frequency in Python, and slopes are differences of them alone; where they follow from few numbers
of a part, as places of strips, and know their slopes by these, of the numbers. Runs about one design in other weather
have them in common: what is computed is kept, at the frequencies of all of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.solving.excited import Signal
from fowtlib.solving.known_slopes import Known
from fowtlib.solving.together import slopes_together
from fowtlib.solving.tuned import Tuned, TunedRun

DECAYED = 1e-9  # of the largest change of a signal, a change that does not count


@dataclass(frozen=True, eq=False)
class There:
    """Signals as they are at frequencies omega (q,) [rad/s], the numbers that they follow from, and what is besides.

    besides: paths of the parameters that are read for it; elements of these move the signals, others the numbers.
    """

    omega: np.ndarray
    values: np.ndarray
    numbers: np.ndarray | None
    besides: frozenset[str]

    def through(self, item: Tuned) -> bool:
        """Whether the signals follow from an element through numbers alone."""
        return self.numbers is not None and item.path not in self.besides


class SignalSlopes:
    """Slopes of signals at frequencies omega (q,) [rad/s], by the elements of a run."""

    def __init__(self, run: TunedRun, signals: Sequence[Signal], omega: np.ndarray):
        self.run, self.signals, self.omega = run, list(signals), omega
        self.names = [("signal", item.path, item.columns.start) for item in self.signals]
        self.known = [run.known(name) for name in self.names]
        everywhere = run.asked(omega)
        for signal, known in zip(self.signals, self.known, strict=True):
            self._prepare(signal, known, everywhere)
        self._learn_closed()
        self._learn_together()

    def of(self, item: Tuned) -> Mapping[int, np.ndarray]:
        """Slopes (q, signals, channels) by an element, by the numbers of those signals that depend on it."""
        self._learn(item)
        return {k: one.slopes[item.name][1][np.searchsorted(one.slopes[item.name][0], self.omega)]
                for k, one in enumerate(self.known) if one.slopes.get(item.name) is not None}  # fmt: skip

    def _prepare(self, signal: Signal, known: Known, everywhere: np.ndarray) -> None:
        """What is known of a signal, at all frequencies where it is of use; its slopes there are not known yet."""
        if known.there is not None and np.all(np.isin(self.omega, known.there.omega, assume_unique=True)):
            return
        with self.run.beside().here() as (tree, read):
            here, numbers = np.array(signal.response(tree, everywhere)), signal.numbers(tree)
        known.note(read, self.run.contents)
        with self.run.beside().here() as (tree, read):
            if numbers is not None:
                signal.besides(tree)
        there = There(everywhere, here, numbers, frozenset(join(*place) for place in read))
        known.there, known.before, known.slopes, known.apart = there, known.mattered, {}, None

    def _learn_closed(self) -> None:
        """Slopes of those signals whose numbers say how they change with the parameters of their part."""
        tangents, items = self.run.tangents(), self.run.by_arithmetic
        for k, known in enumerate(self.known):
            asked = [(column, item) for column, item in enumerate(items) if item.name not in known.slopes
                     and item.path in known.paths and known.there.through(item)]  # fmt: skip
            if not asked:
                continue
            with self.run.beside().here() as (tree, _):
                found = self.signals[k].number_slopes(tree, tangents)
            if found is not None:
                slopes = {item.name: found[:, column] for column, item in asked}
                self._keep(k, {name: slope if slope.any() else None for name, slope in slopes.items()
                               if np.isfinite(slope).all()}, few=True)  # fmt: skip

    def _learn_together(self) -> None:
        """Slopes by those elements of which it is known to which signals they mattered before."""
        steps: dict[str, float] = {}
        asked: dict[str, list[int]] = {}
        for item in self.run.elements:
            unknown = [k for k, one in enumerate(self.known) if item.name not in one.slopes and item.path in one.paths]
            if any(self.known[k].there.through(item) != self._has_numbers(k) for k in unknown):
                continue  # it moves more than the numbers
            if unknown and self.run.moves_freely(item) and all(item.name in self.known[k].before for k in unknown):
                steps[item.name], asked[item.name] = self.run.step(item), unknown
        if len(steps) < 2:
            return
        affects = {name: {k: mask for k in unknown if (mask := self.known[k].before[name]) is not None}
                   for name, unknown in asked.items()}  # fmt: skip
        by_numbers = {k: self._has_numbers(k) for unknown in asked.values() for k in unknown}
        here = {k: self._here(k, few) for k, few in by_numbers.items()}

        def computed(shifts: Mapping[str, float], numbers: Sequence[int]) -> list[np.ndarray]:
            with self.run.beside().at(self.run.shifted(shifts)) as root:
                return [self._computed(k, root, by_numbers[k]) for k in numbers]

        found = slopes_together(steps, affects, here, computed, DECAYED)
        if found is None:
            return
        for k, few in by_numbers.items():
            self._keep(k, {name: found[name].get(k) for name, unknown in asked.items() if k in unknown}, few)

    def _learn(self, item: Tuned) -> None:
        """The slopes of signals by an element that are not known yet; None of those that do not depend on it."""
        asked: dict[int, bool] = {}
        for k, known in enumerate(self.known):
            if item.name in known.slopes:
                continue
            known.slopes[item.name] = None
            if item.path in known.paths and item.name not in self._apart(k):
                asked[k] = known.there.through(item)
        if not asked:
            return
        here = [self._here(k, few) for k, few in asked.items()]

        def computed(value: float) -> np.ndarray:
            with self.run.tree_at(item, value) as root:
                return np.concatenate([self._computed(k, root, few) for k, few in asked.items()])

        slope = self.run.slope(item, computed, np.concatenate(here))
        parts = np.split(slope, np.cumsum([one.size for one in here])[:-1])
        for (k, few), part in zip(asked.items(), parts, strict=True):
            if part.any():
                self._keep(k, {item.name: part}, few)
            else:
                self.run.set_apart(self.names[k], item)

    def _keep(self, k: int, found: Mapping[str, np.ndarray | None], few: bool) -> None:
        """Slopes of a signal by elements, from those of its numbers or of its real and imaginary parts."""
        known, moved = self.known[k], {name: slope for name, slope in found.items() if slope is not None}
        known.slopes |= dict.fromkeys(found)
        if not moved:
            return
        slopes, there = np.array(list(moved.values())), known.there
        if few:
            with self.run.beside().here() as (tree, _):
                values = self.signals[k].slopes(tree, there.omega, slopes)
        else:
            values = slopes.view(complex).reshape(-1, *there.values.shape)
        known.slopes |= {name: (there.omega, value) for name, value in zip(moved, values, strict=True)}

    def _apart(self, k: int) -> set[str]:
        known, few = self.known[k], self._has_numbers(k)
        items = [item for item in self.run.elements
                 if item.path in known.paths and known.there.through(item) == few]  # fmt: skip
        return self.run.kept_apart(self.names[k], known, items, self._here(k, few),
                                   lambda root: self._computed(k, root, few))  # fmt: skip

    def _has_numbers(self, k: int) -> bool:
        return self.known[k].there.numbers is not None

    def _here(self, k: int, few: bool) -> np.ndarray:
        """Numbers of a signal, or its real and imaginary parts, as they are."""
        return self.known[k].there.numbers if few else _flat(self.known[k].there.values)

    def _computed(self, k: int, root: Component, few: bool) -> np.ndarray:
        """The same of a tree."""
        if few:
            return self.signals[k].numbers(root)
        return _flat(self.signals[k].response(root, self.known[k].there.omega))


def _flat(values: np.ndarray) -> np.ndarray:
    """Complex numbers as real ones."""
    return np.ascontiguousarray(values, dtype=complex).ravel().view(float)
