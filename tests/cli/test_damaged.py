"""Damaged results: refused by name by every command, and shown as far as they are sound when asked."""

from __future__ import annotations

from pathlib import Path

import pytest
from scipy.io import netcdf_file

from fowtlib.cli.app import main

pytestmark = pytest.mark.usefixtures("shipped_pendulum")


@pytest.fixture
def damage(capsys):
    """A result of which a variable can be damaged."""
    assert main(["run", "pendulum", "--time", "2", "--output", "run.nc"]) == 0
    capsys.readouterr()

    def turn(name: str) -> None:
        with netcdf_file("run.nc", "r", mmap=False) as file:
            numbers = file.variables[name].data.tobytes()
        data = bytearray(Path("run.nc").read_bytes())
        data[data.index(numbers) + len(numbers) // 2] ^= 4
        Path("run.nc").write_bytes(data)

    return turn


@pytest.mark.parametrize("name", ["pitch", "raw_x", "checkpoint"])
@pytest.mark.parametrize(
    "words",
    [
        "view pendulum --result run.nc",
        "run pendulum --time 3 --resume run.nc --output next.nc",
        "run pendulum --time 3 --start run.nc",
    ],
)
def test_no_command_believes_a_damaged_result(capsys, damage, name, words):
    damage(name)
    assert main(words.split()) == 2
    said = capsys.readouterr().err
    assert f"run.nc: the file is damaged: the numbers or the attributes of {name} are not those that were" in said
    assert not Path("next.nc").exists() and not Path("run.html").exists()


def test_what_is_sound_is_shown_when_asked(capsys, damage):
    damage("pitch")
    assert main(["view", "pendulum", "--result", "run.nc", "--damaged"]) == 0
    assert "run.nc: the file is damaged; read without pitch." in capsys.readouterr().err
    assert Path("run.html").exists()
    damage("raw_x")
    assert main(["view", "pendulum", "--result", "run.nc", "--damaged"]) == 2
    assert "the file holds no states" in capsys.readouterr().err


def test_a_model_is_not_damaged(capsys):
    assert main(["view", "pendulum", "--damaged"]) == 2
    assert "--damaged is for a result" in capsys.readouterr().err
