"""The water at the strips of a part of a hull: signals of its waves, and their slopes by places and widths. NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fowtlib.components.environment.waves import WaveComponents
from fowtlib.components.hydro.hull_part import Complexes, Floats, HullPart, diffraction_coefficient, diffraction_slope
from fowtlib.components.hydro.hull_part_slopes import HullPartSlopes, Tangent


@dataclass(frozen=True)
class WaterAtStrips:
    """Velocity of the water at the strips and the keel of a part, or acceleration as they feel it, per unit amplitude.

    Signals (n, 3 k): x of all k places, then y, then z; see HullPart. They follow from the waves, and from numbers of
    the part: places (k, 3), and for the acceleration diameters there (k,) and the added mass coefficient, one after the
    other.
    """

    what: Literal["velocity", "acceleration"]

    def __call__(self, waves: WaveComponents, part: Any) -> Complexes:
        return _in_columns(getattr(part.numbers(), self.what)(waves))

    def numbers(self, part: Any) -> Floats:
        """Those of the part that the signals follow from."""
        found: HullPart = part.numbers()
        places = found.places.ravel()
        return places if self.what == "velocity" else np.concatenate([places, found.widths, [found.added]])

    def number_slopes(self, part: Any, tangent: Tangent) -> Floats:
        """Changes (their count, m) of these numbers, where the parameters of the part change by tangents."""
        found = HullPartSlopes.along(part.numbers(), part, tangent)
        return found.places if self.what == "velocity" else np.vstack([found.places, found.widths, found.added])

    def slopes(self, waves: WaveComponents, part: Any, moved: Floats) -> Complexes:
        """Slopes (m, n, 3 k) of the signals along m changes of these numbers (m, their count)."""
        found: HullPart = part.numbers()
        count = len(found.places)
        places = moved[:, : 3 * count].reshape(-1, count, 3)
        slope = _of_velocity(waves, found.velocity(waves), places)
        if self.what == "acceleration":
            ka, added = waves.wave_number[:, None] * found.widths / 2, 1 + found.added
            slope *= 1j * waves.omega[:, None, None]
            slope[..., :2] *= (diffraction_coefficient(ka) / added)[..., None]
            widths, mass = moved[:, None, 3 * count : 4 * count], moved[:, None, 4 * count :]
            change = diffraction_slope(ka) * (waves.wave_number[:, None] / 2) * widths - mass / added
            slope[..., :2] += found.acceleration(waves)[..., :2] * change[..., None]
        return _in_columns(slope)


def _of_velocity(waves: WaveComponents, velocity: Complexes, places: Floats) -> Complexes:
    """Slopes (m, n, k, 3) of the velocity (n, k, 3) below the still water level along changes of places (m, k, 3)."""
    x, y, number = np.cos(waves.heading), np.sin(waves.heading), 1j * waves.wave_number[:, None]
    along, up = number * (velocity[..., 0] * x + velocity[..., 1] * y), -number * velocity[..., 2]
    slope = places[:, None, :, 2, None] * np.stack([up * x, up * y, along], axis=-1)
    downwave = places[..., 0] * x + places[..., 1] * y
    return slope - downwave[:, None, :, None] * (number[..., None] * velocity) if downwave.any() else slope


def _in_columns(values: Complexes) -> Complexes:
    """Vectors (..., n, k, 3) as columns (..., n, 3 k)."""
    return np.moveaxis(values, -1, -2).reshape(*values.shape[:-2], -1)
