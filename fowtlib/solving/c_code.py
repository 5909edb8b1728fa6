"""C code of scalar CasADi functions, in pieces that a compiler takes quickly.

One long piece of straight-line code takes a C compiler more than linear time, so that the code is cut into pieces; what
one computes and another needs lies in the scratch memory.
"""

from __future__ import annotations

import math

import casadi as ca

PIECE = 800  # operations in one piece

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


def c_function(function: ca.Function, name: str, arguments: list[str], results: list[str]) -> tuple[str, int]:
    """C text of a scalar (SX) function of dense columns, and the scratch memory it needs.

    The text defines `void name(const double *<argument>, ..., double *<result>, ..., double *scratch)`.
    """
    values = _Values(function, arguments, results)
    signature = ", ".join([*(f"const double *{a}" for a in arguments), *(f"double *{r}" for r in results)])
    signature += ", double *scratch"
    call = ", ".join([*arguments, *results, "scratch"])
    pieces, size = values.pieces()
    text = [
        f"static FS_PIECE void {name}_{k}({signature}) {{\n{body}}}\n" for k, body in enumerate(pieces)
    ] + [f"static void {name}({signature}) {{\n", *(f"  {name}_{k}({call});\n" for k in range(len(pieces))), "}\n"]
    return "".join(text), size


PROLOGUE = "#include <math.h>\n#define FS_PIECE __attribute__((noinline))\n"
"""In front of the text of `c_function`."""


class _Values:
    """The instructions of a function with every value assigned once."""

    def __init__(self, function: ca.Function, arguments: list[str], results: list[str]):
        self.lines: list[tuple[int | None, str, list[int]]] = []  # value or None, C text with {0}, {1}, values it needs
        self.plain: dict[int, str] = {}  # values that are inputs or constants
        holder: dict[int, int] = {}
        for k in range(function.n_instructions()):
            code = function.instruction_id(k)
            inside, outside = function.instruction_input(k), function.instruction_output(k)
            if code == ca.OP_OUTPUT:
                self.lines.append((None, f"{results[outside[0]]}[{outside[1]}] = {{0}};", [holder[inside[0]]]))
                continue
            if code == ca.OP_CONST:
                self.plain[k] = _number(function.instruction_constant(k))
            elif code == ca.OP_INPUT:
                self.plain[k] = f"{arguments[inside[0]]}[{inside[1]}]"
            elif code in OPERATIONS:
                self.lines.append((k, OPERATIONS[code], [holder[place] for place in inside]))
            else:
                raise NotImplementedError(f"there is no C text for the CasADi operation {code}")
            holder[outside[0]] = k

    def pieces(self) -> tuple[list[str], int]:
        """Bodies of the pieces, and the size of the scratch memory between them."""
        cuts = [self.lines[i : i + PIECE] for i in range(0, len(self.lines), PIECE)]
        born = {value: number for number, lines in enumerate(cuts) for value, _, _ in lines if value is not None}
        last: dict[int, int] = {}
        for number, lines in enumerate(cuts):
            last |= {value: number for _, _, needs in lines for value in needs if value in born}
        slot: dict[int, int] = {}
        free: list[int] = []
        size, bodies = 0, []
        for number, lines in enumerate(cuts):
            body, here = [], {}
            for value, text, needs in lines:
                for need in needs:
                    if need not in here:
                        here[need] = self.plain[need] if need in self.plain else f"scratch[{slot[need]}]"
                expression = text.format(*(here[need] for need in needs))
                if value is None:
                    body.append(f"  {expression}\n")
                    continue
                here[value] = f"a{len(body)}"
                body.append(f"  const double {here[value]} = {expression};\n")
                if last.get(value, number) > number:
                    if not free:
                        free, size = [size], size + 1
                    slot[value] = free.pop()
                    body.append(f"  scratch[{slot[value]}] = {here[value]};\n")
            free += [slot[value] for value, end in last.items() if end == number and value in slot]
            bodies.append("".join(body))
        return bodies, size


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(float(value)) if value >= 0 else f"({float(value)!r})"
