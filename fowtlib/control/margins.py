"""How far a loop is from instability: gain, phase, delay and disk margins, exact from the matrices.

Where the phase crosses, L(s) = L(-s) on the imaginary axis; where the gain crosses 1, L(s) L(-s) = 1. Both are zeros of
a state space, so that no frequency grid can miss one. Disk margin: the largest alpha such that the loop stays stable
under each factor (2 + alpha d) / (2 - alpha d), |d| < 1, complex and of any frequency; alpha = 2 / max |S - T|
(P. Seiler, A. Packard and P. Gahinet, IEEE Control Systems 40 (2020) 78). A sampled loop is taken by the
bilinear transformation, which leaves all values of the frequency response as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from fowtlib.control.checks import Matrix
from fowtlib.control.reduction import SampledModel
from fowtlib.language.errors import ModelError
from fowtlib.language.operators import transfer_matrix
from fowtlib.solving.linear import LinearModel

System = tuple[Matrix, Matrix, Matrix, Matrix]


@dataclass(frozen=True)
class Margins:
    """Of one loop, cut at one place, with all others closed.

    gain: factors from the first of which to the second the loop may change; phase [rad] that it may gain or lose;
    delay [s] that it may gain; disk: alpha. crossover: frequencies [rad/s] at which the gain is one.
    """

    gain: tuple[float, float]
    phase: float
    delay: float
    disk: float
    crossover: tuple[float, ...] = ()

    @property
    def disk_gain(self) -> tuple[float, float]:
        """Factors that the disk margin allows, with any change of phase within it."""
        if self.disk >= 2:
            return 0.0, float("inf")
        return (2 - self.disk) / (2 + self.disk), (2 + self.disk) / (2 - self.disk)

    @property
    def disk_phase(self) -> float:
        """Phase [rad] that the disk margin allows."""
        return 2 * float(np.arctan(self.disk / 2))


def margins(loop: LinearModel) -> dict[str, Margins]:
    """Margins at each input of a loop L under negative feedback, one cut at a time, the others closed.

    loop: as many outputs as inputs, output i closes on input i; `Regulator.loop` is one. Raises ModelError where the
    closed loop is not stable.
    """
    system, period = _continuous(loop), getattr(loop, "period", None)
    _refuse_unstable(system, loop)
    found = {}
    for k, name in enumerate(loop.inputs):
        found[name] = _of_one(_others_closed(system, k), period)
    return found


def disk_margin(loop: LinearModel) -> float:
    """Alpha that all loops have at once, each changed in its own way: a lower bound, exact for one loop."""
    system = _continuous(loop)
    _refuse_unstable(system, loop)
    return 2.0 / largest_gain(_difference(system))


def _continuous(loop: LinearModel) -> System:
    A, B, C, D = (np.asarray(loop.matrices[name], dtype=float) for name in "ABCD")
    if D.shape[0] != D.shape[1]:
        raise ModelError(f"a loop has as many outputs as inputs; this one has {D.shape[0]} and {D.shape[1]}.")
    if not isinstance(loop, SampledModel):
        return A, B, C, D
    back = np.linalg.inv(A + np.eye(len(A)))
    factor = 2.0 / loop.period
    return factor * back @ (A - np.eye(len(A))), 2.0 * np.sqrt(1 / loop.period) * back @ B, \
        2.0 * np.sqrt(1 / loop.period) * C @ back, D - C @ back @ B  # fmt: skip


def _refuse_unstable(system: System, loop: LinearModel) -> None:
    A, B, C, D = system
    closed = A - B @ np.linalg.solve(np.eye(len(D)) + D, C)
    values = np.linalg.eigvals(closed)
    worst = int(np.argmax(values.real)) if len(values) else -1
    if worst >= 0 and values[worst].real >= 0:
        raise ModelError(
            f"the closed loop is not stable: it has a pole {values[worst]:.4g} 1/s, so it has no margins."
        )


def _others_closed(system: System, k: int) -> System:
    """The scalar loop k with all others closed."""
    A, B, C, D = system
    o = [i for i in range(len(D)) if i != k]
    if not o:
        return system
    inner = np.linalg.inv(np.eye(len(o)) + D[np.ix_(o, o)])
    into, out = -inner @ C[o], -inner @ D[np.ix_(o, [k])]
    one = slice(k, k + 1)
    return A + B[:, o] @ into, B[:, one] + B[:, o] @ out, C[one] + D[one][:, o] @ into, D[one, one] + D[one][:, o] @ out


def _of_one(system: System, period: float | None) -> Margins:
    D = system[-1]

    def value(s: complex) -> complex:
        return complex(transfer_matrix(s, *system)[0, 0, 0])

    def frequency(omega: float) -> float:
        return omega if period is None else 2 / period * float(np.arctan(omega * period / 2))

    real = [v for w in _phase_crossings(system) if (v := value(1j * w)).real < 0 and abs(v.imag) < 1e-5 * abs(v)]
    if D[0, 0] < 0:
        real.append(complex(D[0, 0]))
    factors = [factor for v in real if (factor := -1 / v.real) > 1e-12]  # an integrator at zero frequency is no limit
    upper = min((f for f in factors if f > 1), default=float("inf"))
    lower = max((f for f in factors if f < 1), default=0.0)
    crossings = [w for w in _gain_crossings(system) if abs(abs(value(1j * w)) - 1) < 1e-5]
    lags = [float(np.angle(-value(1j * w))) for w in crossings]  # above -180 deg, in (-pi, pi]
    phase = min(map(abs, lags), default=float("inf"))
    delays = [(lag % (2 * np.pi)) / frequency(w) for lag, w in zip(lags, crossings, strict=True) if w > 0]
    disk = 2.0 / largest_gain(_difference(system))
    return Margins((lower, upper), phase, min(delays, default=float("inf")), disk, tuple(map(frequency, crossings)))


def _difference(system: System) -> System:
    """S - T = 2 S - 1."""
    A, B, C, D = system
    inner = np.linalg.inv(np.eye(len(D)) + D)
    return A - B @ inner @ C, B @ inner, -2 * inner @ C, 2 * inner - np.eye(len(D))


def _phase_crossings(system: System) -> list[float]:
    """Frequencies at which L is real: zeros of L(s) - L(-s), and zero."""
    A, B, C, _ = system
    n = len(A)
    pair = linalg.block_diag(A, -A), np.vstack([B, B]), np.hstack([C, C]), np.zeros((1, 1))
    regular = np.linalg.cond(A) < 1e14 if n else True
    return ([0.0] if regular else []) + _imaginary_zeros(*pair)


def _gain_crossings(system: System) -> list[float]:
    """Frequencies at which |L| = 1: zeros of L(-s) L(s) - 1."""
    A, B, C, D = system
    n = len(A)
    both = np.block([[A, np.zeros((n, n))], [-C.T @ C, -A.T]])
    into = np.vstack([B, -C.T @ D])
    out = np.hstack([D.T @ C, B.T])
    return _imaginary_zeros(both, into, out, D.T @ D - np.eye(1))


def _imaginary_zeros(A: Matrix, B: Matrix, C: Matrix, D: Matrix) -> list[float]:
    """Positive frequencies of the zeros of a square system on the imaginary axis, nearly."""
    balanced, (scale, _) = linalg.matrix_balance(A, permute=False, separate=True)
    B, C = B / scale[:, None], C * scale[None, :]
    size = max(np.linalg.norm(balanced, 2), 1e-300)
    b, c = max(np.linalg.norm(B), 1e-300), max(np.linalg.norm(C), 1e-300)
    pencil = np.block([[balanced / size, B / b], [C / c, D * size / (b * c)]])
    mass = linalg.block_diag(np.eye(len(A)), np.zeros_like(D))
    values = linalg.eigvals(pencil, mass)
    values = values[np.isfinite(values)] * size
    near = values[(np.abs(values.real) < 1e-4 * np.abs(values.imag)) & (values.imag > 0)]
    return sorted(set(np.round(near.imag, 14).tolist()))


def largest_gain(system: System, tolerance: float = 1e-10) -> float:
    """The largest singular value over all frequencies of a stable system, exact to `tolerance`.

    N. A. Bruinsma and M. Steinbuch, Systems & Control Letters 14 (1990) 287.
    """
    A, D = system[0], system[-1]
    poles = np.linalg.eigvals(A)

    def at(omega: float) -> float:
        return float(np.linalg.norm(transfer_matrix(1j * omega, *system)[0], 2))

    best = max([float(np.linalg.norm(D, 2)), at(0.0), *(at(abs(pole)) for pole in poles)])
    for _ in range(60):
        level = best * (1 + tolerance) + 1e-300
        crossings = _levels(system, level)
        if len(crossings) == 0:
            return best
        middles = [0.5 * (a + b) for a, b in zip(crossings[:-1], crossings[1:], strict=True)] or crossings
        better = max(at(w) for w in middles)
        if better <= level:
            return max(best, better)
        best = better
    return best


def _levels(system: System, level: float) -> Sequence[float]:
    """Frequencies at which a singular value is `level`: imaginary eigenvalues of the Hamiltonian."""
    A, B, C, D = system
    R = D.T @ D - level**2 * np.eye(D.shape[1])
    inner = np.linalg.solve(R, np.hstack([D.T @ C, B.T]))
    n = len(A)
    by_x, by_p = inner[:, :n], inner[:, n:]
    H = np.block([
        [A - B @ by_x, -B @ by_p],
        [-C.T @ C + C.T @ D @ by_x, -A.T + C.T @ D @ by_p],
    ])  # fmt: skip
    values = np.linalg.eigvals(H)
    return sorted(abs(v.imag) for v in values if abs(v.real) < 1e-7 * max(abs(v), 1e-9))
