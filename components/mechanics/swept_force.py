"""A force and a moment on a frame that sweep through a band of frequencies: how a body answers, without waves."""

from __future__ import annotations

import math

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, Scalar, Vector, assert_, eq, param, port, var
from fowtlib.language import math as m


class SweptForce(Component):
    """A swept sine on a frame, in the axes of the world; it acts at the origin of the frame, on the part joined there.

    share(t) = window(t) sin(phase(t)) with the frequency f1 at start_time and f2 at start_time + duration, which
    rises linearly in time ("linear": the same energy at each frequency) or by the same factor in the same time
    ("logarithmic": the same number of cycles in each octave). The window grows and fades by 10 s^3 - 15 s^4 + 6 s^5 in
    `ramp` seconds at both ends; before and after there is none. The load is rest_force + share force, and the same of
    the moment; rest_force and rest_moment are also what a linear model takes as inputs, see analysis.swept.
    """

    force: Vector = param(default=(0, 0, 0), unit="N", doc="amplitude of the force on the part joined, world")
    moment: Vector = param(default=(0, 0, 0), unit="N*m", doc="amplitude of the moment on the part joined, world")
    rest_force: Vector = param(default=(0, 0, 0), unit="N", doc="force at all times beside it")
    rest_moment: Vector = param(default=(0, 0, 0), unit="N*m", doc="moment at all times beside it")
    f1: Scalar = param(unit="Hz", min=1e-6, doc="frequency at the beginning")
    f2: Scalar = param(unit="Hz", min=1e-6, doc="frequency at the end")
    start_time: Scalar = param(default=0.0, unit="s", min=0, doc="begin of the sweep")
    duration: Scalar = param(unit="s", min=1e-3, doc="length of the sweep")
    strength: Scalar = param(default=1.0, doc="factor on the sweep; 0: none, as for an equilibrium")
    ramp: Scalar = param(default=lambda self: self.duration / 20, unit="s", min=1e-6, doc="growth and fading")
    sweep: str = param(default="logarithmic", choices=("linear", "logarithmic"), doc="how the frequency changes")

    frame: Frame = port(doc="where the load acts")

    driven: Scalar = var(discrete=True, start=strength, doc="factor on the sweep; 0: none")
    share: Scalar = var(doc="of the amplitudes, now")

    def in_the_mean(self):
        return {"strength": 0.0}

    def equations(self):
        now = m.fmin(m.fmax(self.time - self.start_time, 0.0), self.duration)
        grown = _smooth(m.fmin(now, self.duration - now) / self.ramp)
        return [
            eq(self.share, self.driven * grown * m.sin(self._phase(now))),
            eq(self.frame.f, -(self.rest_force + self.share * self.force)),
            eq(self.frame.t, -(self.rest_moment + self.share * self.moment)),
            assert_(self.duration >= 2 * self.ramp, "the two ramps of the sweep are longer than the sweep"),
            assert_((self.f2 / self.f1 - 1) ** 2 > 1e-6, "f1 and f2 of the sweep are the same frequency"),
        ]

    def _phase(self, now):
        """Phase [rad] at a time since the begin: 2 pi times the integral of the frequency."""
        if self.sweep == "linear":
            return 2 * math.pi * (self.f1 + (self.f2 - self.f1) * now / (2 * self.duration)) * now
        octaves = m.log(self.f2 / self.f1)
        return 2 * math.pi * self.f1 * self.duration / octaves * (m.exp(octaves * now / self.duration) - 1)


def _smooth(share):
    share = m.fmin(share, 1)
    return share**3 * (10 - 15 * share + 6 * share**2)
