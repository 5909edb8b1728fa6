"""Design maps: what a model is like over one or two of its parameters, and where it keeps its limits."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.plants import compiled, shown_unit
from fowtlib.analysis.sheet import modes_of, what_parts_say
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.units import from_si, si_unit, to_si

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

_LIMIT = re.compile(r"\s*(.+?)\s*(<=|>=|<|>)\s*(.+?)\s*$")
OF_MODES = ("period of ", "damping ratio of ")


@dataclass(frozen=True)
class Axis:
    """A parameter of a map: its path, values (n,) in SI, its SI unit and what it means."""

    path: str
    values: np.ndarray
    unit: str
    doc: str = ""


@dataclass(frozen=True)
class Limit:
    """A quantity that must lie below or above a bound, in the unit of the quantity: `Limit.parse("pitch < 5 deg")`."""

    quantity: str
    below: bool
    bound: str

    @staticmethod
    def parse(text: str) -> Limit:
        """From a text. Raises ModelError where it is none."""
        found = _LIMIT.match(text)
        if found is None:
            raise ModelError(f"'{text}' is not a limit, such as 'pitch < 5 deg' or 'period of platform pitch > 25 s'.")
        return Limit(found[1], found[2].startswith("<"), found[3])

    def number(self, unit: str) -> float:
        """The bound in a unit; a bare number is in it already."""
        try:
            return float(self.bound)
        except ValueError:
            si = si_unit(unit)
            return float(from_si(to_si(self.bound, si, self.quantity), si, unit))

    def kept(self, values: np.ndarray, unit: str) -> np.ndarray:
        """Where the values keep it; not where they are nan."""
        bound = self.number(unit)
        return values <= bound if self.below else values >= bound

    def __str__(self) -> str:
        return f"{self.quantity} {'<' if self.below else '>'} {self.bound}"


@dataclass(frozen=True)
class ParameterMap:
    """Quantities over a grid of one or two parameters: `table[quantity]` has the shape of the grid, in `units`.

    A point without equilibrium, or without a mode that was asked for, has nan, and its sentence in `failures` under its
    place in the grid.
    """

    axes: tuple[Axis, ...]
    table: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    limits: tuple[Limit, ...] = ()
    failures: Mapping[tuple[int, ...], str] = field(default_factory=dict)

    def __getitem__(self, quantity: str) -> np.ndarray:
        if quantity not in self.table:
            raise ModelError(f"the map has no '{quantity}'{did_you_mean(quantity, self.table, list_up_to=20)}")
        return self.table[quantity]

    @property
    def quantities(self) -> list[str]:
        """What is in the table besides the parameters of the axes, which a limit may be on."""
        axes = [axis.path for axis in self.axes]
        return [name for name in self.table if name not in axes]

    @property
    def feasible(self) -> np.ndarray:
        """Where all limits are kept."""
        kept = [limit.kept(self[limit.quantity], self.units[limit.quantity]) for limit in self.limits]
        return np.all(kept, axis=0) if kept else np.isfinite(next(iter(self.table.values())))

    @property
    def dataset(self) -> xarray.Dataset:
        """Quantities, and `feasible` (1 or 0), over coordinates that are called like the parameters."""
        import xarray

        names = [axis.path for axis in self.axes]
        columns = {
            name: (names, self.table[name], {"units": self.units[name], "long_name": name}) for name in self.quantities
        }
        columns["feasible"] = (names, self.feasible.astype(int), {"units": "1", "long_name": "all limits are kept"})
        return xarray.Dataset(columns, {a.path: (a.path, a.values, {"units": a.unit}) for a in self.axes})

    def rows(self) -> Iterator[list[float]]:
        """The parameters, the quantities and whether all limits are kept, point by point."""
        kept = self.feasible
        for place in np.ndindex(*kept.shape):
            point = [float(axis.values[k]) for axis, k in zip(self.axes, place, strict=True)]
            yield [*point, *(float(self.table[name][place]) for name in self.quantities), int(kept[place])]

    def heads(self) -> list[str]:
        """Of `rows`, with units."""
        return [*(f"{axis.path} [{axis.unit}]" for axis in self.axes),
                *(f"{name} [{self.units[name]}]" for name in self.quantities), "feasible"]  # fmt: skip

    def plot(self, path: str | Path | None = None, title: str = "") -> Figure:
        """Curves over one parameter; over two, contours. What breaks a limit is hatched, limits are dashed."""
        from fowtlib.analysis.map_pictures import plot_map

        return plot_map(self, path, title)


def parameter_map(
    model: Any,
    over: Mapping[str, Sequence[Any]],
    of: Sequence[str],
    *,
    limits: Sequence[str | Limit] = (),
    parameters: Mapping[str, Any] | None = None,
    free: Mapping[str, Any] | Sequence[str] | None = None,
    targets: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> ParameterMap:
    """Quantities of a model at rest over a grid of one or two of its tunable parameters.

    model    a compiled model as it is; another is first put into still water without wind
    over     values by the path of a parameter, in SI or with units
    of       results of the model, any of its variables, what `model_sheet` says ("mass", "C33", "turbine: mass"),
             "period of ..." and "damping ratio of ..." a natural mode by its name or its number, the slowest being
             "mode 1", and parameters
    limits   such as "pitch < 5 deg"; their quantities are computed too
    parameters  values of further parameters, the same everywhere
    free, targets  parameters that take the values at which conditions hold, at each point: see Plant.equilibrium
    progress    is told how many points of how many are done

    Each point starts from the equilibrium beside it, the first one is that nearest to the values of the model. Raises
    ModelError for what is unknown. A point without equilibrium, with one that the model warns of, as a hull that lies
    on its side, or without such a mode, as one that turns over, is told in `failures`.
    """
    plant = compiled(model)
    axes = tuple(_axis(plant, path, values) for path, values in over.items())
    if not 1 <= len(axes) <= 2:
        raise ModelError(f"a map is over one or two parameters, not over {len(axes)}.")
    asked = [limit if isinstance(limit, Limit) else Limit.parse(limit) for limit in limits]
    names = list(dict.fromkeys([*of, *(limit.quantity for limit in asked)]))
    if not names:
        raise ModelError("a map needs quantities, such as 'pitch' or 'period of platform pitch'.")
    shape = tuple(axis.values.size for axis in axes)
    table = {name: np.full(shape, np.nan) for name in names}
    units: dict[str, str] = {}
    failures: dict[tuple[int, ...], str] = {}
    solved: dict[tuple[int, ...], Any] = {}
    total, first = int(np.prod(shape)), tuple(_nearest(plant, axis, parameters or {}) for axis in axes)
    for number, place in enumerate(_from(first, shape)):
        given = {axis.path: float(axis.values[k]) for axis, k in zip(axes, place, strict=True)}
        values = {**(parameters or {}), **given}
        near = next((solved[beside] for beside in _beside(place) if beside in solved), None)
        try:
            state = sound_equilibrium(plant, values, near=near, free=free, targets=targets)
        except ModelError as error:
            failures[place] = str(error)
        else:
            solved[place] = state
            for name, value, unit in quantities_at(plant, state, names):
                table[name][place], units[name] = _number(name, value), unit
            missing = [name for name in names if np.isnan(table[name][place])]
            if missing:
                failures[place] = f"the equilibrium has no '{missing[0]}'{modes_like(plant, state, missing[0])}"
        if progress is not None:
            progress(number + 1, total)
    if len(failures) == total:
        what = "an equilibrium" if not solved else "all that was asked for"
        raise ModelError(f"no point of the map has {what}; the first one: {next(iter(failures.values()))}")
    return ParameterMap(axes, table, units, tuple(asked), failures)


def _axis(plant: Any, path: str, values: Sequence[Any]) -> Axis:
    declared = plant.dae.parameters.get(path)
    if declared is None:
        plant.parameter_values({path: next(iter(values), 0.0)})  # says what is wrong with it
        raise ModelError(f"{path} is read when a run starts; a map is over tunable parameters.")
    numbers = np.array([float(to_si(value, declared.unit, path)) for value in values])
    if declared.value.shape or not numbers.size:
        raise ModelError(f"{path}: a map is over numbers, one or more, and over no element of an array.")
    return Axis(path, numbers, declared.unit, declared.doc)


def _nearest(plant: Any, axis: Axis, parameters: Mapping[str, Any]) -> int:
    """The place on an axis that is nearest to the value of the model, near which its start values are good."""
    given = {path: value for path, value in parameters.items() if path != axis.path}
    return int(np.abs(axis.values - float(plant.binding(given).values[axis.path])).argmin())


def _from(first: tuple[int, ...], shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """All places of a grid, those first that fewer steps lead to from the first one."""
    return sorted(np.ndindex(*shape), key=lambda place: sum(abs(a - b) for a, b in zip(place, first, strict=True)))


def _beside(place: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    for axis in range(len(place)):
        for step in (-1, 1):
            yield tuple(k + step * (axis == i) for i, k in enumerate(place))


def sound_equilibrium(plant: Any, values: Mapping[str, Any], **options: Any) -> Any:
    """An equilibrium; ModelError with what the model warns of, where it is out of the range of what is modelled."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        state = plant.equilibrium(values, **options)
    told = [str(one.message) for one in said if issubclass(one.category, UserWarning)]
    if told:
        raise ModelError(told[0])
    return state


def quantities_at(plant: Any, state: Any, names: Sequence[str]) -> Iterator[tuple[str, Any, str]]:
    """Name, value (a number or an array) and unit of quantities at a state; nan where it has no such mode."""
    modes: dict[str, Any] = {}
    told: dict[str, Any] = {}
    if any(name.startswith(OF_MODES) for name in names):
        entries = list(modes_of(plant, state))
        modes = {entry.quantity.partition(", with ")[0]: entry for entry in entries}  # of two motions at one period
        modes |= {entry.quantity: entry for entry in entries}
        modes |= {f"{OF_MODES[k % 2]}mode {k // 2 + 1}": entry for k, entry in enumerate(entries)}
    binding = plant.binding(state.parameters)
    rest = [name for name in names if not name.startswith(OF_MODES) and name not in binding.values]
    if not all(name in plant.outputs for name in rest):
        with binding.tree() as root:
            told = {entry.quantity: entry for entry in what_parts_say(root, state)}
    variables = [name for name in rest if name in plant.outputs or name not in told]
    found = dict(zip(variables, _variables(plant, state, variables, told), strict=True))
    for name in names:
        if name.startswith(OF_MODES):
            unit = "s" if name.startswith(OF_MODES[0]) else "1"
            yield name, modes[name].value if name in modes else np.nan, unit
        elif name in found:
            yield name, found[name], shown_unit(plant, name) if name in plant.outputs else plant.describe(name)[0]
        elif name in told:
            yield name, told[name].value, told[name].unit
        else:
            yield name, binding.values[name], plant.dae.parameters[name].unit


def modes_like(plant: Any, state: Any, name: str) -> str:
    """The end of a message about a mode that there is not, such as "period of heve": those that there are."""
    return did_you_mean(name, [entry.quantity for entry in modes_of(plant, state)], list_up_to=20)


def _variables(plant: Any, state: Any, names: Sequence[str], told: Mapping[str, Any]) -> list[Any]:
    """Results and variables by name, all at once."""
    try:
        return state.values(names)
    except ModelError:
        wrong = next((name for name in names if not _is_known(plant, name)), names[0])
        of_modes = [head + wrong.rpartition(" of ")[2] for head in OF_MODES if " of " in wrong]
        known = [*plant.outputs, *told, *plant.dae.parameters, *of_modes]
        raise ModelError(f"the model has no quantity '{wrong}'{did_you_mean(wrong, known)}") from None


def _number(name: str, value: Any) -> float:
    if np.shape(value):
        raise ModelError(f"{name} is an array of shape {np.shape(value)}; name one element, as in {name}[0].")
    return float(value)


def _is_known(plant: Any, name: str) -> bool:
    try:
        plant.dae.observe_expression(plant.outputs.entry(name).path)
    except ModelError:
        return False
    return True
