"""Equivalent linearisation against closed forms that have nothing to do with wind.

J. B. Roberts and P. D. Spanos, Random Vibration and Statistical Linearization, 1990: an oscillator with a cubic spring;
R. C. Booton, IRE Trans. Circuit Theory 1 (1954) 9: a limit, erf(L / (sqrt(2) s)). White noise of the one-sided density
G [unit^2 s/rad] from w_0 to w_1 gives x of x' + a x = noise the variance G / a (atan(w_1 / a) - atan(w_0 / a)).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import erf
from scipy.stats import norm

import fowtlib as fw
from fowtlib.frequency.expected_means import _solved
from fowtlib.frequency.rotation import speeds_by_states
from fowtlib.language import Component, Number, Scalar, der, eq, param, quadratic, run_time_series, var
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.solving.excited import excited_model
from tests.frequency.conftest import LINEAR, MASS, STIFFNESS, Oscillator, Push
from tests.frequency.test_wind_across import ROTOR

GRID = np.geomspace(1e-3, 9.0, 600)  # Hz


def deviation(level: float, rate: float) -> float:
    """Of x' + rate x = noise on the frequencies of GRID."""
    low, high = np.arctan(2 * np.pi * GRID[[0, -1]] / rate)
    return float(np.sqrt(level / rate * (high - low)))


class Duffing(Oscillator):
    """The oscillator with a spring that hardens, and a damper that does."""

    hardening: Scalar = param(default=0.0, unit="N/m^3", doc="force over the cube of the displacement")
    braking: Scalar = param(default=0.0, unit="N*s^3/m^3", doc="force over the cube of the velocity")

    def equations(self):
        own, balance = super().equations()
        return [own, eq(balance.lhs, balance.rhs - self.hardening * self.x**3 - self.braking * self.v**3)]


class Filter(Component):
    """x' = -rate f(x) + white noise + level, and what else follows x."""

    level: Number = param(default=2.0, bound=True, doc="one-sided spectrum of the noise [s/rad]")
    highest: Number = param(default=60.0, bound=True, doc="circular frequency up to which there is noise")
    limit: Scalar = param(default=0.0, doc="of the return, where it is above zero")
    lead: Scalar = param(default=0.0, doc="constant input")

    x: Scalar = var(start=0.0, doc="what the noise drives")
    held: Scalar = var(start=0.0, doc="follows x within 0.05 s, not below zero")
    late: Scalar = var(start=0.0, doc="follows x within 1 s")
    squared: Scalar = var(start=0.0, doc="follows the square of `held` within 1 s")
    product: Scalar = var(start=0.0, doc="follows x times `late` within 1 s")

    def equations(self):
        noise = run_time_series(self.time, 1, "noise", Push(), of=self)
        back = m.if_else(self.limit > 0, m.fmin(m.fmax(self.x, -self.limit), self.limit), self.x)
        return [
            eq(der(self.x), noise + self.lead - back),
            eq(der(self.held), (m.fmax(self.x, 0) - self.held) / 0.05),
            eq(der(self.late), self.x - self.late),
            eq(der(self.squared), self.held**2 - self.squared),
            eq(der(self.product), self.x * self.late - self.product),
        ]

    def spectral_density(self, omega):
        return np.where(np.asarray(omega) < self.highest, self.level, 0.0)


def filtered(**parameters):
    root = fw.Assembly("filters")
    root.one = Filter(**parameters)
    return fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "held", "late", "squared", "product")})


@pytest.mark.parametrize("push", [0.0, 15.0])
def test_a_cubic_spring_has_the_mean_and_the_deviation_of_the_closed_form(push):
    level, hardening = 2.0, 6.0
    root = fw.Assembly("oscillators")
    root.one = Duffing(level=level, hardening=hardening, push=push, damping=LINEAR)
    found = fw.response(fw.Model(root, outputs={"x": "one.x"}), linearisation="equivalent")

    def mean(s2):
        return brentq(lambda x: STIFFNESS * x + hardening * (x**3 + 3 * x * s2) - push, -10.0, 10.0)

    def left(s2):
        stiffness = STIFFNESS + 3 * hardening * (mean(s2) ** 2 + s2)
        return s2 - np.pi * level / (2 * LINEAR * stiffness)

    s2 = brentq(left, 1e-6, 10.0)
    assert found.std("x") == pytest.approx(np.sqrt(s2), rel=0.01)  # settles to 0.3 %; points and frequencies the rest
    assert found.mean[0] == pytest.approx(mean(s2), rel=0.01, abs=1e-6)
    tangent = fw.response(fw.Model(root, outputs={"x": "one.x"}))
    off = max(abs(tangent.std("x") / np.sqrt(s2) - 1), abs(tangent.mean[0] - mean(s2)))
    assert off > 0.1  # what it is about is no small thing here


def test_what_grows_without_noise_has_the_deviation_that_its_damper_leaves_it():
    """M v' = force + 0.2 v - c v^3 - k x: damping -0.2 + 3 c s^2, and s^2 = pi G / (2 M damping)."""
    root = fw.Assembly("oscillators")
    root.one = Duffing(level=2.0, braking=0.5, damping=-0.2)
    model = fw.Model(root, outputs={"v": "one.v"})
    with pytest.raises(SimulationError, match="unstable"):
        fw.response(model)
    found = fw.response(model, linearisation="equivalent")
    s2 = brentq(lambda s2: s2 * (3 * 0.5 * s2 - 0.2) - np.pi * 2.0 / (2 * MASS), 0.1, 10.0)
    assert found.std("v") == pytest.approx(np.sqrt(s2), rel=0.02)  # 512 points, and frequencies up to 2 Hz


class WithShafts(Duffing):
    """The same, and speeds that nothing holds: of one shaft, and the common one of two; both are followed."""

    air: Scalar = param(default=0.0, unit="1/s", doc="what holds the first shaft")

    alone: Scalar = var(start=3.0, unit="m/s", doc="speed of a shaft")
    first: Scalar = var(start=1.0, unit="m/s", doc="speed of one of two")
    second: Scalar = var(start=5.0, unit="m/s", doc="speed of the other")
    measured: Scalar = var(start=0.0, unit="m/s", doc="follows the first shaft within 0.1 s")

    def equations(self):
        slip = self.second - self.first
        return [
            *super().equations(), eq(der(self.alone), self.air * (self.v - self.alone)),
            eq(der(self.first), slip), eq(der(self.second), -slip),
            eq(der(self.measured), (self.alone + self.first - self.measured) / 0.1),
        ]  # fmt: skip


@pytest.mark.parametrize(("linearisation", "alike"), [
    ("equivalent", 1e-3),
    ("quadratic", 0.03),  # its 512 points lie elsewhere where there are more states, which the products feel
])  # fmt: skip
def test_speeds_that_nothing_holds_stay_as_those_of_a_rotor_without_wind(linearisation, alike):
    found = []
    for kind in (Duffing, WithShafts):
        root = fw.Assembly("oscillators")
        root.one = kind(level=2.0, hardening=6.0, push=15.0, damping=LINEAR)
        outputs = {name: f"one.{name}" for name in ("x", "measured") if name == "x" or kind is WithShafts}
        found.append(fw.response(fw.Model(root, outputs=outputs), linearisation=linearisation))
    assert found[1].std("x") == pytest.approx(found[0].std("x"), rel=alike)
    assert found[1].mean[0] == pytest.approx(found[0].mean[0], rel=alike)
    assert found[1].mean[1] == pytest.approx(3.0 + (1.0 + 5.0) / 2, rel=1e-6)
    assert found[1].std("measured") == pytest.approx(0.0, abs=1e-9)


def test_of_rows_that_hold_no_direction_the_shortest_solution_is_taken_and_none_where_there_is_none():
    slopes = np.diag([1e-9, 2e7, 0.0])
    assert _solved(slopes, np.array([3e-9, 4e7, 0.0])) == pytest.approx([3.0, 2.0, 0.0])
    with pytest.raises(SimulationError, match="mean of the equivalent linearisation is not found"):
        _solved(slopes, np.array([0.0, 0.0, 1e-3]))


def test_a_limit_in_a_loop_has_the_gain_of_booton():
    limit, level = 1.0, 0.4
    model = filtered(limit=limit, level=level)
    found = fw.response(model, outputs=["x"], frequencies=GRID, linearisation="equivalent")
    s = brentq(lambda s: s - deviation(level, erf(limit / (np.sqrt(2) * s))), 0.1, 20.0)
    assert found.std("x") == pytest.approx(s, rel=0.01)
    assert abs(fw.response(model, outputs=["x"], frequencies=GRID).std("x") / s - 1) > 0.05


def test_what_follows_a_corner_has_its_half_and_what_hangs_on_it_has_its_own_slope():
    """Of x with the deviation s: E max(x, 0) = s/sqrt(2 pi), slope 1/2; E max(x, 0)^2 = s^2/2, slope 2 s/sqrt(2 pi)."""
    names = ["x", "held", "late", "squared"]
    found = fw.response(filtered(level=0.5), outputs=names, frequencies=GRID, linearisation="equivalent")
    s = found.std("x")
    assert s == pytest.approx(deviation(0.5, 1.0), rel=0.01)
    assert found.mean[1] == pytest.approx(s / np.sqrt(2 * np.pi), rel=0.01)
    assert found.std("held") == pytest.approx(s / 2, rel=0.03)  # it follows within 0.05 s: 2.5 % of the variance lags
    assert found.mean[3] == pytest.approx(s**2 / 2, rel=0.02)
    assert found.std("squared") == pytest.approx(2 * s / np.sqrt(2 * np.pi) * found.std("late"), rel=0.02)


class Slow(Filter):
    """The filter with an actuator that follows x within 0.05 s, with 0.1 of x in a second at most."""

    behind: Scalar = var(start=0.0, doc="follows x")

    def equations(self):
        return [*super().equations(), eq(der(self.behind), m.fmin(m.fmax((self.x - self.behind) / 0.05, -0.1), 0.1))]


def test_an_actuator_stands_where_its_law_puts_it_however_far_the_limit_of_its_rate_lets_that_be():
    """Points stand up to 6 away from it, and a step of its rate over its pace of 20 1/s is 1/200 there."""
    root = fw.Assembly("filters")
    root.one = Slow(lead=4.0)
    found = fw.response(fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "behind")}), frequencies=GRID,
                        linearisation="equivalent")  # fmt: skip
    assert found.mean == pytest.approx([4.0, 4.0], abs=1e-6)  # points lie in pairs
    assert found.std("behind") == pytest.approx(found.std("x"), rel=0.03)  # within 0.05 s: 5 % of the variance lags


class Bent(Filter):
    """The filter and what a curved equation makes of x, as the shape of a line follows its end."""

    bend: Scalar = var(start=0.0, doc="with its cube it is x")

    def equations(self):
        return [*super().equations(), eq(self.bend**3 + self.bend, self.x)]


def test_an_unknown_has_the_mean_and_the_slope_of_where_its_equation_puts_it():
    """Of x = m + s n, n normal: E h and E dh/dx = E 1/(1 + 3 h^2) of h^3 + h = x, by Hermite's quadrature."""
    root = fw.Assembly("filters")
    root.one = Bent(lead=1.0)
    found = fw.response(fw.Model(root, outputs={name: f"one.{name}" for name in ("x", "bend")}), frequencies=GRID,
                        linearisation="equivalent")  # fmt: skip
    n, weights = np.polynomial.hermite_e.hermegauss(200)
    h = np.array([brentq(lambda h, x=x: h**3 + h - x, -9.0, 9.0) for x in 1.0 + found.std("x") * n])
    weights /= weights.sum()
    slope = weights @ (1 / (1 + 3 * h**2))
    assert found.mean[1] == pytest.approx(weights @ h, rel=0.01)  # 512 points
    assert found.std("bend") / found.std("x") == pytest.approx(slope, rel=0.01)
    assert abs(1 / (weights @ (1 + 3 * h**2)) / slope - 1) > 0.2  # what one over the mean slope of the equation is


@pytest.mark.parametrize("lead", [0.0, 2.0])
def test_a_product_of_two_has_their_covariance_as_its_mean(lead):
    """Of x and what follows it within 1 s: covariance s^2/2, slopes those at the means, which are `lead` both."""
    names = ["x", "late", "product"]
    model = filtered(level=0.5, lead=lead)
    found = fw.response(model, outputs=names, frequencies=GRID, linearisation="equivalent")
    assert found.mean[:2] == pytest.approx([lead, lead], abs=1e-3)
    assert found.mean[2] == pytest.approx(lead**2 + found.std("x") ** 2 / 2, rel=0.02)
    tangent = fw.response(model, outputs=names, frequencies=GRID)
    assert found.std("product") == pytest.approx(tangent.std("product"), rel=0.02, abs=0.02)
    assert tangent.mean[2] == pytest.approx(lead**2, abs=1e-6)


def test_a_linear_model_stays_what_it_is():
    root = fw.Assembly("oscillators")
    root.one = Oscillator(drag=2.0)
    model = fw.Model(root, outputs={"x": "one.x", "v": "one.v"})
    tangent, found = fw.response(model), fw.response(model, linearisation="equivalent")
    for name in ("x", "v"):  # with drag, which has its own law
        assert found.std(name) == pytest.approx(tangent.std(name), rel=1e-3)


class Smooth(Oscillator):
    """The oscillator whose drag is smooth below 0.4 m/s, of the size of its velocities."""

    def equations(self):
        own, balance = super().equations()
        return [own, eq(balance.lhs, balance.rhs - 2.0 * quadratic(self.v, 0.4, "smooth drag"))]


@pytest.mark.parametrize("linearisation", ["tangent", "equivalent"])
def test_the_law_of_drag_stands_in_place_of_all_of_it_however_smooth(linearisation):
    """|u| smooth at rest has a slope there, which is no damping beside that of the law; 1e-6 is as good as none."""
    stds = []
    for part in (Smooth(level=2.0), Oscillator(level=2.0, drag=2.0)):
        root = fw.Assembly("oscillators")
        root.one = part
        model = fw.Model(root, outputs={"v": "one.v"})
        stds.append(fw.response(model, frequencies=GRID, linearisation=linearisation).std("v"))
    assert stds[0] == pytest.approx(stds[1], rel=1e-4)  # tolerance of the gains
    assert 0.2 < stds[0] < 1.0


@pytest.mark.parametrize("smoothing", [0.0, -1e-3, True, "1e-3"])
def test_a_smoothing_that_is_no_number_above_zero_is_refused(smoothing):
    class Rough(Oscillator):
        """With another smoothing."""

        def equations(self):
            own, balance = super().equations()
            return [own, eq(balance.lhs, balance.rhs - quadratic(self.v, smoothing, "rough"))]

    root = fw.Assembly("oscillators")
    root.one = Rough()
    with pytest.raises(ModelError, match="smoothing is a number above 0"):
        fw.Model(root, outputs={"v": "one.v"}).compile()


def test_beside_a_rotor_that_turns_a_corner_has_its_expected_value_and_slope(tmp_path):
    """Of x with mean m and deviation s: E max(x, 0) = m Phi(m/s) + s phi(m/s), slope Phi(m/s); laws alone are so."""
    path = tmp_path / "rotor.yaml"
    path.write_text(ROTOR)
    root = fw.load(str(path)).root
    root.one = Filter(level=0.5, lead=0.4)
    names = ["x", "held", "late"]
    model = fw.Model(root, outputs={name: f"one.{name}" for name in names} | {"speed": "turbine.rotor_speed"})
    steady = {"wind.kind": "steady", "wind.mean_speed": 8.0}
    found, tangent = (fw.response(model, parameters=steady, frequencies=GRID, linearisation=word)
                      for word in ("equivalent", "tangent"))  # fmt: skip
    s, m = found.std("x"), 0.4
    assert s == pytest.approx(deviation(0.5, 1.0), rel=1e-3)
    assert found.mean_of("held") == pytest.approx(m * norm.cdf(m / s) + s * norm.pdf(m / s), rel=0.01)
    share = tangent.std("held") / s  # the slope is one at the mean, and it lags by 0.05 s
    assert found.std("held") == pytest.approx(norm.cdf(m / s) * share * s, rel=0.01)
    assert found.mean_of("speed") == pytest.approx(tangent.mean_of("speed"), rel=1e-6)
    assert tangent.mean_of("held") == pytest.approx(m, rel=1e-6)
    rotating = excited_model(model.compile(), found.state, names).rotating
    (row,) = speeds_by_states(rotating)
    (speed,) = np.flatnonzero(row)
    assert row[speed] == 1.0
    assert rotating.linear.states[speed] == "turbine.assembly.nacelle.bearing.w"


def test_a_word_that_is_no_linearisation_is_refused():
    with pytest.raises(ModelError, match="'tangent' or 'equivalent'"):
        fw.response(filtered(), linearisation="statistical")
