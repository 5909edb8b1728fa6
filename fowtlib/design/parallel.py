"""Cases of a design in several processes at once, each with the evaluator of its cases.

A process is a copy of this one (fork), made when results are first asked for: it has the compiled model, and keeps its
means, gains and slopes from one design to the next.
"""

from __future__ import annotations

import multiprocessing
import signal
import weakref
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fowtlib.design.evaluation import Evaluated, Evaluator
from fowtlib.language.errors import ModelError

OWN = 5  # results that cost as much as what a case takes without any


class OtherProcess:
    """An evaluator (fowtlib.design.evaluation.Evaluator) in a process of its own, which ends with this object."""

    def __init__(self, make: Callable[[], Evaluator]):
        self._make, self._number = make, 0
        self._process: Any = None

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        self.begin(x, jacobian)
        return self.found()

    def begin(self, x: np.ndarray, jacobian: bool) -> None:
        """Let it evaluate; `found` waits for it."""
        if self._process is None:
            context = multiprocessing.get_context("fork")
            self._ours, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(self._make, theirs), daemon=True)
            self._process.start()
            theirs.close()
            weakref.finalize(self, self._process.terminate)
        self._number += 1
        self._ours.send((self._number, x, jacobian))

    def found(self) -> Evaluated:
        """What it was asked for. Raises what was raised there."""
        number = 0
        try:
            while number != self._number:  # an answer that was not waited for, at an interrupt, is left out
                number, found = self._ours.recv()
        except EOFError:
            self._process = None
            raise ModelError("a process that evaluated cases has ended; was there too little memory?") from None
        if isinstance(found, BaseException):
            raise found
        return found


class Parallel:
    """An evaluator of several others, of which all but the first are in processes of their own."""

    def __init__(self, first: Callable[[], Evaluator], others: Sequence[Callable[[], Evaluator]], keys: Sequence[Any]):
        self._first, self.keys = first(), list(keys)
        self._others = [OtherProcess(make) for make in others]

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        for other in self._others:
            other.begin(x, jacobian)
        found, failed = [], None
        for part in (lambda: self._first.evaluate(x, jacobian), *(other.found for other in self._others)):
            try:
                found.append(part())
            except ModelError as error:  # the others are waited for: each answers once
                failed = failed or error
        if failed is not None:
            raise failed
        return joined(found, self.keys)


def joined(found: Sequence[Evaluated], keys: Sequence[Any]) -> Evaluated:
    """What several evaluators know, in the order of keys."""
    values, slopes, units, states = ({k: v for one in found for k, v in (getattr(one, what) or {}).items()}
                                     for what in ("values", "jacobian", "units", "states"))  # fmt: skip
    with_slopes = all(one.jacobian is not None for one in found)
    return Evaluated({key: values[key] for key in keys}, units, slopes if with_slopes else None, states)


def shared_out(costs: Sequence[int], processes: int) -> list[list[int]]:
    """Numbers of cases with so many results each, by process, so that all take about as long."""
    groups: list[list[int]] = [[] for _ in range(min(processes, len(costs)))]
    for number in sorted(range(len(costs)), key=lambda k: -costs[k]):
        min(groups, key=lambda group: sum(costs[k] + OWN for k in group)).append(number)
    return [sorted(group) for group in groups]


def refuse_where_none() -> None:
    """ModelError where this system has no such processes."""
    if "fork" not in multiprocessing.get_all_start_methods():
        raise ModelError("this system cannot copy a running process, so cases are evaluated in one: processes=1.")


def _serve(make: Callable[[], Evaluator], connection: Any) -> None:
    """Answer until the other end is closed. An interrupt is that of the process that asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    evaluator = None
    while True:
        try:
            number, x, jacobian = connection.recv()
        except EOFError:
            return
        try:
            evaluator = evaluator or make()
            found: Any = evaluator.evaluate(x, jacobian)
            states = {name: replace(state, observe=None, plant=None) for name, state in found.states.items()}
            found = replace(found, states=states)
        except Exception as error:
            found = error
        connection.send((number, found))
