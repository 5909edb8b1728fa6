"""Fatigue: cycles, damage-equivalent loads, S-N curves, damage of tubes, and what a spectrum says about them."""

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
from fowtlib.analysis.fatigue.spectral import RangeDistribution, dirlik, narrow_band, tovo_benasciutti
from fowtlib.analysis.fatigue.tube import TubeDamage, TubeSection, tube_damage

__all__ = [
    "YEAR",
    "Cycles",
    "RangeDistribution",
    "SNCurve",
    "TubeDamage",
    "TubeSection",
    "damage_equivalent_load",
    "dirlik",
    "equivalent_loads",
    "lifetime_damage",
    "lifetime_equivalent_load",
    "narrow_band",
    "rainflow_cycles",
    "sn_curve",
    "sn_curves",
    "table_weights",
    "tovo_benasciutti",
    "tube_damage",
    "weibull_weights",
]
