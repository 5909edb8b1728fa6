"""What surrounds a turbine: the world, the sea, the wind."""

# World has a Frame and the bodies of the mechanics need World: the mechanics load first and fetch World themselves.
from fowtlib.components import mechanics as _mechanics  # noqa: F401  isort: skip
from fowtlib.components.environment.current import Current
from fowtlib.components.environment.field_file import FieldGrid, WindField, create_field, read_field, write_field
from fowtlib.components.environment.field_generator import generate_field
from fowtlib.components.environment.iec import extreme_turbulence, normal_turbulence, operating_gust
from fowtlib.components.environment.sea import (
    ExtremeSea,
    ExtremeWave,
    InputSea,
    JonswapSea,
    MeasuredSea,
    NormalSea,
    RegularWaves,
    Sea,
    SevereSea,
    StillSea,
)
from fowtlib.components.environment.turbulence import kaimal, kaimal_series
from fowtlib.components.environment.waves import WaveComponents, irregular_waves, jonswap, regular_waves, wave_number
from fowtlib.components.environment.wind import (
    CoherentGust,
    DirectionChange,
    ExtremeShear,
    ExtremeTurbulence,
    ExtremeWind,
    FieldWind,
    GustWind,
    InputWind,
    KaimalWind,
    NormalProfile,
    NormalTurbulence,
    NoWind,
    OperatingGust,
    SeriesWind,
    SteadyExtremeWind,
    SteadyWind,
    StepWind,
    TurbulentWind,
    VeeringWind,
    Wind,
)
from fowtlib.components.environment.wind_file import WindSeries, read_series
from fowtlib.components.environment.world import World

__all__ = [
    "CoherentGust",
    "Current",
    "DirectionChange",
    "ExtremeSea",
    "ExtremeShear",
    "ExtremeTurbulence",
    "ExtremeWave",
    "ExtremeWind",
    "FieldGrid",
    "FieldWind",
    "GustWind",
    "InputSea",
    "InputWind",
    "JonswapSea",
    "KaimalWind",
    "MeasuredSea",
    "NoWind",
    "NormalProfile",
    "NormalSea",
    "NormalTurbulence",
    "OperatingGust",
    "RegularWaves",
    "Sea",
    "SeriesWind",
    "SevereSea",
    "SteadyExtremeWind",
    "SteadyWind",
    "StepWind",
    "TurbulentWind",
    "VeeringWind",
    "StillSea",
    "WaveComponents",
    "Wind",
    "WindField",
    "WindSeries",
    "World",
    "create_field",
    "extreme_turbulence",
    "generate_field",
    "irregular_waves",
    "jonswap",
    "kaimal",
    "kaimal_series",
    "normal_turbulence",
    "operating_gust",
    "read_field",
    "read_series",
    "regular_waves",
    "wave_number",
    "write_field",
]
