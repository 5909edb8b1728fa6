"""A design: a model with variables, an objective, constraints and cases; and its optimisation."""

from __future__ import annotations

import hashlib
import os
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from fowtlib.analysis.plants import plant_of
from fowtlib.design.adjoints import Adjoints
from fowtlib.design.composition import Asked, keys_of
from fowtlib.design.conflict import least_violation
from fowtlib.design.differences import Differences
from fowtlib.design.evaluation import Evaluator, Key, NoModel
from fowtlib.design.journal import Earlier, Journal
from fowtlib.design.measures import Statistics
from fowtlib.design.multipliers import ACTIVE, multipliers
from fowtlib.design.optimisers import Settings, optimiser
from fowtlib.design.outcome import Limited, Member, Optimum, Search, Size
from fowtlib.design.problem import Point, Problem
from fowtlib.design.progress import Log, Say
from fowtlib.design.several import evaluator_of
from fowtlib.design.starts import starts as starts_of
from fowtlib.design.terms import ALONE, Constraint, DesignCase, Function, Objective
from fowtlib.design.variables import Space, Variable
from fowtlib.language.errors import ModelError, did_you_mean, one_of

SLOPES = ("differences", "adjoint")
HALVINGS = 4  # of the way to the first start, for a random one that has no results


@dataclass(frozen=True, eq=False)
class Design:
    """What is to be found: variables that make the objective least, while the constraints hold.

    model        a model or a compiled one; None: all results are functions of the variables
    variables    see Variable
    objective    an Objective; results with factors; or the name of one result
    constraints  each a Constraint, or a text such as "pitch < 5 deg"
    cases        conditions with weights: DesignCase, or fw.Case; none: the model as it is
    functions    results that follow from others
    free, targets  parameters that take the values at which conditions hold at each design, such as ballast and heave:
                 see Plant.equilibrium
    balance      the case in which they are freed: the others take what is found there. None: each case on its own
    statistics   of the response to waves and wind
    slopes       "differences", central ones; or "adjoint": exact, of outputs and responses, which cost the same for
                 many variables, and by differences of the rest (fowtlib.design.adjoints)
    evaluator    makes another source of results and slopes, from (plant, space, cases, keys) and free, targets,
                 statistics as keywords; see fowtlib.design.evaluation
    processes    that evaluate cases at once, as many as there are cores, say; copies of this one, where the system has
                 these (not Windows)
    Raises ModelError for what does not fit, such as a constraint on a result that there is not.
    """

    model: Any
    variables: Sequence[Variable]
    objective: Objective | Mapping[str, float] | str
    constraints: Sequence[Constraint | str] = ()
    cases: Sequence[DesignCase] = (ALONE,)
    functions: Sequence[Function] = ()
    free: Mapping[str, Any] | Sequence[str] = ()
    targets: Mapping[str, Any] = field(default_factory=dict)
    balance: str | None = None
    statistics: Statistics = field(default_factory=Statistics)
    slopes: Literal["differences", "adjoint"] = "differences"
    evaluator: Callable[..., Evaluator] | None = None
    title: str = ""
    processes: int = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "objective", Objective.read(self.objective))
        object.__setattr__(self, "constraints", tuple(map(Constraint.read, self.constraints)))
        object.__setattr__(self, "cases", tuple(self.cases) or (ALONE,))
        if self.slopes not in SLOPES:
            raise ModelError(f"slopes are by {one_of(SLOPES)}, not by '{self.slopes}'.")
        if isinstance(self.processes, bool) or not isinstance(self.processes, int) or self.processes < 1:
            raise ModelError(f"processes is a whole number, 1 or more, not {self.processes!r}.")
        if not self.objective.terms:  # type: ignore[union-attr]
            raise ModelError("the objective has no results.")
        for what, items in (("case", self.cases), ("function", self.functions)):
            names = [item.name for item in items]
            twice = next((name for name in names if names.count(name) > 1), None)
            if twice is not None:
                raise ModelError(f"there are two {what}s '{twice}'.")
        if self.balance is not None:
            names = [case.name for case in self.cases]
            if self.balance not in names:
                raise ModelError(f"the balance is of no case '{self.balance}'{did_you_mean(self.balance, names)}")
            if not self.free:
                raise ModelError(f"the balance in the case '{self.balance}' needs parameters that are free.")
        if wrong := [item for item in self.variables if not isinstance(item, Variable)]:
            raise ModelError(f"a variable is given as Variable(name, lower, upper), not as {wrong[0]!r}.")
        clash = {item.name for item in self.functions} & {item.name for item in self.variables}
        if clash:
            raise ModelError(f"'{min(clash)}' is a variable and a function.")

    @cached_property
    def plant(self) -> Any:
        """The compiled model; None where there is none."""
        return None if self.model is None else plant_of(self.model)

    @cached_property
    def space(self) -> Space:
        """The variables as one vector."""
        return Space.of(self.variables, self.plant)

    @cached_property
    def asked(self) -> Asked:
        """The names of the design, and the weights of the cases with the sum 1."""
        total = sum(case.weight for case in self.cases)
        if not total > 0 or any(case.weight < 0 for case in self.cases):
            raise ModelError("the weights of the cases are zero or more, and one is above zero.")
        weights = {case.name: case.weight / total for case in self.cases}
        return Asked(tuple(self.space.names), {item.name: item for item in self.functions}, weights)

    @cached_property
    def keys(self) -> list[Key]:
        """What is asked of the model."""
        keys = keys_of(self.asked, self.objective, self.constraints)  # type: ignore[arg-type]
        if keys and self.plant is None:
            known = [*self.asked.functions, *self.space.names]
            name = keys[0][1]
            raise ModelError(f"there is no result '{name}', and no model that could have it{did_you_mean(name, known)}")
        used = _used(self)
        for function in self.functions:
            if function.name not in used:
                raise ModelError(f"nothing uses the function '{function.name}'.")
        for case in self.cases:
            asked = {own for own, _ in keys} | {self.balance}
            if self.plant is not None and len(self.cases) > 1 and case.name not in asked:
                raise ModelError(f"nothing is asked of the case '{case.name}'.")
        return keys

    @cached_property
    def results(self) -> Evaluator:
        """What gives the results and their slopes."""
        if self.plant is None:
            _ = self.keys
            return NoModel()
        make = self.evaluator or (Adjoints if self.slopes == "adjoint" else Differences)
        return evaluator_of(make, self.plant, self.space, self.cases, self.keys, free=self.free, targets=self.targets,
                            statistics=self.statistics, balance=self.balance, processes=self.processes)  # fmt: skip

    def problem(self, x: np.ndarray | None = None) -> Problem:
        """The design as a problem of optimisation, set up at x [SI], or at the start."""
        objective, constraints = self.objective, self.constraints
        return Problem(self.space, self.asked, self.results, objective, constraints,  # type: ignore[arg-type]
                       self.space.start if x is None else x)  # fmt: skip

    def evaluate(self, values: Mapping[str, Any] | None = None) -> Optimum:
        """The design with these values of variables, as it is, and the others as at the start."""
        x = self.space.vector(values or {})
        problem = self.problem(x)
        y = problem.y(x)
        point = problem.point(y)
        search = Search(0, x, x, point.objective, point.violation, False, "as given", 1, 0)
        return _Result(self, problem).outcome(point, point, [search], [], time.perf_counter(), prices=False)

    def optimise(
        self,
        method: str = "ipopt",
        *,
        starts: int = 1,
        seed: int = 0,
        tolerance: float = 1e-6,
        iterations: int = 200,
        journal: str | os.PathLike[str] | None = None,
        resume: bool = False,
        say: Say | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> Optimum:
        """The best design.

        method      "ipopt", "slsqp", "trust-constr" or "successive"
        starts      how many searches there are: the first begins at the start of the variables, the others at random
                    places (Latin hypercube, by `seed`); the best feasible design counts
        tolerance   of optimality and of the constraints, of their scales; iterations: of one search, at most
        journal     a file of JSON lines in which each evaluated design is kept; with `resume`, what it holds is gone on
                    from: searches that have ended are not repeated, the one that was cut off begins at its best design
        say         is told each line of a log
        options     further ones of the optimiser
        """
        return _Optimisation(self, method, Settings(tolerance, iterations, options or {}), starts, seed, say).run(
            journal, resume
        )

    def about(self) -> dict[str, Any]:
        """What identifies the problem, for its journal."""
        objective: Objective = self.objective  # type: ignore[assignment]
        return {
            "model": getattr(self.plant, "name", ""),
            "variables": [[name, lower, upper] for name, lower, upper in
                          zip(self.space.elements, self.space.lower, self.space.upper, strict=True)],
            "objective": dict(objective.terms),
            "constraints": [[c.result, c.lower, c.upper, c.cases and list(c.cases), c.aggregate, c.sharpness]
                            for c in self.constraints],  # type: ignore[union-attr]
            "cases": [[case.name, dict(case.parameters), case.weight, *_other(case)] for case in self.cases],
            "functions": [[item.name, list(item.of), _text(item.function)] for item in self.functions],
            "free": list(self.free), "targets": dict(self.targets), "balance": self.balance,
            "statistics": str(self.statistics), "parameters": _digest(self.plant),
        }  # fmt: skip


def _other(case: Any) -> list[str]:
    """The model of a case that has another one."""
    return [plant_of(case.model).name] if getattr(case, "model", None) and isinstance(case, DesignCase) else []


def _text(function: Any) -> str:
    """What tells one function from another: its formula, or its code."""
    code = getattr(function, "__code__", None)
    if hasattr(function, "text") or code is None:
        return str(getattr(function, "text", ""))
    numbers = [item for item in code.co_consts if isinstance(item, (int, float, str))]
    return f"{code.co_code.hex()} {numbers}"


def _digest(plant: Any) -> str:
    """Of the numbers of a model."""
    return "" if plant is None else hashlib.blake2b(plant.binding().p.tobytes(), digest_size=8).hexdigest()


def _used(design: Design) -> set[str]:
    """Names of functions that something needs."""
    asked, found = design.asked, set[str]()
    case = design.cases[0].name
    names = [*design.objective.terms, *(c.result for c in design.constraints)]  # type: ignore[union-attr]
    while names:
        bare = asked.split(names.pop(), case)[0]
        if bare in asked.functions and bare not in found:
            found.add(bare)
            names += asked.functions[bare].of
    return found


class _Optimisation:
    """The searches of one call of `optimise`."""

    def __init__(self, design: Design, method: str, settings: Settings, count: int, seed: int, say: Say | None):
        self.design, self.method, self.settings, self.say = design, method, settings, say or (lambda line: None)
        self.solve, self.began = optimiser(method), time.perf_counter()
        self.begins = starts_of(design.space, count, seed)
        self.about = design.about() | {"starts": count, "seed": seed if count > 1 else 0}
        self.history: list[tuple[float, float]] = []
        self.start: Point | None = None
        self.best: tuple[Point, Problem] | None = None

    def run(self, path: str | os.PathLike[str] | None, resume: bool) -> Optimum:
        if path is None:
            return self._run(None, Earlier())
        journal = Journal(path, self.about)
        try:
            return self._run(journal, journal.begin(resume))
        finally:
            journal.close()

    def _run(self, journal: Journal | None, earlier: Earlier) -> Optimum:
        searches, failures = [], []
        for number, begin in enumerate(self.begins):
            if len(self.begins) > 1:
                self.say(f"start {number + 1} of {len(self.begins)}")
            try:
                searches.append(self._search(number, begin, journal, earlier))
            except ModelError as error:
                failures.append(str(error))
                if len(self.begins) == 1:
                    raise
                self.say(f"this start has no results: {error}")
                searches.append(Search(number, begin, begin, np.nan, np.inf, False, f"no results: {error}", 1, 0))
        if self.best is None:
            raise ModelError(f"no start has results; the first one: {failures[0]}")
        point, problem = self.best
        conflict: list[str] = []
        if not point.feasible and problem.lower.size:
            point, conflict = self._conflict(point, problem)
        return _Result(self.design, problem).outcome(self.start or point, point, searches, self.history, self.began,
                                                     conflict, method=self.method)  # fmt: skip

    def _search(self, number: int, begin: np.ndarray, journal: Journal | None, earlier: Earlier) -> Search:
        kept = earlier.best(number)
        x, problem = (kept.x, self.design.problem(kept.x)) if kept is not None else self._begun(number, begin)
        first = problem.point(problem.y(begin)) if number == 0 else None
        if first is not None and not first.failure:
            self.start = first
        log = Log(problem, self.say) if number not in earlier.ended else None
        if log is not None:
            problem.watchers.append(log.watch)
        if journal is not None and number not in earlier.ended:
            problem.watchers.append(lambda point, iterate: journal.design(number, point, iterate))
            journal.design(number, problem.point(problem.y(x)))
        problem.watchers.append(self._remember)
        if number in earlier.ended:
            converged, reason = earlier.ended[number]
            point = problem.point(problem.y(x))
            self._best(point, problem)
            return Search(number, begin, point.x, point.objective, point.violation, converged, reason, 0, 0)
        ended = self.solve(problem, problem.y(x), self.settings)
        problem.watchers.clear()  # what follows is no part of the search
        point = problem.point(ended.y)
        if problem.best is not None and (not ended.converged or not point.feasible) and problem.best.better_than(point):
            point = problem.best
        self._best(point, problem)
        if journal is not None:
            journal.end(number, ended.converged, ended.reason)
        self.say(f"{ended.reason}, after {problem.evaluations} evaluations and {problem.gradients} gradients.")
        return Search(number, x, point.x, point.objective, point.violation, ended.converged, ended.reason,
                      problem.evaluations, problem.gradients)  # fmt: skip

    def _begun(self, number: int, begin: np.ndarray) -> tuple[np.ndarray, Problem]:
        """Where a search begins: a random start without results comes nearer to the first one, by half the way."""
        x, home = begin, self.begins[0]
        for _ in range(HALVINGS if number else 0):
            try:
                return x, self.design.problem(x)
            except ModelError as error:
                self.say(f"no results at this start, which comes nearer to the first one: {error}")
                x = (x + home) / 2
        return x, self.design.problem(x)

    def _remember(self, point: Point, iterate: bool) -> None:
        if iterate:
            self.history.append((point.objective, max(point.violation, 0.0)))

    def _best(self, point: Point, problem: Problem) -> None:
        if point.better_than(self.best[0] if self.best is not None else None):
            self.best = point, problem

    def _conflict(self, point: Point, problem: Problem) -> tuple[Point, list[str]]:
        """The design that comes nearest to its constraints, and those that are in the way."""
        self.say("no design that keeps all constraints was found; the least violation is sought.")
        try:
            y, held = least_violation(problem, problem.y(point.x), replace(self.settings, options={}), "slsqp")
        except ModelError:
            return point, []
        nearest = problem.point(y)
        composition = problem.composition
        names = []
        for k in held:
            rows = composition.owners[k]
            violations = composition.violations(nearest.values)[rows]
            names.append(composition.rows[rows[int(np.argmax(violations))]].name)
        return (nearest if nearest.better_than(point) else point), names


class _Result:
    """Makes an Optimum of points of a problem."""

    def __init__(self, design: Design, problem: Problem):
        self.design, self.problem = design, problem

    def outcome(
        self, start: Point, point: Point, searches: list[Search], history: list[tuple[float, float]], began: float,
        conflict: Sequence[str] = (), prices: bool = True, method: str = "",
    ) -> Optimum:  # fmt: skip
        design, problem = self.design, self.problem
        y = problem.y(point.x)
        costs = self._prices(y) if prices else None
        ended = next((s for s in searches if np.allclose(problem.y(s.x), y, rtol=0.0, atol=1e-12)), None)
        found = problem.results_at(point)
        parameters = {**design.space.parameters(point.x), **self._freed(found)}
        results: dict[str, dict[str, Any]] = {case.name: {} for case in design.cases}
        for (case, name), value in found.values.items():
            results[case][name] = float(value[0]) if value.size == 1 else np.array(value)
        self._functions(results, point, found)
        return Optimum(
            design.title or getattr(design.plant, "title", "") or "a design", str(design.objective), start.objective,
            point.objective, point.feasible, bool(ended and ended.converged),
            ended.reason if ended else "the nearest to its constraints", self._sizes(start, point, y, costs),
            self._limited(start, point, costs), parameters, results, tuple(searches), self._members(start, point),
            tuple(history), tuple(conflict), np.nan if costs is None else costs.rest, time.perf_counter() - began,
            {"method": method} if method else {}, self._unit(),
        )  # fmt: skip

    def _unit(self) -> str:
        """Of the objective."""
        objective: Objective = self.design.objective  # type: ignore[assignment]
        units = {self.problem.composition.unit(name) for name in objective.terms}
        return units.pop() if len(units) == 1 else "1"

    def _prices(self, y: np.ndarray) -> Any:
        try:
            return multipliers(self.problem, y)
        except ModelError as error:
            warnings.warn(f"what the limits are worth is not told: {error}", stacklevel=3)
            return None

    def _freed(self, found: Any) -> dict[str, Any]:
        """Values of freed parameters in the case of the balance, or in the first one."""
        states, design = found.states, self.design
        if not states or not design.free:
            return {}
        state = states[design.balance or next(iter(states))]
        return {path: state.parameters[path] for path in (item.partition("[")[0] for item in design.free)}

    def _functions(self, results: dict[str, dict[str, Any]], point: Point, found: Any) -> None:
        composition = self.problem.composition
        for (case, name), value in composition.computed(point.x, found).items():
            results[case][name] = float(value[0]) if value.size == 1 else value

    def _sizes(self, start: Point, point: Point, y: np.ndarray, costs: Any) -> tuple[Size, ...]:
        problem, space = self.problem, self.design.space
        found = []
        for k, (name, unit) in enumerate(zip(space.elements, space.units, strict=True)):
            near = {"lower": abs(y[k] - problem.y_lower[k]), "upper": abs(problem.y_upper[k] - y[k])}
            side = min(near, key=near.__getitem__)
            active = side if near[side] <= ACTIVE else ""
            price = costs.variables[k] * problem.f_scale / problem.scale[k] if costs is not None else 0.0
            found.append(Size(name, unit, float(start.x[k]), float(point.x[k]), float(space.lower[k]),
                              float(space.upper[k]), active, float(price)))  # fmt: skip
        return tuple(found)

    def _limited(self, start: Point, point: Point, costs: Any) -> tuple[Limited, ...]:
        composition, found = self.problem.composition, []
        violations = composition.violations(point.values)
        of = {row: k for k, rows in enumerate(composition.owners) for row in rows}
        for k, row in enumerate(composition.rows):
            before = start.values[k] if start.values.size else np.nan
            value, over = float(point.values[k]), float(violations[k])
            price = costs.constraints[of[k]] * self.problem.f_scale / row.scale if costs is not None else 0.0
            together = composition.owners[of[k]]
            ahead = len(together) > 1 and price > 0 and over == violations[together].max()  # KS keeps a distance
            near = over >= -ACTIVE or (ahead and over >= -0.1)
            side = "upper" if value - row.upper >= row.lower - value else "lower"
            found.append(Limited(row.name, row.unit, float(before), value, row.lower, row.upper, 1 + over,
                                 side if near else "", over > 1e-5, float(price) if near else 0.0))  # fmt: skip
        return tuple(found)

    def _members(self, start: Point, point: Point) -> tuple[Member, ...]:
        space, plant = self.design.space, self.design.plant
        before, after = space.parameters(start.x), space.parameters(point.x)
        found = []
        for path in (path for path in space.base if np.size(before[path]) > 1):
            along = next(item.variable.along for item in space.placed if path in item.matrices)
            stations, name = np.arange(np.size(before[path])), "element"
            if isinstance(along, str) and along:
                stations, name = (
                    plant.parameter_values()[along].ravel(),
                    f"{along} [{plant.dae.parameters[along].unit}]",
                )
            elif len(along):
                stations, name = np.asarray(along, dtype=float), "station"
            unit = plant.dae.parameters[path].unit
            found.append(Member(path, unit, np.ravel(before[path]), np.ravel(after[path]), stations, name))
        return tuple(found)
