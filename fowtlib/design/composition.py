"""Objective and constraints as one CasADi function of the variables of a design and of the results of its model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.design.evaluation import Evaluated, Key
from fowtlib.design.terms import Constraint, Function, Objective, kreisselmeier_steinhauser
from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.units import from_si, si_unit, to_si

WEIGHTED = "weighted "
AT = " @ "


def over_cases(name: str) -> str:
    """A result as its mean over the cases, unless it says itself of which case it is."""
    return name if AT in name or name.startswith(WEIGHTED) else WEIGHTED + name


@dataclass(frozen=True)
class Asked:
    """Names of a design, before anything is computed: what is asked of the model in each case.

    cases: weights by name, scaled to the sum 1.
    """

    variables: tuple[str, ...]
    functions: Mapping[str, Function]
    weights: Mapping[str, float]

    def split(self, name: str, case: str) -> tuple[str, list[str]]:
        """A name without its case, and the cases that it is about: more than one for a mean over them."""
        if name.startswith(WEIGHTED):
            return name.removeprefix(WEIGHTED), [c for c, weight in self.weights.items() if weight > 0]
        bare, at, other = name.rpartition(AT)
        if not at:
            return name, [case]
        if other not in self.weights:
            raise ModelError(f"'{name}': there is no case '{other}'{did_you_mean(other, self.weights)}")
        return bare, [other]

    def leaves(self, name: str, case: str, way: tuple[str, ...] = ()) -> Iterator[Key]:
        """The results of the model that a result needs."""
        bare, cases = self.split(name, case)
        if bare in way:
            raise ModelError(f"the function '{bare}' depends on itself: {' of '.join([*way, bare])}.")
        for own in cases:
            if bare in self.functions:
                for inner in self.functions[bare].of:
                    yield from self.leaves(inner, own, (*way, bare))
            elif bare not in self.variables:
                yield own, bare


def keys_of(asked: Asked, objective: Objective, constraints: Sequence[Constraint]) -> list[Key]:
    """What a design asks of its model. Raises ModelError for a case that is unknown and a function that is not used."""
    found: dict[Key, None] = {}
    first = next(iter(asked.weights))
    for name in objective.terms:
        found |= dict.fromkeys(asked.leaves(over_cases(name), first))
    for constraint in constraints:
        for case in cases_of(asked, constraint):
            found |= dict.fromkeys(asked.leaves(constraint.result, case))
    return list(found)


def cases_of(asked: Asked, constraint: Constraint) -> list[str]:
    """The cases in which a constraint counts; one where its result names its own."""
    for name in constraint.cases or ():
        if name not in asked.weights:
            raise ModelError(
                f"the constraint on '{constraint.result}' is never evaluated: there is no case '{name}'"
                f"{did_you_mean(name, asked.weights)}"
            )
    cases = list(asked.weights) if constraint.cases is None else list(constraint.cases)
    if not cases:
        raise ModelError(f"the constraint on '{constraint.result}' is never evaluated: its list of cases is empty.")
    result = constraint.result
    # of the same results in all cases, as the function of a weighted mean, or of none
    alone = result.startswith(WEIGHTED) or AT in result or len({frozenset(asked.leaves(result, c)) for c in cases}) == 1
    return cases[:1] if alone else cases


@dataclass(frozen=True)
class Row:
    """A number that a constraint limits: what it is called, its unit, its limits and its scale in this unit."""

    constraint: int
    name: str
    unit: str
    lower: float
    upper: float
    scale: float


class Composition:
    """Objective and constraints at a point, from its variables and the results there.

    rows: each number that is limited; bounds: (lower, upper) of the scaled constraints, as an optimiser has them.
    """

    def __init__(self, space: Space, asked: Asked, objective: Objective, constraints: Sequence[Constraint],
                 first: Evaluated):  # fmt: skip
        self.space, self.asked, self.first = space, asked, first
        self.keys = list(first.values)
        self.v = ca.MX.sym("v", len(space))
        ends = np.cumsum([0, *(first.values[key].size for key in self.keys)]).tolist()
        results = self.free = ca.MX.sym("r", ends[-1])
        self.r = ca.vertsplit(results, ends) if self.keys else []
        self._known: dict[Key, Any] = {}
        self.objective = objective
        self.rows: list[Row] = []
        self.labels: list[str] = []
        self.owners: list[list[int]] = []  # the rows of each scaled constraint
        limits: list[tuple[float, float]] = []
        scaled, values = [], []
        for number, constraint in enumerate(constraints):
            self._add(number, constraint, scaled, values, limits)
        self.lower, self.upper = np.array(limits, dtype=float).reshape(-1, 2).T
        case = next(iter(asked.weights))
        terms = [factor * self._scalar(over_cases(name), case)
                 for name, factor in objective.terms.items()]  # fmt: skip
        joined = [sum(terms), ca.vertcat(*scaled) if scaled else ca.MX(0, 1)]
        self.function = ca.Function("design", [self.v, results], joined, ["v", "r"], ["f", "g"])
        self.values = ca.Function("rows", [self.v, results], [ca.vertcat(*values) if values else ca.MX(0, 1)])
        slopes = [ca.jacobian(out, by) for out in joined for by in (self.v, results)]
        self.slopes = ca.Function("slopes", [self.v, results], slopes)

    # -- expressions ---------------------------------------------------------------------------------------------------

    def expression(self, name: str, case: str) -> Any:
        """A result in a case, as an expression of the variables and of the results of the model."""
        bare, cases = self.asked.split(name, case)
        if len(cases) > 1:
            weights = self.asked.weights
            return sum(weights[own] * self.expression(bare, own) for own in cases)
        return self._in_case(bare, cases[0])

    def _in_case(self, name: str, case: str) -> Any:
        if (case, name) in self._known:
            return self._known[case, name]
        if name in self.space.names:
            found = self.v[self.space[name].place]
        elif name in self.asked.functions:
            found = self._called(self.asked.functions[name], case)
        else:
            found = self.r[self.keys.index((case, name))]
        self._known[case, name] = found
        return found

    def _called(self, function: Function, case: str) -> Any:
        values = _Arguments(function, {name: self._in_si(name, case) if function.si else self.expression(name, case)
                                       for name in function.of})  # fmt: skip
        try:
            found = function.function(values)
            return ca.vec(ca.MX(found)) if not isinstance(found, (list, tuple)) else ca.vertcat(*found)
        except ModelError:
            raise
        except Exception as error:
            raise ModelError(
                f"the function '{function.name}' fails with CasADi expressions: {str(error).splitlines()[0]} Take "
                "arithmetic and functions of casadi, such as casadi.if_else in place of `if`."
            ) from error

    def _in_si(self, name: str, case: str) -> Any:
        unit = self.unit(name)
        si = si_unit(unit)
        return self.expression(name, case) * (1.0 if unit == si else float(to_si(f"1 {unit}", si, name)))

    def _scalar(self, name: str, case: str) -> Any:
        found = self.expression(name, case)
        if found.numel() != 1:
            bare = name.removeprefix(WEIGHTED)
            raise ModelError(f"the objective has {found.numel()} numbers of '{bare}'; take one, or a function of them.")
        return found

    def unit(self, name: str) -> str:
        """Unit of a result."""
        bare = self.asked.split(name, next(iter(self.asked.weights)))[0]
        if bare in self.space.names:
            return self.space[bare].unit
        if bare in self.asked.functions:
            return self.asked.functions[bare].unit
        return self.first.units.get(bare, "1")

    def _add(self, number: int, constraint: Constraint, scaled: list, values: list, limits: list) -> None:
        unit = self.unit(constraint.result)
        lower, upper = (_bound(value, unit, constraint, default)
                        for value, default in ((constraint.lower, -np.inf), (constraint.upper, np.inf)))  # fmt: skip
        if lower > upper:
            raise ModelError(f"the limits of '{constraint.result}', {lower:g} and {upper:g}, are the wrong way round.")
        sizes = [abs(item) for item in (lower, upper) if np.isfinite(item) and item]
        scale = constraint.scale or (max(sizes) if sizes else 1.0)
        pieces, owned = [], []
        cases = cases_of(self.asked, constraint)
        for case in cases:
            found = self.expression(constraint.result, case)
            shown = f"{constraint.label} ({case})" if len(cases) > 1 else constraint.label
            for k in range(found.numel()):
                owned.append(len(self.rows))
                at = f"{shown}[{k}]" if found.numel() > 1 else shown
                self.rows.append(Row(number, at, unit, lower, upper, scale))
            pieces.append(found)
        column = ca.vertcat(*pieces)
        values.append(column)
        if constraint.aggregate == "each":
            scaled.append(column / scale)
            limits += [(lower / scale, upper / scale)] * len(owned)
            self.labels += [self.rows[k].name for k in owned]
            self.owners += [[k] for k in owned]
            return
        over = [(column - upper) / scale] if np.isfinite(upper) else []
        over += [(lower - column) / scale] if np.isfinite(lower) else []
        scaled.append(kreisselmeier_steinhauser(ca.vertcat(*over), constraint.sharpness))
        limits.append((-np.inf, 0.0))
        self.labels.append(f"{constraint.label}, all")
        self.owners.append(owned)

    # -- numbers -------------------------------------------------------------------------------------------------------

    def results(self, found: Evaluated) -> np.ndarray:
        """The results of the model as one column."""
        for key in self.keys:
            if found.values[key].size != self.first.values[key].size:
                raise ModelError(f"'{key[1]}' has {found.values[key].size} numbers here, and had others before.")
        return np.concatenate([found.values[key] for key in self.keys]) if self.keys else np.zeros(0)

    def at(self, x: np.ndarray, found: Evaluated) -> tuple[float, np.ndarray, np.ndarray]:
        """Objective, scaled constraints (k,), and the limited numbers in their units (rows,)."""
        r = self.results(found)
        f, g = self.function(x, r)
        return float(f), np.array(g).ravel(), np.array(self.values(x, r)).ravel()

    def computed(self, x: np.ndarray, found: Evaluated) -> dict[Key, np.ndarray]:
        """Values of the functions of the design that were needed, by case and name."""
        known = {key: item for key, item in self._known.items() if key[1] in self.asked.functions}
        if not known:
            return {}
        function = ca.Function("functions", [self.v, self.free], list(known.values()))
        values = function.call([ca.DM(x), ca.DM(self.results(found))])
        return {key: np.array(value).ravel() for key, value in zip(known, values, strict=True)}

    def slopes_at(self, x: np.ndarray, found: Evaluated) -> tuple[np.ndarray, np.ndarray]:
        """Slopes (n,) of the objective and (k, n) of the scaled constraints, by the variables in SI."""
        assert found.jacobian is not None
        fv, fr, gv, gr = (np.array(ca.DM(item).full()) for item in self.slopes(x, self.results(found)))
        n = len(self.space)
        by = np.concatenate([np.zeros((0, n)), *(found.jacobian[key].reshape(-1, n) for key in self.keys)])
        k = self.lower.size
        return (fv + fr @ by).ravel(), gv.reshape(k, n) + gr.reshape(k, len(by)) @ by

    def violations(self, values: np.ndarray) -> np.ndarray:
        """How far each limited number is outside of its limits, over its scale; negative: how far it is inside."""
        return np.array([
            max(value - row.upper, row.lower - value) / row.scale for row, value in zip(self.rows, values, strict=True)
        ])  # fmt: skip


class _Arguments(Mapping[str, Any]):
    """What a function is given; an unknown name is an error that says what to do."""

    def __init__(self, function: Function, values: Mapping[str, Any]):
        self._function, self._values = function, values

    def __getitem__(self, name: str) -> Any:
        if name not in self._values:
            raise ModelError(
                f"the function '{self._function.name}' takes '{name}', which is not in its list `of`"
                f"{did_you_mean(name, self._values)}"
            )
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


def _bound(value: Any, unit: str, constraint: Constraint, default: float) -> float:
    if value is None:
        return default
    try:
        return float(value)
    except (TypeError, ValueError):
        si = si_unit(unit)
        return float(from_si(to_si(value, si, f"the limit of '{constraint.result}'"), si, unit))
