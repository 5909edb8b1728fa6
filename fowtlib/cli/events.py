"""`fowt events`: what can happen in a run of a model; and the option `--event` of commands that run one."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.solving.timeline import Event

EVENTS = """names that are not needed to tell events apart may be left out of a path:
turbine.grid_loss for turbine.safety.grid_loss

examples:
  fowt events oc3_spar_rigid
  fowt run oc3_spar_rigid --time 100 --event "turbine.grid_loss at 50 s"
"""
SHOWN = {"rad": "deg", "rad/s": "deg/s"}


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("events", help="what can happen in a run: faults, shutdowns, losses", epilog=EVENTS)
    loading.declare(parser, wind=False, waves=False, runs=False)
    tables.declare(parser)
    parser.set_defaults(action=show_events)


def declare_option(parser: argparse.ArgumentParser) -> None:
    """Add `--event`."""
    parser.add_argument(
        "--event", dest="events", metavar="EVENT", action="append", default=[],
        help="NAME at TIME[, value=..], or NAME when RESULT > VALUE[, value=..]: what happens in the run, see `fowt "
        "events`; may be repeated; instead of the events of the model file",
    )  # fmt: skip


def chosen(arguments: argparse.Namespace) -> list[Event] | None:
    """The events of the command line; None where it has none."""
    from fowtlib.solving.timeline import Event

    try:
        return [Event.parse(text) for text in arguments.events] or None
    except ModelError as error:
        raise error.at("--event") from None


def show_events(arguments: argparse.Namespace) -> int:
    """Print the events that the parts of a model offer, with the values that they take."""
    plant = loading.load(arguments).compile()
    rows = []
    for item in plant.offered_events():
        values = [f"{name} = {_shown(value, unit)} ({doc})" for name, value, unit, doc in item.values]
        rows.append((item.path, item.doc, "; ".join(values)))
    columns = ("event", "what happens", "values")
    if not rows and not arguments.form:
        print("no part of this model offers any event.")
        return 0
    tables.show(arguments, columns, rows)
    return 0


def _shown(value: float, unit: str) -> str:
    from fowtlib.language.units import from_si

    out = SHOWN.get(unit, unit)
    return f"{from_si(value, unit, out):.5g}" + ("" if unit == "1" else f" {out}")
