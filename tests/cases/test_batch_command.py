"""`fowt batch`: run, status, retry and table, their exit status and their sentences."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from fowtlib.cases import Batch
from fowtlib.cases import batch as batches
from fowtlib.cases.job import carry_out
from fowtlib.cases.pool import Event
from fowtlib.cli.app import main

CASES = """fowtlib_cases: 1
model: oc3_spar_rigid
defaults: {duration: DURATION, start: file, outputs: [surge, pitch]}
sets:
- vary:
    wind_speed: [8, 10]
  name: w{wind_speed}
  wind: {kind: steady, mean_speed: wind_speed}
- name: short
  wind: {kind: file, file: wind.csv}
"""


class Here:
    """Workers in this process."""

    def carry_out(self, jobs):
        for job in jobs:
            yield Event("started", job.name, "here")
            yield Event("ended", job.name, "here", outcome=carry_out(job))


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batches, "_workers", lambda *_: Here())
    Path("wind.csv").write_text("time [s],u [m/s]\n0,8\n1,9\n2,8\n3,9\n")
    Path("few.yaml").write_text(CASES.replace("DURATION", "5 s"))
    return tmp_path


def test_a_batch_from_the_first_run_to_its_table(place, capsys):
    assert main(["batch", "run", "few.yaml"]) == 1
    said = capsys.readouterr()
    assert said.out == "few.batch: 2 of 3 cases done, 1 failed\n"
    assert (
        "failed  short: " in said.err and "to try those that have failed again: fowt batch retry few.yaml" in said.err
    )
    sentence = Batch.open("few.batch").row("short").message
    assert said.err.count(" ".join(sentence.split())) == 1 and "\nshort: " not in said.err
    assert main(["batch", "run", "few.yaml"]) == 1  # nothing is due, and the reason is said all the same
    assert capsys.readouterr().err.startswith(f"short: {sentence}\n")
    assert {path.name for path in Path("few.batch").iterdir()} >= {"w8.nc", "w10.nc", "short.partial.nc", "batch.log"}

    assert main(["batch", "status", "few.yaml", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [(row["case"], row["state"]) for row in rows] == [("short", "failed")]
    assert "short.partial.nc" in rows[0]["what there is to say"]
    assert main(["batch", "status", "few.batch", "--all"]) == 0
    assert "few.batch: 2 of 3 cases done, 1 failed" in capsys.readouterr().out

    assert main(["batch", "table", "few.yaml", "--results", "pitch", "--statistics", "mean,max", "-o", "t.csv"]) == 0
    table = list(csv.DictReader(Path("t.csv").read_text().splitlines()))
    assert [row["case"] for row in table] == ["w8", "w10"] and table[1]["wind_speed"] == "10"
    pitch = Batch.open("few.batch").result("w10").array("pitch")
    assert float(table[1]["max"]) == pitch.max() and table[1]["unit"] == "deg"
    assert main(["batch", "table", "few.yaml", "-o", "t.csv"]) == 2
    assert "t.csv is there already" in capsys.readouterr().err

    Path("few.yaml").write_text(CASES.replace("DURATION", "2.5 s"))
    assert main(["batch", "run", "few.yaml"]) == 0
    assert capsys.readouterr().out == "few.batch: 3 of 3 cases done\n"
    assert "due     w8: the case has changed: duration was 5.0, is 2.5" in Path("few.batch/batch.log").read_text()


def test_names_with_a_comma_in_brackets_are_one_result(place, capsys):
    text = CASES[: CASES.index("- name: short")].replace("DURATION", "1 s")
    Path("matrix.yaml").write_text(text.replace("pitch", "platform.hull.frame_a.R"))
    assert main(["batch", "run", "matrix.yaml"]) == 0
    capsys.readouterr()
    one, other = (f"platform.hull.frame_a.R[{index}]" for index in ("0,1", "2,2"))
    assert main(["batch", "table", "matrix.yaml", "--results", f"{one}, surge,{other}", "--json"]) == 0
    assert [row["result"] for row in json.loads(capsys.readouterr().out)] == [one, "surge", other] * 2
    assert main(["batch", "report", "matrix.yaml", "--results", f"{one},surge"]) == 0


def test_retry_runs_those_that_have_failed(place, capsys):
    assert main(["batch", "run", "few.yaml", "--folder", "f"]) == 1
    assert main(["batch", "run", "few.yaml", "--folder", "f"]) == 1
    assert main(["batch", "retry", "few.yaml", "--folder", "f"]) == 1
    log = Path("f/batch.log").read_text()
    assert log.count("failed  short") == 2 and log.count("done    w8") == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["run", "fw.yaml"], "fowt batch run: there is no file 'fw.yaml'."),
        (["status", "few.yaml"], "few.batch: there is no such folder; begin the batch with fowt batch run few.yaml"),
        (["status", "few.yaml", "--folder", "b"], "b: there is no such folder; begin the batch with fowt batch run "
         "few.yaml --folder b."),
        (["table", "wind.csv"], "wind.csv: is neither a file that lists cases (.yaml) nor the folder of a batch."),
        (["run", "."], ".: is a folder; give the file that lists the cases."),
        (["run", "few.yaml", "--folder", "few.yaml"], "few.yaml: is a file; a batch needs a folder."),
        (["run", "few.yaml", "--workers", "0"], "'0' is not a whole number above zero"),
        (["run", "few.yaml", "--worker", "2"], "unknown option '--worker'; did you mean '--workers'?"),
        (["run", "few.yaml", "--format", "csv"], "format is 'csv'; it must be 'nc' or 'outb'."),
        (["rum", "few.yaml"], "unknown action 'rum'; did you mean 'run'?"),
        ([], "the following arguments are required: ACTION"),
    ],
)
def test_mistakes(place, capsys, words, message):
    try:
        status = main(["batch", *words])
    except SystemExit as end:
        status = end.code
    assert status == 2 and message in capsys.readouterr().err
    assert not Path("few.batch").exists()


def test_what_is_asked_of_a_batch_in_a_wrong_way(place, capsys):
    main(["batch", "run", "few.yaml"])
    capsys.readouterr()
    assert main(["batch", "table", "few.yaml", "--results", ","]) == 2
    assert "',' names no result; give names with commas between them." in capsys.readouterr().err
    assert main(["batch", "report", "few.yaml", "--results", "pitch,heave"]) == 2
    assert "the cases have no result 'heave'; there are 'surge' and 'pitch'." in capsys.readouterr().err
    Path("other.yaml").write_text(CASES.replace("DURATION", "5 s"))
    assert main(["batch", "status", "other.yaml", "--folder", "few.batch"]) == 0
    assert f"few.batch: holds the batch of {place / 'few.yaml'}, not of other.yaml." in capsys.readouterr().err
    for words in (["few.yaml"], ["few.batch"], ["few.yaml", "--folder", "few.batch"]):
        assert main(["batch", "status", *words]) == 0
        assert "holds the batch" not in capsys.readouterr().err


def test_a_stopped_batch_says_how_to_go_on(place, capsys, monkeypatch):
    def stop(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Here, "carry_out", lambda *_: (stop(job) for job in (1,)))
    assert main(["batch", "run", "few.yaml"]) == 130
    assert "stopped. What is done is kept in few.batch; to go on, run it again." in capsys.readouterr().err


def test_a_steep_sea_runs_where_the_file_allows_it(place, capsys):
    text = CASES[: CASES.index("- name: short")].replace("DURATION", "2 s")
    steep = text.replace("  wind: {kind: steady", "  sea: 'jonswap:Hs=1,Tp=2'\n  wind: {kind: steady")
    Path("steep.yaml").write_text(steep)
    assert main(["batch", "run", "steep.yaml"]) == 2
    assert "steeper than seas are" in capsys.readouterr().err and not Path("steep.batch").exists()
    Path("steep.yaml").write_text(steep.replace("start: file", "start: file, steep_sea: allow"))
    assert main(["batch", "run", "steep.yaml"]) == 0


def test_the_page_of_a_batch(place, capsys):
    main(["batch", "run", "few.yaml"])
    assert main(["batch", "report", "few.yaml", "--results", "pitch", "--title", "A few"]) == 0
    assert "saved few.html" in capsys.readouterr().err
    page = Path("few.html").read_text()
    assert "<title>A few</title>" in page and "worst-pitch" in page and "wind.csv" in page
    assert main(["batch", "report", "few.batch", "--results", "pitch"]) == 2
    assert "few.html is there already" in capsys.readouterr().err
    assert main(["batch", "report", "few.yaml", "--output", "page.pdf"]) == 2
    assert "page.pdf: the file must end in '.html'" in capsys.readouterr().err
    assert main(["batch", "report", "none.yaml"]) == 2
    assert "none.batch: there is no such folder; begin the batch with" in capsys.readouterr().err
