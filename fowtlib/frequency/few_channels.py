"""Fields of turbulence by few channels: the sums of what is at many places that the model can tell from each other.

The wind across a turning rotor has five channels a ring and component, hundreds of them, of which results see a few
sums: those that turn and push the hub, and bend blades in their first modes. With channels c of the covariance L L^T,
and responses h of a result at some frequencies, these are the eigenvectors V of the sum of (h L)^H (h L) over
frequencies and results, each over its variance: c = L V V^T inv(L) c, but for what has less than LEFT_OUT of the
variance of any result, of its rate, and of any velocity of drag. Spectra of the sums are exact.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from functools import cache

import numpy as np

from fowtlib.frequency.drag import gains_of
from fowtlib.frequency.driven import Driving, Grid, frequency_widths
from fowtlib.frequency.grid import response_frequencies
from fowtlib.frequency.settling import GUESS
from fowtlib.language.component import Component
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel
from fowtlib.solving.random_fields import density

LEFT_OUT = 1e-3  # of the variance by a field
FEWEST = 12  # channels that are worth it
SAMPLES = 2 * np.pi * np.geomspace(3e-3, 1.0, 6)  # rad/s, at which the laws of coherence are told from each other
THINNED = 2  # of so many frequencies of a coarse grid one


Sums = dict[int, tuple[np.ndarray, np.ndarray]]
"""T and P^T (channels, sums) of c = T P c, by the number of a field."""


def with_few_channels(excited: ExcitedModel, root: Component, beside: Container[str] = (),
                      sums: Sums | None = None) -> ExcitedModel:  # fmt: skip
    """The model with sums of channels in place of these, for the fields of a run that fluctuate across the flow too.

    beside: processes that have channels of signals beside those of a field; they are left as they are, and so are
    fields with u alone and components of few channels. What was found once for a law of coherence is kept with the
    model.
    """
    common = {}
    for k, (columns, places) in enumerate(excited.fields):
        if columns.stop - columns.start < FEWEST or places[0].process(root) in beside:
            continue
        S = density(places, root, SAMPLES)
        strengths = np.trace(S, axis1=1, axis2=2).real
        if strengths.any():
            common[k] = (S / strengths[:, None, None]).sum(axis=0).real
    across = {excited.fields[k][1][0].owner for k in common if excited.fields[k][1][0].part}
    common = {k: C for k, C in common.items() if excited.fields[k][1][0].owner in across}
    if not common:
        return excited
    key = tuple((k, np.round(C, 9).tobytes()) for k, C in common.items())
    if key not in excited.compact:
        excited.compact.clear()
        excited.compact[key] = _compact(excited, common, root, {} if sums is None else sums)
    return excited.compact[key]


def _compact(excited: ExcitedModel, common: dict[int, np.ndarray], root: Component, sums: Sums) -> ExcitedModel:
    """The model with the sums of channels that matter, by their covariances."""
    linear = excited.linear
    taken, fields, bases, labels, end = [], [], {}, [], 0
    if missing := [k for k in common if k not in sums]:
        responses = _Responses(excited, root)
        sums |= {k: responses.sums(k, common[k]) for k in missing}

    def keep(columns: slice, factor: np.ndarray | None = None) -> slice:
        """Columns as they are, or mixed; where they come to stand."""
        nonlocal end
        count = columns.stop - columns.start if factor is None else factor.shape[1]
        names = linear.inputs[columns]
        taken.append((columns, factor))
        labels.extend(names if factor is None else [f"{names[0]} sum {k}" for k in range(count)])
        end += count
        return slice(end - count, end)

    keep(slice(0, excited.fields[0][0].start))
    for k, (columns, places) in enumerate(excited.fields):
        factor = None
        if k in common:
            factor, bases[k] = sums[k]
        fields.append((keep(columns, factor), places))
    keep(slice(excited.fields[-1][0].stop, len(linear.inputs)))

    def mixed(matrix: np.ndarray) -> np.ndarray:
        return np.hstack([matrix[:, place] if factor is None else matrix[:, place] @ factor for place, factor in taken])

    A, B, C, D = (linear.matrices[name] for name in "ABCD")
    operators = linear.operators
    if operators is not None:
        operators = replace(operators, D_input=mixed(operators.D_input))
    made = LinearModel(A, mixed(B), C, mixed(D), linear.states, labels, linear.outputs, linear.units, operators)
    return replace(excited, linear=made, fields=tuple(fields), bases=bases)


class _Responses:
    """Responses to all channels of fields at some frequencies, with a guess of the drag."""

    def __init__(self, excited: ExcitedModel, root: Component):
        self.excited, self.root = excited, root
        means = [excited.means[place] for _, place in excited.laws]
        self.linear = excited.with_gains(gains_of([GUESS**2 * np.eye(len(mean)) for mean in means], means))
        self.frequency = response_frequencies(self.linear.first(0).modes(), coarse=True)[::THINNED]
        self.omega = 2 * np.pi * self.frequency
        self._of, self._squares = cache(self._found), cache(self._mean_squares)

    def sums(self, k: int, common: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """T and P^T (channels, sums) of c = T P c, for the channels of one field with their covariance."""
        H, S = self._of(k)
        strengths, vectors = np.linalg.eigh(common)
        there = strengths > 1e-12 * strengths[-1]
        root, vectors = np.sqrt(strengths[there]), vectors[:, there]
        spectrum = np.trace(S, axis1=1, axis2=2).real * frequency_widths(self.frequency)
        felt = (H @ (vectors * root)) * np.sqrt(spectrum)[:, None, None]
        felt = np.concatenate([felt, felt * self.omega[:, None, None]], axis=1)  # values and rates: (q, m, channels)
        size = self._squares(self.excited.fields[k][1][0].owner)
        felt = (felt[:, size > 0] / np.sqrt(size[size > 0])[:, None]).transpose(1, 0, 2)
        whole = felt.reshape(-1, felt.shape[2])
        V = np.linalg.eigh((whole.conj().T @ whole).real)[1][:, ::-1]
        parts = (np.abs(felt @ V) ** 2).sum(axis=1)  # of each result by each vector
        beyond = np.cumsum(parts[:, ::-1], axis=1)[:, ::-1].max(axis=0, initial=0.0)
        V = V[:, : max(int(np.count_nonzero(beyond > LEFT_OUT)), 1)]
        return (vectors * root) @ V, (vectors / root) @ V

    def _found(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Transfer functions (q, m, channels) of results and velocities of drag, and spectra, of one field."""
        columns, places = self.excited.fields[k]
        inputs = np.arange(columns.start, columns.stop)
        drive = np.repeat(np.eye(len(inputs), dtype=complex)[:, None], len(self.omega), axis=1)
        spectrum = density(places, self.root, self.omega)
        power = spectrum * frequency_widths(self.frequency)[:, None, None]
        grid = Grid(self.excited, self.frequency, {}, {"": Driving(inputs, drive, power)})
        return grid.answers(self.linear)[""], spectrum

    def _mean_squares(self, owner: str) -> np.ndarray:
        """Of results and of rates, by all components of the field of an owner."""
        total = 0.0
        for k, (_, places) in enumerate(self.excited.fields):
            if places[0].owner == owner:
                H, S = self._of(k)
                square = ((H @ S) * H.conj()).sum(axis=2).real * frequency_widths(self.frequency)[:, None]
                total = total + np.concatenate([square.sum(axis=0), self.omega**2 @ square])
        return total
