"""Paths in a model file -> parts, ports and variables of components: `tower.arm_left.tip`, `mooring.lines[0]`."""

from __future__ import annotations

import re
from typing import Any

from fowtlib.language.component import Component, did_you_mean_part
from fowtlib.language.connectors import Signal
from fowtlib.language.declarations import PortReference
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.modelfile.nodes import Place

_ELEMENT = re.compile(r"([^\W\d]\w*)(?:\[\s*(\d+)\s*\])?")


def find_part(component: Component, path: str, place: Place) -> Component:
    """The part at a path below a component."""
    found = component
    for name in path.split(".") if path else ():
        if name not in found.parts:
            owner = found.path or "the model"
            raise place.error(f"'{path}': {owner} has no part '{name}'{did_you_mean_part(name, found)}")
        found = found.parts[name]
    return found


def find_port(component: Component, path: str, place: Place, where: str = "") -> PortReference:
    """The port at a path below a component, or one of its own."""
    owner_path, _, last = path.rpartition(".")
    element = _ELEMENT.fullmatch(last)
    if element is None:
        raise place.error(f"{where}'{path}' is not the path of a port, such as body.frame_b or sum.u[0].")
    owner = find_part(component, owner_path, place)
    name, index = element[1], element[2]
    alias = aliases(owner).get(name)
    if name not in owner.ports and alias is None:
        known = [*owner.ports, *aliases(owner), *owner.parts]
        title = owner.path or "the model"
        if name in owner.parts:
            inner = [f"{path}.{port}" for port in (*owner.parts[name].ports, *aliases(owner.parts[name]))]
            hint = did_you_mean(path, inner, list_up_to=6)
            raise place.error(f"{where}'{path}' is a part, not a port{hint}")
        raise place.error(f"{where}'{path}': {title} has no port '{name}'{did_you_mean(name, known)}")
    port = getattr(owner, name)
    try:
        return port if index is None else port[int(index)]
    except ModelError as error:
        raise place.error(f"{where}{error}") from None


def port_alias(name: str, target: str, place: Place) -> Any:
    """A class attribute under which a component gives a port of one of its parts."""

    def get(component: Component) -> Any:
        owner_path, _, last = target.rpartition(".")
        element = _ELEMENT.fullmatch(last)
        if element is None or not owner_path:
            raise place.error(f"the port '{name}' stands for the port of a part, such as body.frame_a, not '{target}'.")
        owner = find_part(component, owner_path, place)
        if element[1] not in owner.ports and element[1] not in aliases(owner):
            known = did_you_mean(element[1], [*owner.ports, *aliases(owner)])
            raise place.error(f"'{target}': {owner.path} has no port '{element[1]}'{known}")
        port = getattr(owner, element[1])
        return port if element[2] is None else port[int(element[2])]

    return Alias(get)


class Alias(property):
    """A port of a part under a name of its own."""


def aliases(component: Component) -> dict[str, Alias]:
    """The ports that a file gives a component under names of their own."""
    kind = type(component)
    return {name: item for base in kind.__mro__ for name, item in vars(base).items() if isinstance(item, Alias)}


def check_variable(component: Component, path: str, place: Place, where: str) -> str:
    """Check the path of a result as far as the declarations tell; returns the unit, empty where it is not known."""
    owner, rest = component, path.split(".")
    while len(rest) > 1 and rest[0] in owner.parts:
        owner = owner.parts[rest.pop(0)]
    match = re.fullmatch(r"([^\W\d]\w*)((?:\[\s*\d+(?:\s*,\s*\d+)?\s*\])*)", rest[0])
    name = match[1] if match else rest[0]
    fields = {**owner.variables, **owner.ports}
    if match is None or name not in fields:
        known = [*owner.variables, *owner.ports, *(owner.parts if len(rest) > 1 else ())]
        title = owner.path or "the model"
        if name in owner.parts:
            names = [*owner.parts[name].variables, *owner.parts[name].ports]
            raise place.error(f"{where}: '{path}' is a part, not a variable{did_you_mean(name, names)}")
        if name in owner.parameters:
            raise place.error(f"{where}: '{path}' is a parameter, and results are variables; `fowt parameters` has it.")
        raise place.error(f"{where}: '{path}': {title} has no variable '{name}'{did_you_mean(name, known)}")
    field = fields[name]
    is_connector = name in owner.ports and not issubclass(field.annotation, Signal)
    if is_connector:
        member = rest[1].partition("[")[0] if len(rest) > 1 else ""
        members = field.annotation.members
        if member not in members:
            hint = did_you_mean(member, members) if member else f"; give one of its members: {', '.join(members)}."
            raise place.error(f"{where}: '{path}': {field.annotation.__name__} has no member '{member}'{hint}")
        return members[member].unit
    if len(rest) > 1:
        raise place.error(f"{where}: '{path}': {owner.path or 'the model'}.{name} has no parts.")
    return field.unit
