"""Step 3: the structure check, and the report for a singular model."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from fowtlib.flattening import structure
from fowtlib.flattening.system import FlatEquation, Loop, System, Unknown, scalars
from fowtlib.language.equations import place
from fowtlib.language.errors import StructureError

SHOWN = 12  # unknowns or equations listed
FEW = 3  # equations that are shown with the eliminated ones they meet through


def check_structure(system: System, live: list[int], rows: Sequence[np.ndarray]) -> None:
    """Match equations and unknowns, a variable and its derivatives counting as one; report what does not fit.

    rows: numbers of the unknowns in each equation.
    """
    base_position = {number: k for k, number in enumerate(live)}
    base_of = np.array([base_position.get(unknown.base, -1) for unknown in system.unknowns])
    collapsed = []
    for row in rows:
        members = np.unique(base_of[row]) if len(row) else row
        collapsed.append(members[members >= 0] if len(members) else members)
    coarse = structure.dulmage_mendelsohn(collapsed, len(live))
    if not coarse.is_regular:
        raise StructureError(_report(system, live, coarse))


def _report(system: System, live: list[int], coarse: structure.Coarse) -> str:
    missing, surplus = len(coarse.unmatched_columns), len(coarse.unmatched_rows)
    counts = f"{_number(len(system.equations), 'equation')} for {_number(len(live), 'unknown')}"
    lines = [f"the model is singular: {counts}, after the simple ones are eliminated."]
    if missing:
        these = "these unknowns" if len(coarse.under_columns) > 1 else "this unknown"
        lines.append(f"Under-determined: {_count(missing, 'equation')} missing for {these}:")
        lines += _shortened(_undetermined([system.unknowns[live[j]] for j in coarse.under_columns]))
    if surplus:
        lines.append(f"Over-determined: {_count(surplus, 'equation')} too many among these:")
        members = [system.equations[i] for i in coarse.over_rows]
        lines += _shortened(_surplus(system, _with_eliminated(system, members)))
    lines.append(_likely_cause(system, live, coarse))
    return "\n".join(lines)


def _shortened(items: list[str]) -> list[str]:
    """Indented lines, not more than SHOWN of them."""
    more = [f"  ... and {len(items) - SHOWN} more"] if len(items) > SHOWN else []
    return [f"  {item}" for item in items[:SHOWN]] + more


def _undetermined(unknowns: list[Unknown]) -> list[str]:
    """Unknowns with meaning and hint, those with a hint first; elements of one array together."""
    arrays: dict[str, list[Unknown]] = {}
    for unknown in sorted(unknowns, key=lambda unknown: (not unknown.declared.hint, unknown.path)):
        name = unknown.path.rpartition("[")[0] if unknown.path.endswith("]") else unknown.path
        arrays.setdefault(name, []).append(unknown)
    items = []
    for members in arrays.values():
        first = members[0]
        doc = f" ({first.declared.doc})" if first.declared.doc else ""
        hint = f". Hint: {first.declared.hint}" if first.declared.hint else ""
        items.append(f"{', '.join(unknown.path for unknown in members)}{doc}{hint}")
    return items


def _surplus(system: System, equations: list[FlatEquation]) -> list[str]:
    """Equations as they were written; elements of one vector equation together."""
    lines: dict[tuple[str, str], list[str]] = {}
    for equation in equations:
        lines.setdefault((equation.path, equation.source), []).append(_equation(system, equation))
    return [
        texts[0] + (f" and {_number(len(set(texts)) - 1, 'more element')}" if len(set(texts)) > 1 else "")
        for texts in lines.values()
    ]


def _equation(system: System, equation: FlatEquation) -> str:
    """An equation as it was written, with its component and line."""
    left, right = (system.text(side) for side in _written(equation))
    text = f"{left} = {right}"
    text = text if len(text) <= 100 else text[:97] + "..."
    return f"{equation.path or 'the model'}: {text} ({place(equation.source)})"


def _written(equation: FlatEquation) -> tuple[ca.SX, ca.SX]:
    return equation.written or (equation.lhs, equation.rhs)


def _with_eliminated(system: System, equations: list[FlatEquation]) -> list[FlatEquation]:
    """A few equations together with the eliminated ones through which they meet, such as `a = b` and `a = 4`."""
    if len(equations) > FEW:
        return equations
    found, left = list(equations), list(system.eliminated)
    known = {symbol.element_hash() for equation in found for symbol in _symbols(equation)}
    while len(found) <= SHOWN:
        near = [equation for equation in left if any(s.element_hash() in known for s in _symbols(equation))]
        if not near:
            break
        found += near
        left = [equation for equation in left if not any(equation is other for other in near)]
        known |= {symbol.element_hash() for equation in near for symbol in _symbols(equation)}
    return found


def _symbols(equation: FlatEquation) -> list[ca.SX]:
    return ca.symvar(ca.vertcat(*_written(equation)))


def _number(n: int, word: str) -> str:
    return f"{n} {word}{'s' if n != 1 else ''}"


def _count(n: int, word: str) -> str:
    return f"{_number(n, word)} {'are' if n != 1 else 'is'}"


def _likely_cause(system: System, live: list[int], coarse: structure.Coarse) -> str:
    missing, surplus = len(coarse.unmatched_columns), len(coarse.unmatched_rows)
    if missing == surplus and system.loops:
        return f"Likely cause: {_loops(system.loops)}"
    if missing and surplus:
        return (
            "Likely cause: something is prescribed twice in one place and left open in another, "
            "as by a connection to the wrong port."
        )
    if missing:
        owners = sorted({_owner(system.unknowns[live[j]].path) for j in coarse.under_columns})
        return (
            f"Likely cause: {_names(owners)} {'lacks' if len(owners) == 1 else 'lack'} an equation or a connection; "
            "a body that nothing holds needs a joint, an output needs an equation."
        )
    for i in coarse.over_rows:
        cause = _without_unknown(system, system.equations[i])
        if cause:
            return f"Likely cause: {cause}"
    members = _with_eliminated(system, [system.equations[i] for i in coarse.over_rows])
    owners = sorted({equation.path or "the model" for equation in members})
    verb = "prescribes a quantity twice" if len(owners) == 1 else "prescribe the same quantity"
    return f"Likely cause: {_names(owners)} {verb}; remove one of the equations or connections."


def _without_unknown(system: System, equation: FlatEquation) -> str:
    """Why an equation has nothing to determine: what it contains is given already."""
    keys = {symbol.element_hash() for symbol in _symbols(equation)}
    if any(key in system.number for key in keys):
        return ""
    for item in system.inputs.values():
        if keys & {symbol.element_hash() for symbol in scalars(item.symbol)}:
            return (
                f"{item.path} is an input that nothing is connected to, so that its value comes from outside of the "
                "model and no equation can set it; connect an output to it, such as a Constant, "
                "or let its component declare it as an output (RealOutput) or a variable."
            )
    for item in system.discretes:
        if item.symbol.element_hash() in keys:
            return (
                f"{item.path} is discrete and changes by assign() in a sampled() or when() only, not by an equation; "
                "declare it without discrete=True, or assign it."
            )
    return f"the equation of {equation.path or 'the model'} contains no unknown; remove it, or make it an assert_()."


def _loops(loops: list[Loop]) -> str:
    """What is wrong with closed loops that hold something twice."""
    rigid = [loop for loop in loops if not loop.turning and not loop.moving]
    if rigid:
        parts = rigid[0].parts
        who = f"{_names(parts[:-1])} and {parts[-1]} are rigid and join" if len(parts) > 1 else f"{parts[0]} joins"
        return (
            f"{who} the same frames, so that what they carry is held twice; drop one of them, "
            "or give it a joint or a spring."
        )
    closing = _names([loop.parts[0] for loop in loops])
    if not any(loop.turning for loop in loops):
        return (
            f"no part of the loop that {closing} closes turns, so that its orientation is held twice; "
            "put a joint that turns (a Spherical, or a Revolute) into it."
        )
    return (
        f"the loop that {closing} closes constrains the same motion twice, "
        "as the hinges of a planar loop do out of its plane; make one of its hinges a PlanarLoopRevolute, "
        "or a ball joint (Spherical) where they are not parallel."
    )


def _owner(path: str) -> str:
    return path.removeprefix("der(").rsplit(".", 1)[0] if "." in path else "the model"


def _names(names: list[str]) -> str:
    shown = names[:4]
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(shown) + more
