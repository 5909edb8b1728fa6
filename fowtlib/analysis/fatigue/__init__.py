"""Fatigue: cycles, equivalent loads, S-N curves, damage of tubes and from spectra, and how reliable welds are."""

from fowtlib.analysis.fatigue.curves import SNCurve, sn_curve, sn_curves
from fowtlib.analysis.fatigue.cycles import Cycles, rainflow_cycles
from fowtlib.analysis.fatigue.lifetime import (
    YEAR,
    lifetime_damage,
    lifetime_equivalent_load,
    table_weights,
    weibull_weights,
)
from fowtlib.analysis.fatigue.loads import damage_equivalent_load, equivalent_loads
from fowtlib.analysis.fatigue.reliability import (
    FatigueReliability,
    InspectedReliability,
    Inspection,
    break_even_inspection,
    equivalent_factor,
    factor_for,
    present_value,
)
from fowtlib.analysis.fatigue.spectral import RangeDistribution, dirlik, narrow_band, tovo_benasciutti
from fowtlib.analysis.fatigue.tube import TubeDamage, TubeSection, tube_damage

__all__ = [
    "YEAR",
    "Cycles",
    "FatigueReliability",
    "InspectedReliability",
    "Inspection",
    "RangeDistribution",
    "SNCurve",
    "TubeDamage",
    "TubeSection",
    "break_even_inspection",
    "damage_equivalent_load",
    "dirlik",
    "equivalent_factor",
    "equivalent_loads",
    "factor_for",
    "lifetime_damage",
    "lifetime_equivalent_load",
    "narrow_band",
    "present_value",
    "rainflow_cycles",
    "sn_curve",
    "sn_curves",
    "table_weights",
    "tovo_benasciutti",
    "tube_damage",
    "weibull_weights",
]
