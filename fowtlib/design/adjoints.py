"""Results of a model with exact slopes by adjoints, as far as there are adjoints of them; the others by differences.

Outputs, variables and what is of the response to waves and wind have slopes that cost the same for two variables and
for two hundred (fowtlib.frequency.PreparedGradient). Masses, numbers of a sheet, parameters and periods by the names of
modes, which need no response, are left to differences.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fowtlib.analysis.fatigue.spectral import dirlik
from fowtlib.design.differences import CLOSE, STEP, Differences, Results
from fowtlib.design.evaluation import Evaluated, Key
from fowtlib.design.measures import Statistics, answer
from fowtlib.design.terms import DesignCase
from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError


class Adjoints:
    """An evaluator of a compiled model (fowtlib.design.evaluation.Evaluator); arguments are those of Differences.

    Raises ModelError where there are no adjoints: rotors of blade elements turn, or the wind is a field in space.
    """

    def __init__(self, plant: Any, space: Space, cases: Sequence[DesignCase], keys: Sequence[Key], *, free: Any = None,
                 targets: Mapping[str, Any] | None = None, statistics: Statistics | None = None,
                 balance: str | None = None, step: float = STEP):  # fmt: skip
        from fowtlib.frequency import PreparedGradient

        self.plant, self.space, self.keys = plant, space, list(keys)
        self.statistics = statistics or Statistics()
        self.names: dict[str, list[str]] = {}
        self.prepared: dict[str, Any] = {}
        self.paths, self.balance = list(space.base), balance
        self.freed = list(free or ()) if balance is not None else []  # what other cases take from that of the balance
        for case in cases:
            exact = [name for own, name in keys if own == case.name and self._has_adjoint(name)]
            if exact:
                self.names[case.name] = exact
                own = balance in (None, case.name)
                self.prepared[case.name] = PreparedGradient(
                    plant, [self._quantity(name) for name in exact], self.paths + ([] if own else self.freed),
                    parameters=case.parameters, free=free if own and free else None,
                    targets=targets if own and targets else None, tolerance=self.statistics.tolerance,
                )  # fmt: skip
        rest = [key for key in keys if key[1] not in self.names.get(key[0], ())]
        rest += [(balance, path.partition("[")[0]) for path in self.freed if balance is not None]
        self.rest = Differences(plant, space, cases, list(dict.fromkeys(rest)), free=free, targets=targets,
                                statistics=statistics, balance=balance, step=step)  # fmt: skip
        self._chosen: np.ndarray | None = None  # where the frequencies were chosen
        pieces = [_columns_first(space.matrix(path), space.base[path].shape) for path in self.paths]
        self.slopes = np.concatenate(pieces)  # of the elements of parameters by the numbers of the space

    def evaluate(self, x: np.ndarray, jacobian: bool = False) -> Evaluated:
        """See Evaluator.evaluate."""
        other = self.rest.evaluate(x, jacobian)
        values, slopes, units = dict(other.values), dict(other.jacobian or {}), dict(other.units)
        parameters = self.space.parameters(x)
        point = np.concatenate([np.ravel(np.asarray(parameters[path]), order="F") for path in self.paths])
        if self._chosen is None or np.max(np.abs(x - self._chosen) / self.space.scale) > CLOSE:
            self._chosen = x
            for prepared in self.prepared.values():
                prepared.choose_frequencies()
        for case, prepared in self.prepared.items():
            taken = self.freed if case != self.balance else []
            where = [self._taken(other.values, path) for path in taken]
            found, by = self._at(prepared, case, np.concatenate([point, *where]), jacobian)
            for k, name in enumerate(self.names[case]):
                values[case, name], units[name] = found[k : k + 1], self._unit(name)
                if by is not None and other.jacobian is not None:
                    ways = [self._taken(other.jacobian, path) for path in taken]
                    slopes[case, name] = by[k : k + 1] @ np.concatenate([self.slopes, *ways])
        ordered: Results = {key: values[key] for key in self.keys}
        return Evaluated(ordered, units, slopes if jacobian else None, other.states)

    def _at(self, prepared: Any, case: str, point: np.ndarray, jacobian: bool) -> tuple[np.ndarray, np.ndarray | None]:
        try:
            if jacobian:
                return prepared.evaluate(point)
            return prepared.values(point), None
        except ModelError as error:
            if len(self.prepared) > 1:
                error.at(f"case {case}")
            raise

    def _taken(self, results: Mapping[Key, np.ndarray], path: str) -> np.ndarray:
        """Values or slopes of what a case takes from that of the balance; of an element, its row."""
        whole, _, number = path.rstrip("]").partition("[")
        found = results[str(self.balance), whole]
        return found[[int(number)]] if number else found

    def _unit(self, name: str) -> str:
        found = answer(name)
        if found is not None and found[0] == "damage of ":
            return "1"
        return self.plant.outputs.entry(name if found is None else found[1]).unit

    def _has_adjoint(self, name: str) -> bool:
        """Whether it is one number of the model, or of its response."""
        if answer(name) is not None:
            return True
        plant = self.plant
        if name not in plant.outputs and name not in plant.dae.names:
            return False
        return plant.dae.observe_expression(plant.outputs.entry(name).path).numel() == 1

    def _quantity(self, name: str) -> Any:
        from fowtlib.frequency import EquivalentLoad, Extreme, Mean, OfSpectrum, Std

        found, by = answer(name), self.statistics
        if found is None:
            return Mean(name)
        statistic, result = found
        if statistic == "std of ":
            return Std(result)
        if statistic == "range of ":
            return EquivalentLoad(result, by.exponent)
        if statistic == "damage of ":
            curve, lifetime = by.curve, by.lifetime
            if curve is None:
                raise ModelError(f"'{name}' needs an S-N curve: Statistics(curve=...).")
            return OfSpectrum(result, lambda spectrum, mean: dirlik(spectrum).damage(curve, lifetime), "1")
        return Extreme(result, "max" if statistic == "largest " else "min", by.duration, by.quantile)


def _columns_first(slopes: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Rows (elements, n) that are in C order, in column order."""
    order = np.arange(len(slopes)).reshape(shape).ravel(order="F")
    return slopes[order]
