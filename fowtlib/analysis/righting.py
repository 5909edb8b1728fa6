"""Righting arms over heel, with the hull free to sink and trim, and what they say of its stability.

The hull leans by the angle phi towards one side and is held there; sinkage, and the trim across that, are what they
come to. GZ = dPhi/dphi / (M g) of the potential Phi of weight and buoyancy (`afloat`), so that the area below the
moments is the energy that heeling takes. For upright walls GZ = sin(phi) (GM + BM tan(phi)^2 / 2) without trim.
Source: K.J. Rawson and E.C. Tupper, Basic Ship Theory (2001), 4.3 and 4.6; the area criterion: IMO MODU Code (2009),
3.3: for units on columns the area below the righting moments is 1.3 times that of the wind or more, up to the second
intercept or the angle at which it floods.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.analysis.afloat import FARTHEST, LIMIT, UPRIGHT, Afloat
from fowtlib.language.errors import ParameterError
from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

WANTED = 1.3  # area below the righting moments over that below those of the wind


@dataclass(frozen=True, eq=False)
class WindArea:
    """Areas [J] below the moments of righting and of the wind from upright to `end` [rad]; first and second intercept.

    second: NaN where the wind does not come up to the righting moments again, within the curve.
    """

    righting: float
    wind: float
    end: float
    first: float
    second: float

    @property
    def ratio(self) -> float:
        """Of the areas; WANTED or more is enough."""
        return self.righting / self.wind

    @property
    def enough(self) -> bool:
        """Whether the ratio is WANTED or more."""
        return self.ratio >= WANTED


@dataclass(frozen=True, eq=False)
class RightingCurve:
    """Over heel (n,) [rad]: arm GZ [m], trim [rad], draft of the deepest point [m]; displacement [kg].

    towards [rad]: the side to which it leans, from x to y in the hull. metacentric_height [m]: upright, the slope.
    """

    heel: Floats
    arm: Floats
    trim: Floats
    draft: Floats
    mass: float
    gravity: float
    towards: float
    metacentric_height: float

    @property
    def moment(self) -> Floats:
        """Righting moments (n,) [N m]."""
        return self.mass * self.gravity * self.arm

    @property
    def largest(self) -> tuple[float, float]:
        """The heel [rad] with the largest arm, and that arm [m]."""
        fine = np.linspace(self.heel[0], self.heel[-1], 2001)
        values = self._spline(self.arm)(fine)
        k = int(np.argmax(values))
        return float(fine[k]), float(values[k])

    @property
    def vanishing(self) -> float:
        """The first heel [rad] above zero from which it does not come back; NaN where there is none in the curve."""
        roots = [r for r in self._spline(self.arm).roots(extrapolate=False) if r > 1e-6]
        return float(min(roots)) if roots and self.metacentric_height > 0 else math.nan

    def area(self, end: float) -> float:
        """Energy [J] that heeling from upright to `end` [rad] takes."""
        self._check(end)
        return float(self._spline(self.moment).integrate(0.0, end))

    def wind_area(self, force: float, lever: float, flooding: float = math.inf) -> WindArea:
        """The areas with a wind moment force x lever x cos(heel)^2 [N, m] up to the second intercept.

        flooding [rad]: heel at which water comes in, where the areas end at the latest. Raises ParameterError where the
        wind turns it over, that is, no heel has as large a righting moment.
        """
        wind = force * lever * np.cos(self.heel) ** 2
        if not force * lever > 0:
            raise ParameterError("the wind needs a force and a lever above zero for its moment to be compared.")
        roots = sorted(float(r) for r in self._spline(self.moment - wind).roots(extrapolate=False))
        if not roots:
            raise ParameterError(
                f"the wind moment of {force * lever:.4g} N m is above all righting moments up to "
                f"{math.degrees(self.heel[-1]):.3g} deg, {self.moment.max():.4g} N m at most: it turns over."
            )
        second = roots[1] if len(roots) > 1 else math.nan
        end = min(second if len(roots) > 1 else float(self.heel[-1]), flooding)
        self._check(end)
        blown = force * lever * (end / 2 + math.sin(2 * end) / 4)
        return WindArea(self.area(end), blown, end, roots[0], second)

    def _check(self, end: float) -> None:
        if not 0 < end <= self.heel[-1] * (1 + 1e-9):
            raise ParameterError(
                f"{math.degrees(end):.4g} deg is not on the curve, which goes to {math.degrees(self.heel[-1]):.4g} deg."
            )

    def _spline(self, values: Floats):
        from scipy.interpolate import CubicSpline  # slow to import

        return CubicSpline(self.heel, values)

    def rows(self) -> list[tuple[float, ...]]:
        """Heel [deg], arm [m], righting moment [N m], trim [deg], draft [m]."""
        return [
            (math.degrees(heel), arm, moment, math.degrees(trim), draft)
            for heel, arm, moment, trim, draft in zip(
                self.heel.tolist(), self.arm.tolist(), self.moment.tolist(), self.trim.tolist(), self.draft.tolist(),
                strict=True,
            )
        ]  # fmt: skip

    def plot(self, path: str | Path | None = None, title: str = "", wind: tuple[float, float] | None = None) -> Figure:
        """Arms over heel, with the slope that GM gives them; wind: force [N] and lever [m], drawn as its arm."""
        degrees = np.degrees(self.heel)
        fine = np.linspace(self.heel[0], self.heel[-1], 400)
        with drawing_style():
            figure = drawing(7.0, 4.2)
            axis = figure.subplots()
            axis.axhline(0, color=INK, lw=0.8)
            arms = self._spline(self.arm)(fine)
            axis.plot(np.degrees(fine), arms, color=COLORS[0], label="righting arm")
            axis.plot(degrees, self.arm, "o", color=COLORS[0], ms=3)
            reach = min(math.radians(57.3), float(self.heel[-1]))
            slope = np.array([0.0, reach])
            axis.plot(np.degrees(slope), self.metacentric_height * slope, "--", color=COLORS[1], lw=1,
                      label=f"slope GM = {self.metacentric_height:.3g} m")  # fmt: skip
            if wind is not None:
                blown = wind[0] * wind[1] * np.cos(fine) ** 2 / (self.mass * self.gravity)
                axis.plot(np.degrees(fine), blown, color=COLORS[2], label="arm of the wind")
            low, high = min(0.0, float(arms.min())), max(float(arms.max()), 1e-9)
            axis.set_ylim(1.1 * low - 0.02 * (high - low), 1.25 * high)
            axis.set_xlim(float(degrees[0]), float(degrees[-1]))
            axis.set_xlabel("heel [deg]")
            axis.set_ylabel("righting arm GZ [m]")
            axis.legend(frameon=False)
            if title:
                axis.set_title(title)
            if path is not None:
                save_figure(figure, path)
        return figure


def righting_curve(hull: Afloat, heels: ArrayLike, towards: float = 0.0, free_to_trim: bool = True) -> RightingCurve:
    """The righting arms of a hull at heels [rad] that go up from zero.

    towards [rad]: the direction in the hull, from x to y, that goes down; 0 is as pitch, pi/2 against roll.
    """
    phi = np.asarray(heels, dtype=float)
    if phi.ndim != 1 or len(phi) < 4 or abs(phi[0]) > 1e-12 or (np.diff(phi) <= 0).any() or phi[-1] > math.pi + 1e-9:
        raise ParameterError("heels must be four angles or more that go up from 0 to 180 deg at most.")
    down = np.array([math.cos(towards), math.sin(towards), 0.0])
    side = np.array([-down[1], down[0], 0.0])
    arms, trims, drafts, trim = [], [], [], 0.0
    for angle in phi:
        lean = math.cos(angle) * UPRIGHT - math.sin(angle) * down
        if free_to_trim:
            trim = _trimmed(hull, lean, side, trim)
        n = math.cos(trim) * lean + math.sin(trim) * side
        turn = -math.cos(trim) * (math.sin(angle) * UPRIGHT + math.cos(angle) * down)
        _, height, gradient, _ = hull.state(n)
        arms.append(float(gradient @ turn) / hull.total_mass)
        trims.append(trim)
        drafts.append(hull.depth(n, height))
    found = np.array(arms), np.array(trims), np.array(drafts)
    upright = hull.at(UPRIGHT)
    direction = upright.across.T @ down
    GM = float(direction @ upright.metacentric @ direction)
    return RightingCurve(phi, *found, hull.total_mass, hull.gravity, towards, GM)


def _trimmed(hull: Afloat, lean: Floats, side: Floats, trim: float) -> float:
    """The trim [rad] at which nothing turns the hull about the direction in which it leans, from one nearby."""
    size = float(np.cbrt(hull.surface.whole[0, 0]))
    for _ in range(LIMIT):
        n = math.cos(trim) * lean + math.sin(trim) * side
        along = math.cos(trim) * side - math.sin(trim) * lean
        _, _, gradient, slopes = hull.state(n)
        push, stiff = float(along @ gradient), float(along @ slopes @ along - n @ gradient)
        if abs(push) < 1e-11 * size * hull.total_mass:
            return trim
        step = -push / stiff if stiff > 0 else -math.copysign(0.05, push)
        trim += max(-FARTHEST / 2, min(FARTHEST / 2, step))
    raise ParameterError(f"{hull.name}: no trim holds it at this heel; take smaller heels, or hold the trim.")
