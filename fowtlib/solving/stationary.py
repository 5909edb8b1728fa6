"""A start in the stationary state: the mean, and what wind and waves have made of it before the run.

The signals that drive a model are series that repeat themselves. So the linear model about the mean has one response to
them that repeats itself, too, sum_k Re((i omega_k - A)^-1 B u_k exp(i omega_k t)), and its value at t = 0 is where a
run starts that has no transient. Over the seeds of the signals these starts have the stationary covariance of the
linear model under the spectra of the signals, integral of G S G^H; and each fits the waves and the wind that follow.

Only modes slower than a period are taken: a fast one forgets its start within seconds, and those of the blades depend
on the azimuth. A = V diag(lambda) W, and the response of mode j to a harmonic is W_j B u / (i omega - lambda_j).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.language.series import Series
from fowtlib.solving.binding import Binding
from fowtlib.solving.equilibrium import dependence
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.state import State
from fowtlib.solving.turning import turns_of

SHORTEST = 2.5  # s; modes with a longer period than this are taken


@dataclass(frozen=True, eq=False)
class SlowModes:
    """The slow part of a linear model about a mean, from the signals that drive it, by the paths of their handles.

    shapes: (states, modes); gains: of each signal (modes, columns); roots (modes,) [1/s].
    """

    shapes: np.ndarray
    roots: np.ndarray
    gains: dict[str, np.ndarray]

    def response(self, binding: Binding) -> np.ndarray:
        """Deviation of all states from the mean at t = 0 under the signals of a run."""
        total = np.zeros(len(self.roots), dtype=complex)
        conjugate = np.zeros_like(total)
        for path, gain in self.gains.items():
            omega, amplitude = harmonics(binding.sources.get(path))
            if not len(omega):
                continue
            driven = amplitude @ gain.T
            total += (driven / (1j * omega[:, None] - self.roots)).sum(axis=0)
            conjugate += (amplitude.conj() @ gain.T / (-1j * omega[:, None] - self.roots)).sum(axis=0)
        return (self.shapes @ (total + conjugate)).real / 2


def slow_modes(at: AtParameters, plant: Any, state: State, shortest: float = SHORTEST) -> SlowModes:
    """The modes of a plant at a mean state with periods above `shortest` [s].

    One that grows, as near rated wind, has no stationary state and is left out, with a warning. SimulationError where a
    part is sampled.
    """
    dae = at.dae
    if dae.samples:
        raise SimulationError(
            f"no stationary start: {dae.samples[0].path} is sampled, and has no linear model. Take the start "
            "'turning', and discard the first part of the run."
        )
    series = {item.symbol[0].element_hash(): item.path for item in dae.bound.values() if item.functions}
    signals = {
        series[handle]: external.outputs
        for external in dae.externals
        if (handle := ca.vec(external.inputs)[0].element_hash()) in series and external.inputs.numel() == 2
    }

    def make() -> ca.Function:
        columns = [dae.x, dae.z, *(dae.w[place] for place in signals.values())]
        return at.functions.torn_jacobian("slopes", ca.vertcat(dae.ode, dae.alg), columns)

    slopes = at.functions.once(("slopes by signals", tuple(signals)), make)
    blocks = at.call(slopes, state.t, state.x, state.z, np.concatenate([state.u, state.d]))
    by_x, by_z, *by_signals = (np.array(ca.densify(block)) for block in blocks)
    nx, nz = by_x.shape[1], by_z.shape[1]
    through = by_z[:nx] @ np.linalg.inv(by_z[nx:]) if nz else np.zeros((nx, 0))
    A, *B = (block[:nx] - through @ block[nx:] for block in (by_x, *by_signals))
    around = turns_of(plant, at, state)
    for turn in around:  # what turns with a rotor stands in the frame that turns
        A, *B = (M - np.outer(turn.direction, M[turn.azimuth]) for M in (A, *B))
    used = dependence(at.functions).any(axis=0)
    free = [k for k in range(nx) if used[k] and k not in {turn.azimuth for turn in around}]
    roots, right = np.linalg.eig(A[np.ix_(free, free)])
    left = np.linalg.pinv(right)
    slow = np.flatnonzero(np.abs(roots) < 2 * np.pi / shortest)
    growing = [k for k in slow if roots[k].real > -1e-9]
    if growing:
        _say_what_grows(at, state, roots[growing], free, right[:, growing])
        slow = np.setdiff1d(slow, growing)
    shapes = np.zeros((nx, len(slow)), dtype=complex)
    shapes[free] = right[:, slow]
    gains = {path: left[slow] @ block[free] for path, block in zip(signals, B, strict=True)}
    return SlowModes(shapes, roots[slow], gains)


def _say_what_grows(at: AtParameters, state: State, roots: np.ndarray, free: list[int], shapes: np.ndarray) -> None:
    names = {at.dae.states[free[int(np.argmax(np.abs(shape) / _sizes(at, state)[free]))]].path for shape in shapes.T}
    period = 2 * np.pi / max(abs(roots[0].imag), 1e-9)
    about = f", with a period of {period:.3g} s," if period < 1e6 else ""
    warnings.warn(
        f"the start leaves a motion of {', '.join(sorted(names))}{about} at its mean: in the linear model about the "
        "mean it grows, and has no stationary state.", stacklevel=2
    )  # fmt: skip


def _sizes(at: AtParameters, state: State) -> np.ndarray:
    """What is large for each state, for the comparison of states with different units."""
    return 1.0 + np.abs(state.x)


def harmonics(series: Any) -> tuple[np.ndarray, np.ndarray]:
    """Circular frequencies (k,) [rad/s] and complex amplitudes (k, m) of a series that repeats itself; else none.

    A series that grows from nothing has no past either.
    """
    if not isinstance(series, Series) or series.build_up > 0:
        return np.zeros(0), np.zeros((0, 0), dtype=complex)
    if series.kind == "harmonics":
        table = series.rows.reshape(series.count, -1)
        amplitude = table[:, 1 : 1 + series.size] + 1j * table[:, 1 + series.size :]
        moving = table[:, 0] > 0
        return table[moving, 0], amplitude[moving]
    if not series.periodic:
        return np.zeros(0), np.zeros((0, series.size), dtype=complex)
    n = series.count - (3 if series.kind == "cubic" else 0)
    values = series(series.step * np.arange(n))
    amplitude = np.fft.rfft(values, axis=0)[1 : (n + 1) // 2] * (2 / n)
    return 2 * np.pi * np.arange(1, len(amplitude) + 1) / (n * series.step), amplitude
