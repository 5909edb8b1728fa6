"""`fowt check`, `fowt tree`, `fowt equations`, `fowt parameters`: look at a model without solving it."""

from __future__ import annotations

import argparse
import itertools
import textwrap
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.weather import weather

CHECK = """exit status: 0 nothing wrong, 1 something found, 2 the model cannot be built

examples:
  fowt check my_spar.yaml
"""
TREE = """examples:
  fowt tree oc3_spar_rigid
"""
EQUATIONS = """examples:
  fowt equations oc3_spar_rigid platform.motion
"""
PARAMETERS = """A structural parameter decides how the model is built, and says why; a bound
one is read when a run starts; the others are tunable.

examples:
  fowt parameters oc3_spar_rigid
  fowt parameters oc3_spar_rigid --csv > parameters.csv
"""


def declare(commands: Any) -> None:
    """Add the commands of this module."""
    check = commands.add_parser("check", help="structure, units and connections of a model", epilog=CHECK)
    loading.declare(check, runs=False)
    check.set_defaults(action=check_model)

    tree = commands.add_parser("tree", help="the parts of a model", epilog=TREE)
    loading.declare(tree, runs=False)
    tables.declare(tree)
    tree.set_defaults(action=show_tree)

    equations = commands.add_parser("equations", help="the equations of a model, or of one part", epilog=EQUATIONS)
    loading.declare(equations, runs=False)
    equations.add_argument("path", metavar="PATH", nargs="?", default="", help="a part, for example platform.motion")
    tables.declare(equations)
    equations.set_defaults(action=show_equations)

    parameters = commands.add_parser("parameters", help="every parameter: value, unit, meaning", epilog=PARAMETERS)
    loading.declare(parameters, runs=False)
    tables.declare(parameters)
    parameters.set_defaults(action=show_parameters)


def check_model(arguments: argparse.Namespace) -> int:
    """Print the report of the checks; status 1 when something was found."""
    model = loading.load(arguments)
    report = model.check()
    if conditions := weather(model, arguments):
        print(conditions)
    print(report)
    return 0 if report.ok else 1


def show_tree(arguments: argparse.Namespace) -> int:
    """Print the tree of parts."""
    model = loading.load(arguments)
    rows = [(part.path, type(part).__name__) for part in model.root.walk() if part.path]
    tables.say(arguments, weather(model, arguments))
    if arguments.form:
        tables.show(arguments, ("part", "class"), rows)
        return 0
    tables.save(arguments, ("part", "class"), rows)
    print(model.tree())
    return 0


def show_equations(arguments: argparse.Namespace) -> int:
    """Print the flat equations that the parts at and below a path have written."""
    model = loading.load(arguments)
    model.root.find(arguments.path)
    table = model.compile().dae.equation_table
    inside = [row for row in table if not arguments.path or f"{row[0]}.".startswith(f"{arguments.path}.")]
    rows = [(part, f"{left} = {right}") for part, left, right in inside]
    columns = ("part", "equation")
    tables.say(arguments, weather(model, arguments))
    if arguments.form:
        tables.show(arguments, columns, rows)
        return 0
    tables.save(arguments, columns, rows)
    for part, equations in itertools.groupby(rows, key=lambda row: row[0]):
        print(part or "the model", *(equation for _, equation in equations), sep="\n    ")
    return 0


def show_parameters(arguments: argparse.Namespace) -> int:
    """Print the parameters of all parts in the order of the tree."""
    from fowtlib.language.declarations import join

    rows = []
    model = loading.load(arguments)
    tables.say(arguments, weather(model, arguments))
    for part in model.root.walk():
        for name, field in part.parameters.items():
            kind = "tunable" if field.tunable else "bound" if field.bound else "structural"
            row = (join(part.path, name), part.parameter_value(name), field.unit, kind, field.doc, field.why_structural)
            rows.append(row)
    columns = ("parameter", "value", "unit", "kind", "what it is", "why structural")
    if arguments.form:
        tables.show(arguments, columns, rows)
        return 0
    tables.save(arguments, columns, rows)
    width = tables.console().width
    for path, value, unit, _, doc, why in rows:
        plain = isinstance(value, (str, bool)) or unit == "1"
        value = tables.cell(value) or "(no value)"
        text = value if plain or value == "(no value)" else f"{value} {unit}"
        print(f"{path} = {text}")
        sentence = f"{doc} (structural: {why})" if why else doc
        print(textwrap.fill(sentence, width, initial_indent="    ", subsequent_indent="    "))
    return 0
