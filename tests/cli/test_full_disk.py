"""A disk that is full at the end of a run: the results lie somewhere else, and the journal stays."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from fowtlib.cli.app import main
from fowtlib.solving.results import files
from fowtlib.solving.results.result import Result

pytestmark = pytest.mark.usefixtures("shipped_pendulum")
RUN = ["run", "pendulum", "--time", "4"]
RAMP = """fowtlib: 1
parts: {c: {class: Constant, value: 1}, i: {class: Integrator}}
connect: [[c.y, i.u]]
outputs: {y: i.y}
"""


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A temporary folder of the test's own, and a folder of work."""
    (tmp_path / "tmp").mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)
    return tmp_path / "tmp"


def full(monkeypatch, of: str, number: int = 28):
    """Writing a result fails in folders whose path holds `of`."""
    write = files.write_netcdf

    def failing(path, *arguments, **options):
        if of in str(path):
            raise OSError(number, os.strerror(number))
        return write(path, *arguments, **options)

    monkeypatch.setattr(files, "write_netcdf", failing)


@pytest.mark.parametrize("number", [28, 27, 122, 5, 30], ids=os.strerror)
def test_the_results_go_to_the_temporary_folder(capsys, monkeypatch, elsewhere, number):
    full(monkeypatch, "/work/", number)
    assert main([*RUN, "--output", "run.nc"]) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith(f"fowt run: run.nc: cannot be written: {os.strerror(number)}.\nThe results are saved")
    place = Path(re.search(r"saved in (\S+) instead", shown.err)[1])
    assert place.parent.parent == elsewhere and place.stat().st_size and "0 s to 4 s" in shown.out
    assert Result.open(place).time[-1] == 4.0
    assert not Path("run.nc").exists() and not [name for name in os.listdir() if name.startswith(".")]


def test_the_journal_stays_where_no_other_place_is(capsys, monkeypatch, elsewhere):
    assert main([*RUN[:-1], "20", "--output", "whole.nc"]) == 0
    with monkeypatch.context() as patch:
        full(patch, "")
        assert main([*RUN[:-1], "20", "--output", "run.nc"]) == 2
    said = capsys.readouterr().err
    assert f"cannot be saved in the temporary folder either ({elsewhere})" in said
    assert "kept in run.nc.part; to go on from there: --resume run.nc.part" in said
    assert os.listdir(elsewhere) == []
    assert main([*RUN[:-1], "20", "--resume", "run.nc.part", "--output", "run.nc"]) == 0
    np.testing.assert_array_equal(*(Result.open(name).array("pitch") for name in ("run.nc", "whole.nc")))
    assert sorted(os.listdir()) == ["run.nc", "whole.nc"]


def test_a_run_that_failed_keeps_its_results_too(capsys, monkeypatch, elsewhere):
    def report(t, t_end):
        if t > 2:
            raise KeyboardInterrupt

    class Bar:
        def __enter__(self):
            return report

        def __exit__(self, *_):
            return None

    monkeypatch.setattr("fowtlib.cli.run.progress_bar", lambda begin: Bar())
    full(monkeypatch, "/work/")
    assert main([*RUN, "--output", "run.nc"]) == 130
    said = capsys.readouterr().err
    assert "interrupted at t = " in said and "run.nc: cannot be written: No space left on device." in said
    assert Result.open(re.search(r"saved in (\S+) instead", said)[1]).time[-1] > 2


def test_what_was_there_stays(capsys, monkeypatch, elsewhere):
    assert main([*RUN, "--output", "run.nc"]) == 0
    before = Path("run.nc").read_bytes()
    full(monkeypatch, "/work/")
    assert main([*RUN, "--output", "run.nc", "--force"]) == 2
    assert Path("run.nc").read_bytes() == before


@pytest.mark.skipif(sys.platform == "win32", reason="a limit of Unix")
@pytest.mark.parametrize("ending", ["nc", "csv", "outb"])
def test_a_limit_of_the_size_of_files_ends_in_a_sentence(tmp_path, ending):
    import resource

    (tmp_path / "ramp.yaml").write_text(RAMP)
    (tmp_path / "tmp").mkdir()
    words = ["run", "ramp.yaml", "--solver", "idas", "--time", "800", "--output-step", "0.1", "--output"]
    run = subprocess.run(
        [sys.executable, "-m", "fowtlib.cli", *words, f"run.{ending}"], cwd=tmp_path, capture_output=True, text=True,
        timeout=200, env=os.environ | {"TMPDIR": str(tmp_path / "tmp")},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192)),
    )  # fmt: skip
    assert run.returncode == 2, run.stderr
    assert f"run.{ending}: cannot be written: File too large." in run.stderr
    assert "cannot be saved in the temporary folder either" in run.stderr
    assert "Traceback" not in run.stderr and "ignored" not in run.stderr
    assert "real time" in run.stdout and list((tmp_path / "tmp").iterdir()) == []
    assert not [path.name for path in tmp_path.iterdir() if path.name not in ("tmp", "ramp.yaml")]


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="the system cannot reserve room for a file")
def test_a_wind_field_without_room_is_a_sentence_and_no_signal(tmp_path):
    import resource

    words = ["wind-field", "hub.bts", "--speed", "10", "--width", "100", "--height", "100", "--time", "60"]
    run = subprocess.run(
        [sys.executable, "-m", "fowtlib.cli", *words], cwd=tmp_path, capture_output=True, text=True, timeout=200,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536)),
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (2, "fowt wind-field: hub.bts: cannot be written: File too large.\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="mounts a file system")
@pytest.mark.parametrize(
    ("words", "size", "status"),
    [
        ("run ramp.yaml --time 8000 --output-step 0.1 --output disk/run.nc", 1 << 20, 2),
        ("run ramp.yaml --time 8000 --output-step 0.1 --output disk/run.csv", 1 << 19, 2),
        ("run ramp.yaml --time 10 --plot disk/run.png", 8192, 2),
        ("wind-field disk/hub.bts --speed 10 --width 100 --height 100 --time 60", 1 << 18, 2),
        ("parameters oc3_spar_rigid -o disk/table.csv", 4096, 2),
        ("view oc3_spar_rigid -o disk/page.html", 16384, 2),
    ],
)  # fmt: skip
def test_a_full_disk_ends_in_a_sentence(tmp_path, words, size, status):
    (tmp_path / "ramp.yaml").write_text(RAMP)
    (disk := tmp_path / "disk").mkdir()
    (tmp_path / "tmp").mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)]
    if subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        run = subprocess.run(
            [sys.executable, "-m", "fowtlib.cli", *words.split()], cwd=tmp_path, capture_output=True, text=True,
            timeout=200, env=os.environ | {"TMPDIR": str(tmp_path / "tmp")},
        )  # fmt: skip
        left = [path.name for path in disk.iterdir()]
    finally:
        subprocess.run(["umount", str(disk)], check=True)
    assert run.returncode == status, run.stderr
    assert "cannot be written: No space left on device." in run.stderr and "Traceback" not in run.stderr
    assert "ignored" not in run.stderr and not left
    if "--output " in words:
        place = re.search(r"saved in (\S+) instead", run.stderr)[1]
        assert Result.open(place).time[-1] == 8000.0
