"""The model of the radiation load of a body that deforms, on top of that of the rigid body.

    x' = A x + B q',   A = [A_r, 0; 0, A_s],   B = [B_r, 0; 0, B_s],   C = [C_r, C_rs; C_sr, C_ss]

A_r, B_r, C_r are the model of the rigid motions as `radiation_identification` finds it without shapes: rigid motions
load the rigid body as if it could not bend. A_s, B_s come from the kernels that the shapes drive, by a singular value
decomposition of their block Hankel matrix and balanced truncation. C_rs, C_sr, C_ss are fitted to the samples of the
kernel at these poles, with no load at constant velocity and passivity of the whole, as there.

Shapes stand here for the combinations of them that make waves of their own, see radiating_motions: what they radiate
as rigid motions do needs no states and is passive with the rigid model.

Passivity ties the couplings to the model of the rigid motions, which can be too much for it: where it has a combination
of motions that makes no waves. Then A_s, B_s come from the kernels of all motions, whose symmetry leaves more modes
that decay; where that does not help, the motions of that group are fitted together, as in radiation_identification,
with other numbers of states where a tenth of the kernel is left.

Source: that of radiation_identification; the shape of the matrices is our own.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.hydro import radiation_identification as rigid_fit
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.radiating_motions import radiating_motions
from fowtlib.components.hydro.radiation_identification import GroupFit, RadiationModel, kept_model, kept_radiation
from fowtlib.language.on_use import OnUse

if TYPE_CHECKING:
    from scipy import linalg
    from scipy.sparse import csgraph
else:
    linalg, csgraph = OnUse("scipy.linalg"), OnUse("scipy.sparse.csgraph")  # not for a model that is kept

Floats = NDArray[np.float64]
_RIGID = 6
_ROUNDS = 150  # of adding conditions of passivity
_MORE = 0, 2, 4, 6, 8  # states for each shape beyond the order, while passivity moves the fit by more than _LITTLE
_LITTLE, _MOVED = 0.05, 0.1  # what is aimed at, and what is taken at most
_FIRST = 2  # how many sizes are tried of shapes without what they radiate as rigid motions do
_MODULES = rigid_fit.__name__, radiating_motions.__module__, __name__  # whose code decides what is found
_SHARE = 1e-3  # of a motion in those that a group is named by
_POINTS = 300, 1200, 4800  # frequencies at which it is asked for, as many as it takes


def bordered_radiation(
    rigid: RadiationModel, omega: Floats, damping: Floats, added_mass: Floats, infinite: Floats, *, order: int,
    passive: bool,
) -> RadiationModel:  # fmt: skip
    """The model of all motions whose block of the rigid ones is `rigid`; `order` states for each shape besides.

    Arrays as of `identify_radiation`, of 6 + k motions.
    """
    damping = 0.5 * (damping + damping.transpose(0, 2, 1))
    scale, used = rigid_fit.used_entries(damping, rigid_fit.THRESHOLD)
    m = len(scale)
    if not used[:, _RIGID:].any():
        empty = np.zeros((m - _RIGID, rigid.states))
        B = np.hstack([rigid.B, empty.T])
        return replace(rigid, B=B, C=np.vstack([rigid.C, empty]), skipped=_skipped(used))
    scaled = np.where(np.outer(used.diagonal(), used.diagonal()), damping / np.outer(scale, scale), 0.0)
    rigid_groups = csgraph.connected_components(used[:_RIGID, :_RIGID], directed=False)[1]
    columns = scaled[:, *np.nonzero(np.triu(used))]
    motions = radiating_motions(omega, scaled, rigid_groups, rigid_fit.is_smooth(omega, columns))
    units = np.append(scale[:_RIGID], np.ones(len(motions.among) - _RIGID))
    time, K = rigid_fit.sampled_kernel(omega, np.where(used, scaled, 0.0), used, None, None)
    by_rigid, known = -motions.back[:_RIGID, _RIGID:], float(time[-1])
    A, B, C, groups = _of_motions(rigid, units, omega, motions.of(scaled), known, by_rigid, order, passive)
    among = motions.among * scale / units[:, None]
    B, C = B @ among, among.T @ C
    entries = rigid_fit.entry_fits(
        omega, damping, added_mass, infinite, time, K * np.outer(scale, scale), used, A, B, C
    )  # fmt: skip
    named = [np.flatnonzero(np.abs(motions.among[list(one.motions)]).max(axis=0) > _SHARE) for one in groups]
    groups = [replace(one, motions=tuple(names.tolist())) for one, names in zip(groups, named, strict=True)]
    return RadiationModel(A, B, C, entries, tuple(groups), _skipped(used))


def _of_motions(
    rigid: RadiationModel, units: Floats, omega: Floats, damping: Floats, known: float, by_rigid: Floats, order: int,
    passive: bool,
) -> tuple[Floats, Floats, Floats, list[GroupFit]]:
    """A, B, C of motions that make waves, and the fit of each group of them; damping (n, 6 + p, 6 + p) as scaled.

    The scaled motion is the motion times its unit; entries of the damping below THRESHOLD are left out.
    known [s]: how long the kernel is known; by_rigid (6, p): what combinations radiate as rigid motions do, besides.
    """
    largest = np.abs(damping).max(axis=0)
    alive = largest.diagonal() > rigid_fit.THRESHOLD
    used = (largest > rigid_fit.THRESHOLD) & np.outer(alive, alive)
    own = np.sqrt(np.where(alive, largest.diagonal(), 1.0))
    time, K = rigid_fit.sampled_kernel(omega, np.where(used, damping / np.outer(own, own), 0.0), used, None, known)
    size = own * units
    count, label = csgraph.connected_components(used, directed=False)
    parts, groups = [], []
    for together in (np.flatnonzero(label == k) for k in range(count)):
        if not alive[together[0]]:
            continue
        if together[-1] < _RIGID:
            states = _states_of(rigid, together)
            found = (
                rigid.A[np.ix_(states, states)], rigid.B[np.ix_(states, together)], rigid.C[np.ix_(together, states)]
            )  # fmt: skip
            group = next(one for one in rigid.groups if one.motions[0] in together)
        else:
            moved, bent = together[together < _RIGID], together[together >= _RIGID]
            besides = by_rigid[np.ix_(moved, bent - _RIGID)] * own[moved, None] / own[bent]
            *found, group = _Border(rigid, together, size, time, K).solved(order, passive, besides)
        parts.append((together, found))
        groups.append(group)
    A = linalg.block_diag(*(a for _, (a, _, _) in parts))
    B, C, row = np.zeros((len(A), len(size))), np.zeros((len(size), len(A))), 0
    for together, (a, b, c) in parts:
        B[row : row + len(a), together], C[together, row : row + len(a)] = b, c
        row += len(a)
    return A, B, C, groups


def _states_of(rigid: RadiationModel, motions: NDArray[np.intp]) -> NDArray[np.intp]:
    """The states that these motions drive."""
    return np.flatnonzero(np.abs(rigid.B[:, motions]).max(axis=1, initial=0.0))


@lru_cache(maxsize=8)
def kept_modal_radiation(data: ModalDatabase, order: int, passive: bool) -> RadiationModel:
    """`bordered_radiation` of a database on the model that its rigid motions have alone; kept in the cache."""
    arrays = data.omega, data.B, data.A, data.A_inf

    def make() -> RadiationModel:
        rigid = data.rigid
        alone = kept_radiation(rigid.omega, rigid.B, rigid.A, rigid.A_inf, order=order, passive=passive)
        return bordered_radiation(alone, *arrays, order=order, passive=passive)

    return kept_model(make, arrays, f"bordered {order} {passive}", *_MODULES)


def _skipped(used: NDArray[np.bool_]) -> tuple[tuple[int, int], ...]:
    return tuple((int(i), int(j)) for i, j in np.argwhere(~used))


@dataclass
class _Rows:
    """Rows of C that are sought in the same basis: `motions` by place in the group; C = given + y basis."""

    motions: list[int]
    given: Floats
    basis: Floats


class _Border:
    """The fit of one group of motions that couple, in scaled motions; `states`: those of the rigid model in it."""

    def __init__(self, rigid: RadiationModel, motions: NDArray[np.intp], scale: Floats, time: Floats, K: Floats):
        self.motions, self.scale, self.time = motions, scale[motions], time
        self.count = int((motions < _RIGID).sum())  # of rigid motions
        self.K = K[:, motions[:, None], motions]
        moved = motions[: self.count]
        self.states = _states_of(rigid, moved)
        b = rigid.B[np.ix_(self.states, moved)] / self.scale[: self.count]
        self.size = float(np.abs(b).max(initial=0.0)) or 1.0
        self.A, self.B = rigid.A[np.ix_(self.states, self.states)], b / self.size
        self.C = rigid.C[np.ix_(moved, self.states)] / self.scale[: self.count, None] * self.size

    def solved(self, order: int, passive: bool, by_rigid: Floats) -> tuple[Floats, Floats, Floats, GroupFit]:
        """A, B, C in the units of the motions, and how well they fit.

        More states than asked, where passivity beside the given model of the rigid motions moves the fit far; then the
        states of a realisation of all motions; both again of shapes that radiate as rigid motions do besides; a fit of
        all motions at once, where those do not help.
        """
        turn = np.eye(len(self.motions))
        parted = bool(by_rigid.any())
        best = self._beside(order, passive, _FIRST if parted else None) if self.count else None
        if best is None and parted:
            turn, whole = self._together(by_rigid), copy(self)
            whole.K = turn.T @ self.K @ turn
            best = whole._beside(order, passive, None)
        if best is None:
            orders = order, order + 2, *range(order - 2, 1, -2)
            A, B, C, group = rigid_fit.identify_group(self.time, self.K, orders, passive, self.motions)
        else:
            C, found, A, b, hankel, dropped = best
            B, names = linalg.block_diag(self.B, b), tuple(int(k) for k in self.motions)
            share = float(hankel[: len(A)].sum() / hankel.sum())
            A = linalg.block_diag(self.A, A)
            slowest = float(linalg.eigvals(A).real.max())
            group = GroupFit(names, len(A), hankel, share, dropped, slowest, found)
            B, C = linalg.solve(turn.T, B.T).T, linalg.solve(turn.T, C)
        size = self.scale.max()
        return A, B * self.scale / size, C * self.scale[:, None] * size, group

    def _together(self, by_rigid: Floats) -> Floats:
        """How rigid motions and shapes that radiate as these do besides make up the motions, of about equal kernels."""
        turn, r = np.eye(len(self.motions)), self.count
        turn[:r, r:] = by_rigid
        first = turn.T @ self.K[0] @ turn
        turn[:, r:] *= np.sqrt(self.K[0].diagonal()[r:] / first.diagonal()[r:])
        return turn

    def _beside(
        self, order: int, passive: bool, tries: int | None
    ) -> tuple[Floats, float, Floats, Floats, Floats, int] | None:
        """C and how passive it is, A and B of the shapes' states, beside the rigid model; None: moved too far."""
        tried = []
        for hankel, dropped, A, b in islice(self._dynamics(order), tries):
            tried.append((*self._passed(A, b, passive), A, b, hankel, dropped))
            if tried[-1][0] < _LITTLE:
                break
        moved, C, found, A, b, hankel, dropped = min(tried, key=lambda one: one[0])
        return None if moved > _MOVED else (C, found, A, b, hankel, dropped)

    def _dynamics(self, order: int) -> Iterator[tuple[Floats, int, Floats, Floats]]:
        """Hankel singular values, how many modes do not decay, A and B of the states that the shapes drive, in turn.

        Of what the shapes drive alone, and of the kernel of all motions, whose symmetry leaves more modes that decay.
        """
        r, p = self.count, len(self.motions)
        most, step = rigid_fit.RAW_STATES * p, self.time[1] - self.time[0]
        for made, first, counts in (
            (_realisation(self.K[:, :, r:], most), 0, [(order + more) * (p - r) for more in _MORE]),
            (rigid_fit.realisation(self.K, most), r, [order * p]),
        ):
            hankel, Ad, *given = made
            raw = rigid_fit.continuous(Ad, *given, step)
            for states in sorted({min(count, len(raw[0])) for count in counts}):
                A, b, _ = rigid_fit.balanced_truncation(*raw, states)
                yield hankel, len(Ad) - len(raw[0]), A, b[:, first:]

    def _passed(self, A: Floats, b: Floats, passive: bool) -> tuple[float, Floats, float]:
        """How far passivity moves the fit, as a share of it (inf: too far); C; and how passive it is."""
        whole, driven = linalg.block_diag(self.A, A), linalg.block_diag(self.B, b)
        free, _ = self._fit(whole, driven, 0)
        for points in _POINTS if passive else ():
            C, moved = self._fit(whole, driven, points)
            if moved > _MOVED:  # and further with more points
                break
            found = rigid_fit.passivity(whole, driven, C)
            if found > rigid_fit.PASSIVE:
                return moved, C, found
        return (np.inf if passive else 0.0), free, rigid_fit.passivity(whole, driven, free)

    def _fit(self, A: Floats, B: Floats, points: int) -> tuple[Floats, float]:
        """C nearest to the samples at these poles, passive at so many points, and how far that moves it."""
        r, known, p = self.count, len(self.states), len(self.motions)
        given = np.zeros((p, len(A)))
        given[:r, :known] = self.C
        rows = [
            _Rows([*range(r)], given[:r], self._basis(A, B, known)),
            _Rows([*range(r, p)], given[r:], self._basis(A, B, 0)),
        ]
        powers = rigid_fit.model_kernel(A, B, np.eye(len(A)), self.time)
        rest = self.K - np.einsum("is,ksj->kij", given, powers)
        target = np.einsum("kis,kjs->ij", rest, powers)
        best = np.concatenate([(target[one.motions] @ one.basis.T).ravel() for one in rows])
        if not points:
            return self._whole(rows, best), 0.0
        span = linalg.null_space(self._symmetric(A, B, rows))
        start, y, cuts, limits = span.T @ best, best, np.zeros((0, span.shape[1])), np.zeros(0)
        y = span @ start
        T = rigid_fit.model_transfer(A, B, np.eye(len(A)), self._frequencies(A, points))
        for _ in range(_ROUNDS):
            load = self._whole(rows, y) @ T
            value, vector = np.linalg.eigh(load + load.conj().transpose(0, 2, 1))
            small = -rigid_fit.PASSIVE * value.max() / 2
            low = np.flatnonzero(rigid_fit.local_minima(value[:, 0]) & (value[:, 0] < -small))
            if not low.size:
                break
            more, least = self._cuts(rows, T[low], vector[low, :, 0], span, small / 4)
            cuts, limits = np.vstack([cuts, more]), np.concatenate([limits, least])
            y = span @ rigid_fit.least_distance(start, cuts, limits)
        return self._whole(rows, y), float(linalg.norm(y - best) / linalg.norm(best))

    def _frequencies(self, A: Floats, points: int) -> Floats:
        return np.abs(linalg.eigvals(A)).mean() * np.tan(np.linspace(0.002, np.pi - 0.002, points) / 2)

    def _basis(self, A: Floats, B: Floats, first: int) -> Floats:
        """Rows that meet C A^-1 B = 0 on the states from `first` on, orthonormal over the samples."""
        own, driven = A[first:, first:], B[first:]
        powers = rigid_fit.model_kernel(own, driven, np.eye(len(own)), self.time)
        gram = np.einsum("kis,kjs->ij", powers, powers)
        free = linalg.null_space(linalg.solve(own, driven).T, rcond=rigid_fit.RAW_TOLERANCE)
        white = linalg.solve_triangular(linalg.cholesky(free.T @ gram @ free), free.T, trans=1)
        return np.hstack([np.zeros((len(white), first)), white])

    def _whole(self, rows: list[_Rows], y: Floats) -> Floats:
        C, at = np.zeros((len(self.motions), rows[0].basis.shape[1])), 0
        for one in rows:
            size = len(one.motions) * len(one.basis)
            C[one.motions] = one.given + y[at : at + size].reshape(len(one.motions), -1) @ one.basis
            at += size
        return C

    def _lines(self, rows: list[_Rows], weights: Floats, columns: NDArray) -> Floats:
        """The line over y of the real part of sum_i weights_i C_i columns."""
        return np.concatenate([np.outer(weights[one.motions], one.basis @ columns).real.ravel() for one in rows])

    def _cuts(
        self, rows: list[_Rows], T: NDArray, vectors: NDArray, span: Floats, small: float
    ) -> tuple[Floats, Floats]:
        """Conditions on y that each of these motions takes energy: line @ y >= limit."""
        lines, limits = [], []
        for through, v in zip(T, vectors, strict=True):
            line = self._lines(rows, v.conj(), through @ v) @ span
            size = linalg.norm(line)
            if size < 1e-9:  # of rigid motions alone, whose model stays as it is
                continue
            own = sum((v[one.motions].conj() @ one.given @ through @ v).real for one in rows)
            lines.append(line / size)
            limits.append((-own - small / 2) / size)
        return np.array(lines).reshape(-1, span.shape[1]), np.array(limits)

    def _symmetric(self, A: Floats, B: Floats, rows: list[_Rows]) -> Floats:
        """Conditions that added mass at rest and the kernel at t = 0 are symmetric, but among the rigid motions."""
        found, p = [], len(self.motions)
        for column in (linalg.solve(A, linalg.solve(A, B)), B):
            for i, j in zip(*np.triu_indices(p, 1), strict=True):
                if j >= self.count:
                    line = self._lines(rows, np.eye(p)[i], column[:, j]) - self._lines(rows, np.eye(p)[j], column[:, i])
                    found.append(line / linalg.norm(line))
        return np.array(found).reshape(-1, sum(len(one.motions) * len(one.basis) for one in rows))


def _realisation(K: Floats, most: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Hankel singular values and Ad, B, C with C Ad^k B = K_k, for samples (n, p, s) of more outputs than inputs."""
    n, p, s = (len(K) + 1) // 2, K.shape[1], K.shape[2]
    index = np.arange(n)[:, None] + np.arange(n)
    H = K[index].transpose(0, 2, 1, 3).reshape(n * p, n * s)
    value, right = linalg.eigh(H.T @ H)
    largest = np.argsort(-value)
    hankel = np.sqrt(np.maximum(value[largest], 0.0))
    keep = largest[: min(most, int((hankel > rigid_fit.RAW_TOLERANCE * hankel[0]).sum()))]
    root = np.sqrt(hankel[: len(keep)])
    observability = H @ right[:, keep] / root
    Ad = np.linalg.lstsq(observability[:-p], observability[p:], rcond=None)[0]
    return hankel, Ad, (right[:s, keep] * root).T, observability[:p]
