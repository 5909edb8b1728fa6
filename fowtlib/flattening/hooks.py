"""What a flat model holds that is no expression: external functions, computations at a start, processes, operators.

They are objects of Python, and no file holds them. A flat model that is read from disk gets them from the components
that gave them: of these few `equations()` is called again, with symbols of its own, and the expressions are dropped.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca

from fowtlib.flattening.connections import PortNode, member_symbol
from fowtlib.flattening.instances import Instances, two_dimensions
from fowtlib.flattening.system import Bound, System, jacobian_of
from fowtlib.language import equations as statements
from fowtlib.language.component import Component
from fowtlib.language.composition import check_there
from fowtlib.language.connectors import BoundPort, Signal
from fowtlib.language.declarations import Port, join
from fowtlib.language.equations import Process
from fowtlib.language.expressions import one_evaluation
from fowtlib.language.offered import Happening
from fowtlib.language.operators import LinearOperator


@dataclass(frozen=True)
class Hooks:
    """Functions and the numbers of those that they are Jacobians of (-1: none), bound by path, processes, operators."""

    functions: tuple[tuple[ca.Function, int], ...]
    bound: dict[str, Bound]
    processes: tuple[Process, ...]
    operators: tuple[LinearOperator, ...]

    @classmethod
    def of(cls, system: System, stated: Any) -> Hooks:
        """Those of a flattening, in the order in which they were given."""
        calls = [item for item in system.intermediates if item.function is not None]
        processes = [sampled.process for _, sampled in stated.sampled if sampled.process is not None]
        return cls(
            tuple((item.called, item.slope_of) for item in calls),
            system.bound, tuple(processes), tuple(operator for _, operator in stated.operators),
        )  # fmt: skip

    def with_jacobians(self, slopes_of: Sequence[int]) -> Hooks:
        """With the Jacobians of functions that were given, which the reduction of the index has asked for."""
        found = list(self.functions)
        for number in slopes_of[len(found) :]:
            found.append((jacobian_of(found[number][0]), number))
        return Hooks(tuple(found), self.bound, self.processes, self.operators)


def hooks_again(root: Component, given_with: tuple[Sequence[str], Sequence[str]]) -> Hooks:
    """The hooks of a component tree whose equations are known already; given_with: see Instances."""
    instances = _Sparing(root)
    found = {component.path: component for component in instances.components}
    with one_evaluation(), statements.flattening(instances.system):
        for path in given_with[0]:
            for name in (*found[path].parameters, *found[path].variables):
                instances.bindings[path][name]
        with instances:
            for path in given_with[1]:
                instances.system.current_path = path
                instances.take(found[path], found[path].equations())
    return Hooks.of(instances.system, instances.statements)


class _OnDemand(dict):
    def __init__(self, make: Callable[[str], Any]):
        super().__init__()
        self._make = make

    def __missing__(self, name: str) -> Any:
        self[name] = self._make(name)
        return self[name]


class _Sparing(Instances):
    """Gives symbols to what is asked for alone; ports have symbols of their own, as if nothing were connected."""

    def __init__(self, root: Component):
        super().__init__(root)
        ends = (check_there(end) for component in self.components for pair in component.connections for end in pair[:2])
        self._connected = {(id(end.component), end.field.name, end.index) for end in ends}
        self.bindings = {one.path: _OnDemand(partial(self._outside, one)) for one in self.components}

    def __enter__(self) -> _Sparing:
        for component, binding in zip(self.components, self.bindings.values(), strict=True):
            vars(component)["_binding"] = binding
        return self

    def __exit__(self, *_: object) -> None:
        for component in self.components:
            vars(component)["_binding"] = None

    def _outside(self, component: Component, name: str) -> Any:
        """What stands for a name, found while components give values, as at the start of a flattening."""
        bound = vars(component)["_binding"] is not None
        if bound:
            self.__exit__()
        try:
            return self.value_of(component, name)
        finally:
            if bound:
                self.__enter__()

    def value_of(self, component: Component, name: str) -> Any:
        """What stands for a name of a component in its equations."""
        if name in component.parameters:
            return self._parameter(component, name)
        if name in component.outers:
            return component.find_outer(component.outers[name])
        if name in component.variables:
            return self._variable(component, component.variables[name])
        if name in component.offered_events:
            return Happening(component.offered_events[name])
        field = component.ports[name]
        size = component.port_size(field)
        ports = [self._port(component, field, index) for index in ([None] if size is None else range(size))]
        return ports[0] if size is None else ports

    def _port(self, component: Component, field: Port, index: int | None) -> Any:
        path = join(component.path, field.name if index is None else f"{field.name}[{index}]")
        if issubclass(field.annotation, Signal):
            return ca.SX.sym(path, *two_dimensions(component.shape_of(field)))
        connected = (id(component), field.name, index) in self._connected
        node = PortNode(0, 0, component, field, index, path, connected)
        members = field.annotation.members
        symbols = {name: member_symbol(self.system, node, name, member, False) for name, member in members.items()}
        for name, member in members.items():
            if member.kind == "orientation":
                self.system.orient(symbols[name], symbols[member.angular_velocity])
        return BoundPort(path, field.annotation, connected, symbols)
