"""Pareto fronts: designs of which none is better in one of two results without being worse in the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fowtlib.design.composition import over_cases
from fowtlib.design.design import Design
from fowtlib.design.outcome import Optimum
from fowtlib.design.progress import Say
from fowtlib.design.terms import Constraint, Objective
from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Front:
    """Optima along a front, with the values of both results; efficient: whether no other one is better in both.

    units: of both results; "1" of an objective of several units.
    """

    title: str
    names: tuple[str, str]
    first: tuple[float, ...]
    second: tuple[float, ...]
    efficient: tuple[bool, ...]
    optima: tuple[Optimum, ...]
    units: tuple[str, str] = ("1", "1")

    def rows(self) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
        """Heads and rows: both results, then the variables."""
        sizes = self.optima[0].variables
        heads = (*self.names, *(f"{size.name} [{size.unit}]" for size in sizes), "feasible", "efficient")
        return heads, [
            (a, b, *(size.value for size in optimum.variables), optimum.feasible, good)
            for a, b, optimum, good in zip(self.first, self.second, self.optima, self.efficient, strict=True)
        ]

    def save(self, path: str | Path) -> Path:
        """Write the rows as .csv."""
        import csv
        import io

        path = Path(path)
        if path.suffix != ".csv":
            raise ModelError(f"{path}: a front is saved as .csv, not as '{path.suffix or 'no ending'}'.")
        heads, rows = self.rows()
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([heads, *rows])
        return write_text(path, text.getvalue())

    def plot(self, path: str | Path | None = None) -> Figure:
        """Both results against each other."""
        from fowtlib.design.pictures import plot_front

        return plot_front(self, path)

    def __repr__(self) -> str:
        lines = [f"<Front of {self.title}>", f"{self.names[0]:>24}{self.names[1]:>24}"]
        lines += [f"{a:>24.6g}{b:>24.6g}{'' if good else '  (no)'}"
                  for a, b, good in zip(self.first, self.second, self.efficient, strict=True)]  # fmt: skip
        return "\n".join(lines)


def pareto(
    design: Design,
    second: str,
    points: int | Sequence[float] = 7,
    *,
    by: Literal["limit", "weights"] = "limit",
    method: str = "ipopt",
    say: Say | None = None,
    **options: Any,
) -> Front:
    """The front between the objective of a design and a second result, which shall be small, too.

    by "limit"    the objective is made least with second <= epsilon, for values between those of the two optima (the
                  epsilon-constraint method, Haimes, Lasdon and Wismer 1971), which finds all of a front, also where it
                  is not convex
    by "weights"  w objective + (1 - w) second is made least, of both over their ranges
    points        how many, with both ends, or the values of epsilon or w
    options       of Design.optimise. Each point starts from the optimum of the one before.
    Results of several cases count with their weights.
    """
    if by not in ("limit", "weights"):
        raise ModelError(f"a front is found by 'limit' or by 'weights', not by '{by}'.")
    if isinstance(points, int) and points < 2:
        raise ModelError(f"a front has 2 points, or more; not {points}.")
    tell = say or (lambda line: None)
    objective: Objective = design.objective  # type: ignore[assignment]
    result = over_cases(second)
    watched = _Watched(design, result)
    tell(f"least {objective}")
    one = watched.optimum(objective, [], None, method, say, options)
    tell(f"least {second}")
    two = watched.optimum(Objective({second: 1.0}), [], one, method, say, options)
    for which, end in ((str(objective), one), (second, two)):
        if not end.feasible:
            raise ModelError(f"the design of least {which} keeps not all constraints: {end.sentence}")
    ends = np.array([watched.values(one), watched.values(two)])
    if not ends[0, 1] > ends[1, 1]:
        raise ModelError(f"the design of least {objective} has the least {second}, too: there is no front.")
    count = points if isinstance(points, int) else len(points)
    shares = np.linspace(0.0, 1.0, count)[1:-1] if isinstance(points, int) else np.asarray(points, dtype=float)
    found, last = [one], one
    for share in shares.tolist():
        if by == "limit":
            limit = ends[0, 1] + share * (ends[1, 1] - ends[0, 1]) if isinstance(points, int) else share
            tell(f"least {objective} with {second} < {limit:.6g}")
            scale = abs(ends[0, 1] - ends[1, 1])
            last = watched.optimum(
                objective, [Constraint(result, upper=limit, scale=scale)], last, method, say, options
            )
        else:
            weight = 1.0 - share if isinstance(points, int) else share
            tell(f"{weight:.3g} of {objective}, {1 - weight:.3g} of {second}")
            span = np.maximum(np.abs(ends[0] - ends[1]), 1e-300)
            terms = {name: factor * weight / span[0] for name, factor in objective.terms.items()}
            terms[second] = terms.get(second, 0.0) + (1.0 - weight) / span[1]
            last = watched.optimum(Objective(terms, scale=1.0), [], last, method, say, options)
        found.append(last)
    found.append(two)
    return _front(design, (str(objective), second), found, watched)


class _Watched:
    """A design under other objectives, with both results of a front computed at every point."""

    def __init__(self, design: Design, result: str):
        self.design, self.result = design, result
        self.objective: Objective = design.objective  # type: ignore[assignment]
        for name in (*self.objective.terms, result):
            bare = design.asked.split(name, design.cases[0].name)[0]
            if bare in design.asked.variables:
                raise ModelError(f"'{bare}' is a variable; a front is of results.")

    def optimum(self, objective: Objective, limits: list[Constraint], near: Optimum | None, method: str,
                say: Say | None, options: dict[str, Any]) -> Optimum:  # fmt: skip
        design = self.design
        names = [over_cases(name) for name in self.objective.terms]
        watched = [Constraint(name, upper=1e300, scale=1e300) for name in (*names, self.result)]
        variables = design.variables
        if near is not None:
            variables = [replace(item, start=near[item.name]) for item in design.variables]
        moved = replace(design, objective=objective, variables=variables,
                        constraints=(*design.constraints, *limits, *watched))  # fmt: skip
        object.__setattr__(moved, "plant", design.plant)
        return moved.optimise(method, say=say, **options)

    def units(self, optimum: Optimum) -> tuple[str, str]:
        """Of the objective, where its results have one, and of the second result."""
        *own, second = (item.unit for item in optimum.constraints[-len(self.objective.terms) - 1 :])
        return own[0] if len(set(own)) == 1 else "1", second

    def values(self, optimum: Optimum) -> tuple[float, float]:
        """The objective of the design, and the second result."""
        count = len(self.objective.terms)
        seen = [item.value for item in optimum.constraints[-count - 1 :]]
        return sum(f * v for f, v in zip(self.objective.terms.values(), seen, strict=False)), seen[-1]


def _front(design: Design, names: tuple[str, str], found: list[Optimum], watched: _Watched) -> Front:
    count = len(watched.objective.terms) + 1
    both = np.array([watched.values(optimum) for optimum in found])
    size = np.maximum(np.abs(both).max(axis=0), 1e-300)
    good = [
        optimum.feasible and not any(
            np.all(other <= own + 1e-6 * size) and np.any(other < own - 1e-4 * size)
            for other, item in zip(both, found, strict=True) if item.feasible
        )
        for own, optimum in zip(both, found, strict=True)
    ]  # fmt: skip
    optima = tuple(replace(optimum, constraints=optimum.constraints[:-count]) for optimum in found)
    order = np.argsort(both[:, 0], kind="stable")
    return Front(
        design.title or getattr(design.plant, "title", "") or "a design", names, tuple(both[order, 0].tolist()),
        tuple(both[order, 1].tolist()), tuple(good[k] for k in order), tuple(optima[k] for k in order),
        watched.units(found[0]),
    )  # fmt: skip
