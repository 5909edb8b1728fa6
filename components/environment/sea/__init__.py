"""The sea state of a model, one class for each kind: what a new kind needs is a class in this folder."""

# isort: off
from fowtlib.components.environment.sea.base import Sea
from fowtlib.components.environment.sea.still import StillSea
from fowtlib.components.environment.sea.regular import RegularWaves
from fowtlib.components.environment.sea.jonswap import JonswapSea
from fowtlib.components.environment.sea.site import ExtremeSea, ExtremeWave, NormalSea, SevereSea
from fowtlib.components.environment.sea.measured import MeasuredSea
from fowtlib.components.environment.sea.input import InputSea
# isort: on
from fowtlib.components.environment.sea.record import WaveRecord, read_record, record_waves

__all__ = [
    "ExtremeSea",
    "ExtremeWave",
    "InputSea",
    "JonswapSea",
    "MeasuredSea",
    "NormalSea",
    "RegularWaves",
    "Sea",
    "SevereSea",
    "StillSea",
    "WaveRecord",
    "read_record",
    "record_waves",
]
