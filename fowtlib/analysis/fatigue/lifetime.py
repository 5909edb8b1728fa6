"""From single cases to a life: what share of it each case stands for, equivalent loads and damage of all together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, overload

import numpy as np

from fowtlib.analysis.fatigue.loads import check_exponents
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

YEAR = 365.25 * 24 * 3600.0  # s


def weibull_weights(
    speeds: ArrayLike,
    *,
    mean: float | None = None,
    scale: float | None = None,
    shape: float = 2.0,
    edges: ArrayLike | None = None,
) -> np.ndarray:
    """Share of the time that each case stands for, when the wind speed follows a Weibull distribution.

    The probability of a bin is shared by its cases (seeds). What lies outside of the bins belongs to no case, so that
    the weights sum up to less than 1.

    speeds  wind speed of each case, m/s; the same for the seeds of a bin
    mean    of the wind speed over the years, m/s (IEC 61400-1: 0.2 of the reference speed, with shape 2); or
    scale   of the distribution, m/s
    shape   of the distribution
    edges   of the bins, m/s; without them they lie in the middle between the speeds, the outer ones as far outside
    """
    speeds = np.asarray(speeds, dtype=float)
    if (mean is None) == (scale is None):
        raise ModelError("a Weibull distribution of the wind takes either its mean or its scale in m/s.")
    size = mean if scale is None else scale
    if not (size is not None and size > 0 and shape > 0 and math.isfinite(size) and math.isfinite(shape)):
        raise ModelError(f"a Weibull distribution takes numbers above 0, not a mean or scale of {size:g} m/s and a "
                         f"shape of {shape:g}.")  # fmt: skip
    if scale is None:
        size = size / math.gamma(1.0 + 1.0 / shape)
    bounds = _rising(_middles(speeds) if edges is None else edges, "wind speeds")
    cumulated = -np.expm1(-((np.maximum(bounds, 0.0) / size) ** shape))
    return _share(np.searchsorted(bounds, speeds, side="right") - 1, np.diff(cumulated), speeds, "wind speed [m/s]")


def table_weights(
    states: ArrayLike, edges: Sequence[ArrayLike], table: ArrayLike, *, total: float | None = None, missing: float = 0.0
) -> np.ndarray:
    """Share of the time that each case stands for, by a scatter table of one or more variables.

    states   variables of each case, (cases, variables); or (cases,) for one variable
    edges    for each variable the bounds of its cells, one more than there are cells
    table    occurrences or probabilities of the cells, one axis per variable
    total    what the table is divided by; None: its sum
    missing  largest share of the table that may lie in cells without a case; it counts for nothing
    """
    states = np.asarray(states, dtype=float)
    states = states[:, None] if states.ndim == 1 else states
    bounds = [_rising(edge, f"variable {number}") for number, edge in enumerate(edges, 1)]
    cells = np.asarray(table, dtype=float)
    wanted = tuple(bound.size - 1 for bound in bounds)
    if cells.shape != wanted or states.shape[1:] != (len(bounds),):
        raise ModelError(
            f"a scatter table of {' x '.join(map(str, wanted))} cells takes a table of that shape and {len(bounds)} "
            f"variables per case; there are {' x '.join(map(str, cells.shape))} cells, and states of shape "
            f"{states.shape}."
        )
    total = float(cells.sum()) if total is None else total
    if not np.all(cells >= 0) or not total > 0 or cells.sum() > total * (1 + 1e-9):
        raise ModelError("the cells of a scatter table are numbers of 0 or more, and sum up to its total at the most.")
    places = [np.searchsorted(bound, column, side="right") - 1 for bound, column in zip(bounds, states.T, strict=True)]
    flat = np.zeros(len(states), dtype=int)
    for place, bound in zip(places, bounds, strict=True):
        inside = (place >= 0) & (place < bound.size - 1)
        flat = np.where(inside & (flat >= 0), flat * (bound.size - 1) + place, -1)
    weights = _share(flat, cells.ravel() / total, states, "state")
    left = float(cells.sum() / total - weights.sum())
    if left > missing + 1e-9:
        raise ModelError(
            f"{left:.3g} of the scatter table lies in cells without a case; add cases, or say missing={left:.2g} to "
            "count it for nothing."
        )
    return weights


# fmt: off
@overload
def lifetime_equivalent_load(
    loads: ArrayLike, exponent: float, weights: ArrayLike, *, frequency: float = 1.0, lifetime: float | None = None,
    equivalent_cycles: float | None = None,
) -> float | np.ndarray: ...
@overload
def lifetime_equivalent_load(
    loads: ArrayLike, exponent: Sequence[float] | np.ndarray, weights: ArrayLike, *, frequency: float = 1.0,
    lifetime: float | None = None, equivalent_cycles: float | None = None,
) -> np.ndarray: ...
# fmt: on
def lifetime_equivalent_load(
    loads: ArrayLike,
    exponent: float | Sequence[float] | np.ndarray,
    weights: ArrayLike,
    *,
    frequency: float = 1.0,
    lifetime: float | None = None,
    equivalent_cycles: float | None = None,
) -> float | np.ndarray:
    """Equivalent load of a life from those of its cases: (sum of weight_i L_i^m)^(1/m).

    loads              of the cases at one equivalent frequency, (cases,); or (cases, k) with k exponents or one
    exponent           m of the S-N curve, one or k
    weights            share of the life of each case; a rest to 1 counts as time without a load
    frequency          of the equivalent cycles in ``loads``, Hz
    lifetime           s, and
    equivalent_cycles  for the load of so many cycles in the life (1e7, say); without both, that at ``frequency``
    """
    values, slopes, shares = np.asarray(loads, dtype=float), check_exponents(exponent), _weights(weights, loads)
    if not np.all(np.isfinite(values) & (values >= 0)):
        raise ModelError("equivalent loads of cases are finite numbers of 0 or more.")
    if slopes.ndim and slopes.shape != values.shape[1:]:
        raise ModelError(f"there are {slopes.size} exponents for loads of shape {values.shape}: (cases, exponents).")
    if (lifetime is None) != (equivalent_cycles is None):
        raise ModelError("the load of a number of cycles in a life takes both: lifetime in s, and equivalent_cycles.")
    ratio = 1.0
    if lifetime is not None and equivalent_cycles is not None:
        ratio = frequency * lifetime / equivalent_cycles
        if not (math.isfinite(ratio) and ratio > 0):
            raise ModelError("frequency, lifetime and equivalent_cycles are numbers above 0.")
    largest = values.max(axis=0, initial=0.0)
    relative = values / np.where(largest > 0, largest, 1.0)
    total = largest * (ratio * np.tensordot(shares, relative**slopes, axes=1)) ** (1.0 / slopes)
    return total if total.ndim else float(total)


def lifetime_damage(
    damages: ArrayLike,
    durations: ArrayLike,
    weights: ArrayLike,
    *,
    lifetime: float = 20.0 * YEAR,
    design_fatigue_factor: float = 1.0,
) -> float | np.ndarray:
    """Miner sum of a life, times the design fatigue factor: it must not be above 1.

    damages    of the cases (Miner sums), (cases,) or (cases, points)
    durations  of the series that the damages are from, s: one, or one per case
    weights    share of the life of each case; a rest to 1 counts as time without damage
    lifetime   s
    """
    values, shares = np.asarray(damages, dtype=float), _weights(weights, damages)
    spans = np.broadcast_to(np.asarray(durations, dtype=float), values.shape[:1])
    if not np.all(spans > 0):
        raise ModelError("the durations of cases are numbers of seconds above 0.")
    if not np.all(values >= 0):
        raise ModelError("damages of cases are numbers of 0 or more.")
    if not (lifetime > 0 and design_fatigue_factor > 0 and math.isfinite(lifetime * design_fatigue_factor)):
        raise ModelError("lifetime and design_fatigue_factor are numbers above 0.")
    total = design_fatigue_factor * lifetime * np.tensordot(shares / spans, values, axes=1)
    return total if total.ndim else float(total)


def _weights(weights: ArrayLike, cases: ArrayLike) -> np.ndarray:
    """Weights of cases, checked."""
    shares, count = np.asarray(weights, dtype=float), np.shape(cases)[:1]
    if shares.shape != count or not shares.size:
        raise ModelError(f"there are {shares.size} weights for {count[0] if count else 1} cases; give one per case.")
    if not np.all(shares >= 0) or shares.sum() > 1 + 1e-6:
        raise ModelError(
            "weights are shares of the life: numbers of 0 or more with a sum of at most 1; their sum is "
            f"{shares.sum():g}."
        )
    return shares


def _rising(edges: ArrayLike, what: str) -> np.ndarray:
    bounds = np.asarray(edges, dtype=float)
    if bounds.ndim != 1 or bounds.size < 2 or not np.all(np.diff(bounds) > 0):
        raise ModelError(f"the edges of the bins of {what} are two or more rising numbers.")
    return bounds


def _middles(speeds: np.ndarray) -> np.ndarray:
    """Edges between the speeds that occur."""
    centres = np.unique(speeds)
    if centres.size < 2:
        raise ModelError("the bins of a single wind speed are not known; give their edges.")
    inner = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - inner[0]], inner, [2 * centres[-1] - inner[-1]]])


def _share(cell: np.ndarray, probability: np.ndarray, states: np.ndarray, what: str) -> np.ndarray:
    """The probability of each cell, shared by the cases in it."""
    outside = (cell < 0) | (cell >= probability.size)
    if np.any(outside):
        raise ModelError(f"the case with {what} {states[outside][0]} lies outside of the bins.")
    return probability[cell] / np.bincount(cell, minlength=probability.size)[cell]
