"""Result files as arguments of commands."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from fowtlib.cli.run import not_negative
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    import xarray

    from fowtlib.solving.results import Result


def declare(parser: argparse.ArgumentParser) -> None:
    """Add `RESULT...` and `--discard`."""
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULT", help="result files: .nc, .csv or .outb")
    parser.add_argument("--discard", type=not_negative, metavar="S", default=0.0, help="without the first S seconds")


def names(text: str) -> list[str]:
    """Names between commas, for argparse; see split."""
    found = split(text)
    if not all(found):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of names, such as surge,pitch")
    return found


def split(text: str) -> list[str]:
    """What stands between commas; a comma in brackets belongs to a name: `force[0,1]`."""
    found, depth = [""], 0
    for letter in text:
        depth += (letter == "[") - (letter == "]")
        if letter == "," and depth <= 0:
            found.append("")
        else:
            found[-1] += letter
    return [name.strip() for name in found]


def series(paths: list[Path], name: str) -> list[xarray.DataArray]:
    """One series of each result."""
    found = []
    for label, result in open_results(paths).items():
        try:
            found.append(result[name])
        except ModelError as error:
            raise error.at(label) from None
    return found


def open_results(paths: list[Path]) -> dict[str, Result]:
    """Results by the names of their files, without ending where that tells them apart."""
    from fowtlib.solving.results import Result

    if len(set(paths)) < len(paths):
        twice = next(path for path in paths if paths.count(path) > 1)
        raise ModelError(f"{twice}: is named twice.")
    stems = [path.stem for path in paths]
    labels = stems if len(set(stems)) == len(stems) else [str(path) for path in paths]
    return {label: Result.open(path) for label, path in zip(labels, paths, strict=True)}
