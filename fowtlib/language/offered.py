"""What can happen to a part: events that it offers by name, for a run to carry out at a time or at a crossing.

    class Line(Component):
        loss: OfferedEvent = event(doc="the line breaks")
        intact: Scalar = var(discrete=True, start=1.0, doc="1, and 0 from the loss on")

        def equations(self):
            return [..., on(self.loss, assign(self.intact, 0))]

The equations are the same with and without events: they know discrete variables, which an event sets.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import casadi as ca

from fowtlib.language.declarations import Field, Parameter, Scalar, VariableReference
from fowtlib.language.units import check_si


class OfferedEvent(Field):
    """Declaration of an event; `values` are what may be given with it, by name, as parameters are declared."""

    def __init__(self, doc: str, values: dict[str, Parameter]):
        self.doc, self.values = doc, values

    def __set_name__(self, owner: type, name: str) -> None:
        super().__set_name__(owner, name)
        for key, value in self.values.items():
            value.name, value.owner, value.annotation = key, owner, Scalar
            check_si(value.unit, f"{owner.__name__}.{name}, value '{key}'")

    def outside(self, component: Any) -> VariableReference:
        return VariableReference(component, self.name)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """A value of the event."""


class Happening:
    """An event inside of equations(): the symbols of its values are attributes."""

    def __init__(self, declared: OfferedEvent):
        self.declared = declared
        self.symbols = {name: ca.SX.sym(f"{declared.name}.{name}") for name in declared.values}

    def __getattr__(self, name: str) -> ca.SX:
        symbols = self.__dict__.get("symbols", {})
        if name in symbols:
            return symbols[name]
        raise AttributeError(f"the event '{self.declared.name}' has no value '{name}'")


def event(*, doc: str, init: Literal[False] = False, **values: Any) -> Any:
    """Declare something that can happen to a part, and by `on(self.name, ...)` in equations() what it does then.

    values: what a user may give with the event, each declared by `param`, with a unit and a default, which may depend
    on the parameters of the part: `event(doc="emergency stop", rate=param(default="8 deg/s", unit="rad/s"))`. In
    equations() they are `self.emergency_stop.rate`, known in the actions of `on` only.
    """
    for name, value in values.items():
        if not isinstance(value, Parameter) or value.required:
            raise TypeError(f"event(): the value '{name}' is declared by param(default=..., unit=..., doc=...)")
    return OfferedEvent(doc, values)
