"""`fowt sensitivity`: its table, files, picture, and what it refuses."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from fowtlib.cli import main
from fowtlib.cli.sensitivity import _memory

RUN = [
    "sensitivity", "oc3_spar_rigid", "--wind", "steady:14", "--waves", "still", "--time", "10", "--output-step", "0.5",
]  # fmt: skip


def test_a_table_a_file_and_a_picture(tmp_path, capsys):
    files = [tmp_path / "s.csv", tmp_path / "s.png"]
    chosen = ["--parameter", "platform.mooring.length", "--parameter", "platform.damping.translation[0]"]
    more = ["--result", "surge", "--start", "rest", "-o", str(files[0]), "--plot", str(files[1]), "--json"]
    assert main([*RUN, *chosen, *more]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["parameter"] for row in rows] == ["platform.mooring.length", "platform.damping.translation[0]"]
    assert rows[0]["unit of slope"] == "m/m" and rows[0]["mean"] > 0 and rows[0]["its value"] == pytest.approx(902.2)
    assert files[0].read_text().startswith("time [s],d surge / d platform.mooring.length [m/m]")
    assert files[1].stat().st_size > 5000


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--parameter", "platform.mooring.lenght"], "no tunable parameter 'platform.mooring.lenght'; did you mean"),
        (["--parameter", "wind.kind"], "there is no derivative by wind.kind"),
        (["--parameter", "tower.mass", "--result", "surg"], "no result or variable 'surg'; did you mean 'surge'"),
        (["--parameter", "tower.mass", "--start", "stationary"], "--start: the stationary state"),
        (["--parameter", "tower.mass", "--parameter", "tower.mass"], "--parameter: tower.mass is given twice"),
        (["--parameter", "tower.mass", "--output", "s.txt"], "s.txt"),
        (["--parameter", "tower.mass", "--result", "surge", "--discard", "20"], "the run is shorter"),
    ],
)
def test_a_mistake_is_one_sentence(words, told, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([*RUN, *words]) == 2
    error = capsys.readouterr().err
    assert told in error and "Traceback" not in error


@pytest.mark.parametrize(
    ("growth", "said"),
    [(np.nan, "cannot be told from 1 s; take a longer run"), (np.inf, "cannot be told"),
     (-0.1, "from 0.5 s on the motion forgets its start: perturbations change by -0.1 1/s"),
     (0.2, "does not forget its start")],
)  # fmt: skip
def test_the_memory_of_a_motion_is_told_where_it_is_known(growth, said):
    assert said in _memory(SimpleNamespace(time=np.array([0.0, 0.5, 1.0]), growth=growth))
