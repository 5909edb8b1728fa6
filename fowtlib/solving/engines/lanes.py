"""Operations of a program that are alike, side by side: what three blades do is done once, with a lane for each.

Operations go together where they are the roots of the same expressions but for the numbers at their ends. That is found
from the program alone, for any model. The largest expressions of which there are a few say which parts are alike, and
how their inputs belong to each other; what is left follows from below, where operations read lanes of the same vectors.

An operation with lanes does to each of them what it does to a number, so that no result changes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import casadi as ca

from fowtlib.solving.engines.c_lanes import OPERATIONS

WIDTH = 4  # lanes of a vector
LEAST = 3  # of which are used

COMMUTATIVE = {ca.OP_ADD, ca.OP_MUL, ca.OP_FMIN, ca.OP_FMAX, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR}
CONSTANT, INPUT = -1, -2

Lanes = tuple[int, ...]


@dataclass
class Operations:
    """Operations of a scalar (SX) function, each once, in an order in which they can run.

    code: CasADi's number of the operation, or CONSTANT or INPUT. needs: of an operation the values it is of; of an
    input its argument and element. constant: numbers of those that are constants. shape: equal for expressions that are
    equal but for constants and inputs (of the same argument, and known from the same section on). depth: operations one
    behind the other. results: number of the result, element, and value.
    """

    code: list[int] = field(default_factory=list)
    needs: list[tuple[int, ...]] = field(default_factory=list)
    constant: dict[int, float] = field(default_factory=dict)
    shape: list[int] = field(default_factory=list)
    depth: list[int] = field(default_factory=list)
    results: list[tuple[int, int, int]] = field(default_factory=list)

    def operands(self, value: int) -> tuple[int, ...]:
        """The values that an operation is of; none of an input or a constant."""
        return self.needs[value] if self.code[value] >= 0 else ()

    def read_constants(self, argument: int) -> list[float]:
        """Make inputs of the constants, elements of one more argument; what it has to hold."""
        numbers = list(self.constant.values())
        for element, value in enumerate(self.constant):
            self.code[value], self.needs[value] = INPUT, (argument, element)
        self.constant = {}
        return numbers


def operations_of(function: ca.Function, known_from: Callable[[int, int], int]) -> Operations:
    """The operations of a function. known_from: the section from which on an element of an argument is known."""
    program = Operations()
    made: dict[tuple, int] = {}
    shapes: dict[tuple, int] = {}
    holder: dict[int, int] = {}
    for k in range(function.n_instructions()):
        code, inside, outside = (
            function.instruction_id(k),
            function.instruction_input(k),
            function.instruction_output(k),
        )
        if code == ca.OP_OUTPUT:
            program.results.append((outside[0], outside[1], holder[inside[0]]))
            continue
        depth, number = 0, 0.0
        if code == ca.OP_CONST:
            number = function.instruction_constant(k)
            code, needs, key, shape = CONSTANT, (), (CONSTANT, repr(number)), (CONSTANT,)
        elif code == ca.OP_INPUT:
            code, needs = INPUT, (inside[0], inside[1])
            key, shape = (INPUT, *needs), (INPUT, inside[0], known_from(*needs))
        elif code not in OPERATIONS:
            raise NotImplementedError(f"there is no C text for the CasADi operation {code}")
        else:
            needs = tuple(holder[place] for place in inside)
            if code in COMMUTATIVE:
                needs = tuple(sorted(needs, key=lambda value: (program.shape[value], value)))
            key, shape = (code, *needs), (code, *[program.shape[value] for value in needs])
            depth = 1 + max(program.depth[value] for value in needs)
        if key not in made:
            made[key] = len(program.code)
            if code == CONSTANT:
                program.constant[made[key]] = number
            program.code.append(code)
            program.needs.append(needs)
            program.shape.append(shapes.setdefault(shape, len(shapes)))
            program.depth.append(depth)
        holder[outside[0]] = made[key]
    return program


class Packs:
    """Operations among the values that go together, each once at most: `columns` of values, in the order of lanes.

    The values of a column have the same shape, so that none of them can wait for another.
    """

    def __init__(self, program: Operations, values: Iterable[int]):
        self.program = program
        self.place: dict[int, tuple[int, int]] = {}  # pack and lane of operations and inputs
        self._columns: list[Lanes] = []
        self._values = [value for value in values if program.code[value] >= 0]
        classes: dict[int, list[int]] = defaultdict(list)
        for value in self._values:
            classes[program.shape[value]].append(value)
        largest = sorted(classes.values(), key=lambda members: (-program.depth[members[0]], members[0]))
        for few in (True, False):
            for members in largest:
                if few == (len(members) <= WIDTH):
                    self._divided(members)
            self._from_below()
        self.columns = [column for column in self._columns if program.code[column[0]] >= 0]

    def _divided(self, members: list[int]) -> None:
        """Put together what is free of values of the same shape, in vectors that are filled evenly."""
        free = [value for value in members if value not in self.place]
        vectors = -(-len(free) // WIDTH)
        while vectors and len(free) >= LEAST:
            size = max(-(-len(free) // vectors), LEAST)
            column, free, vectors = tuple(free[:size]), free[size:], vectors - 1
            if not any(value in self.place for value in column):  # by the one before
                self._together(self._ordered(column))

    def _together(self, column: Lanes) -> None:
        """Put values together, and what they are of."""
        program, waiting = self.program, [column]
        while waiting:
            column = waiting.pop()
            if len(set(column)) < len(column) or any(value in self.place for value in column):
                continue
            if program.code[column[0]] == CONSTANT:
                continue
            self._keep(column)
            waiting += [inside for inside in self.operands(column) if len(set(inside)) > 1]

    def _keep(self, column: Lanes) -> None:
        for lane, value in enumerate(column):
            self.place[value] = (len(self._columns), lane)
        self._columns.append(column)

    def operands(self, column: Lanes) -> list[Lanes]:
        """What the values are of, lane by lane; those of a sum or product so that known lanes lie beside each other."""
        needs = [self.program.operands(value) for value in column]
        if len(needs[0]) == 2 and self.program.code[column[0]] in COMMUTATIVE:
            one, other = needs[0]
            if self.program.shape[one] == self.program.shape[other]:
                for lane, (a, b) in enumerate(needs):
                    straight = self._beside(one, a, lane) and self._beside(other, b, lane)
                    if not straight and (self._beside(one, b, lane) or self._beside(other, a, lane)):
                        needs[lane] = (b, a)
        return list(zip(*needs, strict=True))

    def _beside(self, first: int, value: int, lane: int) -> bool:
        """Whether a value is the same as that of the first lane, or this lane of its vector."""
        pack, own = self.place.get(first, (-1, 0)), self.place.get(value, (-2, 0))
        return first == value or (pack[0] == own[0] and own[1] == lane)

    def _ordered(self, column: Lanes) -> Lanes:
        """Values in the order of the lanes of what they are of."""
        seen, waiting = set(), [column]
        while waiting:
            inside = waiting.pop()
            if inside in seen or len(set(inside)) == 1:
                continue
            seen.add(inside)
            places = [self.place.get(value) for value in inside]
            known = [place for place in places if place is not None]
            if len(known) == len(inside):
                if len({pack for pack, _ in known}) == 1 and len({lane for _, lane in known}) == len(inside):
                    return tuple(value for _, value in sorted(zip([lane for _, lane in known], column, strict=True)))
                continue
            waiting += zip(*(self.program.operands(value) for value in inside), strict=True)
        return column

    def _from_below(self) -> None:
        """Put together what reads the lanes of the same vectors, and else the same values, or inputs of its own."""
        levels: dict[int, list[int]] = defaultdict(list)
        for value in self._values:
            if value not in self.place:
                levels[self.program.depth[value]].append(value)
        for depth in sorted(levels):
            for own_inputs in (False, True):
                beside: dict[tuple, list[list[int]]] = defaultdict(lambda: [[] for _ in range(WIDTH)])
                for value in levels[depth]:
                    if value not in self.place and (found := self._reads(value, own_inputs)) is not None:
                        beside[found[0]][found[1]].append(value)
                for (width, *_), of_lane in beside.items():
                    for column in zip(*of_lane[:width], strict=False):
                        self._keep(column)
                        for inside in self.operands(column):
                            if all(self.program.code[need] == INPUT and need not in self.place for need in inside):
                                self._together(inside)

    def _reads(self, value: int, own_inputs: bool) -> tuple[tuple, int] | None:
        """What an operation has in common with those it goes together with, and its lane; None where it reads none."""
        needs = self.program.needs[value]
        places = [self.place.get(need) for need in needs]
        lanes = {place[1] for place in places if place is not None}
        widths = {len(self._columns[place[0]]) for place in places if place is not None}
        if len(lanes) != 1 or len(widths) != 1:
            return None
        key = [self._key(need, place, own_inputs) for need, place in zip(needs, places, strict=True)]
        key = sorted(key) if self.program.code[value] in COMMUTATIVE else key
        return (widths.pop(), self.program.shape[value], *key), lanes.pop()

    def _key(self, value: int, place: tuple[int, int] | None, own_inputs: bool) -> tuple[int, int]:
        if place is not None:
            return 0, place[0]
        if self.program.code[value] == CONSTANT or (own_inputs and self.program.code[value] == INPUT):
            return 1, self.program.shape[value]
        return 2, value
