"""`fowt models`, `fowt new`, `fowt parts`, `fowt schema`: what there is to build with."""

from __future__ import annotations

import argparse
from typing import Any

from fowtlib.cli import tables
from fowtlib.language.errors import NotFoundError, did_you_mean


def declare(commands: Any) -> None:
    """Add the commands of this module."""
    parts = commands.add_parser("parts", help="the catalogue of component classes, or one class in full")
    parts.add_argument("name", nargs="?", metavar="CLASS", help="a class, or a group such as mechanics")
    parts.add_argument("--markdown", action="store_true", help="the whole catalogue as a page of the documentation")
    tables.declare(parts)
    parts.set_defaults(action=show_parts)


def show_parts(arguments: argparse.Namespace) -> int:
    """Print the catalogue, one group of it, or one class."""
    from dataclasses import asdict

    from fowtlib.cli import catalogue

    classes = catalogue.classes()
    if arguments.markdown:
        print(catalogue.markdown(classes), end="")
        return 0
    chosen = [item for item in classes if arguments.name in (None, item.group, item.name)]
    if not chosen:
        known = {name: None for item in classes for name in (item.group, item.name)}
        raise NotFoundError(f"there is no part '{arguments.name}'{did_you_mean(arguments.name, known)}")
    if arguments.form == "json":
        tables.show_json([asdict(item) for item in chosen])
    elif chosen[0].name == arguments.name:
        _show_class(arguments, chosen[0])
    else:
        tables.show(arguments, ("class", "group", "what it is"), [(c.name, c.group, c.summary) for c in chosen])
    return 0


def _show_class(arguments: argparse.Namespace, item: Any) -> None:
    from fowtlib.cli.catalogue import KINDS

    if arguments.form == "":
        print(f"{item.name} ({item.group})\n\n{item.doc}")
    rows = [(kind[:-1], e.name, e.type, e.unit, e.default, e.doc) for kind in KINDS for e in getattr(item, kind)]
    tables.show(arguments, ("kind", "name", "type", "unit", "default", "what it is"), rows)
