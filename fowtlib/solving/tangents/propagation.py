"""The derivative of the fixed-step scheme, record by record of what the engine did.

A stage solves v = ode(x_f, z), 0 = alg(x_f, z) with x_f = xbar + k v and xbar = x + (alpha_f h - k) rate; see
fixed_step.c. With V and Z the derivatives of v and z, and o and a those of ode and alg by the parameters at fixed x, z,

    V - ode_x X_f - ode_z Z = o,   alg_x X_f + alg_z Z = -a,   X_f = Xbar + k V,

one linear system for all parameters, with the exact Jacobian at the stage; the derivatives of state and rate follow as
state and rate do. So the result is the derivative of what is computed, steps, samples and starts included, and not
an approximation of the derivative of the exact motion.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.language.native import Library, compiler, load_library
from fowtlib.solving.engines.reduction import Reduction
from fowtlib.solving.tangents.linearised import Entries, Linearised, Points
from fowtlib.solving.tangents.tape import Happening, Point, Record, Sample, Start, Stretch
from fowtlib.solving.timeline import Timeline

CHUNK = 400  # points at which the equations are differentiated at once
LARGE = 1e100  # size of a perturbation from which on it is counted in another unit


@dataclass
class Moved:
    """Derivatives at a point: of states, rates and discrete variables, a column for each parameter.

    One more column is a small perturbation of the states that no parameter drives: what becomes of it says whether
    the motion forgets where it came from. scale: logarithm of what it was divided by, so that it does not overflow.
    """

    x: np.ndarray
    rate: np.ndarray
    d: np.ndarray
    scale: float = 0.0


@dataclass(frozen=True, eq=False)
class Grid:
    """Derivatives at output points, of states (n, n_x, m) and of discrete variables (n, n_d, m).

    size: logarithm of the size of the perturbation (n,).
    """

    x: np.ndarray
    d: np.ndarray
    size: np.ndarray


class Propagation:
    """Takes derivatives along a tape."""

    def __init__(self, model: Linearised, reduced: Reduction, rho_inf: float, timeline: Timeline,
                 given: Sequence[np.ndarray]):  # fmt: skip
        self.model, self.dae, self.timeline, self.given = model, model.dae, timeline, given
        self.alpha_m, self.alpha_f = 0.5 * (3 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf)
        self.gamma = 0.5 + self.alpha_m - self.alpha_f
        self.reduced = reduced
        self.nx, self.nz = self.dae.x.numel(), self.dae.z.numel()
        self.outside = np.ones(self.nx)
        self.outside[reduced.inside] = 0.0
        self.nominal = np.array([state.nominal for state in self.dae.states])

    def along(self, tape: Sequence[Record], start: Moved, times: np.ndarray) -> Grid:
        """Derivatives at the output points of a run, by their times (n,)."""
        m, nd = start.x.shape[1] - 1, self.dae.d.numel()
        grid = Grid(np.zeros((len(times), self.nx, m)), np.zeros((len(times), nd, m)), np.zeros(len(times)))
        now, tiny = start, 1e-6 * (np.min(np.diff(times)) if len(times) > 1 else 1.0)
        self._put(grid, now, times, tape[0].point.t if isinstance(tape[0], Start) else times[0], tiny)
        for records in _chunks(tape):
            found = self._entries(records)
            before = None  # of what happens at one instant: derivatives of states, discrete variables and z ahead of it
            for record in records:
                if isinstance(record, Stretch):
                    self._stretch(record, next(found), now, grid, times, tiny)
                elif isinstance(record, Start):
                    self._begin(record, found, now, before)
                    self._put(grid, now, times, record.point.t, tiny)
                    before = None
                else:
                    here = next(found)
                    before = before or (now.x, now.d, self._at(here, now.x, now.d)[1])
                    self._jump(record, now, before[2])
        return grid

    # --- the equations at the points of the tape -----------------------------------------------------------------

    def _entries(self, records: Sequence[Record]) -> Iterator[Entries]:
        """Derivatives of the equations for each stretch and each point of the records, in order."""
        groups = list(_points_of(records))
        points = self.model.points(*(np.concatenate([group[i] for group in groups]) for i in range(4)))
        if self.reduced.steps:
            found = self._with_steps(points, np.concatenate([group[4] for group in groups]))
        else:
            found = self.model.entries("equations", self.model.equations, points)
        self._finite(found)
        return iter(found.split([len(group[0]) for group in groups]))

    def _with_steps(self, points: Points, length: np.ndarray) -> Entries:
        """The same where externals that solve steps of their own are told how far a stage reaches."""
        values = np.zeros((0, 0, 0))
        for h in np.unique(length):
            which = np.flatnonzero(length == h)
            p = self.model.at.parameters.copy()
            p[np.array(self.reduced.steps) - points.q.shape[1]] = self._reach(h)
            found = self.model.entries("equations", self.model.equations, points.part(which), p)
            values = values if values.size else np.zeros((len(length), *found.values.shape[1:]))
            values[which] = found.values
        return replace(found, values=values, points=points)

    def _reach(self, h: float) -> float:
        return self.alpha_f * self.gamma * h / self.alpha_m

    # --- steps ---------------------------------------------------------------------------------------------------

    def _stretch(self, record: Stretch, found: Entries, now: Moved, grid: Grid, times: np.ndarray,
                 tiny: float) -> None:  # fmt: skip
        steps = self._compiled if compiler() else self._interpreted
        rows = steps(record.stages[:, 1], record.each, found, now, record.stages[:, 0])
        for time, x in zip(record.times, rows, strict=True):
            self._put(grid, Moved(x, now.rate, now.d, now.scale), times, time, tiny)
        self._rescale(now)

    def _interpreted(self, h: np.ndarray, each: int, found: Entries, now: Moved, t: np.ndarray) -> list[np.ndarray]:
        """Derivatives of the states after every `each` steps."""
        nx, moving, rows = self.nx, self.model.moving, []
        by_x, by_z, by_d, by_p = found.blocks()
        k = self._reach(h)
        matrix = np.concatenate([-k[:, None, None] * by_x * self.outside, -by_z], axis=2)
        matrix[:, np.arange(nx), np.arange(nx)] += 1.0
        driven = by_p + by_d @ now.d[moving][:, :-1] if moving else by_p
        for i in range(len(h)):
            right = by_x[i] @ (now.x + (self.alpha_f * h[i] - k[i]) * now.rate)
            right[:, :-1] += driven[i]
            try:
                v = np.linalg.solve(matrix[i], right)[:nx]
            except np.linalg.LinAlgError:
                raise _singular(t[i]) from None
            change = (v - now.rate) / self.alpha_m
            now.x = now.x + h[i] * (now.rate + self.gamma * change)
            now.rate = now.rate + change
            if (i + 1) % each == 0:
                rows.append(now.x)
        return rows

    def _compiled(self, h: np.ndarray, each: int, found: Entries, now: Moved, t: np.ndarray) -> np.ndarray:
        """The same by tangent.c."""
        n, (nx, columns), steps = self.nx + self.nz, now.x.shape, len(h)
        now.x, now.rate = (np.array(values, order="C") for values in (now.x, now.rate))
        zero = np.zeros((len(found.by_p), 1))
        fixed = np.ascontiguousarray(np.vstack([now.d[self.model.moving], np.hstack([found.by_p, zero])]))
        dw = found.points.dw
        data = np.concatenate([dw, np.zeros((*dw.shape[:2], 1))], axis=2)
        out, work = np.empty((steps // each, nx, columns)), np.empty(n * n + n * columns + nx * columns)
        values = np.ascontiguousarray(found.values)
        constants = np.array([self.alpha_m, self.alpha_f, self.gamma])
        length = np.ascontiguousarray(h)
        bad = _runtime().tangent_steps(
            steps, each, nx, self.nz, columns, values.shape[2], len(found.row), found.row.ctypes.data,
            found.column.ctypes.data,
            values.ctypes.data, length.ctypes.data, self.outside.ctypes.data, constants.ctypes.data, len(fixed),
            fixed.ctypes.data, data.shape[1], data.ctypes.data, now.x.ctypes.data, now.rate.ctypes.data,
            out.ctypes.data, work.ctypes.data,
        )  # fmt: skip
        if bad >= 0:
            raise _singular(t[bad])
        return out

    def _finite(self, found: Entries) -> None:
        if np.isfinite(found.values).all():
            return
        i, row, column = (int(k) for k in np.argwhere(~np.isfinite(found.values))[0])
        dae = self.dae
        paths = [*(f"der({state.path})" for state in dae.states), *dae.residual_paths]
        moving = [dae.discretes[k] for k in self.model.moving]
        names = [item.path for item in (*dae.states, *dae.algebraics, *moving)]
        by = f" by {names[column]}" if column < len(names) else ""
        raise SimulationError(
            f"the derivative of {paths[row]}{by} is not a finite number at t = {found.points.t[i]:.6g} s: "
            "there is no sensitivity beyond. A root of zero has none, for instance; start beside it."
        )

    def _rescale(self, now: Moved) -> None:
        size = float(np.linalg.norm(now.x[:, -1] / self.nominal))
        if size > LARGE:
            now.x[:, -1] /= size
            now.rate[:, -1] /= size
            now.scale += np.log(size)

    def _put(self, grid: Grid, now: Moved, times: np.ndarray, t: float, tiny: float) -> None:
        """Keep the derivatives where an output point lies."""
        place = int(np.searchsorted(times, t - tiny))
        while place < len(times) and abs(times[place] - t) <= tiny:
            grid.x[place], grid.d[place] = now.x[:, :-1], now.d[:, :-1]
            size = float(np.linalg.norm(now.x[:, -1] / self.nominal))
            grid.size[place] = np.log(max(size, 1e-300)) + now.scale
            place += 1

    # --- starts, samples, events ---------------------------------------------------------------------------------

    def _at(self, found: Entries, x: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the rates that the equations give at a point, and of z there."""
        by_x, by_z, by_d, by_p = (block[0] for block in found.blocks())
        total = by_x @ x + by_d @ d[self.model.moving]
        total[:, :-1] += by_p
        z = np.linalg.solve(-by_z[self.nx :], total[self.nx :]) if self.nz else np.zeros((0, x.shape[1]))
        return total[: self.nx] + by_z[: self.nx] @ z, z

    def _begin(self, record: Start, found: Iterator[Entries], now: Moved,
               before: tuple[np.ndarray, np.ndarray, np.ndarray] | None) -> None:  # fmt: skip
        rate, _ = self._at(next(found), now.x, now.d)
        if record.before is not None:  # the rates keep what they differ by from the equations
            x, d = before[:2] if before else (now.x, now.d)
            rate = rate + now.rate - self._at(next(found), x, d)[0]
        now.rate = rate

    def _jump(self, record: Sample | Happening, now: Moved, z: np.ndarray) -> None:
        """What a sampled part or an event does to states and discrete variables; z: derivatives of z there."""
        point = record.point
        points = self.model.points(np.array([point.t]), point.x[None], point.z[None], point.q[None])

        def moved(name: str, rows: ca.SX) -> np.ndarray:
            by_x, by_z, by_d, by_p = (block[0] for block in self.model.slopes(name, rows, points))
            total = by_x @ now.x + by_z @ z + by_d @ now.d[self.model.moving]
            total[:, :-1] += by_p
            return total

        if isinstance(record, Sample):
            sample = self.dae.samples[record.number]
            now.d = now.d.copy()
            now.d[list(sample.targets)] = moved(f"sample {record.number}", sample.values)
            return
        planned = self.timeline.planned[record.number]
        offer, given = planned.offer, ca.SX(ca.DM(planned.given))
        rows = ca.vertcat(ca.vec(ca.densify(offer.state_values)), ca.vec(ca.densify(offer.discrete_values)))
        fixed = ca.substitute([rows], [offer.given], [given])[0] if planned.given.size else rows
        total = moved(f"event {planned.label} {planned.given.tobytes().hex()}", fixed)
        if planned.given.size:
            slope = ca.substitute([ca.jacobian(rows, offer.given)], [offer.given], [given])[0]
            function = self.model.functions.function("by_given", [ca.densify(slope)])
            by_given = np.array(self.model.at.call(function, point.t, point.x, point.z, point.q))
            total[:, :-1] += by_given @ self.given[record.number]
        count = len(offer.state_targets)
        now.x, now.d = now.x.copy(), now.d.copy()
        now.x[list(offer.state_targets)] = total[:count]
        now.d[list(offer.discrete_targets)] = total[count:]


@cache
def _runtime() -> Library:
    """The compiled steps, the same for all models."""
    text = (Path(__file__).parent / "tangent.c").read_text(encoding="utf-8")
    _, library = load_library(text, "tangent", optimization="-O3")
    function, pointer, integer = library.tangent_steps, c.c_void_p, c.c_int
    function.restype = integer
    function.argtypes = [*[integer] * 7, *[pointer] * 6, integer, pointer, integer, *[pointer] * 5]
    return library


def _singular(t: float) -> SimulationError:
    return SimulationError(f"the equations of a step are singular at t = {t:.6g} s: there is no sensitivity beyond.")


def _chunks(tape: Iterable[Record]) -> Iterator[list[Record]]:
    """Records in pieces of about so many points; what happens at an instant, and the start behind it, stay together."""
    kept: list[Record] = []
    points = 0
    for record in tape:
        for part in _divided(record) if isinstance(record, Stretch) else [record]:
            if points >= CHUNK and isinstance(part, Stretch):
                yield kept
                kept, points = [], 0
            kept.append(part)
            points += len(part.stages) if isinstance(part, Stretch) else 1
    if kept:
        yield kept


def _divided(record: Stretch) -> Iterator[Stretch]:
    """A stretch in pieces that end at output points."""
    most = max(1, CHUNK // record.each)
    for first in range(0, len(record.times), most):
        stages = record.stages[first * record.each : (first + most) * record.each]
        yield replace(record, stages=stages, times=record.times[first : first + most])


Rows = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _points_of(records: Iterable[Record]) -> Iterator[Rows]:
    """For each stretch, and each point of the other records: rows of t, x, z, q, and the length of the step, or 0."""
    for record in records:
        if isinstance(record, Stretch):
            nx, stages = record.states, record.stages
            rows = stages[:, 2 : 2 + nx], stages[:, 2 + nx :], np.tile(record.q, (len(stages), 1))
            yield stages[:, 0], *rows, stages[:, 1]
            continue
        yield _one(record.point)
        if isinstance(record, Start) and record.before is not None:
            yield _one(record.before)


def _one(point: Point) -> Rows:
    return np.array([point.t]), point.x[None], point.z[None], point.q[None], np.zeros(1)
