"""Where the flow separates from an airfoil, from its polar by Kirchhoff's theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.components.aero.blade_aerodynamics import Airfoil

NEAR = np.radians(20.0)  # the lift is zero, and its slope greatest, within this of 0 deg and of zero lift
LEAST_SLOPE = 1.0  # [1/rad]: below it a section is no airfoil: a cylinder at the blade root


@dataclass(frozen=True, eq=False)
class Separation:
    """Attached and separated flow of one airfoil.

    lifts: whether it is an airfoil; the rest counts then. zero_lift a_0 [rad]: where the lift rises through zero,
    nearest to 0 deg; lift_slope k [1/rad]: the greatest c_l / (a - a_0) from 1 to 20 deg away from it, so that no
    polar exceeds the line of attached flow there; zero_lift_drag: the drag at a_0. place f (n,): 1 attached, 0 fully
    separated, at the angles of the polar, by Kirchhoff, c_l = k (a - a_0) ((1 + sqrt(f)) / 2)^2; beyond the first angle
    on either side where f is 0 it stays 0. separated (n,): c_l,fs with c_l = f k (a - a_0) + (1 - f) c_l,fs. cubics
    (n - 1, 5, 4): of the polar, f and c_l,fs, by power of (angle - knot), monotone between the angles.
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
    from scipy.interpolate import PchipInterpolator

    angle, lift = foil.angle, foil.coefficients[:, 0]
    zero, slope = _attached(foil)
    lifts = slope >= LEAST_SLOPE
    place = _place(foil, zero, slope) if lifts else np.ones_like(angle)
    s, line = np.sqrt(place), slope * (angle - zero)
    # (c_l - f line) / (1 - f) without its quotient of zeros; where the polar lies above the line, half of it
    between = line * (1 + 3 * s) / (4 * (1 + s))
    separated = np.where(place >= 1, lift / 2, np.where(place <= 0, lift, between))
    more = np.moveaxis(PchipInterpolator(angle, np.column_stack([place, separated])).c[::-1], 0, -1)
    drag = float(_value(foil, zero)[1])
    return Separation(lifts, zero, slope, drag, place, separated, np.concatenate([foil.cubics, more], axis=1))


def _value(foil: Airfoil, angle: float) -> np.ndarray:
    i = int(np.clip(np.searchsorted(foil.angle, angle, side="right") - 1, 0, len(foil.angle) - 2))
    return foil.cubics[i] @ (angle - foil.angle[i]) ** np.arange(4)


def _attached(foil: Airfoil) -> tuple[float, float]:
    """Angle of zero lift and slope; slope 0 where the lift does not rise through zero near 0 deg."""
    from scipy.optimize import brentq

    angle = np.unique(np.concatenate([foil.angle[np.abs(foil.angle) <= NEAR], np.linspace(-NEAR, NEAR, 161)]))
    lift = np.array([_value(foil, a)[0] for a in angle])
    rises = np.flatnonzero((lift[:-1] < 0) & (lift[1:] >= 0))
    if not rises.size:
        return 0.0, 0.0
    i = rises[np.argmin(np.abs(angle[rises] + angle[rises + 1]))]
    zero = float(brentq(lambda a: _value(foil, a)[0], angle[i], angle[i + 1], xtol=1e-14))
    around = zero + np.radians(np.concatenate([np.linspace(-20, -1, 153), np.linspace(1, 20, 153)]))
    ratio = np.array([_value(foil, a)[0] for a in around]) / (around - zero)
    return zero, float(ratio.max())


def _place(foil: Airfoil, zero: float, slope: float) -> np.ndarray:
    angle, lift = foil.angle, foil.coefficients[:, 0]
    away = angle - zero
    near = np.abs(away) < np.radians(0.5)  # a quotient of small numbers: there the slope at zero lift
    i = int(np.searchsorted(angle, zero, side="right") - 1)
    steepness = foil.cubics[i, 0, 1:] @ (np.arange(1, 4) * (zero - angle[i]) ** np.arange(3))
    ratio = np.where(near, steepness, lift / np.where(near, 1, away)) / slope
    place = np.clip(2 * np.sqrt(np.maximum(ratio, 0)) - 1, 0, 1) ** 2
    for side in (away >= 0, away < 0):
        order = np.flatnonzero(side)[np.argsort(np.abs(away[side]))]
        gone = np.flatnonzero(place[order] <= 0)
        place[order[gone[0] :] if gone.size else order[:0]] = 0.0
    return place
