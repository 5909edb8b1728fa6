"""Regular waves."""

from __future__ import annotations

import warnings

import numpy as np

from fowtlib.components.environment.sea.base import Sea
from fowtlib.components.environment.waves import WaveComponents, breaking_height, regular_waves
from fowtlib.language import Number, param
from fowtlib.language.bounds import POSITIVE


class RegularWaves(Sea, kind="regular"):
    """One harmonic, with a crest at the origin at t = 0."""

    wave_height: Number = param(
        default=None, unit="m", min=0, bound=True, doc="regular waves: height from trough to crest"
    )
    wave_period: Number = param(default=None, unit="s", min=POSITIVE, bound=True, doc="regular waves: period")

    def components(self) -> WaveComponents:
        (height, period), world = self.wave(), self.world
        return regular_waves(height, period, world.water_depth, heading=self.wave_heading(), gravity=world.gravity)

    def wave(self) -> tuple[float, float]:
        """Height [m] from trough to crest, and period [s]."""
        return self.given("wave_height"), self.given("wave_period")

    def warn(self) -> None:
        """Of waves higher than Miche's limit, 0.142 L tanh(k h)."""
        waves, (height, _) = self.components(), self.wave()
        length = 2 * np.pi / float(waves.wave_number[0])
        highest = breaking_height(waves.period, waves.depth, self.world.gravity)
        if height > highest:
            warnings.warn(
                f"{self.label}: a wave {length:.3g} m long breaks at {highest:.2g} m, and has {height:.3g} m here; "
                "linear waves go on as if nothing was.",
                stacklevel=3,
            )
