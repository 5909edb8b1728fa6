"""A small state-space model of the radiation load, identified from B(omega), A(omega) and A_inf.

    x' = A x + B q',     load on the body = -A_inf q'' - C x,     C exp(A t) B ~ K(t)

for the body's velocity q' (surge, sway, heave, roll, pitch, yaw). Steps:

1. Entries of K that are zero by symmetry, or below a threshold, are left out. What remains falls into groups of coupled
   motions (a spar: surge-pitch, sway-roll, heave). Each group gets *one* model with all its inputs and outputs and
   `order` states per motion. Its states serve all entries, since the same waves carry them: for OC3-Hywind four states
   fit K11, K15 and K55 together better than two states for each of the four entries do.
2. Each motion is scaled by the square root of its largest damping; the sampled kernel fills a block Hankel matrix; its
   singular value decomposition gives a realisation of high order (Kung 1978). The samples C Ad^k B = K(k dt) belong to
   the continuous model with A = log(Ad) / dt exactly; there is no feedthrough. Modes that do not decay are dropped.
3. Balanced truncation to the wanted order by the square-root method (Moore 1981; Laub et al. 1987) keeps it stable.
4. The poles and the input matrix stay; C is fitted again to the kernel, by least squares under two conditions that
   physics sets and truncation violates: no load at constant velocity, C A^-1 B = 0, as B(0) = 0; and passivity, the
   Hermitian part of C (i omega - A)^-1 B is positive semidefinite at all frequencies, so that the model never feeds
   energy to the body. Passivity is a set of linear conditions v* C (i omega - A)^-1 B v >= 0, added where it fails
   until it holds. `passive=False` leaves it out, for a closer fit.

Sources: Kung (1978), 12th Asilomar Conf.; Perez and Fossen, Modeling, Identification and Control 30 (2009) 1-15;
Taghipour, Perez and Moan, Ocean Engineering 35 (2008) 684-705; Lawson and Hanson (1974), ch. 23 (least distance).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.retardation import added_mass_from_kernel, bandwidth, retardation_kernel, spline_between
from fowtlib.language.cache import cached, sources
from fowtlib.language.on_use import OnUse

if TYPE_CHECKING:
    from scipy import linalg
else:
    linalg = OnUse("scipy.linalg")  # not for a model that is kept

Floats = NDArray[np.float64]

THRESHOLD = 0.01  # an entry with |B_ij| below this share of sqrt(max B_ii max B_jj) is left out
NEGLIGIBLE = 1e-4  # a motion whose max B_ii is below this share of the largest (of its kind) is left out
SAMPLES = 360  # of the kernel at most
_FEWEST_SAMPLES = 20
_DECAYED = 1e-6  # the kernel ends where so little of its energy is left
RAW_TOLERANCE = 1e-5  # Hankel singular values below this share of the first are noise
RAW_STATES = 16  # per motion, of the realisation before truncation
_PASSIVITY_POINTS = 300, 1200, 4800  # as many as it takes: narrow dips hide between few
PASSIVE = -1e-6  # of the largest eigenvalue
_PASSIVITY_ROUNDS = 40
_LEFT = 0.1  # of the kernel, from which other numbers of states are tried
_SMOOTH = 0.2  # of the largest damping, least that a spline misses of one that its frequencies do not resolve
_EVEN = 0.9  # mean over widest step of frequencies that count as even


@dataclass(frozen=True)
class EntryFit:
    """How well one entry (i, j), counted from 0, of the radiation is met by the state-space model.

    r2                share of the variance of the kernel over time that the model explains
    damping_error     ||B_model - B|| / ||B|| over the frequencies of the data
    added_mass_error  ||A_model - A|| / ||A - A_inf||, same; None without A
    consistency       the same for the sampled kernel itself, without a model: the quality of the data
    """

    i: int
    j: int
    r2: float
    damping_error: float
    added_mass_error: float | None
    consistency: float | None


@dataclass(frozen=True)
class GroupFit:
    """The model of one group of coupled motions (numbers from 0).

    hankel             singular values of the block Hankel matrix of the scaled kernel
    hankel_share       sum of the first `states` of them over the sum of all
    dropped            modes of the realisation of high order that did not decay
    slowest            largest real part of the poles [rad/s], negative: stable
    passivity          smallest eigenvalue of Re K(i omega) over its largest; above -1e-6 counts as passive
    """

    motions: tuple[int, ...]
    states: int
    hankel: Floats = field(repr=False)
    hankel_share: float
    dropped: int
    slowest: float
    passivity: float


@dataclass(frozen=True)
class RadiationModel:
    """x' = A x + B q', load = C x, and how well it fits. `skipped` lists the entries (i, j) that are left out."""

    A: Floats
    B: Floats
    C: Floats
    entries: tuple[EntryFit, ...]
    groups: tuple[GroupFit, ...]
    skipped: tuple[tuple[int, int], ...]

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.A)

    @property
    def stable(self) -> bool:
        """All poles decay (always true; truncation and the choice of modes keep it)."""
        return all(group.slowest < 0 for group in self.groups)

    @property
    def passive(self) -> bool:
        """No frequency at which the model feeds energy to the body, to 1e-6 of the largest damping."""
        return all(group.passivity > PASSIVE for group in self.groups)

    def kernel(self, time: ArrayLike) -> Floats:
        """K (nt, m, m) of the model at the times t [s]."""
        return model_kernel(self.A, self.B, self.C, np.asarray(time, dtype=float))

    def transfer(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """B(omega) + i omega (A(omega) - A_inf) of the model, (n, m, m)."""
        return model_transfer(self.A, self.B, self.C, np.asarray(omega, dtype=float))

    def __str__(self) -> str:
        lines = [f"radiation: {self.states} states, {'passive' if self.passive else 'NOT passive'}"]
        for group in self.groups:
            names = ", ".join(str(k + 1) for k in group.motions)
            lines.append(f"  motions {names}: {group.states} states, {group.hankel_share:.1%} of the Hankel singular "
                         f"values, slowest pole {group.slowest:.3f} rad/s, passivity {group.passivity:.1e}")
        for entry in self.entries:
            mass = "" if entry.added_mass_error is None else f", A error {entry.added_mass_error:.1%}"
            lines.append(f"  K{entry.i + 1}{entry.j + 1}: R2 {entry.r2:.4f}, B error {entry.damping_error:.1%}{mass}")
        if self.skipped:
            lines.append("  left out: " + ", ".join(f"K{i + 1}{j + 1}" for i, j in self.skipped if i <= j))
        return "\n".join(lines)


def identify_radiation(omega: ArrayLike, damping: ArrayLike, added_mass: ArrayLike | None = None,
                       added_mass_infinite: ArrayLike | None = None, *, order: int = 4,
                       threshold: float = THRESHOLD, passive: bool = True, time_step: float | None = None,
                       duration: float | None = None) -> RadiationModel:
    """The state-space model of the radiation load; see the head of the module.

    omega (n,) [rad/s] rising and positive, damping (n, m, m); added_mass (n, m, m) and added_mass_infinite (m, m) are
    for the report only. `order` is the number of states per motion, 2 at least. `passive=False` keeps the condition
    C A^-1 B = 0 only. The kernel is sampled four times above its bandwidth until it has decayed, unless time_step and
    duration [s] are given. Raises HydrodynamicDataError.
    """
    from scipy.sparse.csgraph import connected_components

    omega, damping = np.asarray(omega, dtype=float), np.asarray(damping, dtype=float)
    if damping.ndim != 3 or damping.shape[0] != omega.size or damping.shape[1] != damping.shape[2]:
        raise HydrodynamicDataError(f"radiation: damping has the shape {damping.shape}, expected ({omega.size}, m, m)")
    if order < 2:
        raise HydrodynamicDataError(
            f"radiation: order is {order}; a motion needs two states at least, because one cannot have a kernel whose "
            "integral is zero (no load at constant velocity)")
    damping = 0.5 * (damping + damping.transpose(0, 2, 1))
    scale, used = used_entries(damping, threshold)
    m = len(scale)
    skipped = tuple((i, j) for i in range(m) for j in range(m) if not used[i, j])
    if not used.any():
        return RadiationModel(np.zeros((0, 0)), np.zeros((0, m)), np.zeros((m, 0)), (), (), skipped)
    scaled = np.where(used, damping / np.outer(scale, scale), 0.0)
    time, K = sampled_kernel(omega, scaled, used, time_step, duration)

    count, label = connected_components(used, directed=False)
    reduced, groups, orders = [], [], range(order, 1, -2)
    for motions in (np.flatnonzero(label == k) for k in range(count)):
        if used[motions[0], motions[0]]:
            *matrices, group = identify_group(time, K[:, motions[:, None], motions], orders, passive, motions)
            reduced.append((motions, matrices))
            groups.append(group)
    A = linalg.block_diag(*(a for _, (a, _, _) in reduced))
    B, C = np.zeros((len(A), m)), np.zeros((m, len(A)))
    size, row = scale[:3].max() or scale.max(), 0  # states become as large as the velocities of the body
    for motions, (a, b, c) in reduced:
        B[row : row + len(a), motions] = b * scale[motions] / size
        C[motions, row : row + len(a)] = c * scale[motions, None] * size
        row += len(a)
    found = K * np.outer(scale, scale), used, A, B, C
    entries = entry_fits(omega, damping, added_mass, added_mass_infinite, time, *found)
    return RadiationModel(A, B, C, entries, tuple(groups), skipped)


def kept_radiation(omega: Floats, damping: Floats, added_mass: Floats, added_mass_infinite: Floats, *, order: int,
                   passive: bool) -> RadiationModel:  # fmt: skip
    """`identify_radiation`, from the cache where it has been asked for the same before."""
    arrays = omega, damping, added_mass, added_mass_infinite
    return kept_model(
        lambda: identify_radiation(*arrays, order=order, passive=passive), arrays, f"{order} {passive}", __name__
    )


def kept_model(
    make: Callable[[], RadiationModel], arrays: tuple[Floats, ...], about: str, *modules: str
) -> RadiationModel:
    """What `make` finds, from the cache where these modules have made one of the same arrays and text before."""
    code = sources(*modules, retardation_kernel.__module__)
    found = cached("radiation", [*code, about, *map(np.asarray, arrays)], lambda: asdict(make()))
    m = arrays[1].shape[1]
    A, B, C = (np.array(found[name], dtype=float) for name in "ABC")
    return RadiationModel(
        A.reshape(len(A), len(A)), B.reshape(len(A), m), C.reshape(m, len(A)),
        tuple(EntryFit(**entry) for entry in found["entries"]),
        tuple(GroupFit(**{**g, "motions": tuple(g["motions"]), "hankel": np.array(g["hankel"])})
              for g in found["groups"]),
        tuple((i, j) for i, j in found["skipped"]),
    )  # fmt: skip


def hankel_singular_values(kernel: ArrayLike) -> Floats:
    """Singular values of the Hankel matrix of one entry's sampled kernel (n,), or of a symmetric one (n, p, p).

    The share of "kernel energy" that `order` states hold is in the literature the sum of the first values over the sum
    of all. The sum of all depends on how the kernel was made: for K11 of OC3-Hywind two states hold 95 % with the
    damping up to 5 rad/s and the tail of `retardation_kernel`, 89 % without the tail, and 78 % where the damping ends
    at 3 rad/s without a tail, because the ringing of the cut is spread over many values. The share in the sum of
    squares, which is energy indeed, is 99.8 % in the first case.
    """
    K = np.asarray(kernel, dtype=float)
    K = K[:, None, None] if K.ndim == 1 else K
    return np.sort(np.abs(linalg.eigvalsh(_block_hankel(K))))[::-1]


# --- the steps --------------------------------------------------------------------------------------------------------


def used_entries(damping: Floats, threshold: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Scale (m,) of each motion and which entries (m, m) are identified; motions beyond six are each their own kind."""
    largest = np.maximum(np.einsum("nii->ni", damping).max(axis=0), 0.0)
    kind = np.minimum(np.arange(len(largest)) // 3, 2)
    reference = np.array([largest[kind == k].max() if k < 2 else largest[i] for i, k in enumerate(kind)])
    alive = (largest > NEGLIGIBLE * reference) & (largest > 0)
    scale = np.sqrt(np.where(alive, largest, 0.0))
    used = np.abs(damping).max(axis=0) > threshold * np.outer(scale, scale)
    return np.where(alive, scale, 1.0), used & np.outer(alive, alive)


def sampled_kernel(omega: Floats, damping: Floats, used: NDArray[np.bool_], time_step: float | None,
                    duration: float | None) -> tuple[Floats, Floats]:
    """Times (nt,) [s] and the kernel (nt, m, m) at them, until it has decayed."""
    rows, columns = np.nonzero(np.triu(used))
    column = damping[:, rows, columns]
    band = bandwidth(omega, column)
    step = time_step or np.pi / (4 * band)
    resolved = np.pi / _spacing(omega, column, band)
    samples = int(duration / step) + 1 if duration else min(SAMPLES, int(resolved / step) + 1)
    if samples < _FEWEST_SAMPLES:
        raise HydrodynamicDataError(
            f"radiation: the frequencies are too few for a kernel of {samples} samples of {step:.3g} s; "
            "compute the damping at more frequencies")
    time = step * np.arange(samples)
    values = retardation_kernel(omega, column, time)
    if duration is None:
        energy = np.cumsum(values[::-1] ** 2, axis=0)[::-1]
        samples = max(samples // 3, int(np.argmax((energy < _DECAYED * energy[0]).all(axis=1))) or samples)
        time, values = time[:samples], values[:samples]
    kernel = np.zeros((len(time), *used.shape))
    kernel[:, rows, columns] = kernel[:, columns, rows] = values
    return time, kernel


def _spacing(omega: Floats, damping: Floats, band: float) -> float:
    """Spacing of the frequencies that says how long the kernel is known, up to pi over it.

    The mean over the squares of the damping (n, m) where it is smooth between its frequencies, so that a few wide steps
    where little is left of it do not shorten the kernel; else the widest step in the band.
    """
    steps, weight = np.diff(np.append(0.0, omega)), (damping**2 / (damping**2).max(axis=0)).sum(axis=1)
    widest = float(steps[np.append(0.0, omega[:-1]) < band].max())
    mean = float(np.average(steps, weights=weight))
    return mean if mean < _EVEN * widest and is_smooth(omega, damping) else widest


def is_smooth(omega: Floats, damping: Floats) -> bool:
    """Whether a spline without a frequency meets the damping (n, m) there, by the median over the entries."""
    scaled = damping / np.abs(damping).max(axis=0)
    missed = [
        np.median(np.abs(spline_between(np.delete(omega, k), np.delete(scaled, k, axis=0))(omega[k]) - scaled[k]))
        for k in range(len(omega) - 1)
    ]
    return bool(max(missed) < _SMOOTH)


def identify_group(
    time: Floats, K: Floats, orders: Iterable[int], passive: bool, motions: NDArray[np.intp]
) -> tuple[Floats, Floats, Floats, GroupFit]:
    """A, B, C of one group of coupled motions from its kernel (nt, p, p), and how well they fit.

    By the first order that leaves less than a tenth of the kernel, or by the one that leaves least: passivity may leave
    more with more states.
    """
    found, least = None, np.inf
    for order in orders:
        A, B, C, group = _identified(time, K, order, passive, motions)
        left = float(linalg.norm(model_kernel(A, B, C, time) - K) / linalg.norm(K))
        if found is None or left < least:
            found, least = (A, B, C, group), left
        if not passive or least < _LEFT:
            break
    assert found is not None
    return found


def _identified(time: Floats, K: Floats, order: int, passive: bool, motions: NDArray[np.intp]):
    step, p = time[1] - time[0], K.shape[1]
    hankel, Ad, B, C = realisation(K, RAW_STATES * p)
    A, B, C = continuous(Ad, B, C, step)
    dropped, states = len(Ad) - len(A), min(order * p, len(A))
    A, B, C = balanced_truncation(A, B, C, states)
    outputs = (_fit_output(A, B, time, K, passive, points) for points in _PASSIVITY_POINTS)
    C = next(outputs)
    while passive and passivity(A, B, C) < PASSIVE and (closer := next(outputs, None)) is not None:
        C = closer
    share, slowest = hankel[:states].sum() / hankel.sum(), linalg.eigvals(A).real.max()
    names = tuple(int(k) for k in motions)
    return A, B, C, GroupFit(names, states, hankel, float(share), dropped, float(slowest), passivity(A, B, C))


def _block_hankel(K: Floats) -> Floats:
    n, p = (len(K) + 1) // 2, K.shape[1]
    index = np.arange(n)[:, None] + np.arange(n)
    return K[index].transpose(0, 2, 1, 3).reshape(n * p, n * p)


def realisation(K: Floats, most: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Hankel singular values and Ad, B, C with C Ad^k B = K_k; K is symmetric, so an eigenvalue problem does."""
    p = K.shape[1]
    value, vector = linalg.eigh(_block_hankel(K))
    largest = np.argsort(-np.abs(value))
    hankel = np.abs(value[largest])
    keep = largest[: min(most, int((hankel > RAW_TOLERANCE * hankel[0]).sum()))]
    observability = vector[:, keep] * np.sqrt(np.abs(value[keep]))
    Ad = np.linalg.lstsq(observability[:-p], observability[p:], rcond=None)[0]
    return hankel, Ad, np.sign(value[keep])[:, None] * observability[:p].T, observability[:p]


def continuous(Ad: Floats, B: Floats, C: Floats, step: float) -> tuple[Floats, Floats, Floats]:
    """Real modal form of A = log(Ad) / step; modes that grow, and negative real ones, which have no logarithm, drop."""
    value, vector = linalg.eig(Ad)
    b, c = linalg.solve(vector, B.astype(complex)), C @ vector
    real = np.abs(value.imag) < 1e-12 * np.abs(value)
    inside = (np.abs(value) < 1) & (np.abs(value) > 1e-9)
    single = np.flatnonzero(inside & real & (value.real > 0))
    pair = np.flatnonzero(inside & ~real & (value.imag > 0))
    pole = np.log(value) / step
    blocks = [np.array([[pole[k].real]]) for k in single]
    blocks += [np.array([[pole[k].real, pole[k].imag], [-pole[k].imag, pole[k].real]]) for k in pair]
    rows = [b[k].real for k in single] + [part for k in pair for part in (b[k].real, -b[k].imag)]
    columns = [c[:, k].real for k in single] + [part for k in pair for part in (2 * c[:, k].real, 2 * c[:, k].imag)]
    return linalg.block_diag(*blocks), np.array(rows), np.array(columns).T


def balanced_truncation(A: Floats, B: Floats, C: Floats, states: int) -> tuple[Floats, Floats, Floats]:
    """The model of fewer states by the square-root method; see the head of the module."""
    reach = _root(linalg.solve_continuous_lyapunov(A, -B @ B.T))
    see = _root(linalg.solve_continuous_lyapunov(A.T, -C.T @ C))
    U, sigma, Vt = linalg.svd(see.T @ reach)
    root = np.sqrt(sigma[:states])
    right, left = reach @ Vt[:states].T / root, (U[:, :states] / root).T @ see.T
    return left @ A @ right, left @ B, C @ right


def _root(gramian: Floats) -> Floats:
    value, vector = linalg.eigh(0.5 * (gramian + gramian.T))
    return vector * np.sqrt(np.maximum(value, 0.0))


def _fit_output(A: Floats, B: Floats, time: Floats, K: Floats, passive: bool, points: int) -> Floats:
    """C that meets the samples K best under C A^-1 B = 0 and, if wanted, passivity at so many points."""
    n, p = B.shape
    powers = model_kernel(A, B, np.eye(n), time)
    gram = np.einsum("kis,kjs->ij", powers, powers)
    target = np.einsum("kis,kjs->ij", K, powers)
    free = linalg.null_space(linalg.solve(A, B).T, rcond=RAW_TOLERANCE)  # of patterns that are there, not of noise
    white = linalg.solve_triangular(linalg.cholesky(free.T @ gram @ free), free.T, trans=1)
    best = target @ white.T  # C = y white meets C A^-1 B = 0, row by row, and |y - best|^2 is the error of the samples
    if not passive:
        return best @ white
    span = linalg.null_space(_symmetric_limits(A, B, white)) if n > 2 * p else np.eye(best.size)
    basis = white @ normalised_damping(A, B, points)  # (points, free, p), complex
    y, rows = span @ (span.T @ best.ravel()), np.zeros((0, span.shape[1]))
    for _ in range(_PASSIVITY_ROUNDS):
        load = y.reshape(best.shape) @ basis
        value, vector = np.linalg.eigh(load + load.conj().transpose(0, 2, 1))
        worst = np.flatnonzero(local_minima(value[:, 0]) & (value[:, 0] < -1e-9 * value.max()))
        if not worst.size:
            break
        cuts = [np.outer(vector[k, :, 0].conj(), basis[k] @ vector[k, :, 0]).real.ravel() @ span for k in worst]
        rows = np.vstack([rows, [cut / linalg.norm(cut) for cut in cuts]])
        y = span @ least_distance(span.T @ best.ravel(), rows)
    return y.reshape(best.shape) @ white


def _symmetric_limits(A: Floats, B: Floats, white: Floats) -> Floats:
    """Linear conditions on y: added mass at omega = 0 and kernel at t = 0 are symmetric (C A^-2 B and C B).

    Re(C (i omega - A)^-1 B) vanishes faster towards both ends than the skew part would.
    """
    p = B.shape[1]
    conditions = []
    for column in (white @ linalg.solve(A, linalg.solve(A, B)), white @ B):
        for i, j in zip(*np.triu_indices(p, 1), strict=True):
            row = np.zeros((p, len(white)))
            row[i], row[j] = column[:, j], -column[:, i]
            conditions.append(row.ravel() / linalg.norm(row))
    return np.array(conditions).reshape(-1, p * len(white))


def least_distance(best: Floats, rows: Floats, limits: Floats | float = 0.0) -> Floats:
    """The point nearest to `best` with rows @ point >= limits + a small margin (Lawson and Hanson 1974, 23.4)."""
    from scipy.optimize import nnls

    wanted = limits + 1e-7 * linalg.norm(best) - rows @ best
    stacked = np.vstack([rows.T, wanted])
    unit = np.zeros(len(stacked))
    unit[-1] = 1.0
    u, _ = nnls(stacked, unit)
    residual = stacked @ u - unit
    return best - residual[:-1] / residual[-1]


def local_minima(values: Floats) -> NDArray[np.bool_]:
    """Where (n,) no neighbour is smaller; ends count."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    return (values <= padded[:-2]) & (values <= padded[2:])


def normalised_damping(A: Floats, B: Floats, points: int) -> NDArray[np.complex128]:
    """M (points, n, p) with C M proportional to C (i omega - A)^-1 B at omega = 0 ... infinity, where C A^-1 B = 0.

    omega = w tan(theta / 2), and the factor (w^2 + omega^2)^2 / (w omega)^2 keeps both limits, where the damping goes
    to zero, as visible as the middle. Real part: omega^2 A^-1 (omega^2 + A^2)^-1 B, or -A (omega^2 + A^2)^-1 B, which
    is the same times C; imaginary part: -omega (omega^2 + A^2)^-1 B, whose skew part goes to zero at both ends.
    """
    w = float(np.abs(linalg.eigvals(A)).mean())
    theta = np.linspace(0.0, np.pi, points)[:, None, None]
    s, c = np.sin(theta / 2), np.cos(theta / 2)
    A = A / w
    inner = np.linalg.solve(s**2 * np.eye(len(A)) + c**2 * (A @ A), np.broadcast_to(B, (len(theta), *B.shape)))
    real = np.where(s < c, linalg.inv(A) @ inner / np.maximum(c**2, 0.25), -A @ inner / np.maximum(s**2, 0.25))
    imaginary = -inner / np.maximum(s * c, 1e-9)
    imaginary[[0, -1]] = 0.0
    return real + 1j * imaginary


def passivity(A: Floats, B: Floats, C: Floats) -> float:
    """Smallest eigenvalue of the Hermitian part of the load over its largest, over all frequencies."""
    omega = np.append(0.0, np.abs(linalg.eigvals(A)).mean() * np.tan(np.linspace(0.002, np.pi - 0.002, 1500) / 2))
    response = model_transfer(A, B, C, omega)
    value = np.linalg.eigvalsh(response + response.conj().transpose(0, 2, 1))
    return float(value[:, 0].min() / value.max())


def model_kernel(A: Floats, B: Floats, C: Floats, time: Floats) -> Floats:
    """C exp(A t) B (nt, m, m) at times t [s]."""
    if not len(A):
        return np.zeros((len(time), len(C), B.shape[1]))
    value, vector = linalg.eig(A)
    left, right = C @ vector, linalg.solve(vector, B.astype(complex))
    return np.einsum("im,tm,mj->tij", left, np.exp(np.outer(time, value)), right, optimize=True).real


def model_transfer(A: Floats, B: Floats, C: Floats, omega: Floats) -> NDArray[np.complex128]:
    """C (i omega - A)^-1 B (n, m, m)."""
    shifted = 1j * omega[:, None, None] * np.eye(len(A)) - A
    return C @ np.linalg.solve(shifted, np.broadcast_to(B, (len(omega), *B.shape)))


def entry_fits(omega, damping, added_mass, infinite, time, K, used, A, B, C) -> tuple[EntryFit, ...]:
    """How well each used entry (i, j) is met."""
    model, response = model_kernel(A, B, C, time), model_transfer(A, B, C, omega)
    have_mass = added_mass is not None and infinite is not None
    if have_mass:
        excess = np.asarray(added_mass, dtype=float) - np.asarray(infinite, dtype=float)
        excess = 0.5 * (excess + excess.transpose(0, 2, 1))
        of_kernel, of_model = added_mass_from_kernel(time, K, omega), response.imag / omega[:, None, None]
    entries = []
    for i, j in np.argwhere(np.triu(used)):
        k = K[:, i, j]
        entries.append(EntryFit(
            int(i), int(j), float(1 - np.sum((model[:, i, j] - k) ** 2) / np.sum((k - k.mean()) ** 2)),
            _relative(response.real[:, i, j], damping[:, i, j]),
            _relative(of_model[:, i, j], excess[:, i, j]) if have_mass else None,
            _relative(of_kernel[:, i, j], excess[:, i, j]) if have_mass else None))
    return tuple(entries)


def _relative(value: Floats, reference: Floats) -> float:
    return float(linalg.norm(value - reference) / max(linalg.norm(reference), 1e-300))
