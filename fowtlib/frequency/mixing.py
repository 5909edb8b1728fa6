"""Anderson's mixing: a fixed point in fewer steps, from the last ones together."""

from __future__ import annotations

from collections.abc import Sequence

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
        sizes = np.concatenate([np.full(matrix.size, max(np.trace(matrix), 1e-12)) for matrix in found])
        self._given = [*self._given, _flat(given)][-DEPTH:]
        self._found = [*self._found, _flat(found)][-DEPTH:]
        steps = [(f - g) / sizes for f, g in zip(self._found, self._given, strict=True)]
        if len(steps) > 1 and np.linalg.norm(steps[-1]) > GROWN * np.linalg.norm(steps[-2]):
            self._share = max(self._share / 2, SHORTEST)
            self._given, self._found = self._given[-1:], self._found[-1:]
        plain = [old + self._share * (new - old) for old, new in zip(given, found, strict=True)]
        if len(self._given) < 2:
            return plain
        differences = np.column_stack([after - before for before, after in zip(steps[:-1], steps[1:], strict=True)])
        share = np.linalg.lstsq(differences, steps[-1], rcond=1e-10)[0]
        moves = np.column_stack([b - a for a, b in zip(self._found[:-1], self._found[1:], strict=True)])
        mixed, first = self._found[-1] - moves @ share, 0
        guess: list[np.ndarray] = []
        for matrix in plain:
            part = mixed[first : first + matrix.size].reshape(matrix.shape)
            first += matrix.size
            guess.append((part + part.T) / 2)
        for size in {len(matrix) for matrix in plain}:
            numbers = [k for k, matrix in enumerate(plain) if len(matrix) == size]
            parts, whole = (np.stack([of[k] for k in numbers]) for of in (guess, plain))
            kept = np.trace(parts, axis1=1, axis2=2) > LEAST * np.trace(whole, axis1=1, axis2=2)
            kept &= np.linalg.eigvalsh(parts)[:, 0] >= 0 if size > 1 else parts[:, 0, 0] >= 0
            for k in (number for number, keep in zip(numbers, kept, strict=True) if not keep):
                guess[k] = plain[k]
        return guess

    def moved(self, before: Sequence[np.ndarray], after: Sequence[np.ndarray]) -> None:
        """F has become another one, that gives `after` where it gave `before`, with steps that shrink alike."""
        self._found = [found + _flat(after) - _flat(before) for found in self._found]


def _flat(matrices: Sequence[np.ndarray]) -> np.ndarray:
    return np.concatenate([matrix.ravel() for matrix in matrices])
