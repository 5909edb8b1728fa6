"""Sampled parts that call something with a memory of its own, and ports that only one instance has."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Component, RealInput, RealOutput, Scalar, assign, call, der, eq, param, port, sampled, var
from fowtlib.language.errors import ParameterError, SimulationError, StructureError

PERIOD, GAIN, STIFFNESS = 0.1, 0.3, 4.0


class Integrating:
    """A process: the sum of its input, times the gain; it may fail at a time."""

    def __init__(self, fails_at: float = np.inf, gives: object = None):
        self.fails_at, self.gives = fails_at, gives
        self.runs: list[Run] = []

    def start(self) -> Run:
        self.runs.append(Run(self))
        return self.runs[-1]


class Run:
    def __init__(self, process: Integrating):
        self.process, self.sum, self.times, self.closed = process, 0.0, [], 0

    def step(self, t: float, inputs: np.ndarray) -> object:
        if t >= self.process.fails_at - 1e-9:
            raise KeyError("gone") if self.process.gives is None else SimulationError("there is no power.")
        self.times.append(t)
        self.sum += GAIN * inputs[0]
        return [self.sum, t] if self.process.gives is None else self.process.gives

    def close(self) -> None:
        self.closed += 1


class Outside(Component):
    """Calls a process; its ports are declared by the instance."""

    process: object = param()
    period: float = param(default=PERIOD, unit="s")
    signals: int = param(default=1)

    def build(self):
        self.declare("speed", RealInput, port(unit="m/s"))
        self.declare("force", RealOutput, port(unit="N"))
        for k in range(self.signals - 1):
            self.declare(f"more_{k}", RealInput, port(default=0.0))
        self.declare("held", Scalar, var(unit="N", discrete=True, start=0.5))
        self.declare("called", Scalar, var(unit="s", discrete=True, start=0.0))

    def equations(self):
        update = call([self.held, self.called], self.process, [self.speed, self.called])
        return [sampled(self.period, update), eq(self.force, self.held)]


class Mass(Component):
    """A mass on a spring, braked by a force."""

    f: RealInput = port(unit="N")
    v: RealOutput = port(unit="m/s")
    x: Scalar = var(unit="m", start=1.0)
    m: Scalar = param(default=1.0, unit="kg")
    k: Scalar = param(default=STIFFNESS, unit="N/m")

    def equations(self):
        return [eq(der(self.x), self.v), eq(self.m * der(self.v), -self.k * self.x - self.f)]


def braked(process, **values) -> fw.Assembly:
    model = fw.Assembly("braked")
    model.outside, model.mass = Outside(process=process, **values), Mass()
    model.connect(model.outside.force, model.mass.f)
    model.connect(model.mass.v, model.outside.speed)
    return model


def exact(steps: int) -> np.ndarray:
    """X and v at the samples: between them the force is constant and the motion a harmonic one."""
    w, x, v, total, rows = np.sqrt(STIFFNESS), 1.0, 0.0, 0.0, []
    c, s = np.cos(w * PERIOD), np.sin(w * PERIOD)
    for _ in range(steps + 1):
        rows.append((x, v))
        total += GAIN * v
        rest = -total / STIFFNESS
        x, v = rest + (x - rest) * c + v / w * s, v * c - w * (x - rest) * s
    return np.array(rows)


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_a_process_is_called_once_in_a_sample_and_acts_at_once(solver):
    process = Integrating()
    plant = fw.load(braked(process)).compile()
    options = {"step": 0.0005} if solver == "fixed" else {}
    result = plant.simulate(2.0, PERIOD / 2, solver=solver, tolerance=1e-10, outputs=["mass.x", "mass.v"], **options)
    (run,) = process.runs
    np.testing.assert_allclose(run.times, PERIOD * np.arange(21), atol=1e-12)
    assert run.closed == 1
    computed = np.column_stack([result["mass.x"].values[::2], result["mass.v"].values[::2]])
    np.testing.assert_allclose(computed, exact(20), atol=1e-7 if solver == "idas" else 1e-6)


def test_every_run_has_its_own_memory():
    process = Integrating()
    plant = fw.load(braked(process)).compile()
    runs = [plant.simulate(1.0, 0.1, outputs=["outside.force"])["outside.force"].values for _ in range(2)]
    np.testing.assert_array_equal(*runs)
    assert [run.closed for run in process.runs] == [1, 1]


def test_an_offset_and_a_start_in_between():
    process = Integrating()
    model = braked(process)
    plant = fw.load(model).compile()
    plant.simulate(1.0, 0.1, start=plant.initial_state(t=0.45))
    np.testing.assert_allclose(process.runs[0].times, PERIOD * np.arange(5, 11), atol=1e-12)


FAILURES = [
    (Integrating(0.5), "outside: KeyError: 'gone' (t = 0.5 s)."),
    (Integrating(0.5, [0, 0]), "outside: there is no power (t = 0.5 s)."),
]


@pytest.mark.parametrize(("process", "text"), FAILURES)
def test_a_failure_keeps_the_results_and_frees_the_process(process, text):
    plant = fw.load(braked(process)).compile()
    with pytest.raises(SimulationError) as caught:
        plant.simulate(1.0, 0.1, outputs=["mass.x"])
    assert str(caught.value) == text
    assert caught.value.result["mass.x"].sizes["time"] == 6  # 0 to 0.5 s
    assert process.runs[-1].closed == 1


def test_outputs_that_cannot_be():
    with pytest.raises(SimulationError, match=r"outside\.held is inf: the process behind it has failed \(t = 0 s\)\."):
        fw.load(braked(Integrating(gives=[np.inf, 0]))).compile().simulate(1.0, 0.1)
    with pytest.raises(SimulationError, match=r"outside: gives 1 outputs instead of 2\."):
        fw.load(braked(Integrating(gives=[1]))).compile().simulate(1.0, 0.1)


def test_closing_that_fails_does_not_cost_the_results():
    class Bad(Run):
        def close(self):
            raise OSError("it hangs")

    process = Integrating()
    process.start = lambda: Bad(process)
    plant = fw.load(braked(process)).compile()
    with pytest.warns(UserWarning, match="outside: closing it fails: it hangs"):
        result = plant.simulate(0.2, 0.1, outputs=["mass.x"])
    assert result["mass.x"].sizes["time"] == 3


def test_a_call_stands_alone():
    class Mixed(Component):
        d: Scalar = var(discrete=True, start=0.0)

        def equations(self):
            return [sampled(0.1, assign(self.d, 1), call(self.d, Integrating(), self.d))]

    model = fw.Assembly("mixed")
    model.mixed = Mixed()
    with pytest.raises(StructureError, match="a sampled\\(\\) with a call\\(\\) has nothing else in it"):
        fw.load(model).compile()


def test_a_target_that_is_no_discrete():
    class Wrong(Component):
        x: Scalar = var(start=0.0)

        def equations(self):
            return [sampled(0.1, call(self.x, Integrating(), self.x)), eq(der(self.x), 1)]

    model = fw.Assembly("wrong")
    model.wrong = Wrong()
    with pytest.raises(StructureError, match=r"wrong: assign\(\) cannot set wrong\.x; declare it with var\(discrete"):
        fw.load(model).compile()


# --- declarations of one instance ------------------------------------------------------------------------------------


def test_declared_ports_belong_to_the_instance_and_follow_its_parameters():
    one, three = Outside(process=Integrating()), Outside(process=Integrating(), signals=3)
    assert list(one.ports) == ["speed", "force"]
    assert list(three.ports) == ["speed", "force", "more_0", "more_1"]
    assert Outside.ports == {}
    one.signals = 2
    assert list(one.ports) == ["speed", "force", "more_0"]
    assert one.more_0.path == "more_0"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("process", "Declaring.process is declared already and cannot be a port or variable."),
        ("connect", "a port or variable cannot be called 'connect', which every component has already."),
        ("1st", "'1st' is not a name; use letters, digits and underscores."),
    ],
)
def test_names_that_are_taken(name, text):
    class Declaring(Component):
        process: object = param(default=None)

        def build(self):
            self.declare(name, RealInput, port())

    with pytest.raises(ParameterError) as caught:
        Declaring()
    assert text in str(caught.value)
