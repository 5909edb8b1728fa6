"""The program as a whole: commands, options, errors, exit status."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from fowtlib.cli import app
from fowtlib.cli.app import main
from fowtlib.language.errors import ParameterError


def refused(capsys: pytest.CaptureFixture[str], *argv: str) -> str:
    """The message on stderr of a call that argparse refuses."""
    with pytest.raises(SystemExit) as caught:
        main(argv)
    assert caught.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("number", ["0", "-1", "one"])
def test_a_mode_has_a_number_from_one_on(capsys, number):
    assert f"--mode: '{number}' is not the number of a mode (1, 2, ...)" in refused(
        capsys, "view", "oc3_spar_rigid", f"--mode={number}"
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--wind field:no.bts", "--wind: wind.file: there is no file"),
        ("--waves regular:H=-4,T=10", "--waves: sea.wave_height = -4 m is below its minimum 0 m"),  # found by compile()
        ("--set platform.hull.mass=-3", "--set: platform.hull.mass = -3 kg is below its minimum 0 kg"),
        ("--set platform.hull.mas=3", "--set: platform.hull: RigidBody has no parameter 'mas'; did you mean 'mass'?"),
        ("--wind steady:8 --set wind.mean=3", "--set: wind: SteadyWind has no parameter 'mean'; did you mean"),
        ("--wind steady:8 --set wind.mean_speed=9",
         "--wind gives wind.mean_speed already, and so does --set; leave one of them out."),
        ("--wind steady:-3 --set sea.seed=3", "--wind: wind.mean_speed = -3 m/s is below its minimum 0 m/s"),
    ],
)
def test_a_mistake_in_a_value_names_the_option_that_gave_it(capsys, tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    assert main(["check" if "--waves" in options else "run", "oc3_spar_rigid", *options.split()]) == 2
    shown = capsys.readouterr().err.partition(": ")[2]
    assert shown.startswith(message)


@pytest.mark.parametrize("command", ["tree", "equations", "parameters", "check"])
def test_the_first_line_of_an_answer_says_the_wind_and_the_waves(capsys, command):
    assert main([command, "oc3_spar_rigid", "--wind", "steady:8"]) == 0
    first, second = capsys.readouterr().out.splitlines()[:2]
    assert first == "wind steady:8 (given), waves jonswap:Hs=6,Tp=10,seed=1 (the model's)"
    assert not second.startswith("wind ")


def test_the_parts_of_a_model_for_machines(capsys, tmp_path):
    file = tmp_path / "parts.csv"
    assert main(["tree", "oc3_spar_rigid", "--waves", "still", "--json", "-o", str(file)]) == 0
    shown = capsys.readouterr()
    assert {"part": "sea", "class": "StillSea"} in json.loads(shown.out)
    assert {"part": "platform.water.radiation", "class": "Radiation"} in json.loads(shown.out)
    assert "waves still (given)" in shown.err and file.read_text().startswith("part,class\nworld,World\n")


def test_help_lists_every_command(capsys):
    assert main([]) == 2
    text = capsys.readouterr().out
    _, commands = app.parser()
    assert all(f"\n    {name.split()[0]}" in text for name in commands) and "batch run" in commands


@pytest.mark.parametrize("command", sorted(set(app.parser()[1]) - {"models"}))
def test_the_help_of_a_command_says_what_it_does_and_gives_an_example(capsys, monkeypatch, command):
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as caught:
        main([*command.split(), "--help"])
    assert caught.value.code == 0
    text = capsys.readouterr().out
    assert f"\n  fowt {command} " in text.partition("\nexamples:")[2]
    assert all(len(line) <= 80 for line in text.partition("\nexamples:")[0].splitlines())


def test_help_fits_in_80_columns(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    for name, command in app.parser()[1].items():
        assert not [line for line in command.format_help().splitlines() if len(line) > 80], name


def test_methods_of_optimise_are_those_of_the_library():
    from fowtlib.cli.optimise import METHODS
    from fowtlib.design import optimisers

    assert set(METHODS) == set(optimisers.METHODS)
    method = next(action for action in app.parser()[1]["optimise"]._actions if action.dest == "method")
    assert all(name in method.help for name in METHODS)


def test_a_new_model_has_a_name(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main(["new", ""]) == 2
    assert capsys.readouterr().err == "fowt new: '' is not a name; write, for example, fowt new my_spar.\n"
    assert main(["new", "spar_1.5"]) == 0
    assert capsys.readouterr().err == "saved spar_1.5.yaml\n"


def test_the_version_is_the_installed_one(capsys):
    from importlib.metadata import version

    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"fowt {version('fowtlib')}\n"


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["rnu"], "fowt: unknown command 'rnu'; did you mean 'run'?\nSee fowt --help\n"),
        (["run", "a", "--tme", "3"], "fowt run: unknown option '--tme'; did you mean '--time'?\nSee fowt run --help\n"),
        (["run", "a", "--xyz=3"], "fowt run: unknown option '--xyz'.\nSee fowt run --help\n"),
        (
            ["--json", "models"],
            "fowt models: the option '--json' belongs behind the command: fowt models ... --json\n"
            "See fowt models --help\n",
        ),
        (["tree", "a", "b"], "fowt tree: one argument too many: 'b'.\nSee fowt tree --help\n"),
        (
            ["run", "a", "--time", "-3"],
            "fowt run: argument --time: '-3' is not a positive number\nSee fowt run --help\n",
        ),
        (
            ["rao", "a", "--frequencies", "0.1:0.2"],
            "fowt rao: argument --frequencies: '0.1:0.2' is not first:last:step in Hz, for example 0.02:0.2:0.005\n"
            "See fowt rao --help\n",
        ),
        (
            ["sheet", "a", "--frequencies", "0:1:1e-9"],
            "fowt sheet: argument --frequencies: '0:1:1e-9' would be 1e+09 values; 100000 is the most, take a larger "
            "step\nSee fowt sheet --help\n",
        ),
        (
            ["tune", "a", "--winds", "nan"],
            "fowt tune: argument --winds: 'nan' is not first:last:step in m/s, for example 12:24:2\n"
            "See fowt tune --help\n",
        ),
        (  # a minus in front makes no option of it
            ["sheet", "a", "--frequencies", "-0.1:0.1:0.1"],
            "fowt sheet: argument --frequencies: '-0.1:0.1:0.1' is not first:last:step in Hz, for example "
            "0.02:0.2:0.005\nSee fowt sheet --help\n",
        ),
    ],
)
def test_a_mistake_on_the_command_line_is_named(capsys, argv, message):
    assert refused(capsys, *argv) == message


@pytest.fixture
def failing(monkeypatch):
    """Make `fowt tree` raise what the test says."""

    def arrange(error: BaseException) -> None:
        def action(arguments):
            raise error

        monkeypatch.setattr("fowtlib.cli.inspection.show_tree", action)

    return arrange


def test_a_mistake_in_a_model_ends_with_status_2_and_one_sentence(capsys, failing):
    failing(ParameterError("there is no such spar.", where="spar.yaml:3"))
    assert main(["tree", "spar.yaml"]) == 2
    assert capsys.readouterr() == ("", "fowt tree: spar.yaml:3: there is no such spar.\n")


def test_control_c_ends_with_status_130(capsys, failing):
    failing(KeyboardInterrupt())
    assert main(["tree", "spar.yaml"]) == 130
    assert capsys.readouterr().err == "fowt tree: stopped; nothing was saved.\n"


def test_an_error_of_the_program_says_how_to_find_it(capsys, failing):
    failing(ZeroDivisionError("float division by zero"))
    assert main(["tree", "spar.yaml"]) == 3
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "fowt tree: an error inside the program: ZeroDivisionError: float division by zero"
    assert said[1].startswith("A report for the makers of fowtlib, with how to send it: ")
    assert said[2:] == ["To see where it arose, add --traceback."]
    assert main(["tree", "spar.yaml", "--traceback"]) == 3
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_help_and_the_catalogue_need_no_plotting_and_no_solver():
    slow = ["matplotlib", "pandas", "xarray", "scipy", "networkx", "yaml", "fowtlib.solving", "fowtlib.flattening"]
    script = f"import sys; from fowtlib.cli import app; app.parser(); print([m for m in {slow} if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout == "[]\n"


def test_parts_shows_a_class_with_its_declarations(capsys):
    assert main(["parts", "Revolute"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("Revolute (mechanics)\n\nHinge:")
    assert " ".join(next(line for line in text.splitlines() if "phi_start" in line).split()) == (
        "parameter phi_start Scalar rad 0 initial angle"
    )


def test_parts_for_machines(capsys):
    assert main(["parts", "mechanics", "--json"]) == 0
    classes = {item["name"]: item for item in json.loads(capsys.readouterr().out)}
    assert {item["group"] for item in classes.values()} == {"mechanics"}
    assert "TwoFrames" not in classes  # partial: it has no equations
    assert main(["parts", "Revolute", "--csv"]) == 0
    assert "parameter,phi_start,Scalar,rad,0,initial angle" in capsys.readouterr().out.splitlines()


def test_an_unknown_part_is_named(capsys):
    assert main(["parts", "Revlute"]) == 2
    assert capsys.readouterr().err == "fowt parts: there is no part 'Revlute'; did you mean 'Revolute'?\n"


def test_the_schema_is_json(capsys):
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "fowtlib model file"
