"""State feedback and estimator as parts: they do what their matrices say, and their numbers are data."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.servo import GainTable, ScheduledFeedback, StateEstimator, read_gains
from fowtlib.control import discretized, gain_table, kalman, lqi, lqr
from fowtlib.control.points import OperatingPoint
from fowtlib.language import Component, RealInput, RealOutput, Scalar, der, eq, port, var
from fowtlib.language.errors import ParameterError
from fowtlib.solving import LinearModel

DATA = Path(__file__).parents[2] / "models" / "data"


class Cart(Component):
    """x'' = force + wind."""

    force: RealInput = port(default=0.0, doc="force of the controller")
    wind: RealInput = port(default=0.0, doc="another force")
    x: RealOutput = port(doc="position")
    v: RealOutput = port(doc="speed")

    p: Scalar = var(state="prefer", start=1.0, fixed=True, doc="position")
    w: Scalar = var(state="prefer", fixed=True, doc="speed")

    def equations(self):
        motion = [eq(der(self.p), self.w), eq(der(self.w), self.force + self.wind)]
        return [*motion, eq(self.x, self.p), eq(self.v, self.w)]


def cart(inputs=("force",)):
    B = np.array([[0.0] * len(inputs), [1.0] * len(inputs)])
    return LinearModel(np.array([[0.0, 1], [0, 0]]), B, np.eye(2), np.zeros((2, len(inputs))), ["x", "v"], list(inputs),
                       ["x", "v"], {})  # fmt: skip


def table(*weights, points=None, integral=0.0, set_point=0.0):
    points = points or range(len(weights))
    regulators = [
        lqi(cart(), {"x": q}, 1.0, {"x": integral}) if integral else lqr(cart(), {"x": q}, 1.0) for q in weights
    ]
    k = len(weights)
    made = gain_table(
        [OperatingPoint(float(v), {"x": set_point, "v": 0.0}, cart(), {"force": 0.0}) for v in points], regulators, "v"
    )
    assert made.gains.shape == (k, 1, 2)
    return made, regulators


def system(gains, schedule=0.0, wind=0.0, **settings):
    model = fw.Assembly("cart under a regulator")
    model.cart, model.at, model.wind = Cart(), Constant(value=schedule), Constant(value=wind)
    model.law = ScheduledFeedback(table=gains, **settings)
    for a, b in (
        (model.cart.x, model.law.measured[0]), (model.cart.v, model.law.measured[1]), (model.at.y, model.law.schedule),
        (model.law.demand[0], model.cart.force), (model.wind.y, model.cart.wind),
    ):  # fmt: skip
        model.connect(a, b)
    return fw.load(model).compile()


@pytest.mark.parametrize("integral", [0.0, 0.3])
def test_the_closed_loop_has_the_poles_of_the_design(integral):
    made, (regulator, _) = table(2.0, 5.0, integral=integral)
    plant = system(made)
    poles = [mode.eigenvalue for mode in plant.linearize(plant.equilibrium(), outputs=[]).modes()]
    poles += [pole.conjugate() for pole in poles if pole.imag]
    wanted = regulator.poles if integral else [*regulator.poles, 0.0]
    assert_allclose(np.sort_complex(poles), np.sort_complex(wanted), atol=1e-7)


def test_integral_action_holds_the_set_point_against_a_steady_force():
    plant = system(table(2.0, integral=0.3, set_point=0.7)[0], wind=0.4)
    assert_allclose(plant.equilibrium()["cart.x"], 0.7, atol=1e-9)
    without = system(table(2.0, set_point=0.7)[0], wind=0.4).equilibrium(hold={"law.integral[0]": 0.0})
    assert_allclose(without["cart.x"], 0.7 + 0.4 / np.sqrt(2.0), rtol=1e-9)


def test_between_two_points_lie_straight_lines_and_nothing_jumps():
    """Half way the gains are the mean; across a point the demand is continuous with any value of the integral."""
    made, _ = table(1.0, 4.0, 9.0, points=[5.0, 7.0, 8.0], integral=0.5)
    plant = system(made, 6.0)
    start = {"cart.p": 0.3, "cart.w": -0.2, "law.integral[0]": 1.7}

    def demand(schedule):
        return plant.initial_state({"at.value": schedule}, start)["law.demand"]

    for v in (6.0, 7.4):
        here = made.at(v)
        assert_allclose(demand(v), 1.7 - here.gains[0, 0] @ [0.3, -0.2], rtol=1e-12)
    assert_allclose(made.at(6.0).gains, made.gains[:2].mean(axis=0)[None])
    for point in made.points:
        assert abs(demand(point - 1e-9) - demand(point + 1e-9)) < 1e-8
    assert demand(1.0) == demand(5.0) and demand(30.0) == demand(8.0)


def test_the_integral_stays_within_its_limits_and_comes_back():
    """A force too strong for the limit: the integral waits there, and leaves as soon as the error changes its sign."""
    made, _ = table(2.0, integral=0.5)
    plant = system(made, wind=0.8, lowest=-0.5, highest=0.5)
    integral = np.asarray(plant.simulate(60.0, 0.5)["law.integral"]).ravel()
    assert integral.min() > -0.51 and integral[-1] < -0.49
    free = np.asarray(system(made, wind=0.8).simulate(60.0, 0.5)["law.integral"]).ravel()
    assert free[-1] < -0.75


def test_gains_are_parameters_of_a_run():
    """The same plant with other gains, not compiled anew, is the plant with another table."""
    (soft, _), (stiff, _) = table(1.0), table(16.0)
    plant = system(soft)
    given = {"law.gains": stiff.gains.reshape(1, -1)}
    ours, theirs = (p.simulate(5.0, 0.5, parameters=q)["cart.x"] for p, q in ((plant, given), (system(stiff), None)))
    assert_allclose(np.asarray(ours), np.asarray(theirs), rtol=1e-5, atol=1e-7)
    assert np.abs(np.asarray(ours) - np.asarray(plant.simulate(5.0, 0.5)["cart.x"])).max() > 0.1


def test_the_estimator_finds_the_states_and_rejects_noise():
    """The part has the poles of the design; from a wrong start it finds position and speed from the position alone."""
    design = kalman(cart(("force", "noise")), {"noise": 4.0}, {"x": 0.01})
    A, B, C, _ = (design.model.matrices[name] for name in "ABCD")
    model = fw.Assembly("cart that is watched")
    model.cart, model.push = Cart(), Constant(value=0.1)
    model.watch = StateEstimator(A=A, B=B, C=C, L=design.gain)
    for a, b in ((model.push.y, model.cart.force), (model.push.y, model.watch.u[0]), (model.cart.x, model.watch.y[0])):
        model.connect(a, b)
    plant = fw.load(model).compile()
    linear = plant.linearize(plant.initial_state(), outputs=[])
    kept = [linear.states.index(f"watch.z[{i}]") for i in range(2)]
    poles = np.linalg.eigvals(linear.matrices["A"][np.ix_(kept, kept)])
    assert_allclose(np.sort_complex(poles), np.sort_complex(design.poles), rtol=1e-7)
    result = plant.simulate(8.0, 0.5, tolerance=1e-9)
    assert abs(float(result["watch.x[1]"][0]) - float(result["cart.v"][0])) < 1e-9
    assert abs(float(result["watch.x[0]"][0]) - float(result["cart.x"][0])) > 0.9
    for ours, true in (("watch.x[0]", "cart.x"), ("watch.x[1]", "cart.v")):
        assert abs(float(result[ours][-1]) - float(result[true][-1])) < 1e-4


def test_tables_keep_their_numbers_in_files(tmp_path):
    made, _ = table(1.0, 4.0, integral=0.2)
    again = read_gains(str(made.save(tmp_path / "gains.json")))
    for name in ("points", "gains", "integral_gains", "set_points", "trim"):
        assert np.array_equal(getattr(again, name), getattr(made, name))
    assert again.measured == ("x", "v") and again.demands == ("force",)


def test_mistakes_in_tables_are_sentences(tmp_path):
    made, _ = table(1.0, 4.0)
    path = made.save(tmp_path / "gains.json")
    content = json.loads(path.read_text())

    def refused(change, message):
        path.write_text(json.dumps({**content, **change}))
        with pytest.raises(ParameterError, match=message):
            read_gains(str(path))

    refused({"gains": [[[1.0]]]}, r"gains.json: a table of gains: gains has the shape \(1, 1, 1\); with 2 points")
    refused({"points": [2.0, 1.0]}, "its points must increase")
    refused({"trims": [1]}, "has no 'trims'; did you mean 'trim'")
    refused({"measured": "x"}, "'measured' must be a list of names")
    refused({"trim": [["a"], ["b"]]}, "trim is no array of numbers")
    path.write_text("{}")
    with pytest.raises(ParameterError, match="not a table of gains"):
        read_gains(str(path))
    with pytest.raises(ParameterError, match="saved as .json, not as '.csv'"):
        made.save(tmp_path / "gains.csv")
    with pytest.raises(ParameterError, match=r"L has the shape \(1, 2\); \(2, 1\) fits the others"):
        StateEstimator(A=np.eye(2), B=np.ones((2, 1)), C=np.ones((1, 2)), L=np.ones((1, 2))).compose()
    with pytest.raises(ParameterError, match="2 operating points and 1 regulators"):
        gain_table([None, None], [lqr(cart(), {"x": 1.0}, 1.0)])
    assert isinstance(discretized(cart(), 0.1).period, float)


@pytest.mark.parametrize(("floater", "integral"), [("two_rotor_spar", 0.1), ("oo_star", np.sqrt(1 / 1000))])
def test_the_gains_of_the_two_rotors_are_antisymmetric_in_yaw(floater, integral):
    """Left and right change places with the sign of yaw; the integral gains are sqrt(Q / R) of their weights.

    Not to the last digit: the published inertia of the structure has products of x and y, and of y and z.
    """
    gains = read_gains(str(DATA / floater / "gains.json"))
    left, right = gains.gains[:, 0], gains.gains[:, 1]
    assert_allclose(right[:, [1, 0]], left[:, [0, 1]], rtol=0.03, atol=0.02)
    assert_allclose(right[:, 4:], -left[:, 4:], rtol=0.03, atol=0.05)
    above = gains.points > 12.9
    assert_allclose(gains.integral_gains[above, 0, 0], -integral, rtol=1e-4)
    assert isinstance(gains, GainTable) and np.all(np.diff(gains.trim[gains.points > 12][:, 0]) > 0)


def test_the_gains_on_the_oo_star_have_the_signs_of_the_source():
    """O. El Beshbichi, thesis (2023), table 8.7, with the rows "rated" and "above rated" changed back.

    Below rated -0.01, 0.01, 0.25, 7.11 for own and other speed, yaw and its rate; above rated -0.42, 0.12, 0.63, -5.31
    and integrals 0.032; at rated wind integrals 0.0014. Changed back, because sqrt(Q / R) says so.
    """
    gains = read_gains(str(DATA / "oo_star" / "gains.json"))
    below, above = gains.at(9.0).gains[0, 0], gains.at(13.0).gains[0, 0]
    assert_allclose(below[:2], [-0.01, 0.01], atol=1.5e-3)
    assert below[4] == pytest.approx(0.25, rel=0.15) and below[5] > 0
    assert np.array_equal(np.sign(above[[0, 1, 4, 5]]), [-1, 1, 1, -1])
    assert above[0] == pytest.approx(-0.42, rel=0.4) and above[1] == pytest.approx(0.12, rel=0.6)
    for wind, integral in ((12.0, 0.0014), (13.0, 0.032)):
        assert round(-gains.at(wind).integral_gains[0, 0, 0], 4 if integral < 0.01 else 3) == integral


@pytest.mark.skipif(not importlib.util.find_spec("fmpy"), reason="fmpy is not installed")
def test_a_feedback_is_exported_with_its_gains_as_parameters(tmp_path):
    """The FMU gives the demand of its matrices; gains and set points are its parameters, and changed there they act."""
    import fmpy

    from fowtlib.language.native import compiler

    if not compiler():
        pytest.skip("no compiler")
    made, _ = table(1.0, 4.0, points=[5.0, 7.0], integral=0.5)
    names = ("schedule", "measured[0]", "measured[1]")
    model = fw.Model(ScheduledFeedback(table=made), outputs={"asked": fw.Output("demand[0]")}, name="law")
    path = fw.export_fmu(model.compile(), tmp_path / "law.fmu")
    described = fmpy.read_model_description(str(path))
    parameters = {v.name for v in described.modelVariables if v.causality == "parameter"}
    gains = sorted(name for name in parameters if name.startswith("gains"))
    assert gains
    signals = np.array([(0.0, 6.0, 0.2, -0.1), (1.0, 6.0, 0.2, -0.1)],
                       dtype=[("time", float), *((name, float) for name in names)])  # fmt: skip

    def demand(**start):
        rows = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.5, input=signals, output=["asked"],
                                 start_values=start)  # fmt: skip
        return rows["asked"]

    here = made.at(6.0)
    integral = -here.integral_gains[0, 0] @ [0.2, -0.1]
    assert_allclose(demand(), -here.gains[0, 0] @ [0.2, -0.1] + integral * np.array([0, 0.5, 1.0]), atol=1e-6)
    changed = demand(**{gains[0]: 5.0})
    assert abs(changed[0] - demand()[0]) > 1e-3
