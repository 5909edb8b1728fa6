"""Step 2: connection sets. One symbol per connected potential, sums of flows, drivers of signals."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.system import BALANCE, Input, System, element_names, scalars
from fowtlib.language.component import Component
from fowtlib.language.composition import check_there
from fowtlib.language.connectors import PORT, Member, RealInput, RealOutput, Signal
from fowtlib.language.declarations import Port, PortReference, Variable, join
from fowtlib.language.equations import place
from fowtlib.language.errors import ConnectionFault, NotFoundError, ParameterError, did_you_mean, one_of
from fowtlib.language.units import dimension, to_si


@dataclass(slots=True)
class PortNode:
    """One port of one component instance."""

    number: int
    instance: int
    component: Component
    field: Port
    index: int | None
    path: str
    connected: bool = False
    connected_inside: bool = False

    @property
    def is_signal(self) -> bool:
        return issubclass(self.field.annotation, Signal)


class DisjointSets:
    """Union-find over 0 .. n-1."""

    def __init__(self, n: int):
        self.parent = list(range(n))

    def find(self, i: int) -> int:
        """Representative of the set of i."""
        while self.parent[i] != i:
            self.parent[i] = self.parent[self.parent[i]]
            i = self.parent[i]
        return i

    def union(self, i: int, j: int) -> None:
        """Join the sets of i and j."""
        self.parent[self.find(j)] = self.find(i)


class Connections:
    """All ports of a model and the sets that `connect` makes of them."""

    def __init__(self, components: list[Component]):
        self.nodes: list[PortNode] = []
        self._number: dict[tuple[int, str, int | None], int] = {}
        self._places: dict[int, str] = {}  # of the first connection of each port
        for i, component in enumerate(components):
            for field in component.ports.values():
                size = component.port_size(field)
                for index in [None] if size is None else range(size):
                    label = field.name if index is None else f"{field.name}[{index}]"
                    node = PortNode(len(self.nodes), i, component, field, index, join(component.path, label))
                    self._number[id(component), field.name, index] = node.number
                    self.nodes.append(node)
        root = components[0]
        n = len(self.nodes)
        self.potential_sets = DisjointSets(n)
        self.flow_sets = DisjointSets(2 * n)  # face of a port: 2 k seen from outside, 2 k + 1 from inside its component
        for component in components:
            for a, b, source in component.connections:
                try:
                    self._connect(component, a, b, place(source))
                except ConnectionFault as error:
                    raise error.at(place(source)) from None
        for node in self.nodes:
            if not (node.connected or node.field.optional or node.is_signal or node.component is root):
                raise _at_part(node, ConnectionFault(
                    f"{node.path} is not connected: {node.field.doc or 'a required port'}. "
                    f"Connect a {node.field.annotation.__name__} to it."
                ))  # fmt: skip

    def _connect(self, owner: Component, a: PortReference, b: PortReference, at: str) -> None:
        ends = []
        for reference in (check_there(a), check_there(b)):
            size = reference.component.port_size(reference.field)
            if size is not None and reference.index is None:
                raise ConnectionFault(
                    f"{reference.path} is an array of {size} ports; connect one of them: {reference.path}[0]."
                )
            ends.append(self.nodes[self._number[id(reference.component), reference.field.name, reference.index]])
        self._check_pair(*ends, owner)
        self.potential_sets.union(ends[0].number, ends[1].number)
        faces = []
        for node in ends:
            inside = node.component is owner
            faces.append(2 * node.number + int(inside))
            node.connected = True
            self._places.setdefault(node.number, at)
            node.connected_inside |= inside
        self.flow_sets.union(*faces)

    @staticmethod
    def _check_pair(a: PortNode, b: PortNode, owner: Component) -> None:
        if a is b:
            raise ConnectionFault(f"{a.path} is connected to itself.")
        if a.is_signal != b.is_signal or (not a.is_signal and a.field.annotation is not b.field.annotation):
            raise ConnectionFault(
                f"{a.path} is a {a.field.annotation.__name__} and {b.path} a {b.field.annotation.__name__}; "
                "only ports of one kind can be connected."
            )
        if not a.is_signal and not a.field.annotation.sized:
            return
        shapes = [node.component.shape_of(node.field) for node in (a, b)]
        if shapes[0] != shapes[1]:
            raise ConnectionFault(
                f"{a.path} has shape {shapes[0]} and {b.path} has shape {shapes[1]}; they cannot be connected."
            )
        if not a.is_signal:
            return
        units = [a.field.unit, b.field.unit]
        if units[0] != units[1] and "1" not in units and dimension(units[0]) != dimension(units[1]):
            raise ConnectionFault(f"{a.path} is in {units[0]} and {b.path} in {units[1]}; they cannot be connected.")

    # --- symbols -------------------------------------------------------------------------------------------------

    def symbols(self, system: System, root: Component, opened: Sequence[str] = ()) -> list[dict[str, Any]]:
        """Members of every port as expressions; the sums of flows go into the system as equations.

        opened: paths of signals that come from outside of the model in place of what drives them.
        """
        wanted = dict.fromkeys(opened, False)
        members: list[dict[str, Any]] = [{} for _ in self.nodes]
        for group in self._groups():
            if group[0].is_signal:
                path = next((node.path for node in group if node.path in wanted), "")
                wanted |= {path: True} if path else {}
                self._signal(system, root, group, members, path)
            else:
                self._potentials(system, group, members)
        self._flows(system, members)
        for path, found in wanted.items():
            if not found:
                signals = [node.path for node in self.nodes if node.is_signal]
                raise NotFoundError(f"there is no signal '{path}'{did_you_mean(path, signals)}")
        return members

    def _groups(self) -> list[list[PortNode]]:
        groups: dict[int, list[PortNode]] = defaultdict(list)
        for node in self.nodes:
            groups[self.potential_sets.find(node.number)].append(node)
        return list(groups.values())

    @staticmethod
    def _potentials(system: System, group: list[PortNode], members: list[dict[str, Any]]) -> None:
        first = group[0]
        shared: dict[str, ca.SX] = {}
        for name, member in first.field.annotation.members.items():
            if member.kind == "flow":
                continue
            shared[name] = member_symbol(system, first, name, member, unknown=member.kind == "potential")
        for name, member in first.field.annotation.members.items():
            if member.kind == "orientation":
                system.orient(shared[name], shared[member.angular_velocity])
                if any(node.connected for node in group):
                    system.orientations.append((first.path, shared[name]))
        for node in group:
            members[node.number].update(shared)
            for name, value in shared.items():
                if node is not first:
                    member = first.field.annotation.members[name]
                    system.add_alias(join(node.path, name), value, member.unit, member.doc)

    def _flows(self, system: System, members: list[dict[str, Any]]) -> None:
        """Two joined flows share a symbol; more of them get a sum; a flow that nothing meets is zero."""
        faces: dict[int, list[int]] = defaultdict(list)
        for node in self.nodes:
            if node.is_signal or all(member.kind != "flow" for member in node.field.annotation.members.values()):
                continue
            faces[self.flow_sets.find(2 * node.number)].append(2 * node.number)
            if node.connected_inside:
                faces[self.flow_sets.find(2 * node.number + 1)].append(2 * node.number + 1)
        pairs = SignedSets(len(self.nodes))
        sums = []
        for group in faces.values():
            signs = [(face // 2, -1 if face % 2 else 1) for face in group]
            if len(signs) == 2 and pairs.union(signs[0][0], signs[1][0], -signs[0][1] * signs[1][1]):
                continue
            sums.append(signs)
        zero = {pairs.find(signs[0][0])[0] for signs in sums if len(signs) == 1}
        shared: dict[int, dict[str, ca.SX]] = {}
        for node in self.nodes:
            if node.is_signal:
                continue
            representative, sign = pairs.find(node.number)
            if representative not in shared:
                shared[representative] = {
                    name: ca.densify(ca.SX(*_two(_shape(node, member)))) if representative in zero
                    else member_symbol(system, self.nodes[representative], name, member)
                    for name, member in node.field.annotation.members.items() if member.kind == "flow"
                }  # fmt: skip
            for name, value in shared[representative].items():
                members[node.number][name] = value if sign > 0 else -value
                if node.number != representative or representative in zero:
                    member = node.field.annotation.members[name]
                    system.add_alias(join(node.path, name), members[node.number][name], member.unit, member.doc)
        for signs in sums:
            if len(signs) == 1 and pairs.find(signs[0][0])[0] in zero:
                continue
            path = self.nodes[signs[0][0]].path
            for name, member in self.nodes[signs[0][0]].field.annotation.members.items():
                if member.kind == "orientation":
                    system.orientation_at[path] = members[signs[0][0]][name].elements()[0].element_hash()
            for name in members[signs[0][0]]:
                if self.nodes[signs[0][0]].field.annotation.members[name].kind == "flow":
                    total = sum((sign * members[k][name] for k, sign in signs), start=ca.SX(0))
                    system.add_equation(total, ca.SX(*total.shape), path, BALANCE)

    def _signal(self, system: System, root: Component, group: list[PortNode], members: list[dict[str, Any]],
                opened: str = "") -> None:  # fmt: skip
        drivers = [node for node in group if _drives(node, root)]
        if not drivers:  # an output that its composite writes itself, and that its own parts read
            drivers = [node for node in group if issubclass(node.field.annotation, RealOutput)]
        if len(drivers) > 1:
            names = " and ".join(self._with_place(node) for node in drivers)
            raise ConnectionFault(f"two outputs drive one signal: {names}. Connect one of them, or add a Sum between.")
        first = drivers[0] if drivers else group[0]
        self._check_direction(group, first)
        shape = _two(first.component.shape_of(first.field))
        symbol = ca.SX.sym(first.path, *shape)
        if drivers and issubclass(first.field.annotation, RealOutput):
            declared = _variable(first.field.unit, first.field.doc)
            for element, name in zip(scalars(symbol), element_names(first.path, symbol.shape), strict=True):
                system.signals.add(system.add_unknown(element, name, declared))
            if opened:
                group = self._opened(system, group, first, symbol, members, opened)
                symbol, first = members[group[0].number]["signal"], group[0]
        else:
            self._open_input(system, root, group, first, symbol)
        for node in group:
            members[node.number]["signal"] = symbol
            if node is not first:
                system.add_alias(node.path, symbol, node.field.unit, node.field.doc)

    def _with_place(self, node: PortNode) -> str:
        """The path of a port with the place where it is connected."""
        at = self._places.get(node.number)
        return f"{node.path} ({at})" if at else node.path

    def _check_direction(self, group: list[PortNode], driver: PortNode) -> None:
        """An input of a composite hands a signal inwards: what is inside of it must not drive it."""
        for node in group:
            inward = issubclass(node.field.annotation, RealInput) and node is not driver
            if inward and node.component in driver.component.enclosing():
                raise ConnectionFault(
                    f"{self._with_place(node)} is an input, and {driver.path} inside of it drives it; "
                    "make it an output (RealOutput), or connect it the other way."
                )

    @staticmethod
    def _opened(system: System, group: list[PortNode], driver: PortNode, symbol: ca.SX, members: list[dict[str, Any]],
                path: str) -> list[PortNode]:  # fmt: skip
        """The signal at `path` becomes an input of the model; the driver keeps its own, which nobody hears."""
        rest = [node for node in group if node is not driver]
        if path == driver.path:
            readers = one_of([node.path for node in rest]) if rest else "a port that reads it"
            raise ConnectionFault(f"{path} drives this signal; to give it from outside, name {readers} instead.")
        node = next(node for node in rest if node.path == path)
        members[driver.number]["signal"] = symbol
        given = ca.SX.sym(path, *symbol.shape)
        members[node.number]["signal"] = given
        values = np.zeros(given.numel())
        system.inputs[path] = Input(path, given, node.field.unit, node.field.doc, values, driver.path)
        return [node, *(other for other in rest if other is not node)]

    @staticmethod
    def _open_input(system: System, root: Component, group: list[PortNode], first: PortNode, symbol: ca.SX) -> None:
        """Nothing drives the signal: it is an input of the whole model, if a value is declared for it."""
        defaults = [node for node in group if node.field.default is not None]
        at_top = [node for node in group if node.component is root]
        if not defaults and not at_top:
            node = group[0]
            if node.field.optional:
                defaults = [node]
            else:
                raise _at_part(node, ConnectionFault(
                    f"{node.path} is not connected: {node.field.doc or 'a required input'} [{node.field.unit}]. "
                    "Connect an output to it."
                ))  # fmt: skip
        source = at_top[0] if at_top else defaults[0]
        default = 0.0
        if defaults and defaults[0].field.default is not None:
            declared = defaults[0]
            default = to_si(declared.component.resolve(declared.field.default), declared.field.unit, declared.path)
        value = np.broadcast_to(
            np.asarray(default, dtype=float), symbol.shape if symbol.shape[1] > 1 else (symbol.shape[0],)
        )
        system.inputs[source.path] = Input(
            source.path, symbol, source.field.unit, source.field.doc, value.reshape(-1, order="F")
        )


class SignedSets:
    """Union-find of quantities that are equal up to a sign."""

    def __init__(self, n: int):
        self.parent = list(range(n))
        self.sign = [1] * n

    def find(self, i: int) -> tuple[int, int]:
        """Representative of i and the sign of i relative to it."""
        sign = 1
        while self.parent[i] != i:
            sign *= self.sign[i]
            i = self.parent[i]
        return i, sign

    def union(self, i: int, j: int, sign: int) -> bool:
        """Declare i = sign * j; False where that closes a ring."""
        (a, sign_a), (b, sign_b) = self.find(i), self.find(j)
        if a == b:
            return False
        self.parent[b], self.sign[b] = a, sign * sign_a * sign_b
        return True


def _at_part(node: PortNode, fault: ConnectionFault) -> ConnectionFault:
    """The fault with the place in a model file where the part of the port stands, if there is one."""
    for component in (node.component, *node.component.enclosing()):
        if "" in component.origins:
            return fault.at(component.origins[""])
    return fault


def _drives(node: PortNode, root: Component) -> bool:
    """True for an output made by its component, and for an input of the whole model."""
    if node.component is root and issubclass(node.field.annotation, RealInput):
        return True
    return issubclass(node.field.annotation, RealOutput) and not node.connected_inside


def _shape(node: PortNode, member: Member) -> tuple[int, ...]:
    """Shape of a member, or of the port that sizes it."""
    if member.shape != PORT:
        return member.shape
    if node.field.shape is None:
        raise ParameterError(
            f"{node.component.label}.{node.field.name}: a {node.field.annotation.__name__} as a port needs a shape, "
            'as port(shape="n_modes").'
        )
    return node.component.shape_of(node.field)


def member_symbol(system: System, node: PortNode, name: str, member: Member, unknown: bool = True) -> ca.SX:
    """The symbol of a member of a port; an unknown of the system, or nothing that it knows."""
    path = join(node.path, name)
    symbol = ca.SX.sym(path, *_two(_shape(node, member)))
    if unknown:
        declared = _variable(member.unit, member.doc)
        for element, label in zip(scalars(symbol), element_names(path, symbol.shape), strict=True):
            system.add_unknown(element, label, declared)
    return symbol


def _variable(unit: str, doc: str) -> Variable:
    return Variable(unit, doc, "", None, None, None, "default", None, None, None, False)


def _two(shape: tuple[int, ...]) -> tuple[int, int]:
    return (1, 1) if not shape else (shape[0], shape[1] if len(shape) == 2 else 1)
