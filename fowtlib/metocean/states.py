"""States of the environment: rows of wind speed, significant wave height and peak period, with what belongs to them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fowtlib.language.errors import ParameterError

COLUMNS = {"wind_speed": "m/s", "Hs": "m", "Tp": "s"}
"""Names of what a state is made of, in tables and labels of cases, and their units."""

PARAMETERS = {
    "wind_speed": "wind.mean_speed",
    "Hs": "sea.significant_wave_height",
    "Tp": "sea.peak_period",
    "turbulence_intensity": "wind.turbulence_intensity",
}
"""The parameters that these are in a model with a part ``wind`` and a part ``sea``, by path."""

YEAR = 365.25 * 24 * 3600.0
"""A year [s], the mean of four."""


class State(NamedTuple):
    """One state: mean wind speed [m/s], significant wave height [m], peak period [s]."""

    wind_speed: float
    wave_height: float
    peak_period: float


@dataclass(frozen=True)
class States:
    """States as arrays of equal length.

    wind_speed [m/s], significant wave height [m], peak period [s]. probability: of each state at any time; None where
    the states are points of a contour. turbulence_intensity: of each, None where it follows from the wind.
    """

    wind_speed: np.ndarray
    wave_height: np.ndarray
    peak_period: np.ndarray
    probability: np.ndarray | None = None
    turbulence_intensity: np.ndarray | None = None

    def __post_init__(self):
        for name in ("wind_speed", "wave_height", "peak_period", "probability", "turbulence_intensity"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, np.atleast_1d(np.asarray(value, dtype=float)))
                if getattr(self, name).shape != self.wind_speed.shape or self.wind_speed.ndim != 1:
                    raise ParameterError(
                        f"states: wind_speed has {self.wind_speed.shape} values, and {name} has "
                        f"{getattr(self, name).shape}; one of each is needed."
                    )
        if self.probability is not None and ((self.probability < 0).any() or self.probability.sum() > 1 + 1e-6):
            raise ParameterError(
                f"states: probabilities are not negative and of sum 1 at most; these have the sum "
                f"{self.probability.sum():.6g}."
            )

    def __len__(self) -> int:
        return self.wind_speed.size

    def __iter__(self) -> Iterator[State]:
        for row in zip(self.wind_speed, self.wave_height, self.peak_period, strict=True):
            yield State(*map(float, row))

    def __getitem__(self, chosen: int | slice | np.ndarray | Sequence[int]) -> States:
        """Some of the states, by index, slice or mask; each once, since they keep their probabilities."""
        index = [chosen] if isinstance(chosen, (int, np.integer)) else chosen
        some = {name: getattr(self, name) for name in self._columns()}
        return replace(self, **{name: value[index] for name, value in some.items()})

    def __add__(self, other: States) -> States:
        """These states and others behind them, both with probabilities or both without, and so on."""
        if self._columns() != other._columns():
            raise ParameterError("states: only states with the same columns can be put together.")
        return States(**{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in self._columns()})

    def run_parameters(self) -> list[dict[str, float]]:
        """Parameters of a run in each state, for models with a part ``wind`` and a part ``sea``."""
        rows = [dict(zip((PARAMETERS[name] for name in COLUMNS), state, strict=True)) for state in self]
        if self.turbulence_intensity is not None:
            for row, intensity in zip(rows, self.turbulence_intensity.tolist(), strict=True):
                row[PARAMETERS["turbulence_intensity"]] = intensity
        return rows

    @property
    def left_out(self) -> float:
        """Probability of no state of these."""
        return max(0.0, 1.0 - float(self.weights.sum()))

    @property
    def weights(self) -> np.ndarray:
        """The probabilities; ParameterError where there are none."""
        if self.probability is None:
            raise ParameterError("these states have no probabilities: they are points of a contour, not bins.")
        return self.probability

    def _columns(self) -> list[str]:
        names = ("wind_speed", "wave_height", "peak_period", "probability", "turbulence_intensity")
        return [name for name in names if getattr(self, name) is not None]


def occurrences(return_period: float, duration: float) -> float:
    """How many states of a duration [s] a return period [years] has."""
    if not (return_period > 0 and duration > 0 and return_period * YEAR > 2 * duration):
        raise ParameterError(
            f"a return period of {return_period:g} years and states of {duration:g} s: both must be "
            "positive, and the return period longer than two states."
        )
    return return_period * YEAR / duration
