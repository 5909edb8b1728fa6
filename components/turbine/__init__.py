"""Turbines: blades, hub, nacelle, drive train, controller, and their steady operation."""

from fowtlib.components.turbine.actuators import ActuatedBearing
from fowtlib.components.turbine.blade import Blade, FlexibleBlade, RigidBlade
from fowtlib.components.turbine.hub import BladeMount, Hub
from fowtlib.components.turbine.nacelle import Drivetrain, Nacelle
from fowtlib.components.turbine.operating_point import OperatingPoint, SteadyTurbine
from fowtlib.components.turbine.rotor_nacelle import RotorNacelle, start_point, steady_turbine
from fowtlib.components.turbine.rotor_nacelle_assembly import RotorNacelleAssembly

__all__ = [
    "ActuatedBearing",
    "Blade",
    "BladeMount",
    "Drivetrain",
    "FlexibleBlade",
    "Hub",
    "Nacelle",
    "OperatingPoint",
    "RigidBlade",
    "RotorNacelle",
    "RotorNacelleAssembly",
    "SteadyTurbine",
    "start_point",
    "steady_turbine",
]
