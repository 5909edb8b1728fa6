"""Designs of models: a beam with a known optimum, and a spar whose optimum lies on the edge of its map."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

import fowtlib as fw
from fowtlib.analysis.fatigue.curves import sn_curve
from fowtlib.analysis.fatigue.spectral import dirlik
from fowtlib.analysis.spectra import Spectrum
from fowtlib.components.environment import World
from fowtlib.components.mechanics import PointMass, TubeBeam
from fowtlib.design import Constraint, Design, DesignCase, Function, Objective, Statistics, Variable
from fowtlib.design.measures import Meter
from fowtlib.language.errors import ModelError

LENGTH, TIP, PERIOD, SLENDER, DENSITY, YOUNG = 100.0, 4e5, 2.0, 160.0, 8500.0, 210e9


@cache
def cantilever():
    """A tube of steel with a mass at its tip, without weight."""
    model = fw.Assembly()
    model.world = World(gravity=0)
    stations = np.linspace(0, LENGTH, 9)
    model.tower = TubeBeam(heights=stations, diameters=[6.0] * 9, wall_thicknesses=[0.04] * 9, hinges=8)
    model.head = PointMass(mass=TIP)
    model.connect(model.world.frame, model.tower.frame_a)
    model.connect(model.tower.frame_b, model.head.frame_a)
    return fw.load(model).compile()


@cache
def spar():
    return fw.load("two_rotor_spar_design").compile()


def period(diameter: float, wall: float) -> float:
    """First of the Euler-Bernoulli cantilever with a mass at its tip."""
    inner = diameter - 2 * wall
    area, inertia = np.pi / 4 * (diameter**2 - inner**2), np.pi / 64 * (diameter**4 - inner**4)
    share = TIP / (DENSITY * area * LENGTH)

    def equation(b):
        return 1 + np.cos(b) * np.cosh(b) + share * b * (np.cos(b) * np.sinh(b) - np.sin(b) * np.cosh(b))

    b = brentq(equation, 0.1, 1.875104)
    return 2 * np.pi / (b**2 * np.sqrt(YOUNG * inertia / (DENSITY * area * LENGTH**4)))


def tube(**more) -> Design:
    slender = Function("slenderness", lambda v: v["D"] / v["t"], ["D", "t"])
    variables = [
        Variable("D", "3 m", "10 m", drives="tower.diameters", points=1),
        Variable("t", "10 mm", "80 mm", drives="tower.wall_thicknesses", points=1),
    ]
    limits = [f"period of mode 1 < {PERIOD} s", f"slenderness < {SLENDER}"]
    return Design(cantilever(), variables, "tower: mass", limits, functions=[slender], **more)


@pytest.mark.parametrize("method", ["ipopt", "slsqp"])
def test_a_tube_of_least_mass_with_a_period(method):
    wall = brentq(lambda t: period(SLENDER * t, t) - PERIOD, 0.01, 0.08)
    found = tube().optimise(method)
    assert found.converged and found.active == ["period of mode 1 <", "slenderness <"]
    assert found["t"] == pytest.approx(wall, rel=5e-3) and found["D"] == pytest.approx(SLENDER * wall, rel=5e-3)
    inner = SLENDER * wall - 2 * wall
    assert found.value == pytest.approx(DENSITY * np.pi / 4 * ((SLENDER * wall) ** 2 - inner**2) * LENGTH, rel=1e-2)
    assert found.results["design"]["period of mode 1"] == pytest.approx(PERIOD, rel=1e-5)


def test_a_spline_along_the_tube_is_lighter_than_one_size():
    one = tube().optimise("slsqp")
    slender = Function("slenderness", lambda v: v["tower.diameters"] / v["tower.wall_thicknesses"],
                       ["tower.diameters", "tower.wall_thicknesses"])  # fmt: skip
    variables = [
        Variable("D", "3 m", "10 m", drives="tower.diameters", points=2, along="tower.heights"),
        Variable("t", "10 mm", "80 mm", drives="tower.wall_thicknesses", points=2, along="tower.heights"),
    ]
    limits = [f"period of mode 1 < {PERIOD} s", Constraint("slenderness", upper=SLENDER, aggregate="ks", sharpness=200)]
    found = Design(cantilever(), variables, "tower: mass", limits, functions=[slender]).optimise("slsqp", iterations=30)
    assert found.feasible and found.value < 0.8 * one.value
    sizes = found.members[0].value
    assert np.all(np.diff(sizes) < 0)  # thickest at the root, where it bends most
    assert np.all(sizes / found.members[1].value <= SLENDER * (1 + 1e-5))
    assert found.members[0].stations[-1] == LENGTH


def hull(**more) -> Design:
    """The least steel of a hull with the pitch and the periods of the thesis; the ballast follows the draft."""
    variables = [Variable("diameter", "9 m", "12 m"), Variable("waterline_diameter", "6 m", "12 m")]
    cases = [DesignCase("thrust"), DesignCase("rest", {"thrust": 0})]
    limits = ["pitch @ thrust < 5 deg", "period of heave @ rest > 25 s"]
    given = {"free": ["ballast"], "targets": {"heave": 0}, "cases": cases} | more
    return Design(spar(), variables, "hull: mass", limits, **given)


def test_the_optimum_of_a_spar_lies_on_the_edge_of_its_map():
    """No point of the grid that keeps the limits is better, and beyond the active limit nothing is allowed."""
    found = hull().optimise("ipopt")
    assert found.converged and "pitch @ thrust <" in found.active
    axes = {name: found[name] + np.array([-0.2, -0.02, 0.02, 0.2]) for name in ("diameter", "waterline_diameter")}
    axes["waterline_diameter"] = np.clip(axes["waterline_diameter"], 6, 12)
    around = fw.parameter_map(spar(), axes, ["hull: mass"], limits=["pitch < 5 deg"], free=["ballast"],
                              targets={"heave": 0})  # fmt: skip
    kept = around.feasible
    assert kept.any() and not kept.all()
    assert np.min(around["hull: mass"][kept]) > found.value
    assert found.parameters["ballast"] == pytest.approx(
        spar().equilibrium(
            {name: found[name] for name in axes}, free=["ballast"], targets={"heave": 0}
        ).parameters["ballast"], rel=1e-6,
    )  # fmt: skip


def test_prices_of_a_spar_are_what_a_limit_costs():
    """The price of the pitch, beside a second optimum with another limit; that of a bound likewise."""

    def best(limit, least):
        variables = [Variable("diameter", "9 m", "14 m"), Variable("waterline_diameter", least, "12 m")]
        return Design(spar(), variables, "hull: mass", [f"pitch < {limit} deg", "period of heave > 25 s"],
                      free=["ballast"], targets={"heave": 0}).optimise("slsqp")  # fmt: skip

    found, moved = best(5.0, 6.0), best(5.02, 6.01)
    assert found.active == ["pitch <", "waterline_diameter (lower bound)"]
    gained = 0.02 * found.constraints[0].price - 0.01 * found.variables[1].price
    assert found.constraints[0].price > 0 and found.variables[1].price > 0 and found.rest < 1e-4
    assert found.value - moved.value == pytest.approx(gained, rel=1e-2)


def test_slopes_are_those_of_a_finer_difference():
    """Beside Richardson's extrapolation of the results themselves."""
    design = hull()
    problem = design.problem()
    x = design.space.start
    _, slopes = problem.composition.slopes_at(x, design.results.evaluate(x, jacobian=True))

    def g(k, h):
        moved = x.copy()
        moved[k] += h
        return problem.composition.at(moved, design.results.evaluate(moved))[1]

    for k in range(x.size):
        one, two = ((g(k, h) - g(k, -h)) / (2 * h) for h in (2e-2, 1e-2))
        assert slopes[:, k] == pytest.approx((4 * two - one) / 3, rel=1e-5, abs=1e-7)


def test_at_a_bound_the_slopes_are_one_sided():
    design = hull()
    x = np.array([design.space.lower[0], design.space.upper[1]])
    asked = []
    evaluator = design.results
    measured = evaluator._one
    names = ("diameter", "waterline_diameter")

    def seen(case, parameters, near, fixed):
        asked.append([parameters[name] for name in names])
        return measured(case, parameters, near, fixed)

    evaluator._one = seen
    bounded = evaluator.evaluate(x, jacobian=True).jacobian
    assert min(point[0] for point in asked) >= x[0] and max(point[1] for point in asked) <= x[1]
    free = Design(spar(), [Variable("diameter", 8, 13, 9.0), Variable("waterline_diameter", 6, 13, 12.0)], "hull: mass",
                  design.constraints, design.cases, free=design.free, targets=design.targets)  # fmt: skip
    central = free.results.evaluate(x, jacobian=True).jacobian
    for key, slope in bounded.items():
        assert slope == pytest.approx(central[key], rel=1e-5, abs=1e-9)


def test_a_response_to_waves_and_wind_is_a_result():
    """Its slopes are differences at the same frequencies."""
    plant = fw.load("oc3_spar_rigid").compile()
    weather = {"wind.mean_speed": 18.0, "wind.kind": "kaimal", "sea.spectrum": "jonswap",
               "sea.significant_wave_height": 4.0, "sea.peak_period": 10.0}  # fmt: skip
    mooring = next(path for path in plant.dae.parameters if path.endswith("yaw_stiffness"))
    design = Design(plant, [Variable(mooring, 5e7, 2e8)], "std of yaw", ["largest pitch < 20 deg"],
                    [DesignCase("storm", weather)])  # fmt: skip
    given = design.evaluate()
    asked = fw.response(plant, outputs=["yaw", "pitch"], parameters=weather)
    assert given.results["storm"]["std of yaw"] == pytest.approx(asked.std("yaw"), rel=1e-3)
    assert given.results["storm"]["largest pitch"] == pytest.approx(asked.extreme("pitch"), rel=1e-3)
    x = design.space.start
    slope = design.results.evaluate(x, jacobian=True).jacobian["storm", "std of yaw"][0, 0]
    ahead, behind = (
        fw.response(plant, outputs=["yaw"], parameters={**weather, mooring: x[0] * share}, tolerance=1e-7,
                    frequencies=asked.frequency).std("yaw") for share in (1.01, 0.99)
    )  # fmt: skip
    assert slope == pytest.approx((ahead - behind) / (0.02 * x[0]), rel=1e-3)


def test_ballast_of_one_case_is_that_of_the_others():
    """With a balance at rest the hull is lifted by the lines under thrust, and no ballast changes."""
    variables = [Variable("diameter", "9 m", "12 m")]
    cases = [DesignCase("thrust"), DesignCase("rest", {"thrust": 0})]
    limits = ["pitch @ thrust < 5 deg", Constraint("heave", lower=-9.0), "ballast @ thrust < 1e9"]
    design = Design(spar(), variables, "ballast @ rest", limits, cases, free=["ballast"], targets={"heave": 0},
                    balance="rest")  # fmt: skip
    found = design.evaluate()
    rest = spar().equilibrium({"thrust": 0}, free=["ballast"], targets={"heave": 0})
    pushed = spar().equilibrium({"ballast": rest.parameters["ballast"]})
    assert found.parameters["ballast"] == pytest.approx(float(rest.parameters["ballast"]), rel=1e-9)
    assert found.results["thrust"]["ballast"] == pytest.approx(found.results["rest"]["ballast"], rel=1e-12)
    assert found.results["thrust"]["pitch"] == pytest.approx(pushed["pitch"], rel=1e-6)
    assert found.results["thrust"]["heave"] == pytest.approx(pushed["heave"], rel=1e-6)
    assert abs(found.results["rest"]["heave"]) < 1e-6 < abs(pushed["heave"])
    x = design.space.start
    slopes = design.results.evaluate(x, jacobian=True).jacobian
    ahead, behind = (design.results.evaluate(x + h).values for h in (0.01, -0.01))
    for key, slope in slopes.items():
        assert slope[0, 0] == pytest.approx(float(ahead[key][0] - behind[key][0]) / 0.02, rel=1e-4, abs=1e-6)
    with pytest.raises(ModelError, match="the balance is of no case 'calm'"):
        Design(spar(), variables, "mass", (), cases, free=["ballast"], targets={"heave": 0}, balance="calm")
    with pytest.raises(ModelError, match="needs parameters that are free"):
        Design(spar(), variables, "mass", (), cases, balance="rest")


def test_damage_of_a_lifetime_is_that_of_dirlik():
    """Of a stress in MPa, as if the case lasted all the time; without an S-N curve it is refused."""
    frequency = np.linspace(0.05, 0.5, 300)
    spectrum = Spectrum(frequency, 900.0 * np.exp(-(((frequency - 0.1) / 0.02) ** 2)), "MPa", "stress")
    curve, years = sn_curve("D"), 20 * 365.25 * 24 * 3600.0
    meter = SimpleNamespace(statistics=Statistics(curve=curve))
    found = Meter._of(meter, SimpleNamespace(spectrum=lambda name: spectrum), "damage of ", "stress")
    assert found == pytest.approx(dirlik(spectrum).damage(curve, years)) and 1e-3 < found < 1e3
    with pytest.raises(ModelError, match="needs an S-N curve"):
        Meter(spar(), DesignCase("a"), ["damage of pitch"])


def test_cases_are_weighted():
    """An objective is the mean over the cases with their weights; a constraint counts in those it names."""
    cases = [DesignCase("full", weight=3), DesignCase("half", {"thrust": 404e3}, weight=1)]
    variables = [Variable("diameter", "9 m", "12 m")]
    limits = [
        Constraint("pitch", upper="5 deg"),
        Constraint("pitch", upper="2 deg", cases=["half"]),
        "weighted pitch < 9",
        "root < 3",  # of the same results in all cases: it counts once
    ]
    root = [Function("root", lambda values: values["weighted pitch"] ** 0.5, ["weighted pitch"])]
    asked = Design(spar(), variables, {"pitch": 2.0}, limits, cases, root, free=["ballast"], targets={"heave": 0})
    found = asked.evaluate()
    full, half = (found.results[name]["pitch"] for name in ("full", "half"))
    assert half < 0.6 * full
    assert found.value == pytest.approx(2 * (3 * full + half) / 4)
    rest = {"free": ["ballast"], "targets": {"heave": 0}}
    told = Design(spar(), variables, "weighted pitch", limits[:3], cases, **rest).evaluate()
    assert 2 * told.value == pytest.approx(found.value)
    names = {item.name: item.value for item in found.constraints}
    assert names == pytest.approx(
        {"pitch (full)": full, "pitch (half)": half, "pitch": half, "weighted pitch": found.value / 2,
         "root": (found.value / 2) ** 0.5}
    )  # fmt: skip
    assert str(Objective.read({"pitch": 2.0})) == "2 x pitch"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variables": [Variable("diametre", 9, 12)]}, "no such parameter; did you mean 'diameter'"),
        ({"variables": [Variable("hull.column.sections", 5, 20)]}, "structural parameter"),
        ({"variables": [Variable("mooring.fairlead_depth", 50, 100)]}, "follows from other parameters"),
        ({"variables": [Variable("diameter", 12, 9)]}, "bounds of 'diameter', 12 and 9 m, are the wrong way round"),
        (
            {"variables": [Variable("diameter", 11, 12)]},
            "10.5 m as of the model, is not between its bounds 11 and 12 m",
        ),
        ({"variables": [Variable("diameter", "9 kg", 12)]}, "kg"),
        ({"variables": [Variable("diameter", 9, 12), Variable("d", 9, 12, drives="diameter")]}, "both drive diameter"),
        ({"objective": "masss"}, "no quantity 'masss'"),
        ({"constraints": ["pich < 5 deg"]}, "no quantity 'pich'; did you mean 'pitch'"),
        ({"constraints": ["pitch 5"]}, "is no constraint, such as"),
        ({"constraints": ["pitch @ storm < 5"]}, "there is no case 'storm'"),
        (
            {"constraints": [Constraint("pitch", upper=5, cases=["storm"])]},
            "is never evaluated: there is no case 'storm'",
        ),
        ({"constraints": ["std of roll < 5"]}, "is of no result of the model"),
        ({"constraints": ["pitch < 5 kg"]}, "kg"),
        ({"functions": [Function("cost", lambda v: v["mass"], ["mass"])]}, "nothing uses the function 'cost'"),
        ({"cases": [DesignCase("a"), DesignCase("a")]}, "two cases 'a'"),
    ],
)
def test_mistakes_are_told(changes, message):
    given = {"variables": [Variable("diameter", 9, 12)], "objective": "mass", "constraints": ["pitch < 5 deg"]}
    with pytest.raises(ModelError) as error:
        Design(spar(), **{**given, **changes}).evaluate()
    assert message in str(error.value)
