"""Problems with a known optimum, by every optimiser."""

import casadi as ca
import numpy as np
import pytest

from fowtlib.design import Constraint, Design, Evaluated, Function, Variable
from fowtlib.language.errors import ModelError

METHODS = ("ipopt", "slsqp", "trust-constr", "successive")
EXACT = {"ipopt": 1e-5, "slsqp": 1e-5, "trust-constr": 2e-3, "successive": 1e-5}  # of the objective, relative


def rosenbrock(limit="r < 1.5", **more) -> Design:
    """The minimum within a circle, where the path to the free one at (1, 1) meets it."""
    functions = [
        Function("f", lambda v: (1 - v["x"]) ** 2 + 100 * (v["y"] - v["x"] ** 2) ** 2, ["x", "y"]),
        Function("r", lambda v: v["x"] ** 2 + v["y"] ** 2, ["x", "y"]),
    ]
    return Design(
        None, [Variable("x", -2, 2, -1.2), Variable("y", -2, 2, 1)], "f", [limit], functions=functions, **more
    )


def truss() -> Design:
    """Least volume [cm^3] of the symmetric three-bar truss: P = 2 kN/cm^2, 100 cm (Rao, Engineering Optimization)."""
    a1, a2, P, limit = "a1", "a2", 2.0, 2.0
    root = np.sqrt(2)

    def stresses(v):
        x1, x2 = v[a1], v[a2]
        common = root * x1**2 + 2 * x1 * x2
        return ca.vertcat(P * (x2 + root * x1) / common, P / (x1 + root * x2), P * x2 / common)

    functions = [
        Function("volume", lambda v: 100 * (2 * root * v[a1] + v[a2]), [a1, a2]),
        Function("stresses", stresses, [a1, a2]),
    ]
    variables = [Variable(a1, 0.01, 1, 0.5), Variable(a2, 0.01, 1, 0.5)]
    return Design(None, variables, "volume", [Constraint("stresses", upper=limit)], functions=functions)


def column() -> Design:
    """The tubular column of S. S. Rao, Engineering Optimization, example 1.1: 2500 kgf, 250 cm; f* = 26.53."""
    functions = [
        Function("cost", lambda v: 9.82 * v["d"] * v["t"] + 2 * v["d"], ["d", "t"]),
        Function("stress", lambda v: 2500 / (np.pi * v["d"] * v["t"]), ["d", "t"]),
        Function("euler", lambda v: np.pi**2 * 0.85e6 * (v["d"] ** 2 + v["t"] ** 2) / (8 * 250**2), ["d", "t"]),
        Function("buckling", lambda v: v["stress"] - v["euler"], ["stress", "euler"]),
    ]
    variables = [Variable("d", 2, 14, 10), Variable("t", 0.2, 0.8, 0.5)]
    limits = ["stress < 500", Constraint("buckling", upper=0, scale=500)]
    return Design(None, variables, "cost", limits, functions=functions)


F, L, E, DENSITY, SLENDER = 1e6, 80.0, 210e9, 7850.0, 200.0


def cantilever(stress_limit: float, deflection_limit: float, aggregate="each") -> Design:
    """Least mass of a thin tube with a force at its tip, diameter over wall at most 200."""
    sizes = ["D", "t"]
    functions = [
        Function("mass", lambda v: DENSITY * np.pi * v["D"] * v["t"] * L, sizes, "kg"),
        Function("stress", lambda v: F * L / (np.pi * v["D"] ** 2 * v["t"] / 4), sizes, "Pa"),
        Function("deflection", lambda v: F * L**3 / (3 * E * np.pi * v["D"] ** 3 * v["t"] / 8), sizes, "m"),
        Function("slenderness", lambda v: v["D"] / v["t"], sizes),
    ]
    limits = [
        Constraint("stress", upper=stress_limit, aggregate=aggregate),
        Constraint("deflection", upper=deflection_limit),
        Constraint("slenderness", upper=SLENDER),
    ]
    variables = [Variable("D", 1, 12, 5, unit="m"), Variable("t", 5e-3, 0.2, 0.1, unit="m")]
    return Design(None, variables, "mass", limits, functions=functions)


def least_wall(stress_limit: float, deflection_limit: float) -> float:
    """The wall of the optimum: D = k t, and the stricter of stress 4 F L / (pi k^2 t^3) and deflection."""
    by_stress = (4 * F * L / (np.pi * SLENDER**2 * stress_limit)) ** (1 / 3)
    by_deflection = (8 * F * L**3 / (3 * E * np.pi * SLENDER**3 * deflection_limit)) ** (1 / 4)
    return max(by_stress, by_deflection)


@pytest.mark.parametrize("method", METHODS)
def test_rosenbrock_in_a_circle(method):
    found = rosenbrock().optimise(method)
    assert found.feasible and found.converged
    assert found["x"] == pytest.approx(0.907234, abs=3e-4) and found["y"] == pytest.approx(0.822755, abs=5e-4)


@pytest.mark.parametrize("method", METHODS)
def test_the_three_bar_truss(method):
    found = truss().optimise(method)
    assert found.value == pytest.approx(263.8958, rel=EXACT[method])
    assert found["a1"] == pytest.approx(0.78868, rel=5e-3) and found["a2"] == pytest.approx(0.40825, rel=2e-2)
    assert [item.active for item in found.constraints] == ["upper", "", ""]


@pytest.mark.parametrize("method", METHODS)
def test_the_tubular_column(method):
    found = column().optimise(method)
    assert found.value == pytest.approx(26.53, abs=0.01 + 26 * EXACT[method])
    assert found["d"] == pytest.approx(5.451, abs=5e-3) and found["t"] == pytest.approx(0.292, abs=1e-3)
    assert found.active == ["stress <", "buckling <"]


@pytest.mark.parametrize("method", METHODS[:2])
@pytest.mark.parametrize(("stress", "deflection", "active"), [(200e6, 0.8, "deflection"), (60e6, 2.0, "stress")])
def test_the_cantilever_tube(method, stress, deflection, active):
    wall = least_wall(stress, deflection)
    found = cantilever(stress, deflection).optimise(method)
    assert found["t"] == pytest.approx(wall, rel=1e-4) and found["D"] == pytest.approx(SLENDER * wall, rel=1e-4)
    assert found.active == [f"{active} <", "slenderness <"]
    assert found.rest < 1e-3


def test_prices_say_what_a_limit_costs():
    """The multiplier of a limit is the change of the optimum per unit of it, and so for a bound."""
    found, moved = (cantilever(200e6, limit).optimise() for limit in (0.8, 0.8008))
    price = {item.name: item.price for item in found.constraints}
    assert price["deflection"] == pytest.approx((found.value - moved.value) / 0.0008, rel=2e-3)
    assert price["stress"] == 0
    bounded = [
        Design(
            None, [Variable("x", lower, 3, 2)], "f", functions=[Function("f", lambda v: v["x"] ** 2, ["x"])]
        ).optimise()
        for lower in (1.0, 1.001)
    ]
    assert bounded[0].variables[0].active == "lower"
    assert bounded[0].variables[0].price == pytest.approx((bounded[1].value - bounded[0].value) / 0.001, rel=2e-3)


def test_an_aggregate_keeps_to_the_safe_side():
    """KS of several points is never less than the largest, and comes nearer to it as it is sharper."""

    def design(sharpness, aggregate="ks"):
        functions = [
            Function("f", lambda v: v["x"] ** 2 + v["y"] ** 2, ["x", "y"]),
            Function("g", lambda v: ca.vertcat(v["x"] + v["y"], v["x"] + 0.99 * v["y"], v["x"]), ["x", "y"]),
        ]
        limit = Constraint("g", lower=1.0, aggregate=aggregate, sharpness=sharpness)
        variables = [Variable("x", 0, 5, 2), Variable("y", 0, 5, 3)]
        return Design(None, variables, "f", [limit], functions=functions).optimise()

    each = design(50.0, "each")
    values = [design(sharpness).value for sharpness in (20.0, 100.0, 2000.0)]
    assert each.value == pytest.approx(1.0, abs=13e-6)  # 1e-6 of the scale, which is that of the start
    assert values[0] > values[1] > values[2] >= each.value - 1e-9
    assert values[2] == pytest.approx(each.value, rel=2e-3)
    assert design(20.0).constraints[2].active == "lower"


@pytest.mark.parametrize("method", METHODS[:2])
def test_an_equality(method):
    found = rosenbrock("r = 0.5").optimise(method)
    assert found.constraints[0].value == pytest.approx(0.5, abs=1e-6)
    assert found.constraints[0].active


@pytest.mark.parametrize("method", METHODS)
def test_no_design_says_which_constraints_are_against_each_other(method):
    functions = [
        *rosenbrock().functions,
        Function("sum", lambda v: v["x"] + v["y"], ["x", "y"]),
        Function("difference", lambda v: v["x"] - v["y"], ["x", "y"]),
    ]
    limits = ["r < 1.5", "sum > 3", "difference < 1"]
    found = Design(None, rosenbrock().variables, "f", limits, functions=functions).optimise(method)
    assert not found.feasible
    assert found.conflict == ("r", "sum")
    # the least violation, over the limits, is where r/1.5 - 1 = 1 - sum/3 with x = y
    x = found["x"]
    assert 2 * x**2 / 1.5 - 1 == pytest.approx(1 - 2 * x / 3, abs=1e-3)
    assert "sum is 2" in found.sentence and "Against each other: r, sum" in found.sentence


@pytest.mark.parametrize("method", METHODS[:3])
def test_a_point_without_results_is_a_step_back(method):
    """Beyond x = 0.5 there are no results, and the limit x^3 < 0.09 is flat at the start, so that steps lead there."""
    functions = [Function("f", lambda v: (v["x"] - 2) ** 2, ["x"]), Function("g", lambda v: v["x"] ** 3, ["x"])]
    design = Design(None, [Variable("x", -2, 2, -0.05)], "f", ["g < 0.09"], functions=functions)
    failures = []

    class Broken:
        def evaluate(self, x, jacobian=False):
            if x[0] > 0.5:
                failures.append(float(x[0]))
                raise ModelError("no equilibrium here.")
            return Evaluated({}, {}, {} if jacobian else None)

    object.__setattr__(design, "results", Broken())
    lines = []
    found = design.optimise(method, say=lines.append)
    assert failures and any("no equilibrium here" in line for line in lines)
    assert found.converged and found["x"] == pytest.approx(0.09 ** (1 / 3), abs=2e-3)
