"""Bins of states and their probabilities, and the rule by which rare ones are left out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.joint import BEYOND, VARIABLES, ConditionalModel
from fowtlib.metocean.states import States, occurrences

_POINTS = 6  # of the rule of Gauss in each bin, along wind speed and along wave height; more change nothing in 5 digits


def bins(
    joint: ConditionalModel,
    wind_speeds: ArrayLike,
    wave_heights: ArrayLike,
    peak_periods: ArrayLike,
    *,
    keep: float | None = 1000.0,
    duration: float = 3600.0,
) -> States:
    """The states at the centres of bins, each with the probability of its whole bin.

    The three lists are the centres, equally spaced, and each bin reaches half a step to both sides (but not below
    zero). The probability is integrated: exactly over the period, by the rule of Gauss over wind and height. keep: bins
    that occur at least once in so many years of states of `duration` [s] are kept; None keeps all that can occur. What
    is left out stays left out, the states that are beyond the form too: `States.left_out` tells how much.
    """
    lists = zip((wind_speeds, wave_heights, peak_periods), VARIABLES, strict=True)
    (u, du), (h, dh), (t, dt) = (centres(values, name) for values, name in lists)
    node, weight = np.polynomial.legendre.leggauss(_POINTS)
    wind, of_wind = _nodes(u, du, node, weight)
    height, of_height = _nodes(h, dh, node, weight)
    seas = (
        joint.wind_speed.pdf(wind)[:, None]
        * joint.wave_height(wind[:, None]).pdf(height)
        * np.outer(of_wind, of_height)
    )
    lowest = 1 / occurrences(keep, duration) if keep is not None else 0.0
    inside = joint.reaches(wind[:, None], height)
    lost = float(seas[~inside].sum())
    if lost > BEYOND:
        raise ParameterError(
            f"the form of the peak period has no value for {lost:.2g} of all states in these bins.", where=joint.name
        )
    seas = np.where(inside, seas, 0.0)
    some = np.argwhere(seas > 0)
    edges = np.append(np.maximum(t - dt / 2, np.finfo(float).tiny), t[-1] + dt / 2)
    law = joint.peak_period(wind[some[:, 0], None], height[some[:, 1], None])
    within = np.diff(law.cdf(edges), axis=1) * seas[some[:, 0], some[:, 1], None]
    probability = np.zeros((u.size, h.size, t.size))
    np.add.at(probability, (some[:, 0] // _POINTS, some[:, 1] // _POINTS), within)
    kept = probability >= lowest if lowest else probability > 0
    if not kept.any():
        raise ParameterError("no bin is so frequent as to be kept.", where=joint.name)
    i, j, k = np.nonzero(kept)
    return States(u[i], h[j], t[k], probability[kept])


def centres(values: ArrayLike, name: str) -> tuple[np.ndarray, float]:
    """Centres of bins, checked, and their step."""
    array = np.asarray(values, dtype=float)
    if array.ndim != 1 or array.size < 2:
        raise ParameterError(f"bins of {name}: two centres or more are needed.")
    step = float(array[1] - array[0])
    if not (array[0] > 0 and step > 0 and np.allclose(np.diff(array), step, rtol=1e-6)):
        raise ParameterError(f"bins of {name}: the centres must be positive and grow by equal steps.")
    return array, step


def _nodes(centres: np.ndarray, step: float, node: np.ndarray, weight: np.ndarray) -> tuple[Any, Any]:
    """Points of integration of all bins, and their weights; the lowest bin is cut at zero."""
    low, high = np.maximum(centres - step / 2, 0.0), centres + step / 2
    half = (high - low)[:, None] / 2
    return (((high + low)[:, None] / 2) + half * node).ravel(), (half * weight).ravel()
