"""Irregular waves of the JONSWAP spectrum."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.sea.base import Sea
from fowtlib.components.environment.spreading import directions_of, spread_directions
from fowtlib.components.environment.waves import WaveComponents, irregular_waves, jonswap, steepest_sea
from fowtlib.language import Number, param
from fowtlib.language.bounds import POSITIVE

_realisation = lru_cache(maxsize=8)(irregular_waves)


class JonswapSea(Sea, kind="jonswap"):
    """One realisation of a JONSWAP sea, which repeats itself after `repetition_period`.

    A warning tells when a run is longer. Frequencies, cut-off and random numbers: see waves.irregular_waves. With an
    exponent of `spreading` it is short-crested: see environment.spreading.
    """

    significant_wave_height: Number = param(default=None, unit="m", min=0, bound=True, doc="JONSWAP: Hs")
    peak_period: Number = param(default=None, unit="s", min=POSITIVE, bound=True, doc="JONSWAP: Tp")
    gamma: Number = param(
        default=None, min=1, bound=True, doc="JONSWAP: peak factor; without a value by DNV-RP-C205, 3.5.5.5"
    )
    seed: int = param(default=1, min=0, bound=True, doc="JONSWAP: number of the realisation")
    random_amplitudes: bool = param(default=True, bound=True, doc="JONSWAP: Gaussian sea; false: random phases only")
    repetition_period: Number = param(
        default=4096.0, unit="s", min=POSITIVE, bound=True, doc="JONSWAP: period of the realisation"
    )
    spreading: Number = param(
        default=None, min=1, max=1000, bound=True, doc="JONSWAP: n of cos^n about the heading; none: long-crested"
    )
    directions: int = param(default=9, min=2, max=99, bound=True, doc="JONSWAP: so many share the spread energy")

    def components(self) -> WaveComponents:
        names = ("gamma", "seed", "random_amplitudes", "repetition_period")
        options = {name: self.parameter_value(name) for name in names}
        options |= {"heading": self.wave_heading(), "gravity": self.world.gravity}
        waves = _realisation(*self.state(), self.world.water_depth, **options)
        if self.spreading is None:
            return waves
        harmonics = np.rint(waves.omega * waves.period / (2 * np.pi))
        directions = directions_of(harmonics, float(self.spreading), self.directions, int(options["seed"]))
        return replace(waves, directions=directions)

    def headings(self) -> tuple[float, ...]:
        main = self.wave_heading()
        if self.spreading is None:
            return (main,)
        return tuple((main + spread_directions(float(self.spreading), self.directions)[0]).tolist())

    def state(self) -> tuple[float, float]:
        """Hs [m] and Tp [s]."""
        return self.given("significant_wave_height"), self.given("peak_period")

    def longest_run(self) -> float:
        return self.parameter_value("repetition_period")

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        whole = jonswap(omega, *self.state(), self.gamma)
        if self.spreading is None:
            return whole
        shares = spread_directions(float(self.spreading), self.directions)[1]
        return whole[..., None, None] * np.diag(shares)

    def warn(self) -> None:
        """Of a sea steeper than DNV-RP-C205 knows, 3.5.4."""
        height, period = self.state()
        highest = steepest_sea(period, self.world.gravity)
        if height > highest:
            warnings.warn(
                f"{self.label}: Hs {height:.4g} m is too steep a sea for Tp {period:g} s, where {highest:.4g} m is the "
                "limit; linear waves go on as if nothing was.",
                stacklevel=3,
            )
