"""Analyses of results and linear models: free decay, response amplitude operators, spectra, statistics, fatigue."""

from fowtlib.analysis.decay import Decay, analyse_decay, free_decay
from fowtlib.analysis.fatigue import damage_equivalent_load, equivalent_loads, lifetime_equivalent_load
from fowtlib.analysis.harmonics import HarmonicFit, harmonic_fit
from fowtlib.analysis.rao import Rao, linear_rao, simulated_rao
from fowtlib.analysis.spectra import Spectrum, average, compare, power_spectrum
from fowtlib.analysis.static import StaticCurve, static_curve
from fowtlib.analysis.statistics import normalized_maxima, over_seeds, up_crossings

__all__ = [
    "Decay",
    "HarmonicFit",
    "Rao",
    "Spectrum",
    "StaticCurve",
    "analyse_decay",
    "average",
    "compare",
    "damage_equivalent_load",
    "equivalent_loads",
    "free_decay",
    "harmonic_fit",
    "lifetime_equivalent_load",
    "linear_rao",
    "normalized_maxima",
    "over_seeds",
    "power_spectrum",
    "simulated_rao",
    "static_curve",
    "up_crossings",
]
