"""The thrust coefficient of an operating turbine over the wind: reader and checks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.language.data_files import cells_of, lines_of, remembered
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
    lines = lines_of(path, "the thrust curve")
    header = cells_of(lines[0][1]) if lines else []
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        found = f"there are {', '.join(header)}" if header else "the file is empty"
        raise ParameterError(f"column {missing[0]} is missing; {found}.", where=path)
    rows = []
    for number, line in lines[1:]:
        cells = dict(zip(header, cells_of(line), strict=False))
        try:
            rows.append([float(cells[name]) for name in COLUMNS])
        except (KeyError, ValueError):
            words = f"'{line.strip()}' is not a row of numbers under {', '.join(header)}."
            raise ParameterError(words, where=f"{path}:{number}") from None
    values = np.array(rows).reshape(-1, len(COLUMNS))
    return ThrustCurve(values[:, 0], values[:, 1], where=path)
