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


@pytest.mark.parametrize(
    ("name", "rotors"),
    [("oc3_spar_rigid", ["turbine"]), ("two_rotor_spar_rigid", ["turbine_left", "turbine_right"])],
)
def test_a_rotor_in_still_air_starts_at_rest(name, rotors):
    """The platform tips by the weight of its turbine on its way to the mean, and air goes through its rotor."""
    still = {"wind.kind": "steady", "wind.mean_speed": 0.0, "sea.spectrum": "still"}
    plant = fw.load(name).compile()
    mean = plant.equilibrium(still)
    run = plant.simulate(20.0, 5.0, parameters=still, start=mean)
    for rotor in rotors:
        assert abs(mean[f"{rotor}.rotor.w"]) < 1e-9  # rad/s; 0.0068 and 0.0755 by the transient
        np.testing.assert_allclose(run[f"{rotor}.rotor.w"], 0.0, atol=1e-9)
    for motion in ("surge", "heave", "pitch"):  # m, rad; it stays there
        held = f"platform.motion.{motion}"
        np.testing.assert_allclose(run[held], mean[held], rtol=0, atol=1e-6)
    if name == "oc3_spar_rigid":
        assert -0.1 < np.degrees(mean["platform.motion.pitch"]) < -0.03
