"""Calibration against records whose parameters are known: of the model itself, with noise and a zero that is off."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import FixedTranslation, Prismatic, RigidBody, SpringDamper
from fowtlib.design.calibration import CalibrationStopped, calibrate
from fowtlib.language import Component, Scalar, der, eq, outer, param, port
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError, ParameterError


class QuadraticDamper(Component):
    """A force c v |v| against the motion along z."""

    coefficient: Scalar = param(unit="N*s^2/m^2", min=0, doc="force over the square of the speed")
    idle: Scalar = param(default=1.0, doc="a number that nothing depends on")

    frame: fw.components.mechanics.Frame = port(doc="what moves")
    world: World = outer(World)

    def equations(self):
        v = der(self.frame.r)[2]
        return [eq(self.frame.f, m.vertcat(0, 0, self.coefficient * v * m.smooth_abs(v, 1e-5))),
                eq(self.frame.t, m.zeros(3))]  # fmt: skip


def heaving(stiffness: float = 850.0, damping: float = 30.0, quadratic: float = 200.0) -> fw.Model:
    """The heave of a spar at 1:45 on a spring; its added mass is a body."""
    root = fw.Assembly("heave at 1:45")
    root.world = World(gravity=1e-3)
    root.slide = Prismatic(n=(0, 0, 1))
    root.body = RigidBody(mass=186.0, inertia=np.eye(3))
    root.water = RigidBody(mass=207.0, inertia=np.eye(3))
    root.above = FixedTranslation(r=(0, 0, 10))
    root.spring = SpringDamper(stiffness=stiffness, damping=damping, natural_length=10.0)
    root.drag = QuadraticDamper(coefficient=quadratic)
    root.connect(root.world.frame, root.slide.frame_a)
    for frame in (root.body.frame_a, root.water.frame_a, root.drag.frame, root.spring.frame_b):
        root.connect(root.slide.frame_b, frame)
    root.connect(root.world.frame, root.above.frame_a)
    root.connect(root.above.frame_b, root.spring.frame_a)
    return fw.Model(root, "heave at 1:45", {"heave": fw.Output("slide.s", "m")}, {"solver": "fixed", "step": 0.05})


TRUE = {"spring.stiffness": 854.4, "spring.damping": 12.0, "drag.coefficient": 350.0}


@pytest.fixture(scope="module")
def plant():
    return heaving().compile()


@pytest.fixture(scope="module")
def record(plant):
    """A decay from 50 mm with noise of 0.2 mm and a zero that is 3 mm off."""
    start = {"slide.s": 0.05}
    run = plant.simulate(60.0, output_step=0.1, solver="fixed", step=0.05, start=start, parameters=TRUE)
    noise = np.random.default_rng(3).normal(0.0, 2e-4, run.time.size)
    return {"heave": (run.time, np.asarray(run["heave"]) + 0.003 + noise)}


def test_stiffness_and_both_dampings_come_back(plant, record):
    found = calibrate(plant, record, list(TRUE), release="heave", step=0.05)
    assert found.gradients == "exact"
    for name, value in TRUE.items():
        assert found[name].value == pytest.approx(value, rel={"spring.stiffness": 1e-3}.get(name, 0.08)), name
        assert found[name].holds(value, 0.999), name
    assert found.constants["heave"] == pytest.approx(0.003, abs=5e-5)
    assert found.left["heave"] < 0.02 < found.left_before["heave"]
    assert abs(found.residuals["heave"].std() - 2e-4) < 3e-5
    low, high = found["spring.stiffness"].interval()
    assert high - low < 2.0
    again = plant.simulate(10.0, output_step=0.1, start={"slide.s": 0.05}, parameters=found.parameters)
    assert np.isfinite(np.asarray(again["heave"])).all()


def test_an_added_mass_is_fitted_as_well(plant, record):
    found = calibrate(plant, record, ["water.mass"], release="heave", step=0.05,
                      parameters=TRUE)  # fmt: skip
    assert found["water.mass"].value == pytest.approx(207.0, rel=2e-3)


def test_differences_give_the_same(plant, record, monkeypatch):
    from fowtlib.design import calibration

    def refused(*_, **__):
        raise ParameterError("nobody knows.")

    names = ["spring.stiffness", "spring.damping"]
    exact = calibrate(plant, record, names, release="heave", step=0.05)
    monkeypatch.setattr(calibration, "sensitivities", refused)
    found = calibrate(plant, record, names, release="heave", step=0.05)
    assert found.gradients == "differences: nobody knows."
    for name in names:
        assert found[name].value == pytest.approx(exact[name].value, abs=1e-2 * exact[name].error)
        assert found[name].error == pytest.approx(exact[name].error, rel=1e-2)


def test_what_was_found_until_it_is_stopped_is_told(plant, record, monkeypatch):
    """Stopped in its fifth simulation; another fit that begins with the values so far ends where the whole one does."""
    whole = calibrate(plant, record, list(TRUE), release="heave")
    asked, simulate = [], type(plant).simulate

    def stopped(self, *given, **options):
        asked.append(1)
        if len(asked) == 5:
            raise KeyboardInterrupt
        return simulate(self, *given, **options)

    monkeypatch.setattr(type(plant), "simulate", stopped)
    with pytest.raises(CalibrationStopped) as stop:
        calibrate(plant, record, list(TRUE), release="heave")
    assert set(stop.value.values) == set(TRUE) and stop.value.units["spring.stiffness"] == "N/m"
    assert stop.value.left < max(whole.left_before.values())
    again = calibrate(plant, record, list(TRUE), release="heave", parameters=stop.value.values)
    assert [float(one.value) for one in again.estimates] == pytest.approx(
        [float(one.value) for one in whole.estimates], rel=1e-4
    )


def test_a_picture_and_a_table(plant, record, tmp_path):
    found = calibrate(plant, record, ["spring.stiffness"], release="heave", step=0.05)
    found.plot(tmp_path / "fit.png")
    assert (tmp_path / "fit.png").stat().st_size > 10_000
    found.save(tmp_path / "fit.csv")
    assert (tmp_path / "fit.csv").read_text().startswith("parameter,before,value,from,to,unit\nspring.stiffness,850")
    assert "spring.stiffness" in repr(found) and "left of heave" in repr(found)


@pytest.mark.parametrize(
    ("fit", "message"),
    [
        (["spring.stiffness", "body.mass", "water.mass"], r"body.mass and water.mass cannot be told apart by"),
        (["spring.stiffness", "drag.idle"], r"drag.idle cannot be fitted: the record does not change with it."),
        (["spring.stifness"], r"no tunable parameter 'spring.stifness'; did you mean 'spring.stiffness'"),
    ],
)  # fmt: skip
def test_what_a_record_does_not_tell_is_refused(plant, record, fit, message):
    with pytest.raises(ModelError, match=message):
        calibrate(plant, record, fit, release="heave", step=0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda time, x: {"surge": (time, x)}, "no channel that is a result of the model; it has surge"),
        (lambda time, x: {"heave": (time, 0 * x)}, "heave does not change in the record"),
        (
            lambda time, x: {"heave": fw.analysis.series.Series(time, x, "kg", "heave")},
            "heave in kg, and the model in m",
        ),
    ],
)
def test_a_record_must_fit_the_model(plant, record, change, message):
    with pytest.raises(ModelError, match=message):
        calibrate(plant, change(*record["heave"]), ["spring.stiffness"], start={"slide.s": 0.05}, step=0.05)


def test_the_length_of_a_mooring_line_is_fitted():
    """A section of one of three lines at 1:45, 30 mm too long at first, by a decay in surge that begins as it began."""
    plant = fw.load("dtif_model_scale_flowave").compile()
    start = {"platform.motion.surge": 0.1}
    run = plant.simulate(40, 0.5, solver="fixed", step=0.05, start=plant.initial_state(start=start))
    record = {"surge": (run.time, np.asarray(run["surge"]))}
    long = {"line_1.lengths": [3.72, 1.63, 0.38]}
    found = calibrate(
        plant, record, ["line_1.lengths[0]"], start=start, step=0.05, constants=False, parameters=long,
    )  # fmt: skip
    assert found["line_1.lengths[0]"].value == pytest.approx(3.69, rel=1e-5)
    assert found.left["surge"] < 1e-4 < 0.05 < found.left_before["surge"]
