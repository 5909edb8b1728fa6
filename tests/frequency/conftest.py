"""An oscillator with a closed form of its response, that the tests of this folder share."""

from __future__ import annotations

import numpy as np

import fowtlib as fw
from fowtlib.language import Component, Number, Scalar, der, eq, param, quadratic, run_time_series, var

MASS, STIFFNESS, LINEAR = 3.0, 12.0, 0.3


class Push:
    """White noise up to a circular frequency, as a force."""

    def __call__(self, part):
        return None

    def process(self, part):
        return part

    def response(self, part, omega):
        return np.ones((len(omega), 1, 1), dtype=complex)


class Oscillator(Component):
    """M x'' + b x' + c |x'| x' + k x = a random force, white up to `highest`."""

    damping: Scalar = param(default=LINEAR, unit="N*s/m", doc="linear damping")
    drag: Scalar = param(default=0.0, unit="kg/m", doc="of the square of the speed")
    flow: Number = param(default=0.0, unit="m/s", doc="of what drags, against the velocity")
    stiffness: Scalar = param(default=STIFFNESS, unit="N/m", doc="of the spring")
    push: Scalar = param(default=0.0, unit="N", doc="a force that does not change")
    level: Number = param(default=2.0, bound=True, doc="one-sided spectrum of the force [N^2 s/rad]")
    highest: Number = param(default=60.0, bound=True, doc="circular frequency up to which the force has energy")

    x: Scalar = var(unit="m", start=0.0, doc="displacement")
    v: Scalar = var(unit="m/s", start=0.0, doc="velocity")

    def equations(self):
        force = run_time_series(self.time, 1, "push", Push(), of=self)
        resistance = self.damping * self.v + self.drag * quadratic(self.v + self.flow, 1e-6)
        return [
            eq(der(self.x), self.v),
            eq(MASS * der(self.v), force + self.push - resistance - self.stiffness * self.x),
        ]

    def spectral_density(self, omega):
        return np.where(np.asarray(omega) < self.highest, self.level, 0.0)


def oscillator(**parameters):
    root = fw.Assembly("oscillators")
    root.one = Oscillator(**parameters)
    return fw.Model(root, outputs={"x": "one.x", "v": "one.v"})
