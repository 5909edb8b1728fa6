"""Variables of a design, and the space that they span: from their numbers to the parameters of a model and back."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fowtlib.design.splines import basis
from fowtlib.language.errors import ModelError, ParameterError, did_you_mean
from fowtlib.language.units import to_si

_ELEMENT = re.compile(r"(.+)\[\s*(\d+)\s*(?::\s*(\d+)\s*)?\]")
Number = float | str
"""A number in SI, or a text with its unit."""


@dataclass(frozen=True)
class Variable:
    """What an optimiser may change, between `lower` and `upper`.

    drives  the tunable parameters that take its value: paths, elements as in "tower.diameters[2]", or several of them,
            "tower.diameters[0:4]", without that of number 4. None: the parameter of the same name; of a design without
            a model, none. Empty: none, and functions alone take it, in its `unit`
    points  number of control points of a B-spline along an array, in place of its elements; see fowtlib.design.splines
    along   of a spline: a parameter with the stations of the array, or the stations; empty: equally spaced
    degree  of the spline
    start   a number, or one for each element or control point; None: what the model has
    scale   a change that matters; None: from the lower to the upper bound
    Numbers are in SI or have a unit. An array that is driven as a whole has one number for each of its elements.
    """

    name: str
    lower: Number | Sequence[Number] = -np.inf
    upper: Number | Sequence[Number] = np.inf
    start: Number | Sequence[Number] | None = None
    drives: str | Sequence[str] | None = None
    points: int | None = None
    along: str | Sequence[float] = ()
    degree: int = 3
    scale: Number | None = None
    unit: str = "1"

    def paths(self, model: bool) -> list[str]:
        """The parameters that it drives."""
        if self.drives is None:
            return [self.name] if model else []
        return [self.drives] if isinstance(self.drives, str) else list(self.drives)


@dataclass(frozen=True, eq=False)
class Placed:
    """A variable within the vector of a design: its numbers, in SI, and the matrix of each parameter it drives."""

    variable: Variable
    place: slice
    unit: str
    start: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    scale: np.ndarray
    matrices: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.variable.name

    @property
    def size(self) -> int:
        return self.start.size

    @property
    def elements(self) -> list[str]:
        """What its numbers are called."""
        return [self.name] if self.size == 1 else [f"{self.name}[{k}]" for k in range(self.size)]


@dataclass(frozen=True, eq=False)
class Space:
    """All variables of a design as one vector (n,) in SI.

    base: values of the driven parameters in the model, in which elements that no variable drives stay.
    """

    placed: tuple[Placed, ...]
    base: Mapping[str, np.ndarray] = field(default_factory=dict)

    @staticmethod
    def of(variables: Sequence[Variable], plant: Any = None) -> Space:
        """The space of variables, of a compiled model or of none. Raises ModelError for what does not fit."""
        if not variables:
            raise ModelError("a design needs variables.")
        placed: list[Placed] = []
        base: dict[str, np.ndarray] = {}
        owners: dict[tuple[str, int], str] = {}
        values = {} if plant is None else plant.parameter_values()
        first = 0
        for variable in variables:
            if variable.name in (item.name for item in placed):
                raise ModelError(f"there are two variables '{variable.name}'.")
            found = _placed(variable, plant, values, base, first)
            for path, matrix in found.matrices.items():
                for k in np.flatnonzero(np.any(matrix, axis=1)):
                    other = owners.setdefault((path, int(k)), variable.name)
                    if other != variable.name:
                        raise ModelError(f"the variables '{other}' and '{variable.name}' both drive {path}.")
            placed.append(found)
            first = found.place.stop
        return Space(tuple(placed), base)

    def __len__(self) -> int:
        return self.placed[-1].place.stop

    def __getitem__(self, name: str) -> Placed:
        for item in self.placed:
            if item.name == name:
                return item
        raise ModelError(f"there is no variable '{name}'{did_you_mean(name, self.names)}")

    @property
    def names(self) -> list[str]:
        return [item.name for item in self.placed]

    @property
    def elements(self) -> list[str]:
        """What the numbers are called, (n,)."""
        return [name for item in self.placed for name in item.elements]

    @property
    def units(self) -> list[str]:
        """Of the numbers, (n,)."""
        return [item.unit for item in self.placed for _ in range(item.size)]

    def _joined(self, name: str) -> np.ndarray:
        return np.concatenate([getattr(item, name) for item in self.placed])

    @property
    def start(self) -> np.ndarray:
        return self._joined("start")

    @property
    def lower(self) -> np.ndarray:
        return self._joined("lower")

    @property
    def upper(self) -> np.ndarray:
        return self._joined("upper")

    @property
    def scale(self) -> np.ndarray:
        return self._joined("scale")

    def parameters(self, x: np.ndarray) -> dict[str, Any]:
        """Values of the driven parameters [SI] at a point of the space."""
        values = {path: value.copy() for path, value in self.base.items()}
        for item in self.placed:
            for path, matrix in item.matrices.items():
                driven = np.any(matrix, axis=1)
                values[path].flat[driven] = (matrix @ x[item.place])[driven]
        return {path: value if value.shape else float(value) for path, value in values.items()}

    def matrix(self, path: str) -> np.ndarray:
        """Slopes (elements, n) of a driven parameter, its elements in C order, by the numbers of the space."""
        slopes = np.zeros((self.base[path].size, len(self)))
        for item in self.placed:
            if path in item.matrices:
                slopes[:, item.place] += item.matrices[path]
        return slopes

    def mapping(self, x: np.ndarray) -> dict[str, Any]:
        """Values by the names of the variables."""
        return {item.name: float(x[item.place][0]) if item.size == 1 else np.array(x[item.place])
                for item in self.placed}  # fmt: skip

    def vector(self, values: Mapping[str, Any]) -> np.ndarray:
        """The inverse of `mapping`; numbers in SI or with a unit, those left out are those of the start."""
        x = self.start
        for name, value in values.items():
            item = self[name]
            x[item.place] = _numbers(value, item.unit, item.size, name)
        return x


def _placed(variable: Variable, plant: Any, values: Mapping[str, np.ndarray], base: dict[str, np.ndarray],
            first: int) -> Placed:  # fmt: skip
    name, paths = variable.name, variable.paths(plant is not None)
    if paths and plant is None:
        raise ModelError(f"the variable '{name}' drives {paths[0]}, and the design has no model.")
    matrices: dict[str, np.ndarray] = {}
    unit, own = variable.unit, None
    for path in paths:
        whole, number = _element(plant, path, name)
        base.setdefault(whole, values[whole].astype(float))
        matrix = _matrix(variable, plant, values, whole, number)
        if own is not None and matrix.shape[1] != own.size:
            raise ModelError(f"the variable '{name}' drives arrays of {own.size} and of {matrix.shape[1]} elements.")
        if own is None:
            unit = plant.dae.parameters[whole].unit
            driven = np.any(matrix, axis=1)
            own = np.linalg.lstsq(matrix[driven], values[whole].ravel()[driven], rcond=None)[0]
        matrices[whole] = matrices[whole] + matrix if whole in matrices else matrix
    if own is None and variable.start is None:
        raise ModelError(f"the variable '{name}' needs a start: there is no model that has one.")
    size = own.size if own is not None else np.size(variable.start)
    start = own if variable.start is None else _numbers(variable.start, unit, size, name)
    lower, upper = (_numbers(value, unit, size, name) for value in (variable.lower, variable.upper))
    _check_bounds(variable, unit, start, lower, upper)
    given = np.nan if variable.scale is None else _numbers(variable.scale, unit, 1, name)
    with np.errstate(invalid="ignore"):
        range_ = upper - lower
    usual = np.where(np.isfinite(range_), range_, np.maximum(np.abs(start), 1.0))
    scale = np.where(np.isnan(given), usual, given) * np.ones(size)
    if not np.all(scale > 0):
        raise ModelError(f"the scale of the variable '{name}' is above zero.")
    return Placed(variable, slice(first, first + size), unit, start, lower, upper, scale, matrices)


def _check_bounds(variable: Variable, unit: str, start: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
    name, shown = variable.name, "" if unit == "1" else f" {unit}"
    wrong = np.flatnonzero(~(lower < upper))
    if wrong.size:
        k = wrong[0]
        way = "equal; leave the variable out" if lower[k] == upper[k] else "the wrong way round"
        raise ModelError(f"the bounds of '{name}', {lower[k]:g} and {upper[k]:g}{shown}, are {way}.")
    wrong = np.flatnonzero((start < lower - 1e-9 * np.abs(lower)) | (start > upper + 1e-9 * np.abs(upper)))
    if wrong.size:
        k = wrong[0]
        of = "of the model" if variable.start is None else "given"
        raise ModelError(
            f"the start of '{name}', {start[k]:g}{shown} as {of}, is not between its bounds {lower[k]:g} and "
            f"{upper[k]:g}{shown}; change the bounds, or give a start."
        )
    np.clip(start, lower, upper, out=start)  # what rounding has left


def _numbers(value: Any, unit: str, size: int, name: str) -> np.ndarray:
    try:
        if isinstance(value, (list, tuple, np.ndarray)):
            numbers = np.array([float(to_si(item, unit, name)) for item in np.ravel(np.asarray(value, dtype=object))])
        else:
            numbers = np.array([float(to_si(value, unit, name))])
        return np.array(np.broadcast_to(numbers, (size,)), dtype=float)
    except ModelError:
        raise
    except (TypeError, ValueError):
        raise ModelError(f"the variable '{name}' takes 1 or {size} numbers [{unit}], not {value!r}.") from None


def _element(plant: Any, path: str, name: str) -> tuple[str, slice | None]:
    """The path of a parameter and the numbers of elements, None: all. ModelError where it is not tunable."""
    found = _ELEMENT.fullmatch(path)
    whole, number = path, None
    if found is not None:
        first = int(found[2])
        whole, number = found[1], slice(first, first + 1 if found[3] is None else int(found[3]))
    declared = plant.dae.parameters.get(whole)
    if declared is None:
        raise ParameterError(f"the variable '{name}' cannot drive {whole}: {_why_not(plant, whole)}")
    size = declared.value.size
    if number is not None and (declared.value.ndim != 1 or not number.start < number.stop <= size):
        raise ParameterError(f"the variable '{name}' drives {path}: {whole} has {size} elements, from 0 on.")
    return whole, number


def _why_not(plant: Any, path: str) -> str:
    """Why a parameter is not tunable."""
    owner, _, name = path.rpartition(".")
    if path in plant.dae.bound_parameters:
        return "it is read when a run starts, such as a seed, a file or a kind, and has no slope."
    try:
        declared = plant.root.find(owner).parameters[name] if plant.root is not None else None
    except (ModelError, KeyError):
        declared = None
    if declared is None:
        known = list(plant.dae.parameters)
        return f"there is no such parameter{did_you_mean(path, known)}"
    if declared.tunable:
        return "it follows from other parameters of the model; drive those."
    return "it decides about the equations (a structural parameter); it is changed in the model, before compile()."


def _matrix(variable: Variable, plant: Any, values: Mapping[str, np.ndarray], path: str,
            number: slice | None) -> np.ndarray:  # fmt: skip
    size = values[path].size
    if number is not None:
        return np.eye(size)[:, number]
    if variable.points is None:
        return np.eye(size)
    if isinstance(variable.along, str) and variable.along:
        if variable.along not in values:
            raise ModelError(f"'{variable.name}': {variable.along} is no tunable parameter with stations"
                             f"{did_you_mean(variable.along, values)}")  # fmt: skip
        stations = values[variable.along].ravel()
    else:
        stations = np.asarray(variable.along or np.linspace(0.0, 1.0, max(size, 2))[:size], dtype=float)
    if stations.size != size:
        raise ModelError(f"'{variable.name}': {stations.size} stations for the {size} elements of {path}.")
    try:
        return basis(stations, variable.points, variable.degree)
    except ModelError as error:
        raise ModelError(f"'{variable.name}': {error}") from None
