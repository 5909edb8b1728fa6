"""`fowt batch`: run many cases, each once, and look at what became of them."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, results, tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.cli.run import count
from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean

if TYPE_CHECKING:
    from fowtlib.cases import Batch, CaseSet, Progress

ENDING, PAGE, LISTS = ".batch", ".html", (".yaml", ".yml")
TOLD = 60.0  # s between two lines on the progress, where there is no terminal
STATISTICS = ("mean", "std", "min", "max")
GONE_WRONG = ("failed", "lost")  # first words of what is said of a case while a batch runs
EACH = {
    "run": "fowt batch run dlc12.yaml --workers 4",
    "retry": "fowt batch retry dlc12.yaml",
    "status": "fowt batch status dlc12.yaml --all",
    "table": "fowt batch table dlc12.yaml --results pitch,surge \\\n      --statistics mean,max --output extremes.csv",
    "report": "fowt batch report dlc12.yaml --output dlc12.html",
}
EXAMPLES = r"""FILE lists the cases (see docs/cases.md). The results lie beside it, in a
folder with the ending .batch, or in that of --folder: a registry, one file a
case, batch.log. A batch that was stopped goes on where it was. Cases are done
again where they, their model or a file of data have changed.

examples:
  fowt batch run dlc12.yaml
  fowt batch status dlc12.yaml
  fowt batch table dlc12.yaml --results pitch,surge --statistics mean,max \
      --output extremes.csv
  fowt batch report dlc12.yaml --output dlc12.html
  fowt batch run dlc12.yaml --scheduler tcp://10.0.0.1:8786
"""


def declare(commands: Any) -> None:
    """Add the command of this module, with its actions."""
    parser = commands.add_parser("batch", help="run many cases, and look at what became of them", epilog=EXAMPLES)
    verbs = parser.add_subparsers(dest="verb", metavar="ACTION", required=True)
    for name, text in (("run", "run the cases that are not done yet"), ("retry", "run those that have failed, too")):
        verb = verbs.add_parser(name, help=text, epilog=_example(name))
        _declare_file(verb, "cases: a file that lists them (.yaml)")
        _declare_run(verb)
        verb.set_defaults(action=run, retry=name == "retry")
    status = verbs.add_parser("status", help="how far a batch is, and what went wrong", epilog=_example("status"))
    _declare_file(status, "the file that lists the cases, or the folder of the batch")
    status.add_argument("--all", action="store_true", help="also cases that are done")
    tables.declare(status)
    status.set_defaults(action=show_status)
    table = verbs.add_parser("table", help="the statistics of all cases that are done", epilog=_example("table"))
    _declare_file(table, "the file that lists the cases, or the folder of the batch")
    table.add_argument("--results", metavar="NAMES", help="of these results, for example pitch,surge; default: all")
    table.add_argument("--statistics", metavar="NAMES", default=",".join(STATISTICS),
                       help="for example mean,max,p99,skewness; default: %(default)s")  # fmt: skip
    tables.declare(table)
    table.set_defaults(action=show_table)
    report = verbs.add_parser("report", help="a page with what the batch has found", epilog=_example("report"))
    _declare_file(report, "the file that lists the cases, or the folder of the batch")
    report.add_argument("-o", "--output", type=Path, metavar="FILE", help="the page; default: beside the folder")
    report.add_argument("--title", default="", metavar="TEXT", help="of the page")
    report.add_argument("--results", metavar="NAMES", help="with figures, for example pitch,surge; default: the usual")
    report.set_defaults(action=write_report)


def _example(verb: str) -> str:
    return f"examples:\n  {EACH[verb]}\n"


def _declare_file(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help=text)
    parser.add_argument("--folder", type=Path, metavar="FOLDER", help=f"of the results; default: FILE with {ENDING}")


def _declare_run(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=count, metavar="N",
                        help="processes; default: as many as cores and memory allow")  # fmt: skip
    parser.add_argument("--format", metavar="F", help="of the results: nc or outb; default: nc")
    parser.add_argument("--keep", metavar="WHAT", help="all, or statistics without files of results; default: all")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of Dask, to compute there, such as tcp://10.0.0.1:8786")
    loading.declare_leave(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run the cases, and print what became of them; 1 where some have failed."""
    from fowtlib.cases import run_batch

    cases = _cases(arguments)
    folder = _folder(arguments.file, arguments.folder)
    told: set[str] = set()
    try:
        with _progress(told) as report:
            batch = run_batch(
                cases, folder, source=str(arguments.file.resolve()), workers=arguments.workers,
                cluster=arguments.scheduler, format=arguments.format, keep=arguments.keep, retry=arguments.retry,
                allow_python=arguments.allow_python, progress=report,
            )  # fmt: skip
    except KeyboardInterrupt:
        print(f"fowt batch {arguments.verb}: stopped. What is done is kept in {folder}; to go on, run it again.",
              file=sys.stderr)  # fmt: skip
        return 130
    counts = batch.counts
    print(f"{folder}: {_told(counts)}")
    for row in batch.rows("failed"):
        if row.name not in told:  # it has failed before
            print(f"{row.name}: {row.message}", file=sys.stderr)
    if counts["failed"]:
        print(f"to try those that have failed again: fowt batch retry {arguments.file}", file=sys.stderr)
    return 1 if counts["failed"] else 0


def show_status(arguments: argparse.Namespace) -> int:
    """Print how many cases are in each state, and those that are not done with what there is to say."""
    tables.check(arguments)
    batch = opened(arguments.file, arguments.folder)
    rows = batch.rows()
    tables.say(arguments, f"{batch.folder}: {_told(batch.counts)}")
    shown = [row for row in rows if arguments.all or row.state != "done"]
    if shown or arguments.form or arguments.table:
        columns = ("case", "state", "simulated [s]", "took [s]", "what there is to say")
        told = [(row.name, row.state, row.simulated, row.seconds, row.message or row.why or row.warnings)
                for row in shown]  # fmt: skip
        tables.show(arguments, columns, told)
    return 0


def show_table(arguments: argparse.Namespace) -> int:
    """Print the statistics of the results of all cases that are done."""
    tables.check(arguments)
    batch = opened(arguments.file, arguments.folder)
    rows = batch.rows("done")
    if not rows:
        raise ModelError(f"{batch.folder}: no case is done yet.")
    found = {row.name: {name: _numbers(told) for name, told in row.statistics.items()} for row in rows}
    known = list(dict.fromkeys(name for told in found.values() for name in told))
    names = _chosen(arguments.results, known, "result") if arguments.results else known
    numbers = list(dict.fromkeys(key for told in found.values() for one in told.values() for key in one))
    columns = _chosen(arguments.statistics, numbers, "statistic")
    labels = list(dict.fromkeys(label for row in rows for label in row.case.labels))
    told = [
        (row.name, *(row.case.labels.get(label) for label in labels), name, row.statistics[name]["unit"],
         *(tables.rounded(found[row.name][name].get(key), _size(row.statistics[name])) for key in columns))
        for row in rows for name in names if name in row.statistics
    ]  # fmt: skip
    tables.say(arguments, f"{batch.folder}: {_told(batch.counts)}")
    tables.show(arguments, ("case", *labels, "result", "unit", *columns), told)
    return 0


def _numbers(told: Any) -> dict[str, float]:
    """The single numbers of the statistics of a channel, percentiles by p1, p50 and so on."""
    percentiles = {f"p{key}": value for key, value in told.get("percentiles", {}).items()}
    return {key: value for key, value in {**told, **percentiles}.items() if isinstance(value, (int, float))}


def write_report(arguments: argparse.Namespace) -> int:
    """Write the page of a batch."""
    from fowtlib.report import write_batch_page

    batch = opened(arguments.file, arguments.folder)
    path = arguments.output or batch.folder.with_suffix(PAGE)
    check_target(path, (PAGE,), arguments.force)
    channels = _names(arguments.results, "result") if arguments.results else None
    say_saved(write_batch_page(batch, path, title=arguments.title, channels=channels))
    return 0


def _size(statistics: Any) -> float:
    return max(abs(statistics.get("min", 0.0)), abs(statistics.get("max", 0.0)))


def _names(text: str, what: str) -> list[str]:
    names = [name for name in results.split(text) if name]
    if not names:
        raise ModelError(f"'{text}' names no {what}; give names with commas between them.")
    return names


def _chosen(text: str, known: list[str], what: str) -> list[str]:
    names = _names(text, what)
    for name in names:
        if name not in known:
            raise NotFoundError(f"there is no {what} '{name}'{did_you_mean(name, known, list_up_to=30)}")
    return names


def _cases(arguments: argparse.Namespace) -> CaseSet:
    """The cases of the file, all of which can be run, with the leave that the command line gives to their models."""
    from fowtlib import check_cases
    from fowtlib.language import leave

    if arguments.file.is_dir():
        raise ModelError(f"{arguments.file}: is a folder; give the file that lists the cases.")
    cases = loading.read_cases(arguments, arguments.file)
    models = check_cases(cases, lambda name: loading.load_file(arguments, name))
    for model in models.values() if arguments.trust else ():
        for path in leave.give_native(model.root):
            print(f"{path}: leave to run this native code is kept in {leave.leave_file()}.", file=sys.stderr)
    return cases


def _folder(file: Path, folder: Path | None) -> Path:
    return folder or (file if file.is_dir() else file.with_suffix(ENDING))


def opened(file: Path, folder: Path | None = None) -> Batch:
    """The batch of a cases file, or in a folder; folder: where it is not the one beside the file."""
    from fowtlib.cases import Batch

    option = f" --folder {folder}" if folder is not None else ""
    folder = _folder(file, folder)
    if not folder.exists():
        if file.is_file() and file.suffix not in LISTS:
            raise ModelError(f"{file}: is neither a file that lists cases (.yaml) nor the folder of a batch.")
        raise ModelError(f"{folder}: there is no such folder; begin the batch with fowt batch run {file}{option}.")
    batch = Batch.open(folder)
    source = batch.about.get("source")
    if source and not file.is_dir() and Path(source) != file.resolve():
        print(f"{folder}: holds the batch of {source}, not of {file}.", file=sys.stderr)
    return batch


def _told(counts: dict[str, int]) -> str:
    total = sum(counts.values())
    told = [f"{counts[state]} {word}" for state, word in (("failed", "failed"), ("running", "running"), ("due", "due"))
            if counts[state]]  # fmt: skip
    return ", ".join([f"{counts['done']} of {total} cases done", *told])


@contextmanager
def _progress(told: set[str]) -> Iterator[Callable[[Progress], None]]:
    """A bar on stderr with rate and time left, and a line for each case that fails; elsewhere lines alone.

    told: gets the names of these cases.
    """
    from fowtlib.cases.batch import duration_in_words, in_words

    screen = tables.console(stderr=True)
    if not screen.is_terminal:
        last = time.monotonic()

        def say(now: Progress) -> None:
            nonlocal last
            if now.words.startswith(GONE_WRONG):
                told.add(now.name)
                print(now.words, file=sys.stderr, flush=True)
            if time.monotonic() - last > TOLD:
                last = time.monotonic()
                print(in_words(now), file=sys.stderr, flush=True)

        yield say
        return
    from rich.progress import BarColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[told]}"))
    with Progress(*columns, console=screen, transient=True) as bar:
        task = bar.add_task("starting", total=None, told="")

        def report(now) -> None:
            if now.words.startswith(GONE_WRONG):
                told.add(now.name)
                bar.console.print(now.words, markup=False, highlight=False)
            failed = f", {now.failed} failed" if now.failed else ""
            rate = f"{now.rate:.0f} x real time" if now.rate else ""
            left = f"{duration_in_words(now.left)} left" if now.left is not None else ""
            bar.update(task, completed=now.simulated, total=now.to_simulate, told=", ".join(filter(None, (rate, left))),
                       description=f"{now.done} of {now.cases} cases{failed}")  # fmt: skip

        yield report
