"""The wind of a model: one class for each kind, all with the equations of `Wind`."""

# The kinds in the order in which messages name them.
# isort: off
from fowtlib.components.environment.wind.base import Wind, require_disk
from fowtlib.components.environment.wind.no_wind import NoWind
from fowtlib.components.environment.wind.steady import SteadyWind
from fowtlib.components.environment.wind.step import StepWind
from fowtlib.components.environment.wind.veer import VeeringWind
from fowtlib.components.environment.wind.gust import GustWind
from fowtlib.components.environment.wind.kaimal import KaimalWind
from fowtlib.components.environment.wind.normal import ExtremeTurbulence, NormalProfile, NormalTurbulence
from fowtlib.components.environment.wind.extreme import ExtremeWind, SteadyExtremeWind
from fowtlib.components.environment.wind.transient import CoherentGust, DirectionChange, ExtremeShear, OperatingGust
from fowtlib.components.environment.wind.series import SeriesWind
from fowtlib.components.environment.wind.field import FieldWind
from fowtlib.components.environment.wind.turbulent import TurbulentWind
from fowtlib.components.environment.wind.input import InputWind
# isort: on

__all__ = [
    "CoherentGust",
    "DirectionChange",
    "ExtremeShear",
    "ExtremeTurbulence",
    "ExtremeWind",
    "FieldWind",
    "GustWind",
    "InputWind",
    "KaimalWind",
    "NoWind",
    "NormalProfile",
    "NormalTurbulence",
    "OperatingGust",
    "SeriesWind",
    "SteadyExtremeWind",
    "SteadyWind",
    "StepWind",
    "TurbulentWind",
    "VeeringWind",
    "Wind",
    "require_disk",
]
