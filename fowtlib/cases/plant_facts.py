"""What named sets of load cases need to know of a model, without compiling it."""

from __future__ import annotations

from fowtlib.components.aero import BladeElementAerodynamics, CoefficientRotor
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.solving.model import Model

SLOWEST, FASTEST = 3.0, 30.0  # wind speeds [m/s] between which the rated one is sought


def require_weather(model: Model) -> None:
    """Refuse a model without a part that load cases give their wind or their sea to, such as a turbine on land."""
    for name in ("wind", "sea"):
        if name not in model.root.parts:
            raise ParameterError(f"the model has no part '{name}', which load cases give their {name} to.")


def hub_height(model: Model) -> float:
    """Height [m] at which the mean wind of the model is given."""
    wind = model.root.parts.get("wind")
    if wind is None or "reference_height" not in wind.parameters:
        raise ParameterError("the model has no part 'wind', which load cases give their wind to.")
    return float(wind.parameter_value("reference_height"))


def idling_parameters(model: Model) -> list[str]:
    """Paths of the parameters that shut turbines down from the start."""
    return [f"{part.path}.idling" for part in model.root.walk() if "idling" in part.parameters]


def rotors_for_front_wind(model: Model) -> list[str]:
    """Paths of the rotors whose data hold for wind from the front only."""
    return [part.path for part in model.root.walk() if isinstance(part, CoefficientRotor)]


def has_blade_elements(model: Model) -> bool:
    """Whether a rotor feels the wind at the elements of its blades."""
    return any(isinstance(part, BladeElementAerodynamics) for part in model.root.walk())


def event_paths(model: Model, name: str) -> list[str]:
    """Paths of the events of this name that parts offer."""
    return [f"{part.path}.{name}" for part in model.root.walk() if name in part.offered_events]


def rated_wind_speed(model: Model) -> float | None:
    """The lowest steady wind [m/s] in which a turbine of the model pitches to hold its speed.

    None where no turbine knows its steady operation. Turbines that differ give the lowest.
    """
    found = []
    for part in model.root.walk():
        steady = getattr(type(part), "steady_turbine", None)
        if steady is None:
            continue
        try:
            turbine = steady(part)
            low, high = SLOWEST, FASTEST
            if not _pitches(turbine, high) or _pitches(turbine, low):
                continue
            while high - low > 1e-3:
                middle = (low + high) / 2
                low, high = (low, middle) if _pitches(turbine, middle) else (middle, high)
        except ModelError:
            continue
        found.append(high)
    return min(found, default=None)


def _pitches(turbine, speed: float) -> bool:
    try:
        return turbine.operating_point(speed).blade_pitch > turbine.least_pitch
    except ModelError:  # in too strong a wind there is none, in too weak a one neither
        return speed > (SLOWEST + FASTEST) / 2
