"""FMUs of the tests: a small machine that has everything, and instances that look the same in both versions."""

from __future__ import annotations

import ctypes as c
import importlib.util
import shutil
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import (
    RealInput,
    Scalar,
    assert_,
    assign,
    der,
    eq,
    initial,
    param,
    port,
    reinit,
    sampled,
    table1d,
    var,
    when,
)
from fowtlib.language import math as m
from fowtlib.language.native import compiler

NEEDS_FMPY = [
    "test_bound_data.py", "test_fmu.py", "test_same_events.py", "test_platforms.py", "test_any_calls.py",
    "test_recipes.py", "test_hull_surface.py", "test_cut_in_archive.py",
]  # fmt: skip
collect_ignore = [] if importlib.util.find_spec("fmpy") and compiler() else NEEDS_FMPY


class Machine(fw.Component):
    """A ball that bounces, and a sampled controller that moves a cart through a loop and a table."""

    gravity: Scalar = param(default=9.81, unit="m/s^2", min=0, max=30, doc="gravity")
    gain: Scalar = param(default=2.0, unit="1/s", doc="gain of the controller")
    height_start: Scalar = param(default=1.0, unit="m", doc="height of the ball at the start")
    period: Scalar = param(default=0.07, unit="s", doc="time between two samples of the controller")
    limit: Scalar = param(default=50.0, unit="m/s", doc="highest speed of the ball")

    push: RealInput = port(unit="m/s", default=0.1, doc="wind on the cart")

    height: Scalar = var(unit="m", start=height_start, fixed=True, state="prefer", doc="height of the ball")
    speed: Scalar = var(unit="m/s", fixed=True, state="prefer", doc="speed of the ball")
    place: Scalar = var(unit="m", start=0.5, fixed=True, state="prefer", doc="place of the cart")
    lag: Scalar = var(unit="m", state="prefer", doc="place of the cart, behind a filter")
    loop: Scalar = var(unit="m/s", doc="solves loop + loop^3 = push - place")
    command: Scalar = var(unit="m/s", discrete=True, doc="what the controller asks for")
    bounces: Scalar = var(unit="1", discrete=True, doc="how often the ball was on the ground")

    def equations(self):
        grid = np.linspace(-4.0, 4.0, 41)
        drag = table1d(self.place, grid, 0.3 * np.sin(grid), name="drag")
        return [
            eq(der(self.height), self.speed), eq(der(self.speed), -self.gravity * 1.0),
            eq(self.loop + self.loop**3, self.push - self.place * 1.0),
            eq(der(self.place), self.command + 0.2 * self.loop - drag),
            eq(der(self.lag), self.place - self.lag), initial(self.lag, self.place + 0.25 * self.loop),
            when(self.height < 0, reinit(self.speed, -0.8 * self.speed), assign(self.bounces, self.bounces + 1)),
            sampled(self.period, assign(self.command, -self.gain * self.place + 0.1 * m.sin(self.time))),
            assert_(self.place < 0.6, "the cart is beyond 0.6 m, 50% more than it should be", level="warning"),
            assert_(self.speed < self.limit, "the ball is too fast."),
        ]  # fmt: skip


def machine() -> fw.Model:
    """The model, with results in other units than SI."""
    root = fw.Assembly("machine")
    root.machine = Machine()
    outputs = {
        "height": fw.Output("machine.height"), "place": fw.Output("machine.place", "mm", "of the cart"),
        "loop": fw.Output("machine.loop"), "command": fw.Output("machine.command"),
        "bounces": fw.Output("machine.bounces"), "machine.speed": fw.Output("machine.speed"),
    }  # fmt: skip
    return fw.Model(root, "a machine", outputs, {"solver": "fixed", "step": 0.01, "output_step": 0.05}, name="machine")


@dataclass
class Unit:
    """An exported FMU."""

    path: Path
    version: str
    folder: str = ""
    described: object = None

    def __post_init__(self):
        import fmpy

        self.folder = str(fmpy.extract(str(self.path)))
        self.described = fmpy.read_model_description(self.folder)
        self.reference = {v.name: v.valueReference for v in self.described.modelVariables}

    def close(self):
        shutil.rmtree(self.folder)

    def simulate(self, kind, t_end, interval, outputs, **options):
        import fmpy

        name = {"cs": "CoSimulation", "me": "ModelExchange"}[kind]
        extra = {"record_events": False} if kind == "me" else {}
        return fmpy.simulate_fmu(
            self.folder, model_description=self.described, fmi_type=name, stop_time=t_end, output_interval=interval,
            output=outputs, **extra, **options,
        )  # fmt: skip


@dataclass
class Instance:
    """One instance; `said` are the messages it has sent, with their status."""

    unit: Unit
    kind: str = "cs"
    options: dict = field(default_factory=dict)
    said: list[tuple[int, str]] = field(default_factory=list)

    def __post_init__(self):
        from fmpy.simulation import instantiate_fmu

        name = {"cs": "CoSimulation", "me": "ModelExchange"}[self.kind]

        def hear3(environment, status, category, message):
            self.said.append((status, message.decode()))

        def hear2(environment, instance, status, category, message, *_):
            self.said.append((status, message.decode()))

        self.three = self.unit.version == "3"
        logger = hear3 if self.three else hear2
        self.fmu = instantiate_fmu(self.unit.folder, self.unit.described, name, logger=logger, **self.options)
        self.size = self.unit.described.numberOfContinuousStates

    def numbers(self, names):
        return [self.unit.reference[name] for name in names]

    def get(self, *names):
        get = self.fmu.getFloat64 if self.three else self.fmu.getReal
        return np.array(get(self.numbers(names)))

    def set(self, **values):
        put = self.fmu.setFloat64 if self.three else self.fmu.setReal
        names = [name.replace("__", ".") for name in values]
        put(self.numbers(names), list(values.values()))

    def begin(self, t=0.0, **values):
        if not self.three:
            self.fmu.setupExperiment(startTime=t)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=t)
        self.set(**values)
        self.fmu.exitInitializationMode()
        if self.kind == "me":
            self.update()
            self.fmu.enterContinuousTimeMode()
        return self

    def update(self):
        return self.fmu.updateDiscreteStates() if self.three else self.fmu.newDiscreteStates()

    def step(self, t, h):
        return self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def run(self, names, steps, h, first=0):
        """Rows of values after each of `steps` communication steps, the first at first * h."""
        rows = []
        for k in range(first, first + steps):
            self.step(k * h, h)
            rows.append(self.get(*names))
        return np.array(rows)

    def save(self):
        return self.fmu.getFMUState() if self.three else self.fmu.getFMUstate()

    def load(self, state):
        (self.fmu.setFMUState if self.three else self.fmu.setFMUstate)(state)

    def forget(self, state):
        (self.fmu.freeFMUState if self.three else self.fmu.freeFMUstate)(state)

    def bytes_of(self, state):
        return self.fmu.serializeFMUState(state) if self.three else self.fmu.serializeFMUstate(state)

    def of_bytes(self, data):
        return self.fmu.deserializeFMUState(data) if self.three else self.fmu.deSerializeFMUstate(data)

    def array(self, name):
        """Continuous states, their derivatives, or the event indicators."""
        count = self.unit.described.numberOfEventIndicators if name == "EventIndicators" else self.size
        values = np.zeros(count)
        if name == "Derivatives" and self.three:
            name = "ContinuousStateDerivatives"
        getattr(self.fmu, f"get{name}")(values.ctypes.data_as(c.POINTER(c.c_double)), count)
        return values

    def put(self, t, x):
        self.fmu.setTime(t)
        x = np.array(x, dtype=float)
        self.fmu.setContinuousStates(x.ctypes.data_as(c.POINTER(c.c_double)), len(x))

    def slope(self, unknown, known, seed):
        names = (self.numbers(unknown), self.numbers(known), list(seed))
        return np.array(self.fmu.getDirectionalDerivative(*names))

    def close(self):
        self.fmu.freeInstance()


@pytest.fixture(scope="session")
def plant():
    """The machine, compiled."""
    return machine().compile()


@pytest.fixture(scope="session", params=["2", "3"])
def unit(request, plant, tmp_path_factory):
    """The machine as an FMU of FMI 2.0 and of FMI 3.0."""
    path = tmp_path_factory.mktemp("fmu") / f"machine_{request.param}.fmu"
    made = Unit(fw.export_fmu(plant, path, fmi=request.param), request.param)
    yield made
    made.close()


@pytest.fixture
def instance_of():
    """Makes instances, and frees them."""
    made = []

    def make(unit, kind="cs", **options):
        made.append(Instance(unit, kind, options))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def instance(unit, instance_of):
    """Makes instances of the machine."""
    return lambda kind="cs", **options: instance_of(unit, kind, **options)


@pytest.fixture(scope="session")
def spar_unit(spar, as_unit):
    """The rigid spar as an FMU."""
    return as_unit(spar)


@pytest.fixture(scope="session")
def spar():
    """The rigid spar, compiled."""
    return fw.load("oc3_spar_rigid").compile()


@pytest.fixture(scope="session")
def as_unit(tmp_path_factory):
    """Exports a plant and unpacks the archive."""
    made = []

    def make(plant, version="3", **options):
        path = tmp_path_factory.mktemp("fmu") / "model.fmu"
        made.append(Unit(fw.export_fmu(plant, path, fmi=version, **options), version))
        return made[-1]

    yield make
    for each in made:
        each.close()
