"""Analyses of results and linear models: free decay, response amplitude operators, spectra, statistics, fatigue."""

from fowtlib.analysis.decay import Decay, analyse_decay, free_decay
from fowtlib.analysis.fatigue import (
    Cycles,
    RangeDistribution,
    SNCurve,
    TubeDamage,
    TubeSection,
    damage_equivalent_load,
    dirlik,
    equivalent_loads,
    lifetime_damage,
    lifetime_equivalent_load,
    narrow_band,
    rainflow_cycles,
    sn_curve,
    sn_curves,
    table_weights,
    tovo_benasciutti,
    tube_damage,
    weibull_weights,
)
from fowtlib.analysis.harmonics import HarmonicFit, harmonic_fit
from fowtlib.analysis.rao import Rao, linear_rao, simulated_rao
from fowtlib.analysis.spectra import Spectrum, average, compare, power_spectrum, realisation
from fowtlib.analysis.static import StaticCurve, static_curve
from fowtlib.analysis.statistics import normalized_maxima, over_seeds, up_crossings

__all__ = [
    "Cycles",
    "Decay",
    "HarmonicFit",
    "RangeDistribution",
    "Rao",
    "SNCurve",
    "Spectrum",
    "StaticCurve",
    "TubeDamage",
    "TubeSection",
    "analyse_decay",
    "average",
    "compare",
    "damage_equivalent_load",
    "dirlik",
    "equivalent_loads",
    "free_decay",
    "harmonic_fit",
    "lifetime_damage",
    "lifetime_equivalent_load",
    "linear_rao",
    "narrow_band",
    "normalized_maxima",
    "over_seeds",
    "power_spectrum",
    "rainflow_cycles",
    "realisation",
    "simulated_rao",
    "sn_curve",
    "sn_curves",
    "static_curve",
    "table_weights",
    "tovo_benasciutti",
    "tube_damage",
    "up_crossings",
    "weibull_weights",
]
