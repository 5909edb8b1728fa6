"""`fowt run`: simulate a model over time."""

from __future__ import annotations

import argparse
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import events, loading, rescue, tables
from fowtlib.cli.files import FIGURES, RESULTS, check_target, say_saved
from fowtlib.cli.progress import progress_bar
from fowtlib.cli.start import HELP, start_values
from fowtlib.cli.weather import weather
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.leave import require_leave

if TYPE_CHECKING:
    import numpy as np

    from fowtlib import Plant
    from fowtlib.solving.results import Result
    from fowtlib.solving.results.journal import Journal

MOST_VALUES = 100_000  # of first:last:step: a step with a zero too many would take all memory

EXAMPLES = r"""examples:
  fowt run oc3_spar_rigid --time 600 --wind steady:8 --waves still
  fowt run oc3_spar_rigid --wind kaimal:11.4,class=B,seed=1 \
      --waves jonswap:Hs=6,Tp=10,seed=1 --plot run.png
  fowt run oc3_spar_rigid --time 4000 --start turning --discard 400 \
      --output run.nc
  fowt run oc3_spar_rigid --time 100 --event "turbine.grid_loss at 50 s"
  fowt run oc3_spar_rigid --time 8000 --output longer.nc --resume run.nc
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("run", help="simulate a model over time", epilog=EXAMPLES)
    loading.declare(parser)
    parser.add_argument("--time", type=positive, metavar="S", help="end time [s]; default: the model file's")
    parser.add_argument(
        "--output-step", type=positive, metavar="S", help="time between results [s]; default: the model file's"
    )
    tables.add_output(parser, "output", "save the results: .nc (resumable), .csv or .outb")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the results: .png, .svg or .pdf")
    events.declare_option(parser)
    parser.add_argument("--solver", default=None, help="idas or fixed; default: the model file's, or idas")
    parser.add_argument("--step", metavar="T", help="step of the solver fixed [s], or 12.5ms")
    parser.add_argument("--tolerance", type=positive, metavar="RTOL", help="relative; default: the model file's")
    parser.add_argument(
        "--resume", type=Path, metavar="FILE",
        help="go on from an earlier result (.nc), or from what a killed run has left (.nc.part)",
    )  # fmt: skip
    parser.add_argument("--start", metavar="HOW", help=HELP)
    parser.add_argument(
        "--discard", type=positive, metavar="S", default=0.0, help="statistics and picture without the first S seconds"
    )
    tables.declare(parser, output=False)
    parser.set_defaults(action=run)


def finite(text: str) -> float:
    """A number, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number")
    return value


def numbers(text: str) -> np.ndarray:
    """`0.02:0.2:0.005`, both ends included, or single values `3,5,8`; empty where the text says neither.

    Raises argparse.ArgumentTypeError for more than MOST_VALUES.
    """
    import numpy as np

    try:
        if ":" not in text:
            values = np.array([float(word) for word in text.split(",")])
            return values if np.isfinite(values).all() else np.zeros(0)
        first, last, step = map(finite, text.split(":"))
        steps = (last - first) / step
    except (argparse.ArgumentTypeError, ValueError, ZeroDivisionError):
        return np.zeros(0)
    if steps >= MOST_VALUES:
        raise argparse.ArgumentTypeError(
            f"'{text}' would be {steps:.3g} values; {MOST_VALUES} is the most, take a larger step"
        )
    return first + step * np.arange(int(max(steps + 1 + 1e-9, 0)))


def positive(text: str) -> float:
    """A number above zero, for argparse."""
    try:
        value = finite(text)
    except argparse.ArgumentTypeError:
        value = 0.0
    if value <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number")
    return value


def not_negative(text: str) -> float:
    """A number from zero upward, for argparse."""
    value = finite(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is negative")
    return value


def count(text: str) -> int:
    """A whole number above zero, for argparse."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number above zero")
    return int(text)


def run(arguments: argparse.Namespace) -> int:
    """Simulate, save, draw, and print the statistics of the results."""
    from fowtlib.solving.conditions import Conditions
    from fowtlib.solving.engines.fixed_step_code import begin_runtime
    from fowtlib.solving.results.journal import Journal

    happening = events.chosen(arguments)
    onto = arguments.output is not None and arguments.output == arguments.resume  # to go on in the same file
    check_target(arguments.output, RESULTS, arguments.force or onto)
    check_target(arguments.plot, FIGURES, arguments.force)
    journal = Journal(arguments.output) if arguments.output else None
    if journal:
        journal.require_free()
    if journal and not onto and arguments.resume != journal.path:
        _check_left(journal.path, arguments.output, arguments.force)
    earlier = _earlier(arguments.resume) if arguments.resume else None
    if earlier is None:
        arguments.resume = None
    model = loading.load(arguments)
    require_leave(model.root)  # before the equations are made
    fixed = (arguments.solver or model.settings.get("solver")) == "fixed"
    if fixed:
        begin_runtime()
    plant = model.compile()
    _check_discard(arguments, plant, earlier)
    if fixed:
        plant.begin_code()
    start, whence = start_values(arguments, plant)
    conditions = Conditions(start=earlier or start, duration=arguments.time, output_step=arguments.output_step,
                            events=happening)  # fmt: skip
    options = {"solver": arguments.solver, "step": arguments.step, "tolerance": arguments.tolerance}
    try:
        with progress_bar(earlier.final.time if earlier else 0.0) as report:
            later = plant.simulate(conditions=conditions, progress=report, journal=journal, **options)
    except SimulationError as error:
        _rescue(error, earlier, arguments.output or rescue.free_name(f"{model.name or 'run'}_partial"), journal)
        raise
    result = earlier.followed_by(later) if earlier else later
    problem = ""
    if arguments.output:
        _, problem = rescue.save(result, arguments.output, journal)
    if arguments.plot:
        from fowtlib.solving.results.plots import plot_result

        plot_result(result, path=arguments.plot, discard=_discarded(arguments, result))
    tables.say(arguments, "; ".join(filter(None, (weather(model, arguments), whence))))
    for line in str(result.attributes.get("events", "")).splitlines():
        tables.say(arguments, f"event at {line}")
    _show(arguments, result, later)
    say_saved(None if problem else arguments.output, arguments.plot)
    if problem:  # at the end, where it is seen
        raise ModelError(problem)
    return 0


def _earlier(path: Path) -> Result | None:
    """The result to resume from: the file, or what a run to it that was killed has left, where that reaches further.

    None, with a warning, where such a run had nothing to go on from yet.
    """
    from fowtlib.solving.results import Result
    from fowtlib.solving.results.journal import ENDING, NothingKept, journal_of

    left = path if path.suffix == ENDING else journal_of(path)
    saved = Result.open(path) if path != left and (path.exists() or not left.exists()) else None
    if saved is not None and not left.exists():
        return saved
    try:
        kept = Result.open(left)
    except ModelError as error:
        if saved is None and not isinstance(error, NothingKept):
            raise
        anew = "the run begins anew, where the model file says (to choose another start: --start and --force)"
        way = anew if saved is None else f"the run goes on from {path}"
        reason = "holds nothing to go on from" if isinstance(error, NothingKept) else "cannot be read"
        warnings.warn(f"{left}, which a run that was killed has left, {reason}; {way}.", stacklevel=1)
        return saved
    if saved is None:
        return kept
    if kept.final.time <= saved.time[-1]:
        return saved
    warnings.warn(f"the run goes on from {left}, which a run that was killed has left: it reaches further than {path}.",
                  stacklevel=1)  # fmt: skip
    return kept


def _check_discard(arguments: argparse.Namespace, plant: Plant, earlier: Result | None) -> None:
    """Refuse to leave out all of a run, before it is computed."""
    from fowtlib.solving.settings import duration_settings

    end, *_ = duration_settings(arguments.time, arguments.output_step, None, plant.settings)
    first = earlier.time[0] if earlier and earlier.time.size else 0.0
    if arguments.discard >= end - first > 0:
        raise ModelError(
            f"--discard: {arguments.discard:g} s of a run of {end - first:g} s leave nothing; "
            "discard less, or simulate longer (--time)."
        )


def _discarded(arguments: argparse.Namespace, result: Result) -> float:
    """Seconds to leave out; of a run that ended before them nothing is left out."""
    return arguments.discard if arguments.discard < result.duration else 0.0


def _check_left(left: Path, output: Path, force: bool) -> None:
    """Refuse to write over what a run that was killed has left."""
    if left.exists() and not force:
        raise ModelError(
            f"{left}: a run to this file was killed, or is going on, and this is what it has computed. To go on from "
            f"there: --resume {output}; to begin anew: --force."
        )


def _rescue(error: SimulationError, earlier: Result | None, path: Path, journal: Journal | None) -> None:
    """Save what a run has computed before it stopped, and say in the error where it is."""
    partial: Result | None = getattr(error, "result", None)
    if partial is None or partial.time.size < 2:
        if journal and partial is not None and not earlier:  # nothing is in it
            journal.remove()
        return
    result = earlier.followed_by(partial) if earlier else partial
    path = path if path.suffix == ".csv" else path.with_suffix(".nc")
    place, problem = rescue.save(result, path, journal)
    if problem:
        error.message += f"\n{problem}"
        return
    error.message += f"\nThe results up to t = {result.time[-1]:g} s are saved in {place}"
    error.message += f"; to go on from there: --resume {place}" if path.suffix == ".nc" else "."


def _show(arguments: argparse.Namespace, result: Result, later: Result) -> None:
    statistics = result.statistics(_discarded(arguments, result))
    summaries = statistics.values()
    columns = ("result", "unit", "mean", "std", "min", "max")
    rows = []
    for item in summaries:
        size = max(abs(item.min), abs(item.max))
        values = (tables.rounded(value, size) for value in (item.mean, item.std, item.min, item.max))
        rows.append((item.name, item.unit, *values))
    factor = later.duration / max(later.attributes["wall_time"], 1e-9)
    tables.show(arguments, columns, rows, f"{statistics.first:g} s to {statistics.last:g} s, {factor:.0f} x real time")
