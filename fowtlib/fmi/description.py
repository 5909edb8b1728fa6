"""The file modelDescription.xml of FMI 2.0 and 3.0, and buildDescription.xml of 3.0."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from fractions import Fraction
from importlib.metadata import version
from xml.etree import ElementTree as et

from fowtlib.fmi.variables import Variable, Variables
from fowtlib.language.unit_grammar import BASE, parse_unit
from fowtlib.language.units import conversion

TYPES = {
    "m": "Length", "rad": "Angle", "s": "Time", "kg": "Mass", "m/s": "Velocity", "m/s^2": "Acceleration",
    "rad/s": "AngularVelocity", "rad/s^2": "AngularAcceleration", "N": "Force", "N*m": "Torque", "W": "Power",
    "Hz": "Frequency", "kg*m^2": "MomentOfInertia", "kg/m^3": "Density", "N/m": "TranslationalStiffness",
    "N*m/rad": "RotationalStiffness",
}  # fmt: skip
KINDS = {"me": ("me",), "cs": ("cs",), "both": ("cs", "me")}


@dataclass(frozen=True)
class Heading:
    """What the top of a model description says."""

    name: str
    identifier: str
    token: str
    description: str
    made: datetime
    kinds: tuple[str, ...]
    sources: Sequence[str]


def model_description(
    variables: Variables, heading: Heading, interface: int, needs: Mapping[int, Sequence[int]]
) -> bytes:
    """The text of modelDescription.xml; needs: for each unknown the value references it depends on."""
    return _Two(variables, heading, needs).text() if interface == 2 else _Three(variables, heading, needs).text()


class _Description:
    """What both versions share."""

    def __init__(self, variables: Variables, heading: Heading, needs: Mapping[int, Sequence[int]]):
        self.variables, self.heading, self.needs = variables, heading, needs
        self.items = [v for v in variables.items if self._shown(v)]

    def _shown(self, variable: Variable) -> bool:
        return variable.group != "solver" or "cs" in self.heading.kinds

    def _root(self, **special: str) -> et.Element:
        h = self.heading
        made = h.made.strftime("%Y-%m-%dT%H:%M:%SZ")
        return et.Element(
            "fmiModelDescription", modelName=h.name, description=h.description, generationTool=f"fowtlib {_version()}",
            generationDateAndTime=made, variableNamingConvention="structured", **special,
        )  # fmt: skip

    def _units(self, root: et.Element) -> None:
        shown: dict[str, set[str]] = {}
        for item in self.items:
            if item.unit != "1":
                shown.setdefault(item.unit, set()).update(filter(None, [item.display]))
        section = et.SubElement(root, "UnitDefinitions") if shown else None
        for unit in sorted(shown):
            parsed = parse_unit(unit)
            exponents = {name: e for name, e in zip(BASE, parsed.dimension, strict=True) if e}
            if parsed.angle:
                exponents["rad"] = parsed.angle
            element = et.SubElement(section, "Unit", name=unit)
            whole = {name: str(int(e)) for name, e in exponents.items() if Fraction(e).denominator == 1}
            et.SubElement(element, "BaseUnit", **whole)
            for display in sorted(shown[unit]):
                factor = conversion(parsed, parse_unit(display))
                et.SubElement(element, "DisplayUnit", name=display, factor=repr(float(factor)))

    def _type_names(self) -> list[str]:
        return sorted({item.unit for item in self.items if item.unit in TYPES})

    def _category_names(self, root: et.Element) -> None:
        section = et.SubElement(root, "LogCategories")
        for name, text in (
            ("logStatusWarning", "what a run should know"), ("logStatusDiscard", "the equations cannot be solved here"),
            ("logStatusError", "why a call has failed"),
        ):  # fmt: skip
            et.SubElement(section, "Category", name=name, description=text)

    def _experiment(self, root: et.Element) -> None:
        s = self.variables.settings
        et.SubElement(
            root, "DefaultExperiment", startTime="0", stopTime=repr(s.duration), tolerance=repr(s.tolerance),
            stepSize=repr(s.output_step),
        )  # fmt: skip

    def _attributes(self, v: Variable) -> dict[str, str]:
        """Causality, variability and initial."""
        if v.group == "time":
            return {"causality": "independent", "variability": "continuous"}
        if v.group == "input":
            return {"causality": "input", "variability": "continuous"}
        if v.group == "parameter":
            return {"causality": "parameter", "variability": "tunable"}
        if v.group == "solver":
            return {"causality": "parameter", "variability": "fixed"}
        causality = "output" if v.is_output else "local"
        variability = "discrete" if v.group == "discrete" else "continuous"
        initial = "exact" if v.group == "state" else "calculated"
        return {"causality": causality, "variability": variability, "initial": initial}

    def _quantity(self, v: Variable) -> dict[str, str]:
        """Type, unit, bounds and start."""
        out: dict[str, str] = {}
        if v.unit in TYPES:
            out["declaredType"] = TYPES[v.unit]
        if v.unit != "1":
            out["unit"] = v.unit
        if v.display:
            out["displayUnit"] = v.display
        for key, value in (("min", v.low), ("max", v.high)):
            if value is not None:
                out[key] = repr(float(value))
        if v.nominal is not None and v.nominal != 1.0:
            out["nominal"] = repr(float(v.nominal))
        if v.start is not None:
            out["start"] = repr(float(v.start))
        return out

class _Two(_Description):
    """FMI 2.0."""

    def text(self) -> bytes:
        v, h = self.variables, self.heading
        root = self._root(fmiVersion="2.0", guid=h.token, numberOfEventIndicators=str(len(v.group("indicator"))))
        common = {
            "modelIdentifier": h.identifier, "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
            "canNotUseMemoryManagementFunctions": "true", "providesDirectionalDerivative": "true",
        }  # fmt: skip
        for kind, tag, special in (
            ("me", "ModelExchange", {}), ("cs", "CoSimulation", {"canHandleVariableCommunicationStepSize": "true"}),
        ):  # fmt: skip
            if kind in h.kinds:
                element = et.SubElement(root, tag, **common, **special)
                files = et.SubElement(element, "SourceFiles")
                for name in h.sources:
                    et.SubElement(files, "File", name=name)
        self._units(root)
        self._types(root)
        self._category_names(root)
        self._experiment(root)
        place = {item.reference: i + 1 for i, item in enumerate(self.items)}
        section = et.SubElement(root, "ModelVariables")
        for item in self.items:
            element = et.SubElement(
                section, "ScalarVariable", name=item.name, valueReference=str(item.reference), **_doc(item),
                **self._attributes(item),
            )  # fmt: skip
            extra = {"derivative": str(place[item.of])} if item.of >= 0 else {}
            et.SubElement(element, "Real", **self._quantity(item), **extra)
        self._structure(et.SubElement(root, "ModelStructure"), place)
        return _bytes(root)

    def _types(self, root: et.Element) -> None:
        section = et.SubElement(root, "TypeDefinitions") if self._type_names() else None
        for unit in self._type_names():
            kind = et.SubElement(section, "SimpleType", name=TYPES[unit])
            et.SubElement(kind, "Real", quantity=TYPES[unit], unit=unit)

    def _structure(self, section: et.Element, place: Mapping[int, int]) -> None:
        rates = self.variables.group("rate")
        for tag, items in (("Outputs", self.variables.outputs), ("Derivatives", rates)):
            if items:
                part = et.SubElement(section, tag)
                for item in items:
                    known = " ".join(str(place[r]) for r in sorted(self.needs[item.reference], key=place.__getitem__))
                    et.SubElement(part, "Unknown", index=str(place[item.reference]), dependencies=known)
        unknown = [item for item in self.variables.outputs if item.group != "state"] + rates
        if unknown:
            part = et.SubElement(section, "InitialUnknowns")
            for item in sorted(unknown, key=lambda item: place[item.reference]):
                et.SubElement(part, "Unknown", index=str(place[item.reference]))


class _Three(_Description):
    """FMI 3.0."""

    def text(self) -> bytes:
        h = self.heading
        root = self._root(fmiVersion="3.0", instantiationToken=h.token)
        common = {
            "modelIdentifier": h.identifier, "canGetAndSetFMUState": "true", "canSerializeFMUState": "true",
            "providesDirectionalDerivatives": "true",
        }  # fmt: skip
        special = {
            "canHandleVariableCommunicationStepSize": "true", "providesIntermediateUpdate": "true",
            "canReturnEarlyAfterIntermediateUpdate": "true",
            "fixedInternalStepSize": repr(self.variables.settings.step),
        }  # fmt: skip
        if "me" in h.kinds:
            et.SubElement(root, "ModelExchange", **common)
        if "cs" in h.kinds:
            et.SubElement(root, "CoSimulation", **common, **special)
        self._units(root)
        self._types(root)
        self._category_names(root)
        self._experiment(root)
        section = et.SubElement(root, "ModelVariables")
        for item in self.items:
            extra = {"derivative": str(item.of)} if item.of >= 0 else {}
            et.SubElement(
                section, "Float64", name=item.name, valueReference=str(item.reference), **_doc(item),
                **self._attributes(item), **self._quantity(item), **extra,
            )  # fmt: skip
        self._structure(et.SubElement(root, "ModelStructure"))
        return _bytes(root)

    def _types(self, root: et.Element) -> None:
        section = et.SubElement(root, "TypeDefinitions") if self._type_names() else None
        for unit in self._type_names():
            et.SubElement(section, "Float64Type", name=TYPES[unit], quantity=TYPES[unit], unit=unit)

    def _structure(self, section: et.Element) -> None:
        v = self.variables
        rates = v.group("rate")
        for tag, items in (("Output", v.outputs), ("ContinuousStateDerivative", rates)):
            for item in items:
                known = " ".join(str(r) for r in sorted(self.needs[item.reference]))
                et.SubElement(section, tag, valueReference=str(item.reference), dependencies=known)
        for item in [item for item in v.outputs if item.group != "state"] + rates:
            et.SubElement(section, "InitialUnknown", valueReference=str(item.reference))
        for item in v.group("indicator"):
            known = " ".join(str(r) for r in sorted(self.needs[item.reference]))
            et.SubElement(section, "EventIndicator", valueReference=str(item.reference), dependencies=known)


def build_description(identifier: str, units: Iterable[tuple[str, str]]) -> bytes:
    """The text of sources/buildDescription.xml of FMI 3.0; units: files that are compiled, with their optimization.

    All files stand in one set, because importers are known that build the first set only.
    """
    root = et.Element("fmiBuildDescription", fmiVersion="3.0")
    build = et.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = et.SubElement(build, "SourceFileSet", language="C11", compilerOptions="-O2 -ffp-contract=off")
    for name, _ in units:
        et.SubElement(files, "SourceFile", name=name)
    et.SubElement(build, "Library", name="m")
    return _bytes(root)


def terminals(variables: Variables) -> bytes:
    """The text of terminalsAndIcons.xml of FMI 3.0: the inputs and outputs of each part of the model as one bus."""
    root = et.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    section = et.SubElement(root, "Terminals")
    buses: dict[str, et.Element] = {}
    for item in variables.items:
        if item.group != "input" and not item.is_output:
            continue
        part = item.path.partition(".")[0]
        if part not in buses:
            text = f"inputs and outputs of the part {part}"
            buses[part] = et.SubElement(section, "Terminal", name=part, matchingRule="bus", description=text)
        member = item.name.removeprefix(f"{part}.")
        et.SubElement(
            buses[part], "TerminalMemberVariable", variableName=item.name, memberName=member, variableKind="signal"
        )
    return _bytes(root)


def _doc(variable: Variable) -> dict[str, str]:
    return {"description": variable.doc} if variable.doc and variable.doc != variable.name else {}


def _version() -> str:
    return version("fowtlib")


def _bytes(root: et.Element) -> bytes:
    et.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + et.tostring(root, encoding="utf-8") + b"\n"
