"""Equilibria beside which there are others: what nothing holds stays where it starts, whatever moves on the way."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, der, eq, param, var


class Coasting(Component):
    """A body that settles at x = 1 and gives what coasts beside it a push on its way; nothing holds that."""

    push: Scalar = param(default=0.3, doc="share of the velocity that is felt")
    begin: Scalar = param(default=0.0, unit="rad/s", doc="speed at the start")
    x: Scalar = var(state="prefer", doc="place")
    v: Scalar = var(state="prefer", doc="velocity")
    w: Scalar = var(unit="rad/s", state="prefer", start=begin, doc="speed that is felt by nothing")
    filtered: Scalar = var(unit="rad/s", state="prefer", start=begin, doc="the same, late")

    def equations(self):
        return [
            eq(der(self.x), self.v), eq(der(self.v), 1 - self.x - 0.5 * self.v),
            eq(der(self.w), self.push * self.v * abs(self.v)), eq(der(self.filtered), self.w - self.filtered),
        ]  # fmt: skip


@pytest.mark.parametrize(("begin", "push"), [(0.0, 0.3), (0.0, -2.0), (0.7, 0.3)])
def test_what_nothing_holds_keeps_its_start(begin, push):
    model = fw.Assembly("coasting")
    model.part = Coasting(begin=begin, push=push)
    state = fw.load(model).compile().equilibrium()
    assert state["part.x"] == pytest.approx(1.0, abs=1e-10)
    assert state["part.w"] == pytest.approx(begin, abs=1e-12)
    assert state["part.filtered"] == pytest.approx(begin, abs=1e-12)


def test_a_rotor_in_still_air_starts_at_rest():
    """The platform tips by the weight of its turbine on its way to the mean, and air goes through its rotor."""
    still = {"wind.kind": "steady", "wind.mean_speed": 0.0, "sea.spectrum": "still"}
    state = fw.load("oc3_spar_rigid").compile().equilibrium(still)
    assert abs(state["turbine.rotor.w"]) < 1e-9  # rad/s; 0.0068 by the transient
    assert -0.1 < np.degrees(state["platform.motion.pitch"]) < -0.03
