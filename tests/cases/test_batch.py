"""Batches: each case is run once, what fails says why, what has changed is run again, nothing of another is touched."""

from __future__ import annotations

import json
import shutil
import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cases import Batch, Case, run_batch
from fowtlib.cases import batch as batches
from fowtlib.cases.job import Job, Outcome, carry_out
from fowtlib.cases.pool import Event
from fowtlib.cases.registry import NAME, RUNNING, VERSION, Registry, RegistryError, held
from fowtlib.cases.statistics import statistics_of
from fowtlib.language.errors import ModelError, ParameterError

MODEL = """fowtlib: 1
title: a pendulum
world: {class: World}
hinge: {class: Revolute, n: [0, 1, 0], phi_start: 20 deg}
rod: {class: FixedTranslation, r: [0, 0, -1]}
bob: {class: PointMass, mass: 2 kg}
damper: {class: TorsionSpringDamper, stiffness: 0, damping: 0.5}
ground: {class: FixedFlange}
connect:
- [world.frame, hinge.frame_a]
- [hinge.frame_b, rod.frame_a]
- [rod.frame_b, bob.frame_a]
- [hinge.flange, damper.flange_b]
- [damper.flange_a, ground.flange]
outputs:
  pitch: {of: hinge.phi, unit: deg}
simulation: {duration: 2 s, output_step: 0.05 s, start: file}
"""


class Here:
    """Workers that compute in this process; `hook` is told each job before."""

    def __init__(self, hook=lambda job: None):
        self.hook, self.done = hook, []

    def carry_out(self, jobs):
        for job in jobs:
            yield Event("started", job.name, "here")
            self.hook(job)
            self.done.append(job.name)
            yield Event("ended", job.name, "here", outcome=carry_out(Job(**json.loads(json.dumps(job.plain())))))


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("pendulum.yaml").write_text(MODEL)
    return tmp_path


@pytest.fixture
def here(monkeypatch):
    workers = Here()
    monkeypatch.setattr(batches, "_workers", lambda *_: workers)
    return workers


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A batch that is done, to be copied."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "pendulum.yaml").write_text(MODEL)
    cases = [replace(case, model=str(folder / "pendulum.yaml")) for case in pendulums()]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "_workers", lambda *_: Here())
        run_batch(cases, folder / "b.batch", source="/x.yaml")
    return folder / "b.batch"


def pendulums(count=3, **changes):
    return [Case(f"m{k}", "pendulum.yaml", {"bob.mass": f"{k + 1} kg"}, **changes) for k in range(count)]


def test_each_case_is_run_once_and_its_results_are_those_of_a_single_run(place, here):
    batch = run_batch(pendulums(), "b.batch")
    assert [row.state for row in batch] == ["done"] * 3 and here.done == ["m0", "m1", "m2"]
    alone = fw.load("pendulum.yaml").compile().simulate(parameters={"bob.mass": 2.0})
    assert np.array_equal(batch.result("m1").array("pitch"), alone.array("pitch"))
    told = batch.row("m1").statistics["pitch"]
    values = alone.array("pitch")
    assert told["unit"] == "deg" and told["max"] == values.max() and told["mean"] == pytest.approx(values.mean())
    kept = batch.statistics("m1")
    assert kept.pop("equivalent_loads") == {} and kept == fw.case_statistics(alone)
    assert run_batch(pendulums(), "b.batch").counts == {"due": 0, "running": 0, "done": 3, "failed": 0}
    assert len(here.done) == 3


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda: [replace(case, duration=3.0) for case in pendulums()], "duration was not given, is 3"),
        (lambda: [replace(case, parameters={"bob.mass": "5 kg"}) for case in pendulums()], "bob.mass was 1 kg, is 5"),
        (lambda: Path("pendulum.yaml").write_text(MODEL.replace("0.5}", "0.6}")), "pendulum.yaml has changed"),
        (lambda: Path("b.batch/m0.nc").unlink(), "its result is gone"),
        (lambda: Path("b.batch/m0.nc").write_bytes(b"x"), "not the one that was written"),
    ],
)
def test_what_has_changed_is_run_again_and_says_why(place, here, change, why):
    run_batch(pendulums(), "b.batch")
    here.done.clear()
    changed = change()
    with Registry(place / "b.batch", write=True)._transaction():  # it can be written while nothing runs
        pass
    batch = run_batch(changed if isinstance(changed, list) else pendulums(), "b.batch")
    assert here.done == (["m0"] if "result" in why or "written" in why else ["m0", "m1", "m2"])
    assert why in Path("b.batch/batch.log").read_text() and batch.counts["done"] == 3


def test_a_data_file_that_has_changed_makes_its_case_due(place, here):
    Path("wind.csv").write_text("time [s],u [m/s]\n0,8\n1,9\n2,8\n3,9\n")
    file = {"wind.kind": "file", "wind.file": str(place / "wind.csv")}
    cases = [Case(name, "oc3_spar_rigid", parameters, start="file", duration=1.0)
             for name, parameters in (("file", file), ("still", {"wind.kind": "none"}))]  # fmt: skip
    batch = run_batch(cases, "b.batch")
    assert batch.counts["done"] == 2, [row.message for row in batch]
    here.done.clear()
    Path("wind.csv").write_text("time [s],u [m/s]\n0,8\n1,9\n2,8\n3,10\n")
    run_batch(cases, "b.batch")
    assert here.done == ["file"]
    assert f"due     file: {place}/wind.csv has changed" in Path("b.batch/batch.log").read_text()


def short(place, duration=6.0):
    """Of a wind that ends after 3 s nothing is known later."""
    (place / "wind.csv").write_text("time [s],u [m/s]\n0,8\n1,9\n2,8\n3,9\n")
    wind = {"wind.kind": "file", "wind.file": str(place / "wind.csv")}
    return Case("short", "oc3_spar_rigid", wind, start="file", duration=duration)


def test_a_failing_case_keeps_its_sentence_and_what_it_has_computed_and_the_others_go_on(place, here):
    wrong = short(place)
    batch = run_batch([wrong, *pendulums()], "b.batch")
    assert batch.counts == {"due": 0, "running": 0, "done": 3, "failed": 1}
    row = batch.row("short")
    assert "wind.csv" in row.message and "are saved in short.partial.nc" in row.message
    assert batch.result("short").time[-1] == row.simulated == pytest.approx(3, abs=0.2)
    here.done.clear()
    run_batch([wrong, *pendulums()], "b.batch")
    assert here.done == []
    run_batch([wrong, *pendulums()], "b.batch", retry=True)
    assert here.done == ["short"]
    batch = run_batch([replace(wrong, duration=2.5), *pendulums()], "b.batch")
    assert batch.counts["done"] == 4 and batch.path("short") == Path("b.batch/short.nc")
    assert not Path("b.batch/short.partial.nc").exists()


def test_the_first_of_each_wind_comes_first(place, here):
    """So that two workers do not seek one mean at the same time."""
    winds = [("a1", 8, 1), ("a2", 8, 2), ("b1", 9, 1), ("b2", 9, 2)]
    cases = [Case(name, "oc3_spar_rigid", {"wind.kind": "kaimal", "wind.mean_speed": speed, "wind.seed": seed,
                                           "sea.spectrum": "jonswap", "sea.significant_wave_height": 2.0 + seed,
                                           "sea.peak_period": 10.0}, start="file", duration=0.2)
             for name, speed, seed in winds]  # fmt: skip
    batch = run_batch(cases, "b.batch", keep="statistics")
    assert here.done == ["a1", "b1", "a2", "b2"] and [row.name for row in batch] == ["a1", "a2", "b1", "b2"]


def test_what_cannot_be_run_is_found_before_anything_is(place, here):
    wrong = Case("wrong", "pendulum.yaml", {"bob.mas": 3})
    with pytest.raises(ModelError, match="case 'wrong'.*bob.*'mas'; did you mean 'mass'"):
        run_batch([*pendulums(), wrong], "b.batch")
    assert here.done == [] and Batch.open("b.batch").counts["due"] == 4
    assert run_batch([*pendulums(), replace(wrong, parameters={"bob.mass": 3})], "b.batch").counts["done"] == 4


def test_a_mean_is_found_once_in_a_batch(place, here, monkeypatch):
    from fowtlib.cases import job
    from fowtlib.solving import starts

    found = []
    monkeypatch.setattr(starts, "_found", lambda *given, find=starts._found: found.append(given[1]) or find(*given))
    cases = [Case(f"s{seed}", "oc3_spar_rigid", {"wind.kind": "kaimal", "wind.mean_speed": 9, "wind.seed": seed},
                  duration=1.0) for seed in (1, 2)]  # fmt: skip
    job._plants.clear()
    run_batch(cases[:1], "b.batch")
    job._plants.clear()  # as another worker
    run_batch(cases, "b.batch")
    assert found == ["turning"] and len(list(Path("b.batch/starts").iterdir())) == 1
    assert here.done == ["s1", "s2"]


def test_statistics_alone_and_other_formats(place, here):
    batch = run_batch(pendulums(), "s.batch", keep="statistics")
    assert batch.path("m0") is None and not list(Path("s.batch").glob("*.nc")) and batch.row("m0").statistics
    run_batch(pendulums(), "s.batch")
    assert len(here.done) == 3
    other = run_batch(pendulums(), "o.batch", format="outb")
    assert other.path("m0").suffix == ".outb" and other.result("m0").time[-1] == pytest.approx(2)
    with pytest.raises(RegistryError, match="begun with format outb, which cannot be changed to nc"):
        run_batch(pendulums(), "o.batch", format="nc")
    with pytest.raises(ParameterError, match="format is 'csv'; it must be 'nc' or 'outb'"):
        run_batch(pendulums(), "p.batch", format="csv")


def test_cases_that_are_left_out_stay_and_come_back_done(place, here):
    run_batch(pendulums(), "b.batch")
    assert [row.name for row in run_batch(pendulums(2)[::-1], "b.batch")] == ["m1", "m0"]
    assert [row.name for row in run_batch(pendulums(), "b.batch")] == ["m0", "m1", "m2"] and len(here.done) == 3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda cases: run_batch([], "n.batch"), "there are no cases"),
        (lambda cases: run_batch([*cases, cases[0]], "n.batch"), "two cases 'm0'; each needs a name of its own"),
        (lambda cases: run_batch([replace(cases[0], name="M1"), cases[1]], "n.batch"), "'M1' and 'm1', which some"),
        (lambda cases: run_batch([replace(cases[0], name="../a")], "n.batch"), "its name is that of a file"),
        (lambda cases: run_batch([replace(cases[0], name="")], "n.batch"), "is not empty"),
        (lambda cases: run_batch([replace(cases[0], name="é" * 101)], "n.batch"), "more than 200 letters"),
        (lambda cases: run_batch(cases, "n.batch", workers=0), "at least one"),
        (lambda cases: run_batch(cases, "a/b/c"), "the folder a/b does not exist"),
        (lambda cases: run_batch(cases, "pendulum.yaml"), "is a file; a batch needs a folder"),
        (lambda cases: run_batch([replace(cases[0], name="other")], "b.batch"), "holds another batch, with cases such"),
        (lambda cases: run_batch(cases, "b.batch", source="/y.yaml"), "holds another batch, of /x.yaml"),
        (lambda cases: run_batch([replace(cases[0], model="oc3_sprr")], "n.batch"), "there is no model 'oc3_sprr'"),
        (lambda cases: run_batch(cases, "full"), "holds other things, and no batch"),
        (lambda cases: Batch.open("full"), "is not the folder of a batch"),
        (lambda cases: Batch.open("b.batch").row("m7"), "there is no case 'm7'; there are 'm0', 'm1'"),
    ],
)
def test_mistakes_are_sentences_and_change_nothing(place, finished, make, message):
    shutil.copytree(finished, "b.batch")
    Path("full").mkdir()
    Path("full/letter.txt").write_text("dear")
    before = {path: path.read_bytes() for path in Path("b.batch").iterdir()}
    with pytest.raises(ModelError, match=message):
        make(pendulums())
    assert {path: path.read_bytes() for path in Path("b.batch").iterdir()} == before
    assert [path.name for path in Path("full").iterdir()] == ["letter.txt"]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (
            lambda path: _ask(path, f"PRAGMA user_version = {VERSION + 1}"),
            "made by a newer fowtlib .registry of",
        ),
        (lambda path: _ask(path, "PRAGMA application_id = 7"), "is not the registry of a batch"),
        (lambda path: path.write_bytes(b"SQLite format 3\0" + b"x" * 5000), "damaged"),
        (lambda path: path.write_text("no registry at all, but long enough for a header " * 9), "damaged"),
    ],
)
def test_a_registry_of_another_kind_is_refused(place, finished, damage, message):
    shutil.copytree(finished, "b.batch")
    damage(Path("b.batch") / NAME)
    before = {path: path.read_bytes() for path in Path("b.batch").iterdir()}
    for attempt in (lambda: run_batch(pendulums(), "b.batch"), lambda: Batch.open("b.batch")):
        with pytest.raises(RegistryError, match=message):
            attempt()
    assert {path: path.read_bytes() for path in Path("b.batch").iterdir()} == before


def _ask(path, query):
    base = sqlite3.connect(path)
    base.execute(query)
    base.commit()
    base.close()


def test_a_batch_that_is_running_is_not_run_twice(place, here):
    run_batch(pendulums(), "b.batch")
    with held(Path("b.batch")), pytest.raises(RegistryError, match="running already, in another process"):
        run_batch(pendulums(), "b.batch")
    assert Batch.open("b.batch").counts["done"] == 3


def test_a_full_disk_ends_the_batch_and_what_is_done_is_kept(place, here, monkeypatch):
    from fowtlib.solving.results import files

    write = files.write_netcdf

    def hook(job):
        def failing(*_, **__):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(files, "write_netcdf", failing if job.name == "m1" else write)

    here.hook = hook
    with pytest.raises(ModelError, match="m1.nc: cannot be written: No space left on device.*run the batch again"):
        run_batch(pendulums(), "b.batch")
    batch = Batch.open("b.batch")
    assert [row.state for row in batch] == ["done", "due", "due"]
    here.hook = lambda job: monkeypatch.setattr(files, "write_netcdf", write)
    here.done.clear()
    assert run_batch(pendulums(), "b.batch").counts["done"] == 3 and here.done == ["m1", "m2"]


def test_a_full_disk_under_the_registry_is_a_sentence(place, here):
    run_batch(pendulums(), "b.batch")
    registry = Registry(place / "b.batch", write=True)
    pages = registry._base.execute("PRAGMA page_count").fetchone()[0]
    registry._base.execute(f"PRAGMA max_page_count = {pages}")  # what SQLite says of a full disk
    with pytest.raises(RegistryError, match="no room on the disk. What is finished is kept"):
        registry.ended("m0", "done", {"message": "x" * 100_000})
    registry.close()
    assert Batch.open("b.batch").row("m0").message == ""


def test_a_stopped_batch_goes_on(place, here):
    def hook(job):
        if job.name == "m1":
            raise KeyboardInterrupt

    here.hook = hook
    with pytest.raises(KeyboardInterrupt):
        run_batch(pendulums(), "b.batch")
    rows = Batch.open("b.batch").rows()
    assert [row.state for row in rows] == ["done", "due", "due"] and rows[1].why == "the batch was stopped"
    here.hook = lambda job: None
    assert run_batch(pendulums(), "b.batch").counts["done"] == 3 and here.done == ["m0", "m1", "m2"]


def test_progress_tells_rate_and_time_left(place, here):
    told = []
    run_batch(pendulums(), "b.batch", progress=told.append)
    assert told[-1].done == 3 and told[-1].running == 0 and told[-1].left == 0
    assert told[-1].simulated == told[-1].to_simulate == pytest.approx(6) and told[-1].rate > 0
    assert told[1].done == 1 and told[1].left > 0 and told[0].left is None
    assert batches.in_words(told[-1]).startswith("3 of 3 cases done, 0 running")


def test_one_plant_serves_all_cases_of_a_model(place, here, counted):
    from fowtlib.cases import job

    job._plants.clear()
    run_batch(pendulums(5), "b.batch")
    assert counted["flattened"] == 1 and counted["compiled"] <= 1
    Path("pendulum.yaml").write_text(MODEL.replace("0.5}", "0.6}"))
    run_batch(pendulums(5), "b.batch")
    assert counted["flattened"] == 2


def test_rows_that_a_killed_run_has_left_are_due(place, here):
    run_batch(pendulums(), "b.batch")
    registry = Registry(place / "b.batch", write=True)
    registry.started("m1", "process 7")
    registry.close()
    assert Batch.open("b.batch").row("m1").state == RUNNING
    Path("b.batch/.fowtlib.half.nc").write_text("half")
    here.done.clear()
    assert run_batch(pendulums(), "b.batch").counts["done"] == 3 and here.done == ["m1"]
    assert not Path("b.batch/.fowtlib.half.nc").exists()


def test_a_transaction_that_was_cut_off_is_taken_back(place, here):
    """A copy of the files as they are in the middle of one, as a kill would leave them."""
    run_batch(pendulums(), "b.batch")
    registry = Registry(place / "b.batch", write=True)
    registry._base.execute("PRAGMA cache_size = 1")  # so that it has to write before the end
    registry._base.execute("BEGIN IMMEDIATE")
    registry._base.execute("UPDATE cases SET state = 'failed', message = ?", ("x" * 50_000,))
    assert Path("b.batch/registry.sqlite-journal").stat().st_size
    shutil.copytree("b.batch", "c.batch")
    registry._base.execute("ROLLBACK")
    registry.close()
    assert Batch.open("c.batch").counts["done"] == 3
    here.done.clear()
    assert run_batch(pendulums(), "c.batch").row("m1").message == "" and here.done == []


def test_a_batch_can_be_moved(place, here):
    run_batch(pendulums(), "b.batch")
    shutil.move("b.batch", "c.batch")
    here.done.clear()
    assert run_batch(pendulums(), "c.batch").result("m2").time[-1] == 2 and not here.done


def test_equivalent_loads_are_kept_of_loads_alone():
    time = np.linspace(0.0, 100.0, 10001)
    load = np.cos(2 * np.pi * time)  # whole cycles, from crest to crest
    told = statistics_of(fw.Result(time, {"load": load, "other": 2 * load}, {"load": "kN m", "other": "m"}))
    assert list(told["equivalent_loads"]) == ["load"]
    assert told["equivalent_loads"]["load"]["4"] == pytest.approx(2.0, rel=1e-3)  # the range of a sine at 1 Hz
    assert statistics_of(fw.Result(time[:2], {"load": load[:2]}, {"load": "kN m"})) == {}


@pytest.mark.parametrize("keep", ["all", "statistics"])
def test_a_long_case_goes_on_where_it_was_killed(place, monkeypatch, keep):
    """Killed by an end that nobody hears of; what comes out is the same, bit by bit."""
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)
    monkeypatch.setattr("fowtlib.solving.event_rules.STRETCH", 5)
    told, stop = [], [None]

    class Killed(BaseException):
        pass

    class Workers:
        def carry_out(self, jobs):
            def report(t, end):
                told.append(t)
                if stop[0] is not None and t > stop[0]:
                    raise Killed

            for job in jobs:
                yield Event("ended", job.name, "here", outcome=carry_out(job, report))

    monkeypatch.setattr(batches, "_workers", lambda *_: Workers())
    case = Case("m", "pendulum.yaml", duration=5.0, discard=1.0, solver="fixed", step=0.01)
    whole = run_batch([case], "w.batch", keep=keep)
    stop[0] = 3.0
    with pytest.raises(Killed):
        run_batch([case], "b.batch", keep=keep)
    assert Batch.open("b.batch").row("m").state == "due" and list(Path("b.batch").glob("m.nc.part*"))
    stop[0] = None
    told.clear()
    batch = run_batch([case], "b.batch", keep=keep)
    assert told[0] > 2.0 and batch.row("m").statistics == whole.row("m").statistics
    assert not list(Path("b.batch").glob("m.nc.part*"))
    if keep == "all":
        one, other = whole.result("m"), batch.result("m")
        assert other.time[0] == 1.0 and np.array_equal(one.time, other.time)
        assert np.array_equal(one.array("pitch"), other.array("pitch")) and np.array_equal(one.raw.x, other.raw.x)
    stop[0] = 3.0
    with pytest.raises(Killed):
        run_batch([replace(case, duration=4.5)], "b.batch", keep=keep)
    stop[0] = None
    told.clear()
    batch = run_batch([replace(case, duration=4.0, step=0.02)], "b.batch", keep=keep)  # another case by now
    assert told[0] == 0.0 and batch.row("m").simulated == 4.0


def test_outcomes_go_through_json():
    outcome = Outcome("done", files={"a": "b"}, statistics={"x": {"unit": "m", "skewness": float("nan")}})
    again = Outcome(**json.loads(json.dumps(outcome.plain())))
    assert again.files == outcome.files and np.isnan(again.statistics["x"]["skewness"])
