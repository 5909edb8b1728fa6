"""C code of scalar CasADi functions, in pieces that a compiler takes quickly.

One long piece of straight-line code takes a C compiler more than linear time, so that the code is cut into pieces; what
one computes and another needs lies in the scratch memory. Each of those values has a place of its own there, so that
pieces may be run again by themselves: those of one piece depend on the same unknowns, and where one unknown moves, only
the pieces that depend on it need to run.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_

import casadi as ca

from fowtlib.solving.engines.c_lanes import ANY_PROCESSOR, OPERATIONS, VECTORS
from fowtlib.solving.engines.lanes import CONSTANT, INPUT, WIDTH, Lanes, Operations, Packs, operations_of

PIECE = 800  # operations in one piece at most
CALL = 5  # operations that take as long as the call of a piece
EVALUATIONS = 100  # of all pieces, for one of each unknown with the pieces that depend on it

WRITERS = (__name__, "fowtlib.solving.engines.c_lanes", "fowtlib.solving.engines.lanes")
"""Modules on which the text of a function depends."""

Depends = Callable[[int, int], int]
"""Unknowns on which an element of an argument depends, as bits of an integer: of the number of argument and element."""


@dataclass(frozen=True)
class Program:
    """C text of a function in sections, and what its pieces are.

    The text defines `void <section>(const double *<argument>, ..., double *<result>, ..., double *scratch)` for each
    section, and where it is asked for an array `pieces` of pointers to its pieces. scratch: numbers of memory that it
    needs. starts: the first piece of each section, and their count. places: the first place in the scratch memory that
    each piece writes, and their count. masks: unknowns on which each piece depends, for each of the dependences.
    """

    text: str
    scratch: int
    starts: list[int]
    places: list[int]
    masks: list[list[int]]


def c_program(
    function: ca.Function,
    sections: Sequence[tuple[str, Sequence[str]]],
    arguments: Sequence[str],
    parameters: Sequence[str],
    dependences: Sequence[Depends] = (),
    known_from: Callable[[int, int], int] = lambda argument, element: 0,
    word: int = ANY_PROCESSOR,
) -> Program:
    """The C text of a scalar (SX) function of dense columns, in sections that run one after the other.

    sections: name, and the results of the function that it writes (in order, as the parameters they are written to).
    A value is computed in the first section that needs it. parameters: names of all result parameters. Pieces are made
    by the first of the dependences, and there is a table of them where there are dependences. known_from: the section
    from which on an element of an argument is known. word: lanes of a vector of C; `prologue` of them stands in front.
    """
    results = [(s, r) for s, (_, results) in enumerate(sections) for r in results]
    lines = _Lines(operations_of(function, known_from), arguments, results, dependences)
    pieces, starts = _grouped(lines.sections, dependences[:1])
    bodies, places = _bodies(lines, pieces, word)
    masks = [[reduce(or_, (line.masks[k] for line in piece), 0) for piece in pieces] for k in range(len(dependences))]
    signature = ", ".join([*(f"const double *{a}" for a in arguments), *(f"double *{r}" for r in parameters)])
    signature += ", double *scratch"
    call = ", ".join([*arguments, *parameters, "scratch"])
    name = sections[0][0]
    apart = signature.replace("*", "*restrict ")
    text = [f"static FS_PIECE void {name}_piece_{k}({apart}) {{\n{body}}}\n" for k, body in enumerate(bodies)]
    for s, (section, _) in enumerate(sections):
        calls = "".join(f"  {name}_piece_{k}({call});\n" for k in range(starts[s], starts[s + 1]))
        text.append(f"EXPORT void {section}({signature}) {{\n{calls}}}\n")
    if dependences:
        table = ", ".join([*(f"{name}_piece_{k}" for k in range(len(bodies))), "0"])
        text.append(f"EXPORT void (*const pieces[])({signature}) = {{{table}}};\n")
    return Program("".join(text), places[-1], starts, places, masks)


@dataclass(frozen=True)
class _Line:
    """A statement: the values that it makes side by side, those that are a result's element, what it needs, masks."""

    column: Lanes
    result: str
    needs: tuple[Lanes, ...]
    masks: tuple[int, ...]


class _Lines:
    """Statements of each section, in an order in which they can run, and how what they make is called.

    plain: text of inputs and constants. column: where a value is made. number: of the statement that makes a column.
    """

    def __init__(self, operations: Operations, arguments: Sequence[str], results: Sequence[tuple[int, str]],
                 dependences: Sequence[Depends]):  # fmt: skip
        self.operations = operations
        self.plain: dict[int, str] = {}
        self._masks: dict[Lanes, tuple[int, ...]] = {}
        self._nothing = (0,) * len(dependences)
        for value, (code, needs) in enumerate(zip(operations.code, operations.needs, strict=True)):
            if code == CONSTANT:
                self.plain[value] = _number(operations.constant[value])
            elif code == INPUT:
                self.plain[value] = f"{arguments[needs[0]]}[{needs[1]}]"
                self._masks[(value,)] = tuple(depends(*needs) for depends in dependences)
        self.packs = Packs(operations, _needed(operations))
        self.column = {value: column for column in self.packs.columns for value in column}
        self.number: dict[Lanes, int] = {}
        self.sections: list[list[_Line]] = [[] for _ in range(1 + max((section for section, _ in results), default=0))]
        for result, element, value in operations.results:
            section, name = results[result]
            needs = self._columns([value])
            self._make(needs, self.sections[section])
            masks = self._joined([value], needs)
            self.sections[section].append(_Line((value,), f"{name}[{element}]", needs, masks))

    def operands(self, column: Lanes) -> list[Lanes]:
        """What a column is of, lane by lane."""
        return self.packs.operands(column)

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
        columns = [self.column.get(value, (value,)) for value in values if value not in self.plain]
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

    def _make(self, columns: Sequence[Lanes], lines: list[_Line]) -> None:
        """Write statements that make columns, and before them of what they need."""
        waiting = [(column, False) for column in reversed(columns)]
        while waiting:
            column, ready = waiting.pop()
            if column in self.number:
                continue
            needs = self._needs(column)
            if ready:
                inside = [column] if self.gathered(column) else self.operands(column)
                plain = [value for operand in inside for value in operand if value in self.plain]
                self._masks[column] = self._joined(plain, needs)
                self.number[column] = len(self.number)
                lines.append(_Line(column, "", needs, self._masks[column]))
            else:
                waiting.append((column, True))
                waiting += [(need, False) for need in reversed(needs)]


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


def _grouped(sections: list[list[_Line]], by: Sequence[Depends]) -> tuple[list[list[_Line]], list[int]]:
    """The lines of every piece, and the first piece of each section."""
    pieces: list[list[_Line]] = []
    starts = [0]
    for section in sections:
        groups: dict[int, list[_Line]] = defaultdict(list)
        for line in section:
            groups[line.masks[0] if by else 0].append(line)
        last = 0
        for mask in _chained(list(groups)):
            lines = groups[mask]
            if len(pieces) > starts[-1] and _better_as_one(len(pieces[-1]), last, len(lines), mask):
                lines, mask = pieces.pop() + lines, last | mask
            pieces += [lines[i : i + PIECE] for i in range(0, len(lines), PIECE)]
            last = mask
        starts.append(len(pieces))
    return pieces, starts


def _better_as_one(one: int, mask: int, other: int, more: int) -> bool:
    """Whether two pieces with so many operations, and the unknowns they depend on, take less time as one."""
    both = mask | more
    beside = one * (both.bit_count() - mask.bit_count()) + other * (both.bit_count() - more.bit_count())
    return one + other <= PIECE and beside < CALL * (EVALUATIONS + (mask & more).bit_count())


def _bodies(lines: _Lines, pieces: list[list[_Line]], word: int) -> tuple[list[str], list[int]]:
    """C text of the pieces, and the places in the scratch memory where what each of them keeps begins."""
    born = {line.column: number for number, piece in enumerate(pieces) for line in piece if not line.result}
    shared = {need for number, piece in enumerate(pieces) for line in piece for need in line.needs
              if born[need] != number}  # fmt: skip
    slot: dict[Lanes, int] = {}
    bodies, places, size = [], [0], 0
    for piece in pieces:
        body, here = [], _Here(lines, slot, word)
        for line in piece:
            if line.result:
                body.append(f"  {line.result} = {here.value(line.column[0])};\n")
                continue
            texts, names, kept = here.statement(line.column), here.made(line.column), line.column in shared
            kind = "double" if len(line.column) == 1 else "W"
            body += [f"  const {kind} {name} = {text};\n" for name, text in zip(names, texts, strict=True)]
            if kept:
                slot[line.column] = size
                stores = [f"scratch[{size}] = {names[0]}"]
                if kind == "W":
                    stores = [f"KEEP(scratch + {size + k * word}, {name})" for k, name in enumerate(names)]
                body += [f"  {store};\n" for store in stores]
                size += 1 if kind == "double" else len(names) * word
        if any(len(line.column) > 1 for line in piece):
            body.append("  LEAVE\n")
        bodies.append("".join(body))
        places.append(size)
    return bodies, places


class _Here:
    """How numbers and vectors are written inside of a piece. slot: where those of the pieces before lie."""

    def __init__(self, lines: _Lines, slot: dict[Lanes, int], word: int):
        self.lines, self.slot, self.word = lines, slot, word
        self.names: dict[Lanes, list[str]] = {}

    def made(self, column: Lanes) -> list[str]:
        """The names of what is made now: a number, or the words of a vector."""
        number = self.lines.number[column]
        words = [f"v{number}{'abcd'[k]}" for k in range(-(-len(column) // self.word))]
        self.names[column] = words if len(column) > 1 else [f"a{number}"]
        return self.names[column]

    def value(self, value: int) -> str:
        """A number."""
        if value in self.lines.plain:
            return self.lines.plain[value]
        column = self.lines.column.get(value, (value,))
        lane = column.index(value)
        if column not in self.names:
            return f"scratch[{self.slot[column] + lane}]"
        names = self.names[column]
        return f"LANE({names[lane // self.word]}, {lane % self.word})" if len(column) > 1 else names[0]

    def vector(self, column: Lanes) -> list[str]:
        """The words of values side by side."""
        if column in self.names:
            return self.names[column]
        lines, starts = self.lines, range(0, len(column), self.word)
        if len(set(column)) == 1 or lines.operations.code[column[0]] == CONSTANT:
            return self.words([self.value(value) for value in column])
        if lines.direct(column):
            return [f"LOAD(&{lines.plain[column[k]]})" for k in starts]
        return [f"LOAD(scratch + {self.slot[column] + k})" for k in starts]

    def words(self, lanes: list[str]) -> list[str]:
        """Words of lanes; what is left of the last is filled with its last lane."""
        filled = lanes + lanes[-1:] * (-len(lanes) % self.word)
        return [f"WORD({', '.join(filled[k : k + self.word])})" for k in range(0, len(filled), self.word)]

    def statement(self, column: Lanes) -> list[str]:
        """What makes a number, or the words of a vector."""
        if self.lines.gathered(column):
            return self.words([self.value(value) for value in column])
        code, operands = self.lines.operations.code[column[0]], self.lines.operands(column)
        if len(column) == 1:
            return [OPERATIONS[code].format(*(self.value(operand[0]) for operand in operands))]
        if code in VECTORS:
            return [VECTORS[code].format(*words) for words in zip(*map(self.vector, operands), strict=True)]
        return self.words([OPERATIONS[code].format(*map(self.value, lane)) for lane in zip(*operands, strict=True)])


def _chained(masks: list[int]) -> list[int]:
    """Masks so that each follows those it contains, and what follows it directly contains it where possible."""
    left, order = sorted(masks, key=lambda mask: (mask.bit_count(), mask)), []
    inside = {mask: sum(other & mask == other and other != mask for other in masks) for mask in masks}
    while left:
        ready = [mask for mask in left if not inside[mask]]
        after = [mask for mask in ready if order and mask & order[-1] == order[-1]]
        chosen = (after or ready)[0]
        left.remove(chosen)
        order.append(chosen)
        for mask in left:
            inside[mask] -= mask & chosen == chosen
    return order


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(float(value)) if value >= 0 else f"({float(value)!r})"
