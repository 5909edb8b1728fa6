"""Constraints at the start: where the coordinates that fulfil them lie, and how each constraint moves with each one.

A structural choice of states sees which coordinates a constraint contains, not whether it moves with them: of the three
position equations of a bar between two ball joints none moves with its spin, although the spin stands in all of them.
So where constraints hang together (closed loops) the choice is made with the numbers of the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from fowtlib.flattening.system import FlatEquation, System, residuals, scalars

CLOSED = 1e-9  # largest residual of constraints that count as fulfilled, relative to the size of what they contain
INDEPENDENT = 1e-3  # least part of a column that stands off the columns chosen before it, for a wish to be followed
DEPENDENT = 1e-7  # the same, below which nothing is left
ALIKE = 0.5  # columns that stand off by this part of the best one, or more, are as good
PROBE = 0.05  # length of the step (m, rad) that tells a redundant constraint from one that is so at the start only


class StartPoint:
    """Some equations with their values and derivatives where the model starts; orientations are put in."""

    def __init__(self, system: System, equations: Sequence[FlatEquation]):
        self.system = system
        column = _with_orientations(system, residuals(equations))
        symbols = ca.symvar(column)
        self.unknowns = [system.number[s.element_hash()] for s in symbols if s.element_hash() in system.number]
        others = [s for s in symbols if s.element_hash() not in system.number]
        known = _known(system)
        known |= _computed(system, [s for s in others if s.element_hash() not in known])
        self.is_known = all(s.element_hash() in known for s in others)  # not so behind external functions
        self._others = [known.get(s.element_hash(), 0.0) for s in others]
        q = ca.vertcat(*[system.unknowns[j].symbol for j in self.unknowns])
        jacobian = ca.jacobian(column, q)
        entries = np.array(jacobian.sparsity().get_triplet(), int).reshape(2, -1)
        moving = np.array([system.unknowns[j].order > 0 for j in self.unknowns], bool)
        self.positional = np.setdiff1d(np.arange(column.shape[0]), entries[0][moving[entries[1]]])
        self._function = ca.Function("constraints", [q, ca.vertcat(*others)], [column, ca.densify(jacobian)])

    def values(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (n) and derivatives (n, number of the unknowns)."""
        residual, jacobian = self._function(q, self._others)
        return np.array(residual).ravel(), np.array(jacobian)

    @cached_property
    def assembled(self) -> tuple[np.ndarray, bool]:
        """The unknowns near their start values that fulfil the equations of positions, and whether they do."""
        return self.closed(_starts(self.system, self.unknowns))

    def closed(self, q: np.ndarray) -> tuple[np.ndarray, bool]:
        """Gauss-Newton towards the equations of positions; what has a start value of its own moves least."""
        unknowns = [self.system.unknowns[j] for j in self.unknowns]
        ease = np.array([10.0**-unknown.start_rank for unknown in unknowns])
        angles = np.array([unknown.start is not None for unknown in unknowns], bool)
        rows = self.positional
        for _ in range(60):
            residual, jacobian = self.values(q)
            if not np.all(np.isfinite(jacobian)):
                break
            if np.max(np.abs(residual[rows]), initial=0.0) < CLOSED * max(1.0, np.max(np.abs(q), initial=0.0)):
                return q, True
            step = -ease * np.linalg.lstsq(jacobian[rows] * ease, residual[rows], rcond=1e-10)[0]
            q = q + step * min(1.0, 0.5 / max(np.max(np.abs(step[angles]), initial=0.0), 0.5))
        return q, False


@dataclass
class Choice:
    """What one level of the dummy derivatives comes to: a column for each row that is not redundant."""

    columns: list[int]
    redundant: list[int]


def choose(matrix: np.ndarray, wishes: Sequence[float]) -> Choice:
    """Independent columns of the smallest wishes, and the rows that are combinations of the others.

    Among columns of equal wish those that stand well off the ones already chosen come first.
    matrix: (rows, columns), derivatives of the constraints; wishes: of each column to stay a state.
    """
    scale = np.max(np.abs(matrix), axis=1, keepdims=True)
    scaled = matrix / np.where(scale > 0, scale, 1.0)
    lengths = np.linalg.norm(scaled, axis=0)
    rest = scaled.copy()
    chosen: list[int] = []
    free = {k for k in range(matrix.shape[1]) if lengths[k] > DEPENDENT}
    for least in (INDEPENDENT, DEPENDENT):
        for wish in sorted({wishes[k] for k in free}):
            group = sorted(k for k in free if wishes[k] == wish)
            while group and len(chosen) < matrix.shape[0]:
                off = np.linalg.norm(rest[:, group], axis=0) / lengths[group]
                best = np.max(off)
                if best < least:
                    break
                k = group.pop(int(np.argmax(off >= ALIKE * best)))
                direction = rest[:, k] / np.linalg.norm(rest[:, k])
                rest -= np.outer(direction, direction @ rest)
                chosen.append(k)
                free.discard(k)
    return Choice(sorted(chosen), _dependent_rows(scaled[:, chosen]))


def _dependent_rows(matrix: np.ndarray) -> list[int]:
    """Rows that are left when as many independent ones as there are columns are taken, the largest first."""
    rest, left = matrix.copy(), list(range(matrix.shape[0]))
    for _ in range(matrix.shape[1]):
        lengths = np.linalg.norm(rest[left], axis=1)
        k = left.pop(int(np.argmax(lengths >= ALIKE * np.max(lengths))))
        direction = rest[k] / np.linalg.norm(rest[k])
        rest -= np.outer(rest @ direction, direction)
    return left


def rank(matrix: np.ndarray) -> int:
    """Number of independent rows, each measured by its largest entry."""
    scale = np.max(np.abs(matrix), axis=1, keepdims=True)
    return int(np.linalg.matrix_rank(matrix / np.where(scale > 0, scale, 1.0), tol=DEPENDENT)) if matrix.size else 0


def is_singular_place(point: StartPoint, columns: Sequence[int]) -> bool:
    """Whether the constraints are independent a small step away along their motion, though not at the start.

    columns: numbers in `point.unknowns` of what the rank is taken of.
    """
    q, closed = point.assembled
    if not closed:
        return False
    _, jacobian = point.values(q)
    here = rank(jacobian[:, columns])
    positions = [k for k, j in enumerate(point.unknowns) if point.system.unknowns[j].order == 0]
    _, sizes, directions = np.linalg.svd(jacobian[np.ix_(point.positional, positions)])
    motions = directions[np.count_nonzero(sizes > DEPENDENT) :]
    for motion in motions:
        step = np.zeros(len(q))
        step[positions] = PROBE * motion / np.max(np.abs(motion))
        moved, closed = point.closed(q + step)
        if closed and rank(point.values(moved)[1][:, columns]) > here:
            return True
    return False


def undetermined(system: System, rows: Sequence[FlatEquation], columns: Sequence[int], near: StartPoint) -> np.ndarray:
    """Directions (n, number of the columns) in which unknowns may change without any of the equations noticing.

    near: constraints, assembled, whose positions are taken.
    """
    point = StartPoint(system, rows)
    q = dict(zip(point.unknowns, _starts(system, point.unknowns), strict=True))
    q |= {j: value for j, value in zip(near.unknowns, near.assembled[0], strict=True) if j in q}
    _, jacobian = point.values(np.array([q[j] for j in point.unknowns]))
    place = {j: k for k, j in enumerate(point.unknowns)}
    matrix = np.zeros((len(rows), len(columns)))
    for k, j in enumerate(columns):
        if j in place:
            matrix[:, k] = jacobian[:, place[j]]
    scale = np.max(np.abs(matrix), axis=1, keepdims=True)
    _, sizes, directions = np.linalg.svd(matrix / np.where(scale > 0, scale, 1.0))
    return directions[np.count_nonzero(sizes > DEPENDENT) :]


def _with_orientations(system: System, column: ca.SX) -> ca.SX:
    """The column with the definitions of the orientations put in, from the roots outwards."""
    defined = [item for item in system.intermediates if item.function is None]
    if not defined:
        return column
    symbols = ca.vertcat(*[symbol for item in defined for symbol in item.symbols])
    values = ca.vertcat(*[item.inputs for item in defined])
    return ca.substitute_inplace([symbols], [values], [column])[1][0]


def _known(system: System) -> dict[int, float]:
    """Values of what is no unknown: time, parameters, inputs of the model, discrete variables at the start."""
    known = {system.time.element_hash(): 0.0}
    for parameter in system.parameters.values():
        known |= _numbers(parameter.symbol, parameter.value)
    for item in system.inputs.values():
        known |= _numbers(item.symbol, item.default)
    discretes = system.discretes
    values = _evaluated([ca.SX(0) if item.start is None else ca.SX(item.start) for item in discretes], known)
    return known | {item.symbol.element_hash(): float(v) for item, v in zip(discretes, values, strict=True)}


def _computed(system: System, symbols: Sequence[ca.SX]) -> dict[int, float]:
    """Values of those symbols that components compute when a run starts, as they would be now."""
    wanted = {symbol.element_hash() for symbol in symbols}
    values: dict[int, float] = {}
    for item in system.bound.values() if wanted else ():
        if wanted & {symbol.element_hash() for symbol in scalars(item.symbol)}:
            numbers = system.computed_now(item)
            values |= _numbers(item.symbol, numbers) if numbers is not None else {}
    return values


def _numbers(symbol: ca.SX, value: np.ndarray) -> dict[int, float]:
    flat = np.ravel(value, order="F")
    return {s.element_hash(): float(v) for s, v in zip(scalars(symbol), flat, strict=True)}


def _starts(system: System, numbers: Sequence[int]) -> np.ndarray:
    starts = [system.unknowns[j].start for j in numbers]
    return _evaluated([ca.SX(0) if start is None else ca.SX(start) for start in starts], _known(system))


def _evaluated(expressions: list[ca.SX], known: dict[int, float]) -> np.ndarray:
    column = ca.vertcat(*expressions) if expressions else ca.SX(0, 1)
    symbols = ca.symvar(column)
    values = [known.get(symbol.element_hash(), 0.0) for symbol in symbols]
    return np.array(ca.Function("starts", [ca.vertcat(*symbols)], [column])(values)).ravel()
