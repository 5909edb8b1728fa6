"""Rules of design and costs as functions: of numbers, of NumPy arrays and of CasADi expressions, SI units throughout.

A utilisation is at most 1 where the rule is kept. Arrays go element by element. Of expressions, derivatives are exact;
where a rule has branches its function says so.
"""

from fowtlib.analysis.line_maxima import harmonic_extreme
from fowtlib.design.rules.column import ColumnBuckling, column_buckling, column_slenderness
from fowtlib.design.rules.cost import (
    SteelCost,
    TubeSections,
    fabrication_times,
    mooring_cost,
    ring_fabrication_times,
    steel_cost,
    tube_sections,
)
from fowtlib.design.rules.fatigue import fatigue_utilisation
from fowtlib.design.rules.limits import (
    at_least,
    at_most,
    heave_period,
    period_ratio,
    power_lost_by_tilt,
    rigid_period,
    taper_utilisation,
)
from fowtlib.design.rules.mooring import (
    HangingLine,
    MooringStrength,
    UpliftLimit,
    hanging_line,
    mooring_strength,
    uplift_limit,
)
from fowtlib.design.rules.raising import flotation_diameter, flotation_draft, shaft_stiffness, shaft_water
from fowtlib.design.rules.ring import PanelRing, Ring, RingSection, panel_ring
from fowtlib.design.rules.shell import (
    HoopStress,
    ShellBuckling,
    cylinder_stress,
    elastic_strengths,
    hoop_stress,
    shell_buckling,
)
from fowtlib.design.rules.stability import (
    highest_wave_ratio,
    nacelle_acceleration,
    righting_arm,
    stability_area_ratio,
    static_heel,
)
from fowtlib.design.rules.standards import (
    SPAR,
    SPAR_AT_REST,
    SPAR_PERIODS,
    Limit,
    Verdict,
    broken,
    check_limits,
    check_periods,
    within_wave_band,
)
from fowtlib.design.rules.steel import STEEL, Steel
from fowtlib.design.rules.tower import TowerBuckling, tower_buckling
from fowtlib.design.rules.tubes import (
    HullUse,
    hull_buckling,
    hull_cost,
    ring_fraction,
    sizes_at,
    spar_ballast,
    spar_heave_period,
    tapers,
    tower_cost,
    tower_use,
    tube_fatigue,
    tube_mass,
    unevenness,
)

__all__ = [
    "SPAR",
    "SPAR_AT_REST",
    "SPAR_PERIODS",
    "STEEL",
    "ColumnBuckling",
    "HangingLine",
    "HoopStress",
    "HullUse",
    "Limit",
    "MooringStrength",
    "PanelRing",
    "Ring",
    "RingSection",
    "ShellBuckling",
    "Steel",
    "SteelCost",
    "TowerBuckling",
    "TubeSections",
    "UpliftLimit",
    "Verdict",
    "at_least",
    "at_most",
    "broken",
    "check_limits",
    "check_periods",
    "column_buckling",
    "column_slenderness",
    "cylinder_stress",
    "elastic_strengths",
    "fabrication_times",
    "fatigue_utilisation",
    "flotation_diameter",
    "flotation_draft",
    "hanging_line",
    "harmonic_extreme",
    "heave_period",
    "highest_wave_ratio",
    "hoop_stress",
    "hull_buckling",
    "hull_cost",
    "mooring_cost",
    "mooring_strength",
    "nacelle_acceleration",
    "panel_ring",
    "period_ratio",
    "power_lost_by_tilt",
    "righting_arm",
    "rigid_period",
    "ring_fabrication_times",
    "ring_fraction",
    "sizes_at",
    "shaft_stiffness",
    "shaft_water",
    "shell_buckling",
    "spar_ballast",
    "spar_heave_period",
    "stability_area_ratio",
    "static_heel",
    "steel_cost",
    "taper_utilisation",
    "tapers",
    "tower_buckling",
    "tower_cost",
    "tower_use",
    "tube_fatigue",
    "tube_mass",
    "tube_sections",
    "unevenness",
    "uplift_limit",
    "within_wave_band",
]
