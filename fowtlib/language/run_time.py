"""What a model takes in when a run starts: numbers and time series, computed then and not while it is flattened.

A model is flattened and compiled once; a seed, a file, a kind of wind change neither. `at_start` gives symbols whose
numbers are computed at the start of each run, from the component that stands in the model then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca
import numpy as np

from fowtlib.language.equations import AtStart, active
from fowtlib.language.errors import StructureError
from fowtlib.language.externals import ExternalFunction
from fowtlib.language.series import Series, series_function


class Source(Protocol):
    """Data that equations find by a number: what `compute` of `at_start` may return in place of numbers."""

    @property
    def numbers(self) -> tuple[float, ...]:
        """The numbers that the equations get; the first is the handle, under which the functions know the data."""

    def open_in(self, function: ExternalFunction) -> Any:
        """Make the data known to a function; they stay known as long as what is returned here lives."""

    def file_for(self, function: ExternalFunction) -> Any:
        """File, and further arguments, with which `<name>_open(handle, file, ...)` of a library finds the data."""


class RandomSignals(Protocol):
    """`compute` of a `run_time_series` whose signals follow a random process linearly: the frequency domain asks it.

    The process is a component with `spectral_density(omega)`, one-sided, of each of its channels and across them:
    (q,), or (q, channels, channels) [unit^2 s/rad].
    """

    def __call__(self, component: Any) -> Series | None:
        """The signals of one run."""

    def process(self, component: Any) -> Any:
        """The component of a run that they follow, from the one that `compute` is given."""

    def response(self, component: Any, omega: np.ndarray) -> np.ndarray:
        """Signals per channel at circular frequencies (q,) [rad/s]: complex (q, signals, channels), exp(+i omega t)."""


class SignalsOfNumbers(RandomSignals, Protocol):
    """Such signals that follow from few numbers of a part, as places of its strips: only these are differenced.

    With `number_slopes(component, tangent)`, the changes (n, m) of the numbers where parameters change by
    tangent(component, name), (size, m), NaN where they are not known, not even these are.
    """

    def numbers(self, component: Any) -> np.ndarray | None:
        """Numbers (n,) from which, and from what is `besides` them, all signals follow; None: they are not known."""

    def besides(self, component: Any) -> Any:
        """What else they follow from, as the depth of the water; which parameters that reads is noted."""

    def slopes(self, component: Any, omega: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """Slopes (m, q, signals, channels) along changes (m, n) of the numbers."""


@dataclass(frozen=True, eq=False)
class TurningRings:
    """Places that turn about an axis along a flow: on rings of radii (r,) [m] about a centre (3,), one for each blade.

    speed [rad/s]: of the turning. uniform (a, r) and once (b, r): sums of rings with weights, of what goes the same way
    all round and of what goes round, in place of each ring by itself. orders: multiples of the angle that count, 1 of
    what goes once round, 2 of what goes twice round too.
    """

    centre: np.ndarray
    radii: np.ndarray
    speed: float
    blades: int
    uniform: np.ndarray | None = None
    once: np.ndarray | None = None
    orders: int = 1

    @property
    def weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Weights (a, r) and (b, r); of rings by themselves ones."""
        alone = np.eye(len(self.radii))
        return alone if self.uniform is None else self.uniform, alone if self.once is None else self.once

    @property
    def channels(self) -> int:
        """Three a ring, or a + 2 b: uniform, and once round in two directions; 2 b more for each further order."""
        uniform, once = self.weights
        return len(uniform) + 2 * self.orders * len(once)


@dataclass(frozen=True, eq=False)
class RestingPlaces:
    """Places (n, 3) [m] that do not turn."""

    positions: np.ndarray

    @property
    def channels(self) -> int:
        """One a place."""
        return len(self.positions)


class RandomField(Protocol):
    """`compute` of the numbers by which an external function finds a field of velocities, which is random in a run.

    The function takes the handle first and positions last, (3 n); it gives n velocities. The frequency domain asks.
    """

    def process(self, component: Any) -> Any:
        """The component of a run whose field it is; one with a spectrum has `field_density`, see below."""

    parts: tuple[str, ...]
    """What the components of the velocity are called before the path of the process; "" for the path alone."""

    def axes(self, component: Any) -> np.ndarray:
        """Unit vectors (parts, 3) of the components, independent of each other: along the flow, across it, up."""

    def density(self, component: Any, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces],
                part: int = 0, basis: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
        """One-sided spectra (q, channels, channels) [unit^2 s/rad] of a component at all places, along axes; Hermitian.

        basis (channels, k): the spectra of the sums of channels with the weights of its columns, (q, k, k), instead.
        """


def at_start(name: str, size: int = 1, unit: str = "1", doc: str = "", compute: Callable[[Any], Any] = float, *,
             of: Any = None, functions: tuple[ExternalFunction, ...] = ()) -> ca.SX:  # fmt: skip
    """A column of `size` numbers that are computed when a run starts; constant in the run. Inside equations() only.

    `compute(component)` returns them: a number, a sequence of numbers, or a `Source`, whose data are then made known to
    the external `functions` that take its handle (None: a handle of 0, and zeros). The component is the one that stands
    at this place when the run starts, with the parameter values of the run, tunable and bound ones:
    `component.parameter_value("seed")`. It may be another one than is flattened now: `compute` must not hold one of
    these.

    unit: of all the numbers; "" where they have different ones.
    of: the component that is given to `compute`, where that is not the one whose equations are written. Numbers of that
    component asked for again by the same name are the same symbols, and `compute` counts the first time only.
    """
    for cell in getattr(compute, "__closure__", None) or ():
        try:
            held = cell.cell_contents
        except ValueError:  # not assigned yet
            continue
        if hasattr(held, "_binding") and hasattr(held, "parameter_value"):
            raise StructureError(
                f"at_start('{name}'): its function uses {held.label} of the model that is being flattened; use the "
                "component that it is given, which stands there when a run starts."
            )
    return active().at_start(AtStart(name, size, unit, doc, compute, of, tuple(functions)))


def series_handle(name: str) -> str:
    """Under which name the handle of a `run_time_series` is found."""
    return f"{name} handle"


def run_time_series(time: Any, size: int, name: str, compute: Callable[[Any], Series | None], *,
                    of: Any = None, message: str = "") -> ca.SX:  # fmt: skip
    """A column of `size` signals of time, from the Series that `compute(component)` returns when a run starts.

    None stands for zeros. A run past the ends of a series that does not repeat itself stops there, with `message`, in
    which {value} is the time, {low} and {high} are the ends, and {path of a bound parameter} is its value. See
    `at_start` for the component, and for `of`.
    """
    function = series_function(size)
    handle, low, high = ca.vertsplit(
        at_start(
            series_handle(name), 3, "", f"{name}: handle, first and last time", compute, of=of, functions=(function,)
        )
    )
    active().check_range(time, low, high, name, "time", message)
    return function(handle=handle, time=time)["values"]
