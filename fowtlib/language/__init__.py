"""Floor 1: what an author of components writes with."""

from fowtlib.language import math, shapes
from fowtlib.language.component import Assembly, Component
from fowtlib.language.connectors import Connector, RealInput, RealOutput, flow, orientation, potential
from fowtlib.language.declarations import (
    Array,
    Data,
    Matrix,
    Number,
    Scalar,
    Vector,
    data,
    outer,
    param,
    part,
    parts,
    port,
    var,
)
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
from fowtlib.language.operators import StateSpace, linear_operator
from fowtlib.language.run_time import at_start, run_time_series
from fowtlib.language.series import Series
from fowtlib.language.tables import table1d, table2d, time_series

__all__ = [
    "Array",
    "Assembly",
    "Component",
    "Connector",
    "Data",
    "ExternalFunction",
    "Matrix",
    "ModelError",
    "Number",
    "RealInput",
    "RealOutput",
    "Scalar",
    "StateSpace",
    "Series",
    "Vector",
    "assert_",
    "assign",
    "at_start",
    "call",
    "data",
    "der",
    "eq",
    "external",
    "fix_orientation",
    "flow",
    "initial",
    "input_rate",
    "linear_operator",
    "math",
    "open_input",
    "orientation",
    "outer",
    "param",
    "part",
    "parts",
    "port",
    "potential",
    "reinit",
    "cyclic_symmetry",
    "rotation",
    "run_time_series",
    "sampled",
    "shapes",
    "table1d",
    "table2d",
    "time_series",
    "var",
    "when",
]
