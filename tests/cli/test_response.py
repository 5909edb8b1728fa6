"""`fowt response` on the command line."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from fowtlib.cli.app import main


def test_response_prints_statistics_and_saves_spectra(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    spectra, picture = tmp_path / "spectra.csv", tmp_path / "spectra.png"
    asked = ["response", "oc3_spar_rigid", "--wind", "none", "--waves", "jonswap:Hs=4,Tp=10", "--outputs", "heave,yaw"]
    assert main([*asked, "--json", "--spectra", str(spectra), "--plot", str(picture)]) == 0
    rows = {row["result"]: row for row in json.loads(capsys.readouterr().out.partition("]\n")[0] + "]")}
    heave = rows["heave [m]"]
    assert heave["largest"] - heave["mean"] == pytest.approx(heave["mean"] - heave["smallest"])
    assert 3 * heave["std"] < heave["largest"] - heave["mean"] < 5 * heave["std"]
    assert picture.stat().st_size > 10_000
    with spectra.open() as file:
        table = list(csv.reader(file))
    assert table[0] == ["frequency [Hz]", "heave [(m)^2/Hz]", "yaw [(deg)^2/Hz]"]
    assert len(table) > 200


def test_mistakes_of_response(capsys: pytest.CaptureFixture[str]):
    assert main(["response", "oc3_spar_rigid", "--outputs", "heavy"]) == 2
    assert "the model has no result 'heavy'; did you mean 'heave'?" in capsys.readouterr().err
    assert main(["response", "oc3_spar_rigid", "--wind", "none", "--waves", "still"]) == 2
    assert "takes anything from random waves or wind" in capsys.readouterr().err
