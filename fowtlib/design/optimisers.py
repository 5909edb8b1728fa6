"""Optimisers behind one interface: IPOPT through CasADi, SLSQP and trust-constr of SciPy, and one for dear models.

All see the scaled problem of `fowtlib.design.problem` with its slopes, and stay within the bounds of the variables.
Where a point has no results (no equilibrium, an unstable pole), IPOPT shortens its step itself; those of SciPy start
anew from their best point within a region that is smaller, and grows again.

Sources: A. Waechter and L. T. Biegler, Mathematical Programming 106 (2006), 25-57 (IPOPT); D. Kraft, DFVLR-FB 88-28
(1988) (SLSQP); R. H. Byrd, M. E. Hribar, J. Nocedal, SIAM J. Optim. 9 (1999), 877-900 (trust-constr).
"""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable
from typing import Any, Protocol

import casadi as ca
import numpy as np

from fowtlib.design.settings import Ended, Settings
from fowtlib.design.successive import search
from fowtlib.language.errors import ModelError, one_of
from fowtlib.solving.interrupts import deferred_interrupt

SMALLEST = 1e-4  # of the ranges of the variables: a region in which nothing more is sought
INSIDE = 1e-6  # of a region: where a method of the interior may begin
NEAR = 1e-2  # of the region: what is so near to its edge is held by it


class Scaled(Protocol):
    """What an optimiser sees: see fowtlib.design.problem.Problem. ModelError is raised where there are no results."""

    lower: np.ndarray
    upper: np.ndarray
    y_lower: np.ndarray
    y_upper: np.ndarray

    def f(self, y: np.ndarray) -> float: ...
    def g(self, y: np.ndarray) -> np.ndarray: ...
    def slopes(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...


Optimiser = Callable[[Scaled, np.ndarray, Settings], Ended]


def optimiser(method: str) -> Optimiser:
    """By its name. Raises ModelError for an unknown one."""
    if method not in METHODS:
        raise ModelError(f"there is no optimiser '{method}'; take {one_of(METHODS)}.")
    return METHODS[method]


# -- IPOPT -------------------------------------------------------------------------------------------------------------

_REASONS = {
    "Solve_Succeeded": "an optimum",
    "Solved_To_Acceptable_Level": "an optimum, less exact than asked for",
    "Infeasible_Problem_Detected": "no point near keeps all constraints",
    "Maximum_Iterations_Exceeded": "the limit of iterations",
    "Search_Direction_Becomes_Too_Small": "steps became too small",
    "Restoration_Failed": "no way back to the constraints was found",
    "Invalid_Number_Detected": "a point without slopes",
    "Error_In_Step_Computation": "no further step was found",
    "Feasible_Point_Found": "a feasible point",
    "Not_Enough_Degrees_Of_Freedom": "there are more equalities than variables",
}


def ipopt(problem: Scaled, y: np.ndarray, settings: Settings) -> Ended:
    """IPOPT with the Hessian of limited memory."""
    guard = _Guard()
    n, k = y.size, problem.lower.size
    parts: dict[str, tuple[list[tuple[int, int]], Callable[[np.ndarray], tuple]]] = {
        "nlp": ([(1, 1), (k, 1)], lambda v: (problem.f(v), problem.g(v))),
        "grad_f": ([(1, 1), (n, 1)], lambda v: (problem.f(v), problem.slopes(v)[0])),
        "jac_g": ([(k, 1), (k, n)], lambda v: (problem.g(v), problem.slopes(v)[1])),
    }
    functions = {name: _Callback(name, [n, 0], shapes, guard.of(call)) for name, (shapes, call) in parts.items()}
    own = {"hessian_approximation": "limited-memory", "tol": settings.tolerance, "max_iter": settings.iterations,
           "constr_viol_tol": settings.tolerance, "dual_inf_tol": max(settings.tolerance, 1e-4) * 10,
           "acceptable_tol": 100 * settings.tolerance, "acceptable_iter": 5, "bound_relax_factor": 0.0,
           "print_level": 0, "sb": "yes", **settings.options}  # fmt: skip
    options = {"ipopt": own, "print_time": False, "show_eval_warnings": False, "error_on_fail": False,
               "grad_f": functions["grad_f"], "jac_g": functions["jac_g"], "calc_lam_p": False,
               "no_nlp_grad": True}  # fmt: skip
    solver = ca.nlpsol("design", "ipopt", functions["nlp"], options)
    with deferred_interrupt() as guard.interrupted:
        try:
            found = solver(x0=y, lbx=problem.y_lower, ubx=problem.y_upper, lbg=problem.lower, ubg=problem.upper)
        except Exception:
            guard.again()
            raise
        guard.again()
    status = solver.stats()["return_status"]
    reason = _REASONS.get(status, status.replace("_", " ").lower())
    reason += f" (the last failure: {guard.failure})" if guard.failure and status not in _REASONS else ""
    y = np.clip(np.array(found["x"]).ravel(), problem.y_lower, problem.y_upper)
    return Ended(y, status in ("Solve_Succeeded", "Solved_To_Acceptable_Level"), reason)


class _Guard:
    """Keeps what was raised in a callback, where CasADi would swallow it: a point without results is not a number."""

    def __init__(self) -> None:
        self.raised: BaseException | None = None
        self.interrupted = threading.Event()  # Ctrl-C, which CasADi would swallow, too
        self.failure = ""

    def of(self, function: Callable[[np.ndarray], tuple]) -> Callable[[np.ndarray], tuple | None]:
        def guarded(y: np.ndarray) -> tuple | None:
            if (
                self.raised is not None or self.interrupted.is_set()
            ):  # let the optimiser come to its end, without a further evaluation
                return None
            try:
                return function(y)
            except ModelError as error:
                self.failure = str(error)
                return None
            except BaseException as error:
                self.raised = error
                return None

        return guarded

    def again(self) -> None:
        """Raise what was raised."""
        if self.raised is not None:
            raise self.raised
        if self.interrupted.is_set():
            raise KeyboardInterrupt


class _Callback(ca.Callback):
    """Columns -> dense matrices of given sizes; all are nan where the function gives None."""

    def __init__(self, name: str, inputs: list[int], outputs: list[tuple[int, int]],
                 function: Callable[[np.ndarray], tuple | None]):  # fmt: skip
        ca.Callback.__init__(self)
        self.ins, self.outs, self.function = inputs, outputs, function
        self.names = {"nlp": ("f", "g"), "grad_f": ("f", "grad_f_x"), "jac_g": ("g", "jac_g_x")}[name]
        self.construct(name, {})

    def get_n_in(self) -> int:
        return len(self.ins)

    def get_n_out(self) -> int:
        return len(self.outs)

    def get_name_in(self, i: int) -> str:
        return ("x", "p")[i]

    def get_name_out(self, i: int) -> str:
        return self.names[i]

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self.ins[i], 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(*self.outs[i])

    def eval(self, arg: list[ca.DM]) -> list[ca.DM]:
        found = self.function(np.array(arg[0]).ravel())
        if found is None:
            return [ca.DM.nan(*shape) for shape in self.outs]
        return [ca.DM(np.reshape(value, shape)) for value, shape in zip(found, self.outs, strict=True)]


# -- SciPy -------------------------------------------------------------------------------------------------------------


class _NoResults(Exception):
    """A point without results stops an optimiser of SciPy."""


def _scipy(method: str) -> Optimiser:
    def solve(problem: Scaled, y: np.ndarray, settings: Settings) -> Ended:
        return _in_regions(method, problem, y, settings)

    return solve


def _in_regions(method: str, problem: Scaled, y: np.ndarray, settings: Settings) -> Ended:
    """From the best point again and again, within a region about it that shrinks where there are no results."""
    left, radius = settings.iterations, np.inf
    ranges = np.where(np.isfinite(problem.y_upper - problem.y_lower), problem.y_upper - problem.y_lower, 1.0)
    while True:
        lower = np.maximum(problem.y_lower, y - radius * ranges)
        upper = np.minimum(problem.y_upper, y + radius * ranges)
        track = _Track(problem, y, (lower, upper))
        try:
            ended, used = _minimize(method, problem, track, y, (lower, upper), settings, left)
        except _NoResults as failed:
            moved = not np.array_equal(track.best, y)
            reached = float(np.max(np.abs(track.failed - track.best) / ranges, initial=0.0))
            y, radius = track.best, min(radius, reached) / 2
            left -= track.iterations
            if left <= 0 or (radius < SMALLEST and not moved):
                reason = "the limit of iterations" if left <= 0 else f"no further step has results: {failed}"
                return Ended(y, False, reason)
            continue
        y, left = ended.y, left - used
        close = NEAR * np.minimum(upper - lower, 1.0)  # methods of the interior keep a distance
        held = (y <= lower + close) & (lower > problem.y_lower) | (y >= upper - close) & (upper < problem.y_upper)
        if left <= 0 or not np.any(held):
            return ended
        radius *= 4


class _Settled(Exception):
    """The iterates of SLSQP stand still."""


class _Track:
    """The best iterate of a search, by its objective and a penalty on its constraints, and the point that failed."""

    def __init__(self, problem: Scaled, y: np.ndarray, box: tuple[np.ndarray, np.ndarray]):
        self.problem, self.best, self.failed, self.iterations, self.box = problem, y, y, 0, box
        self.merit, self.now, self.f_now = np.inf, y, np.inf

    def sees(self, y: np.ndarray, f: float, g: np.ndarray) -> None:
        over = np.maximum(g - self.problem.upper, self.problem.lower - g).clip(0.0).sum()
        if f + 100.0 * over < self.merit:
            self.merit, self.best = f + 100.0 * over, np.array(y)

    def stands_still(self, y: np.ndarray, tolerance: float) -> bool:
        """Whether an iterate that keeps its constraints moves no more by what counts; slopes are not exact to more."""
        before, self.now = self.now, np.clip(y, *self.box)
        g, f = self.problem.g(self.now), self.problem.f(self.now)
        over = np.maximum(g - self.problem.upper, self.problem.lower - g).max(initial=0.0)
        fell = abs(f - self.f_now)
        self.f_now = f
        still = float(np.max(np.abs(self.now - before))) <= 10 * tolerance and fell <= 0.01 * tolerance
        return still and over <= tolerance

    def sound(self, function: Callable[[np.ndarray], Any]) -> Callable[[np.ndarray], Any]:
        def called(y: np.ndarray) -> Any:
            y = np.clip(y, *self.box)  # trust-constr looks outside, too, and takes no notice of what it sees there
            try:
                self.sees(y, self.problem.f(y), self.problem.g(y))
                return function(y)
            except ModelError as error:
                self.failed = np.array(y)
                raise _NoResults(str(error)) from None

        return called


def _minimize(method: str, problem: Scaled, track: _Track, y: np.ndarray, box: tuple[np.ndarray, np.ndarray],
              settings: Settings, iterations: int) -> tuple[Ended, int]:  # fmt: skip
    from scipy.optimize import Bounds, NonlinearConstraint, minimize

    f, df = track.sound(problem.f), track.sound(lambda v: problem.slopes(v)[0])
    g, dg = track.sound(problem.g), track.sound(lambda v: problem.slopes(v)[1])

    def counted(v: np.ndarray, *_: Any) -> None:
        track.iterations += 1
        if method == "SLSQP" and track.stands_still(v, settings.tolerance):
            raise _Settled

    common = {"jac": df, "bounds": Bounds(*box, keep_feasible=True), "callback": counted}
    if method == "SLSQP":
        equal = problem.lower == problem.upper
        above, below = ~equal & np.isfinite(problem.lower), ~equal & np.isfinite(problem.upper)
        constraints: Any = []
        if np.any(equal):
            target = problem.lower[equal]
            constraints.append({"type": "eq", "fun": lambda v: g(v)[equal] - target, "jac": lambda v: dg(v)[equal]})
        if np.any(above | below):
            constraints.append({
                "type": "ineq",
                "fun": lambda v: np.concatenate([(g(v) - problem.lower)[above], (problem.upper - g(v))[below]]),
                "jac": lambda v: np.concatenate([dg(v)[above], -dg(v)[below]]),
            })  # fmt: skip
        options = {"maxiter": iterations, "ftol": settings.tolerance * 1e-4, **settings.options}
    else:
        constraints = [NonlinearConstraint(g, problem.lower, problem.upper, jac=dg)] if problem.lower.size else []
        options = {"maxiter": iterations, "gtol": settings.tolerance * 1e-2, "xtol": 1e-10, **settings.options}
        inside = INSIDE * np.minimum(box[1] - box[0], 1.0)
        y = np.clip(y, box[0] + inside, box[1] - inside)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="delta_grad == 0.0")  # of a result that is linear
        try:
            found = minimize(f, y, method=method, constraints=constraints, options=options, **common)
        except _Settled:
            return Ended(track.now, True, "an optimum"), max(track.iterations, 1)
    over = np.maximum(g(found.x) - problem.upper, problem.lower - g(found.x)).max(initial=0.0)
    if method == "SLSQP":
        converged, reason = found.status == 0, _SLSQP.get(found.status, str(found.message).lower())
    else:
        converged, reason = found.status in (1, 2), _TRUST.get(found.status, str(found.message).lower())
    if converged and over > max(100 * settings.tolerance, 1e-5):
        converged, reason = False, "no point near keeps all constraints"
    return Ended(np.clip(found.x, *box), converged, reason), max(track.iterations, 1)


_SLSQP = {0: "an optimum", 4: "no point near keeps all constraints", 8: "no further step was found",
          9: "the limit of iterations", 6: "no further step was found"}  # fmt: skip
_TRUST = {0: "the limit of iterations", 1: "an optimum", 2: "an optimum; steps became small"}


METHODS: dict[str, Optimiser] = {
    "ipopt": ipopt,
    "slsqp": _scipy("SLSQP"),
    "trust-constr": _scipy("trust-constr"),
    "successive": search,
}
