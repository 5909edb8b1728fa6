"""Steady rotor coefficients over tip speed ratio and collective blade pitch: reader, checks, numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.cubics import CubicSurface
from fowtlib.language.data_files import number_rows, remembered
from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.language.similarity import Similarity

COLUMNS = ("tip_speed_ratio", "blade_pitch_deg", "thrust_coefficient", "torque_coefficient")
REMEDY = "give a table that covers the state (`fowt rotor-table` makes one from the blades), or start elsewhere"
LARGEST_RATIO = 25.0
"""Largest tip speed ratio of an extended table; above, the estimate is no good: such a table comes from the blades."""


@dataclass(frozen=True, eq=False)
class CoefficientTable:
    """C_t and C_q of a rotor: thrust = 1/2 rho A C_t U^2, torque = 1/2 rho A R C_q U^2.

    tip_speed_ratio (n,) and blade_pitch (m,) [rad] increase; thrust and torque coefficients are (n, m).
    """

    tip_speed_ratio: np.ndarray
    blade_pitch: np.ndarray
    thrust: np.ndarray
    torque: np.ndarray

    @property
    def values(self) -> np.ndarray:
        """Both coefficients, (n, m, 2): C_t, C_q."""
        return np.stack([self.thrust, self.torque], axis=-1)

    def __call__(self, tip_speed_ratio: Any, blade_pitch: Any) -> tuple[Any, Any]:
        """(C_t, C_q) by the same cubic spline as in a simulation; NumPy. Raises ModelError outside of the table."""
        for name, values, grid, scale in (
            ("tip speed ratio", tip_speed_ratio, self.tip_speed_ratio, 1.0),
            ("blade pitch [deg]", blade_pitch, self.blade_pitch, 180 / np.pi),
        ):
            low, high = grid[0] - 1e-9, grid[-1] + 1e-9
            outside = ~((np.asarray(values) >= low) & (np.asarray(values) <= high))
            if np.any(outside):
                value = scale * float(np.broadcast_to(values, outside.shape)[outside][0])
                raise ModelError(
                    f"the rotor coefficients cover {name} {scale * low:.4g} to {scale * high:.4g}, and not "
                    f"{value:.4g}; {REMEDY}."
                )
        thrust, torque = _splines(self)
        return thrust(tip_speed_ratio, blade_pitch), torque(tip_speed_ratio, blade_pitch)

    def in_similarity(self, similarity: Similarity) -> CoefficientTable:
        """The same: coefficients over the tip speed ratio have no dimension, and it stays where the wind does."""
        why = "coefficients over the tip speed ratio hold for a wind in proportion to the other speeds"
        similarity.refuse_other_wind(why)
        return self

    def extended(self) -> CoefficientTable:
        """The table continued to LARGEST_RATIO, an estimate for overspeed and for low wind.

        Above the table the blades see small inflow angles, of the size of s = 1 / tip speed ratio: linear blade element
        theory makes C_t s^2 a polynomial of first and C_q s^2 one of second degree in s; they are fitted to the last
        quarter of the rows. Nothing of the kind holds below the table and beyond its pitch angles: for rotors that
        start, idle or are parked the coefficients must come from the blades, see bem_steady.coefficient_table.
        """
        rows, pitches = self.tip_speed_ratio, self.blade_pitch
        fitted, added = rows[-max(len(rows) // 4, 4) :], np.arange(rows[-1] + 0.5, LARGEST_RATIO + 0.25, 0.5)

        def continued(values: np.ndarray, degree: int) -> np.ndarray:
            fit = np.polynomial.Polynomial
            above = np.empty((len(added), len(pitches)))
            for j, column in enumerate(values.T):
                line = fit.fit(1 / fitted, column[-len(fitted) :] / fitted**2, degree)
                above[:, j] = line(1 / added) * added**2 + column[-1] - line(1 / rows[-1]) * rows[-1] ** 2
            return np.vstack([values, above])

        speeds = np.concatenate([rows, added])
        return CoefficientTable(speeds, pitches, continued(self.thrust, 1), continued(self.torque, 2))


@lru_cache(maxsize=16)
def _splines(table: CoefficientTable) -> tuple[CubicSurface, CubicSurface]:
    grid = table.tip_speed_ratio, table.blade_pitch
    return CubicSurface(*grid, table.thrust), CubicSurface(*grid, table.torque)


@remembered()
def read_coefficients(path: str, extended: bool = False) -> CoefficientTable:
    """Read a CSV with the columns tip_speed_ratio, blade_pitch_deg, thrust_coefficient, torque_coefficient.

    Lines that start with # are comments, other columns (power_coefficient) are not read, rows may come in any order,
    and every pair of a tip speed ratio and a pitch angle must be there once. Raises ModelError with path and line.
    """
    rows = np.array(number_rows(path, COLUMNS, "the rotor coefficients", ModelError)).reshape(-1, len(COLUMNS))
    speeds, pitches = np.unique(rows[:, 0]), np.unique(rows[:, 1])
    order = np.lexsort((rows[:, 1], rows[:, 0]))
    grid = np.array([(a, b) for a in speeds for b in pitches])
    if rows.shape[0] != len(grid) or min(len(speeds), len(pitches)) < 4 or not np.allclose(rows[order, :2], grid):
        raise ModelError(
            f"{path}: {rows.shape[0]} rows do not make a full table of {len(speeds)} tip speed ratios and "
            f"{len(pitches)} pitch angles (each pair once, 4 or more of each)."
        )
    thrust, torque = (rows[order, i].reshape(len(speeds), len(pitches)) for i in (2, 3))
    table = CoefficientTable(speeds, np.radians(pitches), thrust, torque)
    return table.extended() if extended else table


def write_coefficients(path: str | Path, table: CoefficientTable, precone: float, about: Sequence[str] = ()) -> None:
    """Write a table as read_coefficients reads it, with the power coefficient as a further column.

    precone [rad] of the rotor: C_p = tip speed ratio C_q cos(precone), see CoefficientRotor. about: lines of comment.
    """
    header = ("tip_speed_ratio", "blade_pitch_deg", "power_coefficient", "thrust_coefficient", "torque_coefficient")
    lines = [*(f"# {line}" for line in about), ",".join(header)]
    for i, ratio in enumerate(table.tip_speed_ratio):
        for j, pitch in enumerate(np.degrees(table.blade_pitch)):
            torque = table.torque[i, j]
            power = ratio * torque * np.cos(precone)
            lines.append(f"{ratio:.10g},{pitch:.10g},{power:.7f},{table.thrust[i, j]:.7f},{torque:.7f}")
    write_text(path, "\n".join(lines) + "\n")
