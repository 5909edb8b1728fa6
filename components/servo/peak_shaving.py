"""Peak shaving: a least blade pitch that keeps the thrust of a rotor down near rated wind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtlib.language import (
    Component,
    Data,
    RealInput,
    RealOutput,
    Scalar,
    data,
    der,
    eq,
    initial,
    param,
    port,
    table1d,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.data_files import number_rows, remembered
from fowtlib.language.errors import ParameterError
from fowtlib.language.whole_files import write_text

COLUMNS = ("generator_power_kW", "least_pitch_deg")


@dataclass(frozen=True, eq=False)
class LeastPitch:
    """Least blade pitch [rad] over the mechanical power of the generator [W], which rises; (n,) each, n from 2 on."""

    power: np.ndarray
    pitch: np.ndarray
    where: str = ""

    def __post_init__(self):
        power, pitch = (np.asarray(values, dtype=float) for values in (self.power, self.pitch))
        object.__setattr__(self, "power", power)
        object.__setattr__(self, "pitch", pitch)
        fits = power.ndim == 1 and power.shape == pitch.shape and len(power) > 1
        if not fits or not np.all(np.isfinite([power, pitch])) or np.any(np.diff(power) <= 0):
            raise ParameterError("peak shaving has a least pitch at two or more rising powers.", where=self.where)

    def write(self, path: str | Path, about: Sequence[str] = ()) -> None:
        """Write the CSV that read_least_pitch reads; about: lines of comment."""
        points = zip(self.power / 1e3, np.degrees(self.pitch), strict=True)
        rows = [f"{power:.6g},{pitch:.6g}" for power, pitch in points]
        write_text(path, "\n".join([*(f"# {line}" for line in about), ",".join(COLUMNS), *rows]) + "\n")


@remembered()
def read_least_pitch(path: str) -> LeastPitch:
    """Read a CSV with the columns of COLUMNS; lines that start with # are comments. Raises ParameterError."""
    values = np.array(number_rows(path, COLUMNS, "the least pitch")).reshape(-1, len(COLUMNS))
    return LeastPitch(1e3 * values[:, 0], np.radians(values[:, 1]), where=path)


class PeakShaving(Component):
    """A least blade pitch by the filtered power of the generator, added to the lower limit of the pitch controller.

    Below rated wind the power says how hard it blows. Beyond its table the pitch stays as at its end, so that above
    rated wind, where the controller pitches further, there is nothing to be shaved. ROSCO has the same over an
    estimated wind (N. Abbas et al., Wind Energ. Sci. 7 (2022) 53, section 2.4).
    """

    table: Data[LeastPitch] = data(read_least_pitch, doc="CSV of `fowt tune --peak-shaving`, see read_least_pitch")
    filter_time: Scalar = param(default=5.0, unit="s", min=1e-3, doc="time constant of the filter of the power")

    speed: RealInput = port(unit="rad/s", doc="filtered generator speed")
    torque: RealInput = port(unit="N*m", doc="generator torque")
    raised: RealOutput = port(unit="rad", doc="what the lower limit of the pitch is raised by")

    power: Scalar = var(unit="W", state="prefer", doc="filtered mechanical power of the generator")

    def equations(self):
        table, now = self.table, self.speed * self.torque
        inside = m.fmin(m.fmax(self.power, float(table.power[0])), float(table.power[-1]))
        names = {"name": f"least pitch of {self.path}", "argument": "power [W]", "smoothness": "c1"}
        return [
            eq(self.filter_time * der(self.power), now - self.power),
            eq(self.raised, table1d(inside, table.power, table.pitch, **names)),
            initial(self.power, now),
        ]
