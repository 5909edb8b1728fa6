"""IDAS on the compiled equations of the fixed-step engine, called without CasADi in between; see ida.c.

It is what Idas is: the same tolerances, the same start of an interval, the same reasons where it fails.
"""

from __future__ import annotations

import ctypes as c
from functools import cache
from pathlib import Path

import numpy as np

from fowtlib.language.native import Library, load_library
from fowtlib.solving.engines.c_lanes import for_this_processor
from fowtlib.solving.engines.fixed_step_code import FixedStepCode, Options, runtime
from fowtlib.solving.engines.idas import LIMIT, REASONS, Idas, absolute_tolerance
from fowtlib.solving.engines.sundials import CALLS, Sundials
from fowtlib.solving.failure import StepFailure
from fowtlib.solving.functions import AtParameters

CODES = {
    -1: "IDA_TOO_MUCH_WORK", -3: "IDA_ERR_FAIL", -4: "IDA_CONV_FAIL", -6: "IDA_LSETUP_FAIL", -7: "IDA_LSOLVE_FAIL",
    -8: "IDA_RES_FAIL", -9: "IDA_REP_RES_ERR", -12: "IDA_FIRST_RES_FAIL", -13: "IDA_LINESEARCH_FAIL",
    -14: "IDA_NO_RECOVERY",
}  # fmt: skip
COUNTS = ("steps", "residuals", "jacobians", "error_test_failures")


class Problem(c.Structure):
    """ida_problem."""

    _fields_ = [
        ("calls", c.c_void_p * len(CALLS)), ("solve_place", c.c_size_t),
        *((name, c.c_void_p) for name in ("krylov_solve", "equations", "values", "derivatives", "see")),
        *((name, c.c_int) for name in ("states", "algebraics", "given", "substituted")),
        *((name, c.c_void_p) for name in ("order", "source", "unknown")), ("relative", c.c_double),
        ("absolute", c.c_double), ("most_steps", c.c_long),
    ]  # fmt: skip


@cache
def _compiled_driver() -> Library:
    """The compiled driver, the same for all models."""
    text = (Path(__file__).parent / "ida.c").read_text(encoding="utf-8")
    _, library = load_library(for_this_processor(text), "ida", optimization="-O3")
    library.ida_create.argtypes, library.ida_create.restype = [c.POINTER(Problem)], c.c_void_p
    library.ida_free.argtypes, library.ida_free.restype = [c.c_void_p], None
    library.ida_advance.argtypes = [c.c_void_p, c.c_double, c.c_double, c.c_int, *7 * [c.c_void_p]]
    library.ida_counts.argtypes, library.ida_counts.restype = [c.c_void_p] * 2, None
    return library


class CompiledIdas(Idas):
    """Idas where the equations are compiled, and SUNDIALS itself can be called."""

    def __init__(self, at: AtParameters, tolerance: float, code: FixedStepCode, ida: Sundials):
        super().__init__(at, tolerance)
        self.code, self.seen = code, np.empty((0, code.width))
        self._equations, self._ida = runtime(), _compiled_driver()
        options = Options(1.0, 1.0, 1.0, 1.0, 1, 1)
        self._instance = self._equations.fs_create(c.byref(code.table), c.byref(options))
        reduced, dae = code.reduction, code.dae
        self._tables = [np.array(numbers, dtype=np.intc) for numbers in (
            reduced.order, reduced.source, reduced.unknown_of_states(len(dae.algebraics)),
        )]  # fmt: skip
        functions = [c.cast(getattr(self._equations, f"fs_{name}"), c.c_void_p)
                     for name in ("values", "derivatives", "see")]  # fmt: skip
        self._sizes = code.table.states, code.table.algebraics
        self._library = ida  # it must not be closed
        problem = Problem(
            (c.c_void_p * len(CALLS))(*ida.calls), ida.place, ida.krylov, self._instance, *functions, *self._sizes,
            code.table.given, len(reduced.order), *(table.ctypes.data for table in self._tables), tolerance,
            absolute_tolerance(at, tolerance), LIMIT,
        )  # fmt: skip
        self._driver = self._ida.ida_create(c.byref(problem)) if self._instance else None
        if not self._driver:
            raise MemoryError("no memory for the solver idas")

    def __del__(self):
        if getattr(self, "_driver", None):
            self._ida.ida_free(self._driver)
        if getattr(self, "_instance", None):
            self._equations.fs_free(self._instance)
        self._driver = self._instance = None

    def advance(
        self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic unknowns (rows) at `points` equidistant times after t; StepFailure where IDAS fails."""
        point = [np.ascontiguousarray(values, dtype=float) for values in (x, z, self.at.whole(q))]
        xs, zs = (np.empty((points, size)) for size in self._sizes)
        seen, self.seen = np.full((points, self.code.width), np.nan), self.seen[:0]
        reached, stopped = c.c_int(), c.c_int()
        self._equations.fs_watch(
            self._instance, self.code.address("observed"), self.code.size, self.code.address("checked"),
            self.code.width, self.code.constants, seen.ctypes.data if seen.size else None,
        )  # fmt: skip
        status = self._ida.ida_advance(
            self._driver, t, length, points, *(values.ctypes.data for values in (*point, xs, zs)), c.byref(reached),
            c.byref(stopped),
        )  # fmt: skip
        done = slice(reached.value)
        self.seen = seen[done]
        if status and not stopped.value:
            name = CODES.get(status, f"code {status}")
            raise StepFailure(REASONS.get(name, f"IDAS says {name}"))
        if not (np.isfinite(xs[done]).all() and np.isfinite(zs[done]).all()):
            raise StepFailure("the solution is not finite")
        return xs[done], zs[done]

    def stop(self, now: bool) -> None:
        """Let `advance`, which runs in another thread, return what it has; False: no more."""
        self._equations.fs_stop(self._instance, int(now))

    def counts(self) -> dict[str, int]:
        """What has been done so far."""
        values = (c.c_longlong * len(COUNTS))()
        self._ida.ida_counts(self._driver, c.byref(values))
        return dict(zip(COUNTS, values, strict=True))
