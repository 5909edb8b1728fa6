"""Cases of several models, as of a turbine in operation and one at rest: each model has an evaluator of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from fowtlib.analysis.plants import plant_of
from fowtlib.design.evaluation import Evaluated, Evaluator, Key
from fowtlib.design.parallel import Parallel, joined, refuse_where_none, shared_out
from fowtlib.design.terms import DesignCase
from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError


class Several:
    """An evaluator (fowtlib.design.evaluation.Evaluator) of what several others know, in the order of `keys`."""

    def __init__(self, evaluators: Sequence[Evaluator], keys: Sequence[Key]):
        self.evaluators, self.keys = list(evaluators), list(keys)

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        return joined([one.evaluate(x, jacobian) for one in self.evaluators], self.keys)


class OfCase:
    """The evaluator of one case among others, whose errors say which it is."""

    def __init__(self, name: str, make: Callable[[], Evaluator]):
        self.name, self.evaluator = name, make()

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        try:
            return self.evaluator.evaluate(x, jacobian)
        except ModelError as error:
            raise error.at(f"case {self.name}") from None


def evaluator_of(make: Callable[..., Evaluator], plant: Any, space: Space, cases: Sequence[DesignCase],
                 keys: Sequence[Key], processes: int = 1, **options: Any) -> Evaluator:  # fmt: skip
    """The evaluator that `make` makes, of cases that are shared out to so many processes."""
    asked = [case for case in cases if any(own == case.name for own, _ in keys)]
    if processes == 1 or len(asked) < 2:
        return _in_one_process(make, plant, space, cases, keys, **options)
    if options.get("balance") is not None:
        raise ModelError("cases that take what is freed in one of them are evaluated in one process: processes=1.")
    refuse_where_none()
    makers = []
    for group in shared_out([sum(own == case.name for own, _ in keys) for case in asked], processes):
        own = [asked[k] for k in group]
        mine = [key for key in keys if key[0] in {case.name for case in own}]
        maker = partial(_in_one_process, make, plant, space, own, mine, **options)
        makers.append(maker if len(own) > 1 else partial(OfCase, own[0].name, maker))
    return Parallel(makers[0], makers[1:], keys)


def _in_one_process(make: Callable[..., Evaluator], plant: Any, space: Space, cases: Sequence[DesignCase],
                    keys: Sequence[Key], **options: Any) -> Evaluator:  # fmt: skip
    """The evaluator that `make` makes; of cases that have models of their own, one for each of these beside it."""
    groups: dict[int, tuple[Any, list[DesignCase]]] = {}
    for case in cases:
        model = case.model if isinstance(case, DesignCase) else None  # a fw.Case stands for its conditions alone
        groups.setdefault(id(model), (model, []))[1].append(case)
    if len(groups) == 1 and id(None) in groups:
        return make(plant, space, cases, keys, **options)
    if options.get("balance") is not None:
        raise ModelError("a design whose cases are of several models has no balance in one of them; take what is freed "
                         "as a variable, with its target as a constraint in one case.")  # fmt: skip
    found = []
    for model, own in groups.values():
        names = {case.name for case in own}
        mine = [key for key in keys if key[0] in names]
        if mine and model is None:
            found.append(make(plant, space, own, mine, **options))
        elif mine:
            other = plant_of(model)
            found.append(make(other, within(space, other), own, mine, **options))
    return Several(found, keys)


def within(space: Space, plant: Any) -> Space:
    """The same variables, of which those parameters that a model has are driven."""
    known = plant.dae.parameters
    base = {path: value for path, value in space.base.items() if path in known}
    for path, value in base.items():
        if known[path].value.shape != value.shape:
            raise ModelError(f"{path} has {known[path].value.size} elements in {plant.name}, and {value.size} in the "
                             "model of the design.")  # fmt: skip
    placed = (replace(item, matrices={path: matrix for path, matrix in item.matrices.items() if path in base})
              for item in space.placed)  # fmt: skip
    return Space(tuple(placed), base)
