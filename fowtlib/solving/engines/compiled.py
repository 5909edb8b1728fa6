"""Residual and Jacobian for IDAS from the compiled code of the fixed-step engine, where the equations are many.

CasADi interprets the equations at some 5 ns an operation, and the exact Jacobian of a flexible turbine has half a
million of them. The compiled code takes a fraction of that, and its Jacobian, by differences of the equations with the
exact Jacobians of the externals, is good enough for Newton's method: the solution does not depend on it.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.externals import LibraryFunction
from fowtlib.language.native import compiler, load_library
from fowtlib.language.tables import SplineFunction
from fowtlib.solving.engines.fixed_step_code import FixedStepCode, Options, runtime
from fowtlib.solving.functions import Functions

OPERATIONS = (2_000, 200_000)  # of the equations: below, compiling takes longer than most runs, and above, too long
FULL = 0.1  # share of entries in a Jacobian: with more, the sparse factors fill up and cost more than those of LAPACK
UNKNOWNS = 1000  # at most: the Jacobian is made by full columns


def worth_compiling(functions: Functions) -> bool:
    """Whether IDAS should have compiled equations: many of them, with a compiler, and no external in Python."""
    dae = functions.dae
    if not compiler() or not dae.states or len(dae.states) + len(dae.algebraics) > UNKNOWNS:
        return False
    if not all(isinstance(external.function, LibraryFunction | SplineFunction) for external in dae.externals):
        return False
    return OPERATIONS[0] < functions.operations < OPERATIONS[1]


class CompiledFunctions:
    """`residual` and `jacobian` as those of Functions, with `handle` behind the parameters in q.

    full: whether so many entries of the Jacobian can be other than zero that it is better factored as a full matrix.
    """

    def __init__(self, code: FixedStepCode):
        dae, self._code = code.dae, code
        patterns = jacobian_patterns(dae)
        given = sum(column.shape[0] for column in (dae.u, dae.d, dae.p))
        sizes = {"STATES": dae.x.shape[0], "ALGEBRAICS": dae.z.shape[0], "GIVEN": given}
        names = ("ode_x", "ode_z", "alg_x", "alg_z")
        head = "".join(f"#define {name} {size}\n" for name, size in sizes.items()) + "".join(
            f"static const long long int {name}[] = {{{', '.join(map(str, _stored(pattern)))}}};\n"
            for name, pattern in zip(names, patterns, strict=True)
        )
        body = (Path(__file__).parent / "compiled.c").read_text(encoding="utf-8")
        path, self._library = load_library(head + body, "functions")
        self._runtime = runtime()
        self._unknown = np.array(code.reduction.unknown_of_states(len(dae.algebraics)), dtype=np.intc)
        options = Options(1.0, 1.0, 1.0, 1.0, 1, 1)
        self._instance = self._runtime.fs_create(c.byref(code.table), c.byref(options))
        if not self._instance:
            raise MemoryError("no memory for the compiled equations")
        self._library.dae_bind.argtypes = 4 * [c.c_void_p]
        self._number = self._library.dae_bind(
            self._instance, c.cast(self._runtime.fs_values, c.c_void_p),
            c.cast(self._runtime.fs_derivatives, c.c_void_p), self._unknown.ctypes.data,
        )  # fmt: skip
        if self._number < 0:
            raise MemoryError("no memory for the compiled equations")
        self.handle = np.array([float(self._number)])
        self.full = sum(pattern.nnz() for pattern in patterns) > FULL * (sizes["STATES"] + sizes["ALGEBRAICS"]) ** 2
        self.residual = ca.external("dae_residual", str(path))
        self.jacobian = ca.external("dae_jacobian", str(path))

    def stop(self, now: bool) -> None:
        """Let the equations fail, so that a solver that runs in another thread ends; False: no more."""
        self._runtime.fs_stop(self._instance, int(now))

    def __del__(self):
        if getattr(self, "_number", -1) >= 0:
            self._library.dae_release(self._number)
        if getattr(self, "_instance", None):
            self._runtime.fs_free(self._instance)
        self._number, self._instance = -1, None


def jacobian_patterns(dae: FlatDAE) -> list[ca.Sparsity]:
    """Patterns of d ode/dx, d ode/dz, d alg/dx, d alg/dz, through the externals."""
    columns = ca.vertcat(dae.x, dae.z)
    through = ca.DM(dae.w.shape[0], columns.shape[0])
    for group in dae.levels:
        rows = []
        for k in group:
            external = dae.externals[k]
            slope = external.function.jacobian().sparsity_out(0)
            rows.append((external.outputs, ca.mtimes(ca.DM(slope, 1), _moved(dae, external.inputs, columns, through))))
        for outputs, moved in rows:
            through[outputs, :] = moved
    ends = [0, dae.x.shape[0], columns.shape[0]]
    total = _moved(dae, ca.vertcat(dae.ode, dae.alg), columns, through)
    return [block.sparsity() for row in ca.vertsplit(total, ends) for block in ca.horzsplit(row, ends)]


def _moved(dae: FlatDAE, rows: ca.SX, columns: ca.SX, through: ca.DM) -> ca.DM:
    """Numbers where rows depend on columns, themselves or through the outputs of externals; as a sparse matrix."""
    function = ca.Function("rows", [columns, dae.w], [ca.densify(rows)], {"allow_free": True})
    direct, by_w = (ca.DM(function.jac_sparsity(0, i), 1) for i in range(2))
    return ca.sparsify(direct + ca.mtimes(by_w, through))


def _stored(pattern: ca.Sparsity) -> Sequence[int]:
    """A pattern in CasADi's form of compressed columns."""
    return [*pattern.shape, *pattern.colind(), *pattern.row()]
