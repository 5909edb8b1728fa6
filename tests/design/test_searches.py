"""Several starts, the journal with resuming and kills, logs, results that are kept, fronts, pictures."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from fowtlib.design import Constraint, Design, Evaluated, Function, Variable, pareto
from fowtlib.design.journal import Journal
from fowtlib.language.errors import ModelError


def valleys(**more) -> Design:
    """Two valleys: the start lies in the one at x = 2, the deeper one is at x = -2."""
    function = Function("f", lambda v: (v["x"] ** 2 - 4) ** 2 + v["x"] + v["y"] ** 2, ["x", "y"])
    return Design(None, [Variable("x", -4, 4, 2.05), Variable("y", -1, 1, 0.1)], "f", functions=[function], **more)


def banana(**more) -> Design:
    """A valley that is long and bent, with its end at (1, 1)."""
    function = Function("f", lambda v: (1 - v["x"]) ** 2 + 100 * (v["y"] - v["x"] ** 2) ** 2, ["x", "y"])
    return Design(None, [Variable("x", -2, 2, -1.2), Variable("y", -2, 2, 1)], "f", functions=[function], **more)


def test_several_starts_find_the_deeper_valley():
    lines = []
    one, many = valleys().optimise(), valleys().optimise(starts=6, seed=3, say=lines.append)
    assert one["x"] == pytest.approx(1.967, abs=1e-3) and many["x"] == pytest.approx(-2.03, abs=1e-3)
    assert [search.number for search in many.searches] == list(range(6))
    assert min(search.objective for search in many.searches) == many.value
    again = valleys().optimise(starts=6, seed=3)
    assert [search.objective for search in again.searches] == [search.objective for search in many.searches]
    assert lines[0] == "start 1 of 6" and "an optimum, after" in lines[-1]
    other = valleys().optimise(starts=6, seed=4)
    assert not np.array_equal(other.searches[1].start, many.searches[1].start)


def test_starts_without_results_are_told_and_left_out():
    design = valleys()

    class Half:
        def evaluate(self, x, jacobian=False):
            if x[0] < -1:
                raise ModelError("no equilibrium there.")
            return Evaluated({}, {}, {} if jacobian else None)

    object.__setattr__(design, "results", Half())
    found = design.optimise(starts=6, seed=3)
    assert found["x"] == pytest.approx(1.967, abs=1e-3)


def test_a_journal_goes_on_from_the_best(tmp_path):
    path = tmp_path / "banana.jsonl"
    first = banana().optimise(journal=path, iterations=3)
    assert not first.converged and first.reason == "the limit of iterations"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert lines[0]["fowtlib_design_journal"] == 1 and lines[-1]["ended"] == 0
    tried = [line for line in lines if "x" in line]
    best = min(line["objective"] for line in tried)
    kept = "".join(line for line in path.read_text().splitlines(keepends=True) if '"ended"' not in line)
    path.write_text(kept + '{"start": 0, "x": [1.0, 0.')  # a kill cut it off
    log = []
    second = banana().optimise(journal=path, resume=True, say=log.append)
    assert second["x"] == pytest.approx(1, abs=1e-3)
    assert float(log[1].split()[2]) == pytest.approx(best, rel=1e-5)
    third = banana().optimise(journal=path, resume=True)  # nothing is left to do
    assert third.searches[0].evaluations == 0 and third.value == pytest.approx(second.value)
    more = [json.loads(line) for line in path.read_text().splitlines() if line.endswith("}")]
    assert len(more) > len(lines)


def test_a_journal_of_another_design_is_refused(tmp_path):
    path = tmp_path / "journal.jsonl"
    valleys().optimise(journal=path)
    other = Design(None, [Variable("x", -4, 3, 2), Variable("y", -1, 1, 0.5)], "f", functions=valleys().functions)
    with pytest.raises(ModelError, match=r"journal.jsonl: the journal is of another design \(variables changed\)"):
        other.optimise(journal=path, resume=True)
    path.write_text("no journal\n")
    with pytest.raises(ModelError, match="this is no journal of a design"):
        valleys().optimise(journal=path, resume=True)
    with pytest.raises(ModelError, match="cannot be written"):
        valleys().optimise(journal=tmp_path / "nowhere" / "journal.jsonl")


SLOW = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have taken it away
sys.path.insert(0, {folder!r})
from test_searches import banana
from fowtlib.design import Evaluated
design = banana()
class Slow:
    def evaluate(self, x, jacobian=False):
        time.sleep(0.2)
        return Evaluated({{}}, {{}}, {{}} if jacobian else None)
object.__setattr__(design, "results", Slow())
design.optimise({method!r}, journal={path!r}, say=lambda line: print(line, flush=True))
"""


@pytest.mark.parametrize(("how", "method"), [(signal.SIGINT, "slsqp"), (signal.SIGKILL, "ipopt")])
def test_ctrl_c_and_kill_leave_a_journal_to_go_on_from(tmp_path, how, method):
    path = tmp_path / "journal.jsonl"
    script = SLOW.format(folder=str(Path(__file__).parent), method=method, path=str(path))
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    deadline = time.time() + 60
    while time.time() < deadline and (not path.exists() or len(path.read_text().splitlines()) < 4):
        time.sleep(0.05)
    os.kill(process.pid, how)
    _, errors = process.communicate(timeout=20)
    assert process.returncode != 0
    if how == signal.SIGINT:
        assert "KeyboardInterrupt" in errors
    kept = Journal(path, banana().about() | {"starts": 1, "seed": 0}).read()
    assert kept.designs and not kept.ended
    found = banana().optimise(journal=path, resume=True)
    assert found["x"] == pytest.approx(1, abs=1e-3)


def compromise() -> Design:
    """Distances from (1, 1) and from (0, 0): the front is the line x = y, sqrt(f) + sqrt(g) = sqrt(2)."""
    functions = [
        Function("f", lambda v: (v["x"] - 1) ** 2 + (v["y"] - 1) ** 2, ["x", "y"]),
        Function("g", lambda v: v["x"] ** 2 + v["y"] ** 2, ["x", "y"]),
    ]
    return Design(None, [Variable("x", -2, 2, 0.3), Variable("y", -2, 2, 1.5)], "f", functions=functions, title="line")


@pytest.mark.parametrize("by", ["limit", "weights"])
def test_a_front(by, tmp_path):
    front = pareto(compromise(), "g", 5, by=by)
    f, g = np.array(front.first), np.array(front.second)
    assert np.all(front.efficient) and np.all(np.diff(f) > 0) and np.all(np.diff(g) < 0)
    assert np.sqrt(f) + np.sqrt(g) == pytest.approx(np.sqrt(2), abs=2e-3)
    assert g[0] == pytest.approx(2, abs=1e-4) and f[-1] == pytest.approx(2, abs=1e-4)
    if by == "limit":
        assert g == pytest.approx([2, 1.5, 1, 0.5, 0], abs=1e-4)
    assert not front.optima[0].constraints
    front.save(tmp_path / "front.csv")
    rows = (tmp_path / "front.csv").read_text().splitlines()
    assert rows[0].startswith("f,g,x [1],y [1]") and len(rows) == 6
    front.plot(tmp_path / "front.png")
    assert (tmp_path / "front.png").stat().st_size > 5000
    assert "sqrt" not in repr(front) and "line" in repr(front)


def test_fronts_that_are_none_are_refused():
    both = [compromise().functions[0], Function("h", lambda v: 2 * v["f"] + 1, ["f"])]
    with pytest.raises(ModelError, match="there is no front"):
        pareto(Design(None, compromise().variables, "f", functions=both), "h")
    with pytest.raises(ModelError, match="is a variable"):
        pareto(compromise(), "x")
    with pytest.raises(ModelError, match="by 'limit' or by 'weights'"):
        pareto(compromise(), "g", by="chance")
    with pytest.raises(ModelError, match="2 points, or more"):
        pareto(compromise(), "g", 1)


def test_results_are_kept_and_drawn(tmp_path):
    functions = [
        Function("f", lambda v: (v["x"] - 1) ** 2 + (v["y"] - 3) ** 2, ["x", "y"], "EUR"),
        Function("g", lambda v: v["x"] + v["y"], ["x", "y"], "m"),
    ]
    variables = [Variable("x", 0, 2, 0.5), Variable("y", 0, 2, 0.5), Variable("z", 0, 1, 0.5)]
    design = Design(None, variables[:2], "f", [Constraint("g", upper="250 cm", name="reach")], functions=functions)
    found = design.optimise()
    assert found.active == ["reach <", "y (upper bound)"]
    assert found["x"] == pytest.approx(0.5, abs=1e-4)
    found.save(tmp_path / "design.json")
    told = json.loads((tmp_path / "design.json").read_text())
    assert told["variables"][1]["active"] == "upper" and told["constraints"][0]["constraint"] == "reach [m]"
    assert told["feasible"] is True and told["method"] == "ipopt"
    found.plot(tmp_path / "design.png")
    assert (tmp_path / "design.png").stat().st_size > 5000
    with pytest.raises(ModelError, match="saved as .json"):
        found.save(tmp_path / "design.txt")
    with pytest.raises(ModelError, match="there is no variable 'w'"):
        found["w"]
