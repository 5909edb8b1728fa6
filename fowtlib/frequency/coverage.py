"""Whether frequencies and spectra reach as far as a response does; what lies beyond is not in it, and that is told."""

from __future__ import annotations

import warnings

import numpy as np

from fowtlib.analysis.spectra import widths
from fowtlib.frequency.found import Response

SHARE = 0.1  # of a variance, as S f at the end of a spectrum, from which the end is in the midst of it
LISTED = 4  # results that a message names


def warn_of_ends(found: Response, given: bool) -> None:
    """UserWarning where results still have energy at an end of the frequencies, or of what drives them.

    The measure is S f over the variance: of a tail that falls as f^-n, n - 1 times what lies beyond. given: the
    frequencies are the user's; those chosen by the modes begin, on purpose, where the mean of a record does.
    """
    f, density = found.frequency, found.density
    variance = (density * widths(f)).sum(axis=1)
    variance = np.where(variance > (1e-9 * np.maximum(np.abs(found.mean), 1e-6)) ** 2, variance, np.inf)
    ends = [(f[-1], "end", "higher", density[:, -1])]
    if given:
        ends.append((f[0], "begin", "lower", density[:, 0]))
    for end, word, which, values in ends:
        _tell(found, values * end / variance, f"the frequencies {word} at {end:.3g} Hz", f"take {which} ones")
    for process, driving in found.driving.items():
        share = found.shares[process]
        driven = np.flatnonzero(np.trace(driving, axis1=1, axis2=2).real > 0)
        if driven.size and driven[-1] < f.size - 1:
            end = f[driven[-1]]
            beyond = share[:, driven[-1]] * end / variance
            _tell(found, beyond, f"the spectrum of {process} ends at {end:.3g} Hz", "let it reach further")


def _tell(found: Response, shares: np.ndarray, what: str, advice: str) -> None:
    missing = np.flatnonzero(shares > SHARE)
    if not missing.size:
        return
    worst = missing[np.argsort(-shares[missing])]
    named = ", ".join(found.outputs[k] for k in worst[:LISTED])
    more = f" and {missing.size - LISTED} more" if missing.size > LISTED else ""
    warnings.warn(
        f"{what}, where the response is not small yet (S f is {100 * shares[worst[0]]:.2g} % of the variance of "
        f"{found.outputs[worst[0]]}): deviations are too small, and crossings too rare, of {named}{more}; {advice}.",
        stacklevel=4,
    )  # fmt: skip
