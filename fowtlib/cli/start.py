"""`fowt run --start`: where a simulation begins, besides the start values of the model file."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading
from fowtlib.language.errors import ModelError, ParameterError, SimulationError, one_of
from fowtlib.language.native import compiler, no_compiler

if TYPE_CHECKING:
    from fowtlib import Model, Plant, State

KINDS = ("equilibrium", "turning", "rest", "file")
HELP = (
    "equilibrium: the mean position, in the mean of the wind; turning: the same, and rotors of blade elements turn; "
    "rest: nothing moves, the rotors stand; file: the start values of the model file; or a FILE: the end of a result "
    "(.nc), a saved state (.json); default: simulation.start of the model file, or file"
)


def start_values(arguments: argparse.Namespace, model: Model, plant: Plant) -> tuple[Mapping[str, Any] | None, str]:
    """Start values by path for the run, and a word for the first line of the answer; None for those of the model."""
    if arguments.start and arguments.resume:
        raise ModelError("--start and --resume: a run either starts, or goes on from where another one ended.")
    if arguments.resume:
        return None, f"going on from {arguments.resume}"
    word = arguments.start or model.settings.get("start", "file")
    if word == "turning" and not arguments.start and not compiler():
        warnings.warn(
            f"The mean of the turning rotors is not sought, which takes long: {no_compiler()} So the run starts from "
            "the values of the model file; --start turning seeks it all the same.", stacklevel=1
        )  # fmt: skip
        return None, ""
    try:
        return _start_values(word, model, plant)
    except SimulationError as error:
        if arguments.start:
            raise
        warnings.warn(f"{error} So the run starts from the values of the model file.", stacklevel=1)
        return None, ""


def _start_values(word: str, model: Model, plant: Plant) -> tuple[Mapping[str, Any] | None, str]:
    if word == "file":
        return None, ""
    if word == "rest":
        from fowtlib.solving.modes import rate_states

        rates = [plant.dae.states[k].path for k in rate_states(plant.dae).values()]
        return dict.fromkeys(rates, 0.0), "from rest"
    if word in ("equilibrium", "turning"):
        return _values(_mean(model, plant, word), plant), "from the mean position"
    if Path(word).suffix in (".nc", ".json"):
        return _of_file(Path(word), plant), f"from {word}"
    raise ModelError(f"--start: '{word}' is not {one_of(KINDS)}, nor a file of a result (.nc) or a state (.json).")


def _mean(model: Model, plant: Plant, word: str) -> State:
    from fowtlib.solving.turning import mean_state

    values = loading.mean_conditions(model)
    try:
        plant.binding(values)
    except ParameterError:  # a wind or sea with equations of its own, such as one from outside
        plant, values = loading.in_the_mean(model).compile(), {}
    try:
        return mean_state(plant, values, near=True) if word == "turning" else plant.equilibrium(values)
    except SimulationError as error:
        if word == "equilibrium" and "turns on and on" in error.message:
            error.message += " To start from the mean of a turning rotor: --start turning."
        raise


def _values(state: State, plant: Plant) -> dict[str, float]:
    """Those values of a state of another compiled model that this one has, too."""
    known = {q.path for group in (plant.dae.states, plant.dae.algebraics, plant.dae.discretes) for q in group}
    dae = state.plant.dae
    groups = ((dae.states, state.x), (dae.algebraics, state.z), (dae.discretes, state.d))
    return {
        q.path: float(value)
        for quantities, values in groups
        for q, value in zip(quantities, values, strict=True)
        if q.path in known
    }


def _of_file(path: Path, plant: Plant) -> dict[str, float]:
    from fowtlib.solving import Result, State

    if path.suffix == ".json":
        return _values(State.open(path, plant), plant)
    result = Result.open(path)
    if result.raw is None or not result.raw.time.size:
        raise ModelError(f"{path}: the file holds no states to start from.")
    end = result.final
    missing = [q.path for q in plant.dae.states if q.path not in end.x]
    if missing:
        raise ModelError(f"{path}: the result is of another model: it has no {missing[0]}.")
    names = {q.path for group in (plant.dae.states, plant.dae.algebraics, plant.dae.discretes) for q in group}
    return {key: float(value) for part in (end.x, end.z, end.d) for key, value in part.items() if key in names}
