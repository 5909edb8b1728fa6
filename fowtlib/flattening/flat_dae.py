"""FlatDAE: the one object that everything above flattening reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening.system import Bound, BoundParameter, Input, Parameter
from fowtlib.language.bounds import outside, shown
from fowtlib.language.equations import Process
from fowtlib.language.errors import NotFoundError, ParameterError, did_you_mean
from fowtlib.language.offered import OfferedEvent
from fowtlib.language.operators import StateSpace, Transfer
from fowtlib.language.stages import Stage


def _freeze(item: Any) -> None:
    """Make tuples of the lists of a frozen dataclass, and read-only views of copies of its dictionaries."""
    for name, value in vars(item).items():
        if isinstance(value, list):
            object.__setattr__(item, name, tuple(value))
        elif isinstance(value, dict):
            object.__setattr__(item, name, MappingProxyType(dict(value)))


@dataclass(frozen=True)
class Quantity:
    """A scalar state, algebraic unknown or discrete variable."""

    path: str
    unit: str
    doc: str
    hint: str
    start: ca.SX
    start_given: bool
    fixed: bool
    nominal: float


@dataclass(frozen=True)
class External:
    """One call of an external function: w[outputs] = function(y)."""

    function: ca.Function
    inputs: ca.SX
    outputs: slice
    path: str


@dataclass(frozen=True)
class Event:
    """State event: when `indicator` becomes negative, targets (numbers of states or discretes) take the values."""

    indicator: ca.SX
    state_targets: tuple[int, ...]
    state_values: ca.SX
    discrete_targets: tuple[int, ...]
    discrete_values: ca.SX
    path: str

    def __post_init__(self) -> None:
        _freeze(self)


@dataclass(frozen=True)
class Offer:
    """Something that can happen to the component at `owner`: targets (numbers of states or discretes) take the values.

    values: expressions of the model and of `given`, a column of symbols, one for each declared value of the event.
    """

    path: str
    owner: str
    declared: OfferedEvent
    given: ca.SX
    state_targets: tuple[int, ...]
    state_values: ca.SX
    discrete_targets: tuple[int, ...]
    discrete_values: ca.SX

    def __post_init__(self) -> None:
        _freeze(self)


@dataclass(frozen=True)
class SampledUpdate:
    """Time event every `period` from `offset` on: discretes take the values.

    With a `process` its outputs go to the targets instead, and `values` are its inputs. It is called once in every
    sample, by the run of a simulation, not from inside of any function.
    """

    period: ca.SX
    offset: ca.SX
    targets: tuple[int, ...]
    values: ca.SX
    path: str
    process: Process | None = None

    def __post_init__(self) -> None:
        _freeze(self)


@dataclass(frozen=True)
class Check:
    """A condition that holds at every output point."""

    condition: ca.SX
    message: str
    level: str
    values: Mapping[str, ca.SX]
    path: str

    def __post_init__(self) -> None:
        _freeze(self)


@dataclass(frozen=True)
class CyclicSymmetry:
    """Paths of parts that are alike, at equal angles around an axis around which they have turned by an angle."""

    angle: ca.SX
    parts: tuple[str, ...]

    def __post_init__(self) -> None:
        _freeze(self)


@dataclass(frozen=True)
class Operator:
    """A linear operator: expressions of its inputs (m,), and entries of p (n, 3), see language.operators.

    transfer(omega), complex (q, n, m), is what the realization in the equations stands for.
    """

    path: str
    inputs: ca.SX
    correction: ca.SX
    transfer: Transfer
    realization: StateSpace


@dataclass(frozen=True)
class Quadratic:
    """A law |u| u: expressions of u (n,), and entries of p (n,) that are added to it, see language.quadratic_laws.

    smoothing: of |u|, in its unit.
    """

    path: str
    inputs: ca.SX
    added: ca.SX
    smoothing: float


@dataclass(frozen=True, repr=False)
class FlatDAE:
    """Semi-explicit DAE of index one, torn at the external functions; a value that nothing changes once it is made.

    der(x) = ode, 0 = alg, both SX expressions of (t, x, z, u, d, p, w); w are the outputs of the externals, whose
    inputs are expressions of the same symbols. `observed` gives every variable of the model by path. p holds the
    tunable `parameters`, then the numbers that are computed when a run starts, `bound`; only these depend on the
    `bound_parameters`. `dependents` are the parameters that follow from the tunable ones, expressions of p.
    """

    t: ca.SX
    x: ca.SX
    z: ca.SX
    u: ca.SX
    d: ca.SX
    p: ca.SX
    w: ca.SX
    ode: ca.SX
    alg: ca.SX
    states: tuple[Quantity, ...]
    algebraics: tuple[Quantity, ...]
    discretes: tuple[Quantity, ...]
    inputs: Mapping[str, Input]
    parameters: Mapping[str, Parameter]
    externals: tuple[External, ...]
    observed: Mapping[str, ca.SX]
    units: Mapping[str, str]
    docs: Mapping[str, str]
    residual_paths: tuple[str, ...]
    initial_equations: ca.SX
    initial_paths: tuple[str, ...]
    events: tuple[Event, ...] = ()
    offers: tuple[Offer, ...] = ()
    samples: tuple[SampledUpdate, ...] = ()
    checks: tuple[Check, ...] = ()
    symmetries: tuple[CyclicSymmetry, ...] = ()
    operators: tuple[Operator, ...] = ()
    quadratics: tuple[Quadratic, ...] = ()
    stages: tuple[Stage, ...] = ()
    bound: Mapping[str, Bound] = field(default_factory=dict)
    bound_parameters: Mapping[str, BoundParameter] = field(default_factory=dict)
    dependents: Mapping[str, Parameter] = field(default_factory=dict)
    write_equations: Callable[[], list[tuple[str, str, str]]] = list
    initial_sources: tuple[str, ...] = ()
    stats: Mapping[str, float] = field(default_factory=dict)
    key: str = ""
    """Digest of all that it was flattened from, but for bound parameters; "" where that is not known."""

    def __post_init__(self) -> None:
        _freeze(self)

    @cached_property
    def _dependent_values(self) -> ca.Function:
        """Of p: all dependent parameters, one after the other."""
        return ca.Function("dependents", [self.p], [ca.vertcat(*[ca.vec(d.symbol) for d in self.dependents.values()])])

    def check_dependents(self, p: np.ndarray) -> None:
        """ParameterError where a parameter that follows from the tunable ones leaves its bounds at these values."""
        if not self.dependents:
            return
        values, first = np.array(self._dependent_values(p)).ravel(), 0
        lowest, highest = self._dependent_bounds
        if np.all((values >= lowest) & (values <= highest) & np.isfinite(values)):
            return
        for item in self.dependents.values():
            numbers = values[first : first + item.symbol.numel()]
            first += item.symbol.numel()
            wrong = numbers[~np.isfinite(numbers)]
            found = (float(wrong[0]), "no finite number") if wrong.size else outside(
                numbers, item.min, item.max, item.unit)  # fmt: skip
            if found:
                raise ParameterError(
                    f"{item.path} = {shown(found[0], item.unit)} is {found[1]} ({item.doc}); it follows from the "
                    "values that were given."
                )

    @cached_property
    def with_data(self) -> list[tuple[int, Bound]]:
        """Numbers of the externals that find data by a handle, their first input, and what is bound to it."""
        bound = {item.symbol[0].element_hash(): item for item in self.bound.values() if item.functions}
        handles = [ca.vec(external.inputs)[0].element_hash() for external in self.externals]
        return [(k, bound[handle]) for k, handle in enumerate(handles) if handle in bound]

    @cached_property
    def silent(self) -> list[int]:
        """Numbers of the entries of p that only the frequency domain uses for quadratic laws; zero in time."""
        if not self.quadratics:
            return []
        place = {symbol.element_hash(): k for k, symbol in enumerate(self.p.elements())}
        return [place[symbol.element_hash()] for law in self.quadratics for symbol in law.added.elements()]

    def in_time(self, expressions: list[ca.SX]) -> list[ca.SX]:
        """Expressions without what only the frequency domain adds."""
        if not self.silent:
            return expressions
        return ca.substitute(expressions, [self.p[self.silent]], [ca.SX.zeros(len(self.silent))])

    @cached_property
    def _dependent_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the greatest value of each element of the dependent parameters."""
        items = self.dependents.values()
        counts = [item.symbol.numel() for item in items]
        bounds = [(-np.inf if item.min is None else item.min, np.inf if item.max is None else item.max)
                  for item in items]  # fmt: skip
        lowest, highest = np.repeat(np.array(bounds, dtype=float).T, counts, axis=1)
        return lowest, highest

    @cached_property
    def equation_table(self) -> list[tuple[str, str, str]]:
        """The equations as components wrote them: path of the component, text of the left and of the right side."""
        return self.write_equations()

    @cached_property
    def levels(self) -> list[list[int]]:
        """Externals in groups that can be called one after the other: each needs outputs of earlier groups only."""
        level: dict[int, int] = {}
        owner = np.zeros(self.w.shape[0], int)
        for k, external in enumerate(self.externals):
            owner[external.outputs] = k
        needs = []
        for external in self.externals:
            pattern = ca.Function("needs", [self.w], [external.inputs], {"allow_free": True}).jac_sparsity(0, 0)
            needs.append({int(owner[c]) for c in pattern.get_triplet()[1]})
        groups: list[list[int]] = []
        while len(level) < len(self.externals):
            ready = [k for k, n in enumerate(needs) if k not in level and n <= level.keys()]
            if not ready:  # external functions in a ring are excluded by their symbols being made after their inputs
                raise RuntimeError("external functions depend on each other in a ring")
            for k in ready:
                level[k] = len(groups)
            groups.append(ready)
        return groups

    @cached_property
    def level_inputs(self) -> list[ca.SX]:
        """Inputs of the externals of each level, one after the other in a dense column."""
        return [ca.vertcat(*[ca.vec(ca.densify(self.externals[k].inputs)) for k in group]) for group in self.levels]

    def needs_outputs(self, expression: ca.SX) -> bool:
        """Whether an expression depends on outputs of the externals."""
        return ca.Function("needs", [self.w], [expression], {"allow_free": True}).jac_sparsity(0, 0).nnz() > 0

    @cached_property
    def names(self) -> list[str]:
        """Paths of all variables: scalars, and arrays as a whole."""
        arrays = dict.fromkeys(name.rpartition("[")[0] for name in self.observed if name.endswith("]"))
        return [*self.observed, *arrays]

    def observe_expression(self, name: str) -> ca.SX:
        """Expression of a variable by path; an array as a whole is the column or matrix of its elements."""
        if name in self.observed:
            return self.observed[name]
        if name.endswith("[0]") and name[:-3] in self.observed:  # an array of one element
            return self.observed[name[:-3]]
        rows = 0
        while f"{name}[{rows}]" in self.observed:
            rows += 1
        if rows:
            return ca.vertcat(*[self.observed[f"{name}[{i}]"] for i in range(rows)])
        while f"{name}[{rows},0]" in self.observed:
            rows += 1
        columns = 0
        while f"{name}[0,{columns}]" in self.observed:
            columns += 1
        if rows:
            return ca.blockcat([[self.observed[f"{name}[{i},{j}]"] for j in range(columns)] for i in range(rows)])
        raise NotFoundError(f"there is no variable '{name}'{did_you_mean(name, self.names)}")

    def __repr__(self) -> str:
        return (
            f"<FlatDAE: {len(self.states)} states, {len(self.algebraics)} algebraic unknowns, "
            f"{len(self.parameters)} parameters, {len(self.externals)} external functions>"
        )
