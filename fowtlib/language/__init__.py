"""Floor 1: what an author of components writes with."""

from fowtlib.language import facts, math, shapes
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
    like,
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
    on,
    open_input,
    reinit,
    rotation,
    sampled,
    when,
)
from fowtlib.language.errors import ModelError
from fowtlib.language.externals import ExternalFunction
from fowtlib.language.offered import OfferedEvent, event
from fowtlib.language.operators import StateSpace, linear_operator
from fowtlib.language.quadratic_laws import quadratic
from fowtlib.language.run_time import at_start, run_time_series
from fowtlib.language.series import Series
from fowtlib.language.stages import stage_step
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
    "OfferedEvent",
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
    "event",
    "external",
    "fix_orientation",
    "flow",
    "initial",
    "input_rate",
    "like",
    "linear_operator",
    "math",
    "on",
    "open_input",
    "orientation",
    "outer",
    "param",
    "part",
    "parts",
    "port",
    "potential",
    "quadratic",
    "reinit",
    "cyclic_symmetry",
    "rotation",
    "run_time_series",
    "sampled",
    "facts",
    "shapes",
    "stage_step",
    "table1d",
    "table2d",
    "time_series",
    "var",
    "when",
]
