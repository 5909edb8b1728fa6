"""Aerodynamics of rotors: coefficient tables, and the rotor that is described by them."""

from fowtlib.components.aero.coefficient_rotor import CoefficientRotor
from fowtlib.components.aero.coefficient_table import CoefficientTable, read_coefficients
from fowtlib.components.aero.rotor import Rotor

__all__ = ["CoefficientRotor", "CoefficientTable", "Rotor", "read_coefficients"]
