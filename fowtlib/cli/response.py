"""`fowt response`: what random waves and wind do to a model, from its linear model, without a run."""

from __future__ import annotations

import argparse
from collections.abc import Sized
from pathlib import Path
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import part_bar
from fowtlib.cli.run import positive
from fowtlib.cli.site import positives
from fowtlib.cli.weather import weather
from fowtlib.language.errors import ModelError, ParameterError, did_you_mean

LEAST = 1e-9  # deviation over the size of the mean, below which a person is not shown a result

EXAMPLES = r"""About the mean position, with the controllers in the loop. Below: mean, standard
deviation, that of each process alone, the median of the largest and of the
smallest value in --hours, and the damage-equivalent range of 1 Hz (Dirlik).
Left out: loads of second order, limits of controllers, changes of their region;
where the deviations reach over a corner of a control law, a warning names it.
With --linearisation equivalent these corners are in it.

examples:
  fowt response oc3_spar_rigid --wind kaimal:18,class=B \
      --waves jonswap:Hs=4,Tp=10
  fowt response oc3_spar_rigid --outputs surge,pitch,thrust --plot spectra.png
  fowt response oc3_spar_rigid --site northern_north_sea --speeds 4:25:1
  fowt response oc3_spar_rigid --states states.csv --each deviations.csv

Many states: a CSV file with the columns wind_speed, Hs, Tp and probability, and
perhaps paths of other parameters; or a site, with the most probable sea of each
of --speeds (--bins: all bins of 1 m and 1 s with a probability above 1e-4).
Mean and std are then those of the states, weighted by their probabilities; the
largest and the smallest value are those of the worst state, whose number stands
behind; the range is that of the whole life. The kind of wind and its class are
those of --wind or of the model.
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "spectra, extremes and fatigue in random waves and wind, without a run"
    parser = commands.add_parser("response", help=text, epilog=EXAMPLES)
    loading.declare(parser)
    parser.add_argument("--outputs", metavar="A,B", help="results; default: all")
    parser.add_argument("--hours", type=positive, default=1.0, metavar="H", help="duration of the extremes; default: 1")
    parser.add_argument("--exponent", type=positive, default=4.0, metavar="M", help="of the S-N curve; default: 4")
    text = "equivalent: suits the response itself, and knows of corners; quadratic: with products of fluctuations too; "
    text += "default: tangent"
    parser.add_argument("--linearisation", choices=("tangent", "equivalent", "quadratic"), default="tangent", help=text)
    text = "what blades meet is as wide as the deviation of the rotor speed makes it; for blade elements in a field"
    parser.add_argument("--varying-speed", action="store_true", help=text)
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the spectra: .png, .svg or .pdf")
    parser.add_argument("--spectra", type=Path, metavar="FILE", help="save the spectra: .csv or .nc")
    many = parser.add_argument_group("many states")
    source = many.add_mutually_exclusive_group()
    source.add_argument("--states", type=Path, metavar="FILE", help="states with their probabilities: .csv")
    source.add_argument("--site", metavar="SITE", help="a site, see `fowt contours`; or the file of one")
    many.add_argument("--speeds", type=positives, metavar="V", help="first:last:step or a list [m/s]; default: 4:24:2")
    many.add_argument("--height", type=positive, metavar="M", help="of the wind at the site [m]; default: the site's")
    many.add_argument("--bins", action="store_true", help="all bins of wave height and period at the site")
    many.add_argument("--each", type=Path, metavar="FILE", help="save the numbers of each state: .csv or .nc")
    tables.declare(parser)
    parser.set_defaults(action=show_response)


def show_response(arguments: argparse.Namespace) -> int:
    """Print the statistics of every result, and draw and save the spectra."""
    from fowtlib.frequency import response

    if arguments.states or arguments.site:
        return show_states(arguments)
    for option in ("speeds", "height", "bins", "each"):
        if getattr(arguments, option):
            raise ModelError(f"--{option} belongs to many states: give --states or --site too.")
    check_target(arguments.plot, FIGURES, arguments.force)
    check_target(arguments.spectra, (".csv", ".nc"), arguments.force)
    tables.check(arguments)
    model = loading.load(arguments)
    names = arguments.outputs.split(",") if arguments.outputs else None
    found = response(model, outputs=names, linearisation=arguments.linearisation, varying_speed=arguments.varying_speed)
    moving = [name for name, mean in zip(found.outputs, found.mean, strict=True)
              if names or found.std(name) > LEAST * max(abs(mean), 1e-6)]  # all that were asked for
    if arguments.plot:
        found.plot(arguments.plot, outputs=moving)
    processes = list(found.shares)
    columns = ["result", "mean", "std", *(f"std by {name}" for name in processes), "largest", "smallest", "range"]
    rows = []
    for name in found.outputs if arguments.form else moving:
        extremes = [found.extreme(name, 3600 * arguments.hours, side=side) for side in ("max", "min")]
        shares = [found.std(name, process) for process in processes]
        mean, unit = float(found.mean[found.outputs.index(name)]), found.unit(name)
        load = found.equivalent_load(name, arguments.exponent)
        rows.append([f"{name} [{unit}]", mean, found.std(name), *shares, *extremes, load])
    method = "" if found.linearisation == "tangent" else f"; {found.linearisation} linearisation"
    method += "; varying rotor speed" if arguments.varying_speed else ""
    tables.say(arguments, weather(model, arguments) + method)
    tables.show(arguments, columns, rows)
    say_saved(arguments.plot)
    if arguments.spectra:
        say_saved(found.save(arguments.spectra))
    return 0


def show_states(arguments: argparse.Namespace) -> int:
    """Print the statistics of every result over many states, and save those of each state."""
    from fowtlib.frequency.many import responses

    for option in ("plot", "spectra"):
        if getattr(arguments, option):
            raise ModelError(f"--{option} is for one state; of many states --each saves the numbers.")
    if arguments.linearisation != "tangent":
        raise ModelError(f"--linearisation {arguments.linearisation} is for one state.")
    if arguments.varying_speed:
        raise ModelError("--varying-speed is for one state.")
    if arguments.states and (arguments.speeds or arguments.height or arguments.bins):
        raise ModelError("--speeds, --height and --bins choose states of a --site; --states names them all.")
    check_target(arguments.each, (".csv", ".nc"), arguments.force)
    tables.check(arguments)
    states, told = _of_file(arguments.states) if arguments.states else _of_site(arguments)
    model = loading.load(arguments)
    names = arguments.outputs.split(",") if arguments.outputs else None
    plant = model.compile()
    paths = [path for path in (states if arguments.states else states.run_parameters()[0]) if path != "probability"]
    known = [*plant.dae.parameters, *plant.dae.bound_parameters]
    for path in paths:
        if path not in known:
            raise ParameterError(
                f"the model has no parameter '{path}' that states could set{did_you_mean(path, known)}",
                where=str(arguments.states or arguments.site),
            )
    with part_bar("states") as report:
        found = responses(plant, states, outputs=names, progress=report)
    every = 1.0 if found.failures or not found.complete else 0.0  # what is missing was told by a warning
    columns = ["result", "mean", "std", "largest", "in state", "smallest", "in state ", "range"]
    rows = []
    for name in found.outputs:
        std = found.weighted_std(name, every)
        mean = found.weighted(lambda one, name=name: one.mean_of(name), every)
        if not names and not arguments.form and not std > LEAST * max(abs(mean), 1e-6):
            continue
        (top, high), (bottom, low) = (found.extreme(name, 3600 * arguments.hours, side=side) for side in ("max", "min"))
        load = found.equivalent_load(name, arguments.exponent, missing=every)
        rows.append([f"{name} [{found.unit(name)}]", mean, std, top, high + 1, bottom, low + 1, load])
    tables.say(arguments, f"{weather(model, arguments)}; in {told}, which set {', '.join(paths)}")
    tables.show(arguments, columns, rows)
    if arguments.each:
        say_saved(found.save(arguments.each))
    if not found.complete:
        return 130
    return 1 if found.failures else 0


def _of_site(arguments: argparse.Namespace) -> tuple[Any, str]:
    """States of a site, and what is said of them."""
    from fowtlib.metocean import centre_bins, likely_states, site

    joint = site(arguments.site)
    joint = joint.at(arguments.height) if arguments.height else joint
    speeds = arguments.speeds or [4.0 + 2.0 * k for k in range(11)]
    if not arguments.bins:
        return likely_states(joint, speeds), f"{_count(speeds)} of {joint.title or joint.name}"
    states = centre_bins(joint, speeds, [0.5 + k for k in range(20)], [0.5 + k for k in range(30)])
    return states, f"{_count(states)} of {joint.title or joint.name}"


def _of_file(path: Path) -> tuple[dict[str, Any], str]:
    """States of a file, by the paths of parameters, and what is said of them."""
    from fowtlib.metocean.csv_columns import read_columns
    from fowtlib.metocean.states import COLUMNS, PARAMETERS

    columns = read_columns(path, "the list of states", None)
    for name in columns.numbers:
        if name not in PARAMETERS and name != "probability" and "." not in name:
            known = [*PARAMETERS, "probability"]
            raise ParameterError(f"the list of states has no column '{name}'{did_you_mean(name, known)} Another "
                                 "parameter is named by its path.", where=str(path))  # fmt: skip
    if "probability" in columns.numbers:
        if (unit := columns.units["probability"]) not in ("", "1"):
            raise ParameterError(f"a probability is a number from 0 to 1, not in {unit}.", where=str(path))
        columns.refuse(columns.numbers["probability"] < 0, "a probability is 0 or more.")
        total = columns.numbers["probability"].sum()
        if not 0 < total <= 1 + 1e-6:
            raise ParameterError(
                f"the probabilities have the sum {total:.6g}; of a life they have 1 at most, and more than 0. Divide "
                "them by their sum if the states stand for all of it.", where=str(path)
            )  # fmt: skip
    found: dict[str, Any] = {}
    for name, values in columns.numbers.items():
        unit = "" if name in (*COLUMNS, "probability") else columns.units[name]  # what the reader knows is in SI
        cells = values.tolist()
        found[PARAMETERS.get(name, name)] = [f"{cell!r} {unit}" for cell in cells] if unit else cells
    return found, f"{_count(columns.lines)} of {path}"


def _count(states: Sized) -> str:
    return f"{len(states)} state{'s' if len(states) > 1 else ''}"
