"""Start values of unknowns that an equation gives: the unknown that is left to be found takes them up.

Tearing chooses what is iterated and index reduction what is a state, whatever else the author of a component gave a
start value. Where y = 2 x gives y, the start of y says where x begins.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca

from fowtlib.flattening.system import System


def carry_starts(
    system: System, states: Sequence[int], torn: Sequence[int], given: Iterable[tuple[int, ca.SX]]
) -> None:
    """Put start values of unknowns that are assigned into those that they follow from.

    given: numbers of assigned unknowns and what each is, of states, torn unknowns and what is known. A start is carried
    where that contains, with a factor of numbers and parameters, one unknown whose own start counts less: which has
    none, or a default where this one was given for the model. A torn unknown, whose start is a guess, takes it before
    a state. Where there is none, or several, the start has no effect.
    """
    unknowns = system.unknowns
    rows = [(j, value) for j, value in given if unknowns[j].order == 0 and unknowns[j].start is not None]
    if not rows:
        return
    heads = [*torn, *states]
    column = ca.vertcat(*[value for _, value in rows])
    symbols = ca.vertcat(*[unknowns[j].symbol for j in heads])
    discretes = ca.vertcat(*[item.symbol for item in system.discretes])
    known = _known(system)
    pattern = ca.Function("starts", [ca.vertcat(symbols, discretes), *known], [column], {"allow_free": True})
    members: list[set[int]] = [set() for _ in rows]
    for row, place in zip(*pattern.jac_sparsity(0, 0).get_triplet(), strict=True):
        if place < len(heads):
            members[row].add(heads[place])
    waiting = sorted(range(len(rows)), key=lambda k: -unknowns[rows[k][0]].start_rank)
    moved = True
    while moved:
        moved = False
        for k in list(waiting):
            number, value = rows[k]
            lower = {j for j in members[k] if unknowns[j].start_rank < unknowns[number].start_rank}
            lower = lower & set(torn) or lower
            if len(lower) != 1:
                continue
            waiting.remove(k)
            moved = _carried(system, number, lower.pop(), value, members[k]) or moved


def _known(system: System) -> list[ca.SX]:
    """Symbols that have values at a start, and that no start value may depend on."""
    columns = [system.time, *[ca.vec(item.symbol) for item in system.inputs.values()]]
    outputs = [symbol for item in system.intermediates if item.function is not None for symbol in item.symbols]
    return [ca.vertcat(*columns, *outputs)]


def _carried(system: System, number: int, into: int, value: ca.SX, members: set[int]) -> bool:
    """Start of the unknown `into` with which `value` is the start of the unknown `number`; whether there is one."""
    source, target = system.unknowns[number], system.unknowns[into]
    others = [system.unknowns[j] for j in members if j != into]
    symbols = [*(other.symbol for other in others), *(item.symbol for item in system.discretes)]
    starts = [*(other.start for other in others), *(item.start for item in system.discretes)]
    slope = ca.jacobian(value, target.symbol)
    moving = ca.vertcat(target.symbol, *symbols, *_known(system))
    if slope.nnz() == 0 or ca.depends_on(slope, moving):
        return False
    rest = ca.substitute([value], [ca.vertcat(target.symbol, *symbols)],
                         [ca.vertcat(0, *[0 if start is None else start for start in starts])])[0]  # fmt: skip
    if ca.depends_on(rest, ca.vertcat(*_known(system))):
        return False
    slope = ca.densify(slope)
    own = 0 if target.start is None else target.start
    found = (source.start - rest) / slope
    target.start = found if slope.is_constant() else ca.if_else(slope == 0, own, found)  # of parameters that may be 0
    target.start_set = source.start_set
    return True
