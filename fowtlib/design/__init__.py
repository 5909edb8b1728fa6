"""Design: variables of a model that make an objective least while constraints hold, found by slopes.

See docs/design.md.
"""

from fowtlib.design.calibration import Calibration, calibrate
from fowtlib.design.design import Design
from fowtlib.design.evaluation import Evaluated, Evaluator
from fowtlib.design.file import DesignFile, read_design
from fowtlib.design.measures import Statistics
from fowtlib.design.outcome import Optimum
from fowtlib.design.pareto import Front, pareto
from fowtlib.design.terms import Constraint, DesignCase, Function, Objective, kreisselmeier_steinhauser
from fowtlib.design.variables import Variable

__all__ = [
    "Calibration",
    "Constraint",
    "Design",
    "DesignCase",
    "DesignFile",
    "Evaluated",
    "Evaluator",
    "Front",
    "Function",
    "Objective",
    "Optimum",
    "Statistics",
    "Variable",
    "calibrate",
    "kreisselmeier_steinhauser",
    "pareto",
    "read_design",
]
