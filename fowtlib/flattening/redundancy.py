"""Constraints of closed loops that repeat others: left out, and the loads that only they could tell are zero."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import casadi as ca
import numpy as np

from fowtlib.flattening import structure
from fowtlib.flattening.constraints import StartPoint, is_singular_place, undetermined
from fowtlib.flattening.system import FlatEquation, System
from fowtlib.language.declarations import STATE_PREFERENCES
from fowtlib.language.errors import StructureError, one_of


def owners(system: System, numbers: Sequence[int]) -> str:
    """Paths of the components whose equations have these numbers."""
    return one_of(sorted({system.equations[i].path or "the model" for i in numbers}), "and")


class Redundancy:
    """The redundant constraints that a choice of states has come upon."""

    def __init__(self, system: System):
        self.system = system
        self.redundant: list[tuple[int, StartPoint]] = []  # undifferentiated constraints, and where they were looked at

    def drop(self, point: StartPoint, rows: list[int], places: list[int]) -> None:
        """Take note of redundant constraints, or say why they cannot be left out."""
        paths = owners(self.system, rows)
        if not point.assembled[1]:
            raise StructureError(
                f"the parts of a closed loop do not meet at the start, however its joints turn: the constraint of "
                f"{paths} stays open. Check the lengths and the places of the parts in the loop."
            )
        if is_singular_place(point, places):
            moving = sorted({self.system.unknowns[j].path for j in self._wished(point)})
            raise StructureError(
                f"at the start the constraint of {paths} does not say how the loop moves on (a dead point: parts in "
                f"line). Start it a little away from there: other start values for {one_of(moving)}."
            )
        self.redundant += [(self.system.equations[i].base, point) for i in rows]

    def _wished(self, point: StartPoint) -> list[int]:
        """Coordinates that are wished as states, in constraints of positions."""
        wished = STATE_PREFERENCES.index("prefer")
        unknowns = [self.system.unknowns[j] for j in point.unknowns]
        able = [
            not u.order and "/s" not in u.declared.unit and STATE_PREFERENCES.index(u.declared.state) >= wished
            for u in unknowns
        ]  # fmt: skip
        _, jacobian = point.values(point.assembled[0] + 0.1)  # away from the place where derivatives vanish
        moved = np.any(jacobian[point.positional] != 0, axis=0)
        return [j for j, a, b in zip(point.unknowns, able, moved, strict=True) if a and b]

    def release(self, columns: Sequence[int], rows: Sequence[np.ndarray]) -> None:
        """Leave out the redundant constraints; the loads that only they could tell are zero.

        columns: numbers of the unknowns that the equations determine; rows: of the unknowns in each equation.
        """
        if not self.redundant:
            return
        system = self.system
        bases = {base for base, _ in self.redundant}
        kept = [i for i, equation in enumerate(system.equations) if equation.base not in bases]
        position = np.full(len(system.unknowns), -1)
        position[columns] = np.arange(len(columns))
        inside = [row[row >= 0] for row in (position[rows[i]] for i in kept)]
        coarse = structure.dulmage_mendelsohn(inside, len(columns))
        open_columns = [columns[k] for k in coarse.under_columns]
        open_rows = [system.equations[kept[i]] for i in coarse.under_rows]
        directions = undetermined(system, open_rows, open_columns, self.redundant[0][1])
        loads = self._loads(directions, open_columns)
        for (base, _), load in zip(self.redundant, loads, strict=True):
            old = system.equations[base]
            symbol = system.unknowns[load].symbol
            system.equations[base] = FlatEquation(symbol, ca.SX(0), old.path, old.source, base=base)
        system.equations = [
            equation for equation in system.equations if not (equation.order and equation.base in bases)
        ]
        where = owners(system, [base for base, _ in self.redundant])
        names = one_of(sorted(system.unknowns[load].path for load in loads), "and")
        warnings.warn(
            f"the parts of a closed loop hold each other more often than they need to (at {where}): the motion is "
            f"right, but how the loads share is not known for rigid parts; {names} is taken as zero. "
            "To know it, put a spring or one more freedom into the loop.",
            stacklevel=2,
        )

    def _loads(self, directions: np.ndarray, columns: list[int]) -> list[int]:
        """One load for each direction in which loads are not determined, that with the largest part in it."""
        unknowns = self.system.unknowns
        count = len(self.redundant)
        able = [not unknowns[j].order and unknowns[j].rate < 0 for j in columns]
        motion = np.max(np.abs(directions[:, [not a for a in able]]), initial=0.0)
        if len(directions) != count or motion > 1e-6:
            paths = owners(self.system, [base for base, _ in self.redundant])
            raise StructureError(
                f"the constraints of {paths} are redundant, and without them the motion or more than "
                "their own loads would be undetermined; a part in the loop may lack a mass."
            )
        chosen: list[int] = []
        rest = directions.copy()
        for _ in range(count):
            sizes = np.linalg.norm(rest, axis=0) * able
            k = int(np.argmax(sizes >= 0.9 * np.max(sizes)))
            direction = rest[:, k] / np.linalg.norm(rest[:, k])
            rest -= np.outer(direction, direction @ rest)
            chosen.append(columns[k])
        return chosen
