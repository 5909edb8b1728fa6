"""Loads of the water on a floating body."""

# the connectors of the mechanics come first, see components/environment
from fowtlib.components import mechanics as _mechanics  # noqa: F401  isort: skip
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.hull_part import HullPart, diffraction_coefficient
from fowtlib.components.hydro.linear_loads import (
    AddedMass,
    Hydrostatics,
    LinearDamping,
    PlatformLoad,
    Radiation,
    WaveExcitation,
    waterplane_stiffness,
)
from fowtlib.components.hydro.morison import MorisonDrag
from fowtlib.components.hydro.potential_flow import LinearPotentialFlow
from fowtlib.components.hydro.radiation_identification import RadiationModel, identify_radiation
from fowtlib.components.hydro.retardation import retardation_kernel
from fowtlib.components.hydro.slender_hull import HullCoefficients, SlenderHullLoads
from fowtlib.components.hydro.turning_waves import TurningWaveExcitation

__all__ = [
    "AddedMass",
    "HydrodynamicDataError",
    "HydrodynamicDatabase",
    "HullCoefficients",
    "HullPart",
    "Hydrostatics",
    "LinearDamping",
    "LinearPotentialFlow",
    "MorisonDrag",
    "PlatformLoad",
    "Radiation",
    "RadiationModel",
    "SlenderHullLoads",
    "TurningWaveExcitation",
    "WaveExcitation",
    "diffraction_coefficient",
    "identify_radiation",
    "retardation_kernel",
    "waterplane_stiffness",
]
