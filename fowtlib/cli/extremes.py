"""`fowt extremes`: what to run for long-term extremes at a site, and the extremes from what the runs have given."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import batch, results, site, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import part_bar
from fowtlib.cli.run import positive
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.metocean import Answers, ConditionalModel, States

WORTH_A_WORD = 1.02  # factor of a value of FLTA that is too high by the scatter of its fits
LAWS = ("gumbel", "pooled", "rates", "gaussian")
METHODS = ("flta", "ecm", "mecm", "sample")
SIDES = ("max", "min", "abs")
CASE_FILES = (".yaml", ".yml")
EXAMPLES = r"""First the states: flta all bins that occur once in --keep years, ecm the contour
of the return period, mecm that one and those that end at --cut-out, sample
random states, evaluated as flta. --cases writes them as a file for `fowt batch
run`. Then the extremes, by each method for which there are runs: of this batch
(--batch), or of tables from elsewhere.
--maxima FILE.csv: wind_speed, Hs, Tp, probability (empty on a contour), and for
each response the largest value of a run; several runs a state.
--fits FILE.csv: response, unit, side, wind_speed, Hs, Tp, probability, and
location and scale of a Gumbel law, or q, a, b, c, threshold of a rate of
up-crossings.
--side: of the batch, or of the values of --maxima, min is about smallest ones
and abs about largest absolute ones. With heave=min,yaw=abs it is about these
results, and about the largest values of the others.

examples:
  fowt extremes norway_5 --method flta --output states.csv
  fowt extremes norway_5 --method mecm --cut-out 25 --cases contours.yaml \
      --model two_rotor_spar_rigid --seeds 20
  fowt batch run contours.yaml
  fowt extremes norway_5 --cut-out 25 --batch contours.yaml \
      --results surge,yaw --side yaw=abs --plot extremes.png
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "long-term extremes at a site: states to run, and values from what the runs gave"
    parser = commands.add_parser("extremes", help=text, epilog=EXAMPLES)
    site.declare(parser, height=90.0)
    add = parser.add_argument
    add("--method", choices=METHODS, default="flta", metavar="NAME", help="of the states: flta, ecm, mecm or sample")
    form = "first:last:step"
    add(
        "--wind",
        type=site.positives,
        default=[*range(4, 51, 2)],
        metavar=form,
        help="bins or rings [m/s]; default: 4:50:2",
    )
    add("--waves", type=site.positives, default=[*range(1, 21)], metavar=form, help="bins of Hs [m]; default: 1:20:1")
    add("--periods", type=site.positives, default=[*range(2, 35, 2)], metavar=form, help="bins [s]; default: 2:34:2")
    add("--keep", type=positive, default=1000.0, metavar="YEARS", help="rarer bins are dropped; default: %(default)g")
    add("--points", type=int, default=9, metavar="N", help="of each ring of a contour; default: %(default)d")
    add("--whole", action="store_true", help="rings with waves below their median too")
    add("--cut-out", type=site.positives, default=[], metavar="V", help="wind speeds [m/s] where contours end")
    add("--fractile", type=positive, default=0.9, metavar="P", help="of ECM; default: %(default)g")
    add("--count", type=int, default=1000, metavar="N", help="of the states of a sample; default: %(default)d")
    add("--seed", type=int, default=1, metavar="N", help="of the sample; default: %(default)d")
    turbulence = "draw the turbulence of each state of a sample too: IEC class A+, A, B or C"
    add("--turbulence", choices=("A+", "A", "B", "C"), metavar="CLASS", help=turbulence)
    given = parser.add_mutually_exclusive_group()
    add("--cases", type=Path, metavar="FILE", help="write the runs as a cases file: .yaml")
    given.add_argument("--fits", type=Path, metavar="FILE", help="laws of extremes by state and response: .csv")
    given.add_argument("--batch", type=Path, metavar="FILE", help="a cases file that `fowt batch run` has run")
    given.add_argument("--maxima", type=Path, metavar="FILE", help="extreme values of runs: .csv")
    add("--results", type=results.names, metavar="NAMES", help="of the batch, for example surge,yaw; default: all")
    add("--side", type=sides, metavar="SIDE", help="max, min or abs, of all or by name: yaw=abs; default: max")
    add("--law", choices=LAWS, metavar="NAME", help="gumbel, pooled, rates or gaussian, see docs/long_term.md")
    add("--worst", type=int, metavar="N", help="--cases of the N worst states of each contour and response alone")
    add("--save-fits", type=Path, metavar="FILE", help="write the laws of the batch, for --fits: .csv")
    add("--model", metavar="MODEL", help="of the cases file")
    add("--seeds", type=int, default=1, metavar="N", help="runs of each state; default: %(default)d")
    add("--time", type=positive, default=4000.0, metavar="S", help="length of a run; default: %(default)g s")
    add("--discard", type=positive, default=400.0, metavar="S", help="of it not evaluated; default: %(default)g s")
    add("--plot", type=Path, metavar="FILE", help="draw return periods over the responses: .png, .svg or .pdf")
    tables.declare(parser)
    parser.set_defaults(action=extremes)


def sides(text: str) -> dict[str, str]:
    """Sides by the name of the result, with "" for those that are not named, for argparse."""
    found: dict[str, str] = {}
    for part in text.split(","):
        name, equals, side = part.rpartition("=")
        if side not in SIDES or name in found or (equals and not name):
            raise argparse.ArgumentTypeError(
                f"'{text}' is neither max, min or abs of all results, nor one of them by name, as in heave=min,yaw=abs"
            )
        found[name] = side
    return found


def extremes(arguments: argparse.Namespace) -> int:
    """The states of a method, or the extremes."""
    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    check_target(arguments.cases, CASE_FILES, arguments.force)
    joint = site.opened(arguments)
    check_target(arguments.save_fits, (".csv",), arguments.force)
    for option in ("results", "law", "save_fits"):
        if getattr(arguments, option) and not arguments.batch:
            raise ModelError(f"--{option.replace('_', '-')} is about the runs of a batch: give --batch.")
    if arguments.side and not (arguments.batch or arguments.maxima):
        raise ModelError("--side is about runs: give --batch or --maxima; a table of --fits has a column for it.")
    if (arguments.cases is None) != (arguments.model is None):
        raise ModelError("--cases and --model belong together: a file of cases of one model.")
    if arguments.cases and (arguments.seeds < 1 or arguments.discard >= arguments.time):
        raise ModelError("a state is run once or more, and what is discarded of a run is not all of it.")
    if arguments.fits or arguments.maxima or arguments.batch:
        if (arguments.cases is None) != (arguments.worst is None):
            raise ModelError("with runs, --cases and --worst belong together: the worst states, to be run again.")
        return _evaluate(arguments, joint)
    if arguments.plot or arguments.worst:
        raise ModelError(
            "--plot and --worst are about extremes: give --batch, --fits or --maxima; or see fowt contours."
        )
    return _list(arguments, joint)


def _list(arguments: argparse.Namespace, joint: ConditionalModel) -> int:
    states, told = _states(arguments, joint)
    head = f"{site.words(joint)}; states of {arguments.duration / 3600:.4g} h; {told}"
    if arguments.cases:
        _write_cases(arguments, states, head, arguments.method.upper())
    tables.say(arguments, head)
    if not arguments.cases or arguments.table or arguments.form:
        rows = [list(state) for state in states]
        columns = ["wind_speed [m/s]", "Hs [m]", "Tp [s]"]
        if states.probability is not None:
            columns.append("probability")
            rows = [[*row, float(each)] for row, each in zip(rows, states.probability, strict=True)]
        if states.turbulence_intensity is not None:
            columns.append("turbulence_intensity")
            rows = [[*row, float(each)] for row, each in zip(rows, states.turbulence_intensity, strict=True)]
        tables.show(arguments, columns, rows)
    say_saved(arguments.cases)
    return 0


def _write_cases(arguments: argparse.Namespace, states: States, title: str, group: str) -> None:
    from fowtlib.metocean import cases_file

    text = cases_file(
        states, arguments.model, title=title, group=group, seeds=arguments.seeds, duration=arguments.time,
        discard=arguments.discard, cut_out=max(arguments.cut_out, default=None),
    )  # fmt: skip
    write_text(arguments.cases, text)


def _states(arguments: argparse.Namespace, joint: ConditionalModel) -> tuple[States, str]:
    from fowtlib.metocean import Turbulence, bins, cut_off, radius, surface

    if arguments.turbulence and arguments.method != "sample":
        raise ParameterError("--turbulence is drawn for the states of a sample alone: --method sample.")
    if arguments.method == "sample":
        states = joint.sample(arguments.count, arguments.seed)
        if arguments.turbulence:
            states = Turbulence(arguments.turbulence).draw(states, arguments.seed + 1)
        return states, f"{len(states)} random states, seed {arguments.seed}"
    if arguments.method == "flta":
        whole = len(arguments.wind) * len(arguments.waves) * len(arguments.periods)
        states = bins(joint, arguments.wind, arguments.waves, arguments.periods, keep=arguments.keep,
                      duration=arguments.duration)  # fmt: skip
        return states, (f"{len(states)} of {whole} bins occur at least once in {arguments.keep:g} years, and hold "
                        f"{100 * states.weights.sum():.5g} % of the time")  # fmt: skip
    levels = [(radius(arguments.return_period, arguments.duration), arguments.return_period)]
    if arguments.method == "mecm":
        if not arguments.cut_out:
            raise ParameterError("the modified method needs --cut-out: the wind speed at which the turbine stops.")
        levels += [cut_off(joint, speed, arguments.duration) for speed in arguments.cut_out]
    parts = []
    for beta, _ in levels:
        top = float(joint.wind_speed.from_normal(beta))
        speeds = [*(speed for speed in arguments.wind if speed < (1 - 1e-9) * top), top]
        parts.append(surface(joint, beta, wind_speeds=speeds, points=arguments.points, upper=not arguments.whole))
    told = ", ".join(f"{len(part)} of {site.time(years)}" for part, (_, years) in zip(parts, levels, strict=True))
    return sum(parts[1:], start=parts[0]), f"{sum(map(len, parts))} states of contours: {told}"


def _evaluate(arguments: argparse.Namespace, joint: ConditionalModel) -> int:
    from fowtlib.metocean import compare_methods, fits_of_batch, read_fits, read_maxima, worst_states, write_fits

    if arguments.batch:
        with part_bar("reading the results of the runs") as report:
            fits = fits_of_batch(batch.opened(arguments.batch), arguments.results, arguments.law, arguments.duration,
                                 report, arguments.side or "max")  # fmt: skip
        if arguments.save_fits:
            write_fits(arguments.save_fits, fits.values())
            say_saved(arguments.save_fits)
    elif arguments.fits:
        fits = read_fits(arguments.fits, arguments.duration)
    else:
        fits = read_maxima(arguments.maxima, arguments.side or "max")
    answers = compare_methods(joint, fits, years=arguments.return_period, duration=arguments.duration,
                              cut_offs=arguments.cut_out, fractile=arguments.fractile)  # fmt: skip
    head = f"{site.words(joint)}; {site.time(arguments.return_period)}, states of {arguments.duration / 3600:.4g} h"
    if arguments.plot:
        from fowtlib.metocean.pictures import plot_exceedance

        plot_exceedance(answers, arguments.plot, title=head)
    tables.say(arguments, head)
    columns = ("response", "unit", "FLTA", "ECM", "MECM", "MECM over FLTA", "wind_speed [m/s]", "Hs [m]", "Tp [s]")
    tables.show(arguments, columns, [_row(each) for each in answers])
    tables.say(arguments, "The state is the one that gives MECM, else ECM, else most of FLTA.")
    _say_excess(answers)
    if arguments.cases:
        worst = worst_states(answers, arguments.worst)
        told = f"{len(worst)} states, the {arguments.worst} worst of each contour and response"
        _write_cases(arguments, worst, f"{head}; {told}", "WORST")
        tables.say(arguments, told)
    say_saved(arguments.plot, arguments.cases)
    return 0


def _say_excess(answers: list[Answers]) -> None:
    """Warn of values that the scatter of fits to few runs has made too high."""
    from fowtlib.metocean import excess_of_fits

    for each in answers:
        if each.flta is None or each.fits.runs is None:
            continue
        factor = excess_of_fits(each.flta, each.fits.runs, each.years)
        if factor > WORTH_A_WORD:
            far = "low" if each.fits.side == "min" else "high"
            warnings.warn(
                f"{each.fits.label}: its laws come from {each.fits.runs.min()} runs a state, too few: what scatters "
                f"{far} decides. FLTA is expected to be {100 * (factor - 1):.0f} % too {far}.",
                stacklevel=1,
            )


def _row(answers: Answers) -> list[Any]:
    """Values of all methods, and the state that matters most."""
    sign = answers.fits.sign
    values: list[float | None] = [None, None, None, None]
    state: Any = (None, None, None)
    if answers.flta is not None:
        value = answers.flta.value(answers.years)
        shares = answers.flta.shares(value)
        values[0], state = sign * value, list(answers.flta.states)[int(shares.argmax())]
    if answers.ecm is not None:
        values[1], state = sign * answers.ecm.value, answers.ecm.state
    if answers.mecm is not None:
        values[2], state = sign * answers.mecm.value, answers.mecm.worst.state
    if values[0] and values[2] is not None:
        values[3] = values[2] / values[0]
    return [answers.fits.label, answers.fits.unit, *values, *state]
