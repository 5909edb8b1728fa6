"""Where the flow separates from an airfoil, from its polar by Kirchhoff's theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.components.aero.blade_aerodynamics import Airfoil
from fowtlib.components.aero.monotone_cubics import monotone_cubics

NEAR = np.radians(20.0)  # the lift rises through zero within this of 0 deg
WINDOW = np.radians(5.0)  # over which the slope of the lift is measured
ATTACHED = np.radians(3.0)  # the flow is attached within this of zero lift, where quotients would be of small numbers
LEAST_SLOPE = 1.0  # [1/rad]: below it a section is no airfoil: a cylinder at the blade root


@dataclass(frozen=True, eq=False)
class Separation:
    """Attached and separated flow of one airfoil.

    lifts: whether it is an airfoil; the rest counts then. lift_slope k [1/rad]: that of the steepest straight line
    through two points of the lift 5 deg apart, the lower of them from 0 to 5 deg above the angle nearest to 0 deg where
    the lift rises through zero; zero_lift a_0 [rad]: where this line is zero; zero_lift_drag: the drag there. place f
    (n,): 1 attached, 0 fully separated, at the angles of the polar, by Kirchhoff, c_l = k (a - a_0)
    ((1 + sqrt(f)) / 2)^2, between 0 and 1; it is 1 within 3 deg of a_0, and 0 from the first angle on either side on
    where it becomes 0. separated (n,): c_l,fs with c_l = f k (a - a_0) + (1 - f) c_l,fs. cubics (n - 1, 5, 4): of the
    polar, f and c_l,fs, by power of (angle - knot), monotone between the angles.
    """

    lifts: bool
    zero_lift: float
    lift_slope: float
    zero_lift_drag: float
    place: np.ndarray
    separated: np.ndarray
    cubics: np.ndarray


def separation(foil: Airfoil) -> Separation:
    """Fitted to the polar."""
    angle, lift = foil.angle, foil.coefficients[:, 0]
    zero, slope = _attached(foil)
    lifts = slope > 0
    place = _place(foil, zero, slope) if lifts else np.ones_like(angle)
    s, line = np.sqrt(place), slope * (angle - zero)
    # (c_l - f line) / (1 - f) without its quotient of zeros; where the polar lies above the line, half of it
    between = line * (1 + 3 * s) / (4 * (1 + s))
    separated = np.where(place >= 1, lift / 2, np.where(place <= 0, lift, between))
    more = monotone_cubics(angle, np.column_stack([place, separated]))
    drag = float(foil.at(zero)[1])
    return Separation(lifts, zero, slope, drag, place, separated, np.concatenate([foil.cubics, more], axis=1))


def _attached(foil: Airfoil) -> tuple[float, float]:
    """Angle of zero lift and slope; slope 0 where the lift does not rise through zero near 0 deg."""
    angle = np.unique(np.concatenate([foil.angle[np.abs(foil.angle) <= NEAR], np.linspace(-NEAR, NEAR, 161)]))
    lift = foil.at(angle)[:, 0]
    rises = np.flatnonzero((lift[:-1] < 0) & (lift[1:] >= 0))
    if not rises.size:
        return 0.0, 0.0
    i = rises[np.argmin(np.abs(angle[rises] + angle[rises + 1]))]
    rise = lift[i + 1] - lift[i]
    low = angle[i] - lift[i] * (angle[i + 1] - angle[i]) / rise + np.linspace(0, WINDOW, 21)
    at_low, at_high = (foil.at(some)[:, 0] for some in (low, low + WINDOW))
    slopes = (at_high - at_low) / WINDOW
    best = int(slopes.argmax())
    if slopes[best] < LEAST_SLOPE:
        return 0.0, 0.0
    return float(low[best] - at_low[best] / slopes[best]), float(slopes[best])


def _place(foil: Airfoil, zero: float, slope: float) -> np.ndarray:
    away = foil.angle - zero
    near = np.abs(away) < ATTACHED
    ratio = np.where(near, 1.0, foil.coefficients[:, 0] / np.where(near, 1.0, slope * away))
    place = np.clip(2 * np.sqrt(np.maximum(ratio, 0)) - 1, 0, 1) ** 2
    for side in (away >= 0, away < 0):
        order = np.flatnonzero(side)[np.argsort(np.abs(away[side]))]
        gone = np.flatnonzero(place[order] <= 0)
        place[order[gone[0] :] if gone.size else order[:0]] = 0.0
    return place
