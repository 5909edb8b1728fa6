"""Where the searches of an optimisation begin."""

from __future__ import annotations

import numpy as np

from fowtlib.design.variables import Space
from fowtlib.language.errors import ModelError


def starts(space: Space, count: int, seed: int) -> list[np.ndarray]:
    """The start of the design, and count - 1 further ones: a Latin hypercube between the bounds, the same for a seed.

    Source: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979), 239-245.
    """
    from scipy.stats import qmc

    if count < 1:
        raise ModelError(f"there is 1 start, or more; not {count}.")
    if count == 1:
        return [space.start]
    open_ = [name for name, a, b in zip(space.elements, space.lower, space.upper, strict=True)
             if not np.isfinite(b - a)]  # fmt: skip
    if open_:
        raise ModelError(f"several starts need bounds on both sides of all variables; '{open_[0]}' has none.")
    drawn = qmc.LatinHypercube(len(space), rng=seed).random(count - 1)
    return [space.start, *(space.lower + drawn * (space.upper - space.lower))]
