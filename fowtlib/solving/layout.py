"""Where the quantities of a flat DAE stand in x, z, d, u and p: the one place that packs and unpacks them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.errors import NotFoundError, ParameterError, SimulationError, did_you_mean
from fowtlib.language.units import to_si

Values = Mapping[str, Any]


class Layout:
    """Names and places: x, z, d give the number of a scalar by its path, u and p the slice of an input or parameter."""

    def __init__(self, dae: FlatDAE):
        self.dae = dae
        self.x, self.z, self.d = (
            {quantity.path: k for k, quantity in enumerate(group)}
            for group in (dae.states, dae.algebraics, dae.discretes)
        )
        self.u, self.p = _slices(dae.inputs), _slices(dae.parameters)

    # --- what a user gives by path -------------------------------------------------------------------------------

    def inputs(self, given: Values | None = None) -> np.ndarray:
        """The vector u: the defaults of the inputs, with those given put in."""
        values = {path: item.default for path, item in self.dae.inputs.items()}
        for path, value in (given or {}).items():
            if path not in values:
                raise ParameterError(f"there is no input '{path}'{did_you_mean(path, values)}")
            numbers = _finite(to_si(value, self.dae.inputs[path].unit, path), f"the input {path}").ravel()
            values[path] = np.broadcast_to(numbers, values[path].shape)
        return _joined(list(values.values()))

    def put(self, start: Values, x: np.ndarray, z: np.ndarray, d: np.ndarray) -> set[int]:
        """Write start values, SI or with unit, into x, z and d; the numbers of the states among them."""
        groups = ((self.x, x), (self.z, z), (self.d, d))
        for path, value in start.items():
            found = next(((places[path], column) for places, column in groups if path in places), None)
            if found is None:
                names = [name for places, _ in groups for name in places]
                raise ParameterError(
                    f"'{path}' is not a state and cannot be given a start value{did_you_mean(path, names)}"
                )
            number, column = found
            column[number] = _finite(to_si(value, self.dae.units[path], path), f"the start value of {path}")
        return {self.x[path] for path in start if path in self.x}

    def vectors(self, *groups: Mapping[str, float]) -> list[np.ndarray]:
        """The vectors x, z and d of values by path, as a result holds them."""
        vectors = []
        for places, values in zip((self.x, self.z, self.d), groups, strict=True):
            missing = [path for path in places if path not in values]
            if missing:
                raise SimulationError(
                    f"the result to resume from is of another model: it has no {missing[0]}. "
                    "Resume with the model it came from."
                )
            vectors.append(np.array([values[path] for path in places]))
        return vectors

    def symbols(self, path: str) -> tuple[list[ca.SX], list[str]]:
        """Symbols of an input or a tunable parameter, and their names: path, or path[i] of several."""
        for places, column in ((self.u, self.dae.u), (self.p, self.dae.p)):
            if path in places:
                of = range(places[path].start, places[path].stop)
                labels = [path] if len(of) == 1 else [f"{path}[{i}]" for i in range(len(of))]
                return [column[i] for i in of], labels
        known = [*self.u, *self.p]
        raise NotFoundError(f"there is no input or tunable parameter '{path}'{did_you_mean(path, known)}")


def _finite(value: Any, what: str) -> np.ndarray:
    numbers = np.asarray(value, dtype=float)
    if not np.all(np.isfinite(numbers)):
        raise ParameterError(f"{what} is {numbers}; a finite number is expected.")
    return numbers


def _slices(items: Mapping[str, Any]) -> dict[str, slice]:
    slices, first = {}, 0
    for path, item in items.items():
        slices[path] = slice(first, first + item.symbol.numel())
        first += item.symbol.numel()
    return slices


def _joined(columns: list[np.ndarray]) -> np.ndarray:
    return np.concatenate(columns) if columns else np.zeros(0)
