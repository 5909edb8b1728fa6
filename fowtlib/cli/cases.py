"""`fowt cases`: show the cases of a file, and write a file with named sets of load cases."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.cli.run import count, not_negative, numbers, positive
from fowtlib.language import leave
from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib import Model
    from fowtlib.cases import Case, CaseSet

DLC = "dlc"
DEFAULT_MODEL = "oc3_spar"
EXAMPLES = r"""A cases file lists runs: products of wind speeds, seas, seeds (docs/cases.md).
fowt cases FILE reads it, checks every case, and shows what there is; fowt cases
dlc NUMBER.. writes one with design load cases of IEC 61400-3-1 and -3-2.

examples:
  fowt cases dlc12.yaml --list
  fowt cases dlc levenmouth --class IA --seeds 5 --time 600 --discard 100 \
      --model oc3_spar_rigid --output levenmouth.yaml
  fowt cases dlc 1.2 1.3 1.6 --class IB --wind 4:24:2 --seeds 6 \
      --model oc3_spar_rigid --output dlc.yaml
"""
OF_DLC = ("model", "wind_class", "site", "wind", "rated", "seeds", "time", "discard", "misalignment")


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("cases", help="show the cases of a file, or write design load cases", epilog=EXAMPLES)
    parser.add_argument("words", nargs="+", metavar="FILE|dlc NUMBER..", help="a cases file; or dlc and load cases")
    parser.add_argument("--list", action="store_true", dest="all", help="every case, not only how many there are")
    parser.add_argument("--model", help=f"dlc: a shipped model or a model file; default: {DEFAULT_MODEL}")
    parser.add_argument("--class", dest="wind_class", metavar="CLASS", help="dlc: I, II or III, then A+, A, B or C; "
                        "default: IB")  # fmt: skip
    parser.add_argument("--site", metavar="SITE", help="dlc: a site as of `fowt contours`; default: norway_5")
    parser.add_argument("--wind", metavar="FIRST:LAST:STEP", help="dlc: speeds in operation [m/s]; default: 4:24:2")
    parser.add_argument("--rated", type=positive, metavar="V", help="dlc: rated wind speed [m/s]; default: the model's")
    parser.add_argument("--seeds", type=count, metavar="N", help="dlc: realisations of each state; default: 6")
    parser.add_argument("--time", type=positive, metavar="S", help="dlc: length that is judged [s]; default: 3600")
    parser.add_argument("--discard", type=not_negative, metavar="S", help="dlc: length before it [s]; default: 400")
    parser.add_argument("--misalignment", type=_angles, metavar="DEG,..", help="dlc: of waves and wind, where a load "
                        "case has it; default: 0")  # fmt: skip
    tables.add_output(parser, "output", "dlc: the cases file (.yaml); else save the table: .csv or .json")
    tables.declare(parser, output=False)
    loading.declare_leave(parser, runs=False)
    parser.set_defaults(action=cases)


def _angles(text: str) -> list[float]:
    values = numbers(text)
    if not len(values):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of angles in degrees, such as 0,30 or -30:30:30")
    return values.tolist()


def cases(arguments: argparse.Namespace) -> int:
    """Show the cases of a file, or write named sets."""
    if arguments.words[0] == DLC:
        return _write(arguments)
    given = [name for name in OF_DLC if getattr(arguments, name) is not None]
    if given:
        option = {"wind_class": "class"}.get(given[0], given[0])
        raise ModelError(f"--{option} belongs to load cases: fowt cases dlc NUMBER ... --{option}")
    if len(arguments.words) > 1:
        raise ModelError(f"'{arguments.words[1]}': one file is shown at a time; for load cases: fowt cases dlc 1.2 6.1")
    arguments.table = arguments.output
    tables.check(arguments)
    found = loading.read_cases(arguments, Path(arguments.words[0]))
    models = _checked(arguments, found)
    if arguments.all:
        _list(arguments, found, models)
    else:
        _show(arguments, found, models)
    return 0


def _checked(arguments: argparse.Namespace, found: CaseSet) -> dict[str, Model]:
    from fowtlib.cases import check_cases

    return check_cases(found, lambda name: loading.load_file(arguments, name))


def _write(arguments: argparse.Namespace) -> int:
    """Write the sets into a file, once they are read and checked like every other one, and show them."""
    from fowtlib.case_files import DEFAULT_SITE, read_cases, read_site
    from fowtlib.cases.dlc import Request, load_case_table, write_dlc
    from fowtlib.cases.plant_facts import hub_height

    known = [*load_case_table()["load_cases"], *load_case_table()["sets"]]
    if len(arguments.words) < 2:
        raise ModelError(f"which load cases? There are {', '.join(known)}; for example: fowt cases dlc 1.2 6.1")
    if arguments.output is None:
        raise ModelError("where to? Give the cases file: --output dlc.yaml")
    check_target(arguments.output, (".yaml",), arguments.force)
    values = {name: getattr(arguments, name) for name in OF_DLC if name not in ("model", "site")}
    given = {name: value for name, value in values.items() if value is not None}
    name = arguments.model or DEFAULT_MODEL
    model = loading.load_file(arguments, name)
    site = read_site(arguments.site or DEFAULT_SITE, hub_height(model))
    path = Path(name)
    if path.is_file():  # names in the file begin at its folder
        folder = arguments.output.absolute().parent.resolve()
        whole = path.resolve()
        name = str(whole.relative_to(folder)) if whole.is_relative_to(folder) else str(whole)
        if not whole.is_relative_to(folder):  # named by the user, who allows it by that
            leave.give_folder(whole.parent, arguments.output)
            print(f"{arguments.output}: leave to read in {whole.parent} is kept in {leave.leave_file()}.",
                  file=sys.stderr)  # fmt: skip
    text = write_dlc(Request(arguments.words[1:], name, site, **given), model)
    found = read_cases(arguments.output, text=text)
    models = _checked(arguments, found)
    _say_depth(site.name, site.water_depth, model)
    write_text(arguments.output, text)
    say_saved(arguments.output)
    _show(arguments, found, models)
    return 0


def _say_depth(site: str, depth: float | None, model: Model) -> None:
    world = model.root.parts.get("world")
    own = float(world.parameter_value("water_depth")) if world is not None else depth
    if depth is not None and own is not None and abs(depth - own) > 0.01 * depth:
        print(f"the site '{site}' has {depth:g} m of water, and the model stands in {own:g} m, which the cases take.",
              file=sys.stderr)  # fmt: skip


def _seconds(case: Case, models: dict[str, Model]) -> float | None:
    """Simulated time of a case, where it or its model says it."""
    given = case.duration if case.duration is not None else models[case.model].settings.get("duration")
    return None if given is None else float(given)


def _hours(found: list[Case], models: dict[str, Model]) -> float:
    return sum(_seconds(case, models) or 0.0 for case in found) / 3600


def _show(arguments: argparse.Namespace, found: CaseSet, models: dict[str, Model]) -> None:
    """A line for each group of cases."""
    groups: dict[str, list[Case]] = {}
    for case in found:
        groups.setdefault(case.group, []).append(case)
    columns = ("group", "cases", "hours", "wind speeds [m/s]", "weight", "safety factor", "first", "last")
    rows = []
    for group, members in groups.items():
        speeds = sorted({float(case.labels["wind_speed"]) for case in members
                         if isinstance(case.labels.get("wind_speed"), (int, float))})  # fmt: skip
        between = f"{speeds[0]:g} to {speeds[-1]:g}" if len(speeds) > 1 else "".join(f"{speed:g}" for speed in speeds)
        factors = sorted({case.safety_factor for case in members})
        rows.append((group, len(members), _hours(members, models), between, sum(case.weight for case in members),
                     ", ".join(f"{factor:g}" for factor in factors), members[0].name, members[-1].name))  # fmt: skip
    tables.say(arguments, _title(found, models))
    tables.show(arguments, columns, rows)


def _list(arguments: argparse.Namespace, found: CaseSet, models: dict[str, Model]) -> None:
    """A line for each case."""
    labels = list(dict.fromkeys(label for case in found for label in case.labels))
    columns = ("case", "group", "model", *labels, "duration [s]", "discard [s]", "weight")
    rows = [(case.name, case.group, case.model, *(case.labels.get(label) for label in labels), _seconds(case, models),
             case.discard, case.weight) for case in found]  # fmt: skip
    tables.say(arguments, _title(found, models))
    tables.show(arguments, columns, rows)


def _title(found: CaseSet, models: dict[str, Model]) -> str:
    count = f"{len(found)} case{'s' * (len(found) != 1)}"
    return f"{found.title}: {count} of {', '.join(found.models)}, {_hours(list(found), models):.4g} h in all"
