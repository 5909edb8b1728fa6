"""The engines that integrate: which there are, and the settings a user gives them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.native import NO_COMPILER, compiler, say_once
from fowtlib.language.units import to_si

if TYPE_CHECKING:
    from fowtlib.solving.plant import Plant

SOLVERS = ("idas", "fixed")
STEP, RHO_INF = 0.0125, 0.8


class Engine(Protocol):
    """What the run of a simulation needs of an engine; StepFailure where it cannot go on."""

    advice: str
    """What to try where it fails; the end of a sentence."""

    @property
    def attributes(self) -> dict[str, float | str]:
        """What a result says about its solver."""

    def advance(
        self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic unknowns (rows) at `points` equidistant times after t."""

    def algebraics(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Algebraic unknowns that satisfy the equations at the states, after a jump."""

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes (see SampledUpdate.values), as a function of t, x, z, q."""


def create_engine(plant: Plant, parameters: Any, solver: str, tolerance: float, output_step: float,
                  given: Mapping[str, Any], settings: Mapping[str, Any]) -> Engine:  # fmt: skip
    """The engine of that name; its `step` and `rho_inf` are given for this run, else the model's, else the defaults."""
    if solver not in SOLVERS:
        raise ParameterError(f"there is no solver '{solver}'{did_you_mean(str(solver), SOLVERS)}")
    if solver == "idas":
        for key, value in given.items():
            if value is not None:
                raise ParameterError(f"{key} is an option of the solver 'fixed'; the solver 'idas' has none like it.")
        from fowtlib.solving.compiled_functions import CompiledFunctions, worth_compiling
        from fowtlib.solving.idas import Idas

        evaluation, compiled = plant.evaluation(parameters), None
        if worth_compiling(plant.dae):
            compiled = CompiledFunctions(plant.fixed_step_code, evaluation.parameters)
        return Idas(evaluation, tolerance, compiled=compiled)

    def chosen(key: str, unit: str, default: float) -> float:
        value = settings.get(key, default) if given.get(key) is None else given[key]
        return float(to_si(value, unit, key))

    step = _step(chosen("step", "s", min(STEP, output_step)), output_step)
    rho_inf = chosen("rho_inf", "1", RHO_INF)
    if not 0 <= rho_inf <= 1:
        raise ParameterError(f"rho_inf is {rho_inf:g}; it must lie between 0 and 1, usually 0.7 to 0.9.")
    evaluation = plant.evaluation(parameters)
    if compiler():
        from fowtlib.solving.fixed_step import FixedStep

        return FixedStep(plant.fixed_step_code, evaluation, step, tolerance, rho_inf)
    from fowtlib.solving.fixed_step_twin import FixedStepTwin

    say_once(f"the solver 'fixed' runs as Python code, slowly: {NO_COMPILER}")
    return FixedStepTwin(evaluation, step, tolerance, rho_inf)


def _step(step: float, output_step: float) -> float:
    if not (step > 0 and math.isfinite(step)):
        raise ParameterError(f"the step of the solver 'fixed' is {step:g} s; it must be above zero, usually 0.01 s.")
    if step > output_step * (1 + 1e-9):
        raise ParameterError(
            f"the step of the solver 'fixed', {step:g} s, is longer than the output step, {output_step:g} s. "
            "Give a shorter step (--step) or a longer output step (--output-step)."
        )
    return step
