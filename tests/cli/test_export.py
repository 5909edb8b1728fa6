"""`fowt export` writes an FMU and says what is wrong with its arguments."""

from __future__ import annotations

import zipfile

import pytest

from fowtlib.cli import main
from fowtlib.language.native import compiler

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")


def test_export_writes_an_archive(shipped_pendulum, capsys):
    assert main(["export", "pendulum", "--fmi", "2", "--kind", "cs", "--step", "5ms"]) == 0
    assert capsys.readouterr().err == "saved pendulum.fmu\n"
    with zipfile.ZipFile("pendulum.fmu") as archive:
        text = archive.read("modelDescription.xml").decode()
    assert '<CoSimulation modelIdentifier="pendulum"' in text
    assert "<ModelExchange" not in text
    assert 'name="solver.step"' in text and 'start="0.005"' in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--fmi", "1"], "fowt export: there is no FMI version '1'; there are '2' and '3'.\n"),
        (["--kind", "all"], "fowt export: there is no kind of FMU 'all'; there are 'me', 'cs' and 'both'.\n"),
        (["-o", "x.zip"], "fowt export: x.zip: the file must end in '.fmu'.\n"),
        (["--platforms", "linux64,win32"], "fowt export: there is no platform 'win32'; did you mean 'win64'?\n"),
        (["--step", "0"], "fowt export: the step of the engine is 0 s; it must be above zero, usually 0.01 s.\n"),
    ],
)
def test_wrong_arguments_are_named(shipped_pendulum, capsys, tmp_path, words, message):
    assert main(["export", "pendulum", *words]) == 2
    assert capsys.readouterr().err == message
    assert not list(tmp_path.iterdir())


def test_a_signal_that_is_not_there(shipped_pendulum, capsys):
    assert main(["export", "pendulum", "--input", "hinge.torque"]) == 2
    assert capsys.readouterr().err == "fowt export: there is no signal 'hinge.torque'.\n"
