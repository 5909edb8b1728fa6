"""What random processes drive in a model, at many frequencies, and the drag that suits the response to it.

The covariance of the inputs of all laws of drag is Q G Q^H with the sums G of a a^H over frequencies and channels, a
the amplitudes of the modes and Q the inputs by these, and with what the processes put into the laws directly: so an
iteration costs products with few rows, and nothing of the size of laws times frequencies times channels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fowtlib.frequency.drag import gains_of
from fowtlib.language.operators import eigenvectors
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel, Resolvent, times


@dataclass(frozen=True, eq=False)
class Process:
    """A random process: its spectrum [unit^2 s/rad] and what it drives, complex (q, inputs, channels), over omega."""

    density: Callable[[np.ndarray], np.ndarray]
    drive: Callable[[np.ndarray], np.ndarray]


Processes = Mapping[str, Process]
"""The random processes by path."""


@dataclass(frozen=True, eq=False)
class Driving:
    """What one process drives: numbers of the inputs, and their amplitudes (inputs, q, k) by its channels.

    weighted: the same by channels that are independent, with a variance of one at each frequency.
    """

    inputs: np.ndarray
    drive: np.ndarray
    weighted: np.ndarray

    def by(self, matrix: np.ndarray, drive: np.ndarray) -> np.ndarray | None:
        """A matrix (m, all inputs) times a drive of these inputs, (m, q, k); None where it is nothing."""
        columns = matrix[:, self.inputs]
        return times(columns, drive) if columns.any() else None


class Grid:
    """What does not change with the gains of drag, at frequencies (q,) [Hz].

    spectra: of the processes (q, channels, channels) per Hz. driving: what they drive.
    """

    def __init__(self, excited: ExcitedModel, frequency: np.ndarray, spectra: Mapping[str, np.ndarray],
                 driving: Mapping[str, Driving]):  # fmt: skip
        self.excited, self.frequency, self.omega = excited, frequency, 2 * np.pi * frequency
        self.spectra, self.driving = dict(spectra), dict(driving)

    @staticmethod
    def of(excited: ExcitedModel, processes: Processes, frequency: np.ndarray) -> Grid:
        """That of some processes."""
        omega, widths = 2 * np.pi * frequency, frequency_widths(frequency)[:, None, None]
        spectra: dict[str, np.ndarray] = {}
        driving: dict[str, Driving] = {}
        for path, process in processes.items():
            density = 2 * np.pi * np.asarray(process.density(omega))
            spectra[path] = density.reshape(len(density), *(density.shape[1:] or (1, 1)))
            drive = process.drive(omega)
            inputs = np.flatnonzero(drive.any(axis=(0, 2)))
            drive = drive[:, inputs]
            weighted = drive @ _roots(spectra[path] * widths)
            both = (np.ascontiguousarray(block.transpose(1, 0, 2), dtype=complex) for block in (drive, weighted))
            driving[path] = Driving(inputs, *both)
        return Grid(excited, frequency, spectra, driving)

    def with_model(self, excited: ExcitedModel) -> Grid:
        """The same with another model that has the same inputs."""
        return Grid(excited, self.frequency, self.spectra, self.driving)

    def thinned(self, step: int) -> Grid:
        """Every so many frequencies of it, each as what stands for its neighbours."""
        frequency = self.frequency[::step]
        share = np.sqrt(frequency_widths(frequency) / frequency_widths(self.frequency)[::step])[None, :, None]
        driving = {path: Driving(one.inputs, one.drive[:, ::step], one.weighted[:, ::step] * share)
                   for path, one in self.driving.items()}  # fmt: skip
        return Grid(self.excited, frequency, {path: S[::step] for path, S in self.spectra.items()}, driving)

    @cached_property
    def errors(self) -> np.ndarray | None:
        """Those of the realizations of operators; see Operators.errors."""
        operators = self.excited.linear.operators
        return operators.errors(self.omega) if operators is not None else None

    def answers(self, linear: LinearModel, outputs: int | None = None) -> dict[str, np.ndarray]:
        """Transfer functions (q, outputs, channels) by process, of the first outputs or of all."""
        linear = linear.first(outputs)
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        resolvent, operators, found = Resolvent(self.omega, A), linear.operators, {}
        for path, one in self.driving.items():
            amplitudes = resolvent.amplitudes(times(B[:, one.inputs], one.drive))
            y = times(D[:, one.inputs], one.drive)
            if operators is not None:
                direct = times(operators.D_input[:, one.inputs], one.drive)
                more, signals = operators.added(resolvent, amplitudes, direct, self.errors)
                amplitudes, y = amplitudes + more, y + times(operators.D_output, signals)
            y += times(C @ resolvent.shapes, amplitudes)
            found[path] = np.ascontiguousarray(y.transpose(1, 0, 2))
        return found

    @cached_property
    def _direct(self) -> dict[str, tuple[np.ndarray | None, np.ndarray | None, np.ndarray | None]]:
        """By process, rates of the states, inputs of the laws, and sums of products of these, by the drive alone."""
        n, m, found = self.excited.driven, self.excited.results, {}
        B, D = self.excited.linear.matrices["B"], self.excited.linear.matrices["D"]
        for path, one in self.driving.items():
            rates = one.by(B, one.weighted) if one.inputs.size >= len(B) else None  # few inputs are taken later
            u = one.by(D[m:, :n], one.weighted)
            found[path] = rates, u, None if u is None else _products(u, u).real
        return found

    def gains(self, gains: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Gains of the laws of drag that suit the response with these gains: from the covariance of their inputs."""
        excited, linear = self.excited, self.excited.linear
        n, m = excited.driven, excited.results
        loop = excited.loop(gains)
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        basis = eigenvectors(A + B[:, n:] @ loop @ C[m:]) if linear.operators is None and len(A) else None
        covariance = self._covariance(loop, *basis) if basis is not None else self._covariance_by_answers(gains)
        return gains_of([covariance[place, place] for _, place in excited.laws],
                        [excited.means[place] for _, place in excited.laws])  # fmt: skip

    def _covariance(self, loop: np.ndarray, roots: np.ndarray, right: np.ndarray, left: np.ndarray) -> np.ndarray:
        """Of the inputs of all laws, by the eigenvectors with them in the loop."""
        excited, n, m = self.excited, self.excited.driven, self.excited.results
        A, B, C, D = (excited.linear.matrices[name] for name in "ABCD")
        through = np.eye(len(loop)) + D[m:, n:] @ loop
        shapes, by_laws = through @ C[m:] @ right, B[:, n:] @ loop
        shares, total = (1 / (1j * self.omega - roots[:, None]))[:, :, None], np.zeros((len(loop), len(loop)))
        for path, one in self.driving.items():
            rates, u, own = self._direct[path]
            if rates is not None:
                amplitudes = times(left, rates if u is None else rates + times(by_laws, u))
            else:
                amplitudes = times(left @ B[:, one.inputs], one.weighted)
                if u is not None:
                    amplitudes += times(left @ by_laws, u)
            amplitudes *= shares
            total += (shapes @ _products(amplitudes, amplitudes) @ shapes.conj().T).real
            if u is not None:
                crossed = (through @ _products(u, amplitudes) @ shapes.conj().T).real
                total += crossed + crossed.T + through @ own @ through.T
        return total

    def _covariance_by_answers(self, gains: Sequence[np.ndarray]) -> np.ndarray:
        """The same by the inputs themselves at all frequencies: with operators, and without eigenvectors."""
        linear, m = self.excited.with_gains(gains), self.excited.results
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        resolvent, operators = Resolvent(self.omega, A), linear.operators
        total = np.zeros((len(C) - m,) * 2)
        for one in self.driving.values():
            amplitudes = resolvent.amplitudes(times(B[:, one.inputs], one.weighted))
            u = times(D[m:, one.inputs], one.weighted)
            if operators is not None:
                direct = times(operators.D_input[:, one.inputs], one.weighted)
                more, signals = operators.added(resolvent, amplitudes, direct, self.errors)
                amplitudes, u = amplitudes + more, u + times(operators.D_output[m:], signals)
            u += times(C[m:] @ resolvent.shapes, amplitudes)
            total += _products(u, u).real
        return total


def frequency_widths(frequency: np.ndarray) -> np.ndarray:
    """What each frequency stands for [Hz]."""
    steps = np.diff(frequency)
    return (np.append(steps, 0.0) + np.append(0.0, steps)) / 2


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sums of a b^H over frequencies and channels, of (n, q, k) and (m, q, k)."""
    return a.reshape(len(a), -1) @ b.reshape(len(b), -1).conj().T


def _roots(S: np.ndarray) -> np.ndarray:
    """R (q, k, k) with R R^H = S, of Hermitian S without negative eigenvalues."""
    if S.shape[1] == 1:
        return np.sqrt(np.maximum(S.real, 0.0))
    values, vectors = np.linalg.eigh(S)
    return vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
