"""A Kalman estimator scheduled over the wind: the design at a point, no jump between points, a turbine, an FMU."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import AttitudeSensor
from fowtlib.components.servo import EstimatorTable, ScheduledEstimator, read_estimators
from fowtlib.control import OperatingPoints, discretized, estimator_table, kalman, reduced
from fowtlib.control.points import OperatingPoint
from fowtlib.language import Component, RealOutput, Scalar, der, eq, initial, param, port, var
from fowtlib.language.errors import ParameterError
from fowtlib.solving import LinearModel

POINTS = (5.0, 7.0, 8.0)


def spring(v):
    """With x'' = -v x - 0.3 x' + v force + noise: the stiffness, and the rest under a force, go with v."""
    A = np.array([[0.0, 1.0], [-v, -0.3]])
    return LinearModel(A, np.array([[0.0, 0.0], [v, 1.0]]), np.eye(2), np.zeros((2, 2)), ["x", "w"], ["force", "noise"],
                       ["x", "w"], {})  # fmt: skip


def rest(v):
    """Force 1 + v / 10, position the same."""
    return {"x": 1 + v / 10, "w": 0.0, "force": 1 + v / 10}


def designs(points=POINTS, measured="x"):
    return [kalman(spring(v), {"noise": 4.0}, {measured: 0.01}) for v in points]


def made(points=POINTS, **given):
    at = [OperatingPoint(v, rest(v), spring(v), {"force": rest(v)["force"]}) for v in points]
    return estimator_table(at, designs(points, **given), "v")


class Spring(Component):
    """That spring with its v as a signal, which goes at a rate, off its rest at the start."""

    first: Scalar = param(default=5.0, doc="v at the start")
    rate: Scalar = param(default=0.0, doc="rate of v")
    away: Scalar = param(default=0.2, doc="distance from the rest at the start")
    v: RealOutput = port(doc="schedule")
    force: RealOutput = port(doc="force at rest")
    x: RealOutput = port(doc="position")

    p: Scalar = var(state="prefer", doc="position")
    w: Scalar = var(state="prefer", doc="speed")

    def equations(self):
        now = self.first + self.rate * self.time
        return [
            eq(self.v, now), eq(self.force, 1 + now / 10), eq(self.x, self.p), eq(der(self.p), self.w),
            eq(der(self.w), -now * (self.p - self.force) - 0.3 * self.w),
            initial(self.p, self.force + self.away), initial(self.w, 0),
        ]  # fmt: skip


def watched(table, **settings):
    model = fw.Assembly("spring that is watched")
    model.spring, model.watch = Spring(**settings), ScheduledEstimator(table=table)
    for a, b in (
        (model.spring.v, model.watch.schedule), (model.spring.force, model.watch.u[0]),
        (model.spring.x, model.watch.y[0]),
    ):  # fmt: skip
        model.connect(a, b)
    return fw.load(model).compile()


@pytest.mark.parametrize("v", POINTS)
def test_at_a_point_it_is_the_design(v):
    plant = watched(made(), first=v)
    linear = plant.linearize(plant.initial_state(), outputs=[])
    kept = [linear.states.index(f"watch.estimate[{i}]") for i in range(2)]
    poles = np.linalg.eigvals(linear.matrices["A"][np.ix_(kept, kept)])
    assert_allclose(np.sort_complex(poles), np.sort_complex(designs([v])[0].poles), rtol=1e-7)


def test_it_finds_the_states_from_a_wrong_start_as_the_error_of_the_design_decays():
    plant = watched(made(), first=7.0)
    result = plant.simulate(6.0, 0.1, tolerance=1e-9)
    error = np.array([np.asarray(result[f"watch.x[{i}]"]) - np.asarray(result[name])
                      for i, name in enumerate(("spring.x", "spring.w"))])  # fmt: skip
    assert_allclose(error[:, 0], [-0.2, 0.0], atol=1e-9)
    values, vectors = np.linalg.eig(designs([7.0])[0].filter.matrices["A"])
    parts = np.linalg.solve(vectors, error[:, 0].astype(complex))
    wanted = np.real(vectors @ (parts[:, None] * np.exp(values[:, None] * np.asarray(result.time))))
    assert_allclose(error, wanted, atol=1e-6)


def test_nothing_jumps_where_the_schedule_moves():
    """The schedule goes through a point while the plant stands at its moving rest: the estimate stays smooth.

    Half way between points the arrays are the mean. With the distance from the rest as state, x would move at the rate
    of the rest even where the plant does not.
    """
    plant = watched(made(), first=6.0, rate=0.5, away=0.0)
    result = plant.simulate(4.0, 0.01, tolerance=1e-10)
    estimate, true = np.asarray(result["watch.x[0]"]), np.asarray(result["spring.x"])
    step = np.diff(estimate)
    assert np.abs(np.diff(step)).max() < 2e-4 and np.abs(step).max() < 0.01
    assert np.abs(estimate - true).max() < 2e-3  # linear between points, as the plant is
    assert step[0] == pytest.approx(0.0, abs=2e-5)
    table = made()
    assert_allclose(table.at(6.0).L[0], (table.L[0] + table.L[1]) / 2, rtol=1e-12)
    for v in (1.0, 30.0):
        assert_allclose(table.at(v).A[0], table.A[0 if v < 5 else -1], rtol=1e-12)


def test_numbers_are_parameters_of_a_run():
    plant, other = watched(made((5.0, 7.0))), made((5.0, 7.0))
    slow = {"watch.L": 0.1 * other.L.reshape(2, -1)}
    fast, late = (np.asarray(plant.simulate(2.0, 0.5, parameters=q)["watch.x[0]"])[2] for q in ({}, slow))
    assert abs(fast - late) > 0.03


def test_tables_keep_their_numbers_in_files(tmp_path):
    table = made()
    again = read_estimators(str(table.save(tmp_path / "estimators.json")))
    for name in ("points", *table.shapes()):
        assert np.array_equal(getattr(again, name), getattr(table, name))
    assert again.states == ("x", "w") and again.inputs == ("force",) and again.outputs == ("x",)


def test_mistakes_are_sentences(tmp_path):
    table = made()
    with pytest.raises(ParameterError, match=r"L has the shape \(3, 1, 2\); with 3 points, 2 states, 1 inputs"):
        EstimatorTable(*(getattr(table, name) for name in ("over", "points", "states", "inputs", "outputs", *"ABCD")),
                       np.swapaxes(table.L, 1, 2), table.x0, table.u0, table.y0)  # fmt: skip
    with pytest.raises(ParameterError, match="3 operating points and 1 estimators; give one each"):
        estimator_table([None] * 3, designs([5.0]))
    at = [OperatingPoint(v, rest(v), spring(v), {"force": 0.0}) for v in (5.0, 7.0)]
    with pytest.raises(ParameterError, match="v = 7: the estimator has other states, inputs or outputs"):
        estimator_table(at, [*designs([5.0]), *designs([7.0], measured="w")], "v")
    sampled = kalman(discretized(spring(5.0), 0.1), {"noise": 4.0}, {"x": 0.01})
    with pytest.raises(ParameterError, match="v = 5: the estimator is of a sampled model"):
        estimator_table(at[:1], [sampled], "v")
    (tmp_path / "gains.json").write_text('{"fowtlib": "gains"}')
    with pytest.raises(ParameterError, match=r"gains.json: this is not a table of estimators, as EstimatorTable.save"):
        read_estimators(str(tmp_path / "gains.json"))


def test_it_watches_a_turbine_through_a_change_of_wind():
    """A spar after a change from 14 to 18 m/s, watched by rotor speed, platform pitch and blade pitch.

    At rest in the new wind the estimate is the truth, and an estimator of 14 m/s alone is not; on the way the rate of
    pitch, which nobody measures, is followed. Surge is held in the design, and its motion leaves an error.
    """
    pitch = ["platform.motion.pitch", "platform.motion.angle_rates[1]"]
    states, measured = ["turbine.rotor.w", *pitch], ["turbine.rotor.w", pitch[0]]
    points = OperatingPoints(fw.load("oc3_spar_rigid"), {"blade": "turbine.rotor.blade_pitch"}, measured)
    at = points.over_values([14.0, 16.0, 18.0])
    held = [name for name in at[0].linear.states if name.startswith("platform") and name not in states]
    noise = {"wind.mean_speed": 1.0, pitch[1]: 1e-5}
    found = [kalman(reduced(point.linear, states, held), noise, dict(zip(measured, (1e-4, 1e-6), strict=True)))
             for point in at]  # fmt: skip
    model = fw.load("oc3_spar_rigid")
    root = model.root
    root.watch, root.attitude = ScheduledEstimator(table=estimator_table(at, found)), AttitudeSensor()
    root.blows = Constant(value=14.0)
    for a, b in (
        (root.blows.y, root.watch.schedule), (root.turbine.blade_pitch, root.watch.u[0]),
        (root.turbine.rotor_speed, root.watch.y[0]), (root.platform.frame, root.attitude.frame),
        (root.attitude.pitch, root.watch.y[1]),
    ):  # fmt: skip
        root.connect(a, b)
    plant = model.compile()
    calm = {"wind.kind": "steady", "sea.spectrum": "still"}
    for v in (14.0, 18.0):
        here = plant.equilibrium(calm | {"wind.mean_speed": v, "blows.value": v})
        assert_allclose([here[f"watch.x[{i}]"] for i in range(3)], [here[name] for name in states], atol=1e-7)
    alone = estimator_table(at[:1], found[:1])
    first = {f"watch.{name}": np.repeat(getattr(alone, name).reshape(1, -1), 3, axis=0) for name in alone.shapes()}
    fixed = plant.equilibrium(calm | first | {"wind.mean_speed": 18.0})
    assert abs(fixed["watch.x[0]"] - fixed["turbine.rotor.w"]) > 0.02
    start = plant.equilibrium(calm | {"wind.mean_speed": 14.0})
    blow = calm | {"wind.mean_speed": 18.0, "blows.value": 18.0}
    result = plant.simulate(120.0, 0.5, solver="fixed", start=start, parameters=blow)
    estimate, rate = np.asarray(result["watch.x[2]"]), np.asarray(result[states[2]])
    assert np.std(estimate - rate) < 0.3 * np.std(rate) and np.std(rate) > 1e-4


@pytest.mark.skipif(not importlib.util.find_spec("fmpy"), reason="fmpy is not installed")
def test_it_is_exported(tmp_path):
    """The FMU goes the way of the matrices from the rest on, under signals that stay; in steps of 2 ms."""
    import fmpy

    from fowtlib.language.native import compiler

    if not compiler():
        pytest.skip("no compiler")
    table = made()
    model = fw.Model(ScheduledEstimator(table=table), outputs={"x": fw.Output("x[0]"), "w": fw.Output("x[1]")},
                     name="watch")  # fmt: skip
    path = fw.export_fmu(model.compile(), tmp_path / "watch.fmu")
    described = fmpy.read_model_description(str(path))
    parameters = {v.name for v in described.modelVariables if v.causality == "parameter"}
    assert sum(name.startswith("L") for name in parameters) == 6
    here, step = table.at(6.0), 0.1
    signals = np.array([(t, 6.0, 1.6, 1.9) for t in (0.0, step)],
                       dtype=[("time", float), ("schedule", float), ("u[0]", float), ("y[0]", float)])  # fmt: skip
    rows = fmpy.simulate_fmu(str(path), stop_time=step, output_interval=2e-3, input=signals, output=["x", "w"])
    from scipy.linalg import expm

    A, drive = here.A[0] - here.L[0] @ here.C[0], here.L[0] @ [0.3]
    moved = np.linalg.solve(A, (expm(A * step) - np.eye(2)) @ drive)
    assert_allclose([rows["x"][-1], rows["w"][-1]], here.x0[0] + moved, atol=1e-5)
