"""What goes round in a steady operation: the harmonics of results over a revolution, without a run.

The mean state balances the mean of the loads in the frame that does not turn, and has the motion of the blades once in
a revolution. What is left over at each azimuth, of the shear and the dam of the tower on blades that pass, of gravity
on blades that are bent, drives the linear model about the mean with multiples of the rotor speed. So a result is

    mean + sum over the rotors and n of 2 Re(c_n exp(i n psi)),

with c_n from the results at the azimuths of the mean state itself (which is exact), and from the forced motion. What a
rotor drives is kept, so that c_n can be had for another speed of the turning and with other damping.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fowtlib.solving.linear import Resolvent
from fowtlib.solving.mean_linear import RotatingLinearModel
from fowtlib.solving.state import State

HARMONICS = 12  # of the rotor speed
FINER = 3  # points for one of the mean: a single blade passes the tower at few of those


@dataclass(frozen=True, eq=False)
class Driven:
    """What one rotor drives in the linear model, by multiples n = 0, 1, ... of its azimuth; n = 0 is nothing.

    rates: of the states (n, states); direct: of the results without the motion of the states (n, m); outputs, turning:
    results by states (m, states), and what goes round once more, times exp(i psi).
    """

    speed: float
    rates: np.ndarray
    direct: np.ndarray
    outputs: np.ndarray
    turning: np.ndarray

    def harmonic(self, n: int, omega: np.ndarray, A: np.ndarray, outputs: np.ndarray | None = None) -> np.ndarray:
        """c_n (q, m) if n psi turns with omega (q,) [rad/s].

        A: of the linear model of these states; outputs: results by states, in place of those of the mean.
        """
        C = self.outputs if outputs is None else outputs
        c = self.direct[n] + self._moved(n, omega, A) @ C.T
        if n > 1:
            c = c + self._moved(n - 1, omega * (n - 1) / n, A) @ self.turning.T
        return c + self._moved(n + 1, omega * (n + 1) / n, A) @ self.turning.conj().T

    def _moved(self, n: int, omega: np.ndarray, A: np.ndarray) -> np.ndarray:
        """States (q, states)."""
        rates = np.broadcast_to(self.rates[n][:, None, None], (len(A), omega.size, 1))
        return Resolvent(omega, A)(rates)[:, :, 0].T


@dataclass(frozen=True, eq=False)
class Rotation:
    """Results of a steady operation, in their units: mean (m,); driven: what each rotor drives.

    A: of the linear model of the states about the mean.
    """

    mean: np.ndarray
    driven: tuple[Driven, ...]
    A: np.ndarray

    @cached_property
    def harmonics(self) -> tuple[np.ndarray, ...]:
        """By rotor, complex c_n (n, m) from n = 1."""
        return tuple(
            np.concatenate([one.harmonic(n, np.array([n * one.speed]), self.A) for n in range(1, HARMONICS + 1)])
            for one in self.driven
        )

    @property
    def variance(self) -> np.ndarray:
        """Mean squares (rotors, n, m) of the parts."""
        return np.array([2 * np.abs(c) ** 2 for c in self.harmonics])

    def values(self, azimuths: Sequence[float]) -> np.ndarray:
        """The results (m,) at azimuths [rad], one for each rotor."""
        total = self.mean.astype(float).copy()
        for c, psi in zip(self.harmonics, azimuths, strict=True):
            phases = np.exp(1j * np.arange(1, len(c) + 1) * psi)
            total += 2 * (phases @ c).real
        return total


def steady_rotation(plant: Any, state: State, names: Sequence[str], rotating: RotatingLinearModel) -> Rotation:
    """Harmonics over a revolution at a mean state of results or variables, those of the linear model there.

    rotating: `rotating_linear_model(plant, state, (), names, ...)` of a state in which rotors turn.
    """
    average, mean, scale = rotating.average, rotating.mean, rotating.scale.ravel()
    at, count = average.at, rotating.results
    observe = at.functions.observed([plant.outputs.entry(name).path for name in names])
    y = average.multiblade.from_states(state.x)
    speeds = np.array(rotating.speeds)
    v, free, points = average.speeds, average.free, FINER * average.azimuths

    def sweep(rotor: int | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rates, residuals of the equations of motion and results at the azimuths."""
        rows = []
        for k in range(points):
            turned = average.turned(k / points, y, rotor)
            x, z = average.point(round(k / FINER) % average.azimuths, turned, speeds)
            ode, alg = (np.array(value).ravel() for value in at.residual(average.t, x, z, average.q))
            force = (average.multiblade.equations(turned) @ alg)[average.motion]
            values = np.array(at.call(observe, average.t, x, z, average.q)).ravel()
            rows.append((average.multiblade.inverse(turned) @ ode, force, values))
        return tuple(np.array(column) for column in zip(*rows, strict=True))

    together = sweep(None)
    found = []
    A = mean.slopes[np.ix_(free, free)]
    for rotor, (turn, speed) in enumerate(zip(average.turns, speeds.tolist(), strict=True)):
        table = together if len(average.turns) == 1 else sweep(rotor)
        rates, force, values = (np.fft.fft(part, axis=0)[: HARMONICS + 2] / points for part in table)
        psi = state.x[turn.azimuth]  # the points begin there
        phases = np.exp(-1j * np.arange(HARMONICS + 2) * psi)[:, None]
        rates, force, values = rates * phases, force * phases, values * phases
        accelerations = -np.linalg.solve(mean.mass, force.T).T
        rates[:, v] = accelerations
        rates -= np.outer(rates[:, turn.azimuth], turn.direction)
        rates, accelerations[0] = rates[:, free], 0.0
        rates[0] = 0.0
        C, C1 = mean.outputs[:count, free], mean.turning[rotor][:count, free]
        a, a1 = mean.by_rates[:count], mean.turning_by_rates[rotor][:count]
        direct = values + accelerations @ a.T
        direct[1:] += accelerations[:-1] @ a1.T
        direct[:-1] += accelerations[1:] @ a1.conj().T
        found.append(Driven(speed, rates, direct * scale, scale[:, None] * C, scale[:, None] * C1))
    return Rotation(together[2].mean(axis=0) * scale, tuple(found), A)
