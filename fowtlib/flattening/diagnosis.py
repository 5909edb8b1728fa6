"""Step 3: the structure check, and the report for a singular model."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fowtlib.flattening import structure
from fowtlib.flattening.incidence import Incidence
from fowtlib.flattening.system import System, residuals
from fowtlib.language.equations import place
from fowtlib.language.errors import StructureError

SHOWN = 12


def check_structure(system: System, live: list[int], incidence: Incidence) -> list[np.ndarray]:
    """Match equations and unknowns, a variable and its derivatives counting as one; report what does not fit."""
    base_position = {number: k for k, number in enumerate(live)}
    base_of = np.array([base_position.get(unknown.base, -1) for unknown in system.unknowns])
    rows = incidence.rows(residuals(system.equations))
    collapsed = []
    for row in rows:
        members = np.unique(base_of[row]) if len(row) else row
        collapsed.append(members[members >= 0] if len(members) else members)
    coarse = structure.dulmage_mendelsohn(collapsed, len(live))
    if not coarse.is_regular:
        raise StructureError(_report(system, live, coarse))
    return rows


def _report(system: System, live: list[int], coarse: structure.Coarse) -> str:
    equations, unknowns = len(system.equations), len(live)
    missing, surplus = len(coarse.unmatched_columns), len(coarse.unmatched_rows)
    lines = [f"the model is singular: {equations} equations for {unknowns} unknowns."]
    if missing:
        lines.append(f"Under-determined: {_count(missing, 'equation')} missing for these unknowns:")
        names = [system.unknowns[live[j]] for j in coarse.under_columns]
        shown = sorted(names, key=lambda unknown: (not unknown.declared.hint, unknown.path))[:SHOWN]
        for unknown in shown:
            hint = f" Hint: {unknown.declared.hint}" if unknown.declared.hint else ""
            doc = f" ({unknown.declared.doc})" if unknown.declared.doc else ""
            lines.append(f"  {unknown.path}{doc}{'.' + hint if hint else ''}")
        lines += _more(len(names))
    if surplus:
        lines.append(f"Over-determined: {_count(surplus, 'equation')} too many among these:")
        shown_equations = list(dict.fromkeys(_equation(system, i) for i in coarse.over_rows))
        lines += [f"  {text}" for text in shown_equations[:SHOWN]]
        lines += _more(len(shown_equations))
    lines.append(_likely_cause(system, live, coarse))
    return "\n".join(lines)


def _equation(system: System, number: int) -> str:
    equation = system.equations[number]
    text = f"{equation.lhs} = {equation.rhs}"
    return (
        f"{equation.path or 'the model'}: {text if len(text) <= 100 else text[:97] + '...'} ({place(equation.source)})"
    )


def _count(n: int, word: str) -> str:
    return f"{n} {word}{'s' if n != 1 else ''} {'are' if n != 1 else 'is'}"


def _more(total: int) -> Iterable[str]:
    return [f"  ... and {total - SHOWN} more"] if total > SHOWN else []


def _likely_cause(system: System, live: list[int], coarse: structure.Coarse) -> str:
    missing, surplus = len(coarse.unmatched_columns), len(coarse.unmatched_rows)
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
    owners = sorted({system.equations[i].path or "the model" for i in coarse.over_rows})
    return f"Likely cause: {_names(owners)} prescribe the same quantity; remove one of the equations or connections."


def _owner(path: str) -> str:
    return path.removeprefix("der(").rsplit(".", 1)[0] if "." in path else "the model"


def _names(names: list[str]) -> str:
    shown = names[:4]
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(shown) + more
