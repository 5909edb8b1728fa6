"""A point in the state space of a compiled model."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.whole_files import write_text
from fowtlib.solving.results.html import table

GROUPS = {"x": "states", "z": "algebraics", "d": "discretes"}


@dataclass(frozen=True, repr=False)
class State:
    """Time t [s], states x, algebraic unknowns z, discrete variables d, inputs u, at given parameter values.

    `state["platform.motion.surge"]` gives any variable of the model, in SI units.
    """

    t: float
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    u: np.ndarray
    parameters: Mapping[str, Any] = field(default_factory=dict)
    observe: Callable[[Sequence[str], State], list[np.ndarray]] | None = field(default=None, repr=False, compare=False)
    plant: Any = field(default=None, repr=False, compare=False)

    def __getitem__(self, name: str) -> float | np.ndarray:
        return self.values([name])[0]

    def values(self, names: Sequence[str]) -> list[float | np.ndarray]:
        """What `state[name]` gives for each name, at once, which is quicker."""
        values = [value.squeeze() for value in self.observe(names, self)] if len(names) else []
        return [float(value) if value.shape == () else value for value in values]

    def save(self, path: str | Path) -> Path:
        """Write the values by path, in SI, as .json; `State.open(path, plant)` reads them."""
        path = Path(path)
        if path.suffix != ".json":
            raise ModelError(f"{path}: a state is saved as .json, not as '{path.suffix or 'no ending'}'.")
        content: dict[str, Any] = {"fowtlib": "state", "time": self.t}
        for group, name in GROUPS.items():
            quantities = getattr(self.plant.dae, name)
            values = getattr(self, group).tolist()
            content[name] = {q.path: value for q, value in zip(quantities, values, strict=True)}
        return write_text(path, json.dumps(content, indent=1))

    @staticmethod
    def open(path: str | Path, plant: Any, parameters: Mapping[str, Any] | None = None) -> State:
        """The state of a file for a compiled model, with these parameter values; its unknowns are solved for anew."""
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise ModelError(f"{path}: cannot be read: {error.strerror}.") from None
        except ValueError:
            content = None
        if not isinstance(content, dict) or content.get("fowtlib") != "state":
            raise ModelError(f"{path}: this is not a state that `state.save` wrote.")
        known = {name: {q.path for q in getattr(plant.dae, name)} for name in GROUPS.values()}
        for name in ("states", "discretes"):
            missing = sorted(known[name] - content.get(name, {}).keys())
            if missing:
                raise SimulationError(f"{path}: the state is of another model: it has no {missing[0]}.")
        given = {
            path: value for name, paths in known.items() for path, value in content[name].items() if path in paths
        }
        return plant.initial_state(parameters, given, t=float(content["time"]))

    @staticmethod
    def of(value: Any, what: str) -> State:
        """The value where it is a state. Raises ModelError with what it was given for, where it is something else."""
        if isinstance(value, State):
            return value
        raise ModelError(
            f"{what} is a state of the model, as plant.equilibrium() or plant.initial_state() gives it, not {value!r}."
        )

    def __repr__(self) -> str:
        what = f" of {self.plant.title or self.plant.name}" if self.plant is not None else ""
        return f"<State{what}: t = {self.t:g} s, {self.x.size} states, {self.z.size} unknowns>"

    def _repr_html_(self) -> str:
        if self.plant is None:
            return table((), (), repr(self)[1:-1])
        rows = []
        for name, entry in self.plant.outputs.items():
            value = self[name]
            rows.append((name, value if isinstance(value, float) else "(array)", entry.unit, entry.doc))
        return table(("output", "value", "unit", ""), rows, repr(self)[1:-1])
