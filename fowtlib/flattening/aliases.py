"""Step 4: alias elimination. Of unknowns equal up to a sign one remains; those equal to a number vanish."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import casadi as ca

from fowtlib.flattening.connections import SignedSets
from fowtlib.flattening.system import FlatEquation, System
from fowtlib.language.declarations import STATE_PREFERENCES

Substitute = Callable[[list[ca.SX]], list[ca.SX]]


def eliminate_aliases(system: System) -> tuple[Substitute, dict[int, ca.SX]]:
    """Remove the alias equations; returns the substitution, and what each eliminated unknown became."""
    sets = SignedSets(len(system.unknowns))
    constants: dict[int, tuple[int, ca.SX]] = {}
    rates: dict[int, tuple[int, ca.SX, FlatEquation]] = {}
    kept = []
    for equation in system.equations:
        left, right = _signed(system, equation.lhs), _signed(system, equation.rhs)
        if left and right and _union(system, sets, left, right):
            system.eliminated.append(equation)
            continue
        if left and right and _names_a_rate(system, left, right, rates, equation):
            continue
        if bool(left) != bool(right):
            (number, sign), value = (left, equation.rhs) if left else (right, equation.lhs)
            if value.is_constant() and system.unknowns[number].order == 0 and number not in constants:
                constants[number] = (sign, value)
                system.eliminated.append(equation)
                continue
        kept.append(equation)
    replaced = _replacements(system, sets, constants, rates, kept)
    system.equations = kept
    for number, equation in enumerate(kept):
        equation.base = number
    if not replaced:
        return lambda expressions: expressions, {}
    symbols = ca.vertcat(*[system.unknowns[k].symbol for k in replaced])
    values = ca.substitute(ca.vertcat(*replaced.values()), symbols, ca.vertcat(*replaced.values()))  # rates of aliases

    def substitute(expressions: list[ca.SX]) -> list[ca.SX]:
        return ca.substitute(expressions, [symbols], [values]) if expressions else expressions

    return substitute, dict(zip(replaced, values.elements(), strict=True))


def _signed(system: System, value: ca.SX) -> tuple[int, int] | None:
    """(number, sign) where the expression is an unknown or its negative."""
    sign = 1
    if not value.is_symbolic():
        if value.is_constant() or value.op() != ca.OP_NEG or not value.dep(0).is_symbolic():
            return None
        value, sign = value.dep(0), -1
    number = system.number.get(value.element_hash())
    return None if number is None else (number, sign)


def _union(system: System, sets: SignedSets, left: tuple[int, int], right: tuple[int, int]) -> bool:
    if system.unknowns[left[0]].order or system.unknowns[right[0]].order:
        return False
    return sets.union(left[0], right[0], left[1] * right[1])


def _names_a_rate(
    system: System,
    left: tuple[int, int],
    right: tuple[int, int],
    rates: dict[int, tuple[int, ca.SX, FlatEquation]],
    equation: FlatEquation,
) -> bool:
    """An equation a = der(x) of an unknown that is not differentiated itself and has no start: a names the rate."""
    (number, sign), (rate, sign_of_rate) = (left, right) if system.unknowns[right[0]].order else (right, left)
    unknown = system.unknowns[number]
    if unknown.order or not system.unknowns[rate].order or number in rates:
        return False
    if unknown.start is not None or unknown.declared.state in ("prefer", "always"):
        return False
    rates[number] = (sign * sign_of_rate, system.unknowns[rate].symbol, equation)
    return True


def _is_differentiated(system: System, number: int) -> bool:
    return system.unknowns[number].rate >= 0


def _replacements(
    system: System,
    sets: SignedSets,
    constants: dict[int, tuple[int, ca.SX]],
    rates: dict[int, tuple[int, ca.SX, FlatEquation]],
    kept: list[FlatEquation],
) -> dict[int, ca.SX]:
    groups: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for number, unknown in enumerate(system.unknowns):
        if unknown.order == 0:
            representative, sign = sets.find(number)
            groups[representative].append((number, sign))
    replaced: dict[int, ca.SX] = {}
    for members in groups.values():
        fixed = [(number, sign) for number, sign in members if number in constants]
        naming = [(number, sign) for number, sign in members if number in rates]
        if naming and (fixed or any(_is_differentiated(system, number) for number, _ in members)):
            kept += [rates[number][2] for number, _ in naming]
        elif naming:
            kept += [rates[number][2] for number, _ in naming[1:]]
            number, sign = naming[0]
            sign_of_rate, rate, _ = rates[number]
            for other, sign_other in members:
                replaced[other] = sign_other * sign * sign_of_rate * rate
            continue
        if len(members) == 1 and not fixed:
            continue
        if fixed:
            number, sign = fixed[0]
            sign_of_value, value = constants[number]
            for other, sign_other in members:
                replaced[other] = sign_other * sign * sign_of_value * value
                _drop_rates(system, other, replaced)
            for other, _ in fixed[1:]:  # a second number for the same quantity: leave it to the structure check
                sign_of_other, second = constants[other]
                path = system.unknowns[other].path
                kept.append(FlatEquation(replaced[other], sign_of_other * second, path, "second value"))
            continue
        chosen, sign = max(members, key=lambda item: _rank(system, item[0]))
        _merge(system, chosen, sign, members)
        for other, sign_other in members:
            if other != chosen:
                _replace(system, other, chosen, sign * sign_other, replaced)
    return replaced


def _rank(system: System, number: int) -> tuple[int, int, int, int]:
    unknown = system.unknowns[number]
    length, rate = 0, unknown.rate
    while rate >= 0:
        length, rate = length + 1, system.unknowns[rate].rate
    return length, STATE_PREFERENCES.index(unknown.declared.state), unknown.start_rank, -number


def _merge(system: System, chosen: int, sign: int, members: list[tuple[int, int]]) -> None:
    """The remaining unknown takes the strongest wish to be a state, and a start value, from its aliases."""
    best, best_sign = max(members, key=lambda item: _rank(system, item[0])[1:])
    keep, source = system.unknowns[chosen], system.unknowns[best]
    starts = [(k, s) for k, s in members if system.unknowns[k].start is not None]
    if best != chosen:
        path = source.path if best_sign == sign else keep.path
        number, declared = chosen, source.declared
        while number >= 0:
            unknown = system.unknowns[number]
            if unknown.path != path:
                unit = unknown.declared.unit
                system.add_alias(unknown.path, unknown.symbol, unit + "/s" * unknown.order, unknown.declared.doc)
            unknown.declared, unknown.path = declared, path
            path, number = f"der({path})", unknown.rate
    if starts:
        other, other_sign = max(starts, key=lambda item: (system.unknowns[item[0]].start_rank, _rank(system, item[0])))
        source = system.unknowns[other]
        if source.start_rank > keep.start_rank:
            keep.start, keep.start_set = sign * other_sign * source.start, source.start_set


def _replace(system: System, other: int, chosen: int, sign: int, replaced: dict[int, ca.SX]) -> None:
    while other >= 0 and chosen >= 0:
        replaced[other] = sign * system.unknowns[chosen].symbol
        other, chosen = system.unknowns[other].rate, system.unknowns[chosen].rate


def _drop_rates(system: System, number: int, replaced: dict[int, ca.SX]) -> None:
    rate = system.unknowns[number].rate
    while rate >= 0:
        replaced[rate] = ca.SX(0)
        rate = system.unknowns[rate].rate
