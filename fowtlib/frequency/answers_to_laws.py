"""What all outputs answer to what is added to the laws of drag, as sums of functions of frequency.

Answers T(omega) = C (i omega - A)^-1 B + D are real sums of the functions of the modes, which few functions stand for.
What is summed over frequencies is then made of these functions alone, and no answer is needed at any frequency.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.solving.linear import Resolvent
from fowtlib.solving.real_modes import FewFunctions

AT_ONCE = 32  # frequencies, of the spectra of all laws with all laws


@dataclass(frozen=True, eq=False)
class AnswersToLaws:
    """by_function (f, outputs, added): what each function of `few` counts for in the answers."""

    few: FewFunctions
    by_function: np.ndarray

    @staticmethod
    def of(resolvent: Resolvent, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> AnswersToLaws:
        """Those of a model with real modes; B, C and D of what is added."""
        modes = resolvent.modes
        few = resolvent.few
        by_mode = modes.between(C, B).reshape(-1, len(modes.of))
        by_function = (few.of.T @ by_mode.T).reshape(-1, *D.shape)
        by_function[-1] += D
        return AnswersToLaws(few, by_function)

    def spectra(self, u: np.ndarray, density: np.ndarray) -> np.ndarray:
        """Re sum over frequencies of the few functions times Z = u S u^H, u (n, q, k) of the laws: (f, n, n)."""
        sums, values = np.zeros((len(self.few.values), len(u) ** 2)), self.few.values
        for begin in range(0, u.shape[1], AT_ONCE):
            part = slice(begin, min(begin + AT_ONCE, u.shape[1]))
            of = u[:, part].transpose(1, 0, 2)
            with_density = of @ density[part]
            other = np.concatenate([of.real, of.imag], axis=2).transpose(0, 2, 1)
            real = np.concatenate([with_density.real, with_density.imag], axis=2) @ other
            imaginary = np.concatenate([with_density.imag, -with_density.real], axis=2) @ other
            sums += values.real[:, part] @ real.reshape(len(real), -1)
            sums -= values.imag[:, part] @ imaginary.reshape(len(real), -1)
        return sums.reshape(len(sums), len(u), len(u))

    def with_spectra(self, sums: np.ndarray, first: int, rows: np.ndarray) -> np.ndarray:
        """Re sum of T[i, r; j, c] Z[j, e; i, s] over frequencies: (laws i, laws j, r c, e s).

        sums (f, n, n): see spectra; the n inputs of the laws stand behind the first outputs; rows (laws, width): of
        each law among them, -1 where it is narrower.
        """
        laws, width = rows.shape
        chosen, there = rows.ravel(), rows.ravel() >= 0
        there = there[:, None] & there
        T = np.where(there, self.by_function[:, first:][:, chosen][:, :, chosen], 0.0)
        Z = np.where(there, sums[:, chosen][:, :, chosen], 0.0)
        T = T.reshape(-1, laws, width, laws, width).transpose(1, 3, 2, 4, 0)
        Z = Z.reshape(-1, laws, width, laws, width).transpose(3, 1, 0, 2, 4)
        return T.reshape(laws, laws, width**2, -1) @ Z.reshape(laws, laws, -1, width**2)

    def with_row(self, output: int, rows: np.ndarray) -> np.ndarray:
        """Re sum of the answers of an output times rows (n, q): (added, n)."""
        return self.by_function[:, output].T @ self.few.summed(rows)
