"""C code of scalar CasADi functions, in pieces that a compiler takes quickly.

One long piece of straight-line code takes a C compiler more than linear time, so that the code is cut into pieces; what
one computes and another needs lies in the scratch memory. Each of those values has a place of its own there, so that
pieces may be run again by themselves: those of one piece depend on the same unknowns, and where one unknown moves, only
the pieces that depend on it need to run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import reduce
from operator import or_

import casadi as ca

from fowtlib.solving.engines.c_lanes import ANY_PROCESSOR
from fowtlib.solving.engines.c_pieces import Pieces, Segment
from fowtlib.solving.engines.lanes import operations_of
from fowtlib.solving.engines.statements import Depends, Statement, Statements

PIECE = 800  # statements in one piece at most
CALL = 5  # statements that take as long as the call of a piece
EVALUATIONS = 100  # of all pieces, for one of each unknown with the pieces that depend on it

WRITERS = (__name__, *(f"fowtlib.solving.engines.{name}" for name in ("c_lanes", "c_pieces", "lanes", "statements")))
"""Modules on which the text of a function depends."""


@dataclass(frozen=True)
class Program:
    """C text of a function in sections, and what its pieces are.

    The text defines `void <section>(const double *<argument>, ..., double *<result>, ..., double *scratch)` for each
    section, and where it is asked for an array `pieces` of pointers to its pieces. scratch: numbers of memory that it
    needs. starts: the first piece of each section, and their count. places: the first place in the scratch memory that
    each piece writes, and their count. masks: unknowns on which each piece depends, for each of the dependences.
    constants: numbers of the function that its text does not hold.
    """

    text: str
    scratch: int
    starts: list[int]
    places: list[int]
    masks: list[list[int]]
    constants: list[float] = field(default_factory=list)


def c_program(
    function: ca.Function,
    sections: Sequence[tuple[str, Sequence[str]]],
    arguments: Sequence[str],
    parameters: Sequence[str],
    dependences: Sequence[Depends] = (),
    known_from: Callable[[int, int], int] = lambda argument, element: 0,
    word: int = ANY_PROCESSOR,
    constants: str = "",
) -> Program:
    """The C text of a scalar (SX) function of dense columns, in sections that run one after the other.

    sections: name, and the results of the function that it writes (in order, as the parameters they are written to).
    A value is computed in the first section that needs it. parameters: names of all result parameters. Pieces are made
    by the first of the dependences, and there is a table of them where there are dependences. known_from: the section
    from which on an element of an argument is known. word: lanes of a vector of C; `prologue` of them stands in front.
    constants: the parameter from which the numbers in the function are read; without it they stand in the text.
    """
    results = [(s, r) for s, (_, results) in enumerate(sections) for r in results]
    operations, read = operations_of(function, known_from), []
    if constants:
        read = operations.read_constants(len(arguments))
    statements = Statements(operations, [*arguments, constants], results, dependences)
    segments, starts = _grouped(statements.sections, bool(dependences))
    pieces = Pieces(sections[0][0], statements, segments, word)
    masks = [[_mask(piece, k) for piece in segments] for k in range(len(dependences))]
    signature = ", ".join([*(f"const double *{a}" for a in arguments), *(f"double *{r}" for r in parameters)])
    signature += ", double *scratch"
    call = ", ".join([*arguments, *parameters, "scratch"])
    name = sections[0][0]
    apart = signature.replace("*", "*restrict ")
    bodies = enumerate(pieces.bodies)
    text = [*pieces.shared, *(f"static FS_PIECE void {name}_piece_{k}({apart}) {{\n{body}}}\n" for k, body in bodies)]
    for s, (section, _) in enumerate(sections):
        calls = "".join(f"  {name}_piece_{k}({call});\n" for k in range(starts[s], starts[s + 1]))
        text.append(f"EXPORT void {section}({signature}) {{\n{calls}}}\n")
    if dependences:
        table = ", ".join([*(f"{name}_piece_{k}" for k in range(len(pieces.bodies))), "0"])
        text.append(f"EXPORT void (*const pieces[])({signature}) = {{{table}}};\n")
    return Program("".join(text), pieces.places[-1], starts, pieces.places, masks, read)


def _mask(piece: list[Segment], dependence: int) -> int:
    """Unknowns on which a piece depends."""
    return reduce(or_, (line.masks[dependence] for segment in piece for line in segment), 0)


def _grouped(sections: list[list[Statement]], by: bool) -> tuple[list[list[Segment]], list[int]]:
    """The segments of every piece, and the first piece of each section. A segment depends on the same unknowns."""
    pieces: list[list[Segment]] = []
    starts = [0]
    for section in sections:
        groups: dict[int, Segment] = defaultdict(list)
        for line in section:
            groups[line.masks[0] if by else 0].append(line)
        last = size = 0
        for mask in _chained(list(groups)):
            lines = groups[mask]
            if len(pieces) > starts[-1] and _better_as_one(size, last, len(lines), mask):
                pieces[-1].append(lines)
                size, last = size + len(lines), last | mask
            else:
                pieces += [[lines[i : i + PIECE]] for i in range(0, len(lines), PIECE)]
                size, last = len(pieces[-1][0]), mask
        starts.append(len(pieces))
    return pieces, starts


def _better_as_one(one: int, mask: int, other: int, more: int) -> bool:
    """Whether two pieces with so many statements, and the unknowns they depend on, take less time as one."""
    both = mask | more
    beside = one * (both.bit_count() - mask.bit_count()) + other * (both.bit_count() - more.bit_count())
    return one + other <= PIECE and beside < CALL * (EVALUATIONS + (mask & more).bit_count())


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
