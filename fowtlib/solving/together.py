"""Slopes of what is computed from many elements of parameters, some of which move at once.

The diameter at one height of a tube matters to few of its numbers. Elements that mattered to different numbers at the
values before move together, and each number that changes belongs to one of them. Whether that still holds is seen: a
number that belongs to none of them must stay as it is, to rounding, and where all elements move together, each by
another share of its step, the numbers must change by the sum of what was found.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import cache
from zlib import crc32

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.differences import SHORT, derivative

Affects = Mapping[str, Mapping[Hashable, np.ndarray]]
"""Which numbers of which key an element mattered to, by its name: (n,), or (1,) for all of a key."""

Compute = Callable[[Mapping[str, float], Sequence[Hashable]], Sequence[np.ndarray]]
"""Numbers of some keys where elements are shifted by so much."""

EQUAL = 1e-6  # of the sum of the sizes of all changes
ROUNDING = 1e-12  # of a number, by which it may change where nothing follows from what moves
GOLDEN = 0.6180339887


def slopes_together(steps: Mapping[str, float], affects: Affects, here: Mapping[Hashable, np.ndarray],
                    compute: Compute, least: float = 0.0) -> dict[str, dict[Hashable, np.ndarray]] | None:  # fmt: skip
    """Slopes of numbers by elements, by name and key, where they matter; None: they no longer matter to the same.

    steps: of all elements; here: the numbers as they are. least: of the largest change of a key, what does not count
    beside it, as waves that have decayed at the depth of a part.
    """
    found: dict[str, dict[Hashable, np.ndarray]] = {name: {} for name in steps}
    for group in _groups(list(steps), affects):
        keys = [key for key in here if any(key in affects[name] for name in group)]

        def moved(part: float, group: list[str] = group, keys: list[Hashable] = keys) -> np.ndarray:
            return np.concatenate(compute({name: part * steps[name] for name in group}, keys))

        if not keys:
            continue
        ends = np.cumsum([here[key].size for key in keys])
        try:
            slope = derivative(moved, 0.0, here=np.concatenate([here[key] for key in keys]), size=1 / SHORT, quick=True)
        except SimulationError:  # which of them it is, is found one by one
            return None
        for key, part in zip(keys, np.split(slope, ends[:-1]), strict=True):
            left = np.abs(part) > ROUNDING * np.abs(here[key])
            for name in group:
                if (mask := affects[name].get(key)) is not None:
                    found[name][key] = np.where(mask, part / steps[name], 0.0)
                    left &= ~mask
            if left.any():
                return None
    return found if _adds_up(steps, found, here, compute, least) else None


def _groups(names: Sequence[str], affects: Affects) -> list[list[str]]:
    """Elements that matter to different numbers."""
    groups: list[tuple[list[str], dict[Hashable, np.ndarray]]] = []
    for name in names:
        mine = affects[name].items()
        free = (one for one in groups if not any(key in one[1] and np.any(one[1][key] & mask) for key, mask in mine))
        if (chosen := next(free, None)) is None:
            groups.append(chosen := ([], {}))
        group, taken = chosen
        group.append(name)
        for key, mask in mine:
            taken[key] = taken[key] | mask if key in taken else mask
    return [group for group, _ in groups]


@cache
def _share(name: str) -> float:
    """From 0.5 to 1, up or down: of its name, so that all that follows from a part moves with the same sizes of it."""
    number = crc32(name.encode())
    return (-1) ** number * (0.5 + 0.5 * (GOLDEN * number % 1))


def _adds_up(steps: Mapping[str, float], found: Mapping[str, Mapping[Hashable, np.ndarray]],
             here: Mapping[Hashable, np.ndarray], compute: Compute, least: float) -> bool:  # fmt: skip
    """Whether the numbers change by the sum of all changes where all elements move."""
    shares = {name: _share(name) * step for name, step in steps.items()}
    above, below = (compute({name: sign * share for name, share in shares.items()}, list(here)) for sign in (1, -1))
    for key, more, less in zip(here, above, below, strict=True):
        changes = [shares[name] * slopes[key] for name, slopes in found.items() if key in slopes]
        size = sum((np.abs(change) for change in changes), np.zeros_like(here[key]))
        off = np.abs((more - less) / 2 - sum(changes, np.zeros_like(here[key])))
        limit = EQUAL * size + least * size.max(initial=0.0) + len(steps) * ROUNDING * np.abs(here[key])
        if np.any(off > limit):
            return False
    return True
