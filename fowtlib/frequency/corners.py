"""Corners of control laws that the deviations of a response reach over, where its linear model is that of one side.

A law is the rate of a state that has corners in it (the larger or smaller of two, absolute values, conditions), depends
on states alone, and is no velocity: that of a controller, of an actuator with limits, of a part of one's own. At states
drawn from the Gaussian statistics of the response it is compared with its linear model. Where they differ by more than
a quarter of the size of the law, all slopes times the deviations of their states, the law is another one there. The
rate of an actuator is held by a limit as soon as what it follows has gone; so a law that pulls its state back is asked
how far the state would have to be for the rate of the linear model, and that times its slope is how they differ. The
state that tells best where that is, and the value at which it begins, are found by splitting the draws at one value of
one state.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from scipy.special import ndtri

from fowtlib.frequency.driven import frequency_widths
from fowtlib.solving import LinearModel, State
from fowtlib.solving.arrays import Arrays
from fowtlib.solving.rates import rate_states

LEAST = 0.05  # of the time beyond corners, from which it is told
CHANGED = 0.25  # of the size of a law, by which it is another one
DRAWS = 500
ROUNDING = 1e-6  # of the size of a law: what is less is none
LISTED = 4  # corners that a message names
CORNERS = frozenset(
    (ca.OP_FMIN, ca.OP_FMAX, ca.OP_FABS, ca.OP_SIGN, ca.OP_IF_ELSE_ZERO, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE,
     ca.OP_FLOOR, ca.OP_CEIL)
)  # fmt: skip
ADVICE = (
    "What the deviations and means may then be wrong by is told in docs/frequency.md, Beside runs. A single state with "
    'linearisation="equivalent" (--linearisation equivalent) knows of corners, and takes longer.'
)


class CornerWarning(UserWarning):
    """A response reaches over corners of control laws."""


@dataclass(frozen=True)
class Corner:
    """A corner that a law reaches over: with a probability it is another law, which begins at a border of a state.

    law: path of the state whose rate the law is. state: path of the one that tells, with its mean and deviation;
    above: whether the other law is above the border, else below. All in SI.
    """

    law: str
    probability: float
    state: str
    border: float
    above: bool
    mean: float
    deviation: float
    unit: str

    def __str__(self) -> str:
        share, side = f"{100 * self.probability:.0f} %", "above" if self.above else "below"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return (f"the law of {self.law} is another one in {share} of the time, where {self.state} is {side} "
                f"{self.border:.3g}{unit} ({self.mean:.3g} +- {self.deviation:.2g})")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Laws:
    """The laws with corners of a flat model: numbers of their states, and of all states that they follow from.

    pairs: of a law and a state that it follows from. values: the laws at DRAWS points, and each alone, from the states
    that are named in them (`moving`), at each point, and the elements of [t; q] that are (`held`), once: a model has a
    thousand parameters, and a law a dozen. slopes: `(t, x, z, q)` -> the laws by the states, (laws, states).
    """

    numbers: tuple[int, ...] = ()
    states: tuple[int, ...] = ()
    pairs: frozenset[tuple[int, int]] = frozenset()
    moving: tuple[int, ...] = ()
    held: tuple[int, ...] = ()
    values: Arrays | None = None
    alone: tuple[Arrays, ...] = ()
    slopes: ca.Function | None = None

    def at(self, values: Arrays, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        """The laws, or one of them, (DRAWS, n), at states x (DRAWS, all states), with [t; q] the same at all."""
        return values.entries(x[:, list(self.moving)], others[list(self.held)])[0].reshape(DRAWS, -1)


def laws_of(plant: Any, at: Any) -> Laws:
    """Those of a compiled model."""
    return plant.functions.once("laws with corners", lambda: _laws(at))


def _laws(at: Any) -> Laws:
    dae = at.dae
    velocities = {number for pair in rate_states(dae).items() for number in pair}
    numbers, pairs = [], set()
    for k, row in enumerate(ca.vertsplit(dae.ode)):
        if k in velocities or row.is_constant() or any(ca.depends_on(row, v) for v in (dae.z, dae.w)):
            continue
        function = ca.Function("law", [dae.x], [row], {"allow_free": True})
        if CORNERS.isdisjoint(function.instruction_id(i) for i in range(function.n_instructions())):
            continue
        numbers.append(k)
        pairs |= {(k, column) for column in function.jac_sparsity(0, 0).get_triplet()[1]}
    if not numbers:
        return Laws()
    chosen = sorted({column for _, column in pairs})
    rows = ca.densify(dae.ode[numbers])
    jacobian = ca.densify(ca.jacobian(rows, dae.x[chosen]))
    slopes = at.general.function("slopes_of_laws", [jacobian])
    named, others = {symbol.element_hash() for symbol in ca.symvar(rows)}, ca.vertcat(at.general.t, at.general.q)
    moving, held = ([k for k, symbol in enumerate(of.elements()) if symbol.element_hash() in named]
                    for of in (dae.x, others))  # fmt: skip

    def at_draws(row: ca.SX) -> Arrays:
        one = ca.Function("laws", [dae.x[moving], others[held]], [row])
        return Arrays(one.map("laws_at_draws", "serial", DRAWS, [1], []))

    alone = tuple(at_draws(row) for row in ca.vertsplit(rows))
    return Laws(tuple(numbers), tuple(chosen), frozenset(pairs), tuple(moving), tuple(held), at_draws(rows), alone,
                slopes)  # fmt: skip


def with_states(linear: LinearModel, outputs: int, rows: np.ndarray, names: Sequence[str]) -> LinearModel:
    """A linear model whose outputs are its first ones and then sums of its states, by rows (m, states)."""
    first = linear.first(outputs)
    C, D, operators = first.matrices["C"], first.matrices["D"], first.operators
    C, D = np.vstack([C, rows]), np.vstack([D, np.zeros((len(rows), D.shape[1]))])
    if operators is not None:
        more = np.zeros((len(rows), operators.D_output.shape[1]))
        operators = replace(operators, D_output=np.vstack([operators.D_output, more]))
    return LinearModel(first.matrices["A"], first.matrices["B"], C, D, linear.states, linear.inputs,
                       [*first.outputs, *names], linear.units, operators)  # fmt: skip


def covariance(H: Mapping[str, np.ndarray], spectra: Mapping[str, np.ndarray], frequency: np.ndarray) -> np.ndarray:
    """Of outputs (m,), from transfer functions (q, m, channels) and spectra per Hz of what drives them."""
    total, widths = np.zeros(()), frequency_widths(frequency)[:, None, None]
    for path, transfer in H.items():
        weighed = (transfer @ spectra[path]) * widths
        total = total + np.tensordot(weighed, transfer.conj(), ((0, 2), (0, 2))).real
    return np.asarray(total)


def reached(plant: Any, state: State, laws: Laws, known: Sequence[int], P: np.ndarray) -> tuple[Corner, ...]:
    """Corners that states with the covariance P about a mean state reach over, the most frequent first.

    known: numbers of these states. A law that follows from another state, which a model of turning rotors has in
    coordinates of its own, is left out.
    """
    if laws.values is None or laws.slopes is None or not len(known):
        return ()
    at, dae = plant.at(state.parameters), plant.dae
    found: list[Corner] = []
    values, axes = np.linalg.eigh((P + P.T) / 2)
    drawn = _normal(DRAWS, len(known))
    away = np.zeros((DRAWS, dae.x.numel()))
    away[:, list(known)] = (drawn * np.sqrt(np.maximum(values, 0.0))) @ axes.T
    away[0] = 0.0  # the mean itself
    deviation = np.zeros(dae.x.numel())
    deviation[list(known)] = np.sqrt(np.maximum(np.diag(P), 0.0))
    x, q = state.x + away, np.concatenate([state.u, state.d])
    others = np.concatenate([[state.t], at.whole(q)])
    rates = laws.at(laws.values, x, others)
    slopes = np.array(at.call(laws.slopes, state.t, state.x, state.z, q))
    for j, number in enumerate(laws.numbers):
        used = [k for k in laws.states if (number, k) in laws.pairs]
        if not set(used) <= set(known):
            continue
        change = rates[:, j] - rates[0, j]
        off = change - away[:, list(laws.states)] @ slopes[j]
        size = max(float(np.linalg.norm(slopes[j] * deviation[list(laws.states)])), float(np.std(change)))
        changed = np.abs(off) > CHANGED * size
        back = -slopes[j][laws.states.index(number)] if number in laws.states else 0.0
        if back > 0 and np.any(np.abs(off) > ROUNDING * size):
            moved = x.copy()
            moved[:, number] += np.sign(off) * CHANGED * size / back
            left = laws.at(laws.alone[j], moved, others)[:, 0] - rates[:, j] + off
            changed = (np.abs(off) > ROUNDING * size) & (left * off > 0)
        rest = np.ones(DRAWS, dtype=bool)
        for _ in range(2):  # one on each side
            if np.mean(changed & rest) < LEAST:
                break
            telling = [k for k in used if k != number] or used
            k, border, above = _split(x[:, telling], changed, rest)
            beyond = (x[:, telling[k]] > border) == above
            item = dae.states[telling[k]]
            found.append(Corner(dae.states[number].path, float(np.mean(changed & rest & beyond)), item.path, border,
                                above, float(state.x[telling[k]]), float(deviation[telling[k]]),
                                item.unit))  # fmt: skip
            rest &= ~beyond
    return tuple(sorted((one for one in found if one.probability >= LEAST), key=lambda one: -one.probability))


def _normal(count: int, size: int) -> np.ndarray:
    """Independent normal numbers (count, size) that fill space evenly.

    Of multiples of powers of a root of g^(size + 1) = g + 1, in one dimension the golden ratio (M. Roberts, The
    unreasonable effectiveness of quasirandom sequences, 2018).
    """
    g = 2.0
    for _ in range(60):
        g = (1 + g) ** (1 / (size + 1))
    return ndtri((0.5 + np.outer(np.arange(count), g ** -np.arange(1.0, size + 1))) % 1.0)


def _split(x: np.ndarray, changed: np.ndarray, rest: np.ndarray) -> tuple[int, float, bool]:
    """The column, the value and the side that hold the most of the changed draws and the least of the others."""
    best = (-np.inf, 0, 0.0, True)
    for k in range(x.shape[1]):
        order = np.argsort(x[rest, k])
        values, sign = x[rest, k][order], np.where(changed[rest][order], 1.0, -1.0)
        below = np.cumsum(sign)  # gain of taking all up to here
        for gains, above in ((below, False), (below[-1] - below, True)):
            i = int(np.argmax(gains))
            border = float((values[i] + values[min(i + 1, len(values) - 1)]) / 2)
            best = max(best, (float(gains[i]), k, border, above))
    return best[1:]


def warn_of_corners(corners: Sequence[Corner]) -> None:
    """CornerWarning that names the corners."""
    if corners:
        more = f"; and {len(corners) - LISTED} more" if len(corners) > LISTED else ""
        named = "; ".join(str(corner) for corner in corners[:LISTED])
        warnings.warn(f"the response reaches over corners of control laws, which it does not know of: {named}{more}. "
                      f"{ADVICE}", CornerWarning, stacklevel=3)  # fmt: skip


def warn_of_states(corners: Mapping[int, Sequence[Corner]], count: int) -> None:
    """The same for a list of states, by their numbers from 0: how many, and the worst corner of all."""
    reaching = {number: found[0] for number, found in corners.items() if found}
    if reaching:
        number, worst = max(reaching.items(), key=lambda item: item[1].probability)
        named = ", ".join(str(k + 1) for k in list(reaching)[:LISTED]) + (", ..." if len(reaching) > LISTED else "")
        warnings.warn(f"{len(reaching)} of {count} responses reach over corners of control laws, which they do not "
                      f"know of: states {named}; in state {number + 1} {worst}. {ADVICE}",
                      CornerWarning, stacklevel=3)  # fmt: skip
