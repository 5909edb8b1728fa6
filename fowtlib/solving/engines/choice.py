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


def create_engine(at: AtParameters, code: Callable[[], FixedStepCode], solver: str | None, tolerance: float,
                  output_step: float, given: Mapping[str, Any], settings: Mapping[str, Any]) -> Engine:  # fmt: skip
    """The engine of that name (None: the model's); its `step` and `rho_inf` as given, else the model's, else defaults.

    code: gives the compiled functions of the model, and is called where they are needed only.
    """
    solver = settings.get("solver", "idas") if solver is None else solver
    if solver not in SOLVERS:
        raise ParameterError(f"there is no solver '{solver}'{did_you_mean(str(solver), SOLVERS)}")
    if solver == "idas":
        for key, value in given.items():
            if value is not None:
                raise ParameterError(f"{key} is an option of the solver 'fixed'; the solver 'idas' has none like it.")
        compiled = None
        if worth_compiling(at.functions):
            if ida := sundials():
                return CompiledIdas(at, tolerance, code(), ida)
            compiled = at.functions.once("compiled", lambda: CompiledFunctions(code()))
        return Idas(at, tolerance, compiled=compiled)

    def chosen(key: str, unit: str, default: float) -> float:
        value = settings.get(key, default) if given.get(key) is None else given[key]
        return float(to_si(value, unit, key))

    step = _step(chosen("step", "s", min(STEP, output_step)), output_step)
    rho_inf = chosen("rho_inf", "1", RHO_INF)
    if not 0 <= rho_inf <= 1:
        raise ParameterError(f"rho_inf is {rho_inf:g}; it must lie between 0 and 1, usually 0.7 to 0.9.")
    if compiler():
        return FixedStep(code(), at, step, tolerance, rho_inf)
    return FixedStepTwin(at, step, tolerance, rho_inf)


def _step(step: float, output_step: float) -> float:
    if not (step > 0 and math.isfinite(step)):
        raise ParameterError(f"the step of the solver 'fixed' is {step:g} s; it must be above zero, usually 0.01 s.")
    if step > output_step * (1 + 1e-9):
        raise ParameterError(
            f"the step of the solver 'fixed', {step:g} s, is longer than the output step, {output_step:g} s. "
            "Give a shorter step (--step) or a longer output step (--output-step)."
        )
    return step
