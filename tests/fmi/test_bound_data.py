"""What a model takes in when a run starts travels in an archive: series in its resources, numbers as constants."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import fowtlib as fw
from fowtlib.language import Scalar, Series, at_start, der, eq, param, run_time_series, var
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
