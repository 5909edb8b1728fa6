"""Every command that needs a model, on a pendulum whose numbers are known."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli import tables
from fowtlib.cli.app import main
from fowtlib.components.environment import World
from fowtlib.components.mechanics import FreeMotion, RigidBody
from fowtlib.language.errors import SimulationError

pytestmark = pytest.mark.usefixtures("shipped_pendulum")

FREQUENCY = math.sqrt(9.81) / (2 * math.pi)
DAMPING = 0.5 / (2 * 2.0 * math.sqrt(9.81))  # c / (2 m l^2 omega)


def printed(capsys: pytest.CaptureFixture[str], *argv: str):
    """What a command prints as JSON."""
    assert main([*argv, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def test_run_prints_statistics_and_saves(capsys):
    assert main(["run", "pendulum", "--output", "r.nc", "--plot", "r.png"]) == 0
    shown = capsys.readouterr()
    assert "0 s to 5 s" in shown.out and "pitch" in shown.out
    assert shown.err == "saved r.nc\nsaved r.png\n"
    assert Path("r.png").read_bytes().startswith(b"\x89PNG")
    result = fw.Result.open("r.nc")
    assert result.time[-1] == 5.0
    assert result["pitch"].units == "deg"
    row = printed(capsys, "run", "pendulum")[0]
    assert row["result"] == "pitch" and row["unit"] == "deg"
    assert row["max"] == pytest.approx(20.0)
    assert row["mean"] == pytest.approx(result.statistics()["pitch"].mean, rel=1e-3)


def test_the_step_of_the_results_can_be_chosen(capsys):
    assert main(["run", "pendulum", "--time", "2", "--output-step", "0.5", "--output", "run.csv"]) == 0
    times = [float(row[0]) for row in csv.reader(Path("run.csv").read_text().splitlines()[1:]) if row[0][0].isdigit()]
    assert times == pytest.approx([0, 0.5, 1.0, 1.5, 2.0])


def test_run_writes_csv(capsys):
    assert main(["run", "pendulum", "--time", "1", "--output", "r.csv", "--tolerance", "1e-8", "--solver", "idas"]) == 0
    rows = list(csv.reader(Path("r.csv").read_text().splitlines()))
    assert rows[0] == ["time [s]", "pitch [deg]"]
    assert len(rows) == 52


def test_run_writes_the_binary_output_of_openfast(capsys):
    assert main(["run", "pendulum", "--time", "1", "--output", "r.outb"]) == 0
    result = fw.Result.open("r.outb")
    assert result["pitch"].units == "deg" and len(result.time) == 51
    assert b"PtfmPitch" in Path("r.outb").read_bytes()


def test_what_an_outb_file_cannot_hold_is_saved_as_netcdf(capsys):
    assert main(["run", "pendulum", "--time", "1.005", "--output", "r.outb"]) == 2
    assert capsys.readouterr().err == (
        "fowt run: r.outb: the file format knows evenly spaced times only, and these are not: 1 s is followed by "
        "1.005 s. Save as .nc or .csv, or simulate for a multiple of the output step.\n"
        "The results are saved in r.nc instead.\n"
    )
    assert fw.Result.open("r.nc").time[-1] == 1.005 and not Path("r.outb").exists()


def test_a_resumed_run_continues_the_first(capsys):
    assert main(["run", "pendulum", "--time", "2", "--output", "first.nc", "--tolerance", "1e-9"]) == 0
    assert main(["run", "pendulum", "--time", "4", "--resume", "first.nc", "--output", "both.nc"]) == 0
    assert main(["run", "pendulum", "--time", "4", "--output", "whole.nc", "--tolerance", "1e-9"]) == 0
    both, whole = (fw.Result.open(name) for name in ("both.nc", "whole.nc"))
    np.testing.assert_allclose(both.time, whole.time, atol=1e-9)
    np.testing.assert_allclose(both.array("pitch"), whole.array("pitch"), atol=1e-3)


@pytest.mark.parametrize(
    ("options", "left"),
    [("--time 2 --discard 2", 2), ("--discard 7", 5), ("--time 4 --resume first.nc --discard 9", 4)],
)
def test_a_run_that_would_be_discarded_whole_is_refused_before_it_starts(capsys, options, left):
    assert main(["run", "pendulum", "--time", "2", "--output", "first.nc"]) == 0
    capsys.readouterr()
    assert main(["run", "pendulum", *options.split(), "--output", "second.nc"]) == 2
    discarded = options.split()[-1]
    assert capsys.readouterr().err == (
        f"fowt run: --discard: {discarded} s of a run of {left} s leave nothing; discard less, or simulate longer "
        "(--time).\n"
    )
    assert not Path("second.nc").exists()
    assert main(["run", "pendulum", "--time", "4", "--resume", "first.nc", "--discard", "3"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("going on from first.nc\n3 s to 4 s")


@pytest.mark.parametrize(("value", "size", "shown"), [
    (2e-72, 2.4, 0.0), (7.9e-34, 1.4e-32, 0.0), (-8.4e-7, 6.7, -8.4e-7), (1e-9, 1e-9, 1e-9), (3e-5, 1e8, 0.0),
])  # fmt: skip
def test_a_number_lost_in_rounding_is_zero_and_a_small_one_is_not(value, size, shown):
    assert tables.rounded(value, size) == shown


def test_settings_change_parameters(capsys):
    def largest(*extra: str) -> float:
        return printed(capsys, "run", "pendulum", "--time", "1", *extra)[0]["max"]

    assert largest("--set", "hinge.phi_start=0.1") == pytest.approx(math.degrees(0.1))
    assert largest("--set", "hinge.phi_start=30 deg", "--set", "bob.mass=3 kg") == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--set", "hinge.phi_strat=1"], "fowt run: hinge has no parameter 'phi_strat'; did you mean 'phi_start'?\n"),
        (
            ["--wind", "steady:8"],
            "fowt run: --wind: this model has no part 'wind' whose parameters could be set; "
            "use --set with the paths of its own parameters (see `fowt parameters`).\n",
        ),
        (["--output", "r.txt"], "fowt run: r.txt: the file must end in '.nc', '.csv' or '.outb'.\n"),
        (
            ["--plot", "missing/r.png"],
            "fowt run: missing/r.png: the folder missing does not exist; make it first, or choose another one.\n",
        ),
        (
            ["--wind", ""],
            "fowt run: --wind: this model has no part 'wind' whose parameters could be set; use --set "
            "with the paths of its own parameters (see `fowt parameters`).\n",
        ),
        (["--resume", "old.nc"], "fowt run: old.nc: there is no such file.\n"),
        (["--solver", "idsa"], "fowt run: there is no solver 'idsa'; did you mean 'idas'?\n"),
    ],
)
def test_a_mistake_ends_with_status_2(capsys, argv, message):
    assert main(["run", "pendulum", *argv]) == 2
    assert capsys.readouterr().err == message


def test_a_file_that_cannot_be_written_is_refused_before_the_work(capsys, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    Path("r.nc").mkdir()
    monkeypatch.setattr(fw, "load", lambda *_, **__: pytest.fail("the model was loaded"))
    assert main(["run", "pendulum", "--output", "r.nc"]) == 2
    assert capsys.readouterr().err == "fowt run: r.nc: is a folder; choose another name.\n"
    monkeypatch.setattr("fowtlib.cli.files.tempfile.TemporaryFile", refuse)
    assert main(["run", "pendulum", "--output", "s.nc"]) == 2
    assert capsys.readouterr().err == "fowt run: s.nc: cannot be written: Permission denied.\n"


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), SimulationError("the integration fails at t = 8 s.")])
def test_a_stopped_run_keeps_its_results(capsys, monkeypatch, stop):
    def report(t: float, t_end: float) -> None:
        if t > 7:
            raise stop

    class Bar:
        def __enter__(self):
            return report

        def __exit__(self, *_):
            return None

    monkeypatch.setattr("fowtlib.cli.run.progress_bar", lambda begin: Bar())
    interrupted = isinstance(stop, KeyboardInterrupt)
    assert main(["run", "pendulum", "--time", "20"]) == (130 if interrupted else 2)
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("fowt run: interrupted at t = 8 s." if interrupted else "fowt run: the integration fails")
    assert second == (
        "The results up to t = 8 s are saved in pendulum_partial.nc; to go on from there: --resume pendulum_partial.nc"
    )
    assert fw.Result.open("pendulum_partial.nc").time[-1] == 8.0


def test_tree_equations_and_parameters(capsys):
    assert main(["tree", "pendulum"]) == 0
    assert "├── hinge: Revolute" in capsys.readouterr().out
    rows = printed(capsys, "equations", "pendulum", "hinge")
    assert {"part": "hinge", "equation": "der(hinge.phi) = hinge.w"} in rows
    assert {row["part"] for row in rows} == {"hinge"}
    rows = {row["parameter"]: row for row in printed(capsys, "parameters", "pendulum")}
    assert rows["bob.mass"] == {
        "parameter": "bob.mass", "value": 2.0, "unit": "kg", "kind": "tunable", "what it is": "mass",
        "why structural": "",
    }  # fmt: skip
    assert rows["hinge.n"]["kind"] == "structural"
    assert rows["hinge.n"]["why structural"] == "its zeros drop out of the equations"
    assert rows["hinge.phi_start"]["value"] == pytest.approx(math.radians(20))
    assert main(["parameters", "pendulum"]) == 0
    said = capsys.readouterr().out
    assert "\nbob.mass = 2 kg\n    mass\n" in said
    assert "(structural: the model is built with it)" in " ".join(said.split())
    assert main(["equations", "pendulum", "hnge"]) == 2
    assert "did you mean 'hinge'?" in capsys.readouterr().err


def test_equilibrium_hangs_straight_down(capsys):
    (row,) = printed(capsys, "equilibrium", "pendulum")
    assert row == {"result": "pitch", "value": pytest.approx(0, abs=1e-9), "unit": "deg"}


def test_eigen_gives_frequency_and_damping(capsys):
    (row,) = printed(capsys, "eigen", "pendulum")
    assert row["frequency [Hz]"] == pytest.approx(FREQUENCY)
    assert row["period [s]"] == pytest.approx(1 / FREQUENCY)
    assert row["damping ratio"] == pytest.approx(DAMPING)
    assert row["motion"] == "pitch"


def test_a_motion_that_nothing_holds_is_no_mode(capsys, monkeypatch):
    free = fw.Assembly("a body in space")
    free.world, free.motion = World(gravity=0), FreeMotion()
    free.body = RigidBody(mass=1.0, inertia=((1, 0, 0), (0, 2, 0), (0, 0, 3)))
    free.connect(free.world.frame, free.motion.frame_a)
    free.connect(free.motion.frame_b, free.body.frame_a)
    monkeypatch.setattr(fw, "load", lambda *_, **__: fw.Model(free))
    assert printed(capsys, "eigen", "free") == []


def test_where_nothing_oscillates_it_is_said(capsys, monkeypatch):
    slow = fw.load("pendulum").with_parameters({"damper.damping": 100.0})
    monkeypatch.setattr(fw, "load", lambda *_, **__: slow)
    assert printed(capsys, "eigen", "slow") == []
    assert main(["eigen", "slow"]) == 0
    assert "Nothing oscillates; --all has 2 that do not." in capsys.readouterr().out


def test_what_runs_away_is_a_mode_although_it_does_not_oscillate(capsys, monkeypatch):
    standing = fw.load("pendulum").with_parameters({"rod.r": (0, 0, 1.0), "hinge.phi_start": 0.0})
    monkeypatch.setattr(fw, "load", lambda *_, **__: standing)
    assert main(["eigen", "standing", "--json"]) == 0
    said = capsys.readouterr()
    assert [row["motion"] for row in json.loads(said.out)] == ["pitch"]
    assert "pitch, grows by a factor e in" in said.err


def test_what_rounding_leaves_is_shown_as_zero():
    assert tables.rounded(-4.8e-17, 5.0) == 0.0
    assert tables.rounded(4.8e-11, 5.0) == 4.8e-11


def test_decay_gives_period_and_damping(capsys):
    argv = ["decay", "pendulum", "--dof", "pitch", "--offset", "1", "--time", "20", "--plot", "d.png"]
    rows = {row["quantity"]: row["value"] for row in printed(capsys, *argv)}
    assert rows["frequency"] == pytest.approx(FREQUENCY * math.sqrt(1 - DAMPING**2), rel=1e-3)
    assert rows["damping ratio"] == pytest.approx(DAMPING, rel=1e-2)
    assert Path("d.png").exists()


def test_tables_as_csv(capsys):
    assert main(["eigen", "pendulum", "--csv"]) == 0
    head, row = csv.reader(io.StringIO(capsys.readouterr().out))
    assert head == ["mode", "motion", "frequency [Hz]", "period [s]", "damping ratio"]
    assert float(row[2]) == pytest.approx(FREQUENCY)


@pytest.mark.parametrize("command", ["eigen", "equilibrium", "parameters", "equations"])
def test_every_table_goes_into_a_file(capsys, command):
    assert main([command, "pendulum", "-o", "table.csv"]) == 0
    capsys.readouterr()
    assert main([command, "pendulum", "--output", "table.json", "--json"]) == 0
    shown = capsys.readouterr()
    rows = json.loads(shown.out)
    assert shown.err == "saved table.json\n"
    assert json.loads(Path("table.json").read_text(encoding="utf-8")) == rows
    head, *lines = csv.reader(Path("table.csv").read_text(encoding="utf-8").splitlines())
    assert head == list(rows[0]) and len(lines) == len(rows)
    assert main([command, "pendulum", "-o", "table.txt"]) == 2
    assert "the file must end in '.csv' or '.json'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["run", "--time", "0.2"], "wind kaimal:11.4,class=B,seed=1 (the model's), waves jonswap:Hs=6,Tp=10,seed=1"),
        (["run", "--time", "0.2", "--wind", "steady:8,direction=20"],
         "wind steady:8,direction=20 (given), waves jonswap:Hs=6,Tp=10,seed=1 (the model's)"),
        (["run", "--time", "0.2", "--set", "sea.spectrum=still"], "wind kaimal:11.4,class=B,seed=1 (the model's), "
         "waves still (the model's)"),
        (["equilibrium"], "wind steady:11.4 (mean of the model's), waves still (mean of the model's)"),
        (["eigen", "--wind", "none"], "wind none (given), waves still (mean of the model's)"),
        (["rao", "--frequencies", "0.1"], "wind steady:11.4 (mean of the model's), waves still (mean of the model's)"),
        (["decay", "--dof", "yaw", "--offset", "2", "--time", "60"], "wind steady:11.4 (mean of the model's), waves"),
    ],
)  # fmt: skip
def test_the_first_line_says_wind_and_waves(capsys, monkeypatch, options, line):
    monkeypatch.undo()
    assert main([options[0], "oc3_spar_rigid", *options[1:]]) == 0
    assert capsys.readouterr().out.splitlines()[0].startswith(line)


def test_rao_needs_a_part_that_feels_waves(capsys):
    assert main(["rao", "pendulum", "--frequencies", "0.05:0.1:0.01"]) == 2
    assert capsys.readouterr().err.startswith("fowt rao: no part of this model feels the waves")
