"""Damage-equivalent loads: the range of a steady cycle that does the damage of a whole series.

    L = (sum of n_i R_i^m / n_eq)^(1/m)

with n_i cycles of range R_i (rainflow), the exponent m of the S-N curve (about 4 for welded steel, 10 for glass fibre)
and n_eq equivalent cycles: frequency times the duration of the series, by default 1 per second.
Sources: ASTM E1049-85; MLife theory manual (Hayman, NREL, 2012).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, overload

import numpy as np

from fowtlib.analysis.fatigue.cycles import Cycles, rainflow_cycles
from fowtlib.analysis.series import scalar_series
from fowtlib.language.errors import ModelError, UnitError
from fowtlib.language.units import dimension

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike
    from fowtlib.solving.results import Result

EXPONENTS = (4.0, 10.0)  # welded steel and glass fibre


# fmt: off
@overload
def damage_equivalent_load(
    series: SeriesLike | Cycles, exponent: float, *, discard: float = 0.0, frequency: float = 1.0,
    equivalent_cycles: float | None = None, ultimate: float | None = None, mean: float = 0.0, bins: int | None = None,
    repeating: bool = False,
) -> float: ...
@overload
def damage_equivalent_load(
    series: SeriesLike | Cycles, exponent: Sequence[float] | np.ndarray, *, discard: float = 0.0,
    frequency: float = 1.0, equivalent_cycles: float | None = None, ultimate: float | None = None, mean: float = 0.0,
    bins: int | None = None, repeating: bool = False,
) -> np.ndarray: ...
# fmt: on
def damage_equivalent_load(
    series: SeriesLike | Cycles,
    exponent: float | Sequence[float] | np.ndarray,
    *,
    discard: float = 0.0,
    frequency: float = 1.0,
    equivalent_cycles: float | None = None,
    ultimate: float | None = None,
    mean: float = 0.0,
    bins: int | None = None,
    repeating: bool = False,
) -> float | np.ndarray:
    """Damage-equivalent load of a series in its unit, as a range; one number per exponent.

    series             ``result["thrust"]``, (time, values), or cycles that are counted already
    exponent           m of the S-N curve, or several of them
    discard            seconds left out at the beginning
    frequency          of the equivalent cycles, Hz
    equivalent_cycles  how many there are in the series, in place of ``frequency``
    ultimate, mean     for Goodman's correction to the load ``mean`` (see Cycles.goodman); None for none
    bins               sort the ranges into so many classes before (see Cycles.binned); None takes them as they are
    repeating          as in rainflow_cycles
    """
    if isinstance(series, Cycles):
        if discard or repeating:
            raise ModelError(f"{series.name}: the cycles are counted; discard and repeating belong to the counting.")
        cycles = series
    else:
        cycles = rainflow_cycles(series, discard=discard, repeating=repeating)
    if ultimate is not None:
        cycles = cycles.goodman(ultimate, mean)
    if bins is not None:
        cycles = cycles.binned(bins)
    number = _number(cycles, frequency, equivalent_cycles)
    slopes = check_exponents(exponent)
    loads = np.array([cycles.power_mean(m, number) for m in slopes.ravel()]).reshape(slopes.shape)
    return loads if slopes.ndim else float(loads)


def equivalent_loads(
    result: Result,
    exponents: Sequence[float] = EXPONENTS,
    *,
    names: Iterable[str] = (),
    discard: float = 0.0,
    frequency: float = 1.0,
    bins: int | None = None,
) -> dict[str, dict[float, float]]:
    """Damage-equivalent loads of a result by name and exponent, each in the unit of the series.

    names  of the series, also any variable of the model; without them every force, moment and stress of the result
    """
    slopes = [float(m) for m in np.atleast_1d(check_exponents(exponents))]
    table = {}
    wanted = list(names)
    for series in scalar_series(result, wanted or None):
        if not wanted and not is_load(series.unit):
            continue
        loads = damage_equivalent_load(series, slopes, discard=discard, frequency=frequency, bins=bins)
        table[series.name] = dict(zip(slopes, np.asarray(loads).tolist(), strict=True))
    return table


def is_load(unit: str) -> bool:
    """True for units of a force, a moment or a stress."""
    try:
        return dimension(unit) in {dimension(kind) for kind in ("N", "N*m", "Pa")}
    except UnitError:
        return False


def check_exponents(exponent: float | Sequence[float] | np.ndarray) -> np.ndarray:
    """Exponents as an array of the same shape."""
    slopes = np.asarray(exponent, dtype=float)
    if not slopes.size or not np.all(np.isfinite(slopes) & (slopes > 0)):
        wrong = "none" if not slopes.size else f"{slopes.ravel()[~(np.isfinite(slopes) & (slopes > 0)).ravel()][0]:g}"
        raise ModelError(f"an exponent of an S-N curve is a number above 0, such as 4 or 10, not {wrong}.")
    return slopes


def _number(cycles: Cycles, frequency: float, given: float | None) -> float:
    number = frequency * cycles.duration if given is None else float(given)
    if not (math.isfinite(number) and number > 0):
        what = f"a frequency of {frequency:g} Hz" if given is None else f"{number:g} equivalent cycles"
        raise ModelError(f"{cycles.name}: {what} cannot stand for a load; give a number above 0.")
    return number
