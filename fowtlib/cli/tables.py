"""Tables for people (rich), and the same rows for machines (JSON, CSV)."""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fowtlib.cli.encoding import is_unicode
from fowtlib.cli.files import TABLES, check_target, say_saved
from fowtlib.language.whole_files import write_text

Row = Sequence[Any]
MOST_NUMBERS = 9  # of an array that is shown to a person in full


def declare(parser: argparse.ArgumentParser, output: bool = True) -> None:
    """Add `--json` and `--csv`; and `--output` of the table, unless the command has one for something larger."""
    if output:
        add_output(parser, "table", "save the table: .csv or .json")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", dest="form", action="store_const", const="json", help="print JSON for machines")
    form.add_argument("--csv", dest="form", action="store_const", const="csv", help="print CSV for machines")
    parser.set_defaults(form="")


def add_output(parser: argparse.ArgumentParser, dest: str, text: str) -> None:
    """Add `-o FILE`, `--output FILE`, alike in every command."""
    parser.add_argument("-o", "--output", dest=dest, type=Path, metavar="FILE", help=text)


def say(arguments: argparse.Namespace, line: str) -> None:
    """Print a line above the answer; beside it, on stderr, where the answer is for machines."""
    if line:
        print(line, file=sys.stderr if arguments.form else sys.stdout)


def show(arguments: argparse.Namespace, columns: Sequence[str], rows: Iterable[Row], title: str = "") -> None:
    """Print rows in the form that the user asked for; in JSON each row is an object with the columns as keys."""
    rows = [list(row) for row in rows]
    save(arguments, columns, rows)
    if arguments.form == "json":
        show_json([dict(zip(columns, map(_plain, row), strict=True)) for row in rows])
    elif arguments.form == "csv":
        sys.stdout.write(csv_text(columns, ([_plain(value) for value in row] for row in rows)))
    else:
        _show_rich(columns, list(rows), title)


def check(arguments: argparse.Namespace) -> None:
    """Before the work: refuse a file of `--output` that cannot be written."""
    check_target(arguments.table, TABLES, arguments.force)


def show_rows(columns: Sequence[str], rows: Iterable[Row], title: str = "") -> None:
    """Print rows for a person."""
    _show_rich(columns, [list(row) for row in rows], title)


def save(arguments: argparse.Namespace, columns: Sequence[str], rows: Sequence[Row]) -> None:
    """Write a table into the file of `--output`, .csv or .json by its ending; without one do nothing."""
    path: Path | None = getattr(arguments, "table", None)
    if path is None:
        return
    check_target(path, TABLES, arguments.force)
    if path.suffix == ".json":
        plain = [dict(zip(columns, map(_plain, row), strict=True)) for row in rows]
        text = json.dumps(plain, indent=2, ensure_ascii=False)
    else:
        text = csv_text(columns, ([_plain(value) for value in row] for row in rows))
    write_text(path, text)
    say_saved(path)


def csv_text(columns: Sequence[str], rows: Iterable[Row]) -> str:
    """A table as the text of a CSV file."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def show_json(value: Any) -> None:
    """Print a value as JSON; numbers that JSON lacks (nan, inf) become null."""
    print(json.dumps(_plain(value), indent=2, ensure_ascii=not is_unicode(sys.stdout)))


def rounded(value: Any, size: float) -> Any:
    """Zero in place of what is left by rounding in a calculation with numbers of this size, or of the size of 1."""
    return 0.0 if isinstance(value, (int, float)) and abs(value) <= max(1e-12 * abs(size), 1e-20) else value


def number(value: float) -> str:
    """Five significant digits, as short as they go."""
    return f"{value:.5g}"


def _show_rich(columns: Sequence[str], rows: list[Row], title: str) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title) if title else None, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for index, column in enumerate(columns):
        values = [row[index] for row in rows if row[index] is not None]
        numeric = bool(values) and all(isinstance(value, (int, float)) for value in values)
        table.add_column(Text(column), justify="right" if numeric else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell(value)) for value in row))
    screen = console()
    with screen.capture() as printed:
        screen.print(table)
    print("\n".join(line.rstrip() for line in printed.get().splitlines()).strip("\n"))


def console(stderr: bool = False):
    """A rich console; text that goes into a file or a pipe is not broken into lines."""
    from rich.console import Console

    made = Console(stderr=stderr, highlight=False)
    if not made.is_terminal:
        made.width = 1000
    return made


def cell(value: Any) -> str:
    """A value as a person reads it, and as `--set` takes it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if hasattr(value, "tolist"):  # a NumPy number or array
        return cell(value.tolist())
    if isinstance(value, float):
        return number(value)
    if isinstance(value, (list, tuple)):
        count = _count(value)
        return "[" + ", ".join(map(cell, value)) + "]" if count <= MOST_NUMBERS else f"({count} values)"
    return str(value)


def _count(value: Any) -> int:
    return sum(map(_count, value)) if isinstance(value, (list, tuple)) else 1


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)
