"""Response of a model to wind and waves in the frequency domain: spectra, deviations, extremes and fatigue, no runs.

Many states at once: `fw.responses`, in fowtlib.frequency.many (`responses` here is the module of one response).
"""

from fowtlib.frequency.aerodynamics import AerodynamicCoefficients, aerodynamic_coefficients, forced_oscillation
from fowtlib.frequency.drag import best_gain
from fowtlib.frequency.found import Response
from fowtlib.frequency.gradients import Gradient, PreparedGradient, gradient
from fowtlib.frequency.line_tension import LineExtreme, line_extreme, with_line_results
from fowtlib.frequency.many import Responses
from fowtlib.frequency.quantities import EquivalentLoad, Extreme, Mean, ModeDamping, ModeFrequency, OfSpectrum, Std
from fowtlib.frequency.responses import response

__all__ = [
    "AerodynamicCoefficients",
    "EquivalentLoad",
    "Extreme",
    "Gradient",
    "LineExtreme",
    "Mean",
    "ModeDamping",
    "ModeFrequency",
    "OfSpectrum",
    "PreparedGradient",
    "Response",
    "Responses",
    "Std",
    "aerodynamic_coefficients",
    "best_gain",
    "forced_oscillation",
    "gradient",
    "line_extreme",
    "response",
    "with_line_results",
]
