"""The mean state of a model whose rotors turn: nothing changes on the average over a revolution.

A rotor of blade elements has no equilibrium: its loads depend on its azimuth. With x = y + psi s, where psi is the
azimuth and s the direction in which the rotor and what is geared to it turn, the rates f(x) are averaged over equally
spaced azimuths, and y is sought at which the mean of f - s dpsi/dt vanishes. This is the harmonic balance of order
zero: the platform, the tower, the mean of each blade and the controller are those of the steady operation, and what
goes round with the blades, such as their sagging edgewise, has a mean of zero. Several rotors turn at their own speeds,
and are averaged together.

The way there is that of the equilibrium: implicit Euler steps of growing length (pseudo-transient continuation, C. T.
Kelley and D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from fowtlib.language.cache import cached
from fowtlib.language.cache import sources as sources_of
from fowtlib.language.errors import SimulationError
from fowtlib.language.externals import LibraryFunction
from fowtlib.language.tables import SplineFunction
from fowtlib.solving.equilibrium import dependence, time_dependence
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.modes import rate_states
from fowtlib.solving.pace import mean_announcement

if TYPE_CHECKING:
    from fowtlib.solving.state import State

Plant = Any
"""fowtlib.solving.plant.Plant, whose runs may start from a mean state."""

# Azimuths of a revolution. Numbers that no number of blades divides: three blades stand at 69 places, near enough for
# the dam of the air in front of the tower. Surge of the OC3 spar at 16 m/s: 13.26 m of 11, 13.33 m of 23, 13.34 of 31.
AZIMUTHS, FEW = 23, 5
GEARED = 1e-3  # of the largest: the torque of an angle that turns with the rotor
STEPS = 80
NEWTON = 8  # iterations of a step
ITERATIONS = 20
# The longest step [s], the last change over 1 + value, and how well a step is solved: of the mean, and near it.
EXACT, NEAR = (1e4, 1e-7, 1e-4), (100.0, 1e-2, 3e-2)


Jacobian = Callable[..., Sequence[Any]]
"""`(t, x, z, q) -> d ode/dx, d ode/dz, d alg/dx, d alg/dz`, and where outputs are averaged too, theirs by x and z."""


@dataclass(frozen=True)
class Turn:
    """A rotor that turns: the number of its azimuth among the states, and the change of all states with it."""

    azimuth: int
    direction: np.ndarray


def mean_state(plant: Plant, parameters: Mapping[str, Any] | None = None, inputs: Mapping[str, Any] | None = None, *,
               near: bool = False) -> State:  # fmt: skip
    """The state at which nothing changes on the average; the equilibrium where no rotor turns at the start.

    near: a state near to it, to start a simulation from, in half the time: of fewer azimuths, to 1 %.

    What was found once for the same equations and numbers is found again on disk. The controllers are in the loop. The
    azimuths are those of the start. Raises SimulationError where the equations depend on time (turbulent wind, waves),
    and where no mean state is found.
    """
    state = plant.initial_state(parameters, None, inputs)
    at = plant.at(parameters)
    turns = turns_of(plant, at, state)
    if not turns:
        return plant.equilibrium(parameters, inputs=inputs)
    sources = time_dependence(at, state.d)
    if sources:
        raise SimulationError(
            f"no mean state: the equations depend on time through {', '.join(sources[:4])}. "
            "Take still water and steady wind (--waves still, --wind steady:8)."
        )
    azimuths, limits = (FEW, NEAR) if near else (AZIMUTHS, EXACT)

    def settled() -> np.ndarray:
        if line := mean_announcement(at, (state.t, state.x, state.z, np.concatenate([state.u, state.d])), azimuths):
            warnings.warn(line, RuntimeWarning, stacklevel=2)
        return _settled(Average(at, state, turns, azimuths), state.x, limits)

    equations = _equations(at)
    made_from = [*sources_of(__name__), repr((azimuths, limits)), equations or "", at.parameters, state.x, state.u]
    x = np.array(cached("mean", [*made_from, state.d], settled)) if equations else settled()
    names = [item.path for item in plant.dae.states]
    return plant.initial_state(parameters, dict(zip(names, x.tolist(), strict=True)), inputs)


def _equations(at: AtParameters) -> str | None:
    """All that rates and loads are made from but numbers of the run, as a text; None where Python code is in them."""
    dae = at.dae
    if not all(isinstance(item.function, SplineFunction | LibraryFunction) for item in dae.externals):
        return None
    symbols = [dae.t, dae.x, dae.z, dae.u, dae.d, dae.p, dae.w]
    function = ca.Function("equations", symbols, [dae.ode, dae.alg, *(ca.vec(item.inputs) for item in dae.externals)])
    tables = [item.function.data for item in dae.externals if isinstance(item.function, SplineFunction)]
    numbers = [array.tobytes().hex() for table in tables for array in (*table.knots, table.coefficients)]
    libraries = [str(item.function.path) for item in dae.externals if isinstance(item.function, LibraryFunction)]
    return "\n".join([function.serialize(), *libraries, *numbers])


def turns_of(plant: Plant, at: AtParameters, state: State) -> list[Turn]:
    """The rotors whose azimuth moves at the start, each with what is geared to it.

    The angle of a gear belongs to the rotor whose azimuth its acceleration depends on; they turn as their rates say.
    """
    dae = plant.dae
    numbers = {dae.x[i].element_hash(): i for i in range(dae.x.shape[0])}
    angles = {numbers.get(ring.angle.element_hash()) for ring in dae.symmetries} - {None}
    speed = np.array(at.residual(state.t, state.x, state.z, np.concatenate([state.u, state.d]))[0]).ravel()
    azimuths = sorted(k for k in angles if abs(speed[k]) > 1e-9)
    if not azimuths:
        return []
    inside = tuple(f"{part}." for ring in dae.symmetries for part in ring.parts)
    rates = rate_states(dae)
    geared = [
        k for k, rate in rates.items()
        if dae.states[k].unit == "rad" and k not in azimuths and abs(state.x[rate]) > 1e-9
        and not dae.states[k].path.startswith(inside)
    ]  # fmt: skip
    blocks = at.jacobian(state.t, state.x, state.z, np.concatenate([state.u, state.d]))
    xx, xz, zx, zz = (np.array(block) for block in blocks)
    A = xx - xz @ np.linalg.solve(zz, zx)
    directions = {k: np.zeros(len(speed)) for k in azimuths}
    for k in azimuths:
        directions[k][k] = 1.0
    for k in geared:
        row = np.abs(A[rates[k]])
        owner = max(azimuths, key=lambda azimuth: row[azimuth])
        if row[owner] > GEARED * row[k] > 0:
            directions[owner][k] = speed[k] / speed[owner]
    return [Turn(k, direction) for k, direction in directions.items()]


class Average:
    """Mean rates of the states behind the azimuths, and their slopes.

    Averaged are forces, not accelerations: M(psi) a = F(psi), and a mean of M^-1 F would let what goes round with the
    blades fall freely for a part of each turn. So the accelerations are held at zero, the residual of the equations of
    motion is averaged, and the rates are those that the mean mass gives to the mean force.

    jacobian: in place of that of the functions, with further columns behind those of x.
    """

    def __init__(self, at: AtParameters, state: State, turns: list[Turn], azimuths: int,
                 jacobian: Jacobian | None = None):  # fmt: skip
        self.at, self.t, self.turns = at, state.t, turns
        self.jacobian = jacobian or at.jacobian
        self.q = np.concatenate([state.u, state.d])
        self.azimuths = azimuths
        self.z = [state.z.copy() for _ in range(azimuths)]
        self.slopes: list[Any] = [None] * azimuths
        out = {turn.azimuth for turn in turns}
        used = dependence(at.functions).any(axis=0)
        self.free = np.array([k for k in range(state.x.size) if k not in out and used[k]])
        self._find_accelerations()

    def _find_accelerations(self) -> None:
        """Numbers of the unknowns that are accelerations, of the equations of motion, and of the speeds they change."""
        _, by_z, _, zz = (self.at.functions.jacobian.sparsity_out(k) for k in range(4))
        rates = set(rate_states(self.at.dae).values())
        pairs = [(row, column) for row, column in zip(*by_z.get_triplet(), strict=True) if row in rates]
        self.accelerations = sorted({column for _, column in pairs})
        self.speeds = sorted({row for row, _ in pairs})
        inside = zip(*zz.get_triplet(), strict=True)
        self.motion = sorted({row for row, column in inside if column in set(self.accelerations)})
        if not len(self.accelerations) == len(self.speeds) == len(self.motion):
            raise SimulationError(
                "no mean state: the equations of motion of this model cannot be told from its other ones. Start from "
                "the values of the model, and take the mean of a simulation."
            )
        self.others = [k for k in range(zz.shape[0]) if k not in set(self.motion)]
        self.unknowns = [k for k in range(zz.shape[1]) if k not in set(self.accelerations)]

    def at_state(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean rates (n,) of the free states and their slopes (n, n)."""
        rates, slopes = self.of_all(x)
        return rates[self.free], slopes[np.ix_(self.free, self.free)]

    def of_all(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean rates of all states, and their slopes by these, and by what else the Jacobian has columns for."""
        rates, slopes, _ = self.with_outputs(x)
        return rates, slopes

    def with_outputs(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same, and the mean slopes of the outputs that the Jacobian has rows for.

        What an output has of accelerations, it has of the mean ones.
        """
        together = sum(turn.direction for turn in self.turns)
        sums: list[Any] = [0.0] * 7
        for k in range(self.azimuths):
            values = self._at_azimuth(k, x + 2 * np.pi * k / self.azimuths * together)
            sums = [total + value / self.azimuths for total, value in zip(sums, values, strict=True)]
        rates, slopes, force, force_slopes, mass, output_slopes, by_acceleration = sums
        rates[self.speeds] = -np.linalg.solve(mass, force)
        slopes[self.speeds] = -np.linalg.solve(mass, force_slopes)
        for turn in self.turns:  # what turns with the rotor stands in the frame that turns
            rates = rates - turn.direction * rates[turn.azimuth]
            slopes = slopes - np.outer(turn.direction, slopes[turn.azimuth])
        return rates, slopes, output_slopes + by_acceleration @ slopes[self.speeds]

    def _at_azimuth(self, number: int, x: np.ndarray) -> tuple[np.ndarray, ...]:
        """Rates and slopes without accelerations; residual of the equations of motion, its slopes, and the mass.

        Behind them, of the outputs: slopes without accelerations, and by the rates of the speeds.
        """
        a, o, m, r, v = self.accelerations, self.unknowns, self.motion, self.others, self.speeds
        z = self._unknowns(number, x)
        ode, alg = (np.array(value).ravel() for value in self.at.residual(self.t, x, z, self.q))
        blocks = [np.array(block) for block in self.jacobian(self.t, x, z, self.q)]
        self.z[number], self.slopes[number] = z, blocks
        xx, xz, zx, zz, *outputs = blocks
        out_x, out_z = outputs or (np.zeros((0, xx.shape[1])), np.zeros((0, z.size)))
        by_x = np.zeros((z.size, xx.shape[1]))
        by_x[o] = -np.linalg.solve(zz[np.ix_(r, o)], zx[r])
        by_x[a] = -np.linalg.solve(xz[np.ix_(v, a)], xx[v] + xz[np.ix_(v, o)] @ by_x[o])
        by_rate = np.linalg.inv(xz[np.ix_(v, a)])
        mass = zz[np.ix_(m, a)] @ by_rate
        return (ode, xx + xz @ by_x, alg[m], zx[m] + zz[m] @ by_x, mass,
                out_x + out_z @ by_x, out_z[:, a] @ by_rate)  # fmt: skip

    def _unknowns(self, number: int, x: np.ndarray) -> np.ndarray:
        """The unknowns at one azimuth, without accelerations, by Newton with the slopes of the last visit."""
        a, o, r, v = self.accelerations, self.unknowns, self.others, self.speeds
        z, blocks = self.z[number], self.slopes[number]
        for iteration in range(ITERATIONS):
            if blocks is None or iteration % 6 == 5:
                blocks = [np.array(block) for block in self.jacobian(self.t, x, z, self.q)]
            _, xz, _, zz, *_ = blocks
            ode, alg = (np.array(value).ravel() for value in self.at.residual(self.t, x, z, self.q))
            step = np.zeros(z.size)
            step[o] = -np.linalg.solve(zz[np.ix_(r, o)], alg[r])
            step[a] = -np.linalg.solve(xz[np.ix_(v, a)], ode[v] + xz[np.ix_(v, o)] @ step[o])
            z = z + step
            if not np.all(np.isfinite(z)):
                break
            if np.max(np.abs(step) / (1 + np.abs(z)), initial=0.0) < 1e-9:
                return z
        raise SimulationError("the unknowns of a turned rotor do not settle")


def _settled(average: Average, x: np.ndarray, goal: tuple[float, float, float]) -> np.ndarray:
    """States at which the mean rates vanish."""
    x, length = x.copy(), 0.5
    longest, settled, close = goal
    rates, slopes = average.at_state(x)
    for _ in range(STEPS):
        try:
            after = _implicit_euler(average, x, rates, slopes, length, close)
        except (SimulationError, np.linalg.LinAlgError):
            after = None
        if after is None:
            length /= 4
            if length < 1e-6:
                break
            continue
        moved = float(np.max(np.abs(after[0] - x) / (1 + np.abs(after[0]))))
        x, rates, slopes = after
        if length > longest and moved < settled:
            return x
        length = min(3 * length, 1e6)
    states = average.at.dae.states
    worst = states[average.free[int(np.argmax(np.abs(rates)))]].path
    raise SimulationError(
        f"no mean state found: {worst} does not settle. Start from other values, or take the mean of a simulation."
    )


def _implicit_euler(average: Average, before: np.ndarray, rates: np.ndarray, slopes: np.ndarray,
                    length: float, close: float) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:  # fmt: skip
    """States, mean rates and slopes one step later; None where Newton does not settle."""
    free, identity, x, last = average.free, np.eye(len(average.free)), before.copy(), np.inf
    for _ in range(NEWTON):
        step = np.linalg.solve(identity / length - slopes, rates - (x - before)[free] / length)
        size = float(np.max(np.abs(step) / (1 + np.abs(x[free]))))
        if not np.isfinite(size) or size > 2 * last:
            return None
        x[free] += step
        rates, slopes = average.at_state(x)
        last = size
        if size < close:
            return x, rates, slopes
    return None
