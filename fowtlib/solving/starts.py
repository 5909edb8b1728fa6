"""Where a run starts, by a word or a file: `start` of a run, a case, a model file, and `fowt run --start`.

A mean is one of the run's own conditions without what changes in time: each part says by `in_the_mean` how it is then,
as a turbulent wind that is steady at its mean speed. What was found once is kept in the plant, by the values of the
parameters that are left, so that all runs of a batch at one wind speed share one mean.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError, SimulationError, one_of
from fowtlib.language.native import compiler, no_compiler
from fowtlib.solving.binding import RunTrees
from fowtlib.solving.checks import check_state
from fowtlib.solving.known_again import kept_or_found
from fowtlib.solving.paths import spread_out
from fowtlib.solving.rates import rate_states
from fowtlib.solving.results import Result
from fowtlib.solving.state import State
from fowtlib.solving.stationary import SlowModes, slow_modes
from fowtlib.solving.structure import plain, structural_values
from fowtlib.solving.turning import mean_state

KINDS = ("equilibrium", "turning", "stationary", "rest", "file")
KEPT = 1000  # means of a plant; the oldest are dropped
FEW = 50  # linear models of a plant, of the last means

Values = Mapping[str, Any]
Plant = Any
"""fowtlib.solving.plant.Plant, which imports this module."""

_digests: WeakKeyDictionary[Plant, str] = WeakKeyDictionary()
_modes: WeakKeyDictionary[Plant, dict[str, SlowModes]] = WeakKeyDictionary()


def start_values(plant: Plant, word: str, parameters: Values | None = None,
                 inputs: Values | None = None) -> tuple[dict[str, float] | None, str]:  # fmt: skip
    """Start values by path for a run with these parameters, and where they are from, in words.

    word: "equilibrium", the mean position in the mean of wind and waves; "turning", the same where rotors of blade
    elements turn; "stationary", that mean and the response of the slow motions to the waves and the wind before t = 0,
    see solving.stationary; "rest", nothing moves; "file", the start values of the model file, which is None; the path
    of a result (.nc), for its end, or of a state (.json); "", simulation.start of the model file, else "file".
    Raises SimulationError where there is no mean; where the word is the model file's that is a warning, and the values
    are those of the file.
    """
    parameters = _whole_paths(plant, parameters)
    if word:
        return _by_word(plant, word, parameters, inputs)
    word = plant.settings.get("start", "file")
    if word == "turning" and not compiler():
        warnings.warn(
            f"The mean of the turning rotors is not sought, which takes long: {no_compiler()} So the run starts from "
            "the values of the model file; --start turning seeks it all the same.", stacklevel=2
        )  # fmt: skip
        return None, ""
    try:
        return _by_word(plant, word, parameters, inputs)
    except SimulationError as error:
        warnings.warn(f"{error} So the run starts from the values of the model file.", stacklevel=2)
        return None, ""


def _by_word(plant: Plant, word: str, parameters: Values | None,
             inputs: Values | None) -> tuple[dict[str, float] | None, str]:  # fmt: skip
    if word == "file":
        return None, ""
    if word == "rest":
        rates = [plant.dae.states[k].path for k in rate_states(plant.dae).values()]
        return dict.fromkeys(rates, 0.0), "from rest"
    if word in ("equilibrium", "turning"):
        return _mean(plant, word, parameters, inputs), "from the mean position"
    if word == "stationary":
        return _stationary(plant, parameters, inputs), "from the stationary state about the mean position"
    if Path(word).suffix in (".nc", ".json"):
        return _of_file(Path(word), plant), f"from {word}"
    raise ModelError(f"start: '{word}' is not {one_of(KINDS)}, nor a file of a result (.nc) or a state (.json).")


# --- means --------------------------------------------------------------------------------------------------------


def mean_values(root: Component) -> dict[str, Any]:
    """Values by path with which nothing in a component tree changes in time; those of its parts' `in_the_mean`."""
    return {join(part.path, name): value for part in root.walk() for name, value in _in_the_mean(part).items()}


def _in_the_mean(part: Component) -> dict[str, Any]:
    """What a part says of its mean; nothing of a kind with equations of its own, such as wind from outside.

    Where it becomes another kind it keeps what the two have by default in different ways, such as the shear of a wind.
    """
    changes, family = part.in_the_mean(), part.family
    if family is None or family.selector not in changes:
        return changes
    if family.own_equations(type(part)):
        return {}
    new = family.kinds[changes[family.selector]]
    differ = {
        name: part.parameter_value(name)
        for name in family.base.parameters
        if name not in changes and name not in part.void and name != family.selector and not part.is_set(name)
        and new.parameters[name].default != type(part).parameters[name].default
    }  # fmt: skip
    return {**changes, **differ}


def mean_parameters(plant: Plant, parameters: Values | None = None, root: Component | None = None) -> dict[str, Any]:
    """The parameters of the mean of a run with these parameters; what belongs to a kind that is left is not in them.

    root: the component tree of the run, where there is one already.
    """
    given = _whole_paths(plant, parameters) or {}
    if root is not None or plant.root is None:
        return _in_the_mean_of(given, root)
    trees = plant.functions.once("trees of runs", lambda: RunTrees(plant.dae, plant.root))
    with trees.lent(given) as tree:
        return _in_the_mean_of(given, tree)


def _in_the_mean_of(given: dict[str, Any], root: Component | None) -> dict[str, Any]:
    for part in root.walk() if root is not None else ():
        changes = _in_the_mean(part)
        if not changes:
            continue
        given = {path: value for path, value in given.items() if part.path not in (path, path.rpartition(".")[0])}
        known = part.family.base.parameters if part.family is not None else part.parameters
        kept = [name for name in part._values if name in known and (known[name].bound or known[name].tunable)]
        given |= {join(part.path, name): part.parameter_value(name) for name in kept if name not in changes}
        given |= {join(part.path, name): value for name, value in changes.items()}
    return given


def _whole_paths(plant: Plant, parameters: Values | None) -> dict[str, Any] | None:
    """Parameters by paths without stars."""
    if parameters is None or plant.root is None:
        return None if parameters is None else dict(parameters)
    return spread_out(parameters, plant.root)


def _mean(plant: Plant, word: str, parameters: Values | None, inputs: Values | None) -> dict[str, float]:
    mean = mean_parameters(plant, parameters)
    key = f"{word} {_digest(plant, parameters, mean, inputs)}"
    if key not in plant.kept_starts:
        found = kept_or_found(plant.dae, "start", [key], lambda: _by_path(_found(plant, word, mean, inputs)))
        while len(plant.kept_starts) >= KEPT:
            del plant.kept_starts[next(iter(plant.kept_starts))]
        plant.kept_starts[key] = found
    return dict(plant.kept_starts[key])


def _found(plant: Plant, word: str, mean: Values, inputs: Values | None) -> State:
    if word == "turning":
        return mean_state(plant, mean, inputs, near=True)
    try:
        return plant.equilibrium(mean, inputs=inputs)
    except SimulationError as error:
        if "turns on and on" in error.message:
            error.message += " To start from the mean of a turning rotor: --start turning."
        raise


def _stationary(plant: Plant, parameters: Values | None, inputs: Values | None) -> dict[str, float]:
    """The mean, and the linear response of the slow motions to what has always driven the run."""
    values, mean = _mean(plant, "turning", parameters, inputs), mean_parameters(plant, parameters)
    known = _modes.setdefault(plant, {})
    key = _digest(plant, parameters, mean, inputs)
    if key not in known:
        while len(known) >= FEW:
            del known[next(iter(known))]
        known[key] = slow_modes(plant.at(mean), plant, plant.initial_state(mean, values, inputs))
    modes = known[key]
    deviation = modes.response(plant.binding(parameters))
    if modes.sound:
        moved = _moved(plant, values, deviation)
        try:
            check_state(plant.at(parameters), plant.initial_state(parameters, moved, inputs), plant.name, warn=False)
        except SimulationError as error:
            warnings.warn(f"the start moves the bodies alone, not rotors and controllers: {error}", stacklevel=2)
        else:
            return moved
    return _moved(plant, values, np.where(modes.moved, deviation, 0.0))


def _moved(plant: Plant, values: Values, deviation: np.ndarray) -> dict[str, float]:
    """Start values with the states moved."""
    changes = zip(plant.dae.states, deviation.tolist(), strict=True)
    return {**values, **{state.path: values[state.path] + change for state, change in changes}}


def _digest(plant: Plant, parameters: Values | None, mean: Values, inputs: Values | None) -> str:
    """Of the model and of all values that a mean depends on; the same in every process."""
    binding = plant.binding(parameters)

    def value(path: str) -> Any:
        owner, _, name = path.rpartition(".")
        if isinstance(mean[path], Component):
            part = binding.root.find(path)
            return [type(part).__name__, {name: plain(part.parameter_value(name)) for name in part.parameters}]
        if binding.root is None or parameters is None or path not in parameters or mean[path] is not parameters[path]:
            return plain(mean[path])  # a number, which a part says
        return plain(binding.root.find(owner).parameter_value(name))

    files = {path: digest for path, digest in binding.data.items() if path in mean}
    given = {path: plain(item) for path, item in plant.input_paths(inputs).items()}
    return _hashed([model_digest(plant), {path: value(path) for path in mean}, files, given])


def model_digest(plant: Plant) -> str:
    """Of the states, the structure, the data files and the parameters that a plant was compiled with."""
    if plant not in _digests:
        binding = plant.binding()
        values = {path: value.tolist() for path, value in binding.values.items()}
        structure = structural_values(plant.root) | dict(binding.data)
        _digests[plant] = _hashed([[state.path for state in plant.dae.states], structure, values])
    return _digests[plant]


def _hashed(content: Any) -> str:
    return hashlib.blake2b(json.dumps(content, sort_keys=True).encode(), digest_size=16).hexdigest()


# --- states and results -------------------------------------------------------------------------------------------


def _by_path(state: State) -> dict[str, float]:
    dae = state.plant.dae
    groups = ((dae.states, state.x), (dae.algebraics, state.z), (dae.discretes, state.d))
    return {q.path: float(value) for known, values in groups for q, value in zip(known, values, strict=True)}


def _of_file(path: Path, plant: Plant) -> dict[str, float]:
    if path.suffix == ".json":
        return _by_path(State.open(path, plant))
    result = Result.open(path)
    if result.raw is None or not result.raw.time.size:
        raise ModelError(f"{path}: the file holds no states to start from.")
    end = result.final
    missing = [q.path for q in plant.dae.states if q.path not in end.x]
    if missing:
        raise ModelError(f"{path}: the result is of another model: it has no {missing[0]}.")
    names = {q.path for group in (plant.dae.states, plant.dae.algebraics, plant.dae.discretes) for q in group}
    return {key: float(value) for part in (end.x, end.z, end.d) for key, value in part.items() if key in names}
