"""Expected values and slopes of nonlinear rows at a Gaussian state: what equivalent linearisation puts in their place.

The linear function nearest in the mean square to f(v), v Gaussian with mean m, is E[f] + E[df/dv] (v - m), since
Cov(f, v) = E[df/dv] Cov(v) (R. C. Booton, IRE Trans. Circuit Theory 1 (1954) 9; I. E. Kazakov, 1954; J. B. Roberts and
P. D. Spanos, Random Vibration and Statistical Linearization, 1990, chapters 5 and 6). The expectations are means over
points that fill the Gaussian evenly, in pairs about its centre.

Laws of states alone with corners (frequency.corners) are cheap, and are averaged over many more points than the rest.
A state that follows its law within a fraction of a second, as an actuator with a lower limit does, is far from Gaussian
beside that limit. So at each point it stands where its own rate vanishes, a function g of the other states, and the
linear function of a row f(v, g(v)) is E[df/dg] (g - E[g]) and what is left of its slopes by the others.

So do algebraic unknowns, as the shapes of lines, stand where their own equations vanish, h(v) at each point: the linear
function of a row f(v, h(v)) is E[df/dh] (h - E[h]) and what is left by the others, and h is E[h] + E[dh/dv] (v - m).
Where that is not found, as for a line beyond its length, they stand where the linear model has them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import numpy as np
from scipy.special import ndtri

from fowtlib.frequency.corners import Laws, laws_of
from fowtlib.frequency.quadratic_rows import Points, QuadraticRows, added, forms_of
from fowtlib.solving.arrays import Arrays
from fowtlib.solving.disturbed import DisturbedRows

POINTS, BLOCK, BLOCKS = 512, 512, 8  # of all rows; of laws at once, and how often
FAST = 5.0  # 1/s; a state whose law pulls it back faster than that follows it, where no limit of its rate holds it,
ALIKE = 3.0  # and wherever it is, much alike: an integral beside its limit is not
HELD = 1e-3  # of its pace: what pulls less is held
AWAY, LITTLE, ALMOST = 6.0, 1e-3, 0.98  # how far: deviations of a state, or this of its size; at so many points
SETTLING, SETTLED = 400, 1e-7  # iterations of those that follow, and the last change over what they deviate by
ALONG = 0.9  # of the step before, from which the next is twice as long
NEWTON, SOLVED, SHRUNK = 12, 1e-6, 0.2  # steps at most for unknowns, the last one over their size, and over the former
FULL = 3  # points for each number, from which products of two are exact too
STILL = 1e-12  # SI; a deviation that is rounding alone, of which nothing is told
ROUNDING = 1e-8  # of a variance, added: dependent inputs have no root otherwise


@dataclass(frozen=True, eq=False)
class Expected:
    """Expected rows (m,), and slopes by states, unknowns and signals; mean: of the states, with those that follow.

    unknowns: the mean of these, at which their own rows vanish.

    quadratic: what the rows are of second order, by the Gaussian [states; signals]; None where that was not asked for.
    """

    values: np.ndarray
    by_x: np.ndarray
    by_z: np.ndarray
    by_signals: np.ndarray
    mean: np.ndarray
    unknowns: np.ndarray
    quadratic: QuadraticRows | None = None


@dataclass(frozen=True, eq=False)
class Gaussian:
    """Covariance of some states (numbers of the flat model) and of signals: of [states; signals]."""

    states: Sequence[int]
    covariance: np.ndarray
    signals: int


class Expectations:
    """Of the rows [ode; alg; outputs] of a compiled model; quadratic: with what they are of second order."""

    def __init__(self, plant: Any, at: Any, disturbed: DisturbedRows, quadratic: bool = False):
        self.at, self.disturbed, self.laws, self.quadratic = at, disturbed, LawExpectations(plant, at), quadratic

    def __call__(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray, means: np.ndarray, law: Gaussian,
                 slopes: tuple[np.ndarray, ...] | None) -> Expected:  # fmt: skip
        """At a mean, of all that is Gaussian; means: of quadratic laws; slopes: of the rows, by which unknowns move."""
        whole = np.concatenate([q, self.at.parameters, np.zeros(law.signals), means])
        if slopes is None:
            slopes = tuple(self.disturbed.slopes(t, x, z, whole))
        nx, nz = x.size, z.size
        laws = self.laws(t, x, q, law)
        first = laws.inputs
        rest = [k for k in range(len(law.covariance)) if k not in first and k not in laws.followers_at]
        points = _points(law.covariance, [*first, *rest], POINTS)
        drawn = points.deviations
        dx, ds = np.zeros((POINTS, nx)), drawn[:, len(law.states) :]
        dx[:, list(law.states)] = drawn[:, : len(law.states)]
        moved = x + dx
        by_others = laws.settle(moved) if laws.followers else np.zeros((POINTS, 0, nx))
        line = dx.copy()
        line[:, laws.followers] = dx @ laws.slopes.T
        kept = []
        alg = slice(nx, nx + nz)
        dz = line @ slopes[0][alg].T + ds @ slopes[2][alg].T
        dz = -np.linalg.solve(slopes[1][alg], dz.T).T if nz else np.zeros((POINTS, 0))
        sums = _Sums(self.disturbed.slopes, alg, laws.followers)
        for k in range(POINTS):
            whole[q.size + self.at.parameters.size :][: law.signals] = ds[k]
            at, found = self._settled(t, moved[k], z + dz[k], whole, sums)
            sums.add(self.disturbed.values.entries(t, moved[k], at, whole)[0], found, at, by_others[k])
            if self.quadratic:
                kept.append(np.concatenate(found))
        values, by_x, by_z, by_s, unknowns = sums.means(POINTS, laws.slopes)
        mean = x.copy()
        mean[laws.followers] = laws.means
        for number, value, row in laws.rows:
            values[number], by_x[number], by_z[number], by_s[number] = value, row, 0.0, 0.0
        quadratic = None
        if self.quadratic:
            quadratic = self._of_second_order(points, np.array(kept), law, laws, moved, by_others, slopes)
        return Expected(values, by_x, by_z, by_s, mean, unknowns, quadratic)

    def _settled(self, t: float, x: np.ndarray, z: np.ndarray, whole: np.ndarray,
                 sums: _Sums) -> tuple[np.ndarray, list[np.ndarray]]:  # fmt: skip
        """Unknowns where their rows vanish, by Newton's method from a guess, and the entries of all slopes there."""
        rows, slopes = self.disturbed.values, self.disturbed.slopes
        first = slopes.entries(t, x, z, whole)
        at, last, by_z = z, np.inf, _dense(slopes, 1, first[1])[sums.alg]
        for _ in range(NEWTON if z.size else 0):
            try:
                step = np.linalg.solve(by_z, rows.entries(t, x, at, whole)[0][sums.alg])
                at = at - step
                size = float(np.max(np.abs(step) / (1 + np.abs(at))))
                if size <= SOLVED:
                    return at, slopes.entries(t, x, at, whole)
                if not size < SHRUNK * last:  # slopes are too old, or nothing is near
                    by_z = _dense(slopes, 1, slopes.entries(t, x, at, whole)[1])[sums.alg]
                last = size
            except (RuntimeError, np.linalg.LinAlgError):
                break
        return z, first

    def _of_second_order(self, points: Points, entries: np.ndarray, law: Gaussian, laws: SettledLaws, moved: np.ndarray,
                         by_others: np.ndarray, slopes: tuple[np.ndarray, ...]) -> QuadraticRows:  # fmt: skip
        """From all slopes at all points; a state that follows its law is what that law is not of second order."""
        nx, count = moved.shape[1], points.u.shape[1]
        x_by_u, s_by_u = np.zeros((nx, count)), points.lift[len(law.states) :]
        x_by_u[list(law.states)] = points.lift[: len(law.states)]
        line = x_by_u.copy()
        line[laws.followers] = laws.slopes @ x_by_u
        alg = slice(nx, nx + slopes[1].shape[1])
        z_by_u = -np.linalg.solve(slopes[1][alg], slopes[0][alg] @ line + slopes[2][alg] @ s_by_u)
        places = self.disturbed.slopes.places
        rows = np.concatenate([rows for rows, _, _ in places])
        first = np.cumsum([0, nx, len(z_by_u)])
        columns = np.concatenate([columns + at for (_, columns, _), at in zip(places, first, strict=True)])
        forms, sizes = forms_of(points, rows, columns, entries, np.vstack([x_by_u, z_by_u, s_by_u]))
        for k, number in enumerate(laws.followers):
            of_u = by_others[:, k] @ x_by_u
            for entry in np.flatnonzero(columns == number):
                off = entries[:, entry] - entries[:, entry].mean()
                if np.any(np.abs(off) > 1e-12 * np.abs(entries[:, entry]).max()):
                    added(forms, int(rows[entry]), points.by(off[:, None] * of_u))
        own, own_sizes = laws.forms(points, moved, by_others, x_by_u)
        return QuadraticRows.of(points, forms | own, sizes | own_sizes)


class LawExpectations:
    """Of the laws of a compiled model that have corners and follow from states alone."""

    def __init__(self, plant: Any, at: Any):
        self.at, self.laws = at, laws_of(plant, at)
        self._paces: dict[int, float] = {}  # of those that follow: once they do, they do in all that comes
        self._function: LawFunctions | None = None
        if self.laws.numbers:
            make = partial(LawFunctions, plant.dae, at, self.laws)
            self._function = plant.functions.once("laws with slopes", make)

    def __call__(self, t: float, x: np.ndarray, q: np.ndarray, law: Gaussian) -> SettledLaws:
        """At a Gaussian state."""
        return SettledLaws(self._function, self.laws, t, x, self.at.whole(q), law, self._paces)

    def tangents(self, t: float, x: np.ndarray, q: np.ndarray) -> dict[int, np.ndarray]:
        """Slopes (states,) of each law at states, by its number."""
        if self._function is None:
            return {}
        moving, others = list(self.laws.moving), np.concatenate([[t], self.at.whole(q)])[list(self.laws.held)]
        by = self._function.slopes(np.tile(x[moving], (BLOCK, 1)), others)[1][0]
        found = {number: np.zeros(x.size) for number in self.laws.numbers}
        for j, number in enumerate(self.laws.numbers):
            found[number][moving] = by[j]
        return found


class SettledLaws:
    """The laws of states alone at a Gaussian state.

    inputs: numbers of what they follow from, within the Gaussian; followers: numbers of the states that follow, and
    followers_at: their places in the Gaussian; pace (k,) [1/s], means (k,) and slopes (k, states) of these; rows: of
    each law its number, its value and its slopes.
    """

    def __init__(self, function: LawFunctions | None, laws: Laws, t: float, x: np.ndarray, q: np.ndarray, law: Gaussian,
                 paces: dict[int, float]):  # fmt: skip
        self.function, self.moving = function, list(laws.moving)
        self.others = np.concatenate([[t], q])[list(laws.held)]
        self.numbers, self.size = list(laws.numbers), x.size
        self.inputs: list[int] = []
        self.followers: list[int] = []
        self.followers_at: list[int] = []
        self.pace, self.means, self.slopes, self.rows = np.zeros(0), np.zeros(0), np.zeros((0, x.size)), []
        place = {number: k for k, number in enumerate(law.states)}
        if function is None or not set(self.moving) <= set(place):
            return
        points = BLOCK * BLOCKS
        whole = [place[k] for k in self.moving]
        spread = x + _spread(law.covariance, law.states, x.size)
        own = self._slopes(spread)[1]
        for j, n in enumerate(self.numbers):
            if not paces.get(n) and n in self.moving and self._pulled(j, spread, x):
                paces[n] = _pace(own[:, j, self.moving.index(n)])
        self.followers = [n for n in self.numbers if paces.get(n, 0.0) > 0]
        self.pace = np.array([paces[n] for n in self.followers])
        self.followers_at = [place[n] for n in self.followers]
        self.inputs = [k for k in whole if k not in self.followers_at]
        moved = np.tile(x, (points, 1))
        moved[:, list(law.states)] += _points(law.covariance, self.inputs, points).deviations[:, : len(law.states)]
        by_others = self.settle(moved)
        self.means, self.slopes = moved[:, self.followers].mean(axis=0), by_others.mean(axis=0)
        values, slopes = self._slopes(moved)
        for j, number in enumerate(self.numbers):
            row = np.zeros(x.size)
            if number in self.followers:
                k = self.followers.index(number)
                row[:] = self.pace[k] * self.slopes[k]
                row[number] -= self.pace[k]
                self.rows.append((number, 0.0, row))
                continue
            row[self.moving] = slopes[:, j].mean(axis=0)
            by = slopes[:, j][:, [self.moving.index(n) for n in self.followers]]
            row += (by[:, :, None] * by_others).sum(axis=(0, 1)) / points - row[self.followers] @ self.slopes
            self.rows.append((number, float(values[:, j].mean()), row))

    def forms(self, points: Points, x: np.ndarray, by_others: np.ndarray,
              x_by_u: np.ndarray) -> tuple[dict[int, np.ndarray], dict[int, float]]:  # fmt: skip
        """Of second order by u, and sizes: see quadratic_rows; x (n, states): points with settled followers."""
        forms: dict[int, np.ndarray] = {}
        sizes: dict[int, float] = {}
        if not self.rows:
            return forms, sizes
        slopes = self._slopes(x)[1]
        followers = [self.moving.index(n) for n in self.followers]
        for j, number in enumerate(self.numbers):
            if number in self.followers:
                k = self.followers.index(number)
                by_u = self.pace[k] * by_others[:, k] @ x_by_u
            else:
                by = slopes[:, j, followers]
                by_u = slopes[:, j] @ x_by_u[self.moving]
                by_u += ((by - by.mean(axis=0))[:, :, None] * (by_others @ x_by_u)).sum(axis=1)
            forms[number], sizes[number] = points.by(by_u), float(np.linalg.norm(by_u.mean(axis=0)))
        return forms, sizes

    def _pulled(self, law: int, spread: np.ndarray, mean: np.ndarray) -> bool:
        """Whether a law pulls its state back from far on both sides, wherever the other states are."""
        number, rates = self.numbers[law], []
        far = max(AWAY * float(np.std(spread[:, number])), LITTLE * (1 + abs(mean[number])))
        for side in (-far, far):
            moved = spread.copy()
            moved[:, number] = mean[number] + side
            rates.append(self._values(moved)[:, law])
        return bool(min(np.mean(rates[0] >= 0), np.mean(rates[1] <= 0)) > ALMOST)

    def settle(self, x: np.ndarray) -> np.ndarray:
        """Move the states that follow to where their rates vanish, at points x (n, states).

        Returns their slopes (n, k, states).
        """
        at = [self.numbers.index(n) for n in self.followers]
        longer, last = np.ones((len(x), len(at))), np.zeros((len(x), len(at)))
        most = np.full_like(longer, np.inf)
        for _ in range(SETTLING if self.followers else 0):
            step = self._values(x)[:, at] / self.pace
            along, over = (step * last > 0) & (np.abs(step) > ALONG * np.abs(last)), step * last < 0
            longer[along] *= 2  # a limit of its rate holds it
            most[over] = longer[over] / 2
            longer[over] /= 8
            longer = np.maximum(np.minimum(longer, most), 1.0)
            x[:, self.followers] += longer * step
            last = step
            if np.max(np.abs(step)) < SETTLED * (1e-12 + np.max(np.std(x[:, self.followers], axis=0))):
                break
        slopes = self._slopes(x)[1][:, at]
        found = np.zeros((len(x), len(at), self.size))
        if not at:
            return found
        own = slopes[:, :, [self.moving.index(n) for n in self.followers]]
        held = np.abs(np.diagonal(own, axis1=1, axis2=2)) < HELD * self.pace  # by the limit of a rate
        for k, pace in enumerate(self.pace):
            own[held[:, k], k, k] = -pace
        found[:, :, self.moving] = -np.linalg.solve(own, slopes)
        found[:, :, self.followers] = 0.0
        return found

    def _values(self, x: np.ndarray) -> np.ndarray:
        """Laws (n, laws)."""
        return self.function.values(x[:, self.moving], self.others)

    def _slopes(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Laws (n, laws) and their slopes (n, laws, moving)."""
        return self.function.slopes(x[:, self.moving], self.others)


def _pace(own: np.ndarray) -> float:
    """How fast a law pulls its state back [1/s], from its slopes by that (n,); 0: it is none that follows."""
    pulls = -own[np.abs(own) > 1e-9]
    slowest, fastest = np.percentile(pulls, [5, 95]) if pulls.size else (0.0, 0.0)
    return float(fastest) if slowest > FAST and fastest < ALIKE * slowest else 0.0


class LawFunctions:
    """The laws, and their slopes, of the states that they name (n, moving) and of the rest of [t; q], BLOCK at once."""

    def __init__(self, dae: Any, at: Any, laws: Laws):
        rows, x = ca.densify(dae.ode[list(laws.numbers)]), dae.x[list(laws.moving)]
        others = ca.vertcat(at.general.t, at.general.q)[list(laws.held)]
        slopes = ca.densify(ca.jacobian(rows, x))
        self.shape = slopes.shape
        self._values, self._slopes = (
            Arrays(ca.Function("laws", [x, others], found).map("laws_at_points", "serial", BLOCK, [1], []))
            for found in ([rows], [rows, slopes])
        )

    def values(self, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Laws (n, laws), n a multiple of BLOCK."""
        blocks = (self._values.entries(block, others)[0] for block in np.split(x, len(x) // BLOCK))
        return np.concatenate(list(blocks)).reshape(len(x), -1)

    def slopes(self, x: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Laws (n, laws) and their slopes (n, laws, moving)."""
        found = [self._slopes.entries(block, others) for block in np.split(x, len(x) // BLOCK)]
        values, slopes = (np.concatenate(part) for part in zip(*found, strict=True))
        return values.reshape(len(x), -1), slopes.reshape(len(x), *self.shape[::-1]).transpose(0, 2, 1)


def _points(covariance: np.ndarray, order: Sequence[int], count: int) -> Points:
    """Gaussian points of this covariance (n, n), in pairs; the first of the order are spread most evenly."""
    s = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    order = [k for k in order if s[k] > 0]
    lift, whitening = np.zeros((len(covariance), len(order))), np.zeros((len(order), len(covariance)))
    if not order:
        return Points(np.zeros((count, 0)), lift, whitening)
    scaled = covariance[np.ix_(order, order)] / np.outer(s[order], s[order])
    still = s[order] < STILL  # by rounding alone, and so is what it goes with
    scaled[still], scaled[:, still], scaled[still, still] = 0.0, 0.0, 1.0
    root = _root(scaled)
    lift[order] = s[order, None] * root
    whitening[:, order] = np.linalg.inv(root) / s[order]
    whitening[still] = 0.0
    drawn = _normal(count // 2, len(order))
    return Points(np.vstack([drawn, -drawn]), lift, whitening)


def _normal(count: int, size: int) -> np.ndarray:
    """Independent normal numbers (count, size) of a sequence of Sobol, the same each time.

    Their squares have a mean of exactly one, and products of two of zero where there are many more points than numbers:
    so expected products are those of the covariance, and hang on no tail.
    """
    from scipy.stats import qmc

    drawn = ndtri(qmc.Sobol(size, scramble=True, seed=1).random(count))
    if size * FULL > count:
        return drawn / np.sqrt(np.mean(drawn**2, axis=0))
    return drawn @ np.linalg.inv(np.linalg.cholesky(drawn.T @ drawn / count)).T


def _root(correlation: np.ndarray) -> np.ndarray:
    """Lower triangular root; what is dependent gets as little more as it takes."""
    added, one = ROUNDING, np.eye(len(correlation))
    while True:
        try:
            return np.linalg.cholesky((correlation + correlation.T) / 2 + added * one)
        except np.linalg.LinAlgError:
            added *= 10


def _spread(covariance: np.ndarray, states: Sequence[int], size: int) -> np.ndarray:
    """Deviations of the states (BLOCK, size), independent, to see how fast laws may be."""
    found = np.zeros((BLOCK, size))
    s = np.sqrt(np.maximum(np.diag(covariance), 0.0))[: len(states)]
    found[:, list(states)] = _normal(BLOCK, len(states)) * s
    return found


class _Sums:
    """Over points: values of rows, their slopes with unknowns as functions of the rest, and these functions.

    alg: the rows of the unknowns. followers: numbers of states that follow their law; see SettledLaws.
    """

    def __init__(self, function: Arrays, alg: slice, followers: Sequence[int]):
        self.function, self.alg, self.followers, self.count = function, alg, list(followers), 0
        self.sums: list[np.ndarray] = []

    def add(self, values: np.ndarray, entries: list[np.ndarray], z: np.ndarray, by_others: np.ndarray) -> None:
        """A point, with entries of the slopes, its unknowns, and slopes (k, states) of the followers."""
        f_x, f_z, f_s = (_dense(self.function, k, of) for k, of in enumerate(entries))
        h = -np.linalg.solve(f_z[self.alg], np.hstack([f_x, f_s])[self.alg]) if z.size else np.zeros((0, f_x.shape[1]
                                                                                                  + f_s.shape[1]))
        n = f_x.shape[1]
        whole, h_x = f_x + f_z @ h[:, :n], h[:, :n]
        parts = [values, whole, f_z, f_s + f_z @ h[:, n:], h_x, h[:, n:], z,
                 whole[:, self.followers] @ by_others, h_x[:, self.followers] @ by_others]  # fmt: skip
        self.sums = [a + b for a, b in zip(self.sums, parts, strict=True)] if self.sums else parts

    def means(self, count: int, slopes: np.ndarray) -> tuple[np.ndarray, ...]:
        """Values, slopes by states, unknowns and signals, and unknowns; slopes (k, states): means of the followers'."""
        values, whole, f_z, f_s, h_x, h_s, z, through, h_through = (total / count for total in self.sums)
        whole = whole + through - whole[:, self.followers] @ slopes
        h_x = h_x + h_through - h_x[:, self.followers] @ slopes
        by_x, by_s = whole - f_z @ h_x, f_s - f_z @ h_s
        values[self.alg] = 0.0
        return values, by_x, f_z, by_s, z


def _dense(function: Arrays, number: int, entries: np.ndarray) -> np.ndarray:
    rows, columns, shape = function.places[number]
    matrix = np.zeros(shape)
    matrix[rows, columns] = entries
    return matrix
