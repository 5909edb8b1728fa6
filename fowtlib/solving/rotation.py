"""What goes round in a steady operation: the harmonics of results over a revolution, without a run.

The mean state balances the mean of the loads in the frame that does not turn, and has the motion of the blades once in
a revolution. What is left over at each azimuth, of the shear and the dam of the tower on blades that pass, of gravity
on blades that are bent, drives the linear model about the mean with multiples of the rotor speed. So a result is

    mean + sum over the rotors and n of 2 Re(c_n exp(i n psi)),

with c_n from the results at the azimuths of the mean state itself (which is exact), and from the forced motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.solving.mean_linear import RotatingLinearModel
from fowtlib.solving.state import State

HARMONICS = 12  # of the rotor speed
FINER = 3  # points for one of the mean: a single blade passes the tower at few of those


@dataclass(frozen=True, eq=False)
class Rotation:
    """Results of a steady operation, in their units: mean (m,); harmonics: by rotor, complex c_n (n, m) from n = 1.

    speeds: of the rotors [rad/s].
    """

    mean: np.ndarray
    harmonics: tuple[np.ndarray, ...]
    speeds: tuple[float, ...]

    def values(self, azimuths: Sequence[float]) -> np.ndarray:
        """The results (m,) at azimuths [rad], one for each rotor."""
        total = self.mean.astype(float).copy()
        for c, psi in zip(self.harmonics, azimuths, strict=True):
            phases = np.exp(1j * np.arange(1, len(c) + 1) * psi)
            total += 2 * (phases @ c).real
        return total

    @property
    def variance(self) -> np.ndarray:
        """Mean squares (rotors, n, m) of the parts."""
        return np.array([2 * np.abs(c) ** 2 for c in self.harmonics])


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
        moved = np.zeros((HARMONICS + 2, len(free)), dtype=complex)
        for n in range(1, HARMONICS + 2):
            moved[n] = np.linalg.solve(1j * n * speed * np.eye(len(free)) - A, rates[n, free])
        accelerations[0] = 0.0
        C, C1 = mean.outputs[:count, free], mean.turning[rotor][:count, free]
        a, a1 = mean.by_rates[:count], mean.turning_by_rates[rotor][:count]
        direct = moved @ C.T + accelerations @ a.T
        ahead = moved @ C1.T + accelerations @ a1.T  # times exp(i psi)
        behind = moved @ C1.conj().T + accelerations @ a1.conj().T
        c = values + direct
        c[1:] += ahead[:-1]
        c[:-1] += behind[1:]
        found.append(c[1 : HARMONICS + 1] * scale)
    return Rotation(together[2].mean(axis=0) * scale, tuple(found), tuple(speeds.tolist()))
