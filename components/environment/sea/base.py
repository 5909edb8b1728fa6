"""Sea: what every kind of sea state has, and what the parts in the water ask of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.waves import WaveComponents, still_water, unit_waves
from fowtlib.components.environment.wind.base import Wind
from fowtlib.components.environment.world import World
from fowtlib.language import (
    Component,
    Number,
    RealOutput,
    Series,
    assert_,
    at_start,
    eq,
    outer,
    param,
    port,
    run_time_series,
    shapes,
)
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError
from fowtlib.language.expressions import value_of

if TYPE_CHECKING:
    import casadi as ca

CLOSED_FORM = 4  # so many components at most are summed as harmonics; more become a spline in time

Transfer = Callable[..., ArrayLike]


class Sea(Component, selector="spectrum", shared=("signal", "loads", "velocity", "acceleration")):
    """Linear waves in finite depth; parts that the sea moves find it by `sea: Sea = outer(Sea)`.

    elevation = sum_k a_k cos(omega_k t - k_k (x cos(heading) + y sin(heading)) + phase_k). A kind of sea gives the
    amplitudes and phases as numbers: `components()`, and, where it is short-crested, directions. They are computed when
    a run starts, and stand in no equation, so that the sea of a compiled model may be another one in every run.
    `build_up` lets the waves grow from nothing after t = 0, so that a run can start from rest without a shock.
    """

    spectrum: str = param(default="still", bound=True, doc="kind of sea state")
    heading: Number = param(
        default=0.0, unit="rad", bound=True, doc="direction in which the waves travel, from x towards y"
    )
    misalignment: Number = param(
        default=None, unit="rad", bound=True, instead_of=("heading",), doc="heading less the direction of the wind"
    )
    build_up: Number = param(default=0.0, unit="s", min=0, bound=True, doc="time in which the waves grow from nothing")

    world: World = outer(World)
    winds: list[Wind] = outer(Wind, many=True)
    elevation: RealOutput = port(unit="m", doc="elevation of the water at the origin")

    if TYPE_CHECKING:  # the class of the kind takes further parameters

        def __init__(self, **parameters: Any) -> None: ...

    def equations(self):
        longest = at_start("longest run", 1, "s", "duration after which the waves are repeated", _longest, of=self)
        told = "the sea repeats itself after {longest} s; take a longer repetition_period or record."
        warning = replace(assert_(self.time < longest * (1 + 1e-9), told, level="warning"), values={"longest": longest})
        elevation = self.signal(lambda waves: np.ones((len(waves), 1)), 1, "wave elevation", "m")
        return [eq(self.elevation, elevation), warning]

    def drawing(self) -> shapes.Drawing:
        return [_water(self)]

    def components(self) -> WaveComponents:
        """The harmonics of this sea as numbers; not inside equations()."""
        return still_water(self.world.water_depth, self.wave_heading())

    def wave_heading(self) -> float:
        """Direction [rad] in which the waves travel: given, or by the direction of the wind before it turns."""
        if self.misalignment is None:
            return float(self.heading)
        return float(self.misalignment + the_wind(self, "misalignment").parameter_value("direction"))

    def headings(self) -> tuple[float, ...]:
        """Directions [rad] in which waves travel: one, or those that a short-crested sea is shared among."""
        return (self.wave_heading(),)

    def water(self) -> tuple[float, tuple[float, ...], float]:
        """Depth [m], headings [rad] and gravity [m/s^2], by which all harmonics of this sea go."""
        return float(self.world.water_depth), self.headings(), float(self.world.gravity)

    def in_the_mean(self) -> dict[str, Any]:
        """Still water."""
        return {"spectrum": "still", "heading": 0.0, "build_up": 0.0}

    def longest_run(self) -> float:
        """Duration [s] after which the waves are not new any more; infinite where they need not be."""
        return math.inf

    def warn(self) -> None:
        """Warn of a sea that cannot be; called when a run starts."""

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        """One-sided spectrum [m^2 s/rad] of the elevation at omega [rad/s]; zero where the sea has none.

        Of a short-crested sea the spectra of its `headings`, (..., headings, headings); they add up to that of the
        elevation.
        """
        return np.zeros(np.shape(omega))

    def signal(
        self, transfer: Transfer, columns: int, name: str = "wave signal", unit: str = "1", *, of: Any = None
    ) -> ca.SX:
        """The time function of so many quantities, a column; inside equations() of any part.

        transfer(waves): complex (n, columns), per unit amplitude at the frequencies of the waves (`WaveComponents`),
        with exp(+i omega t): sum_k Re(a_k exp(i (omega_k t + phase_k)) transfer_k). It is called when a run starts, for
        the sea of that run. `of`: a part whose values of that run it needs: transfer(waves, part); `name` must then be
        one that this part uses once. A transfer that follows from the waves and from numbers of the part alone may say
        so, see WaterAtStrips: slopes by sizes of the part are then made of those of its numbers. Many components become
        a periodic cubic spline through the inverse FFT.
        """
        signals = WaveSignals(self.path, transfer, of is not None)
        return run_time_series(self.time, columns, name, signals, of=of)

    def loads(self, transfer: Transfer, name: str = "wave load", *, motions: int = 6, of: Any = None) -> ca.SX:
        """The time function of a force, a moment and loads on further motions, a column [N, N m, N].

        transfer: (n, motions), as for `signal`.
        """
        return self.signal(transfer, motions, name, "", of=of)

    def velocity(self, points: ArrayLike) -> ca.SX:
        """Velocity of the water (p x 3, world) at fixed `points` (p, 3) [m] with z <= 0; zero above the water level."""
        return _kinematics(self, "velocity", points, "m/s")

    def acceleration(self, points: ArrayLike) -> ca.SX:
        """Local acceleration of the water (p x 3, world) at fixed `points` (p, 3) [m]; zero above the water level."""
        return _kinematics(self, "acceleration", points, "m/s^2")

    def given(self, name: str) -> Any:
        """The value of a parameter that this kind of sea cannot do without."""
        value = self.parameter_value(name)
        if value is None or (isinstance(value, str) and not value):
            kind, doc = type(self).family.kind_of(type(self)), self.parameters[name].doc
            raise ParameterError(f"{self.label}.{name} has no value; a sea of kind '{kind}' needs it ({doc}).")
        return value


@dataclass(frozen=True)
class WaveSignals:
    """Signals of the waves of the sea at `path`, when a run starts; see RandomSignals of fowtlib.language.run_time."""

    path: str
    transfer: Transfer
    wants_part: bool

    def __call__(self, part: Component) -> Series | None:
        sea = self.process(part)
        waves = sea.components()
        if not len(waves):
            return None
        table = waves.by_direction(lambda alike: self._table(alike, part))
        return _series(waves, table, sea.parameter_value("build_up"))

    def process(self, part: Component) -> Any:
        return [part, *part.enclosing()][-1].find(self.path)

    def response(self, part: Component, omega: np.ndarray) -> np.ndarray:
        return np.stack([self._table(waves, part) for waves in self._unit_waves(omega, part)], axis=-1)

    def numbers(self, part: Component) -> np.ndarray | None:
        found = getattr(self.transfer, "numbers", None)
        return None if found is None else found(part)

    def number_slopes(self, part: Component, tangent: Any) -> np.ndarray | None:
        found = getattr(self.transfer, "number_slopes", None)
        return None if found is None else found(part, tangent)

    def besides(self, part: Component) -> tuple[float, tuple[float, ...], float]:
        sea = self.process(part)
        return value_of(sea, "water", sea.water)

    def slopes(self, part: Component, omega: np.ndarray, moved: np.ndarray) -> np.ndarray:
        slopes = [self.transfer.slopes(waves, part, moved) for waves in self._unit_waves(omega, part)]
        return np.stack(slopes, axis=-1)

    def _unit_waves(self, omega: np.ndarray, part: Component) -> list[WaveComponents]:
        depth, headings, gravity = self.besides(part)
        return [unit_waves(omega, depth, heading, gravity) for heading in headings]

    def _table(self, waves: WaveComponents, part: Component) -> np.ndarray:
        return waves.columns(self.transfer(waves, part) if self.wants_part else self.transfer(waves))


def the_wind(sea: Sea, needed_by: str) -> Wind:
    """The wind of the model; ParameterError, which names the parameter that needs it, where there is not one."""
    if len(sea.winds) != 1:
        raise ParameterError(
            f"{sea.label}.{needed_by} goes by the wind, and the model has {len(sea.winds) or 'no'} parts of class Wind."
        )
    return sea.winds[0]


def _water(sea: Sea) -> shapes.Water:
    waves = sea.components()
    along = np.cos(waves.directions) if waves.directions is not None else 1.0  # as on the line along the heading
    harmonics = (waves.omega, waves.amplitude, waves.phase, waves.wave_number * along)
    return shapes.Water(sea.world.water_depth, *harmonics, heading=waves.heading, build_up=sea.build_up)


def _kinematics(sea: Sea, what: str, points: ArrayLike, unit: str) -> ca.SX:
    places = np.atleast_2d(np.array(points, dtype=float))
    count = len(places)

    def transfer(waves: WaveComponents) -> np.ndarray:
        table = getattr(waves, f"{what}_transfer")(places)
        return table.transpose(0, 2, 1).reshape(len(waves), 3 * count)

    value = sea.signal(transfer, 3 * count, f"water {what}", unit)
    return m.horzcat(value[:count], value[count : 2 * count], value[2 * count :])


def _longest(sea: Sea) -> float:
    sea.warn()
    return sea.longest_run()


def _series(waves: WaveComponents, table: np.ndarray, build_up: float) -> Series:
    if len(waves) <= CLOSED_FORM:
        return Series.harmonics(waves.omega, waves.complex_amplitude[:, None] * table, build_up=build_up)
    return Series.fourier(waves.spectrum(table), waves.samples, waves.period / waves.samples, build_up=build_up)
