"""Sizes from what a model shall do at rest: the same equations, solved for other unknowns.

As many targets as sizes: the equations of the model are solved for the sizes (Plant.equilibrium). More or fewer
targets, bounds among them, or an answer out of bounds: the design that keeps all and makes an objective least (Design).
Where no sizes keep all targets, those that are against each other are found, two where two are enough.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from fowtlib.analysis.plants import plant_of
from fowtlib.design.design import Design
from fowtlib.design.starts import starts as starts_of
from fowtlib.design.stopped import SearchStopped
from fowtlib.design.terms import Constraint, Function
from fowtlib.design.variables import Variable
from fowtlib.language.errors import ModelError, NotFoundError, SimulationError, did_you_mean

ITERATIONS, EVALUATIONS = 60, 40  # of the optimisation, and for the targets alone
STARTS = 4  # of the search for the targets alone: the first guesses, and others at random within the bounds
MISSED = 1e-5  # of the scale of a target, by which it counts as missed
NOWHERE = 1e3  # what all targets are missed by, in their scales, where the model has no equilibrium
CLOSE = 1e-6  # of a bound, by which what is found may lie beyond it
LEAST_CHANGE = "change of the sizes"
Row = tuple[Any, ...]


class TargetsError(ModelError):
    """No sizes keep all targets; against: the names of those that are against each other."""

    def __init__(self, message: str, against: Sequence[str] = (), *, where: str = ""):
        super().__init__(message, where=where)
        self.against = tuple(against)


class SizingStopped(SearchStopped):
    """Of sizes, by their names, that come nearest to the targets.

    left: root of the sum of the squares of what the targets are missed by, each over its scale.
    """


@dataclass(frozen=True, eq=False)
class Sized:
    """Sizes that were found. parameters: of a run, in SI; results: of all outputs, in `units`; before: at the start.

    way: "equations", solved for the sizes; or "optimisation". bounds, starts: of the sizes, in SI.
    """

    title: str
    parameters: Mapping[str, float]
    starts: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    size_units: Mapping[str, str]
    results: Mapping[str, float]
    before: Mapping[str, float]
    units: Mapping[str, str]
    targets: Mapping[str, str]
    way: str
    state: Any

    def __getitem__(self, name: str) -> float:
        """A size [SI] or a result, in its unit."""
        found = {**self.results, **self.parameters}
        if name not in found:
            raise NotFoundError(f"there is no size or result '{name}'{did_you_mean(name, found)}")
        return found[name]

    def size_rows(self) -> tuple[tuple[str, ...], list[Row]]:
        """Heads and rows of the sizes."""
        rows = [(f"{name} [{self.size_units[name]}]", self.starts[name], value, *self.bounds[name])
                for name, value in self.parameters.items()]  # fmt: skip
        return ("size", "before", "found", "lower", "upper"), rows

    def result_rows(self) -> tuple[tuple[str, ...], list[Row]]:
        """Heads and rows of the results, with the targets."""
        rows = [(f"{name} [{self.units[name]}]", self.before[name], value, self.targets.get(name, ""))
                for name, value in self.results.items()]  # fmt: skip
        return ("result", "before", "found", "target"), rows

    def plain(self) -> dict[str, Any]:
        """All of it as JSON can hold it."""
        keys = ("title", "way", "parameters", "starts", "results", "before", "units", "targets")
        found = {key: getattr(self, key) for key in keys} | {"bounds": {k: list(v) for k, v in self.bounds.items()}}
        return {key: dict(value) if isinstance(value, Mapping) else value for key, value in found.items()}

    def __repr__(self) -> str:
        lines = [f"<Sizes of {self.title}, by {self.way}>"]
        for rows in (self.size_rows()[1], self.result_rows()[1]):
            lines += [f"{row[0]:32}{row[1]:>14.6g}{row[2]:>14.6g}" for row in rows]
        return "\n".join(lines)


def size(model: Any, free: Mapping[str, Any], targets: Mapping[str, Any], *,
         objective: str | Mapping[str, float] | None = None) -> Sized:  # fmt: skip
    """Sizes at which a model does at rest what it shall.

    model      a model, compiled or not
    free       tunable parameters by path, each with its bounds, (lower, upper), or (lower, upper, first guess); SI or
               texts with units
    targets    results by name: a value, "28.5 s", or a bound, "< 4.5 deg", "> 1 m", or both, ["> 20 s", "< 35 s"]
    objective  what becomes least where the targets leave freedom; None: the change of the sizes, each over its range

    Raises TargetsError where no sizes within their bounds keep all targets, with those that are against each other;
    ParameterError for a parameter that there is not, or is not tunable. Ctrl-C raises SizingStopped, a
    KeyboardInterrupt that has the nearest sizes so far.
    """
    return _Sizing(plant_of(model), free, targets, objective).found()


@dataclass(frozen=True, eq=False)
class Nearest:
    """Sizes that come nearest to some targets [SI]; names of those they miss, values as texts, bounds they are at."""

    x: np.ndarray
    feasible: bool
    missed: list[str]
    shown: dict[str, str]
    at: list[str]


class _Sizing:
    """One search."""

    def __init__(self, plant: Any, free: Mapping[str, Any], targets: Mapping[str, Any], objective: Any):
        if not free or not targets:
            raise ModelError("sizes need parameters that are free, with bounds, and targets.")
        self.plant, self.targets = plant, {name: _texts(name, given) for name, given in targets.items()}
        self.variables = [_variable(path, given) for path, given in free.items()]
        space = Design(plant, self.variables, next(iter(targets))).space
        if space.elements != list(free):
            raise ModelError("a size is a number: free an element of an array, as 'diameters[2]'.")
        self.starts = dict(zip(free, space.start.tolist(), strict=True))
        self.bounds = dict(zip(free, zip(space.lower.tolist(), space.upper.tolist(), strict=True), strict=True))
        self.size_units = dict(zip(free, space.units, strict=True))
        self.objective = objective
        self.nearest: tuple[float, np.ndarray] | None = None  # what all targets are missed by, squared, and the sizes
        self.tried = 0

    def found(self) -> Sized:
        """The sizes; SizingStopped where the search is interrupted after its first sizes."""
        try:
            return self._found()
        except KeyboardInterrupt:
            if self.nearest is None:
                raise
            square, sizes = self.nearest
            values = dict(zip(self.starts, sizes.tolist(), strict=True))
            raise SizingStopped(values, self.size_units, float(np.sqrt(square)), self.tried) from None

    def _found(self) -> Sized:
        """The sizes, by equations where these decide them."""
        exact = [text.removeprefix("=").strip() for texts in self.targets.values() for text in texts if text[0] == "="]
        if len(exact) == len(self.targets) == len(self.variables) and self.objective is None:
            try:
                goals = dict(zip(self.targets, exact, strict=True))
                state = self.plant.equilibrium(free=self.starts, targets=goals)
            except SimulationError:
                state = None
            if state is not None:
                values = {path: _element(state.parameters, path) for path in self.starts}
                if all(self._within(path, value) for path, value in values.items()):
                    return self._sized(values, state, "equations")
        nearest = self._nearest(self.targets)
        if not nearest.feasible:
            raise self._refusal(nearest)
        values = dict(zip(self.starts, nearest.x.tolist(), strict=True))
        begun = [replace(item, start=values[item.name]) for item in self.variables]
        optimum = replace(self._design(self.targets), variables=begun).optimise("slsqp", iterations=ITERATIONS)
        if optimum.feasible:
            values = {path: float(optimum[path]) for path in self.starts}
        return self._sized(values, self.plant.equilibrium(values), "optimisation")

    def _within(self, path: str, value: float) -> bool:
        lower, upper = self.bounds[path]
        slack = CLOSE * max(abs(lower), abs(upper))
        return lower - slack <= value <= upper + slack

    def _design(self, targets: Mapping[str, Sequence[str]]) -> Design:
        """The sizes as a design, for some of the targets."""
        constraints = [Constraint.read(f"{name} {text}") for name, texts in targets.items() for text in texts]
        if self.objective is not None:
            return Design(self.plant, self.variables, self.objective, constraints, slopes="adjoint")
        ranges = {path: upper - lower for path, (lower, upper) in self.bounds.items()}

        def change(values: Mapping[str, Any]) -> Any:
            return sum(((values[path] - start) / ranges[path]) ** 2 for path, start in self.starts.items())

        functions = [Function(LEAST_CHANGE, change, list(self.starts), si=True)]
        return Design(self.plant, self.variables, LEAST_CHANGE, constraints, functions=functions, slopes="adjoint")

    def _nearest(self, targets: Mapping[str, Sequence[str]]) -> Nearest:
        """Where the sum of the squares of what the targets are missed by is least."""
        design = self._design(targets)
        problem = design.problem()
        names = [row.name for row in problem.composition.rows]

        def over(g: np.ndarray) -> np.ndarray:
            return np.maximum(g - problem.upper, 0.0) - np.maximum(problem.lower - g, 0.0)

        def missed(y: np.ndarray) -> np.ndarray:
            try:
                rest = over(problem.g(y))
            except ModelError:  # it does not float with these sizes
                return np.full(len(names), NOWHERE)
            if targets is self.targets:
                self.tried += 1
                square = float(rest @ rest)
                if self.nearest is None or square < self.nearest[0]:
                    self.nearest = square, problem.point(y).x
            return rest

        def slopes(y: np.ndarray) -> np.ndarray:
            return problem.slopes(y)[1] * (over(problem.g(y)) != 0)[:, None]

        ends, best = (problem.y_lower, problem.y_upper), None
        for begin in starts_of(design.space, STARTS, 0):
            y = np.clip(problem.y(begin), *ends)
            if problem.point(y).failure:
                continue
            found = least_squares(missed, y, slopes, ends, xtol=1e-8, ftol=1e-9, gtol=1e-12, max_nfev=EVALUATIONS)
            best = found if best is None or found.cost < best.cost else best
            if best.cost < MISSED**2 / 2:
                break
        if best is None:
            raise ModelError("the model has no equilibrium with the sizes at the start; give first guesses with one.")
        found = best
        point = problem.point(found.x)
        near = np.minimum(found.x - problem.y_lower, problem.y_upper - found.x) < 1e-4
        at = [f"{path} at its {'lower' if y < (low + high) / 2 else 'upper'} bound" for path, y, low, high, is_near in
              zip(self.starts, found.x, problem.y_lower, problem.y_upper, near, strict=True) if is_near]  # fmt: skip
        rows = problem.composition.rows
        shown = {row.name: f"{value:.5g}" + ("" if row.unit == "1" else f" {row.unit}")
                 for row, value in zip(rows, point.values, strict=True)}  # fmt: skip
        violated = [name for name, x in zip(names, np.abs(over(point.g)), strict=True) if x > MISSED]
        return Nearest(point.x, not violated, list(dict.fromkeys(violated)), shown, at)

    def _refusal(self, nearest: Nearest) -> TargetsError:
        """Why no sizes do: one target, or two, that no sizes keep, or all that are in the way."""
        for count in (1, 2):
            for some in itertools.combinations(self.targets, count):
                if not set(some) & set(nearest.missed):
                    continue
                alone = self._nearest({name: self.targets[name] for name in some})
                if not alone.feasible:
                    return TargetsError(self._told(some, alone), some)
        return TargetsError(self._told(nearest.missed, nearest), nearest.missed)

    def _told(self, names: Sequence[str], nearest: Nearest) -> str:
        asked = [f"{name} {', '.join(self.targets[name])}" for name in names]
        near = ", ".join(f"{name} = {nearest.shown[name]}" for name in names)
        at = f", with {', '.join(nearest.at)}" if nearest.at else ""
        if len(names) == 1:
            return f"no sizes within their bounds are found that give {asked[0]}: the nearest is {near}{at}."
        what = "two targets fight each other" if len(names) == 2 else "these targets cannot be met together"
        return f"{what}: {' and '.join(asked)}. The nearest is {near}{at}. Give up one, or free another size."

    def _sized(self, values: Mapping[str, float], state: Any, way: str) -> Sized:
        names = list(dict.fromkeys([*self.plant.outputs, *self.targets]))
        units = {name: _unit(self.plant, name) for name in names}
        try:
            start = self.plant.equilibrium(self.starts)
            before = {name: _number(start, name) for name in names}
        except SimulationError:  # it need not float to begin with
            before = dict.fromkeys(names, float("nan"))
        results = {name: _number(state, name) for name in names}
        told = {name: ", ".join(text.removeprefix("=").strip() for text in texts)
                for name, texts in self.targets.items()}  # fmt: skip
        return Sized(self.plant.title, dict(values), self.starts, self.bounds, self.size_units, results, before, units,
                     told, way, state)  # fmt: skip


def _texts(name: str, given: Any) -> list[str]:
    """A target as texts that begin with =, < or >."""
    items = list(given) if isinstance(given, (list, tuple)) else [given]
    texts = [f"= {item}" if not str(item).strip().startswith(("<", ">", "=")) else str(item).strip() for item in items]
    if not texts or (len(texts) > 1 and any(text[0] == "=" for text in texts)):
        raise ModelError(f"the target '{name}' is one value, or bounds such as ['> 20 s', '< 35 s'], not {given!r}.")
    return texts


def _variable(path: str, given: Any) -> Variable:
    if not isinstance(given, (list, tuple)) or len(given) not in (2, 3):
        raise ModelError(f"the free parameter '{path}' has bounds, (lower, upper) or (lower, upper, first guess), not "
                         f"{given!r}.")  # fmt: skip
    return Variable(path, *given)


def _element(parameters: Mapping[str, Any], path: str) -> float:
    bare, _, index = path.partition("[")
    value = np.ravel(np.asarray(parameters[bare], dtype=float))
    return float(value[int(index.rstrip("]"))] if index else value[0])


def _unit(plant: Any, name: str) -> str:
    return plant.outputs[name].unit if name in plant.outputs else plant.describe(name)[0]


def _number(state: Any, name: str) -> float:
    return float(np.ravel(np.asarray(state[name], dtype=float))[0])
