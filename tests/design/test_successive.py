"""The optimiser for dear models: results linear in each step, functions exact."""

import casadi as ca
import numpy as np
import pytest

from fowtlib.design import Design, Evaluated, Function, Variable, successive
from fowtlib.design.rounding import rounded
from fowtlib.design.settings import Settings
from fowtlib.language.errors import ModelError


class Beam:
    """A "model": a moment that grows a little and bends with the sizes, whose slopes are asked for seldom."""

    def __init__(self, forbidden=np.inf):
        self.values = self.slopes = self.failures = 0
        self.forbidden = forbidden

    def evaluate(self, x, jacobian=False):
        d, t = x
        if d > self.forbidden:
            self.failures += 1
            raise ModelError("no equilibrium here.")
        self.values, self.slopes = self.values + (not jacobian), self.slopes + jacobian
        moment = 3e8 * (1 + 0.1 * np.sin(d)) + 2e9 * t
        by = np.array([[3e8 * 0.1 * np.cos(d), 2e9]])
        key = ("design", "moment")
        return Evaluated({key: np.array([moment])}, {"moment": "N*m"}, {key: by} if jacobian else None)


class Still:
    """A "model" whose result nothing changes."""

    def evaluate(self, x, jacobian=False):
        key = ("design", "moment")
        return Evaluated({key: np.ones(1)}, {"moment": "1"}, {key: np.zeros((1, x.size))} if jacobian else None)


def tube(beam, start=(6.0, 0.05)) -> Design:
    """The lightest tube that bears it: stress M/(pi/4 d^2 t) below 200 MPa, d/t below 160."""
    functions = [
        Function("mass", lambda v: 7850 * np.pi * v["d"] * v["t"], ["d", "t"]),
        Function("stress", lambda v: v["moment"] / (np.pi / 4 * v["d"] ** 2 * v["t"]), ["d", "t", "moment"]),
        Function("slender", lambda v: v["d"] / v["t"], ["d", "t"]),
    ]
    variables = [Variable("d", 3.0, 9.0, start[0]), Variable("t", 0.01, 0.2, start[1])]
    design = Design(None, variables, "mass", ["stress < 2e8", "slender < 160"], functions=functions)
    object.__setattr__(design, "keys", [("design", "moment")])
    object.__setattr__(design, "results", beam)
    return design


def best() -> float:
    """By hand: both limits hold, t = d/160, and the stress gives d."""
    d = np.linspace(3.0, 9.0, 600_001)
    t = d / 160
    kept = (3e8 * (1 + 0.1 * np.sin(d)) + 2e9 * t) / (np.pi / 4 * d**2 * t) <= 2e8
    return float(np.min(7850 * np.pi * d[kept] * t[kept]))


@pytest.mark.parametrize("start", [(6.0, 0.05), (8.5, 0.15), (3.2, 0.02)])
def test_few_slopes_lead_to_the_optimum(start):
    beam = Beam()
    found = tube(beam, start).optimise("successive", tolerance=1e-6)
    assert found.converged and found.feasible
    assert found.value == pytest.approx(best(), rel=1e-5)
    assert sorted(found.active) == ["slender <", "stress <"]
    assert beam.slopes <= 8


def test_kinks_are_rounded_off_by_what_is_said():
    x = ca.MX.sym("x", 2)
    plain = ca.Function("f", [x], [ca.vertcat(ca.fmax(x[0], x[1]), ca.fmin(x[0], x[1]), ca.fabs(x[0])), ca.exp(x[1])])
    w, round_ = 1e-3, rounded(plain, 1e-3)
    for point in ([3.0, 3.0], [3.0, 2.0], [-3.0, 0.0], [0.0, 0.0]):
        exact, found = (np.concatenate([np.ravel(item) for item in one(point)]) for one in (plain, round_))
        size = np.hypot(*point)
        away = [0, 0, 0] if point[0] == point[1] else [abs(point[0] - point[1])] * 2 + [2 * abs(point[0])]
        over = (np.sqrt(np.square(away) + np.square([w * size, w * size, w * abs(point[0]) * np.sqrt(2)])) - away) / 2
        if point[0] == point[1]:
            over[2] = abs(point[0]) * (np.sqrt(1 + w**2 / 2) - 1)
        assert found - exact == pytest.approx([over[0], -over[1], over[2], 0.0], abs=1e-12)
    slopes = ca.Function("s", [x], [ca.jacobian(round_(x)[0], x)])([3.0, 3.0])
    assert np.array(slopes)[0] == pytest.approx([0.5, 0.5], abs=w)


def test_the_problem_of_a_step_ends_where_an_optimum_is_on_a_kink(monkeypatch):
    """The worse of two loads, each of which grows with the other size: a = b = 1, where 0.5 (1 + x)/x is 1."""

    def search():
        functions = [
            Function("mass", lambda v: v["a"] + v["b"], ["a", "b"]),
            Function("use", lambda v: ca.fmax(0.5 * (1 + v["b"]), 0.5 * (1 + v["a"])) / ca.sqrt(v["a"] * v["b"])
                     + 0 * v["moment"], ["a", "b", "moment"]),
        ]  # fmt: skip
        variables = [Variable("a", 0.2, 9.0, 2.0), Variable("b", 0.2, 9.0, 1.0)]
        design = Design(None, variables, "mass", ["use < 1"], functions=functions)
        object.__setattr__(design, "keys", [("design", "moment")])
        object.__setattr__(design, "results", Still())
        told = []
        found = design.optimise("successive", tolerance=1e-6, options={"say": told.append})
        return found, [line for line in told if "not solved" in line]

    found, unsolved = search()
    assert found.converged and found.feasible and not unsolved
    assert found["a"] == pytest.approx(1.0, abs=2e-3) and found["b"] == pytest.approx(1.0, abs=2e-3)
    monkeypatch.setattr(successive, "rounded", lambda function, width: function)
    found, unsolved = search()
    assert unsolved and not found.converged


def test_where_there_are_no_results_steps_become_shorter():
    """Beyond 7.57 there is no result, and the first step would lead there."""
    beam = Beam(forbidden=7.57)
    found = tube(beam, (6.5, 0.05)).optimise("successive", options={"region": 0.5})
    free = tube(Beam(), (6.5, 0.05)).optimise("successive", options={"region": 0.5})
    assert beam.failures and free["d"] < 7.57 and found.value == pytest.approx(free.value, rel=1e-4)


def test_a_step_that_was_not_solved_is_no_optimum(monkeypatch):
    """A solver that gives up at once leaves the start as it is: the search says so, and goes on where it can."""
    whole = successive._solver

    def idle(often):
        left = [often]

        def make(problem, **more):
            able = whole(problem, **more)
            unable = ca.nlpsol("step", "ipopt", problem, {"ipopt.print_level": 0, "print_time": False,
                               "ipopt.sb": "yes", "ipopt.max_iter": 0, "error_on_fail": False})  # fmt: skip

            class Solver:
                def __call__(self, **given):
                    self.used, left[0] = unable if left[0] > 0 else able, left[0] - 1
                    return self.used(**given)

                def stats(self):
                    return self.used.stats()

            return Solver()

        return make

    monkeypatch.setattr(successive, "_solver", idle(3))
    found = tube(Beam(), (8.5, 0.15)).optimise("successive", tolerance=1e-6)
    assert found.converged and found.value == pytest.approx(best(), rel=1e-5)
    monkeypatch.setattr(successive, "_solver", idle(1000))
    found = tube(Beam(), (8.5, 0.15)).optimise("successive", tolerance=1e-6)
    assert not found.converged and "no step was found: Maximum_Iterations_Exceeded" in found.reason


@pytest.mark.parametrize("share", [0.999, 0.997])
def test_limits_are_kept_beside_an_optimum(share):
    """Sizes that are a little too small become those that bear the load, in a few short steps, though results bend."""
    beam = Beam()
    ended = tube(beam).optimise("successive", tolerance=1e-6)
    optimum = np.array([ended["d"], ended["t"]])
    problem = tube(beam).problem(optimum)
    y = problem.y(share * optimum)
    before = problem.point(y).violation
    found = problem.point(successive._Search(problem, Settings(1e-4, 50, {}))._kept(y, *problem.linear(y)))
    assert before > 1e-3 and found.feasible
    assert 1 - 1e-5 < found.objective / best() < 1.005  # NEAR, of the range of t, is 0.5 % of it
