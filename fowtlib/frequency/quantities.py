"""Results of a model that gradients are taken of: each a number, of the mean, of a mode, or of a spectrum.

In a text the first word says which: "mean pitch", "std pitch", "max pitch", "min pitch", "range pitch", "frequency
heave", "damping heave".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fowtlib.analysis.fatigue.spectral import dirlik
from fowtlib.analysis.spectra import Spectrum
from fowtlib.language.errors import ModelError, SimulationError, did_you_mean
from fowtlib.solving.differences import derivative

ORDERS = (0, 1, 2, 4)
REST = 1e-13  # of the mean, or of one unit, a deviation that is nothing but rounding


@dataclass(frozen=True)
class Mean:
    """A result, or any variable of one number by its path, in the mean position."""

    of: str
    word = "mean"

    def unit(self, unit: str) -> str:
        return unit


@dataclass(frozen=True)
class ModeFrequency:
    """Undamped natural frequency [Hz] of the mode in which a state takes part most, of those that oscillate.

    of: the state by its path, or a result that is one; or a frequency [Hz], for the mode nearest to it, within a
    factor of two. together: of modes that are one, the mean.
    """

    of: str | float
    together: bool = False
    word = "frequency"

    def unit(self, _: str) -> str:
        return "Hz"


@dataclass(frozen=True)
class ModeDamping(ModeFrequency):
    """Damping ratio of such a mode."""

    word = "damping"

    def unit(self, _: str) -> str:
        return "1"


@dataclass(frozen=True)
class OfSpectrum:
    """Any smooth function of the mean and the spectral moments of a result: `function(spectrum, mean)`.

    The spectrum that it is given has `moment(n)` for n = 0, 1, 2 and 4, and what follows from these (std,
    up_crossing_rate), but no densities. process: the part of one process alone, such as "sea".
    """

    of: str
    function: Callable[[Spectrum, float], float] = field(repr=False)
    its_unit: str | None = None
    process: str | None = None
    word = "function"

    def value(self, spectrum: Spectrum, mean: float) -> float:
        return float(self.function(spectrum, mean))

    def unit(self, unit: str) -> str:
        return unit if self.its_unit is None else self.its_unit


@dataclass(frozen=True)
class Std:
    """Standard deviation of a result; of one process, such as "sea", or of all."""

    of: str
    process: str | None = None
    word = "std"

    def value(self, spectrum: Spectrum, mean: float) -> float:
        return spectrum.std

    def unit(self, unit: str) -> str:
        return unit


@dataclass(frozen=True)
class Extreme:
    """Quantile of the largest ("max") or smallest ("min") value in a duration [s]; see Response.extreme."""

    of: str
    side: str = "max"
    duration: float = 3600.0
    quantile: float = 0.5
    process = None

    def __post_init__(self) -> None:
        if self.side not in ("max", "min"):
            raise ModelError(f"side: '{self.side}' is not 'max' or 'min'.")
        if not (0 < self.quantile < 1 and self.duration > 0):
            raise ModelError("a quantile between 0 and 1 and a duration above 0 s.")

    @property
    def word(self) -> str:
        return self.side

    def value(self, spectrum: Spectrum, mean: float) -> float:
        size = 2 * np.log(spectrum.up_crossing_rate * self.duration / -np.log(self.quantile))
        if not size > 0:
            raise ModelError(f"{self.of}: {self.duration:g} s hold too few up-crossings; take a longer time.")
        return mean + (1.0 if self.side == "max" else -1.0) * spectrum.std * float(np.sqrt(size))

    def unit(self, unit: str) -> str:
        return unit


@dataclass(frozen=True)
class EquivalentLoad:
    """Damage-equivalent range of a result by Dirlik's law, of `frequency` [Hz] cycles."""

    of: str
    exponent: float = 4.0
    frequency: float = 1.0
    process = None
    word = "range"

    def value(self, spectrum: Spectrum, mean: float) -> float:
        return dirlik(spectrum).equivalent_load(self.exponent, self.frequency)

    def unit(self, unit: str) -> str:
        return unit


Quantity = Mean | ModeFrequency | ModeDamping | OfSpectrum | Std | Extreme | EquivalentLoad

_WORDS: Mapping[str, Callable[[str], Quantity]] = {
    "mean": Mean, "std": Std, "max": lambda of: Extreme(of, "max"), "min": lambda of: Extreme(of, "min"),
    "range": EquivalentLoad, "frequency": ModeFrequency, "damping": ModeDamping,
}  # fmt: skip


def quantities(wanted: Sequence[Any] | Any) -> list[Quantity]:
    """What texts and quantities stand for; ModelError where a text says nothing that is known."""
    items = [wanted] if isinstance(wanted, str) or not isinstance(wanted, Sequence) else list(wanted)
    return [item if isinstance(item, Quantity) else _of_text(item) for item in items]


def _of_text(text: Any) -> Quantity:
    word, _, of = str(text).strip().partition(" ")
    if word not in _WORDS:
        raise ModelError(f"'{text}': the first word says what of a result is wanted{did_you_mean(word, _WORDS)}")
    if not of.strip():
        raise ModelError(f"'{text}': of which result? as in '{word} pitch'.")
    return _WORDS[word](of.strip())


def label(item: Quantity) -> str:
    """What a quantity is called: its word and its result."""
    of = f"{item.of:g} Hz" if isinstance(item.of, int | float) else item.of
    process = getattr(item, "process", None)
    return f"{item.word} {of}" + (f" by {process}" if process else "")


@dataclass(frozen=True)
class Moments(Spectrum):
    """A spectrum of which the moments of orders 0, 1, 2 and 4 are known, and nothing else."""

    known: tuple[float, ...] = ()

    def moment(self, order: int = 0, low: float = 0.0, high: float = np.inf) -> float:
        if order not in ORDERS or low > 0 or high < np.inf:
            raise ModelError("a function of a spectrum has a gradient where it asks for whole moments of orders 0, 1, "
                             "2 and 4 alone.")  # fmt: skip
        return float(self.known[ORDERS.index(order)])


def with_slopes(item: Quantity, moments: np.ndarray, mean: float, unit: str,
                slopes: bool = True) -> tuple[float, np.ndarray, float]:  # fmt: skip
    """Value of a quantity of a spectrum, its slopes by the moments (4,), and by the mean.

    The slopes are central differences of the function of five numbers, extrapolated: about 1e-11 of the largest.
    """
    empty = np.zeros(0)

    def at(values: np.ndarray, m: float) -> float:
        return item.value(Moments(empty, empty, unit, item.of, known=tuple(values)), m)

    value, by_moments = at(moments, mean), np.zeros(len(ORDERS))
    if not slopes:
        return value, by_moments, 0.0
    if not moments[0] > (REST * max(1.0, abs(mean))) ** 2:
        raise SimulationError(f"{label(item)}: the result is at rest, and its deviation has no derivative there.")
    here = np.array([value])
    for k in range(len(ORDERS)):

        def moved(number: float, k: int = k) -> np.ndarray:
            changed = moments.copy()
            changed[k] = number
            return np.array([at(changed, mean)])

        by_moments[k] = derivative(moved, float(moments[k]), here=here, what=label(item))[0]
    scale = max(abs(mean), float(np.sqrt(moments[0])))
    by_mean = derivative(lambda m: np.array([at(moments, m)]), mean, here=here, size=scale, what=label(item))[0]
    return value, by_moments, float(by_mean)
