"""Response of a model to wind and waves in the frequency domain: spectra, deviations, extremes and fatigue, no runs."""

from fowtlib.frequency.drag import best_gain
from fowtlib.frequency.line_tension import LineExtreme, line_extreme, with_line_results
from fowtlib.frequency.responses import Response, response

__all__ = ["LineExtreme", "Response", "best_gain", "line_extreme", "response", "with_line_results"]
