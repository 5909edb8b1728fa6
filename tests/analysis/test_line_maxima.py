"""The largest tension in a motion of the largest amplitude: against the motion itself, its limits, its derivatives."""

import casadi as ca
import numpy as np
import pytest

from fowtlib.analysis.line_maxima import harmonic_extreme

LINE = {"elastic_stiffness": 4.08e5, "geometric_stiffness": 1.04e5, "mass": 8.25e5, "drag": 1.24e6, "axial_mass": 7.2e4}


def linear(x_std, omega, line):
    """Deviations of tension and of u' of the line with the drag that a Gaussian motion of one frequency has."""
    speed = 0.1
    for _ in range(2000):
        stiff = line["elastic_stiffness"] + line["geometric_stiffness"] - line["mass"] * omega**2
        u = line["elastic_stiffness"] / (stiff + 1j * omega * np.sqrt(8 / np.pi) * line["drag"] * speed) * x_std
        speed = (speed + abs(omega * u)) / 2
    return abs(line["elastic_stiffness"] * (x_std - u) - omega**2 * line["axial_mass"] * x_std), speed


@pytest.mark.parametrize("omega", [0.35, 0.6, 0.9])
@pytest.mark.parametrize("x_std", [0.1, 1.0])
def test_it_is_the_tension_of_a_harmonic_motion_in_time(omega, x_std):
    """The fundamental of x = 3.5 deviations sin(w t), stepped with the quadratic drag itself, to 4 %."""
    tension, speed = linear(x_std, omega, LINE)
    found = harmonic_extreme(3.5, tension, speed, omega, **LINE)
    k_E, k_G, mass, drag, axial = LINE.values()
    amplitude, steps = 3.5 * x_std, 4000
    dt, v, u = 2 * np.pi / omega / steps, 0.0, 0.0
    values = np.zeros(steps)
    for i in range(40 * steps):
        x = amplitude * np.sin(omega * i * dt)
        values[i % steps] = k_E * (x - u) - omega**2 * axial * x
        v += dt * (k_E * (x - u) - k_G * u - drag * abs(v) * v) / mass
        u += dt * v
    fundamental = 2 * abs(np.mean(values * np.exp(-2j * np.pi * np.arange(steps) / steps)))
    assert found == pytest.approx(fundamental, rel=0.04)


def test_limits():
    """No drag: a Gaussian. Slow tension besides: independent. Large motions: no more than stretch."""
    light = {**LINE, "drag": 1e-3}
    tension, speed = linear(1.0, 0.5, light)
    assert harmonic_extreme(3.5, tension, speed, 0.5, **light) == pytest.approx(3.5 * tension, rel=1e-6)
    slow = harmonic_extreme(3.5, np.hypot(tension, 4e4), speed, 0.5, **light)
    assert slow == pytest.approx(3.5 * np.hypot(tension, 4e4), rel=1e-6)
    tension, speed = linear(50.0, 0.5, LINE)
    most = 3.5 * 50 * (LINE["elastic_stiffness"] - 0.25 * LINE["axial_mass"])
    assert harmonic_extreme(3.5, tension, speed, 0.5, **LINE) == pytest.approx(most, rel=0.03)


def test_derivatives_of_expressions():
    tension, speed = linear(1.0, 0.6, LINE)
    at = np.array([3.5, 1.1 * tension, speed, 0.6, *LINE.values()])
    x = ca.SX.sym("x", at.size)

    def law(v):
        return harmonic_extreme(*(v[k] for k in range(4)), **{name: v[4 + k] for k, name in enumerate(LINE)})

    value, slopes = (np.array(item) for item in ca.Function("law", [x], [law(x), ca.jacobian(law(x), x)])(at))
    assert float(value[0, 0]) == pytest.approx(law(at), rel=1e-12)
    for k in range(at.size):
        estimates = []
        for h in (2e-4 * at[k], 1e-4 * at[k]):
            step = np.eye(at.size)[k] * h
            estimates.append((law(at + step) - law(at - step)) / (2 * h))
        difference = (4 * estimates[1] - estimates[0]) / 3
        assert slopes[0, k] == pytest.approx(difference, rel=1e-6, abs=1e-7 * law(at) / at[k])
