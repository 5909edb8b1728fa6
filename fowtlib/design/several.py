"""Cases of several models, as of a turbine in operation and one at rest: each model has an evaluator of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fowtlib.analysis.plants import plant_of
from fowtlib.design.evaluation import Evaluated, Evaluator, Key
from fowtlib.design.terms import DesignCase
from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError


class Several:
    """An evaluator (fowtlib.design.evaluation.Evaluator) of what several others know, in the order of `keys`."""

    def __init__(self, evaluators: Sequence[Evaluator], keys: Sequence[Key]):
        self.evaluators, self.keys = list(evaluators), list(keys)

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        found = [one.evaluate(x, jacobian) for one in self.evaluators]
        values, slopes, units, states = ({k: v for one in found for k, v in (getattr(one, what) or {}).items()}
                                         for what in ("values", "jacobian", "units", "states"))  # fmt: skip
        return Evaluated({key: values[key] for key in self.keys}, units, slopes if jacobian else None, states)


def evaluator_of(make: Callable[..., Evaluator], plant: Any, space: Space, cases: Sequence[DesignCase],
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
