"""What a model file may: run native code with leave only, and read where the user lets it."""

from __future__ import annotations

import copy
import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.language import leave
from fowtlib.language.errors import ModelError, ModelFileError, ParameterError
from fowtlib.language.native import compiler

posix = pytest.mark.skipif(sys.platform == "win32", reason="links, pipes and modes of files")
needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")

LAND = """fowtlib: 1
title: a turbine on land
world: {{class: World}}
wind: {{class: Wind, kind: steady, mean_speed: 9 m/s}}
parts:
  top: {{class: FixedTranslation, r: [-5, 0, 90]}}
  anemometer: {{class: Demux, n: 1}}
  turbine:
    use: turbines/nrel5mw_rigid
    rotor_speed_start: 10.3 rpm
    blade_pitch_start: 2 deg
    parts:
      control: {{class: BladedController, file: "{library}", torque_start: 25 kN*m}}
connect:
  - [world.frame, top.frame_a]
  - [top.frame_b, turbine.frame]
  - [wind.speed, anemometer.u]
  - ["anemometer.y[0]", turbine.control.wind_speed]
  - [turbine.rotor_speed, turbine.control.rotor_speed]
outputs: {{pitch: turbine.blade_pitch}}
simulation: {{duration: 0.1 s, output_step: 0.05 s}}
"""
SERIES = "t,u\n0,10\n10,11\n20,10\n100,11\n"
SECRET = "root:x:0:0:the secret of another\n"


@pytest.fixture(autouse=True)
def settings(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    monkeypatch.setenv("APPDATA", str(tmp_path / "settings"))
    monkeypatch.delenv("FOWTLIB_DATA_PATH", raising=False)
    return tmp_path / "settings" / "fowtlib" / "trusted.jsonl"


@pytest.fixture
def folder(tmp_path):
    """That of the model file."""
    made = tmp_path / "model"
    made.mkdir()
    return made


def build_library(target: Path, mark: Path, more: str = "") -> Path:
    """A controller library that leaves a mark when it is loaded."""
    source = target.with_suffix(".c")
    source.write_text(f"""
#include <stdio.h>
__attribute__((constructor)) static void loaded(void) {{ fclose(fopen("{mark}", "w")); }}
void DISCON(float *swap, int *fail, char *a, char *b, char *message) {{
    *fail = 0;
    message[0] = 0;
    swap[34] = 1;
    swap[46] = 25e3f;
    swap[41] = swap[42] = swap[43] = swap[44] = 0.035f;
}}
{more}
""")
    subprocess.run([*compiler(), "-fPIC", "-shared", str(source), "-o", str(target)], check=True)
    return target


@pytest.fixture
def land(folder, tmp_path):
    """A model file that names native code beside it."""
    build_library(folder / f"libmine{SUFFIX}", tmp_path / "mark")
    path = folder / "land.yaml"
    path.write_text(LAND.format(library=f"libmine{SUFFIX}"))
    return path


# --- native code ---------------------------------------------------------------------------------------------------


@needs_compiler
@pytest.mark.parametrize("command", ["check", "tree", "parameters", "equations"])
def test_looking_at_a_model_loads_no_native_code(land, tmp_path, capsys, command):
    assert main([command, str(land)]) == 0
    assert not (tmp_path / "mark").exists()


@needs_compiler
def test_a_run_needs_leave_which_is_kept_until_the_file_changes(land, tmp_path, settings, capsys):
    mark, library = tmp_path / "mark", land.parent / f"libmine{SUFFIX}"
    assert main(["run", str(land)]) == 2
    said = capsys.readouterr().err
    assert "land.yaml:13: turbine.control.file names native code, " in said
    assert f"{library} (sha256 " in said
    assert "add --trust once, or load the model with fw.load(..., trust=True)." in said
    assert not mark.exists()

    assert main(["run", str(land), "--trust"]) == 0
    assert f"leave to run this native code is kept in {settings}" in capsys.readouterr().err
    assert mark.exists()
    (line,) = settings.read_text().splitlines()
    assert json.loads(line)["path"] == str(library)

    mark.unlink()
    assert main(["run", str(land)]) == 0
    assert mark.exists()

    mark.unlink()
    build_library(library, mark, "int another;")
    assert main(["run", str(land)]) == 2
    assert "which has changed since it got leave" in capsys.readouterr().err
    assert not mark.exists()


@needs_compiler
def test_in_python_it_is_an_argument(land, tmp_path, settings):
    mark = tmp_path / "mark"
    plant = fw.load(land).compile()
    for stated in (plant, copy.copy(plant)):
        with pytest.raises(ModelError, match=r"land\.yaml:13: turbine\.control\.file names native code"):
            stated.simulate(0.1, 0.05)
    changed = fw.load(land).with_parameters({"wind.mean_speed": 8.0}).compile()
    with pytest.raises(ModelError, match="names native code"):
        changed.simulate(0.1, 0.05)
    assert not mark.exists()
    assert fw.load(land, trust=True).with_parameters({"wind.mean_speed": 8.0}).compile().simulate(0.1, 0.05)
    assert mark.exists() and not settings.exists()


@needs_compiler
def test_a_path_that_the_user_gives_is_leave(land, tmp_path, settings):
    mine = build_library(tmp_path / f"libother{SUFFIX}", tmp_path / "other_mark")
    path = "turbine.control.file"
    assert fw.load(land, set={path: str(mine)}).compile().simulate(0.1, 0.05)
    assert main(["run", str(land), "--set", f"{path}={mine}"]) == 0
    assert (tmp_path / "other_mark").exists() and not (tmp_path / "mark").exists()
    assert not settings.exists()


@needs_compiler
@pytest.mark.parametrize("elsewhere", ["../out", "{tmp}/out"])
def test_native_code_elsewhere_needs_no_second_leave(land, tmp_path, elsewhere):
    (tmp_path / "out").mkdir()
    build_library(tmp_path / "out" / f"libout{SUFFIX}", tmp_path / "mark")
    land.write_text(LAND.format(library=f"{elsewhere.format(tmp=tmp_path)}/libout{SUFFIX}"))
    with pytest.raises(ModelFileError, match="is refused: it lies outside of the folder of the model file"):
        fw.load(land)
    assert main(["run", str(land), "--trust"]) == 0
    assert fw.load(land).compile().simulate(0.1, 0.05)


@needs_compiler
def test_an_fmu_is_asked_for_too(folder, tmp_path):
    plain = fw.components.fmu.FMU.parameters["file"]
    assert plain.native
    (folder / "unit.fmu").write_text("no archive")
    (folder / "m.yaml").write_text("fowtlib: 1\nunit: {class: FMU, file: unit.fmu}\n")
    with pytest.raises(ModelFileError, match="zip archive"):
        fw.load(folder / "m.yaml")


@posix
def test_leave_that_others_could_have_written_does_not_count(folder, settings):
    settings.parent.mkdir(parents=True)
    settings.write_text(json.dumps({"leave": "folder", "path": "/", "model": str(folder / "m.yaml")}) + "\n")
    settings.chmod(0o600)
    assert leave.folders_of(folder / "m.yaml") == [Path("/")]
    settings.chmod(0o666)
    with pytest.warns(UserWarning, match="can be written by others; the leave in it does not count"):
        assert leave.folders_of(folder / "m.yaml") == []
    with pytest.warns(UserWarning), pytest.raises(ModelError, match="leave cannot be kept in it"):
        leave.give_folder(folder, folder / "m.yaml")


@pytest.mark.parametrize("line", ["{", "[1]", '"text"', "\x00", "[" * 5000])
def test_a_damaged_line_is_no_leave_and_costs_no_other(folder, settings, line):
    leave.give_folder(folder, folder / "m.yaml")
    with settings.open("a") as file:
        file.write(f"{line}\n")
    with pytest.warns(UserWarning, match=r"trusted\.jsonl:2: this line is damaged"):
        assert leave.folders_of(folder / "m.yaml") == [folder.resolve()]


@posix
@pytest.mark.parametrize("value", ["", ".", "some/where"])
def test_a_relative_folder_of_settings_is_not_followed(monkeypatch, tmp_path, value):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", value)
    assert leave.leave_file().is_absolute()
    assert not leave.leave_file().is_relative_to(tmp_path)


# --- data ----------------------------------------------------------------------------------------------------------


def wind_of(folder: Path, file: str) -> Path:
    path = folder / "m.yaml"
    path.write_text(f"fowtlib: 1\ntitle: wind\nwind: {{class: Wind, kind: file, file: {json.dumps(file)}}}\n")
    return path


@pytest.fixture
def elsewhere(tmp_path):
    made = tmp_path / "elsewhere"
    made.mkdir()
    (made / "wind.csv").write_text(SECRET)
    return made


@pytest.mark.parametrize("name", ["wind.csv", "below/wind.csv", "./below/../wind.csv", "{folder}/below/wind.csv"])
def test_beside_and_below_is_allowed(folder, name):
    (folder / "below").mkdir()
    for place in (folder, folder / "below"):
        (place / "wind.csv").write_text(SERIES)
    name = name.format(folder=folder)
    assert fw.load(wind_of(folder, name)).root.wind.file == str((folder / name).resolve())


@pytest.mark.parametrize(
    "name",
    [
        "../elsewhere/wind.csv", "{tmp}/elsewhere/wind.csv", "below/../../elsewhere/wind.csv", "/etc/passwd",
        "~/.ssh/id_rsa", "../elsewhere/absent.csv", "../model_2/wind.csv",
        pytest.param("link.csv", marks=posix), pytest.param("linked/wind.csv", marks=posix),
    ],
)  # fmt: skip
def test_elsewhere_is_refused_and_not_quoted(folder, tmp_path, elsewhere, name):
    (folder / "below").mkdir()
    if sys.platform != "win32":
        (folder / "link.csv").symlink_to(elsewhere / "wind.csv")
        (folder / "linked").symlink_to(elsewhere)
    name = name.format(tmp=tmp_path)
    with pytest.raises(ModelFileError) as caught:
        fw.load(wind_of(folder, name))
    said = str(caught.value)
    assert f"m.yaml:3: wind.file: '{name}' is refused: it lies outside of the folder of the model file." in said
    assert "--allow " in said and "fw.load(..., allow=[" in said
    assert "secret" not in said and "did you mean" not in said


def test_the_user_allows_a_folder_for_one_model(folder, tmp_path, elsewhere, settings, monkeypatch, capsys):
    (elsewhere / "wind.csv").write_text(SERIES)
    path = wind_of(folder, "../elsewhere/wind.csv")
    for allow in (elsewhere, [str(elsewhere)], [tmp_path]):
        assert fw.load(path, allow=allow).root.wind.file == str(elsewhere / "wind.csv")
    again = fw.load(path, allow=elsewhere).with_parameters({"wind.shear_exponent": 0.1})
    assert again.root.wind.file == str(elsewhere / "wind.csv")
    monkeypatch.setenv("FOWTLIB_DATA_PATH", f"{folder}{os.pathsep}{elsewhere}")
    assert fw.load(path).root.wind.file
    monkeypatch.delenv("FOWTLIB_DATA_PATH")
    assert main(["tree", str(path)]) == 2
    assert f"--allow {elsewhere}" in capsys.readouterr().err
    assert main(["tree", str(path), "--allow", str(elsewhere)]) == 0
    assert main(["tree", str(path)]) == 0
    assert fw.load(path).root.wind.file
    other = folder / "other.yaml"
    other.write_text(path.read_text())
    with pytest.raises(ModelFileError, match="is refused"):
        fw.load(other)
    assert len(settings.read_text().splitlines()) == 1


def test_what_the_user_names_is_allowed_by_that(folder, elsewhere, monkeypatch):
    (elsewhere / "wind.csv").write_text(SERIES)
    (folder / "own.csv").write_text(SERIES)
    path = wind_of(folder, "own.csv")
    named = str(elsewhere / "wind.csv")
    assert fw.load(path, set={"wind.file": named}).root.wind.file == named
    assert fw.load(path).with_parameters({"wind.file": named}).root.wind.file == named
    assert main(["parameters", str(path), "--wind", f"file:{named}"]) == 0
    monkeypatch.chdir(elsewhere)
    assert main(["tree", str(path), "--set", "wind.file=wind.csv"]) == 0


def test_what_is_no_folder_cannot_be_allowed(folder, monkeypatch):
    path = wind_of(folder, "own.csv")
    with pytest.raises(ModelFileError, match="there is no folder 'nowhere'"):
        fw.load(path, allow=["nowhere"])
    with pytest.raises(ParameterError, match="there is no folder 'nowhere'"):
        leave.give_folder(Path("nowhere"), path)
    monkeypatch.setenv("FOWTLIB_DATA_PATH", "here")
    with pytest.raises(ModelFileError, match="FOWTLIB_DATA_PATH: 'here' is not an absolute path"):
        fw.load(path)


@pytest.mark.parametrize("use", ["../elsewhere/part", "{tmp}/elsewhere/part", "below/../../elsewhere/part"])
def test_definitions_are_files_too(folder, tmp_path, elsewhere, use):
    (folder / "below").mkdir()
    (elsewhere / "part.yaml").write_text("secret: {of: another}\n")
    path = folder / "m.yaml"
    path.write_text(f"fowtlib: 1\npart: {{use: {use.format(tmp=tmp_path)}}}\n")
    with pytest.raises(ModelFileError, match=r"m\.yaml:2: part: '.*' is refused: it lies outside") as caught:
        fw.load(path)
    assert "secret" not in str(caught.value)


def test_shipped_data_does_not_lead_out(folder):
    for name in ("data:../../pyproject.toml", "data:../../../../../../etc/passwd"):
        with pytest.raises(ModelFileError, match="there is no shipped data file"):
            fw.load(wind_of(folder, name))


@posix
@pytest.mark.parametrize("kind", ["a pipe", "a socket", "a device", "a folder", "not stored"])
@pytest.mark.parametrize("given", ["in the file", "by the user"])
def test_what_is_no_file_of_data_is_never_opened(folder, monkeypatch, kind, given):
    path = folder / "thing"
    if kind == "a pipe":
        os.mkfifo(path)
    elif kind == "a socket":
        with socket.socket(socket.AF_UNIX) as opened:
            monkeypatch.chdir(folder)  # the path of a socket must be short
            opened.bind("thing")
    elif kind == "a folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero" if kind == "a device" else "/proc/self/environ")
    allow = ["/dev", "/proc"]
    if given == "in the file":
        with pytest.raises(ModelFileError, match=f"wind.file: '.*' is {kind}.*; a file .*is expected"):
            fw.load(wind_of(folder, "thing"), allow=allow)
    else:
        (folder / "own.csv").write_text(SERIES)
        model = wind_of(folder, "own.csv")
        with pytest.raises(ModelError, match=f"'.*' is {kind}.*; a file .*is expected"):
            fw.load(model, set={"wind.file": str(path)})


@posix
@pytest.mark.parametrize("name", ["/dev/zero", "/proc/self/environ", "/sys/kernel/notes"])
def test_readers_refuse_them_too(name):
    from fowtlib.components.mechanics import read_beam

    if not Path(name).exists():
        pytest.skip(f"there is no {name} here")
    with pytest.raises(ParameterError, match=f"'{name}' is .*; a file of data is expected"):
        read_beam(name)
