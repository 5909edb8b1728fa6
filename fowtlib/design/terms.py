"""What a design is asked for: cases, functions of results, the objective and the constraints.

A result is named as in `fw.parameter_map`: an output of the model or any of its variables, a number of its sheet
("mass", "hull: mass", "C33"), "period of ..." a mode, a parameter; and of the response to waves and wind, "std of
pitch", "largest pitch", "smallest pitch", "range of pitch" and "damage of stress" (fowtlib.design.measures). Besides, a
variable or a function of the design. "pitch @ storm" is that of one case, "weighted pitch" the mean over the cases with
their weights.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from fowtlib.language.errors import ModelError

_LIMIT = re.compile(r"\s*(.+?)\s*(<=|>=|<|>|=)\s*(.+?)\s*$")
Bound = float | str


@dataclass(frozen=True)
class DesignCase:
    """Conditions under which the results are wanted: parameters of a run by path, and a weight or a probability.

    model: another one than that of the design, compiled or not, such as that of a turbine at rest; variables drive
    those of its parameters that have their names. A `fw.Case` will do as well.
    """

    name: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    weight: float = 1.0
    model: Any = None


ALONE = DesignCase("design")


@dataclass(frozen=True)
class Function:
    """A result that follows from others, in each case: `function(values)`, with a mapping of the names in `of`.

    The values are CasADi expressions, scalars or columns: use arithmetic, NumPy's functions of one number, and those of
    casadi (`casadi.if_else`, `casadi.fmax`, `casadi.sum1`), so that its slopes are exact. What comes back is a scalar
    or a column. si: the values come in SI; otherwise each in the unit of its result.
    """

    name: str
    function: Callable[[Mapping[str, Any]], Any]
    of: Sequence[str]
    unit: str = "1"
    si: bool = False


@dataclass(frozen=True)
class Objective:
    """What becomes least: a sum of results, each times its factor and weighted over the cases.

    scale: a change that matters; None: the size at the start.
    """

    terms: Mapping[str, float]
    scale: float | None = None

    @staticmethod
    def read(given: Objective | Mapping[str, float] | str) -> Objective:
        """From itself, from results with factors, or from the name of one result."""
        if isinstance(given, Objective):
            return given
        return Objective({given: 1.0} if isinstance(given, str) else dict(given))

    def __str__(self) -> str:
        parts = [name if factor == 1 else f"{factor:g} x {name}" for name, factor in self.terms.items()]
        return " + ".join(parts)


@dataclass(frozen=True)
class Constraint:
    """A result between a lower and an upper limit, in the unit of the result or as a text with a unit.

    cases      names of the cases in which it counts; None: in all
    aggregate  "each": a constraint for each case and point; "ks": one for all of them, the function of Kreisselmeier
               and Steinhauser, KS = max g + 1/rho ln sum exp(rho (g - max g)), of g = (result - limit) / scale, which
               is never less than the largest g and at most ln(count) / rho above it
    sharpness  rho
    scale      a change that matters, in the unit of the result; None: the size of the limit
    Source of KS: G. Kreisselmeier and R. Steinhauser, IFAC Proceedings 12 (1979), 113-117.
    """

    result: str
    lower: Bound | None = None
    upper: Bound | None = None
    cases: Sequence[str] | None = None
    aggregate: Literal["each", "ks"] = "each"
    sharpness: float = 50.0
    scale: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if self.lower is None and self.upper is None:
            raise ModelError(f"the constraint on '{self.result}' has no limit.")
        if self.aggregate not in ("each", "ks"):
            raise ModelError(f"the constraint on '{self.result}': aggregate is 'each' or 'ks', not '{self.aggregate}'.")
        if not self.sharpness > 0:
            raise ModelError(f"the constraint on '{self.result}': sharpness is above zero, not {self.sharpness:g}.")
        if self.aggregate == "ks" and self.lower == self.upper:
            raise ModelError(f"the constraint on '{self.result}' is an equality, which cannot be aggregated.")

    @staticmethod
    def read(given: Constraint | str) -> Constraint:
        """From itself, or from a text such as "pitch < 5 deg", "heave = 0", "pitch @ storm < 10 deg"."""
        if isinstance(given, Constraint):
            return given
        found = _LIMIT.match(given)
        if found is None:
            raise ModelError(f"'{given}' is no constraint, such as 'pitch < 5 deg' or 'period of heave > 25 s'.")
        bound = found[3]
        lower, upper = (None if found[2].startswith("<") else bound), (None if found[2].startswith(">") else bound)
        return Constraint(found[1], lower, upper)

    @property
    def label(self) -> str:
        return self.name or self.result


def kreisselmeier_steinhauser(g: Any, sharpness: float = 50.0) -> Any:
    """KS of a column of numbers or of a CasADi expression: smooth, and never less than its largest element."""
    import casadi as ca

    if isinstance(g, (ca.SX, ca.MX)):
        largest = ca.mmax(g)
        return largest + ca.log(ca.sum1(ca.exp(sharpness * (g - largest)))) / sharpness
    values = np.asarray(g, dtype=float)
    largest = float(np.max(values))
    return largest + float(np.log(np.sum(np.exp(sharpness * (values - largest))))) / sharpness
