"""PI gains of a pitch controller that fall with the blade pitch."""

from __future__ import annotations

from fowtlib.language import Component, Scalar, param
from fowtlib.language.bounds import POSITIVE


class ScheduledGains(Component):
    """Partial: K_P and K_I at zero pitch, and G = 1 / (1 + pitch / doubling_pitch + schedule_curvature pitch^2).

    `scheduled: pitch`: pitch = G (K_P e + x), x' = K_I e, with the speed error e; for small changes the gains fall
    faster than G. Source: J. Jonkman et al., NREL/TP-500-38060 (2009), section 7.3, without curvature.
    `scheduled: gains`: pitch = G K_P e + x, x' = G K_I e; for small changes the gains are G times those at zero pitch.
    Source: M. H. Hansen and L. C. Henriksen, DTU Wind Energy E-0028 (2013).
    """

    proportional_gain: Scalar = param(unit="s", doc="K_P at zero pitch")
    integral_gain: Scalar = param(doc="K_I at zero pitch")
    doubling_pitch: Scalar = param(
        default=0.1099965, unit="rad", min=POSITIVE, doc="pitch at which the gains are halved"
    )
    schedule_curvature: Scalar = param(
        default=0.0, unit="1/rad^2", min=0, doc="factor of the square of the pitch in 1 / G"
    )
    scheduled: str = param(
        default="pitch", choices=("pitch", "gains"), doc="what G multiplies: the pitch with its integral, or both gains"
    )

    def gain_at(self, pitch):
        """G at a blade pitch."""
        return 1 / (1 + pitch / self.doubling_pitch + self.schedule_curvature * pitch**2)

    def integral_of(self, pitch):
        """The integral with which a pitch stays as it is at rated speed."""
        return pitch if self.scheduled == "gains" else pitch / self.gain_at(pitch)

    def law(self, error, integrated, pitch, integral):
        """Rate of the integral, the pitch that a speed error and an integral ask for, and pitch over integral.

        error: that of the proportional part; integrated: that of the integral.
        """
        gain = self.gain_at(pitch)
        if self.scheduled == "gains":
            return gain * self.integral_gain * integrated, gain * self.proportional_gain * error + integral, 1
        return self.integral_gain * integrated, gain * (self.proportional_gain * error + integral), gain
