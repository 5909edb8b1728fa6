"""Step 6: strong components in order; explicit solution, tearing, and one sequence of assignments.

An unknown is assigned where its equation gives it with a constant factor. In a block that no sequence of assignments
solves, some unknowns are torn. Up to three of them in linear equations, such as the moments of a joint with three axes,
are solved by Cramer's rule; more stay algebraic unknowns of the flat DAE, with as many residuals. Accelerations of
joints are torn first, so that a tree of bodies ends as the recursive Newton-Euler residual.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np

from fowtlib.flattening import structure
from fowtlib.flattening.incidence import Incidence, union
from fowtlib.flattening.system import BALANCE, System, residuals, stacked
from fowtlib.language.declarations import STATE_PREFERENCES

FEW = 30  # factors that are looked at one by one; more of them together
LARGEST_EXPLICIT = 3  # torn unknowns of a linear block that are solved by Cramer's rule: those of a joint


@dataclass
class Causal:
    """Order of computation: `sequence` of (symbol, expression), then the residuals of the torn unknowns."""

    sequence: list[tuple[ca.SX, ca.SX]] = field(default_factory=list)
    torn: list[int] = field(default_factory=list)
    residuals: list[int] = field(default_factory=list)
    blocks: list[int] = field(default_factory=list)


class Causalization:
    """Orders the equations of a regular system of index one."""

    def __init__(self, system: System, states: list[int], live: list[int], incidence: Incidence):
        self.system = system
        self.states = set(states)
        self.unknowns = [j for j in live if j not in self.states]
        self.incidence = incidence
        self.result = Causal()

    def run(self) -> Causal:
        """Compute the order."""
        system, unknowns = self.system, self.unknowns
        position = np.full(len(system.unknowns), -1)
        position[unknowns] = np.arange(len(unknowns))
        self.position = position
        self.left = self._structure(stacked(equation.lhs for equation in system.equations))
        self.right = self._structure(stacked(equation.rhs for equation in system.equations))
        self.rows = [union([a[0], b[0]]) for a, b in zip(self.left, self.right, strict=True)]
        self._await_intermediates()
        self._place_intermediates()
        blocks = structure.strong_components(self.rows, len(unknowns))
        simple = [(int(r[0]), int(c[0])) for r, c in blocks if len(r) == 1]
        values = {pair: value for pair in simple if (value := self._explicit(*pair)) is not None}
        values |= self._solutions([pair for pair in simple if pair not in values])
        for rows, columns in blocks:
            self.result.blocks.append(len(rows))
            if len(rows) == 1:
                self._scalar(int(rows[0]), int(columns[0]), values)
            else:
                self._torn_block(rows, columns)
            self._place_intermediates()
        return self.result

    def _structure(self, column: ca.SX) -> list[tuple[np.ndarray, np.ndarray]]:
        """For each element: unknowns it depends on in all, and those it depends on through intermediates."""
        direct, through = self.incidence.split(column)
        structures = []
        nothing = np.zeros(0, int)
        for own, via in zip(direct, through, strict=True):
            own = self.position[own]
            own = own[own >= 0]
            if not len(via):
                structures.append((own, nothing))
                continue
            hidden = self.position[union(self.incidence.closures(via))]
            hidden = hidden[hidden >= 0]
            structures.append((union([own, hidden]), hidden))
        return structures

    # --- one equation, one unknown -------------------------------------------------------------------------------

    def _symbol(self, column: int) -> ca.SX:
        return self.system.unknowns[self.unknowns[column]].symbol

    def _explicit(self, row: int, column: int) -> ca.SX | None:
        """The value of the unknown where one side of the equation is the unknown, and the other does not contain it."""
        equation, key = self.system.equations[row], self._keys[column]
        for side, other, others in ((equation.lhs, equation.rhs, self.right), (equation.rhs, equation.lhs, self.left)):
            if side.is_symbolic() and side.element_hash() == key and column not in others[row][0]:
                return other
        return None

    def _hidden(self, row: int, column: int) -> bool:
        return column in self.left[row][1] or column in self.right[row][1]

    def _hidden_in(self, row: int) -> np.ndarray:
        return np.concatenate([self.left[row][1], self.right[row][1]])

    @cached_property
    def _keys(self) -> list[int]:
        """Hash of the symbol of each unknown."""
        return [self.system.unknowns[j].symbol.element_hash() for j in self.unknowns]

    def _solutions(self, pairs: list[tuple[int, int]]) -> dict[tuple[int, int], ca.SX]:
        """What the unknown of each pair is, where its equation contains it with a constant factor."""
        factors = self._factors(pairs)
        solutions: dict[tuple[int, int], ca.SX] = {}
        for group in self._apart(list(factors)):
            residual = residuals([self.system.equations[row] for row, _ in group])
            symbols = ca.vertcat(*[self._symbol(column) for _, column in group])
            rest = ca.substitute(residual, symbols, ca.SX.zeros(len(group)))
            values = -ca.densify(rest) / ca.densify(ca.vertcat(*[factors[pair] for pair in group]))
            solutions |= zip(group, values.elements(), strict=True)
        return solutions

    def _apart(self, pairs: list[tuple[int, int]]) -> list[list[tuple[int, int]]]:
        """The pairs in few groups, no equation of which contains the unknown of another pair of its group."""
        color = np.full(len(self.unknowns), -1)
        nearby: dict[int, list[int]] = defaultdict(list)  # columns of the pairs whose equations contain a column
        columns = {column for _, column in pairs}
        for row, column in pairs:
            for other in self.rows[row]:
                if other != column and other in columns:
                    nearby[int(other)].append(column)
                    nearby[column].append(int(other))
        groups: list[list[tuple[int, int]]] = []
        for row, column in pairs:
            taken = set(color[nearby[column]].tolist())
            k = next(k for k in range(len(groups) + 1) if k not in taken)
            if k == len(groups):
                groups.append([])
            color[column] = k
            groups[k].append((row, column))
        return groups

    def _factors(self, pairs: list[tuple[int, int]]) -> dict[tuple[int, int], ca.SX]:
        """d(lhs - rhs) / d unknown for the pairs, where that does not depend on the unknown."""
        if not pairs:
            return {}
        residual = residuals([self.system.equations[row] for row, _ in pairs])
        symbols = ca.vertcat(*[self._symbol(column) for _, column in pairs])
        jacobian = ca.jacobian(residual, symbols)
        factors = [jacobian[k, k] for k in range(len(pairs))]
        again = ca.Function("f", [symbols], [ca.vertcat(*factors)], {"allow_free": True}).jac_sparsity(0, 0)
        return {
            pair: factor
            for k, (pair, factor) in enumerate(zip(pairs, factors, strict=True))
            if not again.has_nz(k, k) and not self._hidden(*pair) and not factor.is_zero()
        }

    def _residual(self, row: int) -> ca.SX:
        equation = self.system.equations[row]
        return equation.lhs - equation.rhs

    def _solve(self, row: int, column: int, factor: ca.SX) -> ca.SX:
        return -ca.substitute(self._residual(row), self._symbol(column), ca.SX(0)) / factor

    def _scalar(self, row: int, column: int, values: dict[tuple[int, int], ca.SX]) -> None:
        value = values.get((row, column))
        if value is None:
            self._tear(column)
            self.result.residuals.append(row)
        else:
            self._assign(column, value)

    def _assign(self, column: int, value: ca.SX) -> None:
        self.result.sequence.append((self._symbol(column), value))
        self._known(column)

    def _tear(self, column: int) -> None:
        self.result.torn.append(self.unknowns[column])
        self._known(column)

    def _known(self, column: int) -> None:
        """An unknown is known: the intermediates that waited for it last can be placed."""
        for k in self._waiting.pop(column, ()):
            self._missing[k] -= 1
            if not self._missing[k]:
                self._ready.append(k)

    # --- blocks --------------------------------------------------------------------------------------------------

    def _torn_block(self, rows: np.ndarray, columns: np.ndarray) -> None:
        """Tear a block, and solve what is left of it where that is linear and small."""
        result = self.result
        begin = len(result.sequence), len(result.torn), len(result.residuals)
        self._tear_block(rows, columns)
        torn = result.torn[begin[1] :]
        inside = set(map(int, columns))
        if len(torn) > LARGEST_EXPLICIT or any(inside & set(map(int, self._hidden_in(int(r)))) for r in rows):
            return
        unknowns = ca.vertcat(*[self.system.unknowns[k].symbol for k in torn])
        residual = residuals([self.system.equations[r] for r in result.residuals[begin[2] :]])
        inlined = _inlined(result.sequence[begin[0] :], residual)
        solution = _linear_solution(inlined, unknowns)
        if solution is not None:
            result.sequence[begin[0] : begin[0]] = list(zip(unknowns.elements(), solution, strict=True))
            del result.torn[begin[1] :], result.residuals[begin[2] :]

    def _tear_block(self, rows: np.ndarray, columns: np.ndarray) -> None:
        inside = set(map(int, columns))
        open_rows = {int(r): {int(c) for c in self.rows[r] if int(c) in inside} for r in rows}
        rows_of: dict[int, set[int]] = {c: set() for c in inside}
        for r, members in open_rows.items():
            for c in members:
                rows_of[c].add(r)
        constant, parametric = self._block_factors(list(open_rows), sorted(inside))
        left = set(inside)
        order = _TearingOrder(rows_of, constant)

        def remove(column: int) -> None:
            left.discard(column)
            order.drop(column)
            for r in sorted(rows_of[column]):  # a set has an order that changes with the numbers in it
                members = open_rows.get(r)
                if members is not None:
                    members.discard(column)
                    if len(members) == 1:
                        enlist(r)

        # an equation that says what its unknown is comes first: else a hinge on a base that stands still gives a moment
        # and, far from it, a balance of loads is left over as the residual
        stated: list[int] = []
        ready: list[int] = []
        # balances of flows come last, those furthest from the world first: the leaves of a tree of bodies before its
        # root, whose balance is left over as the residual
        balances: list[int] = []

        def enlist(r: int) -> None:
            if self._explicit(r, next(iter(open_rows[r]))) is not None:
                stated.append(r)
            else:
                (balances if self.system.equations[r].source == BALANCE else ready).append(r)

        for r, members in open_rows.items():
            if len(members) == 1:
                enlist(r)

        def assign_ready(factors: dict[tuple[int, int], ca.SX]) -> bool:
            progress, waiting = False, []
            while stated or ready:
                r = stated.pop() if stated else ready.pop()
                members = open_rows.get(r)
                if members is None or len(members) != 1:
                    continue
                c = next(iter(members))
                if (r, c) not in factors:
                    waiting.append(r)
                    continue
                value = self._explicit(r, c)
                self._assign(c, self._solve(r, c, factors[r, c]) if value is None else value)
                self._place_intermediates()
                del open_rows[r]
                order.close(r)
                remove(c)
                progress = True
            ready.extend(waiting)
            return progress

        for c in self._joint_rates(columns):
            if c in left:
                self._tear(c)
                self._place_intermediates()
                remove(c)
                assign_ready(constant)
        while left:
            if assign_ready(constant) or not left:
                continue
            if assign_ready(parametric):
                continue
            if balances:
                furthest = max(range(len(balances)), key=lambda k: (self._joints_below(balances[k]), k))
                ready.append(balances.pop(furthest))
                continue
            c = order.next()
            self._tear(c)
            self._place_intermediates()
            remove(c)
        self.result.residuals += sorted(open_rows)

    def _joints_below(self, row: int) -> int:
        """Joints between the place of a balance of flows and the world; 0 where that is no mechanical one."""
        orientation = self.system.orientation_at.get(self.system.equations[row].path, 0)
        return self.system.joints_below.get(orientation, 0)

    def _block_factors(self, rows: list[int], columns: list[int]) -> tuple[dict, dict]:
        """Factors that are numbers, and those that depend on parameters only and are not zero now."""
        residual = residuals([self.system.equations[r] for r in rows])
        jacobian = ca.jacobian(residual, ca.vertcat(*[self._symbol(c) for c in columns]))
        row_index, column_index = jacobian.sparsity().get_triplet()
        constant, changing = {}, {}
        for i, j, factor in zip(row_index, column_index, jacobian.nonzeros(), strict=True):
            pair = (rows[i], columns[j])
            if factor.is_constant():
                if float(factor) != 0.0 and not self._hidden(*pair):
                    constant[pair] = factor
            elif not self._hidden(*pair):
                changing[pair] = factor
        parametric = self._of_parameters(changing)
        if parametric:
            values = self._parameter_values(list(parametric.values()))
            parametric = {pair: f for (pair, f), v in zip(parametric.items(), values, strict=True) if abs(v) > 0}
        return constant, parametric

    def _of_parameters(self, factors: dict[tuple[int, int], ca.SX]) -> dict[tuple[int, int], ca.SX]:
        """Those of the factors that depend on parameters only."""
        if not factors:
            return {}
        if len(factors) <= FEW:
            known = self._parameter_numbers
            return {
                pair: factor for pair, factor in factors.items()
                if all(symbol.element_hash() in known for symbol in ca.symvar(factor))
            }  # fmt: skip
        column = ca.vertcat(*factors.values())
        others = [s for s in ca.symvar(column) if s.element_hash() not in self._parameter_numbers]
        if not others:
            return factors
        function = ca.Function("factors", [ca.vertcat(*others)], [column], {"allow_free": True})
        moving = set(function.jac_sparsity(0, 0).get_triplet()[0])
        return {pair: factor for k, (pair, factor) in enumerate(factors.items()) if k not in moving}

    @cached_property
    def _parameter_numbers(self) -> dict[int, float]:
        """Value of each scalar tunable parameter, by the hash of its symbol."""
        return {
            symbol.element_hash(): float(value)
            for parameter in self.system.parameters.values()
            for symbol, value in zip(parameter.symbol.elements(), np.ravel(parameter.value, order="F"), strict=True)
        }

    def _parameter_values(self, factors: list[ca.SX]) -> np.ndarray:
        if all(factor.is_symbolic() for factor in factors):
            return np.array([self._parameter_numbers[factor.element_hash()] for factor in factors])
        column = ca.vertcat(*factors)
        symbols = ca.symvar(column)
        values = [self._parameter_numbers[symbol.element_hash()] for symbol in symbols]
        return np.array(ca.Function("f", [ca.vertcat(*symbols)], [column])(values)).ravel()

    @cached_property
    def _state_rates(self) -> set[int]:
        return {self.system.unknowns[s].rate for s in self.states}

    def _joint_rates(self, columns: np.ndarray) -> list[int]:
        """Joint accelerations in the block: rates of preferred states, and of what such a state is the rate of."""
        unknowns = self.system.unknowns
        rates = self._state_rates
        wished = STATE_PREFERENCES.index("prefer")
        members = [
            int(c) for c in columns
            if unknowns[self.unknowns[c]].order > 0
            and STATE_PREFERENCES.index(unknowns[self.unknowns[c]].declared.state) >= wished
        ]  # fmt: skip
        return sorted(members, key=lambda c: (self.unknowns[c] not in rates, c))

    # --- intermediates -------------------------------------------------------------------------------------------

    def _await_intermediates(self) -> None:
        """For each orientation the number of unknowns it waits for; outputs of externals stay symbols."""
        self._definitions: list[tuple[ca.SX, ca.SX]] = []
        self._missing: list[int] = []
        self._waiting: dict[int, list[int]] = defaultdict(list)
        k = 0
        for item in self.system.intermediates:
            n = len(item.symbols)
            if item.function is None:  # element by element: an equation may need one row of a matrix, known first
                for e, definition in enumerate(zip(item.symbols, item.inputs.elements(), strict=True)):
                    columns = self.position[union(self.incidence.closures([k + e]))]
                    columns = columns[columns >= 0]
                    for column in columns:
                        self._waiting[int(column)].append(len(self._definitions))
                    self._missing.append(len(columns))
                    self._definitions.append(definition)
            k += n
        self._ready = [k for k, missing in enumerate(self._missing) if not missing]

    def _place_intermediates(self) -> None:
        """Define the orientations of which everything is known, in their own order (from the roots outwards)."""
        self.result.sequence += [self._definitions[k] for k in sorted(self._ready)]
        self._ready.clear()


class _TearingOrder:
    """Which unknown of a block to tear next: the one in most of the open equations.

    One that no equation gives explicitly counts double. A heap holds the scores; what is out of date is skipped.
    """

    def __init__(self, rows_of: dict[int, set[int]], constant: dict[tuple[int, int], ca.SX]):
        self._left = {c: len(rows) for c, rows in rows_of.items()}
        self._assignable = dict.fromkeys(rows_of, 0)
        self._members: dict[int, list[int]] = defaultdict(list)
        for c, rows in rows_of.items():
            for r in rows:
                self._members[r].append(c)
        for _, c in constant:
            self._assignable[c] += 1
        self._constant = constant
        self._heap = [(-self._score(c), c) for c in rows_of]
        heapq.heapify(self._heap)

    def _score(self, c: int) -> int:
        return self._left[c] * (1 if self._assignable[c] else 2)

    def close(self, row: int) -> None:
        """An equation is used up."""
        for c in self._members.pop(row, ()):
            if c in self._left:
                self._left[c] -= 1
                self._assignable[c] -= (row, c) in self._constant
                heapq.heappush(self._heap, (-self._score(c), c))

    def drop(self, column: int) -> None:
        """An unknown is known."""
        self._left.pop(column, None)

    def next(self) -> int:
        """The unknown with the largest score, of equal ones the first."""
        while True:
            score, c = self._heap[0]
            if c in self._left and -score == self._score(c):
                return c
            heapq.heappop(self._heap)


def _inlined(sequence: list[tuple[ca.SX, ca.SX]], expression: ca.SX) -> ca.SX:
    """An expression with the values of a sequence of assignments put in, each of which may need earlier ones."""
    if not sequence:
        return expression
    symbols, values = (list(column) for column in zip(*sequence, strict=True))
    return ca.substitute_inplace(symbols, values, [expression])[1][0]


def _linear_solution(residual: ca.SX, unknowns: ca.SX) -> list[ca.SX] | None:
    """Cramer's rule for at most three linear equations; none where they are not linear, or singular by their form."""
    matrix = ca.jacobian(residual, unknowns)
    if matrix.shape[0] != matrix.shape[1] or ca.depends_on(matrix, unknowns):
        return None
    determinant = _determinant(matrix)
    if determinant.is_zero():
        return None
    right = -ca.substitute(residual, unknowns, ca.SX.zeros(unknowns.shape[0]))
    solution = []
    for k in range(unknowns.shape[0]):
        replaced = ca.SX(matrix)
        replaced[:, k] = right
        solution.append(_determinant(replaced) / determinant)
    return solution


def _determinant(a: ca.SX) -> ca.SX:
    if a.shape[0] == 1:
        return a[0, 0]
    if a.shape[0] == 2:
        return a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    return ca.dot(a[:, 0], ca.cross(a[:, 1], a[:, 2]))
