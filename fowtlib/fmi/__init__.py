"""Functional Mock-up Units: any plant as a standard FMU of FMI 2.0 or 3.0; see docs/fmi.md."""

from fowtlib.fmi.export import export_fmu

__all__ = ["export_fmu"]
