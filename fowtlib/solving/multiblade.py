"""Multi-blade coordinates: what the blades of a rotor do, seen from the frame that does not turn.

With the azimuths psi_b = psi + 2 pi b / N of the N blades of a ring, a quantity q_b of each of them is

    q_b = q_collective + q_cosine cos(psi_b) + q_sine sin(psi_b) + ...

(R. P. Coleman and A. M. Feingold, NACA Report 1351, 1958; G. Bir, NREL/CP-500-42553, 2008). Three blades have these
three; more have pairs with the multiples of the azimuth too, and an even number the differential one, which changes
its sign from blade to blade. In these coordinates the equations of a rotor whose blades are alike, on a support of any
kind, do not depend on the azimuth; what still does (gravity and shear on blades that are bent, the dam in front of the
tower) is small, and is averaged over a revolution. Two blades have no such coordinates: their rotor is periodic to
anyone, and they keep those of their own.

With x = T(psi) y and T' = dT/dpsi the product S = inv(T) T' does not depend on psi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.solving.engines.symmetry import counterparts

LEAST = 3  # blades of a ring that has multi-blade coordinates


@dataclass(frozen=True)
class Turn:
    """A rotor that turns: the number of its azimuth among the states, and the change of all states with it."""

    azimuth: int
    direction: np.ndarray


def multiblade_names(count: int) -> list[str]:
    """What the coordinates of a ring of `count` parts are called."""
    names = ["collective"]
    for order in range(1, (count - 1) // 2 + 1):
        suffix = "" if order == 1 else f"_{order}"
        names += [f"cosine{suffix}", f"sine{suffix}"]
    return names if count % 2 else [*names, "differential"]


def multiblade_matrix(count: int, azimuth: float) -> tuple[np.ndarray, np.ndarray]:
    """T (parts, coordinates) at an azimuth [rad] of the first part, and its derivative by the azimuth."""
    psi = azimuth + 2 * np.pi * np.arange(count) / count
    columns, slopes = [np.ones(count)], [np.zeros(count)]
    for order in range(1, (count - 1) // 2 + 1):
        cosine, sine = np.cos(order * psi), np.sin(order * psi)
        columns += [cosine, sine]
        slopes += [-order * sine, order * cosine]
    if count % 2 == 0:
        columns.append((-1.0) ** np.arange(count))
        slopes.append(np.zeros(count))
    return np.stack(columns, axis=1), np.stack(slopes, axis=1)


def multiblade_inverse(count: int, azimuth: float) -> np.ndarray:
    """The inverse of T (coordinates, parts): the columns of T are orthogonal."""
    T = multiblade_matrix(count, azimuth)[0]
    return (T / (T**2).sum(axis=0)).T


@dataclass(frozen=True, eq=False)
class Ring:
    """Parts in a ring: number of the state that is their azimuth, their paths.

    states, rows: numbers of the states, and of the algebraic equations, that are the same but for the part: (k, parts).
    """

    azimuth: int
    parts: tuple[str, ...]
    states: np.ndarray
    rows: np.ndarray

    @property
    def count(self) -> int:
        """Number of the parts."""
        return len(self.parts)


class Multiblade:
    """The multi-blade coordinates of a model about a state in which rotors turn (`turns`, fowtlib.solving.turning)."""

    def __init__(self, dae: FlatDAE, turns: Sequence[Turn]):
        self.dae, self.turns = dae, list(turns)
        numbers = {dae.x[i].element_hash(): i for i in range(dae.x.shape[0])}
        states, rows = [item.path for item in dae.states], list(dae.residual_paths)
        azimuths = {turn.azimuth for turn in turns}
        self.rings = [
            Ring(azimuth, tuple(ring.parts), *(_table(counterparts(paths, ring.parts), len(ring.parts))
                                               for paths in (states, rows)))
            for ring in dae.symmetries
            if (azimuth := numbers.get(ring.angle.element_hash())) in azimuths and len(ring.parts) >= LEAST
        ]  # fmt: skip

    def __bool__(self) -> bool:
        return any(ring.states.size for ring in self.rings)

    @property
    def two_bladed(self) -> list[str]:
        """Parts of the rings that turn and have fewer than three parts, with states of their own."""
        numbers = {self.dae.x[i].element_hash(): i for i in range(self.dae.x.shape[0])}
        azimuths = {turn.azimuth for turn in self.turns}
        parts = [part for ring in self.dae.symmetries for part in ring.parts
                 if len(ring.parts) < LEAST and numbers.get(ring.angle.element_hash()) in azimuths]  # fmt: skip
        return [part for part in parts if any(item.path.startswith(f"{part}.") for item in self.dae.states)]

    def states(self, x: np.ndarray) -> np.ndarray:
        """T (n, n) of the states, at the azimuths in x."""
        T = np.eye(self.dae.x.numel())
        for ring in self.rings:
            _put(T, ring.states, multiblade_matrix(ring.count, x[ring.azimuth])[0])
        return T

    def inverse(self, x: np.ndarray) -> np.ndarray:
        """The inverse of T (n, n)."""
        T = np.eye(self.dae.x.numel())
        for ring in self.rings:
            _put(T, ring.states, multiblade_inverse(ring.count, x[ring.azimuth]))
        return T

    def slopes(self, x: np.ndarray, turn: Turn) -> np.ndarray:
        """dT/dpsi (n, n) by the azimuth of one rotor."""
        T = np.zeros((self.dae.x.numel(),) * 2)
        for ring in self.rings:
            if ring.azimuth == turn.azimuth:
                _put(T, ring.states, multiblade_matrix(ring.count, x[ring.azimuth])[1])
        return T

    def equations(self, x: np.ndarray) -> np.ndarray:
        """The matrix (m, m) that takes algebraic equations to the frame that does not turn."""
        R = np.eye(len(self.dae.residual_paths))
        for ring in self.rings:
            _put(R, ring.rows, multiblade_inverse(ring.count, x[ring.azimuth]))
        return R

    def from_states(self, x: np.ndarray) -> np.ndarray:
        """The coordinates y of x = T y, with the azimuths of x."""
        return self.inverse(x) @ x

    def to_states(self, y: np.ndarray) -> np.ndarray:
        """The states x = T y."""
        return self.states(y) @ y

    def paths(self) -> list[str]:
        """What the coordinates are called: `rotor.blade_1.flap` and so on become `rotor.blade_collective.flap`, ..."""
        paths = [item.path for item in self.dae.states]
        for ring in self.rings:
            names = multiblade_parts(ring.parts)
            for numbers in ring.states:
                first = self.dae.states[numbers[0]].path
                for number, name in zip(numbers.tolist(), names, strict=True):
                    paths[number] = first.replace(f"{ring.parts[0]}.", f"{name}.", 1)
        return paths


def multiblade_parts(parts: Sequence[str]) -> list[str]:
    """What stands in place of the parts of a ring: `rotor.blade_collective`, `rotor.blade_cosine`, ..."""
    stem = parts[0].rstrip("0123456789[]._")
    return [f"{stem}_{name}" for name in multiblade_names(len(parts))]


def _table(groups: list[list[int]], count: int) -> np.ndarray:
    return np.array(groups, dtype=int).reshape(-1, count)


def _put(matrix: np.ndarray, groups: np.ndarray, block: np.ndarray) -> None:
    """The block in the rows and columns of every group."""
    if groups.size:
        matrix[groups[:, :, None], groups[:, None, :]] = block
