"""IDAS, the reference engine: CasADi's interface on the flat DAE, with the torn Jacobian.

It integrates one interval in normalised time s = (t - t_a) / h, so that one integrator object serves intervals of any
length; every call is a real restart, which is what jumps in inputs and discrete variables need.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr
from functools import cache, cached_property
from io import StringIO
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.solving.engines.compiled import CompiledFunctions
from fowtlib.solving.failure import StepFailure
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.initial import consistent_algebraics

LIMIT = 100_000
REASONS = {
    "IDA_TOO_MUCH_WORK": f"{LIMIT:,} steps do not reach the next point",
    "IDA_ERR_FAIL": "no step is short enough for the tolerance",
    "IDA_CONV_FAIL": "the equations of a step are not solved, however short it is",
    "IDA_REP_RES_ERR": "an equation is not a finite number",
    "IDA_FIRST_RES_FAIL": "an equation is not a finite number",
    "IDA_LSETUP_FAIL": "the equations of a step are singular",
    "IDA_LSOLVE_FAIL": "the equations of a step are singular",
    "IDA_LINESEARCH_FAIL": "the values at its start are not consistent",
    "IDA_NO_RECOVERY": "the values at its start are not consistent",
}


@cache
def _one_thread() -> None:
    """Let CasADi's own OpenBLAS use one thread: shared among several, a few hundred rows take longer."""
    for path in Path(ca.__file__).parent.glob("libcasadi-tp-openblas.*"):  # the same library under several names
        try:
            library = ctypes.CDLL(str(path), mode=getattr(os, "RTLD_NOLOAD", 0) | ctypes.DEFAULT_MODE)
        except OSError:  # not the name that was loaded
            continue
        if hasattr(library, "openblas_set_num_threads"):
            library.openblas_set_num_threads(1)


def absolute_tolerance(at: AtParameters, tolerance: float) -> float:
    """Of all states: that of the one whose values are the smallest."""
    return tolerance * min((state.nominal for state in at.dae.states), default=1.0)


SMALL = 40  # unknowns that are factored as a full matrix, which pivots


class Idas:
    """Integrates from a consistent point over an interval, with equidistant output points."""

    name, seen = "idas", np.empty((0, 0))
    advice = "or try another tolerance (--tolerance 1e-8)"

    def __init__(self, at: AtParameters, tolerance: float, options: dict | None = None,
                 compiled: CompiledFunctions | None = None):  # fmt: skip
        self.at = at
        self.functions = compiled or at.functions
        self._handle = compiled.handle if compiled else np.zeros(0)
        self._compiled = compiled
        self.tolerance = tolerance
        self.options = options or {}

    @cached_property
    def _linear_solver(self) -> str:
        # the sparse LU of csparse hardly pivots, and loses the light tips of blades; where rounding is all that is left
        # of what should be zero, the reflections of the sparse QR end in a division of underflows
        small = self.at.dae.x.numel() + self.at.dae.z.numel() <= SMALL
        if (small or (self._compiled and self._compiled.full)) and ca.has_linsol("lapacklu"):
            _one_thread()
            return "lapacklu"
        return "qr"

    @property
    def attributes(self) -> dict[str, float | str]:
        """What a result says about its solver."""
        return {"solver": self.name, "tolerance": self.tolerance}

    def algebraics(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Algebraic unknowns that satisfy the equations at the states, after a jump."""
        return consistent_algebraics(self.at, t, x, z, q)

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes (see SampledUpdate.values), as a function of t, x, z, q."""
        return self.at.updater(sample)

    def advance(
        self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic unknowns (rows) at `points` equidistant times after t; StepFailure where IDAS fails."""
        nx, nz = len(x), len(z)
        if nx == 0:
            raise RuntimeError("a model without states is not integrated")
        integrator = self.integrator(points)
        given = np.concatenate([[t, length], self.at.whole(q), self._handle])
        with redirect_stderr(StringIO()):  # SUNDIALS says there what the caller says better
            try:
                result = integrator(x0=x, z0=z, p=given)
            except RuntimeError as error:
                found = re.search(r'returned "(IDA_\w+)"', str(error))
                if not found:
                    raise
                raise StepFailure(REASONS.get(found[1], f"IDAS says {found[1]}")) from None
        xf = np.array(result["xf"]).T.reshape(points, nx)
        zf = np.array(result["zf"]).T.reshape(points, nz)
        if not (np.all(np.isfinite(xf)) and np.all(np.isfinite(zf))):
            raise StepFailure("the solution is not finite")
        return xf, zf

    def stop(self, now: bool) -> None:
        """Let `advance`, which runs in another thread, fail soon where the equations are compiled.

        Interpreted ones go on to their next point; the integrator is theirs then, and later runs get another one.
        """
        if isinstance(self.functions, CompiledFunctions):
            self.functions.stop(now)
        elif now:
            self.at.functions.abandoned += 1

    def remarks(self) -> list[str]:
        """Nothing: it chooses its steps."""
        return []

    def memory(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Nothing: each interval is a new start."""
        return {"engine": "idas"}, {}

    def remember(self, text: Mapping[str, Any], numbers: Mapping[str, np.ndarray]) -> None:
        """Nothing; ValueError where it is the memory of another engine."""
        if text["engine"] != "idas":
            raise ValueError("the memory of its solver is that of another one")

    def integrator(self, points: int) -> ca.Function:
        """The integrator to that many output points; made once for all runs with these settings."""
        settings = (points, self.tolerance, self._linear_solver, repr(self.options), self.at.functions.abandoned)
        return self.at.functions.once(("idas", self.functions, settings), lambda: self._create(points))

    def _create(self, points: int) -> ca.Function:
        grid = [(k + 1) / points for k in range(points)]
        options = {
            "reltol": self.tolerance,
            "abstol": absolute_tolerance(self.at, self.tolerance),
            "suppress_algebraic": True,
            "max_num_steps": LIMIT,  # between two points of the grid
            "show_eval_warnings": False,
            "linear_solver": self._linear_solver,
            "first_time": 1e-6,  # IDACalcIC steps 1e-3 of this: short, so that its Newton matrix is that of alg alone
            **self.options,
        }
        problem = self.at.functions.once(("problem", self.functions), self._normalised)
        return ca.integrator("idas", "idas", problem, 0, grid, options)

    def _normalised(self) -> dict[str, ca.MX]:
        """The DAE in s, with t_a, h and q as parameters; the right-hand side carries its own Jacobian."""
        residual, jacobian = self.functions.residual, self.functions.jacobian
        s = ca.MX.sym("s")
        x, z = (ca.MX.sym(n, residual.size1_in(i)) for i, n in ((1, "x"), (2, "z")))
        p = ca.MX.sym("p", 2 + residual.size1_in(3))
        t, h, q = p[0] + s * p[1], p[1], p[2:]
        ode, alg = residual(t, x, z, q)
        by_x, by_z, alg_x, alg_z = jacobian(t, x, z, q)
        nx, nz, np_ = x.shape[0], z.shape[0], p.shape[0]
        out_ode, out_alg = ca.MX.sym("out_ode", nx), ca.MX.sym("out_alg", nz)
        blocks = [ca.MX(nx, 1), h * by_x, h * by_z, ca.MX(nx, np_), ca.MX(nz, 1), alg_x, alg_z, ca.MX(nz, np_)]
        jac = ca.Function("jac_rhs", [s, x, z, p, out_ode, out_alg], blocks)
        rhs = ca.Function("rhs", [s, x, z, p], [h * ode, alg], ["s", "x", "z", "p"], ["ode", "alg"],
                          {"custom_jacobian": jac, "never_inline": True, "jac_penalty": 0})  # fmt: skip
        ode_value, alg_value = rhs(s, x, z, p)
        return {"t": s, "x": x, "z": z, "p": p, "ode": ode_value, "alg": alg_value}
