"""Response of a model to wind and waves in the frequency domain: spectra, deviations, extremes and fatigue, no runs.

Many states at once: `fw.responses`, in fowtlib.frequency.many (`responses` here is the module of one response).
"""

from fowtlib.frequency.drag import best_gain
from fowtlib.frequency.found import Response
from fowtlib.frequency.many import Responses
from fowtlib.frequency.responses import response

__all__ = ["Response", "Responses", "best_gain", "response"]
