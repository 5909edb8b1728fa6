"""Rates that need no equation in an implicit step.

Rows of ode that are one state or one algebraic unknown are substituted; what external functions solve is left to them.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from fowtlib.flattening import FlatDAE


@dataclass(frozen=True)
class Reduction:
    """The unknowns of an implicit step: the algebraic unknowns and the rates of the `free` states.

    order: other states, in the order in which their rates follow. source: for each of those its rate, as the number
    j of a state, whose value it is, or -1 - k for the algebraic unknown k. inside: states whose steps the external
    functions solve, steps: the numbers in q by which these are told how far; see language.stages.
    """

    free: list[int]
    order: list[int]
    source: list[int]
    inside: list[int]
    steps: list[int]

    def unknown_of_states(self, algebraics: int) -> list[int]:
        """The unknown that moves each state, through its rate; the free rates stand behind the algebraic unknowns.

        States inside follow, with numbers of their own: no unknown of a step moves them.
        """
        unknown = [0] * (len(self.free) + len(self.order) + len(self.inside))
        for i, state in enumerate([*self.free, *self.inside]):
            unknown[state] = algebraics + i
        for state, source in zip(self.order, self.source, strict=True):
            unknown[state] = unknown[source] if source >= 0 else -1 - source
        return unknown


def reduction(dae: FlatDAE, stages: bool = True) -> Reduction:
    """Found by the form of the rows alone; of states that are each other's rates in a ring, one stays free.

    stages: leave the steps of some states to the external functions that can solve them.
    """
    states = {dae.x[i].element_hash(): i for i in range(dae.x.shape[0])}
    algebraics = {dae.z[k].element_hash(): -1 - k for k in range(dae.z.shape[0])}
    known = states | algebraics
    found = {}
    for i in range(dae.ode.shape[0]):
        row = dae.ode[i]
        if row.is_symbolic() and row.element_hash() in known:
            found[i] = known[row.element_hash()]
    given = ca.vertcat(dae.u, dae.d, dae.p)
    numbers = {given[i].element_hash(): i for i in range(given.shape[0])}
    solved = dae.stages if stages else ()
    inside = sorted(states[stage.states[i].element_hash()] for stage in solved for i in range(stage.states.numel()))
    steps = [numbers[stage.step.element_hash()] for stage in solved]
    placed = [i for i in range(dae.ode.shape[0]) if i not in found and i not in set(inside)]
    free, order, done = list(placed), [], set(placed)
    waiting = dict(found)
    while waiting:
        ready = [i for i, source in waiting.items() if source < 0 or source in done]
        if not ready:
            first = min(waiting)
            free.append(first)
            ready = [first]
        else:
            order += ready
        for i in ready:
            done.add(i)
            del waiting[i]
    return Reduction(sorted(free), order, [found[i] for i in order], inside, steps)
