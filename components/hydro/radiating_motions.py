"""The motions by which a body that deforms makes waves: the rigid ones, and few combinations of its shapes.

Most of what shapes radiate is what rigid motions radiate: a column moves sideways at the water level in many of them.
With v the velocities of the six rigid motions and of k shapes, scaled,

    v' = E v,   E = [1, W; 0, Z^T],   damping B ~ E^T B' E,   kernel K ~ E^T K' E

W is what each shape radiates as rigid motions do, by least squares over the frequencies; Z^T are p <= k combinations of
what is left, by its principal directions, as many as the damping needs. A model of the kernel of v' is one of v, with
B' E and E^T C', and passive if that is. Principal directions of equal size, as of a hull with three legs, are turned
until each goes with one group of rigid motions, so that groups that symmetry makes are not mixed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_RIGID = 6
_NEAR = 0.05  # largest change of an entry of the damping over sqrt(max B_ii max B_jj) by what is left out
_LEAST = 0.01  # rigid motions together that radiate less than this share of the most are not used for W
_ALIKE = 0.98  # ratio of directions that are taken or left together
_APART = 0.618  # ratio of weights that tells the groups of rigid motions


@dataclass(frozen=True)
class RadiatingMotions:
    """E (6 + p, 6 + k) of the head of the module, and its right inverse (6 + k, 6 + p), of scaled motions."""

    among: Floats
    back: Floats

    def of(self, matrices: Floats) -> Floats:
        """B' or K' (n, 6 + p, 6 + p) of (n, 6 + k, 6 + k)."""
        return self.back.T @ matrices @ self.back


def radiating_motions(omega: Floats, damping: Floats, groups: NDArray[np.intp], smooth: bool) -> RadiatingMotions:
    """Of a scaled, symmetric damping (n, 6 + k, 6 + k) at omega (n,); groups (6,): number of each rigid motion's group.

    As few combinations as keep all entries of the damping to 5 %; of a damping that is not smooth between its
    frequencies, whose means say little, the shapes themselves.
    """
    found = RadiatingMotions(np.eye(damping.shape[1]), np.eye(damping.shape[1]))
    if not smooth:
        return found
    weight = np.gradient(omega)
    mean = np.einsum("n,nij->ij", weight, damping)
    by_rigid = np.linalg.lstsq(mean[:_RIGID, :_RIGID], mean[:_RIGID, _RIGID:], rcond=_LEAST)[0]
    rest = np.vstack([-by_rigid, np.eye(len(mean) - _RIGID)])  # shapes without what they radiate as rigid motions
    size, direction = np.linalg.eigh(rest.T @ mean @ rest)
    size, direction = size[::-1], direction[:, ::-1]
    for count in range(len(size) + 1):
        if 0 < count < len(size) and size[count] > _ALIKE * size[count - 1]:
            continue
        kept = _told_apart(weight, damping[:, :_RIGID] @ (rest @ direction[:, :count]), groups)
        turned = direction[:, :count] @ kept
        rigid = np.eye(_RIGID, len(mean)) + np.hstack([np.zeros((_RIGID, _RIGID)), by_rigid])
        shapes = np.hstack([np.zeros((count, _RIGID)), turned.T])
        found = RadiatingMotions(
            np.vstack([rigid, shapes]), np.hstack([np.eye(len(mean), _RIGID), rest @ turned])
        )
        if np.abs(found.among.T @ found.of(damping) @ found.among - damping).max() < _NEAR:
            break
    return found


def _told_apart(weight: Floats, coupling: Floats, groups: NDArray[np.intp]) -> Floats:
    """A turn (p, p) of combinations, so that each goes with one group of rigid motions; coupling (n, 6, p)."""
    total = np.zeros((coupling.shape[2],) * 2)
    for k, group in enumerate(np.unique(groups)):
        total += _APART**k * np.einsum("n,nai,naj->ij", weight, *[coupling[:, groups == group]] * 2)
    return np.linalg.eigh(total)[1]
