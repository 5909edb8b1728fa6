"""modelDescription.xml of an FMU, versions 2.0 and 3.0, as far as co-simulation needs it."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from fowtlib.language.errors import ModelError, UnitError
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import conversion, si_unit, unit_text

REALS = ("Real", "Float64", "Float32")
INTEGERS = ("Integer", "Enumeration", *(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)))
NUMBERS = (*REALS, *INTEGERS, "Boolean")  # what can be a signal
OTHERS = ("String", "Binary", "Clock")
MOST_ELEMENTS = 100_000  # of an array variable
_BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class UnitScale:
    """SI value = factor * value + offset."""

    si: str = "1"
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class FmuVariable:
    """A variable as the file declares it; `start` in its own unit, one number for each element."""

    name: str
    reference: int
    kind: str
    causality: str
    variability: str
    unit: str
    doc: str
    shape: tuple[int, ...] = ()
    start: tuple[float, ...] | None = None

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)


@dataclass(frozen=True)
class Description:
    """What the file says of the unit for co-simulation."""

    version: str
    name: str
    identifier: str
    token: str
    step: float | None
    fixed_step: float | None
    needs_tool: bool
    variables: Mapping[str, FmuVariable]
    units: Mapping[str, UnitScale | None] = field(default_factory=dict)
    keeps_state: bool = False  # can save what it remembers as bytes, and go on from them

    def scale(self, unit: str, where: str) -> UnitScale:
        """How numbers in a unit of the file become SI: by its own definition, else by its name."""
        if not unit:
            return UnitScale()
        if (defined := self.units.get(unit)) is not None:
            return defined
        try:
            si = si_unit(unit)
            return UnitScale(si, conversion(parse_unit(unit), parse_unit(si)))
        except UnitError:
            raise ModelError(
                f"{where}: the file does not define its unit '{unit}'; name a known one under 'units', for example "
                f"units: {{{where}: rad/s}}."
            ) from None


class _Fault(Exception):
    """What is wrong with the file."""


def read_description(content: bytes, file: str) -> Description:
    """The description in the bytes of modelDescription.xml; `file` is how messages call the FMU.

    Raises ModelError: not XML, a document type (entities), a version other than 2.0 and 3.0, no co-simulation, numbers
    that are none, variables twice.
    """
    try:
        return _description(_parse(content))
    except _Fault as error:
        raise ModelError(f"'{file}' is not a usable FMU: {error}.") from None


def _parse(content: bytes) -> ET.Element:
    if content.startswith((b"\xfe\xff", b"\xff\xfe")) or b"\0" in content[:200]:
        raise _Fault("its modelDescription.xml is in UTF-16 or UTF-32, and FMI has UTF-8")
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:  # UTF-8 has no other way to write these
        raise _Fault("its modelDescription.xml has a document type, which may hide anything")
    try:
        return ET.fromstring(content, ET.XMLParser(encoding="utf-8"))  # whatever it says of itself, as FMI asks for
    except (ET.ParseError, ValueError, LookupError) as error:
        raise _Fault(f"its modelDescription.xml is not well-formed XML in UTF-8 ({error})") from None


def _description(root: ET.Element) -> Description:
    version = root.get("fmiVersion", "")
    if root.tag != "fmiModelDescription" or not version:
        raise _Fault("its modelDescription.xml does not describe an FMU")
    if not re.fullmatch(r"2\.0|3\.0(\.\d+)?", version):
        raise _Fault(f"it is of FMI version {version[:20]}, and versions 2.0 and 3.0 can be imported")
    element = root.find("CoSimulation")
    if element is None:
        others = [kind for kind in ("ModelExchange", "ScheduledExecution") if root.find(kind) is not None]
        raise _Fault(f"it has no co-simulation, only {' and '.join(others) or 'nothing to run'}")
    identifier = element.get("modelIdentifier", "")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", identifier):
        raise _Fault(f"its modelIdentifier {identifier[:40]!r} is not the name of a library")
    second = version == "2.0"
    experiment = root.find("DefaultExperiment")
    step = _positive(experiment, "stepSize") if experiment is not None else None
    internal = None if second else _positive(element, "fixedInternalStepSize")
    variable_step = _flag(element, "canHandleVariableCommunicationStepSize")
    variables = _unique(_variables_2(root) if second else _variables_3(root))
    return Description(
        version=version, name=root.get("modelName", ""), identifier=identifier,
        token=root.get("guid" if second else "instantiationToken", ""),
        step=internal if step is None else step, fixed_step=None if variable_step else internal,
        needs_tool=_flag(element, "needsExecutionTool"), variables=variables, units=dict(_units(root)),
        keeps_state=all(_flag(element, f"can{what}FMU{'state' if second else 'State'}")
                        for what in ("GetAndSet", "Serialize")),
    )  # fmt: skip


def _unique(variables: Iterator[FmuVariable]) -> dict[str, FmuVariable]:
    found: dict[str, FmuVariable] = {}
    for variable in variables:
        if variable.name in found:
            raise _Fault(f"it has two variables '{variable.name}'")
        found[variable.name] = variable
    return found


# --- variables -------------------------------------------------------------------------------------------------------


def _variables_2(root: ET.Element) -> Iterator[FmuVariable]:
    types = {item.get("name"): item[0] for item in root.iterfind("TypeDefinitions/SimpleType") if len(item)}
    for item in root.iterfind("ModelVariables/ScalarVariable"):
        kinds = [child for child in item if child.tag in (*NUMBERS, *OTHERS)]
        if len(kinds) != 1:
            raise _Fault(f"its variable '{item.get('name', '?')}' has no type")
        yield _variable(item, kinds[0], kinds[0].tag, types, ())


def _variables_3(root: ET.Element) -> Iterator[FmuVariable]:
    types = {item.get("name"): item for item in root.iterfind("TypeDefinitions/*")}
    items = [item for item in root.iterfind("ModelVariables/*") if item.tag in (*NUMBERS, *OTHERS)]
    by_reference = {item.get("valueReference"): item for item in items}
    for item in items:
        yield _variable(item, item, item.tag, types, tuple(_dimension(d, item, by_reference)
                                                           for d in item.iterfind("Dimension")))  # fmt: skip


def _dimension(item: ET.Element, variable: ET.Element, by_reference: Mapping[str | None, ET.Element]) -> int:
    given = item.get("start")
    if given is None and (source := by_reference.get(item.get("valueReference"))) is not None:
        given = source.get("start")
    size = _whole(given, f"the size of '{variable.get('name', '?')}'")
    if not 0 < size <= MOST_ELEMENTS:
        raise _Fault(f"the size of '{variable.get('name', '?')}' is {size}, and 1 to {MOST_ELEMENTS} is possible")
    return size


def _variable(
    item: ET.Element, typed: ET.Element, kind: str, types: Mapping[str | None, ET.Element], shape: tuple[int, ...]
) -> FmuVariable:
    name = item.get("name", "")
    if not name:
        raise _Fault("it has a variable without a name")
    if len(shape) > 2 or math.prod(shape) > MOST_ELEMENTS:
        raise _Fault(f"its variable '{name}' is an array of {' x '.join(map(str, shape))}, which is too much")
    declared = types.get(typed.get("declaredType"))
    unit = typed.get("unit", declared.get("unit", "") if declared is not None else "")
    reference = _whole(item.get("valueReference"), f"the valueReference of '{name}'")
    if not 0 <= reference < 2**32:
        raise _Fault(f"the valueReference of '{name}' is {reference}, and 0 to {2**32 - 1} is possible")
    causality = item.get("causality", "local")
    default = "continuous" if kind in REALS and causality != "structuralParameter" else "discrete"
    return FmuVariable(
        name, reference, kind, causality, item.get("variability", default), unit if kind in REALS else "",
        " ".join(item.get("description", "").split()), shape, _start(typed, kind, shape, name),
    )  # fmt: skip


def _start(typed: ET.Element, kind: str, shape: tuple[int, ...], name: str) -> tuple[float, ...] | None:
    text = typed.get("start")
    if text is None or kind not in NUMBERS:
        return None
    numbers = [_number(word, kind, f"the start value of '{name}'") for word in text.split()]
    size = math.prod(shape)
    if len(numbers) == 1:
        numbers = numbers * size
    if len(numbers) != size:
        raise _Fault(f"'{name}' has {size} elements and {len(numbers)} start values")
    return tuple(numbers)


# --- units -----------------------------------------------------------------------------------------------------------


def _units(root: ET.Element) -> Iterator[tuple[str, UnitScale | None]]:
    for item in root.iterfind("UnitDefinitions/Unit"):
        name, base = item.get("name", ""), item.find("BaseUnit")
        if base is None:
            yield name, None
            continue
        where = f"the unit '{name}'"
        powers = {symbol: _whole(base.get(symbol, "0"), where) for symbol in _BASE}
        if any(abs(power) > 20 for power in powers.values()):
            raise _Fault(f"{where} has an exponent beyond 20")
        text = "*".join(f"{symbol}^{power}" for symbol, power in powers.items() if power)
        factor = _number(base.get("factor", "1"), "Real", where)
        if factor == 0:
            raise _Fault(f"{where} has the factor 0")
        yield name, UnitScale(unit_text(parse_unit(text or "1")), factor,
                              _number(base.get("offset", "0"), "Real", where))  # fmt: skip


# --- attributes ------------------------------------------------------------------------------------------------------


def _number(text: str, kind: str, where: str) -> float:
    if kind == "Boolean":
        if text not in ("true", "false", "1", "0"):
            raise _Fault(f"{where} is {text[:40]!r}, and true or false is expected")
        return float(text in ("true", "1"))
    try:
        value = float(text)
    except ValueError:
        raise _Fault(f"{where} is {text[:40]!r}, and a number is expected") from None
    if not math.isfinite(value) or (kind in INTEGERS and not value.is_integer()):
        raise _Fault(f"{where} is {text[:40]!r}, and a {'whole' if kind in INTEGERS else 'finite'} number is expected")
    return value


def _whole(text: str | None, where: str) -> int:
    if text is None or not re.fullmatch(r"\s*[+-]?\d{1,18}\s*", text):
        raise _Fault(f"{where} is {'missing' if text is None else repr(text[:40])}, and a whole number is expected")
    return int(text)


def _positive(item: ET.Element, name: str) -> float | None:
    text = item.get(name)
    if text is None:
        return None
    value = _number(text, "Real", name)
    if value <= 0:
        raise _Fault(f"{name} is {value:g}, and it must be above zero")
    return value


def _flag(item: ET.Element, name: str) -> bool:
    return item.get(name, "false") in ("true", "1")
