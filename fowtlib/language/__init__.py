"""Floor 1: what an author of components writes with."""

from __future__ import annotations

import importlib as _importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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

# imported when first used: `fowt --help` and what reads files alone must not wait for NumPy and CasADi
_MODULES = ("facts", "math", "shapes")
_LATER = {
    **dict.fromkeys(("Assembly", "Component"), "component"),
    **dict.fromkeys(("Connector", "RealInput", "RealOutput", "flow", "orientation", "potential"), "connectors"),
    **dict.fromkeys(
        ("Array", "Data", "Matrix", "Number", "Scalar", "Vector", "data", "like", "outer", "param", "part",
         "parts", "port", "var"), "declarations",
    ),
    **dict.fromkeys(
        ("assert_", "assign", "call", "cyclic_symmetry", "der", "eq", "external", "fix_orientation", "initial",
         "input_rate", "on", "open_input", "reinit", "rotation", "sampled", "when"), "equations",
    ),
    "ModelError": "errors",
    "ExternalFunction": "externals",
    **dict.fromkeys(("OfferedEvent", "event"), "offered"),
    **dict.fromkeys(("StateSpace", "linear_operator"), "operators"),
    "quadratic": "quadratic_laws",
    **dict.fromkeys(("at_start", "run_time_series"), "run_time"),
    "Series": "series",
    "stage_step": "stages",
    **dict.fromkeys(("table1d", "table2d", "time_series"), "tables"),
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return _importlib.import_module(f"fowtlib.language.{name}")
    if name not in _LATER:
        raise AttributeError(f"module 'fowtlib.language' has no attribute '{name}'")
    found = globals()[name] = getattr(_importlib.import_module(f"fowtlib.language.{_LATER[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted(__all__)


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
