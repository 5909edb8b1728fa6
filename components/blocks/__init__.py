"""Signal blocks: gains, integrators, filters, actuators, limiters, controllers, tables, sources."""

from fowtlib.components.blocks.algebra import Demux, Gain, Limiter, Mux, Product, Sum
from fowtlib.components.blocks.control import PI, DiscreteTransferFunction, SampledPI, Sampler
from fowtlib.components.blocks.dynamics import (
    BandPass,
    ButterworthLowPass,
    Derivative,
    FirstOrder,
    Integrator,
    SecondOrderActuator,
    SlewRateLimiter,
    StateSpace,
    TransferFunction,
)
from fowtlib.components.blocks.sources import Constant, Ramp, Sine, Step, TimeTable
from fowtlib.components.blocks.tables import Table1D, Table2D

__all__ = [
    "PI",
    "BandPass",
    "ButterworthLowPass",
    "Constant",
    "Demux",
    "Derivative",
    "DiscreteTransferFunction",
    "FirstOrder",
    "Gain",
    "Integrator",
    "Limiter",
    "Mux",
    "Product",
    "Ramp",
    "SampledPI",
    "Sampler",
    "SecondOrderActuator",
    "Sine",
    "SlewRateLimiter",
    "StateSpace",
    "Step",
    "Sum",
    "Table1D",
    "Table2D",
    "TimeTable",
    "TransferFunction",
]
