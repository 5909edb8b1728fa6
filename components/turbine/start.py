"""Where the simulation of a turbine starts: steady operation in the mean wind."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache
from math import cos, sin
from typing import TYPE_CHECKING, Any, Protocol

from fowtlib.components.mechanics.attitude import heading_at_start
from fowtlib.components.servo import TorqueController, TorqueLaw
from fowtlib.components.turbine.idling import idling_speed_of
from fowtlib.components.turbine.operating_point import STANDSTILL, OperatingPoint, SteadyTurbine
from fowtlib.language import Component
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.language.expressions import value_of

if TYPE_CHECKING:
    from fowtlib.components.environment.wind import Wind


class InTheWind(Protocol):
    """A turbine that knows its wind and its steady operation."""

    wind: Wind
    label: str
    parts: dict[str, Component]

    def parameter_value(self, name: str) -> Any:
        """The value that a parameter has now."""

    @property
    def carrier(self) -> tuple[Component, str]:
        """The part and its frame that the shaft is fixed to."""

    def steady_turbine(self) -> SteadyTurbine:
        """Rotor and controller as numbers."""


def start_point(turbine: InTheWind, station: int) -> OperatingPoint:
    """Steady operation in the mean wind of the rotor's station, as far as it blows along the shaft.

    The shaft is turned as joints, links and a constant yaw command turn it at the start; see heading_at_start.
    Standstill without wind or loads of the air, in wind from the side or behind, and at feather where it is idling:
    there rotors of blade elements have their idling speed, those of coefficients start at standstill.
    """
    return value_of(turbine, f"start at station {station}", lambda: _start_point(turbine, station))


def _start_point(turbine: InTheWind, station: int) -> OperatingPoint:
    wind = turbine.wind
    mean = wind.mean_at(station)  # refuses a station that does not exist
    if not turbine.parameter_value("air_loads"):
        return STANDSTILL
    askew = wind.parameter_value("direction") - heading_at_start(*turbine.carrier)
    safety = turbine.parts.get("safety")
    if safety is not None and safety.parameter_value("idling"):
        pitch, blows, speed = safety.parameter_value("feather_pitch"), (mean * cos(askew), mean * sin(askew), 0.0), 0.0
        if "aerodynamics" in turbine.parts:
            speed = idling_speed_of(turbine, blows, pitch)
        return replace(STANDSTILL, rotor_speed=speed, blade_pitch=pitch)
    along = mean * cos(askew)
    if along <= 1e-12 * abs(mean):  # a direction of 90 deg is no round number
        return STANDSTILL
    steady = turbine.steady_turbine()
    try:
        return _operating_point(steady, along)
    except ModelError as error:
        raise error.at(turbine.label) from None


@lru_cache(maxsize=16)
def _operating_point(steady: SteadyTurbine, wind_speed: float) -> OperatingPoint:
    """Remembered, because every start value of a turbine asks for it."""
    return steady.operating_point(wind_speed)


def give_default(component: Component, name: str, value: object) -> None:
    """Set a parameter that the component has, and that nobody has given."""
    if name in component.parameters and not component.is_set(name):
        setattr(component, name, value)


def controlled(turbine: Any) -> dict[str, Any]:
    """What a turbine's controller and air are to its steady operation: arguments of SteadyTurbine."""
    torque, pitch = (turbine.control.parts.get(name) for name in ("torque", "pitch"))
    if not isinstance(torque, TorqueController) or "least_pitch" not in getattr(pitch, "parameters", ()):
        raise unknown_start(turbine)
    return {
        "law": TorqueLaw(**{field.name: torque.parameter_value(field.name) for field in fields(TorqueLaw)}),
        "least_pitch": pitch.parameter_value("least_pitch"),
        "air_density": turbine.world.parameter_value("air_density"),
    }


def unknown_start(turbine: Any) -> ParameterError:
    """The error of a turbine whose steady operation cannot be computed."""
    return ParameterError(
        f"{turbine.label}: with this rotor or controller give rotor_speed_start and blade_pitch_start."
    )
