"""Fields of turbulence by few channels: the sums of what is at many places that the model can tell from each other.

The wind across a turning rotor has five channels a ring and component, hundreds of them, of which loads and motions see
a few sums, those that bend blades in their first modes and turn and push the hub. With channels of the covariance
L L^T that the rows m of the model take in, these are the first right singular vectors V of the rows m L over their own
lengths: c = L V V^T inv(L) c, but for a part that is less than LEFT_OUT of what drives any state or result. What they
are is found in the densities at some frequencies; the spectra of the sums are exact at all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fowtlib.language.component import Component
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel
from fowtlib.solving.random_fields import density

LEFT_OUT = 1e-3  # of the amplitude of what drives a state or a result, or 1e-2 of what the wind along does there
BESIDE = 1e-2
FEWEST = 12  # channels that are worth it
SAMPLES = 2 * np.pi * np.geomspace(3e-3, 1.0, 6)  # rad/s


def with_few_channels(excited: ExcitedModel, root: Component) -> ExcitedModel:
    """The model with sums of channels in place of those of components across the flow, for the field of a run.

    The model itself where it has few. What was found once for a law of coherence is kept with the model.
    """
    chosen = [k for k, (columns, places) in enumerate(excited.fields)
              if places[0].part and columns.stop - columns.start >= FEWEST]  # fmt: skip
    common = {}
    for k in chosen:
        S = density(excited.fields[k][1], root, SAMPLES)
        strengths = np.trace(S, axis1=1, axis2=2).real
        if strengths.any():
            common[k] = (S / strengths[:, None, None]).sum(axis=0).real
    if not common:
        return excited
    key = tuple((k, np.round(C, 9).tobytes()) for k, C in common.items())
    if key not in excited.compact:
        excited.compact.clear()
        excited.compact[key] = _compact(excited, common)
    return excited.compact[key]


def _compact(excited: ExcitedModel, common: dict[int, np.ndarray]) -> ExcitedModel:
    """The model with the sums of channels that matter, by their covariances."""
    linear = excited.linear
    blocks = [linear.matrices["B"], linear.matrices["D"]]
    if linear.operators is not None:
        blocks.append(linear.operators.D_input)
    rows = np.vstack(blocks)
    taken, fields, bases, labels, end = [], [], {}, [], 0

    def keep(columns: slice, factor: np.ndarray | None = None) -> slice:
        """Columns as they are, or mixed; where they come to stand."""
        nonlocal end
        count = columns.stop - columns.start if factor is None else factor.shape[1]
        names = linear.inputs[columns]
        taken.append((columns, factor))
        labels.extend(names if factor is None else [f"{names[0]} sum {k}" for k in range(count)])
        end += count
        return slice(end - count, end)

    first = excited.fields[0][0].start
    keep(slice(0, first))
    for k, (columns, places) in enumerate(excited.fields):
        factor = None
        if k in common:
            along = next(one for one, other in excited.fields
                         if other[0].owner == places[0].owner and other[0].part == 0)  # fmt: skip
            factor, bases[k] = _sums(rows[:, columns], common[k], np.linalg.norm(rows[:, along], axis=1))
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


def _sums(rows: np.ndarray, common: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """T and P^T (channels, k) of c = T P c, for rows (m, channels) of the model; along (m,): those of another process."""
    strengths, vectors = np.linalg.eigh(common)
    there = strengths > 1e-12 * strengths[-1]
    root, vectors = np.sqrt(strengths[there]), vectors[:, there]
    felt = rows @ (vectors * root)
    size = np.maximum(np.linalg.norm(felt, axis=1), BESIDE * along * np.sqrt(np.trace(common) / len(common)))
    felt = felt[size > 0] / size[size > 0, None]
    _, parts, V = np.linalg.svd(felt, full_matrices=False)
    beyond = np.append(np.cumsum((parts**2)[::-1])[::-1], 0.0)  # what is left out with so many of them
    V = V[: max(int(np.argmax(beyond < LEFT_OUT**2)), 1)]
    return (vectors * root) @ V.T, (vectors / root) @ V.T
