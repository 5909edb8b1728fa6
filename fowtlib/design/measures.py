"""The results of a model under one case: at its mean position, of its modes, and of its response to waves and wind."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.fatigue.curves import SNCurve
from fowtlib.analysis.fatigue.spectral import dirlik
from fowtlib.analysis.maps import OF_MODES, modes_like, quantities_at, sound_equilibrium
from fowtlib.design.terms import DesignCase
from fowtlib.language.errors import ModelError
from fowtlib.solving import State, mean_state
from fowtlib.solving.starts import mean_parameters
from fowtlib.solving.turning import turns_of

if TYPE_CHECKING:
    from fowtlib.frequency import Response

YEARS = 365.25 * 24 * 3600.0
OF_RESPONSE = ("std of ", "largest ", "smallest ", "range of ", "damage of ")


@dataclass(frozen=True)
class Statistics:
    """How results of the response are taken.

    duration [s] and quantile: of the largest and smallest value; exponent: of the damage-equivalent range at 1 Hz;
    curve, lifetime [s]: of the damage of a stress, by Dirlik's law, as if the case lasted all the time: weighted over
    the cases with their probabilities it is that of the lifetime; tolerance: of the linearised drag.
    """

    duration: float = 3600.0
    quantile: float = 0.5
    exponent: float = 4.0
    curve: SNCurve | None = None
    lifetime: float = 20 * YEARS
    tolerance: float = 1e-7

    def __post_init__(self) -> None:
        for name in ("duration", "exponent", "lifetime", "tolerance"):
            if not 0 < getattr(self, name) < np.inf:
                raise ModelError(f"{name}: a number above 0 is expected, not {getattr(self, name):g}.")
        if not 0 < self.quantile < 1:
            raise ModelError(f"quantile: a number between 0 and 1 is expected, not {self.quantile:g}.")


@dataclass(frozen=True, eq=False)
class Measured:
    """Results of a case as columns, in `units`; where they were found, and the frequencies of the response."""

    values: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    state: State
    frequencies: np.ndarray | None = None


class Meter:
    """Measures results of a compiled model in a case, by their names."""

    def __init__(self, plant: Any, case: DesignCase, names: Sequence[str], free: Any = None,
                 targets: Mapping[str, Any] | None = None, statistics: Statistics | None = None):  # fmt: skip
        statistics = statistics or Statistics()
        self.plant, self.case, self.free, self.targets = plant, case, free, targets
        self.statistics, self.names = statistics, list(names)
        self._told = False  # of corners of control laws
        self.answers = {name: answer(name) for name in names if answer(name) is not None}
        self.still = [name for name in names if name not in self.answers]
        for name, (statistic, result) in self.answers.items():
            if result not in plant.outputs:
                known = ", ".join(list(plant.outputs)[:12])
                raise ModelError(f"'{name}' is of no result of the model; its results are {known}.")
            if statistic == "damage of " and statistics.curve is None:
                raise ModelError(f"'{name}' needs an S-N curve: Statistics(curve=...).")

    def measure(self, parameters: Mapping[str, Any], near: Measured | None = None, fixed: bool = False) -> Measured:
        """The results with these parameters over those of the case. `near`: of other parameters, to start from.

        fixed: the response is taken at the frequencies of `near`, so that a difference between both is one of the model
        and not of frequencies. Raises ModelError where there are no results.
        """
        given = {**self.case.parameters, **parameters}
        state = self._state(mean_parameters(self.plant, given), near)
        values, units, frequencies = {}, {}, None
        for name, value, unit in quantities_at(self.plant, state, self.still):
            values[name], units[name] = np.ravel(np.asarray(value, dtype=float)), unit
            if not np.all(np.isfinite(values[name])):
                like = modes_like(self.plant, state, name) if name.startswith(OF_MODES) else "."
                raise ModelError(f"there is no '{name}' at this point{like}")
        if self.answers:
            found = self._response(given, state, near.frequencies if near is not None and fixed else None)
            frequencies = found.frequency
            for name, (statistic, result) in self.answers.items():
                values[name] = np.array([self._of(found, statistic, result)])
                units[name] = "1" if statistic == "damage of " else found.unit(result)
        return Measured({name: values[name] for name in self.names}, units, state, frequencies)

    def _state(self, given: Mapping[str, Any], near: Measured | None) -> State:
        beside = near.state if near is not None else None
        if self.free:
            return sound_equilibrium(self.plant, given, near=beside, free=self.free, targets=self.targets)
        if self._turns(given):
            return mean_state(self.plant, given)
        return sound_equilibrium(self.plant, given, near=beside)

    def _turns(self, given: Mapping[str, Any]) -> bool:
        """Whether the mean is one over revolutions of rotors."""
        plant = self.plant
        if not plant.dae.symmetries:
            return False
        return bool(turns_of(plant, plant.at(given), plant.initial_state(given)))

    def _response(self, given: Mapping[str, Any], state: State, frequencies: np.ndarray | None) -> Response:
        from fowtlib.frequency import response
        from fowtlib.frequency.corners import CornerWarning

        freed = {path: state.parameters[path] for path in _paths(self.free) if path in state.parameters}
        outputs = list(dict.fromkeys(result for _, result in self.answers.values()))
        with warnings.catch_warnings():
            if self._told:  # a search comes by the same corners at each of its points
                warnings.simplefilter("ignore", CornerWarning)
            found = response(self.plant, outputs=outputs, parameters={**given, **freed}, frequencies=frequencies,
                             state=state, tolerance=self.statistics.tolerance)  # fmt: skip
        self._told = self._told or bool(found.corners)
        return found

    def _of(self, found: Response, statistic: str, result: str) -> float:
        by = self.statistics
        if statistic == "std of ":
            return found.std(result)
        if statistic == "range of ":
            return found.equivalent_load(result, by.exponent)
        if statistic == "damage of ":
            assert by.curve is not None
            return dirlik(found.spectrum(result)).damage(by.curve, by.lifetime)
        return found.extreme(result, by.duration, by.quantile, "max" if statistic == "largest " else "min")


def _paths(free: Any) -> list[str]:
    return [path.partition("[")[0] for path in free or ()]


def answer(name: str) -> tuple[str, str] | None:
    """Statistic and result of a name such as "std of pitch"; None for another name."""
    return next(((head, name.removeprefix(head)) for head in OF_RESPONSE if name.startswith(head)), None)
