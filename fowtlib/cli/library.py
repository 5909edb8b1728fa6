"""`fowt models`, `fowt new`, `fowt parts`, `fowt schema`: what there is to build with."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from fowtlib.cli import tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean, one_of
from fowtlib.language.whole_files import write_text

NEW = """examples:
  fowt new my_spar
  fowt new my_multi_rotor --like two_rotor_spar_rigid
"""
PARTS = """examples:
  fowt parts hydro
  fowt parts MorisonDrag
"""
SCHEMA = """examples:
  fowt schema > fowtlib.schema.json
"""


def declare(commands: Any) -> None:
    """Add the commands of this module."""
    models = commands.add_parser("models", help="the models that are shipped")
    tables.declare(models)
    models.set_defaults(action=show_models)

    new = commands.add_parser("new", help="a model file of your own, to start from", epilog=NEW)
    new.add_argument("name", metavar="NAME", help="name of the model; the file is NAME.yaml")
    new.add_argument("--like", default="oc3_spar_rigid", metavar="MODEL", help="what is copied; default: %(default)s")
    new.set_defaults(action=write_new)

    parts = commands.add_parser("parts", help="the catalogue of component classes, or one class in full", epilog=PARTS)
    parts.add_argument("name", nargs="?", metavar="CLASS", help="a class, or a group such as mechanics")
    parts.add_argument("--markdown", action="store_true", help="the whole catalogue as a page of the documentation")
    tables.declare(parts)
    parts.set_defaults(action=show_parts)

    schema = commands.add_parser("schema", help="a JSON schema of model files, for editors", epilog=SCHEMA)
    schema.set_defaults(action=show_schema)


def show_models(arguments: argparse.Namespace) -> int:
    """Print name and title of every shipped model."""
    from fowtlib.modelfile import models

    tables.show(arguments, ("model", "title"), models().items())
    return 0


def write_new(arguments: argparse.Namespace) -> int:
    """Copy a shipped model into a file of the user."""
    from fowtlib.modelfile.files import find_model

    path = Path(arguments.name)
    if not path.name:
        raise ModelError(f"'{arguments.name}' is not a name; write, for example, fowt new my_spar.")
    if path.suffix != ".yaml":
        path = path.with_name(f"{path.name}.yaml")
    if path.exists():
        raise ModelError(f"{path} exists already; choose another name.")
    check_target(path, (".yaml",), force=False)
    text = find_model(arguments.like).read_text(encoding="utf-8")
    head = f"# A copy of {arguments.like}, made by `fowt new`. Check it: fowt check {path}   Run it: fowt run {path}\n"
    write_text(path, head + re.sub(r"^title:.*$", f"title: {path.stem}", text, count=1, flags=re.M))
    say_saved(path)
    return 0


def show_schema(arguments: argparse.Namespace) -> int:
    """Print the JSON schema."""
    from fowtlib.modelfile.schema import schema

    tables.show_json(schema())
    return 0


def show_parts(arguments: argparse.Namespace) -> int:
    """Print the catalogue, one group of it, or one class."""
    from dataclasses import asdict

    from fowtlib.cli import catalogue
    from fowtlib.modelfile.catalogue import derived_from

    classes = catalogue.classes()
    if arguments.markdown:
        print(catalogue.markdown(classes), end="")
        return 0
    chosen = [item for item in classes if arguments.name in (None, item.group, item.name)]
    if not chosen:
        made = derived_from(arguments.name)
        if made:
            raise NotFoundError(f"'{arguments.name}' is a base of other classes, no part: see {one_of(made)}.")
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
