"""The log of an optimisation: a line for each iterate, which a person can read."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fowtlib.design.problem import Point, Problem

Say = Callable[[str], None]
HEAD = f"{'iterate':>7} {'evaluations':>11} {'objective':>13} {'violation':>11} {'step':>9}  worst constraint"


class Log:
    """Says what happens, line by line: iterates, and points that have no results."""

    def __init__(self, problem: Problem, say: Say):
        self.problem, self.say, self.number = problem, say, 0
        self.before: np.ndarray | None = None
        say(HEAD)

    def watch(self, point: Point, iterate: bool) -> None:
        """Be told of a point; see fowtlib.design.problem.Watcher."""
        if point.failure:
            self.say(f"{'':7} {self.problem.evaluations:>11}  no results: {point.failure}")
        elif iterate:
            self.say(self._line(point))
            self.before = point.x
            self.number += 1

    def _line(self, point: Point) -> str:
        moved = 0.0 if self.before is None else float(np.max(np.abs(point.x - self.before) / self.problem.scale))
        over = f"{point.violation:11.3g}" if np.isfinite(point.violation) else f"{'':11}"
        worst = f"{point.worst}{' (kept)' if point.violation <= 0 else ''}"
        counts = f"{self.number:>7} {self.problem.evaluations:>11}"
        return f"{counts} {point.objective:>13.6g} {over} {moved:>9.2g}  {worst}".rstrip()
