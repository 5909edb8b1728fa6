"""Analyses of results and linear models: decay, response operators, spectra, statistics, extremes, fatigue."""

from fowtlib.analysis.campbell import Campbell, campbell
from fowtlib.analysis.case_statistics import case_statistics, over_cases
from fowtlib.analysis.comparison import compare_over_time, compare_results
from fowtlib.analysis.decay import Decay, analyse_decay, free_decay
from fowtlib.analysis.decay_fits import DecayFit, damped_sinusoid, decay_equation, linear_quadratic
from fowtlib.analysis.dry_tests import PullTest, pull_test
from fowtlib.analysis.extremes import block_maxima, fit_gumbel
from fowtlib.analysis.fatigue import damage_equivalent_load, equivalent_loads, lifetime_equivalent_load
from fowtlib.analysis.harmonics import HarmonicFit, harmonic_fit
from fowtlib.analysis.load_matrix import ultimate_loads
from fowtlib.analysis.maps import ParameterMap, parameter_map
from fowtlib.analysis.rao import Rao, linear_rao, simulated_rao
from fowtlib.analysis.scaling import scaled
from fowtlib.analysis.sheet import Sheet, model_sheet
from fowtlib.analysis.spectra import Spectrum, average, compare, power_spectrum
from fowtlib.analysis.static import StaticCurve, static_curve
from fowtlib.analysis.statistics import normalized_maxima, over_seeds, up_crossings
from fowtlib.analysis.swept import Transfer, linear_transfer, swept_transfer
from fowtlib.analysis.tank_waves import RegularTest, SpectralRao, rao_of_tests, regular_test, spectral_rao

__all__ = [
    "Campbell",
    "Decay",
    "DecayFit",
    "HarmonicFit",
    "ParameterMap",
    "PullTest",
    "Rao",
    "RegularTest",
    "Sheet",
    "SpectralRao",
    "Spectrum",
    "StaticCurve",
    "Transfer",
    "analyse_decay",
    "average",
    "block_maxima",
    "campbell",
    "case_statistics",
    "compare",
    "compare_over_time",
    "compare_results",
    "damage_equivalent_load",
    "damped_sinusoid",
    "decay_equation",
    "equivalent_loads",
    "fit_gumbel",
    "free_decay",
    "harmonic_fit",
    "lifetime_equivalent_load",
    "linear_quadratic",
    "linear_rao",
    "linear_transfer",
    "model_sheet",
    "normalized_maxima",
    "over_cases",
    "over_seeds",
    "parameter_map",
    "power_spectrum",
    "pull_test",
    "rao_of_tests",
    "regular_test",
    "scaled",
    "simulated_rao",
    "spectral_rao",
    "static_curve",
    "swept_transfer",
    "ultimate_loads",
    "up_crossings",
]
