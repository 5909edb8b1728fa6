"""Linear design of controllers from the model itself."""

from fowtlib.control.estimators import Estimator, compensator, kalman
from fowtlib.control.margins import Margins, disk_margin, margins
from fowtlib.control.pi_tuning import PitchLoop, Poles, RotorResponse, Shaved, Tuned, least_pitch, shave_peak, tune_pi
from fowtlib.control.points import OperatingPoint, OperatingPoints
from fowtlib.control.reduction import SampledModel, discretized, opened, reduced
from fowtlib.control.regulators import DesignError, Regulator, lqi, lqr, poles_of
from fowtlib.control.schedules import estimator_table, gain_table

__all__ = [
    "DesignError",
    "Estimator",
    "Margins",
    "OperatingPoint",
    "OperatingPoints",
    "PitchLoop",
    "Poles",
    "Regulator",
    "RotorResponse",
    "SampledModel",
    "Shaved",
    "Tuned",
    "compensator",
    "discretized",
    "disk_margin",
    "estimator_table",
    "gain_table",
    "kalman",
    "lqi",
    "lqr",
    "margins",
    "opened",
    "poles_of",
    "reduced",
    "least_pitch",
    "shave_peak",
    "tune_pi",
]
