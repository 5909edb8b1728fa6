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
from dataclasses import dataclass, field
from functools import reduce
from operator import or_

import casadi as ca

PIECE = 800  # operations in one piece at most
SMALL = 40  # a piece with less goes on with the next operations that depend on all that it depends on

OPERATIONS = {
    ca.OP_ASSIGN: "{0}", ca.OP_LIFT: "{0}", ca.OP_ADD: "{0} + {1}", ca.OP_SUB: "{0} - {1}", ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}", ca.OP_NEG: "-{0}", ca.OP_EXP: "exp({0})", ca.OP_LOG: "log({0})",
    ca.OP_POW: "pow({0}, {1})", ca.OP_CONSTPOW: "pow({0}, {1})", ca.OP_SQRT: "sqrt({0})", ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}", ca.OP_SIN: "sin({0})", ca.OP_COS: "cos({0})", ca.OP_TAN: "tan({0})",
    ca.OP_ASIN: "asin({0})", ca.OP_ACOS: "acos({0})", ca.OP_ATAN: "atan({0})", ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}", ca.OP_EQ: "{0} == {1}", ca.OP_NE: "{0} != {1}", ca.OP_NOT: "!{0}",
    ca.OP_AND: "{0} && {1}", ca.OP_OR: "{0} || {1}", ca.OP_FLOOR: "floor({0})", ca.OP_CEIL: "ceil({0})",
    ca.OP_FMOD: "fmod({0}, {1})", ca.OP_REMAINDER: "remainder({0}, {1})", ca.OP_FABS: "fabs({0})",
    ca.OP_SIGN: "({0} > 0) - ({0} < 0)", ca.OP_COPYSIGN: "copysign({0}, {1})", ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0",
    ca.OP_ERF: "erf({0})", ca.OP_FMIN: "fmin({0}, {1})", ca.OP_FMAX: "fmax({0}, {1})", ca.OP_INV: "1.0 / {0}",
    ca.OP_SINH: "sinh({0})", ca.OP_COSH: "cosh({0})", ca.OP_TANH: "tanh({0})", ca.OP_ASINH: "asinh({0})",
    ca.OP_ACOSH: "acosh({0})", ca.OP_ATANH: "atanh({0})", ca.OP_ATAN2: "atan2({0}, {1})", ca.OP_LOG1P: "log1p({0})",
    ca.OP_EXPM1: "expm1({0})", ca.OP_HYPOT: "hypot({0}, {1})",
}  # fmt: skip


PROLOGUE = """#include <math.h>
#ifdef __GNUC__
#define FS_PIECE __attribute__((noinline))
#else
#define FS_PIECE
#endif
"""
"""In front of the text of `c_program`."""

Depends = Callable[[int, int], int]
"""Unknowns on which an element of an argument depends, as bits of an integer: of the number of argument and element."""


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
    constants: str = "",
) -> Program:
    """The C text of a scalar (SX) function of dense columns, in sections that run one after the other.

    sections: name, and the results of the function that it writes (in order, as the parameters they are written to).
    A value is computed in the first section that needs it. parameters: names of all result parameters. Pieces are made
    by the first of the dependences, and there is a table of them where there are dependences. constants: the parameter
    from which the numbers in the function are read; without it they stand in the text.
    """
    results = [(s, r) for s, (_, names) in enumerate(sections) for r in names]
    values = _Values(function, arguments, results, constants)
    pieces, starts = values.grouped(*dependences[:1])
    bodies, places = values.bodies(pieces)
    masks = [values.of_pieces(pieces, depends) for depends in dependences]
    signature = ", ".join([*(f"const double *{a}" for a in arguments), *(f"double *{r}" for r in parameters)])
    signature += ", double *scratch"
    call = ", ".join([*arguments, *parameters, "scratch"])
    name = sections[0][0]
    text = [f"static FS_PIECE void {name}_piece_{k}({signature}) {{\n{body}}}\n" for k, body in enumerate(bodies)]
    for s, (section, _) in enumerate(sections):
        calls = "".join(f"  {name}_piece_{k}({call});\n" for k in range(starts[s], starts[s + 1]))
        text.append(f"EXPORT void {section}({signature}) {{\n{calls}}}\n")
    if dependences:
        table = ", ".join([*(f"{name}_piece_{k}" for k in range(len(bodies))), "0"])
        text.append(f"EXPORT void (*const pieces[])({signature}) = {{{table}}};\n")
    return Program("".join(text), places[-1], starts, places, masks, values.constants)


@dataclass(frozen=True)
class _Line:
    """One operation: the value it makes, or None for a result; C text with {0}, {1}; values that it needs."""

    value: int | None
    text: str
    needs: list[int]
    section: int


class _Values:
    """The instructions of a function with every value assigned once."""

    def __init__(self, function: ca.Function, arguments: Sequence[str], results: Sequence[tuple[int, str]],
                 constants: str = ""):  # fmt: skip
        self.plain: dict[int, str] = {}  # values that are inputs or constants
        self.constants: list[float] = []  # those that are read from an array of that name
        self.inputs: dict[int, tuple[int, int]] = {}  # argument and element of those that are inputs
        holder: dict[int, int] = {}
        found: list[tuple[int | None, str, list[int], int]] = []
        for k in range(function.n_instructions()):
            code = function.instruction_id(k)
            inside, outside = function.instruction_input(k), function.instruction_output(k)
            if code == ca.OP_OUTPUT:
                section, name = results[outside[0]]
                found.append((None, f"{name}[{outside[1]}] = {{0}};", [holder[inside[0]]], section))
                continue
            if code == ca.OP_CONST:
                self.plain[k] = _number(function.instruction_constant(k))
                if constants:
                    self.plain[k] = f"{constants}[{len(self.constants)}]"
                    self.constants.append(function.instruction_constant(k))
            elif code == ca.OP_INPUT:
                self.plain[k] = f"{arguments[inside[0]]}[{inside[1]}]"
                self.inputs[k] = (inside[0], inside[1])
            elif code in OPERATIONS:
                found.append((k, OPERATIONS[code], [holder[place] for place in inside], len(results)))
            else:
                raise NotImplementedError(f"there is no C text for the CasADi operation {code}")
            holder[outside[0]] = k
        first: dict[int, int] = {}  # section that needs a value first
        self.lines: list[_Line] = []
        for value, text, needs, section in reversed(found):
            section = section if value is None else first.get(value, section)
            for need in needs:
                first[need] = min(first.get(need, section), section)
            self.lines.append(_Line(value, text, needs, section))
        self.lines.reverse()
        self.sections = max((section for section, _ in results), default=0) + 1

    def masks(self, depends: Depends) -> dict[int, int]:
        """Unknowns on which each line depends, by the identity of the line."""
        of = {k: depends(*place) for k, place in self.inputs.items()}
        masks = {}
        for line in self.lines:
            mask = 0
            for need in line.needs:
                mask |= of.get(need, 0)
            if line.value is not None:
                of[line.value] = mask
            masks[id(line)] = mask
        return masks

    def of_pieces(self, pieces: list[list[_Line]], depends: Depends) -> list[int]:
        """Unknowns on which each piece depends."""
        masks = self.masks(depends)
        return [reduce(or_, (masks[id(line)] for line in lines), 0) for lines in pieces]

    def grouped(self, depends: Depends = lambda argument, element: 0) -> tuple[list[list[_Line]], list[int]]:
        """The lines of every piece, and the first piece of each section."""
        masks = self.masks(depends)
        of_section: list[dict[int, list[_Line]]] = [defaultdict(list) for _ in range(self.sections)]
        for line in self.lines:
            if line.section < self.sections:  # what no result needs is left out
                of_section[line.section][masks[id(line)]].append(line)
        pieces: list[list[_Line]] = []
        starts = [0]
        for groups in of_section:
            last = 0
            for mask in _chained(list(groups)):
                lines = groups[mask]
                if len(pieces) > starts[-1] and len(pieces[-1]) < SMALL and last & mask == last:
                    lines = pieces.pop() + lines
                pieces += [lines[i : i + PIECE] for i in range(0, len(lines), PIECE)]
                last = mask
            starts.append(len(pieces))
        return pieces, starts

    def bodies(self, pieces: list[list[_Line]]) -> tuple[list[str], list[int]]:
        """C text of the pieces, and the places in the scratch memory where what each of them keeps begins."""
        born = {line.value: number for number, lines in enumerate(pieces) for line in lines if line.value is not None}
        shared = {need for number, lines in enumerate(pieces) for line in lines for need in line.needs
                  if born.get(need, number) != number}  # fmt: skip
        slot: dict[int, int] = {}
        bodies, places = [], [0]
        for lines in pieces:
            body, here = [], {}
            for line in lines:
                for need in line.needs:
                    if need not in here:
                        here[need] = self.plain[need] if need in self.plain else f"scratch[{slot[need]}]"
                expression = line.text.format(*(here[need] for need in line.needs))
                if line.value is None:
                    body.append(f"  {expression}\n")
                    continue
                here[line.value] = f"a{line.value}"
                body.append(f"  const double a{line.value} = {expression};\n")
                if line.value in shared:
                    slot[line.value] = len(slot)
                    body.append(f"  scratch[{slot[line.value]}] = a{line.value};\n")
            bodies.append("".join(body))
            places.append(len(slot))
        return bodies, places


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
