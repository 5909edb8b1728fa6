"""S-N curves of steel with one or two slopes, and Miner's sum of the damage of cycles."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.language.errors import ModelError, NotFoundError, UnitError, did_you_mean, one_of
from fowtlib.language.units import conversion, dimension, parse_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from fowtlib.analysis.fatigue.cycles import Cycles

MEGA = 1e6  # intercepts are those of stress ranges in MPa, as they are printed
# At joints of tubes (T) with a concentration of more than 10 the thickness counts with another exponent.
STEEP, STEEP_EXPONENT = 10.0, 0.30
DATA = "data/fatigue/dnv_rp_c203_2016.csv"


@dataclass(frozen=True)
class SNCurve:
    """Cycles to failure N over the stress range S: log10 N = log_a - m log10(S in MPa), with one line or two.

    Of two lines that with the smaller slope m1 holds for large ranges, and the other from where they cross.

    m1, log_a1           slope and intercept of the first line
    m2, log_a2           of the second one; None for one line
    thickness_exponent   k: a wall thicker than the reference sees stresses larger by (t / t_ref)^k
    reference_thickness  t_ref, m
    factor               what stresses are multiplied with: see with_thickness and with_concentration
    """

    m1: float
    log_a1: float
    m2: float | None = None
    log_a2: float | None = None
    thickness_exponent: float = 0.0
    reference_thickness: float = 0.025
    factor: float = 1.0
    name: str = "an S-N curve"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.log_a1) and self.m1 > 0 and self.factor > 0 and self.reference_thickness > 0):
            raise ModelError(f"{self.name}: m1, factor and reference_thickness are above 0, log_a1 is a finite number.")
        if not self.thickness_exponent >= 0:
            raise ModelError(f"{self.name}: thicker walls are not better: thickness_exponent is 0 or above.")
        if (self.m2 is None) != (self.log_a2 is None) or not math.isfinite(self.log_a2 or 0.0):
            raise ModelError(f"{self.name}: the second line takes both m2 and log_a2, finite numbers.")
        if self.m2 is not None and not self.m2 > self.m1:
            raise ModelError(
                f"{self.name}: the second slope must be larger than the first, {self.m1:g}; it is {self.m2:g}. "
                "The first line is that of large ranges."
            )

    def with_thickness(self, thickness: float) -> SNCurve:
        """The curve of a wall of this thickness, m; up to the reference thickness it is the same."""
        if not (math.isfinite(thickness) and thickness > 0):
            raise ModelError(f"{self.name}: the thickness of a wall is above 0 m, not {thickness:g} m.")
        ratio = max(thickness / self.reference_thickness, 1.0) ** self.thickness_exponent
        if ratio == 1.0:
            return self
        return replace(self, factor=self.factor * ratio, name=f"{self.name}, {1e3 * thickness:g} mm")

    def with_concentration(self, factor: float) -> SNCurve:
        """The curve for nominal stresses, where the stress at the weld is ``factor`` times as large."""
        if not (math.isfinite(factor) and factor > 0):
            raise ModelError(f"{self.name}: a stress concentration factor is above 0, not {factor:g}.")
        return replace(self, factor=self.factor * factor, name=f"{self.name}, stress x {factor:g}")

    @property
    def knee(self) -> float:
        """Stress range at which the two lines cross, Pa; 0 for one line."""
        if self.m2 is None or self.log_a2 is None:
            return 0.0
        return 10.0 ** ((self.log_a2 - self.log_a1) / (self.m2 - self.m1)) * MEGA / self.factor

    def lines(self) -> list[tuple[float, float, float, float]]:
        """The lines as (exponent m, damage per cycle over S^m with S in Pa, from S, up to S)."""
        size = self.factor / MEGA
        upper = (self.m1, size**self.m1 * 10.0**-self.log_a1, self.knee, math.inf)
        if self.m2 is None or self.log_a2 is None:
            return [upper]
        return [upper, (self.m2, size**self.m2 * 10.0**-self.log_a2, 0.0, self.knee)]

    def endurance(self, ranges: ArrayLike) -> np.ndarray:
        """Cycles to failure at these stress ranges, Pa; infinitely many at 0."""
        size = np.asarray(ranges, dtype=float) * (self.factor / MEGA)
        if not np.all(size >= 0):
            raise ModelError(f"{self.name}: stress ranges are numbers of 0 Pa or more.")
        with np.errstate(divide="ignore"):
            level = np.log10(size)
            cycles = self.log_a1 - self.m1 * level
            if self.m2 is not None and self.log_a2 is not None:  # the first line is the higher one above the knee
                cycles = np.maximum(cycles, self.log_a2 - self.m2 * level)
            return 10.0**cycles

    def damage(self, cycles: Cycles) -> float:
        """Miner's sum of the cycles of a stress: the share of the life that they use up."""
        ranges = cycles.ranges * in_si(cycles.unit, "Pa", cycles.name, "an S-N curve takes stresses")
        return float(np.sum(cycles.counts / self.endurance(ranges)))

    def plot(self, path: str | Path | None = None) -> Figure:
        """Stress range over cycles to failure."""
        from fowtlib.analysis.fatigue.figures import plot_sn_curves

        return plot_sn_curves([self], path)


def in_si(unit: str, wanted: str, name: str, because: str) -> float:
    """What a series in ``unit`` is multiplied with for the SI unit ``wanted``; without a unit ("1") it is in SI."""
    if unit in ("", "1"):
        return 1.0
    try:
        if dimension(unit) == dimension(wanted):
            return conversion(parse_unit(unit), parse_unit(wanted))
    except UnitError:
        pass
    raise ModelError(f"{name} is in {unit}; {because}, in {wanted} or a multiple of it.")


def sn_curve(
    name: str, environment: str = "air", *, thickness: float | None = None, concentration: float = 1.0
) -> SNCurve:
    """An S-N curve of DNVGL-RP-C203 (2016): ``sn_curve("D", "cathodic protection", thickness=0.06)``.

    name           B1, B2, C, C1, C2, D, E, F, F1, F3, G, W1, W2, W3; T for joints of tubes
    environment    air, cathodic protection (in seawater), free corrosion (in seawater)
    thickness      of the wall, m; None: not above the reference thickness (25 mm; 16 mm for T)
    concentration  stress concentration factor, by which nominal stresses are multiplied
    """
    curves = _read()
    kinds = list(dict.fromkeys(kind for kind, _ in curves))
    if environment not in kinds:
        raise NotFoundError(f"there is no environment '{environment}' of S-N curves; there are {one_of(kinds, 'and')}.")
    there = sn_curves(environment)
    if name not in there:
        others = did_you_mean(name, there, list_up_to=20)
        raise NotFoundError(f"there is no S-N curve '{name}' for {environment}{others}")
    curve = curves[environment, name]
    if name == "T" and concentration > STEEP:
        curve = replace(curve, thickness_exponent=STEEP_EXPONENT)
    if thickness is not None:
        curve = curve.with_thickness(thickness)
    return curve if concentration == 1.0 else curve.with_concentration(concentration)


def sn_curves(environment: str = "air") -> Sequence[str]:
    """Names of the S-N curves that there are for an environment."""
    return [name for kind, name in _read() if kind == environment]


@cache
def _read() -> dict[tuple[str, str], SNCurve]:
    """Every curve of the data file by environment and name."""
    text = resources.files("fowtlib.models").joinpath(DATA).read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    curves = {}
    for row in rows:
        second = (float(row["m2"]), float(row["log_a2"])) if row["m2"] else (None, None)
        first = float(row["m1"]), float(row["log_a1"])
        wall = float(row["thickness_exponent"]), float(row["reference_thickness"])
        name = f"{row['curve']}, {row['environment']}"
        curves[row["environment"], row["curve"]] = SNCurve(*first, *second, *wall, name=name)
    return curves
