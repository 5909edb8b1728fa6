"""Stress and fatigue damage around a tube, from its axial force and two bending moments.

Axes of the section: z along the tube, x and y across it. A point of the outer surface lies at the angle a from x to y:
for a tower 0 deg is downwind and 90 deg to port. Loads are those of what is on the side of +z on the rest, as the
outputs of towers are: N along z (tension positive), M_x and M_y about x and y (thrust gives a positive M_y: tension
upwind). From M = integral of r x (s e_z) over the section,

    s(a) = N/A + M_x y/I - M_y x/I,    x = R cos a,  y = R sin a,    tension positive.

Shear, torsion and hoop stresses are left out. Signs matter for Goodman's correction only: ranges do not know them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.analysis.fatigue.curves import SNCurve, in_si
from fowtlib.analysis.fatigue.cycles import rainflow_cycles
from fowtlib.analysis.series import Series, as_series
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from fowtlib.analysis.series import SeriesLike


@dataclass(frozen=True)
class TubeSection:
    """Ring of a tube, thin or thick: outer diameter and wall thickness, m (half the diameter is a full rod)."""

    outer_diameter: float
    wall_thickness: float

    def __post_init__(self) -> None:
        if not (0 < self.wall_thickness <= self.outer_diameter / 2 and math.isfinite(self.outer_diameter)):
            raise ModelError(
                f"a tube with an outer diameter of {self.outer_diameter:g} m takes a wall above 0 m and at most of "
                f"half of it, not of {self.wall_thickness:g} m."
            )

    @property
    def outer_radius(self) -> float:
        """R, m."""
        return self.outer_diameter / 2

    @property
    def inner_diameter(self) -> float:
        """Diameter of the bore, m."""
        return self.outer_diameter - 2 * self.wall_thickness

    @property
    def area(self) -> float:
        """A, m^2; as product, which keeps its digits where the wall is thin."""
        return math.pi * self.wall_thickness * (self.outer_diameter - self.wall_thickness)

    @property
    def second_moment(self) -> float:
        """I about a diameter, m^4."""
        return self.area * (self.outer_diameter**2 + self.inner_diameter**2) / 16

    @property
    def bending(self) -> float:
        """Stress at the outer surface per bending moment, R/I, Pa/(N*m)."""
        return self.outer_radius / self.second_moment

    def stress(self, axial_force: ArrayLike, moment_x: ArrayLike, moment_y: ArrayLike, angles: ArrayLike) -> np.ndarray:
        """Stress along the tube at angles [rad] of its outer surface, Pa, tension positive: (..., angles).

        axial_force N and moments N*m, numbers or arrays of one shape; axes and signs as this module says.
        """
        loads = (axial_force, moment_x, moment_y)
        force, about_x, about_y = (np.asarray(load, dtype=float)[..., None] for load in loads)
        angles = np.asarray(angles, dtype=float)
        return force / self.area + self.bending * (about_x * np.sin(angles) - about_y * np.cos(angles))


@dataclass(frozen=True)
class TubeDamage:
    """Damage (Miner sum) at points around a tube during ``duration`` s.

    angles  of the points from x to y, rad
    """

    angles: np.ndarray
    damage: np.ndarray
    duration: float
    name: str = ""

    @property
    def worst(self) -> float:
        """Largest damage."""
        return float(self.damage.max())

    @property
    def worst_angle(self) -> float:
        """Where it is, rad."""
        return float(self.angles[np.argmax(self.damage)])

    def life(self, design_fatigue_factor: float = 1.0) -> float:
        """Seconds until the worst point fails under the series again and again, over the design fatigue factor."""
        return self.duration / (self.worst * design_fatigue_factor) if self.worst > 0 else math.inf

    def plot(self, path: str | Path | None = None) -> Figure:
        """Damage over the angle, around the tube."""
        from fowtlib.analysis.fatigue.figures import plot_damage_rose

        return plot_damage_rose(self, path)


def tube_damage(
    section: TubeSection,
    curve: SNCurve,
    moment_x: SeriesLike,
    moment_y: SeriesLike,
    axial_force: SeriesLike | None = None,
    *,
    points: int = 24,
    discard: float = 0.0,
    ultimate: float | None = None,
) -> TubeDamage:
    """Damage at points around a tube by rainflow counting of the stress there.

    section      outer diameter and wall
    curve        S-N curve; for its correction of thickness take sn_curve(..., thickness=section.wall_thickness)
    moment_x     about x (side-side of a tower), ``result["tower_base_side_side_moment"]`` or (time, values in N*m)
    moment_y     about y (fore-aft of a tower)
    axial_force  along z, tension positive; None: it does not change
    points       number of points, the first on the axis x
    discard      seconds left out at the beginning
    ultimate     strength for Goodman's correction to a mean of 0, Pa; None for none
    """
    if int(points) != points or points < 1:
        raise ModelError(f"damage is computed at 1, 2, 3 ... points around a tube, not at {points:g}.")
    about_x, about_y = (_in_si(load, "N*m", "moments", discard) for load in (moment_x, moment_y))
    force = None if axial_force is None else _in_si(axial_force, "N", "an axial force", discard)
    for other in filter(None, (about_y, force)):
        if other.time.shape != about_x.time.shape or not np.allclose(other.time, about_x.time, rtol=0, atol=1e-6):
            raise ModelError(f"{other.name} and {about_x.name} have different points of time; take them from one run.")
    angles = 2 * np.pi * np.arange(int(points)) / points
    pull = np.zeros_like(about_x.values) if force is None else force.values
    stress = section.stress(pull, about_x.values, about_y.values, angles)
    damage = np.empty(angles.size)
    for number, values in enumerate(stress.T):
        label = f"the stress at {math.degrees(angles[number]):g} deg"
        cycles = rainflow_cycles(Series(about_x.time, values, "Pa", label))
        damage[number] = curve.damage(cycles if ultimate is None else cycles.goodman(ultimate))
    return TubeDamage(angles, damage, float(about_x.time[-1] - about_x.time[0]), about_y.name)


def _in_si(load: SeriesLike, unit: str, what: str, discard: float) -> Series:
    record = as_series(load).after(discard)
    return Series(
        record.time, record.values * in_si(record.unit, unit, record.name, f"a tube takes {what}"), unit, record.name
    )  # fmt: skip
