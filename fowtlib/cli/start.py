"""`fowt run --start`: where a simulation begins."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib import Plant

HELP = (
    "equilibrium: the mean position, in the mean of the wind; turning: the same, and rotors of blade elements turn; "
    "stationary: that, and the slow motions as the wind and the waves before have made them; rest: nothing moves, the "
    "rotors stand; file: the start values of the model file; or a FILE: the end of a result (.nc), a saved state "
    "(.json); default: simulation.start of the model file, or file"
)


def start_values(arguments: argparse.Namespace, plant: Plant) -> tuple[Mapping[str, Any] | None, str]:
    """Start values by path for the run, and a word for the first line of the answer; None for those of the model."""
    from fowtlib.solving import starts

    if arguments.start and arguments.resume:
        raise ModelError("--start and --resume: a run either starts, or goes on from where another one ended.")
    if arguments.resume:
        return None, f"going on from {arguments.resume}"
    try:
        return starts.start_values(plant, arguments.start or "")
    except ModelError as error:
        if error.message.startswith("start: "):
            error.message = f"--{error.message}"
        raise
