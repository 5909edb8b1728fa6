"""Cases of a design in several processes."""

import multiprocessing
from functools import cache

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.design import Constraint, Design, DesignCase, Evaluated, Variable
from fowtlib.design.parallel import OtherProcess, shared_out
from fowtlib.language.errors import ModelError

forked = pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="no copies of a process here")


@cache
def spar():
    return fw.load("two_rotor_spar_design").compile()


def hull(processes, thrust=404e3, **more):
    cases = [DesignCase("full", weight=3), DesignCase("half", {"thrust": thrust}), DesignCase("rest", {"thrust": 0})]
    limits = [Constraint("pitch", upper="5 deg", cases=["full", "half"]), "heave @ rest > -20", "surge @ half < 50"]
    return Design(spar(), [Variable("diameter", 9, 12), Variable("draft", 110, 150)], "weighted pitch", limits, cases,
                  processes=processes, slopes="adjoint", **more)  # fmt: skip


@forked
def test_results_and_slopes_of_several_processes_are_those_of_one():
    alone, shared = (hull(processes).results for processes in (1, 2))
    for x in (np.array([10.7, 133.0]), np.array([10.0, 130.0])):
        one, other = (results.evaluate(x, jacobian=True) for results in (alone, shared))
        assert list(one.values) == list(other.values) and one.units == other.units
        for key in one.values:
            np.testing.assert_allclose(other.values[key], one.values[key], rtol=1e-9)
            np.testing.assert_allclose(other.jacobian[key], one.jacobian[key], rtol=1e-7, atol=1e-9)
    assert shared.evaluate(x).jacobian is None


@forked
def test_why_there_is_no_result_is_told_and_the_next_design_has_results():
    alone, shared = (hull(processes, thrust=4e8).results for processes in (1, 3))
    x, told = np.array([10.7, 133.0]), []
    for results in (alone, shared):
        with pytest.raises(ModelError) as error:
            results.evaluate(x)
        told.append(str(error.value))
    assert told[0] == told[1] and "case half" in told[0]
    fine = hull(2).results
    assert fine.evaluate(x).values.keys() == hull(1).results.evaluate(x).values.keys()


@forked
def test_a_process_that_ends_is_told():
    class Ending:
        def evaluate(self, x, jacobian=False):
            raise SystemExit

    with pytest.raises(ModelError, match="has ended"):
        OtherProcess(Ending).evaluate(np.zeros(1))


@forked
def test_a_process_ends_with_what_asks_it():
    class Nothing:
        def evaluate(self, x, jacobian=False):
            return Evaluated({}, {})

    other = OtherProcess(Nothing)
    assert other.evaluate(np.zeros(1)).values == {}
    process = other._process
    assert process.is_alive()
    del other
    process.join(20)
    assert not process.is_alive()


def test_cases_are_shared_out_by_what_they_cost():
    assert shared_out([26, 19, 19, 19, 1], 2) == [[0, 3], [1, 2, 4]]
    assert shared_out([3, 1], 5) == [[0], [1]]


def test_mistakes_are_told(monkeypatch):
    with pytest.raises(ModelError, match="processes is a whole number, 1 or more, not 0"):
        hull(0)
    with pytest.raises(ModelError, match="evaluated in one process"):
        _ = hull(2, free=["ballast"], targets={"heave": 0}, balance="rest").results
    monkeypatch.setattr(multiprocessing, "get_all_start_methods", lambda: ["spawn"])
    with pytest.raises(ModelError, match="cannot copy a running process"):
        _ = hull(2).results
