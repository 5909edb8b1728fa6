"""Environmental contours by the inverse first-order reliability method (IFORM).

States whose standard normal variables have the distance beta from the origin are the contour; beta belongs to a return
period: Phi(-beta) = state duration / return period. S. R. Winterstein et al., Environmental parameters for extreme
response: inverse FORM with omission factors, ICOSSAR (1993).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.joint import ConditionalModel
from fowtlib.metocean.states import YEAR, States, occurrences


def radius(return_period: float, duration: float = 3600.0) -> float:
    """Beta: distance from the origin of states with a return period [years], each lasting `duration` [s]."""
    from scipy.special import ndtri

    return float(-ndtri(1 / occurrences(return_period, duration)))


def return_period(beta: float, duration: float = 3600.0) -> float:
    """Return period [years] of the contour of radius beta, for states of `duration` [s]."""
    from scipy.special import ndtr

    return float(duration / ndtr(-beta) / YEAR)


def inflated(beta: float, *, omission: float | None = None, fractile: float | None = None) -> float:
    """Radius on which the median of a response stands for its extreme, which is random in a given state too.

    omission: alpha^2 of the variable left out, the part of the response's own randomness in the distance of the design
    point; beta / sqrt(1 - alpha^2). fractile: the one that would be taken on the contour of beta instead of the median,
    usually 0.7 to 0.9.

    Take a response that is linear in the normal variables, x = cos(phi) e.z + sin(phi) z_r with a unit vector e and its
    own randomness z_r, alpha = sin(phi). Its extreme is beta. The fractile p on the contour of beta gives
    cos(phi) beta + sin(phi) z_p, the same where tan(phi / 2) = z_p / beta; the median gives it on the radius
    beta / cos(phi).
    """
    from scipy.special import ndtri

    if (omission is None) == (fractile is None):
        raise ParameterError("a contour is inflated by an omission factor or by a fractile: give one of them.")
    if omission is not None:
        if not 0 <= omission < 1:
            raise ParameterError(f"an omission factor alpha^2 is 0 or more and below 1, not {omission:g}.")
        return beta / math.sqrt(1 - omission)
    half = math.atan(float(ndtri(fractile)) / beta) if 0.5 <= fractile < 1 else math.inf
    if not half < math.pi / 4:
        raise ParameterError(
            f"a fractile that a contour of radius {beta:.4g} is inflated by is 0.5 or more, and below "
            f"the one of this radius; not {fractile:g}."
        )
    return beta / math.cos(2 * half)


def contour(
    joint: ConditionalModel, beta: float, *, points: int = 72, wind_speed: float | None = None, upper: bool = False
) -> States:
    """A contour in two dimensions.

    wind_speed None: wind speed and wave height around the whole circle, with the median peak period of each. A number
    [m/s]: wave height and peak period around the section of the surface at that wind speed. upper: the half with waves
    above their median alone.
    """
    if wind_speed is not None:
        return surface(joint, beta, wind_speeds=[wind_speed], points=points, upper=upper)
    angle = _angles(points, upper)
    z = np.stack([beta * np.sin(angle), beta * np.cos(angle), 0 * angle], axis=1)
    return _states(joint, z, upper)


def surface(
    joint: ConditionalModel,
    beta: float,
    *,
    wind_speeds: Sequence[float] | None = None,
    points: int = 24,
    upper: bool = False,
) -> States:
    """The contour surface in three dimensions: at each wind speed [m/s] a ring of wave heights and peak periods.

    points: of each ring, from the highest waves on towards longer periods. upper: of its half with waves above their
    median alone, from the shortest period to the longest. wind_speeds None: 13 of equal steps of angle, both poles
    included, of which there is one point each. Refuses a wind speed beyond the surface.
    """
    angle = _angles(points, upper)
    if wind_speeds is None:
        first = -beta * np.cos(np.linspace(0, np.pi, 13))
    else:
        given = np.atleast_1d(_positive(wind_speeds))
        first = joint.wind_speed.to_normal(given)
        far = np.abs(first) > beta * (1 + 1e-12)
        if far.any():
            low, high = joint.wind_speed.from_normal([-beta, beta])
            raise ParameterError(
                f"{given[far][0]:g} m/s is beyond the contour, whose wind speeds are {low:.3g} to {high:.4g} m/s.",
                where=joint.name,
            )
    rings = []
    for z in first:
        ring = math.sqrt(max(beta**2 - z**2, 0.0))
        if ring < 1e-7 * beta:
            rings.append([[z, 0.0, 0.0]])
        else:
            rings.append(np.stack([np.full(points, z), ring * np.cos(angle), ring * np.sin(angle)], axis=1))
    return _states(joint, np.concatenate(rings), upper)


def cut_off(joint: ConditionalModel, wind_speed: float, duration: float = 3600.0) -> tuple[float, float]:
    """Radius and return period [years] of the contour whose largest wind speed is this one, such as the cut-out speed.

    It is the rarest contour on which the turbine still operates: the wind is stronger once in the return period.
    """
    from scipy.special import ndtr

    beta = float(joint.wind_speed.to_normal(_positive(wind_speed)))
    if ndtr(-beta) == 0:
        raise ParameterError(f"{wind_speed:g} m/s of wind is never exceeded: no contour ends there.", where=joint.name)
    if not beta > 0:
        raise ParameterError(
            f"{wind_speed:g} m/s is below the median of the wind, "
            f"{float(joint.wind_speed.median()):.3g} m/s: no contour ends there.",
            where=joint.name,
        )
    return beta, return_period(beta, duration)


def distance(joint: ConditionalModel, states: States) -> np.ndarray:
    """Distance of each state from the origin of the normal variables: the radius of the contour it lies on."""
    z = joint.to_normal(states.wind_speed, states.wave_height, states.peak_period)
    return np.linalg.norm(z, axis=-1)


def _positive(values: Any) -> np.ndarray:
    array = np.asarray(values, dtype=float)
    if not (np.isfinite(array) & (array > 0)).all():
        raise ParameterError("a wind speed of a contour must be positive and finite.")
    return array


def _angles(points: int, upper: bool) -> np.ndarray:
    """From the highest waves once around; or from one side to the other over the highest waves."""
    if points < 3:
        raise ParameterError(f"a contour has 3 points or more, not {points}.")
    return np.linspace(-np.pi / 2, np.pi / 2, points) if upper else 2 * np.pi * np.arange(points) / points


def _states(joint: ConditionalModel, z: np.ndarray, upper: bool) -> States:
    try:
        return joint.from_normal(z)
    except ParameterError as error:
        if not upper:
            error.message += " Take the upper half of the contour, the one of waves above their median."
        raise
