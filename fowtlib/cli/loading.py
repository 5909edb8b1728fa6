"""The MODEL argument, and what the command line changes in a model before it is used."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli.weather import weather
from fowtlib.language import leave
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.modelfile.short_forms import WAVES, WIND, Condition, settings

if TYPE_CHECKING:
    from fowtlib import Model
    from fowtlib.cases import CaseSet

CONSTANT_WIND = ("none", "steady", "nwp", "ewm_steady", "input")


def declare(parser: argparse.ArgumentParser, *, wind: bool = True, waves: bool = True, runs: bool = True) -> None:
    """Add MODEL, `--set`, what the model file may, and where wanted `--wind` and `--waves`; runs: `--trust`."""
    parser.add_argument("model", metavar="MODEL", help="a shipped model (see `fowt models`) or a model file")
    if wind:
        kinds = f"{WIND.usage}\nin m, s and deg; class A, B or C" if waves else "none\n" + WIND.form("steady")
        parser.add_argument("--wind", metavar="WIND", help=kinds)
    if waves:
        parser.add_argument("--waves", metavar="WAVES", help=f"{WAVES.usage}\nin m, s and deg")
    parser.add_argument(
        "--set",
        dest="settings",
        metavar="PATH=VALUE",
        action="append",
        default=[],
        help="set a parameter, for example --set platform.hull.mass='7500 t'; may be repeated",
    )
    declare_leave(parser, runs)


def declare_leave(parser: argparse.ArgumentParser, runs: bool = True) -> None:
    """Add what the model file may do; runs: also `--trust`."""
    parser.add_argument(
        "--allow-python", action="store_true", help="run the Python files that the model file names (`python:`)"
    )
    parser.add_argument(
        "--allow", metavar="FOLDER", type=Path, action="append", default=[],
        help="let the model file read data in this folder, now and later; may be repeated",
    )  # fmt: skip
    if runs:
        parser.add_argument(
            "--trust", action="store_true",
            help="run the native code (controller library, FMU) that the model file names, now and until it changes",
        )  # fmt: skip


def load(arguments: argparse.Namespace) -> Model:
    """The model with the conditions and parameters of the command line."""
    model = load_file(arguments, arguments.model)
    values: dict[str, Any] = {}
    options: dict[str, str] = {}
    for condition, text in ((WIND, getattr(arguments, "wind", None)), (WAVES, getattr(arguments, "waves", None))):
        if text is not None:
            _require_part(model, condition)
            chosen = condition.parse(text)
            values |= chosen
            options |= dict.fromkeys(chosen, condition.option)
    chosen = settings(arguments.settings)
    for path in chosen:
        if path in values:
            raise ParameterError(f"{options[path]} gives {path} already, and so does --set; leave one of them out.")
    values |= chosen
    options |= dict.fromkeys(chosen, "--set")
    arguments.options = options  # which option gave which parameter, for messages
    model = model.with_parameters(values) if values else model
    if getattr(arguments, "trust", False):
        for path in leave.give_native(model.root):
            print(f"{path}: leave to run this native code is kept in {leave.leave_file()}.", file=sys.stderr)
    return model


def load_file(arguments: argparse.Namespace, name: str) -> Model:
    """The model of a name or file, with the leave that the command line gives."""
    import fowtlib as fw

    for folder in getattr(arguments, "allow", ()):
        from fowtlib.modelfile.files import find_model

        leave.give_folder(folder, find_model(name))
    trust = getattr(arguments, "trust", False)
    return fw.load(name, allow_python=arguments.allow_python, trust=trust)


def read_cases(arguments: argparse.Namespace, path: Path) -> CaseSet:
    """The cases of a file, with the leave that the command line gives."""
    import fowtlib as fw

    for folder in getattr(arguments, "allow", ()):
        leave.give_folder(folder, path)
    return fw.read_cases(path)


def message(error: ModelError, arguments: argparse.Namespace) -> str:
    """What the error says, with the option that a value came from where it says `set: wind.file: ...`."""
    text = str(error)
    about = text.removeprefix("set: ")
    options: Mapping[str, str] = getattr(arguments, "options", {})
    if about == text or not options:
        return text
    named = [path for path in options if re.match(rf"{re.escape(path)}\b", about)]
    return f"{options[max(named, key=len)] if named else '--set'}: {about}"


def load_at_rest(arguments: argparse.Namespace) -> tuple[Model, str]:
    """The same in the mean of its wind and waves, for what is asked about a mean position; and a line that says so."""
    model = load(arguments)
    if arguments.wind and model.root.parts[WIND.part].kind not in CONSTANT_WIND:
        kind = model.root.parts[WIND.part].kind
        raise ParameterError(f"--wind: '{kind}' changes in time; give none or {WIND.form('steady')} here.")
    calm = model.in_the_mean()
    return calm, weather(calm, arguments, model)


def _require_part(model: Model, condition: Condition) -> None:
    if condition.part not in model.root.parts:
        raise ParameterError(
            f"{condition.option}: this model has no part '{condition.part}' whose parameters could be set; "
            "use --set with the paths of its own parameters (see `fowt parameters`)."
        )
