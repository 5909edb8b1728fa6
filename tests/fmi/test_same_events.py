"""The event loop of the FMU core is that of the run in Python: the same numbers, the same instants, the same ends."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib import fmi
from fowtlib.fmi.c_tables import event_rules
from fowtlib.language import Scalar, assign, der, eq, param, reinit, sampled, var, when
from fowtlib.language.errors import SimulationError
from fowtlib.solving import event_rules as rules

CORE = (Path(fmi.__file__).parent / "fmu_core.c").read_text(encoding="utf-8")
STEP, OUTPUT = 0.01, 0.05


def test_every_rule_is_written_once():
    """The C text takes each of them by name, and those that decide about events have no number of their own."""
    used = set(re.findall(r"RULE_(\w+)", CORE))
    assert used == {name.removeprefix("RULE_") for name, _ in event_rules()}
    assert {name for name in vars(rules) if name.isupper()} == used
    events = CORE[CORE.index("/* --- events and samples") : CORE.index("/* The end of the communication step h")]
    numbers = set(re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])", re.sub(r'"[^"]*"|/\*.*?\*/', "", events)))
    own = {"200", "3", "2", "0.5"}  # of the search for a root, which ends at the same point by any way
    assert numbers <= own | {"0", "1", "0.0", "1.0"}


class Bounces(fw.Component):
    """A ball that loses half of its speed at each bounce: the bounces pile up in a finite time."""

    loss: Scalar = param(default=0.5, doc="what a bounce leaves of the speed")
    h: Scalar = var(unit="m", start=1.0, fixed=True, state="prefer", doc="height")
    v: Scalar = var(unit="m/s", fixed=True, state="prefer", doc="speed")
    n: Scalar = var(unit="1", discrete=True, doc="bounces")

    def equations(self):
        fall = when(self.h < 0, reinit(self.v, -self.loss * self.v), assign(self.n, self.n + 1))
        return [eq(der(self.h), self.v), eq(der(self.v), -9.81), fall]


class Cascade(fw.Component):
    """Two events at one instant, of which one sets off a third one; a sampled part changes what comes after."""

    x: Scalar = var(unit="1", fixed=True, state="prefer", doc="time that an event sets back")
    y: Scalar = var(unit="1", fixed=True, state="prefer", doc="what grows twice as fast")
    a: Scalar = var(unit="1", discrete=True, doc="how often x was set back")
    b: Scalar = var(unit="1", discrete=True, doc="how often y was set back")
    c: Scalar = var(unit="1", discrete=True, doc="rounds of the third event")
    s: Scalar = var(unit="1", discrete=True, doc="sampled x")

    def equations(self):
        return [
            eq(der(self.x), 1.0),
            eq(der(self.y), 2.0 + 0.1 * self.s),
            when(self.x > 0.71, reinit(self.x, 0.0), assign(self.a, self.a + 1)),
            when(self.y > 1.42, reinit(self.y, 0.1 * self.a), assign(self.b, self.b + 1)),
            when(self.a - self.c > 0.5, assign(self.c, self.c + 1)),
            sampled(0.31, assign(self.s, self.x)),
        ]


class Rising(fw.Component):
    """Indicators that are zero at the start: one that rises and falls again, one that falls at once, one that stays."""

    x: Scalar = var(unit="1", fixed=True, state="prefer", doc="sine")
    v: Scalar = var(unit="1/s", start=1.0, fixed=True, state="prefer", doc="cosine")
    up: Scalar = var(unit="1", discrete=True, doc="ends of the positive half wave")
    down: Scalar = var(unit="1", discrete=True, doc="ends of the negative half wave")
    level: Scalar = var(unit="1", discrete=True, doc="how often the top was passed")

    def equations(self):
        return [
            eq(der(self.x), 3 * self.v),
            eq(der(self.v), -3 * self.x),
            when(self.x < 0, assign(self.up, self.up + 1)),
            when(self.x > 0, assign(self.down, self.down + 1)),
            when(self.x > 0.999, assign(self.level, self.level + 1)),
        ]


class Endless(fw.Component):
    """An event whose action leads straight back to it."""

    x: Scalar = var(unit="1", start=0.37, fixed=True, state="prefer", doc="falls, and is lifted by nothing")

    def equations(self):
        return [eq(der(self.x), -1.0), when(self.x < 0, reinit(self.x, 1e-13))]


def model(*parts):
    root = fw.Assembly("events")
    outputs = {}
    for part in parts:
        name = type(part).__name__.lower()
        setattr(root, name, part)
        outputs |= {f"{name}_{key}": fw.Output(f"{name}.{key}")
                    for key, value in vars(type(part)).items() if hasattr(value, "discrete")}  # fmt: skip
    settings = {"solver": "fixed", "step": STEP, "output_step": OUTPUT, "tolerance": 1e-11}  # of iterations: no trace
    return fw.Model(root, "events", outputs, settings, name="events").compile()


@pytest.fixture(scope="module")
def pair_of(as_unit):
    """The plant of some parts and its FMU, which takes seconds to be compiled; made once."""

    @cache
    def make(*parts):
        plant = model(*(part() for part in parts))
        return plant, as_unit(plant, kind="cs")

    return make


@pytest.mark.parametrize(
    ("parts", "end", "least"),
    [((Bounces,), 1.25, {"bounces.n": 2}), ((Cascade, Rising), 3.0, {"cascade.a": 4, "cascade.b": 2, "cascade.c": 4,
                                                                     "rising.up": 1, "rising.down": 1,
                                                                     "rising.level": 2})],
)  # fmt: skip
def test_the_same_instants(parts, end, least, pair_of, instance_of):
    """All values behind each event, to the last digits: an event at another instant would shift all that follow."""
    plant, unit = pair_of(*parts)
    names = [output.path for output in plant.outputs.values()]
    run = plant.simulate(end, OUTPUT, outputs=names)
    python = np.column_stack([run.array(name) for name in names])[1:]
    rows = instance_of(unit).begin().run(names, len(python), OUTPUT)
    counts = [k for k, name in enumerate(names) if np.all(python[:, k] == np.round(python[:, k]))]
    happened = dict(zip(names, python[-1], strict=True))
    assert all(happened[name] >= count for name, count in least.items()), happened
    assert set(least) == {names[k] for k in counts}
    np.testing.assert_array_equal(rows[:, counts], python[:, counts])
    np.testing.assert_allclose(rows, python, rtol=0, atol=2e-11)


@pytest.mark.parametrize(("part", "end"), [(Bounces, 3.0), (Endless, 1.0)])
def test_the_same_end_without_an_end(part, end, pair_of, instance_of):
    """Events that come at once, again and again, are given up at the same one, in the same words."""
    plant, unit = pair_of(part)
    with pytest.raises(SimulationError) as refused:
        plant.simulate(end, OUTPUT)
    assert "returns at once, again and again" in str(refused.value)
    instance = instance_of(unit).begin()
    names = list(plant.outputs)
    with pytest.raises(Exception, match="failed|status"):
        instance.run(names, round(end / OUTPUT), OUTPUT)
    assert instance.said[-1][1] == str(refused.value)
