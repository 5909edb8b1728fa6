"""Where there is no equilibrium because something turns on and on."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, der, eq, param, var
from fowtlib.language import math as m
from fowtlib.language.errors import SimulationError


class DrivenPendulum(Component):
    """phi'' = drive - sin(phi) - phi': rests at asin(drive), and turns for ever where the drive is above 1."""

    drive: Scalar = param(default=0.5, unit="1/s^2", doc="moment over inertia")
    phi: Scalar = var(unit="rad", doc="angle")
    w: Scalar = var(unit="rad/s", doc="angular velocity")

    def equations(self):
        return [eq(der(self.phi), self.w), eq(der(self.w), self.drive - m.sin(self.phi) - self.w)]


def pendulum(drive):
    model = fw.Assembly("pendulum")
    model.pendulum = DrivenPendulum(drive=drive)
    return fw.load(model).compile()


def test_a_drive_that_is_too_strong_is_named():
    assert pendulum(0.5).equilibrium()["pendulum.phi"] == pytest.approx(np.arcsin(0.5))
    with pytest.raises(SimulationError) as error:
        pendulum(1.5).equilibrium()
    assert str(error.value) == (
        "no equilibrium: pendulum.phi turns on and on, and the loads depend on this angle. Where this is the azimuth "
        "of a rotor of blade elements, let the rotor stand (--wind none), hold it, or take the mean of a simulation."
    )
