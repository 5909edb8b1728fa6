"""Numeric functions of a FlatDAE, made once and for all values of its parameters, torn at its external functions.

The chain rule through the externals is assembled here in scalar symbols, with the Jacobians of the externals as inputs:
building the Jacobian through the whole graph instead is many times slower.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cached_property
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.solving.arrays import Arrays
from fowtlib.solving.binding import Binding

MANY = 300  # columns from which a sparse Jacobian is better than a directional one
SHORT = {"cse": True}  # common subexpressions once: parameters as arguments leave more of them
POINTS = (100, 10, 1)  # at which a function is evaluated in one call
MOST = 64  # things made on demand that are held at once; the one that was not used for longest goes first

Made = TypeVar("Made")


class Functions:
    """The functions of a FlatDAE. Arguments of all of them, unless said otherwise: t, x, z, and q = [u; d; p].

    They are made when first asked for, and hold no number that a run may change: other values of parameters need no
    other functions. `at` gives them with the parameters put in.

    zeros: numbers of parameters in p that are zero, and what they multiply is left out: a fifth of the operations of
    two turbines, whose parts stand on straight lines. `at` chooses them, and makes other functions where
    one of them is zero no longer.
    """

    def __init__(self, dae: FlatDAE, zeros: frozenset[int] = frozenset()):
        self.dae, self.zeros = dae, zeros
        self._lean: Functions | None = None
        self.t, self.x, self.z, self.w = dae.t, dae.x, dae.z, dae.w
        self.q = ca.vertcat(dae.u, dae.d, dae.p)
        self._externals = [_Differentiable(external.function) for external in dae.externals]
        self._made: dict[Hashable, Any] = {}
        self._last: AtParameters | None = None
        self._tunable = sum(item.symbol.numel() for item in dae.parameters.values())
        self.abandoned = 0  # integrators that were left to run on in another thread

    def at(self, binding: Binding) -> AtParameters:
        """The functions at what a run takes in, without those parameters that have been zero in all runs so far."""
        if self._last is not None and self._last.binding is binding:
            return self._last
        zeros = frozenset(np.flatnonzero(binding.p[: self._tunable] == 0).tolist()) | frozenset(self.dae.silent)
        if self._lean is None or not self._lean.zeros <= zeros:
            self._lean = Functions(self.dae, zeros & self._lean.zeros if self._lean else zeros)
        self._last = AtParameters(self._lean, binding, self)
        return self._last

    def once(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """What `make` returns, made for the first that asks for it by this key."""
        made = self._made.pop(key) if key in self._made else make()
        self._made[key] = made  # the last one used is the last to go
        if len(self._made) > MOST:
            del self._made[next(iter(self._made))]
        return made

    def has(self, key: Hashable) -> bool:
        """Whether `once` has something by this key."""
        return key in self._made

    def arrays(self, function: ca.Function) -> Arrays:
        """One of the functions of arrays."""
        return self.once(("arrays", function.__hash__()), lambda: Arrays(function))

    def along(self, function: ca.Function, points: int, held: bool = False) -> ca.Function:
        """`(t, x, z, [u; d], p) -> values of a function` at that many points, one column of each but p for a point.

        held: [u; d] is the same at all points, too, and given once.
        """

        def make() -> ca.Function:
            columns = [ca.MX.sym(n, v.shape[0]) for n, v in zip("txz", self._arguments, strict=False)]
            given, p = ca.MX.sym("given", self.q.shape[0] - self.dae.p.shape[0]), ca.MX.sym("p", self.dae.p.shape[0])
            inputs = [*columns, given, p]
            one = ca.Function("one", inputs, [ca.densify(function(*columns, ca.vertcat(given, p)))])
            return one.map(f"along_{points}", "serial", points, [3, 4] if held else [4], [])

        return self.once(("along", function.__hash__(), points, held), make)

    # --- building blocks -----------------------------------------------------------------------------------------

    @cached_property
    def external_inputs(self) -> list[ca.SX]:
        """The inputs of each external, as expressions."""
        return self.without_zeros([external.inputs for external in self.dae.externals])

    def without_zeros(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """Expressions with zero in place of the parameters that are zero."""
        if not self.zeros or not expressions:
            return list(expressions)
        places = sorted(self.zeros)
        return ca.substitute(list(expressions), [self.dae.p[places]], [ca.SX.zeros(len(places))])

    @property
    def _arguments(self) -> list[ca.SX]:
        return [self.t, self.x, self.z, self.q]

    def _called(self, needed: set[int] | None = None) -> tuple[list[ca.MX], ca.MX, dict[int, ca.MX]]:
        """Symbols t, x, z, q, the outputs of the externals at them, and the inputs of each external."""
        arguments = [ca.MX.sym(name, *value.shape) for name, value in zip("txzq", self._arguments, strict=True)]
        outputs: list[ca.MX] = [
            ca.MX(external.outputs.stop - external.outputs.start, 1) for external in self.dae.externals
        ]
        inputs: dict[int, ca.MX] = {}
        for level, group in enumerate(self.dae.levels):
            members = [k for k in group if needed is None or k in needed]
            if not members:
                continue
            inside = [self.external_inputs[k] for k in members]
            function = ca.Function(f"inputs_{level}", [*self._arguments, self.w], inside, SHORT)
            values = function(*arguments, ca.vertcat(*outputs) if outputs else ca.MX(0, 1))
            for k, y in zip(members, values if isinstance(values, (list, tuple)) else [values], strict=True):
                inputs[k] = y
                outputs[k] = ca.vec(self._externals[k].function(y))
        return arguments, (ca.vertcat(*outputs) if outputs else ca.MX(0, 1)), inputs

    def function(self, name: str, expressions: Sequence[ca.SX], names: Sequence[str] = ()) -> ca.Function:
        """`(t, x, z, q) -> expressions`, calling the external functions that they need."""
        columns = self.without_zeros(expressions)
        labels = list(names) or [f"o{i}" for i in range(len(columns))]
        inner = ca.Function(name, [*self._arguments, self.w], columns, ["t", "x", "z", "q", "w"], labels, SHORT)
        needed = self.needed(columns)
        if not needed:
            return ca.Function(name, self._arguments, columns, ["t", "x", "z", "q"], labels, SHORT)
        arguments, w, _ = self._called(needed)
        values = inner(*arguments, w)
        values = list(values) if isinstance(values, (list, tuple)) else [values]
        return ca.Function(name, arguments, values, ["t", "x", "z", "q"], labels)

    def needed(self, expressions: Sequence[ca.SX]) -> set[int]:
        """Externals whose outputs the expressions depend on, directly or through other externals."""
        if not self.dae.externals:
            return set()
        owner = np.zeros(self.w.shape[0], int)
        for k, external in enumerate(self.dae.externals):
            owner[external.outputs] = k

        def direct(column: ca.SX) -> set[int]:
            pattern = ca.Function("needs", [self.w], [column], {"allow_free": True}).jac_sparsity(0, 0)
            return {int(owner[c]) for c in pattern.get_triplet()[1]}

        needed: set[int] = set()
        front = direct(ca.vertcat(*[ca.vec(ca.densify(e)) for e in expressions]))
        while front:
            needed |= front
            front = set().union(*(direct(self.external_inputs[k]) for k in front)) - needed
        return needed

    def torn_jacobian(self, name: str, rows: ca.SX, columns: Sequence[ca.SX]) -> ca.Function:
        """`(t, x, z, q) -> d rows / d columns[0], d rows / d columns[1], ...`, through the externals too.

        Columns of w are changes of what an external gives; those of a series, of its signals.

        The partial derivatives are expressions of scalars; their products with the Jacobians of the externals are
        sparse matrix products, because written out as scalars those of a rotor are a million operations.
        """
        rows = self.without_zeros([rows])[0]
        block_of = ca.vertcat(*columns)
        ends = [0, *np.cumsum([c.shape[0] for c in columns]).tolist()]
        needed = self.needed([rows])
        if not needed:
            blocks = ca.horzsplit(ca.sparsify(ca.jacobian(rows, block_of)), ends)
            return ca.Function(name, self._arguments, blocks)
        used, pieces = [], [ca.jacobian(rows, block_of), ca.jacobian(rows, self.w)]
        for k in (k for group in self.dae.levels for k in group if k in needed):
            y = self.external_inputs[k]
            if ca.depends_on(y, block_of) or ca.depends_on(y, self.w):  # those of waves and wind depend on time only
                used.append(k)
                pieces += [ca.jacobian(y, block_of), ca.jacobian(y, self.w)]
        pieces = [ca.sparsify(piece) for piece in pieces]
        inner = ca.Function(f"{name}_pieces", [*self._arguments, self.w], pieces)
        arguments, w, inputs = self._called(needed)
        by_columns, by_w, *slopes = inner(*arguments, w)
        through = ca.MX(self.w.shape[0], block_of.shape[0])
        for k, y_by_columns, y_by_w in zip(used, slopes[::2], slopes[1::2], strict=True):
            dy = y_by_columns + ca.mtimes(y_by_w, through)
            through = through + self._placed(k, ca.mtimes(self._externals[k].jacobian(inputs[k]), dy))
        total = by_columns + ca.mtimes(by_w, through)
        return ca.Function(name, arguments, ca.horzsplit(total, ends))

    def directional_jacobian(self, name: str, rows: ca.SX, columns: ca.SX) -> ca.Function:
        """`(t, x, z, q) -> d rows / d columns`, dense, column by column; the numbers are those of `torn_jacobian`.

        Its expressions are the derivative along one direction, evaluated for each column. They are found in the time of
        one column, and each evaluation costs more: for a Jacobian that is needed a few times.
        """
        rows = self.without_zeros([rows])[0]
        n, moving = columns.shape[0], ca.vertcat(columns, self.w)
        seed, w_seed = ca.SX.sym("seed", n), ca.SX.sym("w_seed", self.w.shape[0])

        def along(label: str, expression: ca.SX) -> ca.Function:
            """The derivative of an expression along n seeds at one point."""
            slope = ca.jtimes(expression, moving, ca.vertcat(seed, w_seed))
            one = ca.Function(f"{name}_{label}", [*self._arguments, self.w, seed, w_seed], [ca.densify(slope)])
            return one.map(f"{name}_{label}_all", "serial", n, [0, 1, 2, 3, 4], [])

        needed = self.needed([rows])
        arguments, w, inputs = self._called(needed)
        seeds, through = ca.MX(ca.DM.eye(n)), ca.MX(ca.DM.zeros(self.w.shape[0], n))
        for level, group in enumerate(self.dae.levels):
            members = [k for k in group if k in needed and ca.depends_on(self.external_inputs[k], moving)]
            if not members:
                continue
            y = ca.vertcat(*[ca.vec(ca.densify(self.external_inputs[k])) for k in members])
            dy = along(f"level_{level}", y)(*arguments, w, seeds, through)
            ends = [0, *np.cumsum([inputs[k].numel() for k in members]).tolist()]
            for k, dy_k in zip(members, ca.vertsplit(dy, ends), strict=True):
                through = through + self._placed(k, ca.mtimes(self._externals[k].jacobian(inputs[k]), dy_k))
        return ca.Function(name, arguments, [along("rows", rows)(*arguments, w, seeds, through)])

    def _placed(self, k: int, rows: ca.MX) -> ca.MX:
        """The rows of external k among those of all externals."""
        outputs = self.dae.externals[k].outputs
        above, below = outputs.start, self.w.shape[0] - outputs.stop
        return ca.vertcat(ca.MX(above, rows.shape[1]), rows, ca.MX(below, rows.shape[1]))

    def external_jacobian(self, k: int) -> ca.Function:
        """`inputs of external k -> d its outputs / d inputs`."""
        return self._externals[k].jacobian

    # --- the functions of the DAE --------------------------------------------------------------------------------

    @cached_property
    def residual(self) -> ca.Function:
        """`(t, x, z, q) -> ode, alg`."""
        return self.function("residual", [self.dae.ode, self.dae.alg], ["ode", "alg"])

    @cached_property
    def jacobian(self) -> ca.Function:
        """`(t, x, z, q) -> d ode/dx, d ode/dz, d alg/dx, d alg/dz`."""
        full = self.torn_jacobian("jacobian", ca.vertcat(self.dae.ode, self.dae.alg), [self.x, self.z])
        arguments = [ca.MX.sym(name, *value.shape) for name, value in zip("txzq", self._arguments, strict=True)]
        by_x, by_z = full(*arguments)
        n = self.x.shape[0]
        return ca.Function("jacobian", arguments, [by_x[:n, :], by_z[:n, :], by_x[n:, :], by_z[n:, :]])

    @cached_property
    def jacobian_entries(self) -> ca.Function:
        """`(t, x, z, q) -> the entries of the four blocks of jacobian`, as a column."""
        arguments = [ca.MX.sym(name, *value.shape) for name, value in zip("txzq", self._arguments, strict=True)]
        entries = [block.nz[:] for block in self.jacobian(*arguments) if block.nnz()]
        return ca.Function("jacobian_entries", arguments, [ca.vertcat(*entries) if entries else ca.MX(0, 1)])

    @property
    def algebraic_jacobian(self) -> ca.Function:
        """`(t, x, z, q) -> d alg/dz`: from `jacobian` where that is made already, or where the unknowns are many."""
        return self._algebraic_slice if "jacobian" in vars(self) or self.z.shape[0] > MANY else self._algebraic_alone

    @cached_property
    def _algebraic_slice(self) -> ca.Function:
        return self.jacobian.slice("algebraic_jacobian", [0, 1, 2, 3], [3])

    @cached_property
    def _algebraic_alone(self) -> ca.Function:
        return self.directional_jacobian("algebraic_jacobian", self.dae.alg, self.z)

    @cached_property
    def operations(self) -> int:
        """Scalar operations of ode and alg, without those of the external functions."""
        equations = ca.vertcat(self.dae.ode, self.dae.alg)
        return ca.Function("equations", ca.symvar(equations), [equations]).n_instructions()

    @cached_property
    def indicators(self) -> ca.Function:
        """`(t, x, z, q) -> indicators of the events`."""
        return self.function("indicators", [ca.vertcat(*[event.indicator for event in self.dae.events])])

    @cached_property
    def actions(self) -> list[ca.Function]:
        """For each event `(t, x, z, q) -> values of its states, values of its discrete variables`."""
        return [self.function("action", [e.state_values, e.discrete_values]) for e in self.dae.events]

    @cached_property
    def updates(self) -> list[ca.Function]:
        """For each sampled part `(t, x, z, q) -> what it computes` (see SampledUpdate.values)."""
        return [self.function("update", [sample.values]) for sample in self.dae.samples]

    @cached_property
    def conditions(self) -> ca.Function:
        """`(t, x, z, q) -> conditions of the checks`, 0 where one is broken."""
        return self.function("conditions", [ca.vertcat(*[check.condition for check in self.dae.checks])])

    def told(self, check: int) -> ca.Function:
        """`(t, x, z, q) -> values in the message of a check`."""
        values = list(self.dae.checks[check].values.values())
        return self.once(("told", check), lambda: self.function("told", [ca.vertcat(*values)]))

    def observed(self, paths: Sequence[str]) -> ca.Function:
        """`(t, x, z, q) -> all elements of variables`, those of a matrix column by column."""

        def make() -> ca.Function:
            return self.function("observe", [ca.vertcat(*[ca.vec(self.dae.observe_expression(p)) for p in paths])])

        return self.once(("observed", *paths), make)

    @cached_property
    def start(self) -> ca.Function:
        """`p -> start values of x, z and d`."""
        columns = [ca.vertcat(*[q.start for q in group]) if group else ca.SX(0, 1)
                   for group in (self.dae.states, self.dae.algebraics, self.dae.discretes)]  # fmt: skip
        return ca.Function("start", [self.dae.p], columns)

    @cached_property
    def clocks(self) -> ca.Function:
        """`p -> periods, offsets` of the sampled parts."""
        samples = self.dae.samples
        columns = [ca.vertcat(*[s.period for s in samples]), ca.vertcat(*[s.offset for s in samples])]
        return ca.Function("clocks", [self.dae.p], columns)


class AtParameters:
    """Functions with the parameters put in: of t, x, z, and q = [u; d].

    binding: what the parameters came from; its data stay known as long as the functions are used.
    general: the functions in which all parameters are symbols, also those that are zero.
    """

    def __init__(self, functions: Functions, binding: Binding, general: Functions):
        self.functions, self.dae, self.general, self.binding = functions, functions.dae, general, binding
        self.parameters = np.ascontiguousarray(binding.p, dtype=float)
        self._again: tuple[Any, list[np.ndarray]] | None = None

    def whole(self, q: np.ndarray) -> np.ndarray:
        """[u; d; p] of [u; d]."""
        return np.concatenate([q, self.parameters])

    def call(self, function: ca.Function, t: Any, x: Any, z: Any, q: Any) -> Any:
        """Values of one of the functions."""
        return function(t, x, z, self.whole(q))

    def along(self, function: ca.Function, t: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Values of one of the functions at many points: rows of the arguments and of what it returns are points."""
        n, columns = len(t), (t[None], x.T, z.T)
        held = bool(n) and bool((q == q[0]).all())
        blocks, first = [], 0
        for size in POINTS:
            count = (n - first) // size
            if count:
                at_once = self.functions.along(function, size, held)
            for _ in range(count):
                part = slice(first, first + size)
                given = q[0] if held else q.T[:, part]
                blocks.append(np.array(at_once(*(column[:, part] for column in columns), given, self.parameters)))
                first += size
        return np.concatenate(blocks, axis=1).T if blocks else np.zeros((0, function.size1_out(0)))

    def arrays(self, function: ca.Function, t: Any, x: Any, z: Any, q: Any) -> list[np.ndarray]:
        """Values of one of the functions as arrays."""
        return self.general.arrays(function)(t, x, z, self.whole(q))

    def arrays_again(self, function: ca.Function, t: Any, x: Any, z: Any, q: Any) -> list[np.ndarray]:
        """The same, not to be changed; those of the last point are kept, for a second one who asks for them."""
        key = function.__hash__(), float(t), *(np.asarray(value, dtype=float).tobytes() for value in (x, z, q))
        if self._again is None or self._again[0] != key:
            self._again = key, self.arrays(function, t, x, z, q)
        return self._again[1]

    def entries(self, function: ca.Function, t: Any, x: Any, z: Any, q: Any) -> list[np.ndarray]:
        """The entries of the values of one of the functions, column by column."""
        return self.general.arrays(function).entries(t, x, z, self.whole(q))

    def residual(self, t: Any, x: Any, z: Any, q: Any) -> tuple[ca.DM, ca.DM]:
        """Values of ode and alg."""
        return self.functions.residual(t, x, z, self.whole(q))

    def jacobian(self, t: Any, x: Any, z: Any, q: Any) -> tuple[ca.DM, ca.DM, ca.DM, ca.DM]:
        """D ode/dx, d ode/dz, d alg/dx, d alg/dz."""
        return self.functions.jacobian(t, x, z, self.whole(q))

    def algebraic_jacobian(self, t: Any, x: Any, z: Any, q: Any) -> ca.DM:
        """D alg/dz."""
        return self.functions.algebraic_jacobian(t, x, z, self.whole(q))

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes (see SampledUpdate.values), as a function of t, x, z, q."""
        update = self.functions.updates[sample]
        return lambda *point: np.array(self.call(update, *point)).ravel()

    def start_values(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Start values of x, z and d."""
        x, z, d = (np.array(value, dtype=float).ravel() for value in self.functions.start(self.parameters))
        return x, z, d

    def clocks(self) -> list[tuple[float, float]]:
        """Period and offset of each sampled part [s]."""
        periods, offsets = (np.array(column).ravel().tolist() for column in self.functions.clocks(self.parameters))
        return list(zip(periods, offsets, strict=True))


class _Differentiable:
    """An external function and its Jacobian."""

    def __init__(self, function: ca.Function):
        self.function = function

    @cached_property
    def jacobian(self) -> ca.Function:
        y = ca.MX.sym("y", self.function.size1_in(0))
        return ca.Function(f"{self.function.name()}_jac", [y], [ca.jacobian(ca.vec(self.function(y)), y)])
