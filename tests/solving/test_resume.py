"""A run that is interrupted and resumed is the run without the interruption."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import ModelError, Scalar, assign, der, eq, param, sampled, var
from fowtlib.solving.run import Interrupted


class Counter(fw.Component):
    """A decaying state with a sampled counter that drives it."""

    period: float = param(default=0.25, unit="s", doc="sampling period")

    x: Scalar = var(start=1.0, state="prefer", doc="state")
    count: Scalar = var(discrete=True, doc="samples so far")

    def equations(self):
        return [eq(der(self.x), self.count - self.x), sampled(self.period, assign(self.count, self.count + 1))]


@pytest.mark.parametrize("middle", [1.0, 1.1])
def test_resumed_run_equals_the_whole_run(tmp_path, middle):
    plant = fw.load(Counter()).compile()
    whole = plant.simulate(2.0, output_step=0.05, tolerance=1e-9, outputs=["x", "count"])
    first = plant.simulate(middle, output_step=0.05, tolerance=1e-9, outputs=["x", "count"])
    first.save(tmp_path / "first.nc")
    second = plant.simulate(
        2.0, output_step=0.05, tolerance=1e-9, outputs=["x", "count"], start=fw.Result.open(tmp_path / "first.nc")
    )
    joined = first.followed_by(second)
    assert np.allclose(joined.time, whole.time)
    assert np.array_equal(joined.array("count"), whole.array("count"))
    assert np.max(np.abs(joined.array("x") - whole.array("x"))) < 1e-7


def test_times_may_have_units_and_a_tolerance_is_small():
    plant = fw.load(Counter()).compile()
    assert plant.simulate("0.02 min", output_step="100 ms").time[-1] == 1.2
    with pytest.raises(ModelError, match="duration: got '5 m', which is a length"):
        plant.simulate("5 m")
    with pytest.raises(ModelError, match="the tolerance is 0; it must lie between 0 and 1, usually 1e-4 to 1e-9."):
        plant.simulate(1.0, tolerance=0)


def test_ctrl_c_keeps_what_was_computed():
    plant = fw.load(Counter()).compile()

    def interrupt(t: float, t_end: float) -> None:
        if t > 1.0:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as stopped:
        plant.simulate(5.0, output_step=0.05, progress=interrupt)
    result = stopped.value.result
    assert 1.0 < result.time[-1] < 5.0
    later = plant.simulate(5.0, output_step=0.05, start=result)
    whole = plant.simulate(5.0, output_step=0.05)
    assert later.array("x")[-1] == pytest.approx(whole.array("x")[-1], abs=1e-5)


def test_a_resumed_run_needs_the_same_parameters():
    class Rate(fw.Component):
        """x' = rate."""

        rate: Scalar = param(default=1.0, doc="rate")
        x: Scalar = var(doc="state")

        def equations(self):
            return [eq(der(self.x), self.rate)]

    plant = fw.load(Rate()).compile()
    first = plant.simulate(1.0)
    with pytest.raises(ModelError, match="the run to resume had other parameters: rate was 1.0, is 2.0"):
        plant.simulate(2.0, start=first, parameters={"rate": 2.0})


def test_a_resumed_run_needs_the_same_structure(tmp_path):
    class Powers(fw.Component):
        """x' = x**power."""

        power: int = param(default=1, doc="exponent")
        table: str = param(default="/here/table.csv", doc="a file")
        x: Scalar = var(start=1.0, doc="state")

        def equations(self):
            return [eq(der(self.x), self.x**self.power)]

    first = fw.load(Powers()).compile().simulate(1.0)
    first.save(tmp_path / "first.nc")
    saved = fw.Result.open(tmp_path / "first.nc")
    with pytest.raises(ModelError, match="the run to resume had other parameters: power was 1, is 2. Give the same"):
        fw.load(Powers(power=2)).compile().simulate(2.0, start=saved)
    elsewhere = fw.load(Powers(table="/there/table.csv")).compile()
    assert elsewhere.simulate(2.0, start=saved).time[-1] == 2.0
