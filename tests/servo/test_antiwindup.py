"""The rule of all integrals with limits: free inside, at rest at a limit, back from outside."""

import casadi as ca
import numpy as np
import pytest

from fowtlib.components.servo.antiwindup import held_within


@pytest.mark.parametrize("sign", [1, -1])
def test_the_rule(sign):
    """At both limits alike: more than 1.2 bands inside nothing changes; at the limit it stands; outside it returns."""
    low, high, band, rate = -0.5, 2.0, 0.1, 0.7 * sign
    limit, inward = (high, -1) if sign > 0 else (low, 1)
    value = ca.SX.sym("value")
    rule = ca.Function("rule", [value], [held_within(rate, value, low, high, band)])
    at = {bands: float(rule(limit + inward * bands * band)) / rate for bands in (5, 1.2, 1, 0.5, 0, -0.5, -1, -30)}
    assert [at[5], at[1.2]] == pytest.approx([1, 1]) and at[0.5] == pytest.approx(0.5)
    assert 0.8 < at[1] < 1 and at[0] == pytest.approx(0, abs=1e-15)
    assert at[-0.5] == pytest.approx(-0.5) and [at[-1], at[-30]] == pytest.approx([-1, -1])
    away = ca.Function("away", [value], [held_within(-rate, value, low, high, band)])
    assert float(away(limit)) == -rate and float(away(limit - inward * band)) == -rate  # off the limit at once
    steps = np.diff([float(rule(v)) for v in np.linspace(low - 0.3, high + 0.3, 4001)])
    assert np.abs(steps).max() < 1.2 * 0.7 / band * 2.9 / 4000  # no jump
