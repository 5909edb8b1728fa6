"""Anderson's mixing: a fixed point in fewer steps, from the last ones together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

DEPTH = 5  # steps that are remembered
LEAST = 0.2  # of a gain: what a step may leave of its trace at least, else the plain step is taken
GROWN = 1.0  # of a step over the last one: from there what is remembered misleads
SHORTEST = 1 / 32  # share of a plain step that is taken at least, where steps go to and fro and grow


class Mixing:
    """The next guess of symmetric matrices G = f(G) without negative eigenvalues, from the guesses so far.

    Where the steps G -> f(G) shrink by a factor close to 1, as those of drag near a mode of little damping do, their
    least-squares combination goes on from where they would end. D. G. Anderson, J. ACM 12 (1965) 547; H. F. Walker and
    P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.

    Near a mode that hardly decays, f falls so steeply that plain steps go to and fro and grow: each time they do, plain
    steps become half as long.
    """

    def __init__(self) -> None:
        self._share = 1.0
        self._given: list[np.ndarray] = []
        self._found: list[np.ndarray] = []

    def __call__(self, given: Sequence[np.ndarray], found: Sequence[np.ndarray]) -> list[np.ndarray]:
        """The next guess, after f(given) = found."""
        places = _places(tuple(len(matrix) for matrix in found))
        self._given = [*self._given, _flat(given)][-DEPTH:]
        self._found = [*self._found, _flat(found)][-DEPTH:]
        sizes = places.spread(np.maximum(places.traces(self._found[-1]), 1e-12))
        steps = [(f - g) / sizes for f, g in zip(self._found, self._given, strict=True)]
        if len(steps) > 1 and np.linalg.norm(steps[-1]) > GROWN * np.linalg.norm(steps[-2]):
            self._share = max(self._share / 2, SHORTEST)
            self._given, self._found = self._given[-1:], self._found[-1:]
        plain = self._given[-1] + self._share * (self._found[-1] - self._given[-1])
        if len(self._given) < 2:
            return places.matrices(plain)
        differences = np.column_stack([after - before for before, after in zip(steps[:-1], steps[1:], strict=True)])
        share = np.linalg.lstsq(differences, steps[-1], rcond=1e-10)[0]
        moves = np.column_stack([b - a for a, b in zip(self._found[:-1], self._found[1:], strict=True)])
        mixed = self._found[-1] - moves @ share
        for size, numbers in places.of_size.items():
            parts, whole = mixed[numbers], plain[numbers]  # (matrices, size, size)
            parts = (parts + parts.transpose(0, 2, 1)) / 2
            kept = np.trace(parts, axis1=1, axis2=2) > LEAST * np.trace(whole, axis1=1, axis2=2)
            kept &= np.linalg.eigvalsh(parts)[:, 0] >= 0 if size > 1 else parts[:, 0, 0] >= 0
            mixed[numbers] = np.where(kept[:, None, None], parts, whole)
        return places.matrices(mixed)

    def moved(self, before: Sequence[np.ndarray], after: Sequence[np.ndarray]) -> None:
        """F has become another one, that gives `after` where it gave `before`, with steps that shrink alike."""
        self._found = [found + _flat(after) - _flat(before) for found in self._found]


@dataclass(frozen=True, eq=False)
class _Places:
    """Where matrices (n, n) of some sizes stand, one after the other; of_size: their numbers there (matrices, n, n)."""

    sizes: tuple[int, ...]
    of_size: Mapping[int, np.ndarray]
    owners: np.ndarray
    diagonal: np.ndarray

    def traces(self, flat: np.ndarray) -> np.ndarray:
        """Of each matrix."""
        return np.bincount(self.owners[self.diagonal], flat[self.diagonal], len(self.sizes))

    def spread(self, values: np.ndarray) -> np.ndarray:
        """One value of each matrix at all its elements."""
        return values[self.owners]

    def matrices(self, flat: np.ndarray) -> list[np.ndarray]:
        """The matrices themselves."""
        found, first = [], 0
        for size in self.sizes:
            found.append(flat[first : first + size**2].reshape(size, size))
            first += size**2
        return found


@lru_cache(maxsize=16)
def _places(sizes: tuple[int, ...]) -> _Places:
    first, of_size, diagonal = 0, dict[int, list[np.ndarray]](), []
    for size in sizes:
        numbers = first + np.arange(size**2).reshape(size, size)
        of_size.setdefault(size, []).append(numbers)
        diagonal.append(np.diag(numbers))
        first += size**2
    owners = np.repeat(np.arange(len(sizes)), [size**2 for size in sizes])
    stacked = {size: np.array(numbers) for size, numbers in of_size.items()}
    return _Places(sizes, stacked, owners, np.concatenate(diagonal))


def _flat(matrices: Sequence[np.ndarray]) -> np.ndarray:
    return np.concatenate([matrix.ravel() for matrix in matrices])
