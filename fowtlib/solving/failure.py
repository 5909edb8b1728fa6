"""What stands out in the equations where an integration fails: the sentence the user reads."""

from __future__ import annotations

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.externals import says_why
from fowtlib.solving import event_rules as rules
from fowtlib.solving.functions import AtParameters


class StepFailure(Exception):
    """An engine cannot go on; the text is the reason."""


def integration_failure(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray, step: float,
                        reason: str, advice: str) -> str:  # fmt: skip
    """Why no step leads on from the last good point: what is not finite there or ahead, or what changes fastest."""
    where = f"the integration fails after t = {t:.6g} s"
    ode = np.array(at.residual(t, x, z, q)[0]).ravel()
    for reach in rules.REACHES:
        h = reach * step
        try:
            name = not_finite(at, t + h, x + h * ode if h else x, z, q)
        except RuntimeError:
            if any(says_why(external.function) for external in at.dae.externals):
                raise
            paths = ", ".join(dict.fromkeys(external.path or "the model" for external in at.dae.externals))
            return f"{where}: an external function has no value there. Look at those of {paths}: {reason}."
        if name:
            return f"{where}: {name} is not a finite number. Check the parameters, start values and limits there."
        if not np.all(np.isfinite(ode)):
            break
    states = at.dae.states
    rates = np.abs(ode) / (rules.RATE_FLOOR + np.abs(x))
    fastest = f"the fastest change is der({states[int(np.argmax(rates))].path})" if rates.size else "nothing changes"
    return (
        f"{where}, because {reason}; {fastest}. Look there for a jump, a missing damping or a quantity that grows "
        f"without bound, {advice}."
    )


def step_failure(dae: FlatDAE, free: list[int], t: float, row: int, not_finite: bool) -> str:
    """Why a step fails, by the row that stands out: rows are alg, the rates that are unknowns, all rates."""
    rates = [f"der({state.path})" for state in dae.states]
    name = [*dae.residual_paths, *(rates[i] for i in free), *rates][row]
    if not_finite:
        return f"an equation of {name} is not a finite number at t = {t:.6g} s"
    return f"the equations of the step at t = {t:.6g} s are not solved, furthest of all that of {name}"


def cut_steps(count: int, first: float, last: float, parts: int, advice: str) -> str:
    """What a user should know of steps that were not solved at once; times [s]: of the first and the last one."""
    one, more = f"the step at t = {first:.6g} s was", f"{count} steps from t = {first:.6g} to {last:.6g} s were"
    return (
        f"{one if count == 1 else more} not solved at once and taken in up to {parts} parts. Something changes within "
        "a step there, a line that comes taut or a contact; what it peaks at has the error of such steps: compare with "
        f"a run of shorter ones, {advice}."
    )


def not_finite(at: AtParameters, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> str:
    """The variable, or the equation, that is the first in the order of computation not to be a finite number."""
    dae = at.dae
    ode, alg = (np.array(value).ravel() for value in at.residual(t, x, z, q))
    if np.all(np.isfinite(ode)) and np.all(np.isfinite(alg)):
        return ""
    names = [name for name, value in dae.observed.items() if not value.is_constant()]
    values = at.call(at.functions.observed(names), t, x, z, q)
    bad = np.flatnonzero(~np.isfinite(np.array(values).ravel()))
    if len(bad):
        name = names[bad[0]]
        return f"{name} ({dae.docs[name]})" if dae.docs.get(name) and not name.startswith("der(") else name
    paths = [*(f"der({state.path})" for state in dae.states), *(f"an equation of {p}" for p in dae.residual_paths)]
    return paths[int(np.flatnonzero(~np.isfinite(np.concatenate([ode, alg])))[0])]
