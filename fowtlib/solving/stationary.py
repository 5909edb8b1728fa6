"""A start in the stationary state: the mean, and what wind and waves have made of it before the run.

The signals that drive a model are series that repeat themselves. So the linear model about the mean has one response to
them that repeats itself, too, sum_k Re((i omega_k - A)^-1 B u_k exp(i omega_k t)), and its value at t = 0 is where a
run starts that has no transient. Over the seeds of the signals these starts have the stationary covariance of the
linear model under the spectra of the signals, integral of G S G^H; and each fits the waves and the wind that follow.

Only modes slower than a period are taken: a fast one forgets its start within seconds. Where loads depend on the
azimuth of a rotor, the linear model is the mean over a turn; see solving.turning. Near rated wind a linear model is
that of one side of the controller, and a mode may grow in it, or as good as that: then the motions of bodies are moved
alone, and rotors and controllers, which have limits that it knows nothing of, begin at their mean.

A = V diag(lambda) W, and the response of mode j to a harmonic is W_j B u / (i omega - lambda_j).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.declarations import join
from fowtlib.language.errors import SimulationError
from fowtlib.language.run_time import series_handle
from fowtlib.language.series import Series
from fowtlib.solving.binding import Binding
from fowtlib.solving.equilibrium import dependence
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.rates import rate_states
from fowtlib.solving.state import State
from fowtlib.solving.turning import FEW, Average, turns_of

SHORTEST = 2.5  # s; modes with a longer period than this are taken
LEAST_DAMPING = 0.01  # ratio of a mode, below which what it does is too large for a linear model


@dataclass(frozen=True, eq=False)
class SlowModes:
    """The slow part of a linear model about a mean, from the signals that drive it, by the paths of their handles.

    shapes: (states, modes); roots (modes,) [1/s]; gains: of each signal (modes, columns). moved: (states,) the motions
    of bodies. sound: whether all modes are damped.
    """

    shapes: np.ndarray
    roots: np.ndarray
    gains: dict[str, np.ndarray]
    moved: np.ndarray
    sound: bool

    def response(self, binding: Binding) -> np.ndarray:
        """Deviation of all states from the mean at t = 0 under the signals of a run."""
        total = np.zeros(len(self.roots), dtype=complex)
        conjugate = np.zeros_like(total)
        sources = before_the_run(binding)
        for path, gain in self.gains.items():
            omega, amplitude = harmonics(sources.get(path))
            if not len(omega):
                continue
            driven = amplitude @ gain.T
            total += (driven / (1j * omega[:, None] - self.roots)).sum(axis=0)
            conjugate += (amplitude.conj() @ gain.T / (-1j * omega[:, None] - self.roots)).sum(axis=0)
        return (self.shapes @ (total + conjugate)).real / 2


def slow_modes(at: AtParameters, plant: Any, state: State, shortest: float = SHORTEST) -> SlowModes:
    """The modes of a plant at a mean state with periods above `shortest` [s].

    One that grows or hardly decays, as near rated wind, has no stationary state that a linear model knows; it is left
    out, with a warning. SimulationError where a part is sampled.
    """
    dae = at.dae
    if dae.samples:
        raise SimulationError(
            f"no stationary start: {dae.samples[0].path} is sampled, and has no linear model. Take the start "
            "'turning', and discard the first part of the run."
        )
    signals = {
        item.path: dae.externals[k].outputs for k, item in dae.with_data if dae.externals[k].inputs.numel() == 2
    }

    def make() -> ca.Function:
        columns = [dae.x, dae.z, *(dae.w[place] for place in signals.values())]
        return at.functions.torn_jacobian("slopes", ca.vertcat(dae.ode, dae.alg), columns)

    function = at.functions.once(("slopes by signals", tuple(signals)), make)
    nx = state.x.size

    def jacobian(*point: Any) -> tuple[np.ndarray, ...]:
        by_x, by_z, *by_signals = (np.array(ca.densify(block)) for block in at.call(function, *point))
        columns = np.hstack([by_x, *by_signals])
        return columns[:nx], by_z[:nx], columns[nx:], by_z[nx:]

    around = turns_of(plant, at, state)
    if around:  # loads depend on the azimuth
        average = Average(at, state, around, FEW, jacobian)
        slopes = average.at_mean(average.multiblade.from_states(state.x)).slopes
    else:
        top, top_z, bottom, bottom_z = jacobian(state.t, state.x, state.z, np.concatenate([state.u, state.d]))
        slopes = top - top_z @ np.linalg.solve(bottom_z, bottom) if state.z.size else top
    ends = np.cumsum([nx, *(place.stop - place.start for place in signals.values())])
    A, *B = np.split(slopes, ends[:-1], axis=1) if signals else [slopes]
    used = dependence(at.functions).any(axis=0)
    free = [k for k in range(nx) if used[k] and k not in {turn.azimuth for turn in around}]
    roots, right = np.linalg.eig(A[np.ix_(free, free)])
    left = np.linalg.pinv(right)
    slow = np.flatnonzero(np.abs(roots) < 2 * np.pi / shortest)
    growing = [k for k in slow if -roots[k].real < LEAST_DAMPING * np.abs(roots[k])]
    if growing:
        _say_what_grows(dae, roots[growing], free, right[:, growing])
        slow = np.setdiff1d(slow, growing)
    shapes, moved = np.zeros((nx, len(slow)), dtype=complex), np.zeros(nx, dtype=bool)
    geared = {k for turn in around for k in np.flatnonzero(turn.direction).tolist()}
    shapes[free] = right[:, slow]
    moved[motions(dae, [k for k in free if k not in geared])] = True
    gains = {path: left[slow] @ block[free] for path, block in zip(signals, B, strict=True)}
    return SlowModes(shapes, roots[slow], gains, moved, not growing)


def motions(dae: FlatDAE, free: list[int]) -> list[int]:
    """Numbers of the states that are positions and speeds of bodies; nothing of rotors that turn, and of their parts.

    free: the states without coordinates that turn with a rotor, or that nothing depends on; their speeds do not count.
    """
    inside = tuple(f"{part}." for ring in dae.symmetries for part in ring.parts)
    pairs = [pair for pair in rate_states(dae).items() if set(pair) <= set(free)]
    found = {k for pair in pairs for k in pair if not dae.states[k].path.startswith(inside)}
    linear = tuple({f"{item.path}." for item in dae.operators})  # what the water remembers
    return sorted(found | {k for k in free if dae.states[k].path.startswith(linear)}) if linear else sorted(found)


def _say_what_grows(dae: FlatDAE, roots: np.ndarray, free: list[int], shapes: np.ndarray) -> None:
    positions = [row for row, k in enumerate(free) if k in rate_states(dae)] or list(range(len(free)))
    names = {dae.states[free[positions[int(np.argmax(np.abs(shape[positions])))]]].path for shape in shapes.T}
    period = 2 * np.pi / max(abs(roots[0].imag), 1e-9)
    about = f", with a period of {period:.3g} s," if period < 1e6 else ""
    warnings.warn(
        f"the start leaves a motion of {', '.join(sorted(names))}{about} at its mean: in the linear model about the "
        "mean it grows or hardly decays. So rotors and controllers begin at their mean, too.", stacklevel=2
    )  # fmt: skip


def before_the_run(binding: Binding) -> dict[str, Any]:
    """What has driven a model before a run, by the paths of the handles; a warning tells of what nobody knows."""
    sources, parts = dict(binding.sources), binding.root.walk() if binding.root is not None else ()
    own = {join(part.path, series_handle(name)): series
           for part in parts for name, series in part.before_the_run().items()}  # fmt: skip
    unknown = [path for path, series in own.items() if series is None]
    unknown += [
        path for path, series in sources.items() if isinstance(series, Series) and np.isfinite(series.covers[1])
    ]
    if unknown:
        names = ", ".join(sorted({path.rpartition(".")[0] for path in unknown}))
        warnings.warn(
            f"the start takes {names} as steady before the run: what does not repeat itself has no past.", stacklevel=2
        )
    return sources | own


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
