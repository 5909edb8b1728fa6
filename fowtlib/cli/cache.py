"""`fowt cache`: what is kept of earlier runs, and away with it."""

from __future__ import annotations

import argparse
from typing import Any

from fowtlib.cli import tables
from fowtlib.language.errors import ModelError

EXAMPLES = """FOWTLIB_CACHE names another folder, and FOWTLIB_CACHE_LIMIT another limit
in MB.

examples:
  fowt cache
  fowt cache --clear
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser(
        "cache", help="the compiled code and other things that are kept from run to run", epilog=EXAMPLES
    )
    parser.add_argument("--clear", action="store_true", help="delete everything that is kept")
    tables.declare(parser)
    parser.set_defaults(action=cache)


def cache(arguments: argparse.Namespace) -> int:
    """Print folder, number, size and limit, and the same by kind; or delete all."""
    from fowtlib.language import cache_folder as store

    try:
        folder = store.cache_folder()
        found = store.clear() if arguments.clear else store.entries()
    except OSError as error:
        raise ModelError(f"the cache folder {error.filename}: {error.strerror}.") from None
    files, size = sum(len(entry.files) for entry in found), sum(entry.size for entry in found)
    amount = f"{files} files, {size / 1e6:.1f} MB"
    if arguments.clear:
        tables.say(arguments, f"{folder}: deleted {amount}.")
        return 0
    tables.say(arguments, f"{folder}: {amount}; the limit is {store.limit() / 1e6:g} MB.")
    rows = []
    for kind in sorted({entry.kind for entry in found}):
        own = [entry for entry in found if entry.kind == kind]
        rows.append((kind or "unfinished", len(own), sum(len(entry.files) for entry in own),
                     round(sum(entry.size for entry in own) / 1e6, 3)))  # fmt: skip
    tables.show(arguments, ("kind", "contents", "files", "size [MB]"), rows)
    return 0
