"""A linear yaw spring between a floating body and the ground."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, Scalar, eq, param, port, var
from fowtlib.language import math as m


class YawSpring(Component):
    """A moment -stiffness * yaw about the vertical on the body: what the crowfoot (delta) lines of a spar add in yaw.

    yaw is the angle of the sequence yaw, pitch, roll of the frame, within +-180 deg. The delta lines of OC3-Hywind give
    98.34 MN m/rad, near linear up to about 20 deg (Jonkman, NREL/TP-500-47535, 2010, section 4).
    """

    stiffness: Scalar = param(unit="N*m/rad", min=0, doc="yaw stiffness")

    frame: Frame = port(doc="frame of the body")

    yaw: Scalar = var(unit="rad", doc="yaw angle of the frame")
    moment: Scalar = var(unit="N*m", doc="moment on the body about the vertical")

    def equations(self):
        R = self.frame.R
        return [
            eq(self.yaw, m.atan2(R[1, 0], R[0, 0])),
            eq(self.moment, -self.stiffness * self.yaw),
            [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, m.vertcat(0, 0, -self.moment))],
        ]
