"""Values that follow from others: a table over one variable, or a joint distribution of wind and waves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from fowtlib.cases import csv_tables
from fowtlib.cases.folder import Folder
from fowtlib.cases.lists import variable
from fowtlib.cases.values import Item, Names, evaluate, number, scalar, word
from fowtlib.language.errors import ModelError, ModelFileError
from fowtlib.modelfile.formulas import Quantity
from fowtlib.modelfile.nodes import Node, Place
from fowtlib.modelfile.specs import check_keys, mapping


class Distribution(Protocol):
    """A joint distribution of the wind speed at the hub, Hs and Tp."""

    def conditional(self, wind_speed: float) -> tuple[float, float]:
        """Hs [m] and Tp [s] that go with a mean wind speed [m/s]; an error outside of its range."""


class Source(Protocol):
    """What gives variables from another one: `argument` -> `columns`."""

    argument: str
    columns: tuple[str, ...]

    def at(self, value: Quantity) -> dict[str, Item]:
        """The columns at a value of the argument; a ModelError outside of the range."""


@dataclass(frozen=True)
class Table:
    """Columns over the first one, linear between its rows; nothing is known outside of them."""

    name: str
    argument: str
    columns: tuple[str, ...]
    at_values: np.ndarray
    values: Mapping[str, np.ndarray]
    units: Mapping[str, Any]

    def at(self, value: Quantity) -> dict[str, Item]:
        low, high = float(self.at_values[0]), float(self.at_values[-1])
        given, unit = value.value, self.units[self.argument]
        if value.unit and unit and value.unit.dimension != unit.dimension:
            raise ModelFileError(f"'{self.argument}' has another unit than the column of the table '{self.name}'.")
        if not low <= given <= high:
            raise ModelFileError(
                f"{self.argument} = {given:g} lies outside of the table '{self.name}', which goes from {low:g} to "
                f"{high:g}; nothing is extrapolated. Give the table more rows."
            )
        return {name: number(float(np.interp(given, self.at_values, self.values[name])), self.units[name])
                for name in self.columns}  # fmt: skip


@dataclass(frozen=True)
class Joint:
    """A distribution as a source: `wind_speed` -> Hs and Tp."""

    name: str
    distribution: Distribution
    argument: str = "wind_speed"
    columns: tuple[str, ...] = ("Hs", "Tp")

    def at(self, value: Quantity) -> dict[str, Item]:
        height, period = self.distribution.conditional(float(value.value))
        return {"Hs": number(float(height)), "Tp": number(float(period))}


def table(name: str, node: Node, names: Names, folder: Folder, files: list[Path]) -> Table:
    """A table that the file holds as lists by column, or a CSV file that it names; the first column is the argument."""
    if isinstance(node.value, str):
        columns = csv_tables.read(node, folder, files)
    else:
        form = f"the table '{name}' is a mapping of lists, the first of what it is looked up by, or a CSV file"
        columns = {key: _list(key, item, names) for key, item in mapping(node, form).items()}
    if len(columns) < 2:
        raise node.place.error(f"the table '{name}' has one column; it needs the one it is looked up by, and others.")
    numbers = {variable(key, node.place): _numbers(name, key, items, node.place) for key, items in columns.items()}
    argument, *others = numbers
    lengths = {len(values) for values, _ in numbers.values()}
    if len(lengths) > 1:
        told = ", ".join(f"{key} has {len(values)}" for key, (values, _) in numbers.items())
        raise node.place.error(f"the columns of the table '{name}' have the same length; {told}.")
    at_values = numbers[argument][0]
    if len(at_values) < 2 or not np.all(np.diff(at_values) > 0):
        raise node.place.error(f"the table '{name}': '{argument}', its first column, needs two rising values or more.")
    return Table(name, argument, tuple(others), at_values, {key: numbers[key][0] for key in others},
                 {key: unit for key, (_, unit) in numbers.items()})  # fmt: skip


Opener = Callable[[str, float], Distribution]
"""From the name or the path of a site, and the height [m] at which wind speeds are wanted."""


def joint(name: str, node: Node, names: Names, folder: Folder, files: list[Path], opened: Opener | None) -> Joint:
    """A distribution that `distributions` names: {site: NAME or FILE, height: of the wind speeds, the hub}."""
    keys = ("site", "height")
    items = mapping(node, f"the distribution '{name}' is a mapping: {{site: name or file, height: 90 m}}")
    check_keys(items, keys, f"the distribution '{name}'")
    for key in keys:
        if key not in items:
            raise node.place.error(f"the distribution '{name}' needs '{key}'.")
    if opened is None:
        raise node.place.error(f"the distribution '{name}': nobody here reads sites; give read_cases the object in "
                               f"distributions={{'{name}': ...}}, or open_distribution.")  # fmt: skip
    site, height = word(items["site"], "site", names), scalar(items["height"], "height", names, "m")
    try:
        if "." in site or "/" in site:
            files.append(folder.find(site))
            site = str(files[-1])
        return Joint(name, opened(site, height))
    except ModelError as error:
        raise node.place.error(str(error)) from None


def _list(key: str, node: Node, names: Names) -> list[Item]:
    if not isinstance(node.value, list):
        raise node.place.error(f"'{key}' is a list of the values of a column, not {node.kind}.")
    return [evaluate(item, names) for item in node.value]


def _numbers(name: str, key: str, items: list[Item], place: Place) -> tuple[np.ndarray, Any]:
    """A column in SI, and its unit."""
    for item in items:
        if item.quantity is None:
            raise place.error(f"the table '{name}': '{item.written}' in '{key}' is no number.")
    quantities = [item.quantity for item in items if item.quantity]
    units = {quantity.unit for quantity in quantities}
    if len(units) > 1:
        raise place.error(f"the table '{name}': the values of '{key}' have different units, or some have none.")
    values = np.array([float(quantity.value) for quantity in quantities])
    if not np.all(np.isfinite(values)):
        raise place.error(f"the table '{name}': '{key}' holds what is not a finite number.")
    return values, units.pop()
