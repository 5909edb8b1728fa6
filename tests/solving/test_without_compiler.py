"""Without a C compiler: a run says at its start how long it will take and what helps, and it can be watched."""

from __future__ import annotations

import re
import time
import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import ExternalFunction, Scalar, der, eq, var
from fowtlib.solving import run as runs
from fowtlib.solving.engines import create_engine
from fowtlib.solving.pace import BY_AZIMUTH, BY_SECOND, BY_STEP, mean_announcement, seconds_per_second
from fowtlib.solving.starts import start_values

SOURCE = "int drag_of_test;"  # never compiled here
PAUSE = 0.002


class Slow(fw.Component):
    """A decay by a function whose Python twin takes its time."""

    x: Scalar = var(unit="1", start=1.0, state="prefer", doc="state")

    calls: list

    def equations(self):
        def loss(x):
            self.calls.append(("value", float(x[0])))
            time.sleep(PAUSE)
            return -x

        def slope(x):
            self.calls.append(("slope", float(x[0])))
            return [[-1.0]]

        function = ExternalFunction("loss", {"x": 1}, {"rate": 1}, source=SOURCE, python=loss, jacobian=slope)
        return [eq(der(self.x), function(x=self.x)["rate"])]


@pytest.fixture
def slow(monkeypatch):
    monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    Slow.calls = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return fw.load(Slow()).compile()


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_what_a_run_will_take_is_said_at_its_start(slow, solver, monkeypatch):
    told: list[str] = []
    monkeypatch.setattr(warnings, "warn", lambda text, *_, **__: told.append(f"{text} ({len(Slow.calls)})"))
    monkeypatch.setattr(runs, "TOLD", 0.0)
    slow.simulate(0.4, 0.02, solver=solver)
    (line,) = [line for line in told if "expected" in line]
    found = re.search(r"expected to take (\d+) s to (\d+) (s|min) on this computer: FOWTLIB_CC .*\((\d+)\)$", line)
    assert "with the model" in line
    assert "as Python code" in line
    assert "fowtlib[compiler]" in line
    if solver == "fixed":
        assert "the solver 'fixed'" in line
    assert int(found[4]) < 10  # said before the work
    assert len(Slow.calls) > 30


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_the_pace_is_measured(slow, solver):
    engine = create_engine(slow.at(), lambda: None, solver, 1e-6, 0.1, {}, {"step": 0.02} if solver == "fixed" else {})
    low, high = seconds_per_second(engine, 0.0, np.array([1.0]), np.zeros(0), np.zeros(0))
    few, many = BY_SECOND if solver == "idas" else np.array(BY_STEP) / 0.02
    assert low > few[0] * PAUSE
    assert many[0] * PAUSE < high < 30 * many[0] * PAUSE
    assert high / low > 3


def test_what_the_mean_of_turning_rotors_takes_is_said_before_it_is_sought(slow):
    point = (0.0, np.array([1.0]), np.zeros(0), np.zeros(0))
    for azimuths in (5, 5000):
        line = mean_announcement(slow.at(), point, azimuths)
        assert "mean state of the turning rotors is expected" in line
        number, unit = re.search(r"to take (\S+) (s|min|h) here: FOWTLIB_CC names", line).groups()
        least = azimuths * sum(BY_AZIMUTH) * PAUSE
        assert 0.9 * least < float(number) * {"s": 1, "min": 60, "h": 3600}[unit] < 10 * least


def test_a_model_that_starts_from_the_mean_starts_from_its_file(slow):
    model = fw.Model(Slow(), "slow", {}, {"start": "turning"}, name="slow")
    with pytest.warns(UserWarning, match="takes long: FOWTLIB_CC .* So the run starts from the values of the model"):
        assert start_values(model.compile(), "") == (None, "")


def test_a_short_run_says_nothing(slow):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        slow.simulate(0.2, 0.1)


def test_a_slow_run_is_looked_at_often(slow, monkeypatch):
    monkeypatch.setattr(runs, "SLOW_STRETCH", 10)  # points, not seconds of the clock, which results must not depend on
    seen: list[float] = []
    slow.simulate(2.0, 0.02, progress=lambda t, end: seen.append(t))
    assert len(seen) > 6
    assert np.diff(seen).max() < 0.25
    monkeypatch.setattr(runs, "SLOW_STRETCH", 1000)
    whole: list[float] = []
    slow.simulate(2.0, 0.02, progress=lambda t, end: whole.append(t))
    assert len(whole) == 2


def test_the_twin_is_called_once_for_a_point(slow):
    at = slow.at()
    Slow.calls.clear()
    for _ in range(3):
        at.residual(0.0, [0.5], [], [])
        at.jacobian(0.0, [0.5], [], [])
    assert Slow.calls == [("value", 0.5), ("slope", 0.5)]
    at.residual(0.0, [0.6], [], [])
    at.residual(0.0, [0.5], [], [])
    assert Slow.calls[2:] == [("value", 0.6), ("value", 0.5)]
    slow.initial_state()["der(x)"]  # a calculation begins: data behind a handle may be others by now
    assert Slow.calls[-1] == ("value", 1.0)
    count = len(Slow.calls)
    slow.initial_state()["der(x)"]
    assert len(Slow.calls) > count


def test_a_value_that_was_refused_is_not_kept(monkeypatch):
    monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    answers = iter([RuntimeError("not yet"), [2.0]])

    def compute(x):
        answer = next(answers)
        if isinstance(answer, Exception):
            raise answer
        return answer

    function = ExternalFunction("waits", {"x": 1}, {"y": 1}, python=compute).function
    with pytest.raises(RuntimeError):
        function(1.0)
    assert float(function(1.0)) == 2.0
    assert float(function(1.0)) == 2.0
