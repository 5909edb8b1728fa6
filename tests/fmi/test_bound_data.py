"""What a model takes in when a run starts travels in an archive: series in its resources, numbers as constants."""


import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import fowtlib as fw
from fowtlib.fmi.guards import guarded
from fowtlib.language import Scalar, Series, at_start, der, eq, param, part, run_time_series, var
from fowtlib.language.errors import ModelError


class Shaken(fw.Component):
    """A mass that is shaken by samples, and pushed once."""

    size: Scalar = param(default=1.0, unit="m/s^2", doc="size of the samples")
    damping: Scalar = param(default=0.3, unit="1/s", doc="damping")
    seed: int = param(default=1, bound=True, doc="number of the realisation")
    begin: float = param(default=1.03, unit="s", bound=True, doc="begin of the push")
    v: Scalar = var(unit="m/s", start=0.2, fixed=True, state="prefer", doc="speed")

    def equations(self):
        shaking = run_time_series(self.time, 1, "shaking", Shaken.samples)
        push = run_time_series(self.time, 1, "push", Shaken.push)
        drift = at_start("drift", 1, "m/s^2", "drift", lambda it: 0.01 * it.seed)
        return [eq(der(self.v), shaking + push + drift - self.damping * self.v)]

    def samples(self):
        values = np.random.default_rng(self.seed).normal(size=(3000, 1))
        return Series.samples(self.parameter_value("size") * values, 0.2, periodic=True)

    def push(self):
        return Series.transition(self.begin, 0.04, [0.0], [0.0], harmonics=[(0.0, 50.0), (2 * np.pi, -50.0)])


@pytest.fixture(scope="module")
def shaken():
    root = fw.Assembly("shaken")
    root.mass = Shaken()
    return fw.Model(root, "shaken", {"speed": fw.Output("mass.v")}, {"output_step": 0.05}, name="shaken").compile()


@pytest.mark.parametrize("version", ["2", "3"])
def test_an_archive_holds_the_data_of_a_run(shaken, as_unit, version):
    given = {"mass.seed": 5, "mass.begin": 0.52}
    unit = as_unit(shaken, version, parameters=given, step=0.005)
    runs = {
        "cs": shaken.simulate(3.0, parameters=given, solver="fixed", step=0.005),
        "me": shaken.simulate(3.0, parameters=given, tolerance=1e-8),
    }
    assert runs["me"]["speed"][-1] != pytest.approx(float(shaken.simulate(3.0)["speed"][-1]), rel=0.1)
    for kind, error in (("cs", 1e-9), ("me", 2e-5)):
        options = {"relative_tolerance": 1e-8} if kind == "me" else {}
        rows = unit.simulate(kind, 3.0, 0.05, ["speed"], **options)
        np.testing.assert_allclose(rows["speed"], runs[kind]["speed"], rtol=0, atol=error)


def test_a_parameter_that_data_were_computed_from_is_guarded(shaken, as_unit, instance_of):
    unit = as_unit(shaken)
    instance_of(unit).begin(mass__damping=0.6).step(0.0, 0.05)
    changed = instance_of(unit)
    with pytest.raises(FMICallException):
        changed.begin(mass__size=2.0)
    words = "mass.size is 2 m/s^2, and this FMU holds data that were computed for 1 m/s^2 (mass.shaking handle)"
    assert any(words in text for _, text in changed.said), changed.said


def test_a_run_in_python_follows_the_parameter(shaken):
    speeds = [float(shaken.simulate(0.9, parameters={"mass.size": k})["speed"][-1]) for k in (0.0, 1.0, 2.0)]
    assert speeds[2] - speeds[1] == pytest.approx(speeds[1] - speeds[0], rel=1e-4)
    with pytest.raises(ModelError, match="mass.size"):
        shaken.simulate(1, parameters={"mass.sise": 1})


class Store(fw.Component):
    """A tank that empties."""

    time_constant: Scalar = param(unit="s", min=0.1, max=1e3, doc="time constant")
    share: Scalar = param(min=0, max=1, doc="share of the flow")
    leak: Scalar = param(default=0.5, min=0, doc="leak")
    level: Scalar = var(unit="m", start=1.0, fixed=True, state="prefer", doc="level")

    def equations(self):
        return [eq(self.time_constant * der(self.level), -(self.share + self.leak) * self.level)]


class Tank(fw.Component):
    """Parameters of the part follow from those of the whole."""

    rate: Scalar = param(default=2.0, unit="Hz", doc="rate")
    open_part: Scalar = param(default=0.4, doc="open part")
    leak: Scalar = param(default=0.2, min=0, doc="leak")
    store: Store = part(Store, time_constant=1 / rate, share=1 - open_part, leak=leak)


@pytest.fixture(scope="module")
def tank():
    root = fw.Assembly("tank")
    root.tank = Tank()
    outputs = {"level": fw.Output("tank.store.level")}
    return fw.Model(root, "tank", outputs, {"output_step": 0.05}, name="tank").compile()


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("tank.rate", 20.0, "tank.store.time_constant = 0.05 s is below its minimum 0.1 s (time constant)"),
        ("tank.rate", 5e-4, "tank.store.time_constant = 2000 s is above its maximum 1000 s (time constant)"),
        ("tank.rate", 0.0, "tank.store.time_constant = inf s is no finite number (time constant)"),
        ("tank.open_part", 1.25, "tank.store.share = -0.25 is below its minimum 0 (share of the flow)"),
        ("tank.open_part", -1.0, "tank.store.share = 2 is above its maximum 1 (share of the flow)"),
    ],
)
def test_what_follows_from_a_parameter_keeps_its_bounds(tank, as_unit, instance_of, version, name, value, message):
    """In an archive as in a run with the same values; what it was exported with, and others within bounds, run."""
    unit = as_unit(tank, version)
    message += "; it follows from the values that were given."
    with pytest.raises(ModelError) as refused:
        tank.simulate(0.1, parameters={name: value})
    assert str(refused.value) == message
    wrong = instance_of(unit)
    with pytest.raises(FMICallException):
        wrong.begin(**{name.replace(".", "__"): value})
    assert any(message.rstrip(".") in text for _, text in wrong.said), wrong.said
    instance_of(unit).begin(tank__rate=4.0).step(0.0, 0.05)


def test_bounds_that_a_given_value_ensures_are_not_checked_twice(tank):
    checks = guarded(tank, tank.binding({}), 0.0125).dae.checks
    told = [check.message.split(" = ")[0] for check in checks]
    assert told == ["tank.store.time_constant"] * 3 + ["tank.store.share"] * 3
