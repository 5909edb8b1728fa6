"""Response of a model to wind and waves in the frequency domain: spectra, deviations, extremes and fatigue, no runs."""

from fowtlib.frequency.drag import best_gain
from fowtlib.frequency.gradients import Gradient, PreparedGradient, gradient
from fowtlib.frequency.quantities import EquivalentLoad, Extreme, Mean, ModeDamping, ModeFrequency, OfSpectrum, Std
from fowtlib.frequency.responses import Response, response

__all__ = [
    "EquivalentLoad",
    "Extreme",
    "Gradient",
    "Mean",
    "ModeDamping",
    "ModeFrequency",
    "OfSpectrum",
    "PreparedGradient",
    "Response",
    "Std",
    "best_gain",
    "gradient",
    "response",
]
