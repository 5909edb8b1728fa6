"""Quadratic laws |u| u: drag. Time takes them as they are; the frequency domain by what they do to a random u.

The linear law with the least mean square error against |u| u, for a Gaussian u, is E[d(|u| u)/du] (u - mean):
stochastic linearisation, sqrt(8/pi) sigma u in one direction without a mean. It depends on how large the answer of the
whole model is, so that no part can say it; what a part says is that the law is there, and of what.
Source: L.E. Borgman, J. Waterways and Harbors Div. ASCE 93 (1967) 129-156; T.K. Caughey, J. Acoust. Soc. Am. 35 (1963)
1706-1711.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language import math as m
from fowtlib.language.equations import active
from fowtlib.language.errors import ModelError
from fowtlib.language.run_time import at_start


@dataclass(slots=True)
class QuadraticLaw:
    """What the frequency domain is told: inputs u (n,), and zeros (n,) that stand beside |u| u in the equations.

    smoothing: of |u|, in the unit of u; see quadratic.
    """

    inputs: ca.SX
    added: ca.SX
    smoothing: float
    path: str


class Nothing:
    """So many zeros when a run starts."""

    def __init__(self, size: int):
        self.size = size

    def __call__(self, component: Any) -> np.ndarray:
        return np.zeros(self.size)


def quadratic(u: Any, smoothing: float, name: str = "drag") -> ca.SX:
    """|u| u of a column u (n,), |u| as sqrt(u.u + smoothing^2). Inside equations() only.

    smoothing is a number, in the unit of u: what is below it counts as at rest. ModelError where it is not above zero.
    Where u changes with time, so do the equations; the frequency domain replaces the law by its best linear one.
    """
    if isinstance(smoothing, bool) or not isinstance(smoothing, (int, float)) or not smoothing > 0:
        raise ModelError(f"quadratic(u, smoothing): smoothing is a number above 0, as 1e-3, not {smoothing!r}.")
    u = ca.densify(ca.vec(ca.SX(u)))
    n = u.numel()
    doc = "added by the frequency domain to a quadratic law; zero in time"
    added = at_start(f"{name} added", n, "", doc, Nothing(n))
    active().quadratic(u, added, smoothing)
    return m.smooth_norm(u, smoothing) * u + added


def slope_at(mean: np.ndarray, smoothing: float = 0.0) -> np.ndarray:
    """d(|u| u)/du (n, n) at a mean u (n,): what the equations have of the law by themselves, for small changes."""
    speed = float(np.hypot(np.linalg.norm(mean), smoothing))
    return speed * np.eye(len(mean)) + (np.outer(mean, mean) / speed if speed > 0 else 0.0)
