"""Rates that need no equation: rows of ode that are one state or one algebraic unknown are substituted."""

from __future__ import annotations

from dataclasses import dataclass

from fowtlib.flattening import FlatDAE


@dataclass(frozen=True)
class Reduction:
    """The unknowns of an implicit step: the algebraic unknowns and the rates of the `free` states.

    order: the other states, in the order in which their rates follow. source: for each of those its rate, as the number
    j of a state, whose value it is, or -1 - k for the algebraic unknown k.
    """

    free: list[int]
    order: list[int]
    source: list[int]

    def unknown_of_states(self, algebraics: int) -> list[int]:
        """The unknown that moves each state, through its rate; the free rates stand behind the algebraic unknowns."""
        unknown = [0] * (len(self.free) + len(self.order))
        for i, state in enumerate(self.free):
            unknown[state] = algebraics + i
        for state, source in zip(self.order, self.source, strict=True):
            unknown[state] = unknown[source] if source >= 0 else -1 - source
        return unknown


def reduction(dae: FlatDAE) -> Reduction:
    """Found by the form of the rows alone; of states that are each other's rates in a ring, one stays free."""
    states = {dae.x[i].element_hash(): i for i in range(dae.x.shape[0])}
    algebraics = {dae.z[k].element_hash(): -1 - k for k in range(dae.z.shape[0])}
    known = states | algebraics
    found = {}
    for i in range(dae.ode.shape[0]):
        row = dae.ode[i]
        if row.is_symbolic() and row.element_hash() in known:
            found[i] = known[row.element_hash()]
    placed = [i for i in range(dae.ode.shape[0]) if i not in found]
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
    return Reduction(sorted(free), order, [found[i] for i in order])
