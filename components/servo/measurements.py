"""Sensors that may fail, between what is and what a controller is told."""

from __future__ import annotations

from fowtlib.language import (
    Component,
    OfferedEvent,
    RealInput,
    RealOutput,
    Scalar,
    assign,
    eq,
    event,
    on,
    param,
    port,
    var,
)
from fowtlib.language import math as m


class Measurement(Component):
    """Partial: a signal as it is until the sensor fails, then share times it and an offset, or a value that stays.

    A sensor that drops out shows one value without noise, as a broken wire does. Kinds of faults: P. F. Odgaard, J.
    Stoustrup and M. Kinnaert, IEEE Trans. Control Syst. Technol. 21 (2013) 1168. A subclass has the signals, with their
    unit, `held`, `offset`, and events `offset` and `drop_out` whose values have that unit.
    """

    stuck: OfferedEvent = event(doc="what is measured stays as it is")
    scaled: OfferedEvent = event(
        doc="it shows a share of what is", by=param(default=0.95, doc="share of the true value")
    )
    restored: OfferedEvent = event(doc="the sensor measures again, as it should")

    faulty: Scalar = var(discrete=True, start=0.0, doc="1 while it shows a value that stays")
    share: Scalar = var(discrete=True, start=1.0, doc="of the true value that is shown")

    def measuring(self, true, shown):
        """The equations, from the true signal to the one that is shown."""
        steady = assign(self.faulty, 1)
        return [
            eq(shown, m.if_else(self.faulty > 0.5, self.held, self.share * true + self.added)),
            on(self.stuck, steady, assign(self.held, shown)),
            on(self.drop_out, steady, assign(self.held, self.drop_out.value)),
            on(self.offset, assign(self.added, self.added + self.offset.by)),
            on(self.scaled, assign(self.share, self.scaled.by)),
            on(self.restored, assign(self.faulty, 0), assign(self.share, 1), assign(self.added, 0)),
        ]


class SpeedMeasurement(Measurement):
    """A speed of rotation as a sensor shows it; see Measurement."""

    drop_out: OfferedEvent = event(
        doc="it shows one value from now on", value=param(default=0.0, unit="rad/s", doc="what it shows")
    )
    offset: OfferedEvent = event(
        doc="it shows more than is", by=param(default="10 rpm", unit="rad/s", doc="what is added")
    )

    speed: RealInput = port(unit="rad/s", doc="speed")
    measured: RealOutput = port(unit="rad/s", doc="speed that is measured")

    held: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="speed that it shows while it shows one value")
    added: Scalar = var(unit="rad/s", discrete=True, start=0.0, doc="added to the speed")

    def equations(self):
        return self.measuring(self.speed, self.measured)


class AngleMeasurement(Measurement):
    """An angle as a sensor shows it; see Measurement."""

    drop_out: OfferedEvent = event(
        doc="it shows one value from now on", value=param(default=0.0, unit="rad", doc="what it shows")
    )
    offset: OfferedEvent = event(
        doc="it shows more than is", by=param(default="1 deg", unit="rad", doc="what is added")
    )

    angle: RealInput = port(unit="rad", default=0.0, doc="angle")
    measured: RealOutput = port(unit="rad", doc="angle that is measured")

    held: Scalar = var(unit="rad", discrete=True, start=0.0, doc="angle that it shows while it shows one value")
    added: Scalar = var(unit="rad", discrete=True, start=0.0, doc="added to the angle")

    def equations(self):
        return self.measuring(self.angle, self.measured)


class MomentMeasurement(Measurement):
    """A bending moment as strain gauges show it; see Measurement."""

    drop_out: OfferedEvent = event(
        doc="it shows one value from now on", value=param(default=0.0, unit="N*m", doc="what it shows")
    )
    offset: OfferedEvent = event(
        doc="it shows more than is", by=param(default="1 MN*m", unit="N*m", doc="what is added")
    )

    moment: RealInput = port(unit="N*m", doc="moment")
    measured: RealOutput = port(unit="N*m", doc="moment that is measured")

    held: Scalar = var(unit="N*m", discrete=True, start=0.0, doc="moment that it shows while it shows one value")
    added: Scalar = var(unit="N*m", discrete=True, start=0.0, doc="added to the moment")

    def equations(self):
        return self.measuring(self.moment, self.measured)
