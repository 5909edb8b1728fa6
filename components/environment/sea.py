"""The sea state of a model: still water, regular waves or one realisation of a JONSWAP sea."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.time_functions import progress, smooth_step, warn_of_repetition
from fowtlib.components.environment.waves import WaveComponents, irregular_waves, regular_waves, still_water
from fowtlib.components.environment.world import World
from fowtlib.language import Component, Number, RealOutput, eq, open_input, outer, param, port, shapes, time_series
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    import casadi as ca

CLOSED_FORM = 4  # so many components at most are written as cosines; more become a spline in time

_jonswap = lru_cache(maxsize=8)(irregular_waves)


class Sea(Component):
    """Long-crested linear waves in finite depth; parts that the sea moves find it by `sea: Sea = outer(Sea)`.

    elevation = sum_k a_k cos(omega_k t - k_k (x cos(heading) + y sin(heading)) + phase_k). Everything about a sea state
    is structural: waves are a fixed set of numbers when the model is built. A regular wave has a crest at the origin at
    t = 0. A JONSWAP sea repeats itself after `repetition_period` (a warning tells when a run is longer), see
    waves.irregular_waves for its frequencies, its cut-off and its random numbers. `build_up` lets the waves grow from
    nothing after t = 0, so that a run can start from rest without a shock. With the spectrum "input" all that the parts
    ask of the sea comes from outside of the model: the elevation, each wave load, the velocity of the water at each
    point; a wave generator drives them.
    """

    spectrum: str = param(default="still", choices=("still", "regular", "jonswap", "input"), doc="kind of sea state")
    wave_height: Number = param(default=None, unit="m", min=0, doc="regular waves: height from trough to crest")
    wave_period: Number = param(default=None, unit="s", min=0, doc="regular waves: period")
    significant_wave_height: Number = param(default=None, unit="m", min=0, doc="JONSWAP: Hs")
    peak_period: Number = param(default=None, unit="s", min=0, doc="JONSWAP: Tp")
    gamma: Number = param(default=None, min=1, doc="JONSWAP: peak factor; without a value by DNV-RP-C205, 3.5.5.5")
    heading: Number = param(default=0.0, unit="rad", doc="direction in which the waves travel, from x towards y")
    seed: int = param(default=1, min=0, doc="JONSWAP: number of the realisation")
    random_amplitudes: bool = param(default=True, doc="JONSWAP: Gaussian sea; false: random phases only")
    repetition_period: Number = param(default=4096.0, unit="s", min=0, doc="JONSWAP: period of the realisation")
    build_up: Number = param(default=0.0, unit="s", min=0, doc="time in which the waves grow from nothing")

    world: World = outer(World)
    elevation: RealOutput = port(unit="m", doc="elevation of the water at the origin")

    def equations(self):
        waves = self.components()
        _warn_of_breaking(self, waves)
        longer = [warn_of_repetition(self.time, waves.period, "sea")] if self.spectrum == "jonswap" else []
        return [eq(self.elevation, self.signal(np.ones((len(waves), 1)), "wave elevation", "m")), *longer]

    def drawing(self) -> shapes.Drawing:
        waves = self.components()
        harmonics = (waves.omega, waves.amplitude, waves.phase, waves.wave_number)
        return [shapes.Water(self.world.water_depth, *harmonics, heading=self.heading, build_up=self.build_up)]

    def components(self) -> WaveComponents:
        """The harmonics of this sea as numbers."""
        depth, gravity = self.world.water_depth, self.world.gravity
        if self.spectrum in ("still", "input"):
            return still_water(depth, self.heading)
        if self.spectrum == "regular":
            height, period = _given(self, "wave_height"), _given(self, "wave_period")
            return regular_waves(height, period, depth, heading=self.heading, gravity=gravity)
        options = {name: getattr(self, name) for name in ("gamma", "heading", "seed", "random_amplitudes")}
        height, period = _given(self, "significant_wave_height"), _given(self, "peak_period")
        return _jonswap(height, period, depth, gravity=gravity, repetition_period=self.repetition_period, **options)

    def signal(self, transfer: ArrayLike, name: str = "wave signal", unit: str = "1") -> ca.SX:
        """The time function of m quantities, a column of m, while the model is flattened.

        transfer: complex (n, m), per unit amplitude at the frequencies of `components()`, with exp(+i omega t):
        sum_k Re(a_k exp(i (omega_k t + phase_k)) transfer_k). Many components become a periodic cubic spline through
        the inverse FFT. Columns that are zero cost nothing.
        """
        if self.spectrum == "input":
            return open_input(name.replace(" ", "_"), np.shape(transfer)[1], unit, f"{name} from outside")
        waves = self.components()
        columns = waves.columns(transfer)
        size = np.max(np.abs(columns), axis=0, initial=0.0)
        alive = np.flatnonzero(size > 1e-14 * np.max(size, initial=0.0))
        value = m.zeros(columns.shape[1])
        if len(alive):
            value[alive.tolist()] = _time_function(self, waves, columns[:, alive], name)
        return value

    def loads(self, transfer: ArrayLike, name: str = "wave load") -> ca.SX:
        """The time function of a force and a moment, a column of 6 [N, N m]; transfer: (n, 6), as for `signal`."""
        if self.spectrum != "input":
            return self.signal(transfer, name)
        transfer = np.asarray(transfer)
        force = self.signal(transfer[:, :3], f"{name} force", "N")
        return m.vertcat(force, self.signal(transfer[:, 3:], f"{name} moment", "N*m"))

    def velocity(self, points: ArrayLike) -> ca.SX:
        """Velocity of the water (p x 3, world) at fixed `points` (p, 3) [m] with z <= 0; zero above the water level."""
        return self._kinematics(self.components().velocity_transfer(points), "water velocity", "m/s")

    def acceleration(self, points: ArrayLike) -> ca.SX:
        """Local acceleration of the water (p x 3, world) at fixed `points` (p, 3) [m]; zero above the water level."""
        return self._kinematics(self.components().acceleration_transfer(points), "water acceleration", "m/s^2")

    def _kinematics(self, transfer: np.ndarray, name: str, unit: str) -> ca.SX:
        n, points, _ = transfer.shape
        value = self.signal(transfer.transpose(0, 2, 1).reshape(n, 3 * points), name, unit)
        return m.horzcat(value[:points], value[points : 2 * points], value[2 * points :])


def _warn_of_breaking(sea: Sea, waves: WaveComponents) -> None:
    """Waves that cannot be: higher than Miche's 0.142 L tanh(k h), a sea steeper than DNV-RP-C205 knows."""
    if sea.spectrum == "regular" and len(waves):
        k = float(waves.wave_number[0])
        length, height = 2 * np.pi / k, sea.wave_height
        highest = 0.142 * length * np.tanh(k * waves.depth)
        what = f"a wave {length:.3g} m long breaks at {highest:.2g} m, and has {height:.3g} m here"
    elif sea.spectrum == "jonswap":
        height, length = sea.significant_wave_height, sea.world.gravity * sea.peak_period**2 / (2 * np.pi)
        highest = length * np.interp(sea.peak_period, [8, 15], [1 / 15, 1 / 25])
        what = f"Hs {height:.3g} m is too steep a sea for Tp {sea.peak_period:g} s, where {highest:.2g} m is the limit"
    else:
        return
    if height > highest:
        warnings.warn(f"{sea.label}: {what}; linear waves go on as if nothing was.", stacklevel=3)


def _time_function(sea: Sea, waves: WaveComponents, columns: np.ndarray, name: str) -> ca.SX:
    if len(waves) <= CLOSED_FORM:
        weighted = waves.complex_amplitude[:, None] * columns
        terms = zip(waves.omega.tolist(), weighted, strict=True)
        value = sum(m.cos(w * sea.time) * c.real - m.sin(w * sea.time) * c.imag for w, c in terms)
    else:
        step = waves.period / waves.samples
        value = time_series(sea.time, 0.0, step, waves.series(columns), periodic=True, name=f"{sea.path} {name}")
    return value * smooth_step(progress(sea.time, 0, sea.build_up)) if sea.build_up > 0 else value


def _given(sea: Sea, name: str) -> float:
    value = getattr(sea, name)
    if value is None:
        doc = sea.parameters[name].doc
        raise ParameterError(f"{sea.label}.{name} has no value; a sea of kind '{sea.spectrum}' needs it ({doc}).")
    return value
