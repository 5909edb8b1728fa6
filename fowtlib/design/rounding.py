"""Kinks of a function rounded off: where the larger of two is taken, or an absolute value, slopes have a step.

A rule that takes the worse of two ends has its optimum where both are as bad, just at the step, and Newton's method
goes from one side to the other for ever. Rounded, max(a, b) = (a + b + sqrt((a - b)^2 + w^2 (a^2 + b^2)))/2: too large
by w |a|/sqrt(2) where both are equal, by some w^2 |a| elsewhere. Conditions stay steps.
"""

from __future__ import annotations

import casadi as ca

_TINY = 1e-100


def rounded(function: ca.Function, width: float) -> ca.Function:
    """A function of the same arguments with its larger, smaller and sizes rounded off over a share `width` of them.

    One that is no sequence of plain operations (a table, an iteration) stays as it is.
    """
    try:
        plain = function.expand()
    except RuntimeError:
        return function
    given = [ca.SX.sym(plain.name_in(k), plain.sparsity_in(k)) for k in range(plain.n_in())]
    inputs = [ca.vertsplit(ca.vertcat(*item.nonzeros())) if item.nnz() else [] for item in given]
    work = [ca.SX(0)] * plain.sz_w()
    found = [[ca.SX(0)] * plain.nnz_out(k) for k in range(plain.n_out())]
    for k in range(plain.n_instructions()):
        op, to, of = plain.instruction_id(k), plain.instruction_output(k), plain.instruction_input(k)
        if op == ca.OP_INPUT:
            work[to[0]] = inputs[of[0]][of[1]]
        elif op == ca.OP_OUTPUT:
            found[to[0]][to[1]] = work[of[0]]
        elif op == ca.OP_CONST:
            work[to[0]] = ca.SX(plain.instruction_constant(k))
        else:
            work[to[0]] = _operation(op, [work[place] for place in of], width)
    outputs = [ca.SX(plain.sparsity_out(k), ca.vertcat(*values)) if values else ca.SX(plain.sparsity_out(k))
               for k, values in enumerate(found)]  # fmt: skip
    return ca.Function(plain.name(), given, outputs, plain.name_in(), plain.name_out())


def _operation(op: int, of: list[ca.SX], width: float) -> ca.SX:
    if op == ca.OP_FABS:
        return _larger(of[0], -of[0], width)
    if op == ca.OP_FMAX:
        return _larger(of[0], of[1], width)
    if op == ca.OP_FMIN:
        return -_larger(-of[0], -of[1], width)
    return ca.SX.unary(op, of[0]) if len(of) == 1 else ca.SX.binary(op, *of)


def _larger(a: ca.SX, b: ca.SX, width: float) -> ca.SX:
    if a.is_constant() and b.is_constant():
        return ca.fmax(a, b)
    return (a + b + ca.sqrt((a - b) ** 2 + width**2 * (a**2 + b**2) + _TINY)) / 2
