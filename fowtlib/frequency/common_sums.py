"""Slopes of many scalars of one response: the sums over frequencies that all of them need are made once.

The adjoint of a scalar is for each mode a conjugate function of frequency times the inputs u of all laws of drag, times
the density S and by constants, and times one row of its own (frequency.adjoint). So with

    W[f, i, c] = Re sum over frequencies and channels of conj(function f) (u S)_i conj(c),

c the states and all that is driven, its slopes by the matrices are products of constants with W and with sums for that
row; nothing else has to be summed for a scalar.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fowtlib.frequency.driven import NOTHING
from fowtlib.solving.linear import Resolvent, times
from fowtlib.solving.real_modes import RealModes

AT_ONCE = 32  # frequencies, of the products of all laws with all columns
ALONE = 2  # channels up to which products are made function by function


@dataclass(frozen=True, eq=False)
class Rows:
    """What is summed, at frequencies (q,) and by channels, the channels of the processes one behind the other.

    columns: channels of each process; driven: numbers of the inputs that it drives, of so many; drives: of these, by
    its own channels (n, q, k); weighted: density times widths (q, k, k); states, laws: x and u S (n, q, k).
    """

    columns: Mapping[str, slice]
    driven: Mapping[str, np.ndarray]
    inputs: int
    drives: Mapping[str, np.ndarray]
    weighted: np.ndarray
    states: np.ndarray
    laws: np.ndarray


class CommonSums:
    """Those of a response without operators whose modes are real pairs and real roots."""

    def __init__(self, resolvent: Resolvent, modes: RealModes, rows: Rows):
        self.resolvent, self.modes, self.few, self.of = resolvent, modes, resolvent.few, rows
        self.states = len(rows.states)
        self.moved = {path: self._moved(channels) for path, channels in rows.columns.items()}
        self.driven_rows = {path: drive.any(axis=(1, 2)) for path, drive in rows.drives.items()}

    def _moved(self, channels: slice) -> slice:
        """From the first to the last of the frequencies at which channels have power."""
        power = np.trace(self.of.weighted[:, channels, channels], axis1=1, axis2=2).real
        there = np.flatnonzero(power > NOTHING * power.max(initial=0.0))
        return slice(int(there[0]), int(there[-1]) + 1) if there.size else slice(0, 0)

    @cached_property
    def _conjugates(self) -> dict[str, np.ndarray]:
        """Of the states and of what each process drives, by its channels (q, k, c), where it has power."""
        x, drives, columns = self.of.states, self.of.drives, self.of.columns
        both = {path: np.concatenate([x[:, part, columns[path]], drives[path][self.driven_rows[path]][:, part]])
                for path, part in self.moved.items()}  # fmt: skip
        return {path: np.ascontiguousarray(block.transpose(1, 2, 0)).conj() for path, block in both.items()}

    @cached_property
    def _by_few(self) -> np.ndarray:
        """W of the few functions, but for the last one, which no mode has: (f, laws, states and inputs)."""
        swept, values = self.of.laws, self.few.values[:-1]
        found = np.zeros((len(values), len(swept), self.states + self.of.inputs))
        for path, channels in self.of.columns.items():
            part, conjugates = self.moved[path], self._conjugates[path]
            sums = _alone if conjugates.shape[1] <= ALONE else _by_products
            self._add(found, path, sums(values[:, part], swept[:, part, channels], conjugates))
        return found

    def _add(self, found: np.ndarray, path: str, sums: np.ndarray) -> None:
        """Add sums with the states and with what a process drives."""
        found[..., : self.states] += sums[..., : self.states]
        driven = self.of.driven[path][self.driven_rows[path]]
        found[..., self.states + driven] += sums[..., self.states :]

    def laws_with_laws(self, u: np.ndarray, by: np.ndarray) -> np.ndarray:
        """Re sum of the few functions times spectra u S u^H of the laws (f, laws, laws), u = by [states; inputs]."""
        swept, rows = (np.ascontiguousarray(block).reshape(len(block), -1).view(float) for block in (self.of.laws, u))
        return np.concatenate([self._by_few @ by.T, (swept @ rows.T)[None]]).transpose(0, 2, 1)

    def with_modes(self, own: np.ndarray, by_laws: np.ndarray, bars: np.ndarray) -> np.ndarray:
        """Re sum of the adjoint amplitudes of scalars times conjugates of states and inputs: (k, modes, c).

        The amplitudes are conjugate functions of own (k, modes) times bars (k, q, channels), and by_laws (k, modes,
        laws) times what W is of.
        """
        p, count = len(self.modes.pairs), len(own)
        first, second, rest = slice(p), slice(p, 2 * p), slice(2 * p, None)
        W, F = self._by_function, self._of_bars(bars)
        pairs = by_laws[:, : 2 * p].reshape(count, 2, p, -1).transpose(2, 0, 1, 3).reshape(p, 2 * count, -1)
        P, Q = ((pairs @ W[part]).reshape(p, count, 2, -1).transpose(2, 1, 0, 3) for part in (first, second))
        g, h, alone = (own[:, part, None] for part in (first, second, rest))
        found = np.empty((count, *F.shape[1:]))
        found[:, first] = P[0] + Q[1] + g * F[:, first] + h * F[:, second]
        found[:, second] = Q[0] - P[1] + g * F[:, second] - h * F[:, first]
        found[:, rest] = (by_laws[:, rest].transpose(1, 0, 2) @ W[rest]).transpose(1, 0, 2) + alone * F[:, rest]
        return found

    def rows(self, bars: np.ndarray) -> np.ndarray:
        """Re sum of bars (k, q, channels) times conjugates of states and inputs: (k, c)."""
        found = np.zeros((len(bars), self.states + self.of.inputs))
        for path, channels in self.of.columns.items():
            conjugates = self._conjugates[path].reshape(-1, self._conjugates[path].shape[2])
            found_of = bars[:, self.moved[path], channels].reshape(len(bars), -1) @ conjugates
            self._add(found, path, found_of.real)
        return found

    def driven(self, path: str, of_both: np.ndarray, of_rows: np.ndarray, of_states: np.ndarray,
               bar: np.ndarray) -> np.ndarray:  # fmt: skip
        """Slopes of a scalar by what a process drives (n, q, k), nothing where that has no power.

        of_both (n, modes): from the adjoint amplitudes; of_rows (n, 1 + laws), of_states (modes, 1 + laws): of these
        inputs, and of the modes, from bar (q, channels) and what W is of.
        """
        part, channels = self.moved[path], self.of.columns[path]
        found = np.zeros((len(of_rows), len(bar), channels.stop - channels.start), dtype=complex)
        swept, own = self.of.laws[:, part, channels], bar[part, channels]
        both = times(np.vstack([of_states, of_rows])[:, 1:], swept)
        both[: len(of_states)] += of_states[:, :1, None] * own
        amplitudes = self.modes.answers(self.resolvent.functions[:, part].conj(), both[: len(of_states)])
        found[:, part] = both[len(of_states) :] + of_rows[:, :1, None] * own + times(of_both, amplitudes)
        return found

    def _of_bars(self, bars: np.ndarray) -> np.ndarray:
        """Re sum of the conjugate of each function times bars times the conjugates: (k, modes, c)."""
        values = self.few.values[:-1]
        found = np.zeros((len(values), len(bars), self.states + self.of.inputs))
        for path, channels in self.of.columns.items():
            part = self.moved[path]
            self._add(found, path, _by_products(values[:, part], bars[:, part, channels], self._conjugates[path]))
        return self._of_all(found).transpose(1, 0, 2)

    @cached_property
    def _by_function(self) -> np.ndarray:
        """W of all functions of the modes."""
        return self._of_all(self._by_few)

    def _of_all(self, by_few: np.ndarray) -> np.ndarray:
        of = self.few.of[:, :-1]
        return (of @ by_few.reshape(len(by_few), -1)).reshape(len(of), *by_few.shape[1:])


def _alone(values: np.ndarray, swept: np.ndarray, conjugates: np.ndarray) -> np.ndarray:
    """W of functions (f, q), rows (laws, q, k) and conjugates (q, k, c), one function after the other."""
    columns = conjugates.conj().reshape(-1, conjugates.shape[2]).T
    columns, found = np.ascontiguousarray(columns).view(float).T, []
    for value in values.conj():
        found.append((swept * value[:, None]).reshape(len(swept), -1).view(float) @ columns)
    return np.array(found)


def _by_products(values: np.ndarray, swept: np.ndarray, conjugates: np.ndarray) -> np.ndarray:
    """The same by the products of rows and conjugates at each frequency, where channels are many."""
    q, _, count = conjugates.shape
    found = np.zeros((len(values), len(swept) * count))
    for first in range(0, q, AT_ONCE):
        part = slice(first, first + AT_ONCE)
        found += _real_sums(values[:, part], swept[:, part].transpose(1, 0, 2), conjugates[part])
    return found.reshape(len(values), len(swept), count)


def _real_sums(values: np.ndarray, rows: np.ndarray, conjugates: np.ndarray) -> np.ndarray:
    """Re sum over frequencies of the conjugates of functions (f, q) times rows (q, n, k) times conjugates (q, k, c).

    In real numbers: (f, n c).
    """
    q, n, _ = rows.shape
    real, imaginary = rows.real, rows.imag
    both = np.concatenate([np.concatenate([real, -imaginary], axis=2), np.concatenate([imaginary, real], axis=2)],
                          axis=1)  # fmt: skip
    products = both @ np.concatenate([conjugates.real, conjugates.imag], axis=1)
    products = products.reshape(q, 2, -1)
    return np.ascontiguousarray(values.real) @ products[:, 0] + np.ascontiguousarray(values.imag) @ products[:, 1]
