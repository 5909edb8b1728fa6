"""Maxima of what drag and inertia make together: Rayleigh's law where they are small, an exponential one beyond.

A load c |u'| u' + z, with Gaussian u' and z of one narrow band a quarter of a period apart, has the maxima of z where
the motion is small, and drag makes those where it is large. With the deviation s_z of z, k = c s_u'^2 / s_z and the
deviation of the load s = s_z sqrt(1 + 3 k^2), the maxima y = load / s have the distribution

    F(y) = 1 - exp(-(3 k^2 + 1) y^2 / 2)                            up to y_0 = 1/(2 k sqrt(3 k^2 + 1))
    F(y) = 1 - exp(-sqrt(3 k^2 + 1)/(2 k) (y - y_0/2))              beyond

Source: L.E. Borgman, J. Waterways and Harbors Div. ASCE 93 (1967); for mooring lines H. Lie and N. Sodahl (1993), and
J.M. Hegseth et al., Marine Structures 72 (2020) 102771, eq. 12-13.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError


def rayleigh_exponential(y: Any, k: Any) -> Any:
    """Probability that a maximum, over the deviation of the load, is below y >= 0; k >= 0: drag over inertia."""
    y, k = np.asarray(y, dtype=float), np.asarray(k, dtype=float)
    _refuse(y, k)
    load = y * np.sqrt(3 * k**2 + 1)  # over the deviation of z
    far = (load - 1 / (4 * np.maximum(k, 1e-9))) / (2 * np.maximum(k, 1e-9))
    return -np.expm1(-np.where(2 * k * load <= 1, load**2 / 2, far))


def rayleigh_exponential_quantile(probability: Any, k: Any) -> Any:
    """The y below which a maximum is with this probability, from 0 up to below 1."""
    p, k = np.asarray(probability, dtype=float), np.asarray(k, dtype=float)
    _refuse(p, k)
    if np.any(p >= 1):
        raise ModelError("a probability is below 1.")
    return _at_depth(-np.log1p(-p), k)


def rayleigh_exponential_extreme(count: Any, k: Any, quantile: float | None = 0.5) -> Any:
    """The y that the largest of `count` independent maxima is below with probability `quantile`.

    None: the characteristic largest, which one of count + 1 maxima exceeds, as P3 of the source takes it.
    """
    count, k = np.asarray(count, dtype=float), np.asarray(k, dtype=float)
    _refuse(count, k)
    if quantile is None:
        return _at_depth(np.log(count + 1), k)
    if not 0 < quantile < 1 or np.any(count < 1):
        given = f"{quantile:g} of {np.min(count):.2g}"
        raise ModelError(f"a quantile between 0 and 1, of one maximum or more; not {given}.")
    return _at_depth(-np.log(-np.expm1(np.log(quantile) / count)), k)


def _at_depth(depth: Any, k: Any) -> Any:
    """The y that a maximum exceeds with the probability exp(-depth)."""
    near, far = np.sqrt(2 * depth), 2 * k * depth + 1 / (4 * np.maximum(k, 1e-9))
    return np.where(8 * k**2 * depth <= 1, near, far) / np.sqrt(3 * k**2 + 1)


def _refuse(value: Any, k: Any) -> None:
    if np.any(~(value >= 0)) or np.any(~(k >= 0)):
        raise ModelError("maxima, probabilities and the share of drag are not below zero.")
