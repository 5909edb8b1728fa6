"""`fowt equilibrium` and `fowt eigen`: the mean position, and the natural modes about it."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables

if TYPE_CHECKING:
    from fowtlib import Mode

STANDING = 1e-7  # of the fastest eigenvalue: a motion that nothing holds, zero twice and split by rounding
EQUILIBRIUM = """Still water. Without --wind the model's own wind at its mean speed.

examples:
  fowt equilibrium oc3_spar_rigid --wind steady:8
"""
EIGEN = """About the equilibrium in still water. Without --wind the model's own wind at its
mean speed.

examples:
  fowt eigen oc3_spar_rigid --wind none
  fowt eigen oc3_spar --wind none       a rotor of blade elements stands
"""


def declare(commands: Any) -> None:
    """Add the commands of this module."""
    equilibrium = commands.add_parser("equilibrium", help="the mean position in steady wind", epilog=EQUILIBRIUM)
    equilibrium.set_defaults(action=show_equilibrium)
    text = "natural frequencies, damping ratios, and which motion each mode is"
    eigen = commands.add_parser("eigen", help=text, epilog=EIGEN)
    eigen.set_defaults(action=show_modes)
    for parser in (equilibrium, eigen):
        loading.declare(parser, waves=False)
        tables.declare(parser)


def show_equilibrium(arguments: argparse.Namespace) -> int:
    """Print the results of the model at its equilibrium."""
    plant = loading.load_at_rest(arguments).compile()
    state = plant.equilibrium()
    rows = [(name, tables.rounded(state[name], 1.0), unit) for name, (_, unit, _) in plant.outputs.items()]
    tables.show(arguments, ("result", "value", "unit"), rows)
    return 0


def show_modes(arguments: argparse.Namespace) -> int:
    """Print the oscillating modes of the linear model at the equilibrium, slowest first."""
    plant = loading.load_at_rest(arguments).compile()
    modes = plant.linearize(plant.equilibrium()).modes()
    least = STANDING * max((abs(mode.eigenvalue) for mode in modes), default=0.0)
    oscillating = [mode for mode in modes if mode.eigenvalue.imag > least]
    names = {path: name for name, (path, _, _) in plant.outputs.items()}
    rows = [(m.frequency_hz, 1 / m.frequency_hz, m.damping_ratio, motion_of(m, names)) for m in oscillating]
    tables.show(arguments, ("frequency [Hz]", "period [s]", "damping ratio", "motion"), rows)
    return 0


def motion_of(mode: Mode, names: Mapping[str, str]) -> str:
    """What a person calls a mode: the result that takes the largest part in it, else the state that does.

    names: of the results by the path of their variable. A coordinate and its rate share a mode about equally.
    """
    share = {name: mode.participation.get(path, 0.0) for path, name in names.items()}
    most = max(share, key=share.__getitem__, default="")
    return most if most and share[most] > 0.5 * max(mode.participation.values()) else mode.label
