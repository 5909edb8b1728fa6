"""Ctrl-C during a simulation waits until the solver reports, and keeps what was computed."""

from __future__ import annotations

import signal

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Scalar, der, eq, var
from fowtlib.solving import run as runs
from fowtlib.solving.interrupts import deferred_interrupt
from fowtlib.solving.run import Interrupted

pytestmark = pytest.mark.usefixtures("python_handler")


def test_control_c_is_kept_until_it_is_asked_for():
    before = signal.getsignal(signal.SIGINT)
    with deferred_interrupt() as interrupted:
        signal.raise_signal(signal.SIGINT)  # as if inside compiled code: nothing happens yet
        assert interrupted.is_set()
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_control_c_acts_at_once():
    with pytest.raises(KeyboardInterrupt), deferred_interrupt():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        pytest.fail("still running")


def test_a_simulation_stops_at_the_next_report():
    class Decay(fw.Component):
        """x' = -x."""

        x: Scalar = var(start=1.0, doc="state")

        def equations(self):
            return [eq(der(self.x), -self.x)]

    def press(t: float, t_end: float) -> None:
        if t > 100:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(Interrupted) as stopped:
        fw.load(Decay()).compile().simulate(1000.0, output_step=0.1, progress=press)
    assert 100 < stopped.value.result.time[-1] < 1000


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_a_run_stopped_within_an_output_step_goes_on_exactly(monkeypatch, solver):
    class Swing(fw.Component):
        """x'' = -x."""

        x: Scalar = var(start=1.0, doc="state")
        v: Scalar = var(start=0.0, doc="rate")

        def equations(self):
            return [eq(der(self.x), self.v), eq(der(self.v), -self.x)]

    def press(t: float, t_end: float) -> None:
        if t > 21:
            signal.raise_signal(signal.SIGINT)

    plant = fw.load(Swing()).compile()
    monkeypatch.setattr(runs, "longest_stretch", lambda engine: 3.0)
    whole = plant.simulate(50.0, output_step=10.0, solver=solver)
    with pytest.raises(Interrupted) as stopped:
        plant.simulate(50.0, output_step=10.0, solver=solver, progress=press)
    first = stopped.value.result
    assert first.time[-1] == pytest.approx(25.0)  # asked for at 22.5 s, heard at the end of the next stretch
    both = first.followed_by(plant.simulate(50.0, output_step=10.0, solver=solver, start=first))
    assert np.array_equal(both.time, whole.time)
    assert np.array_equal(both.array("x"), whole.array("x"))
