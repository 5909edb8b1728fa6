"""Step 5: Pantelides' algorithm and dummy derivatives.

Sources: C. C. Pantelides, SIAM J. Sci. Stat. Comput. 9 (1988) 213; S. E. Mattsson and G. Soederlind, SIAM J. Sci.
Comput. 14 (1993) 677. All equations that an unmatched equation reaches are differentiated together.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from fowtlib.flattening import structure
from fowtlib.flattening.constraints import StartPoint, choose
from fowtlib.flattening.incidence import Incidence, union
from fowtlib.flattening.redundancy import Redundancy, owners
from fowtlib.flattening.system import FlatEquation, System, residuals
from fowtlib.language.declarations import STATE_PREFERENCES
from fowtlib.language.errors import StructureError


class IndexReduction:
    """Differentiates the equations that constrain states, and chooses the states."""

    def __init__(self, system: System, live: set[int], incidence: Incidence, rows: Sequence[np.ndarray]):
        self.system = system
        self.live = live
        self.incidence = incidence
        self.rows = list(rows)
        self.steps = 0
        self.redundancy = Redundancy(system)

    def run(self) -> list[int]:
        """Numbers of the states; afterwards the equations determine all other unknowns."""
        self._pantelides()
        states = self._select_states()
        given = set(states)
        self.redundancy.release([j for j in self._all() if j not in given], self.rows)
        return states

    # --- Pantelides ----------------------------------------------------------------------------------------------

    def _update_rows(self) -> None:
        system = self.system
        fresh = system.equations[len(self.rows) :]
        self.rows += self.incidence.rows(residuals(fresh))

    def _pantelides(self) -> None:
        system = self.system
        while True:
            active_rows = [i for i, equation in enumerate(system.equations) if equation.rate < 0]
            columns = [j for j in self._all() if system.unknowns[j].rate < 0]
            position = np.full(len(system.unknowns), -1)
            position[columns] = np.arange(len(columns))
            rows = [row[row >= 0] for row in (position[self.rows[i]] for i in active_rows)]
            match = structure.matching(rows, len(columns))
            exposed = np.flatnonzero(match < 0)
            if not len(exposed):
                self.active_rows, self.columns = active_rows, columns
                return
            self.steps += 1
            if self.steps > 20:
                raise StructureError(self._endless(active_rows, exposed))
            row_of = np.full(len(columns), -1)
            row_of[match[match >= 0]] = np.flatnonzero(match >= 0)
            reached, _ = structure.reachable(rows, row_of, exposed)
            self._differentiate([active_rows[i] for i in reached])

    def _all(self) -> list[int]:
        return [j for j, unknown in enumerate(self.system.unknowns) if unknown.base in self.live]

    def _differentiate(self, numbers: list[int]) -> None:
        system = self.system
        chosen = [system.equations[i] for i in numbers]
        left = system.derivative(ca.vertcat(*[equation.lhs for equation in chosen])).elements()
        right = system.derivative(ca.vertcat(*[equation.rhs for equation in chosen])).elements()
        for equation, lhs, rhs in zip(chosen, left, right, strict=True):
            equation.rate = len(system.equations)
            system.equations.append(
                FlatEquation(lhs, rhs, equation.path, equation.source, order=equation.order + 1, base=equation.base)
            )
        self._update_rows()
        for number, equation in zip(numbers, chosen, strict=True):
            # an orientation hides joint coordinates behind an angular velocity: their rates belong to the structure too
            rates = np.array([system.rate_of(j) for j in self.rows[number]], int)
            self.rows[equation.rate] = np.union1d(self.rows[equation.rate], rates)

    def _endless(self, active_rows: list[int], exposed: np.ndarray) -> str:
        paths = sorted({self.system.equations[active_rows[i]].path or "the model" for i in exposed})
        return (
            "the index reduction does not end: equations of "
            + ", ".join(paths[:5])
            + " constrain each other at every order. Two of these components probably prescribe the same motion."
        )

    # --- choice of states ----------------------------------------------------------------------------------------

    def _select_states(self) -> list[int]:
        """Dummy derivatives, order by order; the unknowns with a derivative that is not a dummy are the states."""
        system = self.system
        equation_before = {equation.rate: i for i, equation in enumerate(system.equations) if equation.rate >= 0}
        self.unknown_before = {unknown.rate: j for j, unknown in enumerate(system.unknowns) if unknown.rate >= 0}
        dummies: set[int] = set()
        rows = [i for i in self.active_rows if system.equations[i].order > 0]
        columns = [j for j in self.columns if system.unknowns[j].order > 0]
        while rows:
            chosen = self._choose(rows, columns)
            dummies.update(chosen)
            rows = [equation_before[i] for i in rows if system.equations[i].order > 1]
            columns = [self.unknown_before[j] for j in chosen if system.unknowns[j].order > 1]
        return [
            j for j in self._all()
            if system.unknowns[j].rate >= 0 and system.unknowns[j].rate not in dummies
        ]  # fmt: skip

    def _choose(self, rows: list[int], columns: list[int]) -> list[int]:
        """One dummy for each differentiated equation, those least wished as states first."""
        from scipy.sparse.csgraph import min_weight_full_bipartite_matching

        system = self.system
        position = {(system.unknowns[j].base, system.unknowns[j].order): k for k, j in enumerate(columns)}
        entries = []
        for i in rows:
            equation = system.equations[i]
            # d e^(c) / d x^(d) = d e / d x^(d - c): the same entry at every order
            undifferentiated = (system.unknowns[j] for j in self.rows[equation.base])
            members = ((unknown.base, unknown.order + equation.order) for unknown in undifferentiated)
            entries.append(np.array(sorted(position[member] for member in members if member in position), int))
        incidence = structure.matrix(entries, len(columns)).astype(float)
        incidence.data = np.array([self._weight(columns[k]) for k in incidence.indices])
        try:
            _, chosen = min_weight_full_bipartite_matching(incidence)
        except ValueError:
            paths = sorted({system.equations[i].path or "the model" for i in rows})
            raise StructureError(
                "no choice of states satisfies the constraints of "
                + ", ".join(paths[:8])
                + "; they may be redundant, as the "
                "out-of-plane constraints of a planar loop are (close it with a PlanarLoopRevolute)."
            ) from None
        return self._by_derivatives(rows, columns, entries, chosen)

    def _by_derivatives(
        self, rows: list[int], columns: list[int], entries: list[np.ndarray], chosen: np.ndarray
    ) -> list[int]:
        """The choice by the derivatives at the start, for the constraints that do not follow one from another."""
        tied = _tied(entries, chosen)
        if not len(tied):
            return [columns[k] for k in chosen]
        bases = [self.system.equations[rows[i]].base for i in tied]
        point = StartPoint(self.system, [self.system.equations[i] for i in bases])
        if not point.is_known:
            return [columns[k] for k in chosen]
        candidates = union([entries[i] for i in tied])
        matrix, places = self._derivatives(point, [rows[i] for i in tied], [columns[k] for k in candidates])
        choice = choose(matrix, [self._wish(columns[k]) for k in candidates])
        if all(self.system.equations[i].order == 1 for i in rows):  # the last level
            self._check_always(matrix, [rows[i] for i in tied], [columns[k] for k in candidates], choice.columns)
        if choice.redundant:
            redundant = [rows[tied[i]] for i in choice.redundant]
            self.redundancy.drop(point, redundant, places)
            rows[:] = [i for i in rows if i not in redundant]
        others = np.setdiff1d(np.arange(len(entries)), tied)
        return [columns[k] for k in [*chosen[others], *candidates[choice.columns]]]

    def _check_always(self, matrix: np.ndarray, rows: list[int], columns: list[int], chosen: list[int]) -> None:
        """A state that its author insists on, where another one is free and only the place of the start forbids it."""
        below = [self.system.unknowns[self.unknown_before[j]] for j in columns]
        insisted = [unknown.declared.state == "always" for unknown in below]
        lost = [k for k in chosen if insisted[k]]
        free = [k for k in range(len(columns)) if not insisted[k] and k not in set(chosen)]
        if lost and free:
            constraints = owners(self.system, [rows[i] for i in np.flatnonzero(matrix[:, lost[0]])])
            raise StructureError(
                f"{below[lost[0]].path} is declared to be a state (state='always'), and at the start the constraint of "
                f"{constraints} does not tell by it how the loop moves on (a dead point). Start it elsewhere, or make "
                f"{below[free[0]].path} the state (state='always', as in a Crank)."
            )

    def _derivatives(self, point: StartPoint, rows: list[int], columns: list[int]) -> tuple[np.ndarray, list[int]]:
        """Derivatives of the constraints by the unknowns below the columns; and the places of those in the point."""
        system = self.system
        _, jacobian = point.values(point.assembled[0])
        place = {(system.unknowns[j].base, system.unknowns[j].order): k for k, j in enumerate(point.unknowns)}
        matrix, used = np.zeros((len(rows), len(columns))), set()
        for k, j in enumerate(columns):
            for n, i in enumerate(rows):
                below = place.get((system.unknowns[j].base, system.unknowns[j].order - system.equations[i].order))
                if below is not None:
                    matrix[n, k] = jacobian[n, below]
                    used.add(below)
        return matrix, sorted(used)

    def _weight(self, number: int) -> float:
        """Cost of making a derivative a dummy; the number makes it unique."""
        return self._wish(number) + 1e-6 * number

    # --- wishes --------------------------------------------------------------------------------------------------

    def _wish(self, number: int) -> float:
        """How much it is wished that a derivative be no dummy: high where the unknown below it is a wished state."""
        unknown = self.system.unknowns[number]
        preference = STATE_PREFERENCES.index(unknown.declared.state)
        below = self.system.unknowns[self.unknown_before[number]]
        given = max(below.start_rank, int(bool(unknown.declared.fixed)))
        return 10.0 ** (2 * preference) * 2**given * (1 + 0.01 / unknown.order)


def _tied(entries: list[np.ndarray], chosen: np.ndarray) -> np.ndarray:
    """Rows that only several columns together fulfil (closed loops), and those that lead to them."""
    row_of = {int(k): i for i, k in enumerate(chosen)}
    local = [np.array(sorted(row_of[int(k)] for k in entry if int(k) in row_of), int) for entry in entries]

    def leading_to(rows: set[int]) -> set[int]:
        found, front = set(rows), rows
        while front:
            front = {int(i) for row in front for i in local[row]} - found
            found |= front
        return found

    blocks = structure.strong_components(local, len(local))
    found = leading_to({int(i) for rows, _ in blocks if len(rows) > 1 for i in rows})
    columns = {int(k) for row in found for k in entries[row]}
    # the speed of a joint stands beside the derivative of its angle: which of the two is the state is chosen here too
    beside = {i for i, entry in enumerate(entries) if len(entry) == 2 and columns & {*map(int, entry)}}
    return np.array(sorted(leading_to(found | beside)), int)
