"""Which variables of an FMU become ports, under which names and in which units; and the start values a user gives."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from fowtlib.components.fmu.description import NUMBERS, REALS, Description, FmuVariable, UnitScale
from fowtlib.language.errors import ParameterError, SimulationError, UnitError, did_you_mean
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import conversion, quantity, si_unit, to_si

SETTABLE = ("parameter", "local", "input", "output")


@dataclass(frozen=True)
class FmuSignal:
    """An input or output of an FMU as a port: SI value = factor * value of the FMU + offset."""

    port: str
    variable: FmuVariable
    scale: UnitScale
    start: np.ndarray | None

    @property
    def unit(self) -> str:
        """SI unit of the port."""
        return self.scale.si

    def whole(self, value: float) -> int:
        """A value of the FMU where it is no real number: the nearest whole number; true is from one half on."""
        if self.variable.kind == "Boolean":
            return value >= 0.5
        low, high = whole_range(self.variable.kind)
        number = round(value) if math.isfinite(value) else value
        if not low <= number <= high:
            raise SimulationError(f"the input '{self.variable.name}' is {number}, and {low} to {high} is possible")
        return number


@cache
def whole_range(kind: str) -> tuple[int, int]:
    """The smallest and the largest number of a type."""
    bits = int(found[0]) if (found := re.findall(r"\d+$", kind)) else 32
    return (0, 2**bits - 1) if kind.startswith("U") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def port_name(name: str) -> str:
    """The name of the port of a variable: what is no letter, digit or underscore becomes one underscore."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return f"v_{text}" if not text or text[0].isdigit() else text


def signals(
    description: Description, causality: str, start: Mapping[str, Any], names: Mapping[str, str],
    units: Mapping[str, str], ignore: Iterable[str],
) -> list[FmuSignal]:  # fmt: skip
    """The inputs or the outputs as signals. Raises ParameterError: a type that cannot be one, two of one name."""
    ignored, found = set(ignore), {}
    for variable in description.variables.values():
        if variable.causality != causality or variable.name in ignored:
            continue
        if variable.kind not in NUMBERS:
            raise ParameterError(
                f"the {causality} '{variable.name}' is of type {variable.kind} and cannot be a signal; "
                "to leave it out, add it to 'ignore'."
            )
        port = names.get(variable.name, port_name(variable.name))
        if port in found:
            raise ParameterError(
                f"the {causality}s '{found[port].variable.name}' and '{variable.name}' would both be the port "
                f"'{port}'; give one of them a name of its own, names: {{\"{variable.name}\": ...}}."
            )
        scale = _scale(description, variable, units)
        own = start.get(variable.name, variable.start if causality == "output" else None)
        si = None
        if own is not None:
            numbers = own_values(description, variable, own, units)
            si = scale.factor * np.reshape(numbers, variable.shape) + scale.offset
        found[port] = FmuSignal(port, variable, scale, si)
    return list(found.values())


def _scale(description: Description, variable: FmuVariable, units: Mapping[str, str]) -> UnitScale:
    if variable.name not in units:
        return description.scale(variable.unit, variable.name)
    try:
        given = str(units[variable.name])
        si = si_unit(given)
        return UnitScale(si, conversion(parse_unit(given), parse_unit(si)))
    except UnitError as error:
        raise error.at(f"units: {variable.name}") from None


def own_values(
    description: Description, variable: FmuVariable, given: Any, units: Mapping[str, str]
) -> list[float] | list[int] | list[bool] | list[str]:
    """A value a user gives for a variable, in the FMU's own unit: numbers are in it, texts carry a unit."""
    where = f"start: {variable.name}"
    if variable.kind == "String":
        if not isinstance(given, str):
            raise ParameterError(f"{where}: got {given!r}, and a text is expected.")
        return [given]
    if variable.kind not in NUMBERS:
        raise ParameterError(f"{where}: a variable of type {variable.kind} cannot be set.")
    items = list(np.ravel(np.asarray(given, dtype=object)))
    if len(items) not in (1, variable.size):
        raise ParameterError(f"{where}: got {len(items)} values, and {variable.size} are expected.")
    items = items * variable.size if len(items) == 1 else items
    if variable.kind in REALS:
        scale = _scale(description, variable, units)
        return [_own(item, scale, where) for item in items]
    if variable.kind == "Boolean":
        if not all(item in (True, False) for item in items):
            raise ParameterError(f"{where}: got {given!r}, and true or false is expected.")
        return [bool(item) for item in items]
    low, high = whole_range(variable.kind)
    if not all(isinstance(item, (int, float)) and float(item).is_integer() and low <= item <= high for item in items):
        raise ParameterError(f"{where}: got {given!r}, and a whole number from {low} to {high} is expected.")
    return [int(item) for item in items]


def _own(item: Any, scale: UnitScale, where: str) -> float:
    si = float(to_si(item, scale.si, where))
    found = quantity(item) if isinstance(item, str) else None
    value = (si - scale.offset) / scale.factor if found and found[1] else si
    if not np.isfinite(value):
        raise ParameterError(f"{where}: got {item!r}, which is not a finite number.")
    return value


def check_names(description: Description, given: Any, what: str, kind: type = dict) -> None:
    """Refuse what is no mapping (or list), and names that are no variables of the FMU."""
    if not isinstance(given, kind):
        raise ParameterError(f"{what}: got {given!r}, and a {'mapping' if kind is dict else 'list'} is expected.")
    for name in given:
        if name not in description.variables:
            hint = did_you_mean(str(name), description.variables)
            raise ParameterError(f"{what}: there is no variable '{name}'{hint}")


def check_ports(names: Mapping[str, Any]) -> None:
    """Refuse names of ports that cannot be names."""
    for variable, name in names.items():
        if not isinstance(name, str) or not name.isidentifier() or name.startswith("_"):
            raise ParameterError(
                f"names: {variable}: {name!r} is not a name; use letters, digits and underscores, and a letter first."
            )


def check_start(description: Description, start: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, list[Any]]:
    """Start values by variable in the FMU's own units, without those of the outputs, which are held before it runs."""
    check_names(description, start, "start")
    values: dict[str, list[Any]] = {}
    for name, given in start.items():
        variable = description.variables[name]
        if variable.causality not in SETTABLE or variable.variability == "constant":
            what = variable.variability if variable.variability == "constant" else variable.causality
            raise ParameterError(f"start: '{name}' is a {what} of the FMU and cannot be set.")
        if variable.causality != "output":
            values[name] = own_values(description, variable, given, units)
    return values
