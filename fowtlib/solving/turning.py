"""The mean state of a model whose rotors turn: nothing changes on the average over a revolution.

A rotor of blade elements has no equilibrium: its loads depend on its azimuth. With x = T(psi) y + psi s, where psi is
the azimuth, T the transformation of the blades to multi-blade coordinates (solving.multiblade) and s the direction in
which the rotor and what is geared to it turn, the rates of y are averaged over equally spaced azimuths, and y is sought
at which their mean vanishes. This is the harmonic balance of order zero in the frame that does not turn: the platform,
the tower, the mean of each blade and the controller are those of the steady operation, and what the blades do once in
a revolution, such as their sagging edgewise, is in it too, as the constant cosine and sine of their motion. Several
rotors turn at their own speeds, and are averaged together. The state that is found lies on this steady operation, at
the azimuths of the start.

The way there is that of the equilibrium: implicit Euler steps of growing length (pseudo-transient continuation, C. T.
Kelley and D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508). But bodies do not travel along it: their positions are
those that rest under the loads of each step, and the speeds of rotors, controllers and wakes alone take their time. A
platform that drifts to its mean would take wind from its rotors, and lead them through regions of the controller that
the mean has nothing to do with; near rated wind these corners stop every step. Where nothing rests, as without a
mooring, positions take their time too. The search goes over few azimuths, and over all of them at its end.
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
from fowtlib.solving.multiblade import Multiblade, Turn
from fowtlib.solving.pace import mean_announcement
from fowtlib.solving.rates import rate_states

if TYPE_CHECKING:
    from fowtlib.solving.state import State

Plant = Any
"""fowtlib.solving.plant.Plant, whose runs may start from a mean state."""

# Azimuths of a revolution. Numbers that no number of blades divides: three blades stand at 69 places, near enough for
# the dam of the air in front of the tower. Surge of the OC3 spar at 16 m/s: 13.26 m of 11, 13.33 m of 23, 13.34 of 31.
AZIMUTHS, FEW = 23, 5
STEPS_OF = {AZIMUTHS: (1, 5, 7, 11), FEW: (1, 2)}  # by which several rotors go on
GEARED = 1e-3  # of the largest: the torque of an angle that turns with the rotor
STEPS = 80
NEWTON = 8  # iterations of a step
ITERATIONS = 20
FIRST, SHORTEST = 0.5, 1e-6  # steps [s]
# The longest step [s], the last change over 1 + value, and how well a step is solved: of the mean, and near it.
EXACT, NEAR = (1e4, 1e-7, 1e-4), (100.0, 1e-2, 3e-2)


Jacobian = Callable[..., Sequence[Any]]
"""`(t, x, z, q) -> d ode/dx, d ode/dz, d alg/dx, d alg/dz`, and where outputs are averaged too, theirs by x and z."""


def mean_state(plant: Plant, parameters: Mapping[str, Any] | None = None, inputs: Mapping[str, Any] | None = None, *,
               near: bool = False, start: State | None = None) -> State:  # fmt: skip
    """The state at which nothing changes on the average; the equilibrium where no rotor turns at the start.

    near: a state near to it, to start a simulation from, in half the time: of fewer azimuths, to 1 %.
    start: where the search begins, such as the mean state in another wind; None: at the start values.

    What was found once for the same equations and numbers is found again on disk. The controllers are in the loop. The
    azimuths are those of the start. Raises SimulationError where the equations depend on time (turbulent wind, waves),
    and where no mean state is found.
    """
    names = [item.path for item in plant.dae.states]
    values = None if start is None else dict(zip(names, start.x.tolist(), strict=True))
    state = plant.initial_state(parameters, values, inputs)
    at = plant.at(parameters)
    if not _moving_azimuths(at, state)[0]:
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
        turns = turns_of(plant, at, state)
        average = Average(at, state, turns, FEW)
        y = _found(average, average.multiblade.from_states(state.x), NEAR)
        if not near:
            average = Average(at, state, turns, AZIMUTHS)
            y = _settled(average, y, EXACT, 3 * EXACT[0])
        return average.multiblade.to_states(y)

    equations = _equations(at)
    code = sources_of(__name__, Multiblade.__module__)
    made_from = [*code, repr((azimuths, limits)), equations or "", at.parameters, state.x, state.u, state.d]
    x = np.array(cached("mean", made_from, settled)) if equations else settled()
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
    azimuths, speed = _moving_azimuths(at, state)
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


def _moving_azimuths(at: AtParameters, state: State) -> tuple[list[int], np.ndarray]:
    """Numbers of the azimuths that move at the start, and the rates of all states."""
    dae = at.dae
    if not dae.symmetries:
        return [], np.zeros(0)
    numbers = {symbol.element_hash(): i for i, symbol in enumerate(dae.x.elements())}
    angles = {numbers.get(ring.angle.element_hash()) for ring in dae.symmetries} - {None}
    speed = np.array(at.residual(state.t, state.x, state.z, np.concatenate([state.u, state.d]))[0]).ravel()
    return sorted(k for k in angles if abs(speed[k]) > 1e-9), speed


@dataclass
class Sums:
    """Sums over the azimuths of a revolution, divided by their number; see Average.

    y are the coordinates that do not turn, g the rates of the speeds that a steady y has, [y u] the columns.
    outputs: by the number of a rotor (None: none) their mean with exp(-i psi) of that rotor, each a triple: by [y u] at
    given rates of the speeds; by these rates; by the speed of each rotor through the rates.
    """

    rates: np.ndarray
    slopes: np.ndarray
    force: np.ndarray
    force_slopes: np.ndarray
    mass: np.ndarray
    swung: np.ndarray
    outputs: dict[int | None, tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class MeanSlopes:
    """Mean rates (n,) of the coordinates that do not turn, and their slopes (n, n + inputs) by these and by the inputs.

    outputs: (m, n + inputs) their mean slopes. turning: by rotor, the complex slopes C1 of what goes round with it:
    an output is `outputs @ y + 2 Re(C1 exp(i psi) @ y)`, with the azimuth psi. mass: what rates of the speeds do in the
    equations of motion; by_rates, turning_by_rates: the same of the outputs by these rates alone.
    """

    rates: np.ndarray
    slopes: np.ndarray
    outputs: np.ndarray
    turning: tuple[np.ndarray, ...]
    mass: np.ndarray
    by_rates: np.ndarray
    turning_by_rates: tuple[np.ndarray, ...]


class Average:
    """Mean rates of the states behind the azimuths, and their slopes, in coordinates y that do not turn.

    x = T(psi) y with the multi-blade coordinates of the blades (solving.multiblade), so that a constant y has blades
    that go through the same motion once in a revolution. Averaged are forces, not accelerations: M(psi) a = F(psi), and
    a mean of M^-1 F would let what goes round with the blades fall freely for a part of each turn. So the accelerations
    are held at those of a constant y, g = T' dpsi/dt y, the residual of the equations of motion is averaged, and the
    rates are those that the mean mass gives to the mean force.

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
        self.multiblade = Multiblade(at.dae, turns)
        self.free = np.array([k for k in range(state.x.size) if k not in out and used[k]])
        rates = rate_states(at.dae)
        self.taking_time = np.array([k not in rates for k in self.free])  # free coordinates that are no positions
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
        for ring in self.multiblade.rings:
            speeds = sum(set(numbers) <= set(self.speeds) for numbers in ring.states.tolist())
            rows = sum(set(numbers) <= set(self.motion) for numbers in ring.rows.tolist())
            if speeds != rows:
                raise SimulationError(
                    f"no mean state: the equations of motion of {', '.join(ring.parts)} are not alike, though the "
                    "model says that these parts are. Take the mean of a simulation."
                )

    def at_state(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean rates (n,) of the free coordinates and their slopes (n, n)."""
        found = self.at_mean(y)
        return found.rates[self.free], found.slopes[np.ix_(self.free, self.free)]

    def at_mean(self, y: np.ndarray) -> MeanSlopes:
        """Mean rates and slopes of all coordinates, and of the outputs that the Jacobian has rows for."""
        v, turns, n = self.speeds, self.turns, y.size
        speeds = self.rotor_speeds(y)
        inner = [self.multiblade.inverse(y) @ self.multiblade.slopes(y, turn) for turn in turns]
        sums: Sums | None = None
        for k in range(self.azimuths):
            sums = _added(sums, self._at_azimuth(k, y, speeds), self.azimuths)
        rates, slopes = sums.rates, sums.slopes
        for speed, S, turn in zip(speeds, inner, turns, strict=True):  # y' = inv(T) x' - S dpsi/dt y
            rates -= speed * S @ y
            slopes[:, :n] -= speed * S
            slopes -= np.outer(S @ y, slopes[turn.azimuth])
        by_rotor = slopes[[turn.azimuth for turn in turns]]
        rates[v] = -np.linalg.solve(sums.mass, sums.force)
        slopes[v] = -np.linalg.solve(sums.mass, sums.force_slopes + sums.swung @ by_rotor)
        outputs = {key: given + by_rate @ slopes[v] + by_speed @ by_rotor
                   for key, (given, by_rate, by_speed) in sums.outputs.items()}  # fmt: skip
        for turn in turns:  # what turns with the rotor stands in the frame that turns
            rates = rates - turn.direction * rates[turn.azimuth]
            slopes = slopes - np.outer(turn.direction, slopes[turn.azimuth])
        rotors = range(len(turns))
        return MeanSlopes(rates, slopes, outputs[None].real, tuple(outputs[k] for k in rotors), sums.mass,
                          sums.outputs[None][1].real, tuple(sums.outputs[k][1] for k in rotors))  # fmt: skip

    def rotor_speeds(self, y: np.ndarray) -> np.ndarray:
        """Rates of the azimuths [rad/s]."""
        ode = np.array(self.at.residual(self.t, self.multiblade.to_states(y), self.z[0], self.q)[0]).ravel()
        return ode[[turn.azimuth for turn in self.turns]]

    def turned(self, share: float, y: np.ndarray, rotor: int | None = None) -> np.ndarray:
        """The coordinates with the azimuths at a share of a revolution further on, of all rotors or of one.

        Several rotors go on by different steps, so that what is a product of the harmonics of two of them has no mean.
        """
        steps = STEPS_OF[self.azimuths]
        angle = 2 * np.pi * share
        if rotor is not None:
            return y + angle * self.turns[rotor].direction
        return y + sum(angle * steps[k % len(steps)] * turn.direction for k, turn in enumerate(self.turns))

    def point(self, number: int, y: np.ndarray, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and unknowns of steady coordinates, with their azimuths.

        number: of the point of a revolution that is next to these. speeds: of the rotors [rad/s].
        """
        x = self.multiblade.to_states(y)
        z = self._unknowns(number, x, self._swing(y, speeds) @ y)
        self.z[number] = z
        return x, z

    def _swing(self, y: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        """Rates of the speeds by the coordinates, where these are constant."""
        swings = [speed * self.multiblade.slopes(y, turn) for speed, turn in zip(speeds, self.turns, strict=True)]
        return sum(swings)[self.speeds]

    def _at_azimuth(self, number: int, y: np.ndarray, speeds: np.ndarray) -> Sums:
        """What one azimuth adds to the sums."""
        a, o, m, r, v = self.accelerations, self.unknowns, self.motion, self.others, self.speeds
        y = self.turned(number / self.azimuths, y)
        T, R = self.multiblade.states(y), self.multiblade.equations(y)
        x, z = self.point(number, y, speeds)
        ode, alg = (np.array(value).ravel() for value in self.at.residual(self.t, x, z, self.q))
        blocks = [np.array(block) for block in self.jacobian(self.t, x, z, self.q)]
        self.slopes[number] = blocks
        xx, xz, zx, zz, *outputs = blocks
        out_x, out_z = outputs or (np.zeros((0, xx.shape[1])), np.zeros((0, z.size)))
        by_x = np.zeros((z.size, xx.shape[1]))
        by_x[o] = -np.linalg.solve(zz[np.ix_(r, o)], zx[r])
        by_x[a] = -np.linalg.solve(xz[np.ix_(v, a)], xx[v] + xz[np.ix_(v, o)] @ by_x[o])
        by_rate = np.linalg.inv(xz[np.ix_(v, a)])
        n = y.size

        def fixed(rows: np.ndarray) -> np.ndarray:
            """Columns by y in place of x."""
            return np.hstack([rows[:, :n] @ T, rows[:, n:]])

        back, of_motion, Tv = self.multiblade.inverse(y), R[np.ix_(m, m)], T[np.ix_(v, v)]
        mass = of_motion @ zz[np.ix_(m, a)] @ by_rate
        moving = self._swing(y, speeds)  # dg/dy
        swung = np.stack([self.multiblade.slopes(y, turn)[v] @ y for turn in self.turns], axis=1)  # dg/d(speed of each)
        force_slopes = of_motion @ fixed(zx[m] + zz[m] @ by_x)
        force_slopes[:, :n] += mass @ moving
        shown, by_acceleration = fixed(out_x + out_z @ by_x), out_z[:, a] @ by_rate
        shown[:, :n] += by_acceleration @ moving
        triple = (shown, by_acceleration @ Tv, by_acceleration @ swung)
        phases = {None: 1.0} | {k: np.exp(-1j * y[turn.azimuth]) for k, turn in enumerate(self.turns)}
        return Sums(back @ ode, back @ fixed(xx + xz @ by_x), of_motion @ alg[m], force_slopes, mass @ Tv, mass @ swung,
                    {key: tuple(phase * part for part in triple) for key, phase in phases.items()})  # fmt: skip

    def _unknowns(self, number: int, x: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """The unknowns at one azimuth, at given rates of the speeds, by Newton with the slopes of the last visit."""
        a, o, r, v = self.accelerations, self.unknowns, self.others, self.speeds
        z, blocks = self.z[number], self.slopes[number]
        for iteration in range(ITERATIONS):
            if blocks is None or iteration % 6 == 5:
                blocks = [np.array(block) for block in self.jacobian(self.t, x, z, self.q)]
            _, xz, _, zz, *_ = blocks
            ode, alg = (np.array(value).ravel() for value in self.at.residual(self.t, x, z, self.q))
            step = np.zeros(z.size)
            step[o] = -np.linalg.solve(zz[np.ix_(r, o)], alg[r])
            step[a] = -np.linalg.solve(xz[np.ix_(v, a)], ode[v] - rate + xz[np.ix_(v, o)] @ step[o])
            z = z + step
            if not np.all(np.isfinite(z)):
                break
            if np.max(np.abs(step) / (1 + np.abs(z)), initial=0.0) < 1e-9:
                return z
        raise SimulationError("the unknowns of a turned rotor do not settle")


def _added(sums: Sums | None, more: Sums, count: int) -> Sums:
    """The sums with those of one more azimuth."""
    parts = ("rates", "slopes", "force", "force_slopes", "mass", "swung")
    share = {name: getattr(more, name) / count for name in parts}
    outputs = {key: tuple(part / count for part in triple) for key, triple in more.outputs.items()}
    if sums is not None:
        share = {name: getattr(sums, name) + value for name, value in share.items()}
        outputs = {key: tuple(a + b for a, b in zip(sums.outputs[key], triple, strict=True))
                   for key, triple in outputs.items()}  # fmt: skip
    return Sums(**share, outputs=outputs)


def _found(average: Average, x: np.ndarray, goal: tuple[float, float, float]) -> np.ndarray:
    """States at which the mean rates vanish, on the way on which bodies rest, or else on that on which they move."""
    try:
        return _settled(average, x, goal, FIRST, resting=True)
    except SimulationError:
        return _settled(average, x, goal, FIRST)


def _settled(average: Average, x: np.ndarray, goal: tuple[float, float, float], length: float,
             resting: bool = False) -> np.ndarray:  # fmt: skip
    """States at which the mean rates vanish.

    length: of the first step [s]. resting: positions are those that rest under the loads of a step.
    """
    x = x.copy()
    longest, settled, close = goal
    taking = average.taking_time if resting else np.ones(len(average.free), bool)
    rates, slopes = average.at_state(x)
    for _ in range(STEPS):
        try:
            after = _implicit_euler(average, x, rates, slopes, taking / length, close)
        except (SimulationError, np.linalg.LinAlgError):
            after = None
        if after is None:
            length /= 4
            if length < SHORTEST:
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


def _implicit_euler(average: Average, before: np.ndarray, rates: np.ndarray, slopes: np.ndarray, pace: np.ndarray,
                    close: float) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:  # fmt: skip
    """States, mean rates and slopes one step later; None where Newton does not settle.

    pace: of each free coordinate, one over the length of the step [1/s]; zero: its rate vanishes at the end of it.
    """
    free, x, last = average.free, before.copy(), np.inf
    for _ in range(NEWTON):
        step = np.linalg.solve(np.diag(pace) - slopes, rates - (x - before)[free] * pace)
        size = float(np.max(np.abs(step) / (1 + np.abs(x[free]))))
        if not np.isfinite(size) or size > 2 * last:
            return None
        x[free] += step
        rates, slopes = average.at_state(x)
        last = size
        if size < close:
            return x, rates, slopes
    return None
