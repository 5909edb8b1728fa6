"""What the attack has found, each in the form it was found in and in two more."""

from __future__ import annotations

import struct
import sys

import numpy as np
import pytest

from fowtlib.cli import app
from fowtlib.components.environment.field_file import FieldGrid, read_field, write_field
from fowtlib.language import native
from fowtlib.language.errors import CompilerError, ModelError


def test_an_error_inside_leaves_a_report(tmp_path, monkeypatch, capsys):
    import tempfile

    import fowtlib

    (tmp_path / "model.yaml").write_text("fowtlib: 1\n")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(fowtlib, "load", lambda *_, **__: {}["no such thing"])
    assert app.main(["tree", str(tmp_path / "model.yaml")]) == 3
    report = next(tmp_path.glob("fowt_report_*.txt"))
    said, text = capsys.readouterr().err, report.read_text()
    assert str(report) in said and "Traceback" not in said
    digest = __import__("hashlib").sha256(b"fowtlib: 1\n").hexdigest()
    assert digest in text and "KeyError" in text and f"Python {sys.version.split()[0]}" in text and "send" in text


def test_a_report_that_cannot_be_written_hides_no_error(tmp_path, monkeypatch, capsys):
    import tempfile

    import fowtlib

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    monkeypatch.setattr(fowtlib, "load", lambda *_, **__: 1 / 0)
    assert app.main(["tree", "oc3_spar_rigid"]) == 3
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_no_memory_is_a_sentence(monkeypatch, capsys):
    import fowtlib

    monkeypatch.setattr(fowtlib, "load", lambda *_, **__: np.zeros(10**16))
    assert app.main(["tree", "oc3_spar_rigid"]) == 2
    assert "more memory than there is" in capsys.readouterr().err


@pytest.mark.parametrize("named", ['gcc "', "it's", "cc -D'x"])
def test_a_compiler_with_a_quote_is_refused(monkeypatch, named):
    monkeypatch.setenv("FOWTLIB_CC", named)
    with pytest.raises(CompilerError, match="FOWTLIB_CC"):
        native.compiler()


@pytest.mark.parametrize("slope", [1e-30, -1e-12, 1e-3])
def test_a_scale_that_makes_storms_of_everything_is_refused(tmp_path, slope):
    path = tmp_path / "field.bts"
    write_field(path, FieldGrid(2, 2, 4, 10.0, 10.0, 0.5, 10.0, 90.0, 60.0), np.full((4, 2, 2, 3), 10.0))
    content = bytearray(path.read_bytes())
    content[42:46] = struct.pack("<f", slope)  # of u
    path.write_bytes(content)
    with pytest.raises(ModelError, match="the scale of u is damaged"):
        read_field(path)


@pytest.mark.parametrize("letters", [240, 253, 400])
def test_long_names_of_outputs_are_refused_or_work(tmp_path, monkeypatch, capsys, letters):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ramp.yaml").write_text(
        "fowtlib: 1\nparts: {c: {class: Constant, value: 1}, i: {class: Integrator}}\nconnect: [[c.y, i.u]]\n"
        "outputs: {y: i.y}\n"
    )
    status = app.main(["run", "ramp.yaml", "--time", "1", "--output", "n" * letters + ".csv"])
    assert status in (0, 2), capsys.readouterr().err
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize("ending", [".nc", ".csv", ".outb"])
def test_damaged_results_are_refused(tmp_path, ending):
    from fowtlib.solving.results import Result

    path = tmp_path / f"result{ending}"
    about = {"fowtlib_version": "0", "date": "0"}
    Result([0.0, 1.0], {"surge": [1.0, 2.0]}, {"surge": "m"}, attributes=about).save(path)
    content = path.read_bytes()
    for damaged in (content[:9] + b"\xff\xfe\x80" + content[12:], content[: len(content) // 2], b"", b"\x00" * 64):
        path.write_bytes(damaged)
        try:
            Result.open(path)
        except ModelError as error:
            assert str(path) in str(error)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("wind.mean_speed", [1, 2], "mean_speed has shape 2, and one number is expected"),
        ("wind.stations", [1, 2, 3], r"stations: give \(y, z\) of each hub"),
        ("platform.hull.mass", [[1, 2], [3, 4]], "mass has shape 2 x 2, and one number is expected"),
    ],
)
def test_lists_in_the_place_of_numbers_are_refused_before_anything_is_computed_from_them(path, value, words):
    import fowtlib

    with pytest.raises(ModelError, match=words):
        fowtlib.load("oc3_spar_rigid", set={path: value}).compile()
