"""An optimiser for models that are dear: results of the model are taken as linear, functions of them exactly.

Rules, costs and other functions of a design are expressions, which cost nothing; results of its model cost much, but
change little within a step, and nearly linearly. So in each step a problem is solved in which the results r are
r_0 + J (y - y_0) and all functions are themselves, within a region about y_0. What the model says at the new point
then decides on the step, and on the region. J is exact at times; in between it learns from each point that was
evaluated, by Broyden's update, which makes it agree with the last two. A step that leads outside of limits that bend
is corrected once, from the results at its end. Constraints that cannot be kept within the region are broken by the
least sum. Variables on which no result depends may go anywhere. At an optimum limits are broken by what bends within
the last step, and by what kinks were rounded off; a few short steps, with limits moved by the latter, keep them.

Sources: R. Fletcher, Practical Methods of Optimization (1987), chapter 14 (steps within a region, exact penalties);
C.G. Broyden, Mathematics of Computation 19 (1965), 577-593; L.A. Schmit and B. Farshi, AIAA Journal 12 (1974), 692-699
(approximation concepts in the design of structures).
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from fowtlib.design.rounding import rounded
from fowtlib.design.settings import Ended, Settings
from fowtlib.language.errors import ModelError

PENALTY = 10.0  # of a constraint that is broken by its scale, over the scale of the objective
FIRST, SMALLEST, LARGEST = 0.05, 1e-4, 0.5  # of the ranges of the variables: the region
WIDE = 0.01  # the region in which there must be nothing to gain at an optimum
GOOD, POOR, ACCEPTED = 0.7, 0.3, 0.02  # actual over expected improvement
DEARER, FALLING = 2.0, 0.3  # of the price of a limit: what is broken costs; and how fast that may fall
CHEAPEST = 0.05  # of the penalty: what costs least, as the price of a limit that is not reached is not known
ROUNDED = 1e-3  # of what is compared: kinks of the problem of a step are rounded off over it, those of merits are not
KEPT, NEAR = 5, 1e-3  # short steps at most that keep all limits at an optimum, and how short
AGE = 4  # steps for which slopes learn before they are taken anew


def search(problem: Any, y: np.ndarray, settings: Settings) -> Ended:
    """From y on.

    options: `region` (0.05), `age` (4 steps) and `penalty` (10), of limits that cannot be kept in a step, in place of
    those of this module; `say`, which is told of each step.
    """
    return _Search(problem, settings).run(y)


class _Search:
    def __init__(self, problem: Any, settings: Settings):
        self.problem, self.settings = problem, settings
        options = settings.options
        self.penalty, self.age = float(options.get("penalty", PENALTY)), int(options.get("age", AGE))
        self.region = float(options.get("region", FIRST))
        self.say = options.get("say", lambda line: None)
        self.sub = _Step(problem, self.penalty)
        self.prices = np.full(problem.lower.size, self.penalty)  # of limits that are broken, in the merit of a point

    def merit(self, r: np.ndarray, y: np.ndarray) -> float:
        f, g = self.problem.composition.function(self.problem.x(y), r)
        return float(f) / self.problem.f_scale + float(self.prices @ np.abs(_over(self.problem, np.ravel(g))))

    def run(self, y: np.ndarray) -> Ended:
        problem, reason = self.problem, "the limit of iterations"
        r, J = problem.linear(y)
        here, learned, poor, moved = self.merit(r, y), 0, 0, False  # since slopes were exact
        widened = False  # since a step was worth its while
        for _ in range(self.settings.iterations):
            new = self.sub(y, r, J, self.region)
            if self.sub.solved:
                self._set_prices(self.sub.prices)
            step, here = new - y, self.merit(r, y)
            expected = here - self.merit(r + J @ step, new)
            if expected <= self.settings.tolerance * max(abs(here), 1.0):
                if not self.sub.solved:  # where no step was found it is not known that there is none
                    self.say(f"the problem of a step in {self.region:.3f} was not solved: {self.sub.reason}")
                    self.region, reason = self.region / 2, f"no step was found: {self.sub.reason}"
                    if self.region < SMALLEST:
                        return Ended(y, False, reason)
                    continue
                if not learned and (widened or self.region >= WIDE):
                    told = "" if self.region >= WIDE else f", as far as steps of {self.region:.2g} tell"
                    return Ended(self._kept(y, r, J), True, f"an optimum{told}")
                if not learned:  # there is little to gain in a small region: is there in a larger one?
                    self.region, widened = WIDE, True
                    continue
                try:
                    (r, J), learned, poor, moved = problem.linear(y), 0, 0, False
                except ModelError as error:
                    return Ended(y, False, f"there are no exact slopes at what may be an optimum: {error}")
                continue
            try:
                found = self._results(new)
            except ModelError as error:
                reason, self.sub.free = f"no further step has results: {error}", False
                self.region = min(self.region, float(np.max(np.abs(step)))) / 4
                if self.region < SMALLEST:
                    return Ended(y, False, reason)
                continue
            J = _learnt(J, step, found - r)
            there = self.merit(found, new)
            if here - there < POOR * expected:
                new, found, there, J = self._corrected(y, new, found, there, J)
                step = new - y
            quality = (here - there) / expected
            self._tell(new, step * held(J), here, there, here - expected)
            self._resize(quality, step * held(J))
            if self.region < SMALLEST:
                return Ended(y, False, "steps became too small")
            learned, poor = learned + 1, poor + 1 if quality < POOR else 0
            if quality > ACCEPTED:
                widened = widened and here - there <= self.settings.tolerance * max(abs(here), 1.0)
                y, r, here, moved = new, found, there, True
            # a step that led astray was too long, and has taught something; two in a row ask for exact slopes
            if moved and (learned >= self.age or poor > 1):
                try:
                    (r, J), learned, poor, moved = problem.linear(y), 0, 0, False
                except ModelError as error:  # a kink of the model, just here: what was learned leads on
                    self.say(f"slopes stay those that were learned: {error}")
        return Ended(y, False, reason)

    def _corrected(self, y: np.ndarray, new: np.ndarray, found: np.ndarray, there: float,
                   J: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:  # fmt: skip
        """A point beside a new one, from the results there: what bends leaves it less far outside of its limits."""
        beside = self.sub(new, found, J, self.region, y)
        try:
            r = self._results(beside)
        except ModelError:
            return new, found, there, J
        J = _learnt(J, beside - new, r - found)
        merit = self.merit(r, beside)
        return (beside, r, merit, J) if merit < there else (new, found, there, J)

    def _kept(self, y: np.ndarray, r: np.ndarray, J: np.ndarray) -> np.ndarray:
        """A point beside an optimum that keeps all limits, or breaks them less than it."""
        best = self.problem.point(y)
        for _ in range(KEPT):
            if best.feasible:
                break
            given = self.problem.x(y), r
            off = np.ravel(self.problem.composition.function(*given)[1] - self.sub.rounded(*given)[1])
            new = self.sub(y, r, J, NEAR, off=off)
            try:
                found = self._results(new)
            except ModelError:
                break
            J, y, r = _learnt(J, new - y, found - r), new, found
            point = self.problem.point(new)
            self.say(f"beside it: {point.objective:.5g}, {point.violation:.2g} at {point.worst}")
            best = point if point.violation < best.violation else best
        return self.problem.y(best.x)

    def _set_prices(self, prices: np.ndarray) -> None:
        """What breaks a limit costs more than the limit is worth in a step, and not much more.

        So a step may bend out of its limits by what later ones take back. Prices fall slowly.
        """
        least = np.maximum(FALLING * self.prices, CHEAPEST * self.penalty)
        self.prices = np.minimum(np.maximum(DEARER * prices, least), DEARER * self.penalty)

    def _tell(self, y: np.ndarray, step: np.ndarray, here: float, there: float, expected: float) -> None:
        point, length = self.problem.point(y), np.max(np.abs(step))
        self.say(f"step {length:.3f} in {self.region:.3f}: {here:.5f} to {there:.5f}, not {expected:.5f}; "
                 f"{point.objective:.5g}, {point.violation:.2g} at {point.worst}")  # fmt: skip

    def _results(self, y: np.ndarray) -> np.ndarray:
        point = self.problem.point(y)
        if point.failure:
            raise ModelError(point.failure)
        return self.problem.composition.results(point.found)

    def _resize(self, quality: float, step: np.ndarray) -> None:
        if quality > GOOD:
            self.region = min(max(self.region, 1.5 * float(np.max(np.abs(step)))), LARGEST)
        elif quality < POOR:
            self.region = max(0.4 * min(self.region, float(np.max(np.abs(step)))), SMALLEST / 2)


WATCHFUL = {"ipopt.watchdog_shortened_iter_trigger": 3, "ipopt.max_soc": 8}  # where rules have kinks, steps are cut off


def _solver(problem: dict[str, ca.MX], **more: Any) -> ca.Function:
    """IPOPT, with functions as plain operations where they are some: derivatives then take a twentieth of the time."""
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.max_iter": 300, "ipopt.tol": 1e-7,
               "ipopt.bound_relax_factor": 0.0, "show_eval_warnings": False, "ipopt.mu_strategy": "adaptive",
               "error_on_fail": False, **more}  # fmt: skip
    try:
        return ca.nlpsol("step", "ipopt", problem, {**options, "expand": True})
    except RuntimeError:  # a table, or an iteration
        return ca.nlpsol("step", "ipopt", problem, options)


def held(J: np.ndarray) -> np.ndarray:
    """Which variables results depend on."""
    return np.any(J, axis=0)


def _over(problem: Any, g: np.ndarray) -> np.ndarray:
    """By how much constraints are broken: above 0 at their upper limit, below 0 at the lower one."""
    return np.maximum(g - problem.upper, 0.0) - np.maximum(problem.lower - g, 0.0)


def _learnt(J: np.ndarray, step: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Broyden's update, in the variables on which results depend."""
    s = np.where(held(J), step, 0.0)
    size = s @ s
    return J if size < 1e-16 else J + np.outer(change - J @ s, s) / size


class _Step:
    """The problem of a step: unknowns y, results over their sizes, and by how much each constraint is broken."""

    def __init__(self, problem: Any, penalty: float):
        self.problem, self.penalty = problem, penalty
        self.free = True  # whether variables that no result depends on may go anywhere
        self.prices = np.full(problem.lower.size, penalty)  # of limits, in the last step
        self.solved, self.reason = True, ""  # whether the problem of the last step was
        composition = problem.composition
        n, m, k = len(problem.space), composition.free.numel(), problem.lower.size
        y, r, s = (ca.MX.sym(name, size) for name, size in (("y", n), ("r", m), ("s", k)))
        J, rest, sizes = ca.MX.sym("J", m, n), ca.MX.sym("rest", m), ca.MX.sym("sizes", m)
        self.rounded = rounded(composition.function, ROUNDED)
        f, g = self.rounded(problem.offset + problem.scale * y, sizes * r)
        rows = [g - s, g + s, r - ca.mtimes(J, y)]
        asked = {
            "x": ca.vertcat(y, r, s), "p": ca.vertcat(ca.vec(J), rest, sizes),
            "f": f / problem.f_scale + penalty * ca.sum1(s), "g": ca.vertcat(*rows[:2], rows[2] - rest),
        }  # fmt: skip
        self.solvers = [_solver(asked), _solver(asked, **WATCHFUL)]  # the second where the first does not end

    def __call__(self, y: np.ndarray, r: np.ndarray, J: np.ndarray, region: float,
                 centre: np.ndarray | None = None, off: Any = 0.0) -> np.ndarray:  # fmt: skip
        """The best point within a region about a centre, of results r and slopes J at y; None: about y.

        off: what constraints have beyond those of the problem, in which kinks are rounded off.
        """
        problem, centre = self.problem, y if centre is None else centre
        k, m = problem.lower.size, r.size
        bound = held(J) | (not self.free)
        low = np.where(bound, np.maximum(problem.y_lower, centre - region), problem.y_lower)
        high = np.where(bound, np.minimum(problem.y_upper, centre + region), problem.y_upper)
        sizes = np.maximum(np.abs(r), np.abs(J).sum(axis=1) * region)
        sizes = np.where(sizes > 0, sizes, 1.0)
        scaled = J / sizes[:, None]
        g = np.ravel(problem.composition.function(problem.x(y), r)[1])
        given = {
            "x0": np.concatenate([y, r / sizes, np.abs(_over(problem, g))]),
            "p": np.concatenate([scaled.ravel(order="F"), r / sizes - scaled @ y, sizes]),
            "lbx": np.concatenate([low, np.full(m, -np.inf), np.zeros(k)]),
            "ubx": np.concatenate([high, np.full(m, np.inf), np.full(k, np.inf)]),
            "lbg": np.concatenate([np.full(k, -np.inf), problem.lower - off, np.zeros(m)]),
            "ubg": np.concatenate([problem.upper - off, np.full(k, np.inf), np.zeros(m)]),
        }  # fmt: skip
        tried = []
        for solver in self.solvers:
            found = solver(**given)
            stats = solver.stats()
            there = np.clip(np.ravel(found["x"])[: y.size], low, high)
            tried.append((self._value(there, r + J @ (there - y)), len(tried), there, np.ravel(found["lam_g"])))
            self.solved, self.reason = bool(stats["success"]), str(stats["return_status"])
            if self.solved:
                break
        _, _, there, multipliers = tried[-1] if self.solved else min(tried)
        self.prices = np.abs(multipliers[: 2 * k]).reshape(2, k).max(axis=0, initial=0.0)
        return np.asarray(there)

    def _value(self, y: np.ndarray, r: np.ndarray) -> float:
        """What becomes least."""
        f, g = self.problem.composition.function(self.problem.x(y), r)
        over = np.abs(_over(self.problem, np.ravel(g)))
        value = float(f) / self.problem.f_scale + self.penalty * float(over.sum())
        return value if np.isfinite(value) else np.inf
