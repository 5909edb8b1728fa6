"""A design as a problem of optimisation: scaled variables y, objective and constraints, and what was found so far."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fowtlib.design.composition import Asked, Composition
from fowtlib.design.evaluation import Evaluated, Evaluator
from fowtlib.design.terms import Constraint, Objective
from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError

FEASIBLE = 1e-5  # of its scale, by which a limit may be passed


@dataclass(frozen=True, eq=False)
class Point:
    """A design that was evaluated: variables x [SI], objective, scaled constraints g, the limited numbers (rows,).

    violation: the largest over its scale, and the name of what has it; `failure`: why there are no results.
    """

    x: np.ndarray
    objective: float = np.nan
    g: np.ndarray = field(default_factory=lambda: np.zeros(0))
    values: np.ndarray = field(default_factory=lambda: np.zeros(0))
    violation: float = np.inf
    worst: str = ""
    failure: str = ""
    found: Evaluated | None = field(default=None, repr=False)

    @property
    def feasible(self) -> bool:
        return self.violation <= FEASIBLE

    def better_than(self, other: Point | None) -> bool:
        """Feasible before not, then the smaller objective, or the smaller violation."""
        if other is None or bool(self.failure) != bool(other.failure):
            return other is None or not self.failure
        if self.feasible != other.feasible:
            return self.feasible
        return self.objective < other.objective if self.feasible else self.violation < other.violation


Watcher = Callable[[Point, bool], None]
"""Is told of each point that was evaluated, and whether it is an iterate, of which slopes are wanted."""


class Problem:
    """Objective f and constraints lower <= g <= upper as functions of y in [y_lower, y_upper], all of the size of 1.

    Points are kept while they are the last few, so that f, g and their slopes at one y cost one evaluation.
    """

    def __init__(self, space: Space, asked: Asked, evaluator: Evaluator, objective: Objective,
                 constraints: tuple[Constraint, ...], x: np.ndarray):  # fmt: skip
        self.space, self.evaluator, self.watchers = space, evaluator, list[Watcher]()
        first = evaluator.evaluate(x)
        self.composition = Composition(space, asked, objective, constraints, first)
        self.offset = np.where(np.isfinite(space.lower), space.lower, 0.0)
        self.scale = space.scale
        self.lower, self.upper = self.composition.lower, self.composition.upper
        self.y_lower, self.y_upper = self.y(space.lower), self.y(space.upper)
        self.evaluations = self.gradients = 0
        self._points: dict[bytes, Point] = {}
        self._slopes: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}
        self.best: Point | None = None
        self.began = time.perf_counter()
        size = abs(self.composition.at(x, first)[0])
        self.f_scale = objective.scale or (size if size > 0 else 1.0)

    def y(self, x: np.ndarray) -> np.ndarray:
        """Scaled variables of those in SI."""
        return (x - self.offset) / self.scale

    def x(self, y: np.ndarray) -> np.ndarray:
        """Variables in SI, within their bounds, of scaled ones."""
        return np.clip(self.offset + self.scale * np.asarray(y, dtype=float), self.space.lower, self.space.upper)

    def point(self, y: np.ndarray) -> Point:
        """What is there; where there are no results, the reason is in it."""
        x = self.x(y)
        key = x.tobytes()
        if key not in self._points:
            self.evaluations += 1
            self._keep(key, self._evaluated(x))
        return self._points[key]

    def _evaluated(self, x: np.ndarray) -> Point:
        try:
            found = self.evaluator.evaluate(x)
            objective, g, values = self.composition.at(x, found)
        except ModelError as error:
            point = Point(x, failure=str(error))
        else:
            point = self._judged(x, objective, g, values, found)
        for watcher in self.watchers:
            watcher(point, False)
        if not point.failure and point.better_than(self.best):
            self.best = point
        return point

    def _judged(self, x: np.ndarray, objective: float, g: np.ndarray, values: np.ndarray, found: Evaluated) -> Point:
        if not (np.isfinite(objective) and np.all(np.isfinite(g)) and np.all(np.isfinite(values))):
            rows = self.composition.rows
            bad = next((row.name for row, value in zip(rows, values, strict=True) if not np.isfinite(value)), "")
            return Point(x, failure=f"{bad or 'the objective'} is not a finite number.")
        violations = self.composition.violations(values)
        worst = int(np.argmax(violations)) if violations.size else -1
        name = self.composition.rows[worst].name if violations.size else ""
        return Point(x, objective, g, values, float(violations[worst]) if violations.size else -np.inf, name, "", found)

    def slopes(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Slopes (n,) of the scaled objective and (k, n) of the constraints by y. ModelError where there are none."""
        point = self.point(y)
        key = point.x.tobytes()
        if key not in self._slopes:
            if point.failure:
                raise ModelError(point.failure)
            self.gradients += 1
            found = self.evaluator.evaluate(point.x, jacobian=True)
            df, dg = self.composition.slopes_at(point.x, found)
            if not (np.all(np.isfinite(df)) and np.all(np.isfinite(dg))):
                raise ModelError("a slope is not a finite number.")
            self._slopes = {key: (df * self.scale / self.f_scale, dg * self.scale)}
            for watcher in self.watchers:
                watcher(point, True)
        return self._slopes[key]

    def linear(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The results of the model (m,) and their slopes (m, n) by y. ModelError where there are none."""
        point = self.point(y)
        if point.failure:
            raise ModelError(point.failure)
        self.gradients += 1
        found = self.evaluator.evaluate(point.x, jacobian=True)
        assert found.jacobian is not None
        slopes = [found.jacobian[key].reshape(-1, len(self.space)) for key in self.composition.keys]
        J = np.concatenate([np.zeros((0, len(self.space))), *slopes]) * self.scale
        if not np.all(np.isfinite(J)):
            raise ModelError("a slope is not a finite number.")
        for watcher in self.watchers:
            watcher(point, True)
        return self.composition.results(found), J

    def results_at(self, point: Point) -> Evaluated:
        """The results of the model at a point."""
        return point.found if point.found is not None else self.evaluator.evaluate(point.x)

    def f(self, y: np.ndarray) -> float:
        """The scaled objective. ModelError where there are no results."""
        return self._sound(y).objective / self.f_scale

    def g(self, y: np.ndarray) -> np.ndarray:
        """The scaled constraints."""
        return self._sound(y).g

    def _sound(self, y: np.ndarray) -> Point:
        point = self.point(y)
        if point.failure:
            raise ModelError(point.failure)
        return point

    def _keep(self, key: bytes, point: Point) -> None:
        while len(self._points) >= 20:
            del self._points[next(iter(self._points))]
        self._points[key] = point
