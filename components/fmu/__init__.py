"""Functional mock-up units made elsewhere, as parts of a model."""

from fowtlib.components.fmu.component import FMU

__all__ = ["FMU"]
