"""fowtlib: acausal models of floating wind turbines, from components to results.

    plant = fw.load("oc3_spar_rigid").compile()
    result = plant.simulate(600.0)
    result.plot("run.png")

load, view and export_fmu; the analyses of fowtlib.analysis (fw.free_decay, fw.linear_rao, ...); the packages of parts
(fw.components.mooring, ...); Assembly and Component to compose models of one's own.
"""

from __future__ import annotations

import importlib as _importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib import analysis, components
    from fowtlib.analysis import (
        analyse_decay,
        average,
        block_maxima,
        case_statistics,
        compare,
        compare_over_time,
        compare_results,
        damage_equivalent_load,
        damped_sinusoid,
        decay_equation,
        equivalent_loads,
        fit_gumbel,
        free_decay,
        harmonic_fit,
        lifetime_equivalent_load,
        linear_quadratic,
        linear_rao,
        linear_transfer,
        model_sheet,
        normalized_maxima,
        over_cases,
        over_seeds,
        parameter_map,
        power_spectrum,
        pull_test,
        rao_of_tests,
        regular_test,
        scaled,
        simulated_rao,
        spectral_rao,
        static_curve,
        swept_transfer,
        ultimate_loads,
        up_crossings,
    )
    from fowtlib.analysis.afloat_models import afloat
    from fowtlib.analysis.righting import righting_curve
    from fowtlib.analysis.stages import Stage, construction_stages
    from fowtlib.case_files import read_cases
    from fowtlib.cases import Batch, Case, check_cases, run_batch
    from fowtlib.design import (
        Calibration,
        Constraint,
        Design,
        DesignCase,
        Function,
        Objective,
        Optimum,
        Variable,
        calibrate,
        pareto,
        read_design,
    )
    from fowtlib.fmi import export_fmu
    from fowtlib.frequency import (
        AerodynamicCoefficients,
        Gradient,
        PreparedGradient,
        Response,
        Responses,
        aerodynamic_coefficients,
        forced_oscillation,
        gradient,
        response,
    )
    from fowtlib.frequency.many import responses
    from fowtlib.language import Assembly, Component, ModelError
    from fowtlib.modelfile import dump, load
    from fowtlib.solving import (
        Conditions,
        Event,
        LinearModel,
        Mode,
        Model,
        NaturalMode,
        Output,
        Plant,
        Result,
        Sensitivities,
        State,
        mean_linear_model,
        mean_state,
        natural_modes,
        sensitivities,
    )
    from fowtlib.view import view

    __version__: str

# imported when first used, so that `import fowtlib` stays fast
_PACKAGES = ("analysis", "components")
_LATER = {
    **dict.fromkeys(("Assembly", "Component", "ModelError"), "fowtlib.language"),
    "export_fmu": "fowtlib.fmi",
    "view": "fowtlib.view",
    **dict.fromkeys(
        ("Calibration", "Constraint", "Design", "DesignCase", "Function", "Objective", "Optimum", "Variable",
         "calibrate", "pareto", "read_design"),
        "fowtlib.design",
    ),
    **dict.fromkeys(
        ("AerodynamicCoefficients", "Gradient", "PreparedGradient", "Response", "Responses",
         "aerodynamic_coefficients", "forced_oscillation", "gradient", "response"),
        "fowtlib.frequency",
    ),
    "afloat": "fowtlib.analysis.afloat_models",
    "righting_curve": "fowtlib.analysis.righting",
    **dict.fromkeys(("Stage", "construction_stages"), "fowtlib.analysis.stages"),
    "responses": "fowtlib.frequency.many",
    "read_cases": "fowtlib.case_files",
    **dict.fromkeys(("Batch", "Case", "check_cases", "run_batch"), "fowtlib.cases"),
    **dict.fromkeys(("dump", "load"), "fowtlib.modelfile"),
    **dict.fromkeys(
        ("Conditions", "Event", "LinearModel", "Mode", "Model", "NaturalMode", "Output", "Plant", "Result",
         "Sensitivities", "State", "mean_linear_model", "mean_state", "natural_modes", "sensitivities"),
        "fowtlib.solving",
    ),
    **dict.fromkeys(
        ("analyse_decay", "average", "block_maxima", "campbell", "case_statistics", "compare", "compare_over_time",
         "compare_results", "damage_equivalent_load", "damped_sinusoid", "decay_equation", "equivalent_loads",
         "fit_gumbel", "free_decay", "harmonic_fit", "lifetime_equivalent_load", "linear_quadratic", "linear_rao",
         "linear_transfer", "model_sheet", "normalized_maxima", "over_cases", "over_seeds", "parameter_map",
         "power_spectrum", "pull_test", "rao_of_tests", "regular_test", "scaled", "simulated_rao", "spectral_rao",
         "static_curve", "swept_transfer", "ultimate_loads", "up_crossings"),
        "fowtlib.analysis",
    ),
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in _LATER:
        found = globals()[name] = getattr(_importlib.import_module(_LATER[name]), name)
        return found
    if name in _PACKAGES:
        return _importlib.import_module(f"fowtlib.{name}")
    if name == "__version__":
        from importlib.metadata import version

        return version("fowtlib")
    raise AttributeError(f"module 'fowtlib' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])


__all__ = [
    "AerodynamicCoefficients",
    "Assembly",
    "Batch",
    "Calibration",
    "Case",
    "Component",
    "Conditions",
    "Constraint",
    "Design",
    "DesignCase",
    "Event",
    "Function",
    "Gradient",
    "LinearModel",
    "Mode",
    "Model",
    "ModelError",
    "NaturalMode",
    "Objective",
    "Optimum",
    "Output",
    "Plant",
    "PreparedGradient",
    "Response",
    "Responses",
    "Result",
    "Sensitivities",
    "Stage",
    "State",
    "Variable",
    "aerodynamic_coefficients",
    "afloat",
    "analyse_decay",
    "analysis",
    "average",
    "block_maxima",
    "calibrate",
    "campbell",
    "case_statistics",
    "check_cases",
    "compare",
    "compare_over_time",
    "compare_results",
    "components",
    "construction_stages",
    "damage_equivalent_load",
    "damped_sinusoid",
    "decay_equation",
    "dump",
    "equivalent_loads",
    "export_fmu",
    "fit_gumbel",
    "forced_oscillation",
    "free_decay",
    "gradient",
    "harmonic_fit",
    "lifetime_equivalent_load",
    "linear_quadratic",
    "linear_rao",
    "linear_transfer",
    "load",
    "mean_linear_model",
    "mean_state",
    "model_sheet",
    "natural_modes",
    "normalized_maxima",
    "over_cases",
    "over_seeds",
    "parameter_map",
    "pareto",
    "power_spectrum",
    "pull_test",
    "rao_of_tests",
    "read_cases",
    "read_design",
    "regular_test",
    "response",
    "responses",
    "righting_curve",
    "run_batch",
    "scaled",
    "sensitivities",
    "simulated_rao",
    "spectral_rao",
    "static_curve",
    "swept_transfer",
    "ultimate_loads",
    "up_crossings",
    "view",
]
