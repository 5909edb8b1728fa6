"""Floor 1: what an author of components writes with."""

from fowtlib.language import math, shapes
from fowtlib.language.component import Assembly, Component
from fowtlib.language.connectors import Connector, RealInput, RealOutput, flow, orientation, potential
from fowtlib.language.declarations import Array, Matrix, Scalar, Vector, outer, param, part, port, var
from fowtlib.language.equations import (
    assert_,
    assign,
    call,
    cyclic_symmetry,
    der,
    eq,
    external,
    fix_orientation,
    initial,
    input_rate,
    open_input,
    reinit,
    rotation,
    sampled,
    when,
)
from fowtlib.language.errors import ModelError
from fowtlib.language.externals import ExternalFunction
from fowtlib.language.tables import table1d, table2d, time_series

__all__ = [
    "Array",
    "Assembly",
    "Component",
    "Connector",
    "ExternalFunction",
    "Matrix",
    "ModelError",
    "RealInput",
    "RealOutput",
    "Scalar",
    "Vector",
    "assert_",
    "assign",
    "call",
    "der",
    "eq",
    "external",
    "fix_orientation",
    "flow",
    "initial",
    "input_rate",
    "math",
    "open_input",
    "orientation",
    "outer",
    "param",
    "part",
    "port",
    "potential",
    "reinit",
    "cyclic_symmetry",
    "rotation",
    "sampled",
    "shapes",
    "table1d",
    "table2d",
    "time_series",
    "var",
    "when",
]
