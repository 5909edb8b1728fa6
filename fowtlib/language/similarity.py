"""Froude similarity: what a quantity is multiplied with when a model is made larger or smaller, by its dimension.

Gravity stays what it is, so lengths by L give times by sqrt(L); masses go by the density of the water and L^3. Froude
and Keulegan-Carpenter numbers stay, Reynolds numbers do not.
Source: C. Serret (2019), Development of the Deepwater Turbine Installation-Floating concept, section 5.3, tables 5.1
and 5.2, which have prototype = factor x model; here new = factor x old, in either direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.language.units import dimension


@dataclass(frozen=True)
class Similarity:
    """Ratios of the new model to the old one: of lengths, of densities, of wind speeds beside that of other speeds.

    length 1/45 makes a model of a prototype, density 1000/1025 puts it into fresh water. wind: 1 keeps the wind in
    proportion to all speeds; beta where a model's wind is adjusted so that its rotor has the right thrust (the wind
    adjustment of the source: prototype wind = sqrt(45) / beta x model wind).
    """

    length: float
    density: float = 1.0
    wind: float = 1.0

    def __post_init__(self) -> None:
        for name in ("length", "density", "wind"):
            value = getattr(self, name)
            if not (isinstance(value, (int, float)) and math.isfinite(value) and value > 0):
                raise ParameterError(f"the ratio of {name} of a scaled model is a number above 0, not {value!r}.")

    def factor(self, unit: str) -> float:
        """What a quantity in this unit is multiplied with: r^kg L^(m + 3 kg + s/2) for the exponents of its dimension.

        Electric current, temperature and the like are not scaled.
        """
        metres, kilograms, seconds = (float(exponent) for exponent in dimension(unit)[:3])
        return self.density**kilograms * self.length ** (metres + 3 * kilograms + seconds / 2)

    @property
    def wind_speed(self) -> float:
        """What a speed of the wind is multiplied with."""
        return self.factor("m/s") * self.wind

    def refuse_other_wind(self, why: str) -> None:
        """ParameterError for data of a rotor that hold where the wind is in proportion to the other speeds."""
        if self.wind != 1.0:
            raise ParameterError(f"{why}; another ratio ({self.wind:g}) makes another rotor.")

    @property
    def inverse(self) -> Similarity:
        """The way back."""
        return Similarity(1 / self.length, 1 / self.density, 1 / self.wind)


class Scalable(Protocol):
    """Data that know what they are in another scale."""

    def in_similarity(self, similarity: Similarity) -> Any:
        """The same data for a model of another scale; ParameterError where they cannot be."""
        ...


def six_by_six(unit: str, shapes: int = 0) -> np.ndarray:
    """Units (6, 6) of a matrix over three translations and three rotations, by that of its first element.

    "N/m" of a stiffness makes N/m, N and N*m; "kg" of a mass makes kg, kg*m and kg*m^2. shapes: rows and columns behind
    them of a body that deforms, whose coordinates are lengths as translations are.
    """
    lengths = ("", "*m", "*m^2")
    turns = (np.arange(6 + shapes) >= 3) & (np.arange(6 + shapes) < 6)
    return np.array([[f"{unit}{lengths[int(i) + int(j)]}" for j in turns] for i in turns])


QUANTITIES: dict[str, str] = {
    "length": "m", "significant wave height": "m", "water depth": "m", "area": "m^2", "volume": "m^3", "time": "s",
    "peak period": "s", "frequency": "Hz", "acceleration": "m/s^2", "angle": "rad", "mass": "kg", "force": "N",
    "moment": "N*m", "mass moment of inertia": "kg*m^2", "area moment": "m^4", "water velocity": "m/s",
    "stress": "Pa", "power": "W", "linear stiffness": "N/m", "angular stiffness": "N*m/rad",
    "linear damping": "N*s/m", "rotational damping": "N*m*s/rad", "mass per length": "kg/m", "axial stiffness": "N",
    "spectral density of elevation": "m^2*s",
}  # fmt: skip
"""What a table of factors shows: name and unit. Beside them it has wind speed and thrust coefficient."""


def factors(similarity: Similarity) -> dict[str, float]:
    """Name -> factor of the quantities of a tank test, new = factor x old.

    "thrust coefficient" is that of a rotor whose area and air are not scaled: thrust over the square of the wind. The
    source prints it as r L^2 beta^2, with beta = 1 / wind from model to prototype.
    """
    found = {name: similarity.factor(unit) for name, unit in QUANTITIES.items()}
    wind = similarity.wind_speed
    return {**found, "wind speed": wind, "thrust coefficient": similarity.factor("N") / wind**2}
