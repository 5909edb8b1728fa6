"""The thrust coefficient of an operating turbine over the wind: reader and checks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.language.data_files import number_rows, remembered
from fowtlib.language.errors import ParameterError

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

    def _wrong(self, message: str) -> ParameterError:
        return ParameterError(message, where=self.where)


@remembered()
def read_thrust_curve(path: str) -> ThrustCurve:
    """Read a CSV with the columns of COLUMNS; lines that start with # are comments. Raises ParameterError."""
    values = np.array(number_rows(path, COLUMNS, "the thrust curve")).reshape(-1, len(COLUMNS))
    return ThrustCurve(values[:, 0], values[:, 1], where=path)
