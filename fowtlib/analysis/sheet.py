"""The sheet of a model: what two people compare first when two programs differ.

Masses, centres and inertia; displaced volume, stiffness and added mass of floating bodies; position and tensions at
rest; natural periods; the response to waves at a few frequencies. What the parts say of themselves is in their
`facts()` (fowtlib.language.facts).
"""

from __future__ import annotations

import csv
import io
import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.analysis.masses import Placed, centre_of_mass, placed_bodies
from fowtlib.analysis.plants import MOTIONS, compiled, shown_unit
from fowtlib.analysis.rao import linear_rao, wave_inputs
from fowtlib.analysis.upright import facts_of, metacentre, warn_unless_upright
from fowtlib.language import facts
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError, SimulationError, UnitError, did_you_mean
from fowtlib.language.expressions import one_evaluation
from fowtlib.language.units import from_si, si_unit, to_si
from fowtlib.language.whole_files import write_text
from fowtlib.solving import mean_state, natural_modes
from fowtlib.solving.results.html import table

FREQUENCIES = (0.04, 0.06, 0.08, 0.1, 0.12)
"""Of the response to waves [Hz]."""

HEADS = ("group", "quantity", "value", "unit")
_WITH_LENGTHS = {"N/m": ("N/m", "N", "N m"), "kg": ("kg", "kg m", "kg m^2")}  # unit times m^0, m^1, m^2
_NOISE = 1e-6  # of sqrt(M_ii M_jj): an element of a matrix that is left out


@dataclass(frozen=True)
class Entry:
    """One line: a number in `unit`, under the name of its quantity, which is unique on a sheet."""

    group: str
    quantity: str
    value: float
    unit: str


@dataclass(frozen=True)
class Difference:
    """A quantity of two sheets, in the unit of the first."""

    quantity: str
    unit: str
    first: float
    second: float

    @property
    def percent(self) -> float:
        """The difference in percent of the second value; infinite where that alone is zero."""
        if self.first == self.second:
            return 0.0
        return 100.0 * (self.first - self.second) / abs(self.second) if self.second else math.inf


@dataclass(frozen=True)
class Sheet:
    """Numbers of a model by the names of their quantities: `sheet["mass"]`, `sheet["C33"]`, in the units of entries."""

    name: str
    entries: tuple[Entry, ...]

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __contains__(self, quantity: object) -> bool:
        return any(entry.quantity == quantity for entry in self.entries)

    def entry(self, quantity: str) -> Entry:
        """The line of a quantity. Raises ModelError where there is none."""
        for entry in self.entries:
            if entry.quantity == quantity:
                return entry
        known = [entry.quantity for entry in self.entries]
        raise ModelError(f"the sheet of {self.name} has no '{quantity}'{did_you_mean(quantity, known)}")

    def __getitem__(self, quantity: str) -> float:
        return self.entry(quantity).value

    def rows(self) -> list[tuple[str, str, float, str]]:
        """Group, quantity, value, unit of every line."""
        return [(entry.group, entry.quantity, entry.value, entry.unit) for entry in self.entries]

    def save(self, path: str | Path) -> Path:
        """Write a table as .csv, which `Sheet.read` reads."""
        path = Path(path)
        if path.suffix != ".csv":
            raise ModelError(f"{path}: a sheet is saved as .csv, not as '{path.suffix or 'no ending'}'.")
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([HEADS, *self.rows()])
        return write_text(path, text.getvalue())

    @staticmethod
    def read(path: str | Path) -> Sheet:
        """A sheet from a table with the columns quantity and value, and unit where it is not that of fowtlib (.csv).

        So the numbers of a report or of another program become a sheet. Raises ModelError with the line.
        """
        path, entries = Path(path), {}
        try:
            with path.open(newline="", encoding="utf-8-sig") as file:
                reader = csv.DictReader(file, skipinitialspace=True)
                missing = {"quantity", "value"} - set(reader.fieldnames or ())
                if missing:
                    raise ModelError(f"{path}:1: a sheet needs the columns quantity and value; unit and group may be.")
                for row in reader:
                    quantity, where = (row["quantity"] or "").strip(), f"{path}:{reader.line_num}"
                    if quantity in entries:
                        raise ModelError(f"{where}: '{quantity}' is there twice.")
                    value = _finite(row["value"], where)
                    unit = (row.get("unit") or "").strip()
                    entries[quantity] = Entry((row.get("group") or "").strip(), quantity, value, unit)
        except OSError as error:
            raise ModelError(f"{path}: cannot be read: {error.strerror}.") from None
        except UnicodeDecodeError:
            raise ModelError(f"{path}: is no table of text (.csv).") from None
        return Sheet(path.name, tuple(entries.values()))

    def against(self, other: Sheet) -> list[Difference]:
        """The quantities that both have, in the order of this one. Raises ModelError where units do not fit."""
        there = {entry.quantity: entry for entry in other.entries}
        return [
            Difference(entry.quantity, entry.unit, entry.value, _in_unit(there[entry.quantity], entry.unit, other.name))
            for entry in self.entries
            if entry.quantity in there
        ]

    def without(self, other: Sheet) -> list[str]:
        """The quantities that the other one lacks."""
        return [entry.quantity for entry in self.entries if entry.quantity not in other]

    def _repr_html_(self) -> str:
        return table(HEADS, self.rows(), self.name)


def model_sheet(
    model: Any,
    *,
    frequencies: Sequence[float] = FREQUENCIES,
    heading: float = 0.0,
) -> Sheet:
    """The sheet of a model: a compiled one as it is; another is first put into still water without wind.

    Bodies count where they are at rest: centre of mass [m] in the world, inertia [kg m^2] about it, of the whole and of
    every part of the model with a mass. Matrices of floating bodies are about their frames, C without the weight.
    Periods are those of the natural modes about the position at rest. The response to waves is that of the linear
    model, in still water, at `frequencies` [Hz] and a `heading` [rad]; a model that is unstable at rest has none, and
    a warning says so.
    """
    plant = compiled(model)
    state = mean_state(plant)
    warn_unless_upright(plant, state)
    entries = [*what_parts_say(plant.root, state), *_rest(plant, state), *modes_of(plant, state)]
    if wave_inputs(plant.root):
        try:
            entries += _response(linear_rao(plant, frequencies, heading=heading, state=state))
        except SimulationError as error:  # what does not come back after a push has all else
            warnings.warn(f"no response to waves: {error}", stacklevel=2)
    return Sheet(plant.name, tuple(entries))


def what_parts_say(root: Any, state: Any) -> Iterator[Entry]:
    """Masses, and numbers and matrices of floating bodies; root: the parts with their values, state: where they are."""
    with one_evaluation():
        told = facts_of(root)
        of = metacentre(told, state)
    yield from _masses(root, state, [(part, fact) for part, fact in told if isinstance(fact, facts.Mass)])
    yield from _water([(part, fact) for part, fact in told if isinstance(fact, (facts.Number, facts.Loads))])
    if of is not None:
        yield Entry("water", "metacentric height without moorings", of.height, "m")


def _masses(root: Any, state: Any, told: Sequence[tuple[Any, facts.Mass]]) -> Iterator[Entry]:
    """Of the whole, and of each part below the root that has a mass."""
    bodies = placed_bodies(told, state)
    groups: dict[str, list[Placed]] = {"": bodies}
    for body in bodies:
        groups.setdefault(body.path.partition(".")[0], []).append(body)
    for name, placed in groups.items():
        mass, centre = centre_of_mass(placed)
        if not mass:
            continue
        own = f"{name}: " if name else ""
        yield Entry("mass", f"{own}mass", mass, "kg")
        for axis, value in zip("xyz", centre, strict=True):
            yield Entry("mass", f"{own}centre of mass {axis}", _clean(value), "m")
        inertia = sum(body.inertia + body.mass * _steiner(body.centre - centre) for body in placed)
        for axis, value in zip("xyz", np.diag(inertia), strict=True):
            yield Entry("mass", f"{own}inertia {axis}{axis}", float(value), "kg m^2")
    if bodies:
        gravity = [part.parameter_value("gravity") for part in root.walk() if "gravity" in part.parameters]
        if gravity:
            yield Entry("mass", "weight", sum(body.mass for body in bodies) * float(gravity[0]), "N")


def _steiner(r: np.ndarray) -> np.ndarray:
    return float(r @ r) * np.eye(3) - np.outer(r, r)


def _water(told: Sequence[tuple[Any, facts.Number | facts.Loads]]) -> Iterator[Entry]:
    """Numbers and matrices; with the path of their part where two have the same."""
    names = [fact.name for _, fact in told]
    for part, fact in told:
        own = f"{part.path}: " if names.count(fact.name) > 1 else ""
        if isinstance(fact, facts.Loads):
            yield from _elements(own, fact)
        elif np.ndim(fact.value) == 0:
            yield Entry("water", f"{own}{fact.name}", float(np.asarray(fact.value)), fact.unit)
        else:
            for axis, value in zip("xyz", np.ravel(fact.value), strict=True):
                yield Entry("water", f"{own}{fact.name} {axis}", _clean(value), fact.unit)


def _elements(own: str, loads: facts.Loads) -> Iterator[Entry]:
    """The elements of a matrix that are not zero; of a symmetric pair the upper one."""
    matrix = np.asarray(loads.matrix, dtype=float)
    letter, _, rest = loads.name.partition("(")
    size = np.sqrt(np.abs(np.outer(np.diag(matrix), np.diag(matrix))))
    lengths = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
    size = np.maximum(size, 1e-3 * np.abs(matrix / np.outer(lengths, lengths)).max() * np.outer(lengths, lengths))
    for i in range(6):
        for j in range(6):
            same = abs(matrix[i, j] - matrix[j, i]) <= 1e-3 * size[i, j]
            if abs(matrix[i, j]) > _NOISE * size[i, j] and not (j < i and same):
                name = f"{own}{letter}{i + 1}{j + 1}" + (f"({rest}" if rest else "")
                yield Entry("water", name, float(matrix[i, j]), _WITH_LENGTHS[loads.unit][(i > 2) + (j > 2)])


def _rest(plant: Any, state: Any) -> Iterator[Entry]:
    readings = [(part, fact) for part in plant.root.walk() for fact in part.facts() if isinstance(fact, facts.Reading)]
    for name in MOTIONS:
        if name in plant.outputs:
            unit = shown_unit(plant, name)
            yield Entry("at rest", f"{name} at rest", _clean(float(np.asarray(state[name]))), unit)
    for part, reading in readings:
        path = join(part.path, reading.variable)
        yield Entry("at rest", path, float(np.asarray(state[path])), plant.describe(path)[0])


def modes_of(plant: Any, state: Any) -> Iterator[Entry]:
    """Periods and damping ratios of the natural modes about a state."""
    seen: dict[str, int] = {}
    for mode in natural_modes(plant, state):
        if mode.motion and mode.oscillates:
            seen[mode.name] = seen.get(mode.name, 0) + 1
            name = mode.name if seen[mode.name] == 1 else f"{mode.name} ({seen[mode.name]})"
            yield Entry("modes", f"period of {name}", float(mode.period), "s")
            yield Entry("modes", f"damping ratio of {name}", float(mode.damping_ratio) + 0.0, "1")  # + 0.0: no -0.0


def _response(rao: Any) -> Iterator[Entry]:
    for name in rao.outputs:
        amplitude = rao.amplitude(name)
        if amplitude.max() > 1e-9:
            for frequency, value in zip(rao.frequency, amplitude, strict=True):
                yield Entry("response", f"{name} per wave amplitude at {frequency:g} Hz", float(value), rao.unit(name))


def _clean(value: float) -> float:
    """Zero in place of what rounding leaves of a length or an angle."""
    return float(value) if abs(value) > 1e-8 else 0.0


def _finite(text: str | None, where: str) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ModelError(f"{where}: the value '{text}' is not a number.")
    return value


def _in_unit(entry: Entry, unit: str, name: str) -> float:
    if entry.unit in ("", unit):
        return entry.value
    try:
        si = si_unit(unit)
        return float(from_si(to_si(f"{entry.value!r} {entry.unit}", si), si, unit))
    except UnitError as error:
        raise ModelError(f"{name}: {entry.quantity}: {error}") from None
