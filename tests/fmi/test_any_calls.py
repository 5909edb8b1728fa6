"""Any sequence of calls with any values, through fmpy: an answer or an error with a sentence, never a crash.

hostile.c does the same in C, with pointers and saved states; hypothesis looks for the shortest sequence that fails.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

ODD = st.sampled_from([0.0, -1.0, 0.05, 0.3, 1e-12, 5e-324, 1e17, 1e300, -1e300, math.nan, math.inf, -math.inf])
NUMBERS = st.one_of(st.integers(0, 30), st.sampled_from([10_000, 2**31, 2**32 - 1]))
CALLS = st.one_of(
    st.tuples(st.just("get"), st.lists(NUMBERS, max_size=4)),
    st.tuples(st.just("set"), NUMBERS, ODD),
    st.tuples(st.just("step"), ODD, ODD),
    st.tuples(st.just("go"), st.sampled_from([0.05, 0.013, 0.3])),
    st.tuples(st.just("slope"), NUMBERS, NUMBERS, ODD),
    st.tuples(st.just("begin"), ODD),
    st.tuples(st.sampled_from(["end", "reset", "terminate", "save", "load", "events", "update", "continue"])),
    st.tuples(st.just("put"), ODD, st.lists(ODD, min_size=4, max_size=4)),
)
NAMES = ["height", "place", "loop", "command", "bounces"]


def call(one, kept, name, *values):
    """One call; what it answers does not matter."""
    fmu, three = one.fmu, one.three
    if name == "get":
        (fmu.getFloat64 if three else fmu.getReal)(values[0])
    elif name == "set":
        (fmu.setFloat64 if three else fmu.setReal)([values[0]], [values[1]])
    elif name == "step":
        one.step(*values)
    elif name == "go":
        one.step(one.get("time")[0], values[0])
    elif name == "slope":
        fmu.getDirectionalDerivative([values[0]], [values[1]], [values[2]])
    elif name == "begin":
        one.begin(values[0])
    elif name == "put":
        one.put(*values)
    elif name == "save":
        kept.append(one.save())
    elif name == "load" and kept:
        one.load(kept[-1])
    elif name in ("end", "reset", "terminate"):
        {"end": fmu.exitInitializationMode, "reset": fmu.reset, "terminate": fmu.terminate}[name]()
    elif name == "events":
        fmu.enterEventMode()
    elif name == "update":
        one.update()
    elif name == "continue":
        fmu.enterContinuousTimeMode()


@pytest.fixture
def runs(instance):
    """An instance of each kind, and the trajectory of co-simulation of a new one."""
    return {kind: instance(kind) for kind in ("cs", "me")}, instance().begin().run(NAMES, 10, 0.05)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(kind=st.sampled_from(["cs", "me"]), calls=st.lists(CALLS, max_size=12))
def test_any_calls_end_in_a_status_and_a_reset_forgets_them(runs, kind, calls):
    instances, reference = runs
    one, kept = instances[kind], []
    for each in calls:
        try:
            call(one, kept, *each)
        except FMICallException as error:
            assert error.status in (2, 3)  # discard or error, never fatal
        except AttributeError as error:
            assert error.obj is one.fmu  # fmpy offers the calls of a kind only
    for state in kept:
        one.forget(state)
    one.fmu.reset()
    one.begin()
    if kind == "cs":
        assert np.array_equal(one.run(NAMES, 10, 0.05), reference)
    else:
        assert np.all(np.isfinite(one.array("Derivatives")))
