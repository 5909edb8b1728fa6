"""Frequencies at which a response is computed: close where it changes fast."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fowtlib.solving import Mode

LOWEST, HIGHEST = 0.5 / 3600, 2.0  # Hz; what is slower than an hour is the mean of a record
BROAD = 200  # equally spaced in the logarithm, over all frequencies
WAVES = (0.03, 0.35, 160)  # Hz, and so many equally spaced
PEAK = 33  # about a resonance
BROADEST = 0.2  # damping ratio of a mode, from which those all over are close enough
COARSE = 3  # so many times fewer where a percent is enough


def response_frequencies(modes: Iterable[Mode], low: float = LOWEST, high: float = HIGHEST,
                         coarse: bool = False) -> np.ndarray:  # fmt: skip
    """Frequencies [Hz] for the integrals of a response: all over, of waves, and about each mode.

    About a mode those at which the phase of its resonance has moved on by equal steps. coarse: fewer of them, for
    integrals to a percent.
    """
    return frequencies_about(np.array([mode.eigenvalue for mode in modes], dtype=complex), low, high, coarse)


def frequencies_about(roots: np.ndarray, low: float = LOWEST, high: float = HIGHEST,
                      coarse: bool = False) -> np.ndarray:  # fmt: skip
    """The same, of the roots (n,) [rad/s] of a linear model, of a conjugate pair one or both."""
    fewer = COARSE if coarse else 1
    points = [np.geomspace(low, high, BROAD // fewer), np.linspace(*WAVES[:2], WAVES[2] // fewer)]
    angles = np.linspace(-1.5, 1.5, PEAK // fewer)
    for root in roots[roots.imag >= 0].tolist():
        natural = abs(root) / (2 * np.pi)
        damping = -root.real / abs(root) if root else 0.0
        if low < natural < high and damping < BROADEST:
            points.append(root.imag / (2 * np.pi) + max(damping, 1e-5) * natural * np.tan(angles))
    frequency = np.sort(np.concatenate(points))
    frequency = frequency[(frequency >= low) & (frequency <= high)]
    return frequency[np.diff(frequency, prepend=0.0) > 1e-7 * frequency]
