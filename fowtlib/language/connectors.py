"""Connectors: what two components share where they are joined.

Potentials of joined ports are equal, flows sum to zero (positive into the component). An orientation is a rotation
matrix potential whose time derivative is given by the angular velocity beside it. Signals are directed: one output
drives any number of inputs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Literal, Self

from fowtlib.language.expressions import Arithmetic

PORT = "port"  # shape of a member that every port has as it declares it: port(shape=...)
Shape = tuple[int, ...] | Literal["port"]


class Member:
    """One quantity of a connector."""

    name: str = "?"

    def __init__(self, kind: str, shape: Shape, unit: str, doc: str, angular_velocity: str | None = None):
        self.kind, self.shape, self.unit, self.doc, self.angular_velocity = kind, shape, unit, doc, angular_velocity

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name


def potential(*, shape: Shape = (), unit: str = "1", doc: str = "") -> Any:
    """A quantity that is equal in a connection.

    shape: "port" for one that each port sizes: `modes: ModalCoordinates = port(shape="n_modes")`.
    """
    return Member("potential", shape, unit, doc)


def flow(*, shape: Shape = (), unit: str = "1", doc: str = "") -> Any:
    """A quantity that sums to zero in a connection, positive into the component; shape: as of a potential."""
    return Member("flow", shape, unit, doc)


def orientation(*, angular_velocity: str, doc: str = "") -> Any:
    """A rotation matrix (3 x 3, world from frame) that is equal in a connection; d/dt R = skew(w) R.

    `angular_velocity` names the potential member w of the same connector, resolved in the world.
    """
    return Member("orientation", (3, 3), "1", doc, angular_velocity)


class Connector:
    """Base class of acausal connectors; the members are class-body fields."""

    members: dict[str, Member] = {}
    sized: bool = False  # a port of it declares a shape

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        own = {name: value for name, value in vars(cls).items() if isinstance(value, Member)}
        cls.members = {**cls.members, **own}
        cls.sized = any(member.shape == PORT for member in cls.members.values())

    if TYPE_CHECKING:  # a port is declared by the class of its connector; one declaration may be an array of ports
        path: str

        def __getitem__(self, index: int) -> Self: ...
        def __iter__(self) -> Iterator[Self]: ...
        def __len__(self) -> int: ...


class Signal(Arithmetic if TYPE_CHECKING else object):
    """Base class of the directed signals."""

    if TYPE_CHECKING:
        path: str

        def __getitem__(self, index: Any) -> Any: ...
        def __len__(self) -> int: ...
        def __getattr__(self, name: str) -> Any: ...


class RealInput(Signal):
    """A real signal that the component reads."""


class RealOutput(Signal):
    """A real signal that the component gives."""


class BoundPort:
    """An acausal port while flattening: its members are CasADi expressions."""

    def __init__(self, path: str, connector: type, connected: bool, members: dict[str, Any]):
        self.path = path
        self.connector = connector
        self.connected = connected
        self.__dict__.update(members)

    def __repr__(self) -> str:
        return self.path
