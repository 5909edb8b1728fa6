"""`fowt view`: a model or a result in 3-D, in the browser."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading
from fowtlib.cli.files import RESULTS, check_target, in_place_of
from fowtlib.cli.run import positive
from fowtlib.cli.weather import weather
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib import Model
    from fowtlib.solving.results import Result

PAGES = (".html", ".htm")
EXAMPLES = """A result of a shipped model finds its model; with a model file of your own give
both: MODEL --result FILE.
The page needs no network: it may be sent by mail. An address may end in
#t=12.5&view=side&theme=dark&play.

examples:
  fowt view oc3_spar_rigid --open
  fowt view run.nc -o run.html
  fowt view my_spar.yaml --result run.nc
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("view", help="a model or a result in 3-D, as a page for the browser", epilog=EXAMPLES)
    loading.declare(parser)
    model = next(action for action in parser._actions if action.dest == "model")
    model.metavar, model.help = "MODEL|RESULT", "a shipped model, a model file, or a result (.nc)"
    parser.add_argument("--result", type=Path, metavar="FILE", help="play this result (.nc) of MODEL")
    parser.add_argument("--damaged", action="store_true", help="of a damaged result show what is sound")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="the page: .html; default: the model's name")
    parser.add_argument("--equilibrium", action="store_true", help="a model: at its mean position, not at its start")
    parser.add_argument(
        "--mode", type=_number_of_mode, metavar="N", help="a model: moving in the mode N of `fowt eigen`"
    )
    parser.add_argument("--rate", type=positive, metavar="N", help="moments per second; default: 10 or more")
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.set_defaults(action=view)


def _number_of_mode(text: str) -> int:
    """1, 2, ..., for argparse."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not the number of a mode (1, 2, ...)")
    return int(text)


def view(arguments: argparse.Namespace) -> int:
    """Write the page, say what is in it, and open it where wanted."""
    from fowtlib.view import view as draw

    check_target(arguments.output, PAGES, arguments.force)
    path: Path | None = arguments.result
    alone = path is None and Path(arguments.model).suffix in RESULTS
    if alone:
        path = Path(arguments.model)
    target = arguments.output or Path(f"{path.stem if path else Path(arguments.model).stem}.html")
    before = "" if arguments.output else in_place_of(target)
    options = {"path": target, "rate": arguments.rate, "show": arguments.open}
    if path is None:
        if arguments.damaged:
            raise ModelError("--damaged is for a result; a model has no checksums.")
        made = _of_model(arguments, options)
    else:
        given = [name for name in ("wind", "waves") if getattr(arguments, name)] + ["set"] * bool(arguments.settings)
        given += [name for name in ("equilibrium", "mode") if getattr(arguments, name)]
        if given:
            what = f"--{given[0]}"
            raise ModelError(f"{what} changes a model; a result is shown as it was computed.")
        model, result = _played(arguments, path, alone)
        _say(weather(model, arguments, whose="of the run"))
        made = draw(result, **options)
    print(f"saved {made}{before}", file=sys.stderr)
    return 0


def _of_model(arguments: argparse.Namespace, options: Mapping[str, Any]) -> Any:
    """The picture of a model at its start, at its mean position, or moving in one of its modes."""
    if arguments.equilibrium or arguments.mode:
        model, conditions = loading.load_at_rest(arguments)
    else:
        model = loading.load(arguments)
        conditions = weather(model, arguments)
    _say(conditions)
    from fowtlib.view import view as draw

    return draw(model, equilibrium=arguments.equilibrium, mode=arguments.mode, **options)


def _say(conditions: str) -> None:
    if conditions:
        print(conditions)


def _played(arguments: argparse.Namespace, path: Path, alone: bool) -> tuple[Model, Result]:
    """The result, with the model that it came from."""
    from fowtlib.modelfile.files import shipped_models
    from fowtlib.solving import Result

    if path.suffix == ".csv":
        raise ModelError(f"{path}: a CSV file holds the series only, not the states: save the run as .nc.")
    result = Result.open(path, damaged=arguments.damaged)
    if result.raw is None or not result.raw.time.size:
        raise ModelError(f"{path}: the file holds no states, from which positions could be found.")
    name = result.attributes["model"]
    if alone and name not in shipped_models():
        which = f"'{name}' is not a shipped model" if name else "it does not name its model"
        raise ModelError(f"{path}: {which}; give the model too: fowt view MODEL --result {path}")
    model = loading.load_file(arguments, name if alone else arguments.model)
    model = _as_it_was(model, result, path)
    result.attach_plant(model.compile())
    return model, result


def _as_it_was(model: Model, result: Result, path: Path) -> Model:
    """The model with the parameters of the run; an error that names the first one which cannot be set again."""
    from fowtlib.solving.structure import structural_values

    then, numbers = result.attributes["structure"], result.attributes["parameters"]
    now = structural_values(model.root)
    depths = sorted({key.count(".") for key in (*then, *numbers)})
    for depth, kinds in ((depth, kinds) for depth in depths for kinds in (True, False)):  # the leading ones first
        here = [key for key in (*then, *numbers) if key.count(".") == depth and _names_kind(model, key) == kinds]
        changed = [key for key in here if key in then and key in now and now[key] != then[key]]
        values = {key: then[key] for key in changed if " sha256:" not in str(then[key])}
        values |= {key: numbers[key] for key in here if key in numbers and _was_changed(model, key, numbers[key])}
        if values:
            model = model.with_parameters(values)
            now = structural_values(model.root)
    for key in sorted({*now, *then} if then else ()):
        if now.get(key, "absent") != then.get(key, "absent"):
            raise ModelError(
                f"{path}: the model of this result is another one: {key} was {then.get(key, 'absent')}, and is "
                f"{now.get(key, 'absent')}. Give the model that was run: fowt view MODEL --result {path}"
            )
    return model


def _names_kind(model: Model, path: str) -> bool:
    """True for a parameter that says of which kind a part is, and so which other parameters it has."""
    from fowtlib.language.errors import NotFoundError

    owner, _, name = path.rpartition(".")
    try:
        family = model.root.find(owner).family
    except NotFoundError:
        return False
    return family is not None and name == family.selector


def _was_changed(model: Model, path: str, value: Any) -> bool:
    """True for a tunable parameter of the model that has another value than the run had."""
    import numpy as np

    from fowtlib.language.errors import NotFoundError

    owner, _, name = path.rpartition(".")
    try:
        component = model.root.find(owner)
    except NotFoundError:
        return False  # the comparison of structures tells
    if name not in component.parameters or not component.parameters[name].tunable:
        return False
    return not np.array_equal(component.parameter_value(name), np.asarray(value))
