"""The statements that `equations()` returns, and `der` and `external`, which belong to the model being flattened."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language.errors import StructureError
from fowtlib.language.to_come import ToCome


class Flattener(Protocol):
    """What `der` and `external` need from the flattening that calls `equations()`."""

    def derivative(self, expression: ca.SX) -> ca.SX: ...

    def external(self, function: ca.Function | ToCome, inputs: ca.SX) -> ca.SX: ...

    def at_start(self, numbers: AtStart) -> ca.SX: ...

    def stage(self, states: ca.SX, step: ca.SX) -> None: ...

    def quadratic(self, inputs: ca.SX, added: ca.SX, smoothing: float) -> None: ...

    @property
    def time(self) -> ca.SX: ...


@dataclass(slots=True)
class AtStart:
    """Numbers that are computed when a run starts; see fowtlib.language.run_time.at_start."""

    name: str
    size: int
    unit: str
    doc: str
    compute: Callable[[Any], Any]
    of: Any = None
    functions: tuple[Any, ...] = ()


_active: list[Flattener] = []


def active() -> Flattener:
    """The flattening in progress; an error outside of `equations()`."""
    if not _active:
        raise StructureError("der(), external() and self.time work only inside equations().")
    return _active[-1]


class flattening:
    """Context in which `equations()` may be called."""

    def __init__(self, flattener: Flattener):
        self.flattener = flattener

    def __enter__(self) -> Flattener:
        _active.append(self.flattener)
        return self.flattener

    def __exit__(self, *_: object) -> None:
        _active.pop()


def der(expression: Any) -> Any:
    """Time derivative of any expression of variables, connector members and time."""
    return active().derivative(_column(expression))


def open_input(name: str, size: int, unit: str, doc: str, default: Any = 0.0) -> ca.SX:
    """A column of `size` signals that come from outside of the whole model: its input `<path of the part>.<name>`.

    default: values [unit] where nobody gives any. A name that the part has given already gets a number behind it.
    """
    return active().open_input(name, size, unit, doc, default)


def input_rate(signal: Any, rate: Any) -> None:
    """Say how fast a signal changes where it is an input of the model, which otherwise counts as held: der() gives it.

    Where the signal is driven by an output of the model, der() is that of the output, and this says nothing.
    """
    active().set_input_rate(ca.SX(signal), ca.SX(rate))


def external(function: ca.Function | ToCome, inputs: Any) -> ca.SX:
    """Outputs of `function` (a CasADi Function of one dense column, giving one dense column) at `inputs`.

    The flat model is torn here: the function is called as a whole, with its own Jacobian.
    """
    return active().external(function, ca.SX(inputs))


def source_line(depth: int = 2) -> str:
    """`file:line` of the caller of the caller."""
    frame = sys._getframe(depth)
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"


def place(source: str) -> str:
    """`folder/file.py:12` of a full `file:line`, short enough for a message."""
    return "/".join(source.rsplit("/", 2)[-2:])


@dataclass(slots=True)
class Equation:
    """lhs = rhs at all times."""

    lhs: ca.SX
    rhs: ca.SX
    source: str


@dataclass(slots=True)
class Initial:
    """lhs = rhs at the start."""

    lhs: ca.SX
    rhs: ca.SX
    source: str


@dataclass(slots=True)
class Assign:
    """At an event: `target` (discrete variable, or state for a `reinit`) takes the value."""

    target: ca.SX
    value: ca.SX
    is_reinit: bool = False


class Session(Protocol):
    """One run of a process: what it remembers from sample to sample lives here."""

    def step(self, t: float, inputs: np.ndarray) -> ArrayLike:
        """Outputs that hold from the sample at t [s] on, from the inputs at that instant; ModelError where it fails."""

    def close(self) -> None:
        """Free what the run has used; called once, also after a failure."""

    # Where the process says `keeps_state`:
    # saved_state() -> bytes: all that the session remembers; ModelError where it fails.
    # restore_state(state): go on as the session that gave it, also in a fresh one; ModelError where it does not fit.


class Process(Protocol):
    """Something with a memory that is not written as equations: a co-simulation FMU, the library of a controller.

    An attribute `keeps_state` that is true: its sessions can save and restore what they remember, see Session.
    """

    def start(self) -> Session:
        """A fresh session, independent of all others; called once in a simulation, at the first sample."""


@dataclass(slots=True)
class Call:
    """At a sample: `target` (discrete variables) takes the outputs of a process at `value`, its inputs."""

    target: ca.SX
    value: ca.SX
    process: Process
    is_reinit: bool = False


@dataclass(slots=True)
class When:
    """Actions at the instant at which a condition becomes true."""

    condition: ca.SX
    actions: tuple[Assign, ...]
    source: str


@dataclass(slots=True)
class On:
    """Actions at the instant at which an event that the part offers happens in a run; `event` is a Happening."""

    event: Any
    actions: tuple[Assign, ...]
    source: str


@dataclass(slots=True)
class Sampled:
    """Assignments at multiples of a period, or one call of a process."""

    period: Any
    offset: Any
    assignments: tuple[Assign | Call, ...]
    source: str

    @property
    def process(self) -> Process | None:
        """The process that is called; None where there are assignments only."""
        return next((item.process for item in self.assignments if isinstance(item, Call)), None)


@dataclass(slots=True)
class Assertion:
    """A condition that is checked at output points; `values` are put into the message."""

    condition: ca.SX
    message: str
    level: str
    source: str
    values: dict[str, ca.SX] = field(default_factory=dict)


@dataclass(slots=True)
class Rotation:
    """R_b = R_a @ R_rel and w_b = w_a + R_a @ w_rel."""

    frame_a: Any
    frame_b: Any
    R_rel: ca.SX
    w_rel: ca.SX
    source: str


@dataclass(slots=True)
class FixedOrientation:
    """The orientation and angular velocity of a frame are given."""

    frame: Any
    R: ca.SX
    w: ca.SX
    source: str


@dataclass(slots=True)
class CyclicSymmetry:
    """Parts that are copies of each other, at equal angles around an axis, and the angle by which they have turned."""

    angle: ca.SX
    parts: list[Any]
    source: str


def _column(value: Any) -> ca.SX:
    if isinstance(value, ca.SX):
        return value if value.is_dense() else ca.densify(value)
    if type(value) in (int, float):
        return ca.SX(value)
    try:
        return ca.densify(ca.SX(ca.DM(value)))
    except (NotImplementedError, TypeError, RuntimeError):
        raise StructureError(f"{value!r} ({type(value).__name__}) cannot stand in an equation.") from None


def _pair(lhs: Any, rhs: Any) -> tuple[ca.SX, ca.SX]:
    a, b = _column(lhs), _column(rhs)
    if a.shape != b.shape:
        if b.is_scalar():
            b = ca.repmat(b, *a.shape)
        elif a.is_scalar():
            a = ca.repmat(a, *b.shape)
        else:
            raise StructureError(
                f"the sides of an equation have different shapes: {_shape(a)} on the left, {_shape(b)} on the right."
            )
    return a, b


def _shape(value: ca.SX) -> str:
    return f"{value.shape[0]} x {value.shape[1]}"


def eq(lhs: Any, rhs: Any) -> Equation:
    """`lhs = rhs` at all times; scalars, vectors or matrices of equal shape (a scalar stands for a filled one)."""
    return Equation(*_pair(lhs, rhs), source_line())


def initial(lhs: Any, rhs: Any) -> Initial:
    """`lhs = rhs` at the start of a simulation; it takes the place of the start value of a state."""
    return Initial(*_pair(lhs, rhs), source_line())


def assign(target: Any, value: Any) -> Assign:
    """In `when` or `sampled`: the discrete variable `target` takes `value` and keeps it."""
    return Assign(*_pair(target, value))


def call(target: Any, process: Process, inputs: Any) -> Call:
    """In `sampled`, alone: the discrete variables `target` take the outputs of a process with a memory of its own.

    It is called exactly once in every sample, between the steps of the solver, with the numbers of `inputs`. A list of
    targets or of inputs is read as one column.
    """
    return Call(_joined(target), _joined(inputs), process)


def _joined(items: Any) -> ca.SX:
    if not isinstance(items, (list, tuple)):
        return ca.vec(_column(items))
    return ca.vertcat(*[ca.vec(_column(item)) for item in items]) if items else ca.SX(0, 1)


def reinit(state: Any, value: Any) -> Assign:
    """In `when`: the state jumps to `value`."""
    return Assign(*_pair(state, value), is_reinit=True)


def when(condition: Any, *actions: Assign) -> When:
    """`actions` at the instant at which `condition` (a < b or a > b) becomes true."""
    return When(_column(condition), _actions("when", actions, Assign), source_line())


def on(event: Any, *actions: Assign) -> On:
    """`actions` at the instant at which `event`, which the class declares by `event(...)`, happens in a run.

    All of them see the values before it. A run says which events happen, and when; see fowtlib.solving.timeline.
    """
    if not hasattr(event, "declared"):
        raise StructureError("on() takes an event that the class declares: `loss: OfferedEvent = event(doc=...)`.")
    taken = _actions("on", actions, Assign)
    if not taken:
        raise StructureError("on() has nothing to do: give it an assign(target, value), or several.")
    return On(event, taken, source_line())


def _actions(statement: str, items: Sequence[Any], kinds: Any) -> tuple[Any, ...]:
    """What stands in a when() or sampled(), lists of it opened; refused where it is no assignment."""
    found: list[Any] = []
    for item in items:
        if isinstance(item, (list, tuple)):
            found += _actions(statement, item, kinds)
        elif isinstance(item, kinds):
            found.append(item)
        elif isinstance(item, Equation):
            raise StructureError(
                f"{statement}() takes no equations: at such an instant a variable is given a value, and keeps it; "
                "write assign(target, value) in place of eq(target, value)."
            )
        else:
            what = "call()" if isinstance(item, Call) else f"{item!r}"
            raise StructureError(
                f"{statement}() takes assignments, assign(target, value), and {what if len(what) < 60 else 'this'} "
                "is none."
            )
    return tuple(found)


def sampled(period: Any, *assignments: Assign | Call, offset: Any = 0.0) -> Sampled:
    """Assignments carried out every `period` seconds, in order; each sees the values assigned before it.

    Instead of assignments it takes one `call` of a process.
    """
    assignments = _actions("sampled", assignments, (Assign, Call))
    if not assignments:
        raise StructureError("sampled() has nothing to do: give it an assign(target, value), or several.")
    if any(isinstance(item, Assign) and item.is_reinit for item in assignments):
        raise StructureError("sampled() cannot make a state jump; write reinit() in a when().")
    if len(assignments) > 1 and any(isinstance(item, Call) for item in assignments):
        raise StructureError("a sampled() with a call() has nothing else in it; write a second sampled().")
    return Sampled(period, offset, assignments, source_line())


def assert_(condition: Any, message: str, level: str = "error", **values: Any) -> Assertion:
    """Checked at every output point: "error" stops the simulation there, "warning" is said once.

    "rest" is an error of an equilibrium, and says nothing in a run, which may pass through such a state. "step" is a
    warning of a run whose output points, or whose steps by the solver `fixed`, are further apart than the value
    `seconds`, which it must have: what is too quick for them is not resolved.
    values: scalars that are put into the message where it has their name in braces.
    """
    if level not in ("error", "warning", "rest", "step"):
        raise StructureError(f"assert_(level={level!r}): choose 'error', 'warning', 'rest' or 'step'.")
    if level == "step" and "seconds" not in values:
        raise StructureError("assert_(level='step') needs the value `seconds`: the longest step that resolves it.")
    return Assertion(_column(condition), message, level, source_line(), {k: _column(v) for k, v in values.items()})


def rotation(frame_a: Any, frame_b: Any, R_rel: Any, w_rel: Any) -> Rotation:
    """frame_b is turned by `R_rel` against frame_a: R_b = R_a @ R_rel.

    `w_rel` is its angular velocity relative to frame_a, resolved in frame_a. The assembler writes R and w of either
    frame, or three equations where a loop closes.
    """
    return Rotation(frame_a, frame_b, _column(R_rel), _column(w_rel), source_line())


def fix_orientation(frame: Any, R: Any, w: Any) -> FixedOrientation:
    """The orientation and angular velocity (world) of a frame are given: a root of the orientation graph."""
    return FixedOrientation(frame, _column(R), _column(w), source_line())


def cyclic_symmetry(angle: Any, parts: Sequence[Any]) -> CyclicSymmetry:
    """The parts are alike and stand in a ring: the next one is the last, turned on by 1 / len(parts) of a turn.

    `angle` is the angle by which all of them have turned around the axis, positive towards the next part. It is no
    equation but a hint for solvers: what couples such a ring to the rest of a model turns with it, and a solver that
    keeps a Newton matrix over many steps can turn the matrix too (`fixed`; it needs three parts or more, and an angle
    that is a state). A wrong hint costs time and no accuracy.
    """
    return CyclicSymmetry(_column(angle), list(parts), source_line())


Statements = list[Any]
Function = Callable[..., Any]
