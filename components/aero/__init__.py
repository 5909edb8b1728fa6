"""Aerodynamics of rotors: coefficient tables and the rotor described by them; blade-element momentum theory."""

from fowtlib.components.aero.airfoil_models import AirfoilModel
from fowtlib.components.aero.bem import BladeElementRotor
from fowtlib.components.aero.bem_steady import RigidRotor, coefficient_table
from fowtlib.components.aero.blade_aerodynamics import Airfoil, BladeAerodynamics, read_airfoils, read_blade
from fowtlib.components.aero.blade_element_aerodynamics import BladeElementAerodynamics, node_points
from fowtlib.components.aero.coefficient_rotor import CoefficientRotor
from fowtlib.components.aero.coefficient_table import CoefficientTable, read_coefficients, write_coefficients
from fowtlib.components.aero.dynamic_inflow import DynamicInflow
from fowtlib.components.aero.effective_wind_rotor import EffectiveWindRotor
from fowtlib.components.aero.load_slopes import LoadSlopes, load_slopes, read_load_slopes, write_load_slopes
from fowtlib.components.aero.rotor import Rotor
from fowtlib.components.aero.rotor_side import RotorSide
from fowtlib.components.aero.thrust_curve import ThrustCurve, read_thrust_curve
from fowtlib.components.aero.thrust_rotor import ThrustRotor
from fowtlib.components.aero.tower_flow import TowerDrag, TowerFlow, TowerPotentialFlow, TowerShadow
from fowtlib.components.aero.unsteady_airfoils import (
    AIRFOIL_MODELS,
    AttachedFlow,
    BeddoesLeishman,
    OyeStall,
    UnsteadyAirfoil,
)

__all__ = [
    "AIRFOIL_MODELS",
    "Airfoil",
    "AirfoilModel",
    "AttachedFlow",
    "BeddoesLeishman",
    "BladeAerodynamics",
    "BladeElementAerodynamics",
    "BladeElementRotor",
    "CoefficientRotor",
    "CoefficientTable",
    "DynamicInflow",
    "EffectiveWindRotor",
    "LoadSlopes",
    "OyeStall",
    "RigidRotor",
    "Rotor",
    "RotorSide",
    "ThrustCurve",
    "ThrustRotor",
    "TowerDrag",
    "TowerFlow",
    "TowerPotentialFlow",
    "TowerShadow",
    "UnsteadyAirfoil",
    "coefficient_table",
    "load_slopes",
    "node_points",
    "read_airfoils",
    "read_blade",
    "read_coefficients",
    "read_load_slopes",
    "read_thrust_curve",
    "write_coefficients",
    "write_load_slopes",
]
