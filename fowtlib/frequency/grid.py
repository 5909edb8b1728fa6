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
    fewer = COARSE if coarse else 1
    points = [np.geomspace(low, high, BROAD // fewer), np.linspace(*WAVES[:2], WAVES[2] // fewer)]
    angles = np.linspace(-1.5, 1.5, PEAK // fewer)
    for mode in modes:
        width = max(mode.damping_ratio, 1e-5) * mode.frequency_hz
        if low < mode.frequency_hz < high and mode.damping_ratio < BROADEST:
            points.append(abs(mode.eigenvalue.imag) / (2 * np.pi) + width * np.tan(angles))
    frequency = np.sort(np.concatenate(points))
    frequency = frequency[(frequency >= low) & (frequency <= high)]
    return frequency[np.diff(frequency, prepend=0.0) > 1e-7 * frequency]
