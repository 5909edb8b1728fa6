"""Dynamic inflow: the induced speed of a rotor follows its loads with the delay of the wake."""

from __future__ import annotations

import numpy as np

from fowtlib.language import Array, Component, Number, Scalar, der, eq, initial, param, var
from fowtlib.language import math as m

COUPLING = 0.6
"""Oye's k: this part of a change of the quasi-steady induced speed enters the second filter at once."""


def _stations(inflow: DynamicInflow) -> tuple[int]:
    return (len(inflow.radius),)


class DynamicInflow(Component):
    """Oye's dynamic inflow: two filters in series between the quasi-steady and the acting induced speed of an annulus.

    With the quasi-steady speed W_qs, the mean of the blades at a station, the intermediate W_int and the acting W:
        W_int + tau_1 dW_int/dt = W_qs + k tau_1 dW_qs/dt, k = 0.6,     W + tau_2 dW/dt = W_int
        tau_1 = 1.1 / (1 - 1.3 a) R / V,     tau_2 = (0.39 - 0.26 (r/R)^2) tau_1
    with the mean axial induction factor a, at most 0.5, and the wind speed V along the shaft, at least
    `least_wind_speed`. Source: Oye (1990), in Snel and Schepers (1995, ECN-C--94-107) and Hansen (2008), Aerodynamics
    of Wind Turbines, chapter 9. The states are `delayed` = (W_int - k W_qs) / (1 - k), which needs no derivative of
    W_qs (tau_1 d delayed/dt = W_qs - delayed), and W.

    Two states for each station, whatever the number of blades: 34 for 17 stations. The wake belongs to the annulus,
    and the blades meet the same air in turn. Starts in the steady state.
    """

    memory = "dynamic inflow"

    radius: list = param(unit="m", doc="radii of the stations")
    length: list = param(unit="m", doc="lengths of the elements at the stations, weights of the mean induction")
    tip_radius: Number = param(unit="m", min=0, doc="radius R of the tips")
    least_wind_speed: Scalar = param(default=1.0, unit="m/s", min=0.01, doc="V is taken for at least this")

    quasi_steady: Array = var(unit="m/s", shape=_stations, doc="induced speed of the balance of momentum, W_qs")
    wind_speed: Scalar = var(unit="m/s", doc="relative wind along the shaft, averaged over the disk")
    delayed: Array = var(unit="m/s", shape=_stations, state="prefer", doc="quasi-steady speed behind the first filter")
    induced: Array = var(unit="m/s", shape=_stations, state="prefer", doc="acting induced speed, W")
    induction: Scalar = var(doc="mean axial induction factor, between 0 and 0.5")
    slow_time: Scalar = var(unit="s", doc="tau_1")

    def equations(self):
        radius, R = np.asarray(self.radius, dtype=float), self.tip_radius
        area = radius * np.asarray(self.length, dtype=float)
        fast = [float(share) for share in 0.39 - 0.26 * (radius / R) ** 2]  # tau_2 / tau_1
        speed = m.fmax(self.wind_speed, self.least_wind_speed)
        mean = sum(float(w) * self.induced[i] for i, w in enumerate(area / area.sum()))
        intermediate = COUPLING * self.quasi_steady + (1 - COUPLING) * self.delayed
        return [
            eq(self.induction, m.fmin(m.fmax(mean / speed, 0), 0.5)),
            eq(self.slow_time, 1.1 / (1 - 1.3 * self.induction) * R / speed),
            eq(self.slow_time * der(self.delayed), self.quasi_steady - self.delayed),
            [eq(share * self.slow_time * der(self.induced[i]), intermediate[i] - self.induced[i])
             for i, share in enumerate(fast)],
            initial(self.delayed, self.quasi_steady),
            initial(self.induced, self.quasi_steady),
        ]  # fmt: skip
