"""Turbines made of rotor, drive train, generator and controller, and their steady operation."""

from fowtlib.components.turbine.operating_point import OperatingPoint, SteadyTurbine
from fowtlib.components.turbine.rotor_nacelle import RotorNacelle, start_point, steady_turbine

__all__ = ["OperatingPoint", "RotorNacelle", "SteadyTurbine", "start_point", "steady_turbine"]
