"""Individual pitch: a part for each blade that takes the once-per-turn load off it."""

from __future__ import annotations

import math

from fowtlib.components.servo.antiwindup import held_within
from fowtlib.components.servo.measurements import MomentMeasurement
from fowtlib.language import Array, Component, RealInput, RealOutput, Scalar, der, eq, initial, param, parts, port, var
from fowtlib.language import math as m


class IndividualPitchController(Component):
    """PI control of the tilt and yaw moments of a rotor by a pitch that goes round once per turn.

    With psi_k = azimuth + 2 pi k / blades the root moments give tilt = 2/n sum M_k cos psi_k and yaw = 2/n sum M_k
    sin psi_k (Coleman); each has a pitch K_P M + x, x' = K_I M, and blade k gets pitch_tilt cos(psi_k + lead) +
    pitch_yaw sin(psi_k + lead). More flapwise moment asks for more pitch, so gains are positive. Both pitches stay
    within greatest_pitch, and x does not wind up there. While it is not enabled, x fades out within fade_time.
    Each moment goes through a sensor, which may fail (`sensor_1` and so on).
    Source: E. A. Bossanyi, Wind Energy 6 (2003) 119.
    """

    memory = "individual pitch"

    blades: int = param(default=3, min=2, doc="number of blades")
    proportional_gain: Scalar = param(default=0.0, unit="rad/(N*m)", min=0, doc="K_P")
    integral_gain: Scalar = param(unit="rad/(N*m*s)", min=0, doc="K_I")
    lead: Scalar = param(default=0.0, unit="rad", doc="azimuth by which the pitch goes ahead, for lags of drives")
    greatest_pitch: Scalar = param(default="5 deg", unit="rad", min=1e-9, doc="limit of each of the two pitches")
    band: Scalar = param(default="0.05 deg", unit="rad", min=1e-9, doc="range before the limit of the integrals")
    fade_time: Scalar = param(default=5.0, unit="s", min=1e-3, doc="time constant of fading out")

    azimuth: RealInput = port(unit="rad", doc="azimuth of blade 1")
    moments: RealInput = port(size="blades", unit="N*m", doc="flapwise root moment of each blade")
    enabled: RealInput = port(default=1.0, doc="0 while it is off")
    pitch: RealOutput = port(size="blades", unit="rad", doc="to be added to the pitch of each blade")

    sensors: list[MomentMeasurement] = parts(MomentMeasurement, size="blades", name="sensor")

    moment: Array = var(shape=(2,), unit="N*m", doc="tilt and yaw moment of a blade")
    integral: Array = var(shape=(2,), unit="rad", state="prefer", doc="K_I times their integrals")
    cyclic: Array = var(shape=(2,), unit="rad", doc="pitch against tilt and yaw")

    def build(self):
        for moment, sensor in zip(self.moments, self.sensors, strict=True):
            self.connect(moment, sensor.moment)

    def equations(self):
        n, on, top = self.blades, self.enabled > 0.5, self.greatest_pitch
        seen = [sensor.measured for sensor in self.sensors]
        psi = [self.azimuth + 2 * math.pi * k / n for k in range(n)]
        ahead = [angle + self.lead for angle in psi]
        return [
            eq(self.moment[0], 2 / n * sum(seen[k] * m.cos(psi[k]) for k in range(n))),
            eq(self.moment[1], 2 / n * sum(seen[k] * m.sin(psi[k]) for k in range(n))),
            [eq(self.pitch[k], self.cyclic[0] * m.cos(ahead[k]) + self.cyclic[1] * m.sin(ahead[k])) for k in range(n)],
            [self._axis(i, on, top) for i in range(2)],
        ]

    def _axis(self, i, on, top):
        """One of the two: tilt and yaw."""
        moment, integral = self.moment[i], self.integral[i]
        rate = held_within(self.integral_gain * moment, integral, -top, top, self.band)
        asked = integral + m.if_else(on, self.proportional_gain * moment, 0)
        return [
            eq(der(integral), m.if_else(on, rate, -integral / self.fade_time)),
            eq(self.cyclic[i], m.fmin(m.fmax(asked, -top), top)),
            initial(integral, 0),
        ]
