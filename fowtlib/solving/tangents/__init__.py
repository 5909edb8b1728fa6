"""Sensitivities of a run in time: the derivative of what the fixed-step engine computes, step by step."""

from fowtlib.solving.tangents.sensitivity import Sensitivities, Slopes, sensitivities

__all__ = ["Sensitivities", "Slopes", "sensitivities"]
