"""States that an external function advances itself in an implicit step, so that they cost the engine no unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from fowtlib.language.equations import active
from fowtlib.language.run_time import at_start


@dataclass(slots=True)
class Stage:
    """States (k,) that one external function reads, and its input `step` (1,) [s]; see stage_step."""

    path: str
    states: ca.SX
    step: ca.SX


def stage_step(states: Any, name: str = "stage_step") -> ca.SX:
    """The input by which an external function solves the implicit steps of its states. Inside equations() only.

    Many small filters, such as those of the flow at each section of a blade, would each be an unknown of every implicit
    step. An external function that gets the states and gives their rates f(x, inputs) can do better: with a step k
    other than zero it takes x for the place from which the stage starts, solves
        x + k f(y, inputs) = y
    for the states y at the end of the stage itself, and gives f(y, inputs) and all else it gives at y. An engine with
    such a stage hands over k, and all others 0, with which the function is f(x, inputs). Nothing else of the model may
    read the states, but outputs. States (k,): as they are declared. The function need not give its slope by the step.
    """
    symbol = at_start(name, 1, "s", "how far the implicit stage of an engine reaches; zero elsewhere", _zero)
    active().stage(ca.densify(ca.vec(ca.SX(states))), symbol)
    return symbol


def _zero(component: Any) -> float:
    return 0.0
