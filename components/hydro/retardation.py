"""The retardation kernel K(t) of the radiation load, by careful quadrature of the damping B(omega).

The radiation load of a floating body is -A_inf q'' - int_0^t K(t - s) q'(s) ds (Cummins 1962), with

    K(t) = 2/pi int_0^inf B(omega) cos(omega t) d omega,
    B(omega) = int_0^inf K(t) cos(omega t) dt,
    A(omega) - A_inf = -1/omega int_0^inf K(t) sin(omega t) dt      (Ogilvie 1964).

The three hold together, so A(omega) is a check of B(omega), A_inf and the quadrature: `added_mass_from_kernel`.

Between the given frequencies, which need not be uniform, B is the cubic spline with B(0) = B'(0) = 0. The spline times
cos(omega t) is integrated by Gauss quadrature on a grid fine enough for the longest time, so that nothing is periodic
in time, as it is with a discrete Fourier transform. Above the last frequency W the damping is continued as
B(W) (W / omega)^3, the decay for a wall that makes waves (Havelock 1929: in deep water their height goes with the
stroke, their power per width with height^2 / omega, and B with power / (omega stroke)^2). The transform of this tail is
known in closed form. Without it the kernel rings with the frequency W: for OC3-Hywind, B11 at 5 rad/s is still 5 % of
its maximum.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Floats = NDArray[np.float64]

_GAUSS = np.polynomial.legendre.leggauss(6)
_PHASE = 2.0  # rad; largest phase omega t over one panel of the quadrature, where six points reach 1e-10


def retardation_kernel(omega: ArrayLike, damping: ArrayLike, time: ArrayLike, *, tail: bool = True) -> Floats:
    """K (nt, ...) at the times t [s] from the damping B (n, ...) at rising, positive omega (n,) [rad/s].

    tail=False leaves the damping above the last frequency out.
    """
    omega, damping, time = (np.asarray(item, dtype=float) for item in (omega, damping, time))
    flat = damping.reshape(omega.size, -1)
    kernel = _transform(spline_between(omega, flat), np.append(0.0, omega), time, np.cos)
    if tail:
        kernel += np.outer(omega[-1] * _cubic_tail(omega[-1] * time), flat[-1])
    return (2 / np.pi * kernel).reshape(time.shape + damping.shape[1:])


def added_mass_from_kernel(time: ArrayLike, kernel: ArrayLike, omega: ArrayLike) -> Floats:
    """A(omega) - A_inf (n, ...) that belongs to a kernel K (nt, ...) sampled at the times t (nt,)."""
    from scipy.interpolate import CubicSpline

    time, kernel, omega = (np.asarray(item, dtype=float) for item in (time, kernel, omega))
    flat = kernel.reshape(time.size, -1)
    spline = CubicSpline(time, flat, bc_type=((1, np.zeros(flat.shape[1])), "not-a-knot"))
    integral = _transform(spline, time, omega, np.sin)
    return -(integral / omega[:, None]).reshape(omega.shape + kernel.shape[1:])


def bandwidth(omega: Floats, damping: Floats, share: float = 0.99) -> float:
    """The frequency [rad/s] below which every column of |B| (n, m) has this share of its integral."""
    steps = 0.5 * np.diff(np.append(0.0, omega))[:, None] * (np.abs(damping) + np.abs(np.roll(damping, 1, axis=0)))
    steps[0] = 0.5 * omega[0] * np.abs(damping[0])
    total = np.cumsum(steps, axis=0)
    return float(omega[np.argmax(total >= share * total[-1], axis=0).max()])


def spline_between(omega: Floats, damping: Floats) -> CubicSpline:
    """The damping (n, m) between its frequencies; zero with no slope at zero."""
    from scipy.interpolate import CubicSpline

    zero = np.zeros((1, damping.shape[1]))
    return CubicSpline(np.append(0.0, omega), np.vstack([zero, damping]), bc_type=((1, zero[0]), "not-a-knot"))


def _transform(spline: CubicSpline, knots: Floats, frequency: Floats, function: np.ufunc) -> Floats:
    """Integral of spline(x) function(frequency x) over the knots, for each frequency."""
    highest = float(np.abs(frequency).max(initial=0.0))
    panels = np.maximum(1, np.ceil(np.diff(knots) * highest / _PHASE)).astype(int)
    edges = np.concatenate([*(np.linspace(a, b, n, endpoint=False)
                              for a, b, n in zip(knots[:-1], knots[1:], panels, strict=True)), knots[-1:]])
    half = np.diff(edges)[:, None] / 2
    points = (edges[:-1, None] + half * (1 + _GAUSS[0])).ravel()
    weights = (half * _GAUSS[1]).ravel()
    return function(np.outer(frequency, points)) @ (spline(points) * weights[:, None])


def _cubic_tail(x: Floats) -> Floats:
    """int_1^inf cos(x u) / u^3 du."""
    from scipy.special import sici

    x = np.abs(x)
    cosine_integral = sici(np.maximum(x, 1e-12))[1]
    return 0.5 * (np.cos(x) - x * np.sin(x) + x**2 * cosine_integral)
