"""The thrust coefficient of an operating turbine over the wind: reader and checks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.language.data_files import number_rows, remembered
from fowtlib.language.errors import ParameterError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.language.similarity import Similarity

COLUMNS = ("wind_speed_m_s", "thrust_coefficient")


@dataclass(frozen=True, eq=False)
class ThrustCurve:
    """C_t over the wind speed [m/s], which rises; (n,) each, four points or more. Raises ParameterError."""

    wind_speed: np.ndarray
    thrust_coefficient: np.ndarray
    where: str = ""

    def __post_init__(self):
        wind, thrust = (np.asarray(values, dtype=float) for values in (self.wind_speed, self.thrust_coefficient))
        object.__setattr__(self, "wind_speed", wind)
        object.__setattr__(self, "thrust_coefficient", thrust)
        if wind.ndim != 1 or wind.shape != thrust.shape or len(wind) < 4:
            raise self._wrong("a thrust curve has four wind speeds or more, and a thrust coefficient at each.")
        if not (np.all(np.isfinite(wind)) and np.all(np.isfinite(thrust))):
            raise self._wrong("wind speeds and thrust coefficients must be finite numbers.")
        falls = np.flatnonzero(np.diff(wind) <= 0)
        if falls.size:
            i = falls[0]
            raise self._wrong(f"the wind speeds must rise; {wind[i]:g} m/s is followed by {wind[i + 1]:g} m/s.")

    ending = ".csv"

    def in_similarity(self, similarity: Similarity) -> ThrustCurve:
        """The winds in the other scale; where their ratio differs, coefficients that keep the thrust in proportion."""
        coefficient = self.thrust_coefficient / similarity.wind**2
        return ThrustCurve(self.wind_speed * similarity.wind_speed, coefficient, self.where)

    def write(self, path: str | Path) -> None:
        """Write a CSV that read_thrust_curve reads. Raises WriteError."""
        pairs = zip(self.wind_speed, self.thrust_coefficient, strict=True)
        write_text(path, "\n".join([",".join(COLUMNS), *(f"{v:.17g},{c:.17g}" for v, c in pairs)]) + "\n")

    def _wrong(self, message: str) -> ParameterError:
        return ParameterError(message, where=self.where)


@remembered()
def read_thrust_curve(path: str) -> ThrustCurve:
    """Read a CSV with the columns of COLUMNS; lines that start with # are comments. Raises ParameterError."""
    values = np.array(number_rows(path, COLUMNS, "the thrust curve")).reshape(-1, len(COLUMNS))
    return ThrustCurve(values[:, 0], values[:, 1], where=path)
