"""Turbines: blades, hub, nacelle, drive train, controller, and their steady operation."""

from fowtlib.components.turbine.actuators import ActuatedBearing
from fowtlib.components.turbine.blade import Blade, FlexibleBlade, RigidBlade
from fowtlib.components.turbine.hub import BladeMount, Hub
from fowtlib.components.turbine.nacelle import Drivetrain, Nacelle
from fowtlib.components.turbine.operating_point import OperatingPoint, SteadyTurbine
from fowtlib.components.turbine.rotor_nacelle import RotorNacelle
from fowtlib.components.turbine.rotor_nacelle_assembly import RotorNacelleAssembly
from fowtlib.components.turbine.start import start_point
from fowtlib.components.turbine.thrust_turbine import ThrustTurbine
from fowtlib.components.turbine.turbine import Turbine

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
    "ThrustTurbine",
    "Turbine",
    "start_point",
]
