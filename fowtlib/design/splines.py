"""B-splines along a member: how a few control points give the values at many stations."""

from __future__ import annotations

import numpy as np

from fowtlib.language.errors import ModelError


def basis(stations: np.ndarray, points: int, degree: int = 3) -> np.ndarray:
    """Values (stations, points) of the basis functions of a clamped B-spline with equal knots.

    stations: places along the member in any unit, from one end to the other; the first and the last control point are
    the values there. The degree is at most points - 1, so that two points give a line and one a constant. Rows sum to 1
    and have no negative entry: the values at stations lie between the smallest and the largest control point.
    Source: C. de Boor, A Practical Guide to Splines (1978), chapter IX.
    """
    from scipy.interpolate import BSpline

    places = np.asarray(stations, dtype=float)
    if not 1 <= points <= places.size:
        raise ModelError(f"{points} control points for {places.size} stations: take 1 to {places.size}.")
    if points == 1:
        return np.ones((places.size, 1))
    length = places[-1] - places[0]
    if not length or np.any(np.diff(places) * np.sign(length) < 0):
        raise ModelError("the stations of a spline go from one end to the other.")
    order = min(degree, points - 1)
    inner = np.linspace(0.0, 1.0, points - order + 1)[1:-1]
    knots = np.concatenate([np.zeros(order + 1), inner, np.ones(order + 1)])
    where = np.clip((places - places[0]) / length, 0.0, 1.0)
    return BSpline.design_matrix(where, knots, order).toarray()
