"""Irregular waves of the JONSWAP spectrum."""

from __future__ import annotations

import warnings
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.sea.base import Sea
from fowtlib.components.environment.waves import WaveComponents, irregular_waves, jonswap, steepest_sea
from fowtlib.language import Number, param
from fowtlib.language.bounds import POSITIVE

_realisation = lru_cache(maxsize=8)(irregular_waves)


class JonswapSea(Sea, kind="jonswap"):
    """One realisation of a JONSWAP sea, which repeats itself after `repetition_period`.

    A warning tells when a run is longer. Frequencies, cut-off and random numbers: see waves.irregular_waves.
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

    def components(self) -> WaveComponents:
        names = ("gamma", "seed", "random_amplitudes", "repetition_period")
        options = {name: self.parameter_value(name) for name in names}
        options |= {"heading": self.wave_heading(), "gravity": self.world.gravity}
        return _realisation(*self.state(), self.world.water_depth, **options)

    def state(self) -> tuple[float, float]:
        """Hs [m] and Tp [s]."""
        return self.given("significant_wave_height"), self.given("peak_period")

    def longest_run(self) -> float:
        return self.parameter_value("repetition_period")

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        return jonswap(omega, *self.state(), self.gamma)

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
