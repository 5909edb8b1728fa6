"""Which engines there are, and the settings that a user gives them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from fowtlib.language.errors import ParameterError, did_you_mean
from fowtlib.language.native import compiler
from fowtlib.language.units import to_si
from fowtlib.solving.engines.base import RHO_INF, SOLVERS, STEP, Engine
from fowtlib.solving.engines.compiled import CompiledFunctions, worth_compiling
from fowtlib.solving.engines.compiled_idas import CompiledIdas
from fowtlib.solving.engines.fixed_step import FixedStep
from fowtlib.solving.engines.fixed_step_code import FixedStepCode
from fowtlib.solving.engines.idas import Idas
from fowtlib.solving.engines.sundials import sundials
from fowtlib.solving.engines.twin import FixedStepTwin
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.settings import duration_settings, place_of


def create_engine(at: AtParameters, code: Callable[[], FixedStepCode], solver: str | None, tolerance: float,
                  output_step: float, given: Mapping[str, Any], settings: Mapping[str, Any]) -> Engine:  # fmt: skip
    """The engine of that name (None: the model's); its `step` and `rho_inf` as given, else the model's, else defaults.

    code: gives the compiled functions of the model, and is called where they are needed only.
    """
    if _solver(solver, settings) == "idas":
        for key, value in given.items():
            if value is not None:
                raise ParameterError(f"{key} is an option of the solver 'fixed'; the solver 'idas' has none like it.")
        compiled = None
        if worth_compiling(at.functions):
            if ida := sundials():
                return CompiledIdas(at, tolerance, code(), ida)
            compiled = at.functions.once("compiled", lambda: CompiledFunctions(code()))
        return Idas(at, tolerance, compiled=compiled)

    step, rho_inf = _of_fixed(given, settings, output_step)
    if compiler():
        return FixedStep(code(), at, step, tolerance, rho_inf)
    return FixedStepTwin(at, step, tolerance, rho_inf)


def check_settings(settings: Mapping[str, Any]) -> None:
    """ParameterError where no run can be made as a model file says, if it asks for nothing else."""
    output_step = duration_settings(None, None, None, settings)[1]
    if _solver(None, settings) == "fixed":
        _of_fixed({}, settings, output_step)


def _solver(solver: str | None, settings: Mapping[str, Any]) -> str:
    name = settings.get("solver", "idas") if solver is None else solver
    if name not in SOLVERS:
        said = f"there is no solver '{name}'{did_you_mean(str(name), SOLVERS)}"
        raise ParameterError(said).at("" if solver is not None else place_of(settings, "solver"))
    return str(name)


def _of_fixed(given: Mapping[str, Any], settings: Mapping[str, Any], output_step: float) -> tuple[float, float]:
    """Step [s] and rho_inf of the solver `fixed`."""

    def chosen(key: str, unit: str, default: float) -> tuple[float, str]:
        if given.get(key) is not None:
            return float(to_si(given[key], unit, key)), ""
        return float(to_si(settings.get(key, default), unit, key)), place_of(settings, key)

    step, place = chosen("step", "s", min(STEP, output_step))
    if not (step > 0 and math.isfinite(step)):
        raise ParameterError(
            f"the step of the solver 'fixed' is {step:g} s; it must be above zero, usually 0.01 s."
        ).at(place)
    if step > output_step * (1 + 1e-9):
        raise ParameterError(
            f"the step of the solver 'fixed', {step:g} s, is longer than the output step, {output_step:g} s. "
            "Give a shorter step (--step) or a longer output step (--output-step)."
        ).at(place)
    rho_inf, place = chosen("rho_inf", "1", RHO_INF)
    if not 0 <= rho_inf <= 1:
        said = f"rho_inf is {rho_inf:g}; it must lie between 0 and 1, usually 0.7 to 0.9."
        raise ParameterError(said).at(place)
    return step, rho_inf
