"""The statements of a program: each makes a number, or numbers side by side, or writes one into a result."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_

from fowtlib.solving.engines.lanes import CONSTANT, INPUT, WIDTH, Lanes, Operations, Packs

Depends = Callable[[int, int], int]
"""Unknowns on which an element of an argument depends, as bits of an integer: of the number of argument and element."""


@dataclass(frozen=True)
class Statement:
    """Makes values side by side, of those in `needs`; with a result it writes a value into its element instead.

    masks: unknowns on which they depend, for each of the dependences.
    """

    column: Lanes
    result: tuple[str, int] | None
    needs: tuple[Lanes, ...]
    masks: tuple[int, ...]


class Statements:
    """Statements of each section, in an order in which they can run.

    inputs: argument and element of those values that are inputs. constants: text of those that are constants. column:
    where a value is made with others. number: of the statement that makes a column.
    """

    def __init__(self, operations: Operations, arguments: Sequence[str], results: Sequence[tuple[int, str]],
                 dependences: Sequence[Depends]):  # fmt: skip
        self.operations = operations
        self.inputs: dict[int, tuple[str, int]] = {}
        self.constants: dict[int, str] = {}
        self._masks: dict[Lanes, tuple[int, ...]] = {}
        self._nothing = (0,) * len(dependences)
        for value, (code, needs) in enumerate(zip(operations.code, operations.needs, strict=True)):
            if code == CONSTANT:
                self.constants[value] = _number(operations.constant[value])
            elif code == INPUT:
                self.inputs[value] = (arguments[needs[0]], needs[1])
                self._masks[(value,)] = tuple(depends(*needs) for depends in dependences)
        self.packs = Packs(operations, _needed(operations))
        self.column = {value: column for column in self.packs.columns for value in column}
        self.number: dict[Lanes, int] = {}
        self._operands: dict[Lanes, list[Lanes]] = {}
        last = max((section for section, _ in results), default=0)
        self.sections: list[list[Statement]] = [[] for _ in range(last + 1)]
        for result, element, value in sorted(operations.results, key=lambda item: results[item[0]][0]):
            section, name = results[result]
            needs = self._columns([value])
            self._make(needs, self.sections[section])
            masks = self._joined([value], needs)
            self.sections[section].append(Statement((value,), (name, element), needs, masks))

    def plain(self, value: int) -> bool:
        """Whether a value is not made but an input or a constant."""
        return value in self.inputs or value in self.constants

    def operands(self, column: Lanes) -> list[Lanes]:
        """What a column is of, lane by lane."""
        if column not in self._operands:
            self._operands[column] = self.packs.operands(column)
        return self._operands[column]

    def gathered(self, column: Lanes) -> bool:
        """Whether values are put side by side that are not made so."""
        return len(column) > 1 and self.column.get(column[0]) != column

    def direct(self, column: Lanes) -> bool:
        """Whether values side by side need no statement: constants, and inputs that lie so."""
        codes = {self.operations.code[value] for value in column}
        if codes == {INPUT} and len(column) == WIDTH:
            argument, first = self.operations.needs[column[0]]
            return [self.operations.needs[value] for value in column] == [(argument, first + k) for k in range(WIDTH)]
        return codes == {CONSTANT}

    def _columns(self, values: Sequence[int]) -> tuple[Lanes, ...]:
        """Where values are made, one by one."""
        columns = [self.column.get(value, (value,)) for value in values if not self.plain(value)]
        return tuple(dict.fromkeys(columns))

    def _needs(self, column: Lanes) -> tuple[Lanes, ...]:
        """Columns that have to be made first."""
        if self.gathered(column):
            return self._columns(column)
        needs: list[Lanes] = []
        for inside in self.operands(column):
            if len(set(inside)) == 1:
                needs += self._columns(inside[:1])
            elif not self.direct(inside):
                needs.append(inside)
        return tuple(dict.fromkeys(needs))

    def _joined(self, plain: Sequence[int], needs: Sequence[Lanes]) -> tuple[int, ...]:
        """Unknowns on which inputs and columns depend together."""
        masks = [self._masks[key] for key in [*((value,) for value in plain), *needs] if key in self._masks]
        return tuple(reduce(or_, some) for some in zip(*masks, strict=True)) if masks else self._nothing

    def _make(self, columns: Sequence[Lanes], lines: list[Statement]) -> None:
        """Write statements that make columns, and before them of what they need."""
        waiting: list[tuple[Lanes, tuple[Lanes, ...] | None]] = [(column, None) for column in reversed(columns)]
        while waiting:
            column, needs = waiting.pop()
            if column in self.number:
                continue
            if needs is None:
                needs = self._needs(column)
                waiting.append((column, needs))
                waiting += [(need, None) for need in reversed(needs) if need not in self.number]
                continue
            inside = [column] if self.gathered(column) else self.operands(column)
            plain = [value for operand in inside for value in operand if value in self.inputs]
            self._masks[column] = self._joined(plain, needs)
            self.number[column] = len(self.number)
            lines.append(Statement(column, None, needs, self._masks[column]))


def _needed(operations: Operations) -> list[int]:
    """Values that results need, in their order."""
    needed = [False] * len(operations.code)
    for _, _, value in operations.results:
        needed[value] = True
    for value in range(len(needed) - 1, -1, -1):
        if needed[value]:
            for need in operations.operands(value):
                needed[need] = True
    return [value for value, is_needed in enumerate(needed) if is_needed]


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(float(value)) if value >= 0 else f"({float(value)!r})"
