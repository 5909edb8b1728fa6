"""The fixed-step engine in NumPy, for computers without a C compiler: the scheme of fixed_step.c, with exact Jacobians.

It is also what the compiled engine is tested against.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.engines.reduction import reduction
from fowtlib.solving.failure import StepFailure, cut_steps, step_failure
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.initial import consistent_algebraics

NEWTON = 0.01  # of the tolerance
KEEP = 20  # steps over which a Newton matrix is kept
ITERATIONS = 12
HALVINGS = 3  # of a step that is not solved, as often as in fixed_step.c


class FixedStepTwin:
    """The contract of FixedStep, without compiled code."""

    def __init__(self, at: AtParameters, step: float, tolerance: float, rho_inf: float):
        self.at, self.dae, self.step = at, at.dae, step
        self.tolerance = NEWTON * tolerance
        self.alpha_m, self.alpha_f = 0.5 * (3 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf)
        self.gamma = 0.5 + self.alpha_m - self.alpha_f
        self.reduced = reduction(self.dae, stages=False)
        self.x_nominal = np.array([s.nominal for s in self.dae.states])
        self.z_scale = np.array([a.nominal for a in self.dae.algebraics])
        self.attributes = {"solver": "fixed", "step": step, "rho_inf": rho_inf, "tolerance": tolerance}
        self.advice = f"or take a shorter step (--step {500 * step:g}ms)"
        self.stands: tuple[float, np.ndarray, np.ndarray] | None = None
        self.inverse, self.made_for, self.age = np.zeros((0, 0)), 0.0, KEEP
        self.watch: Callable[[np.ndarray], None] | None = None
        self.seen = np.empty((0, 0))
        self.cuts: list[float] = []  # where steps began that had to be cut
        self.halvings = 0  # how often one of them was halved, at most
        self.stages: list[np.ndarray] = []  # of one call of `advance`, as FixedStep.watch is given them

    def algebraics(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Algebraic unknowns that satisfy the equations at the states; SimulationError where none are found."""
        return consistent_algebraics(self.at, t, x, z, q)

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes (see SampledUpdate.values), as a function of t, x, z, q."""
        return self.at.updater(sample)

    def advance(
        self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic unknowns (rows) at `points` equidistant times after t; StepFailure where it fails."""
        steps = max(1, int(np.ceil(length / points / self.step * (1 - 1e-9))))
        h = length / points / steps
        if not self._stands_at(t, x, q):
            self._start(t, x, z, q)
        rows, self.stages = [], []
        for p in range(points):
            for i in range(steps):
                self._step_or_halves(t + length * p / points + i * h, h)
            now = t + length * (p + 1) / points
            self.z = self._consistent(now, self.x, self._predict(now)[: z.size], q)
            self.stands = (now, self.x, q.copy())
            rows.append((self.x, self.z))
        if self.watch is not None:
            self.watch(np.array(self.stages))
        return np.array([row[0] for row in rows]), np.array([row[1] for row in rows]).reshape(points, z.size)

    def stop(self, now: bool) -> None:
        """Nothing to do: steps in Python are heard of a stop between them only."""

    def memory(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """All that the next step depends on, as a text and numbers."""
        text = {"engine": "twin", "made_for": self.made_for, "age": self.age, "stands": self.stands and self.stands[0]}
        text |= {"cuts": self.cuts, "halvings": self.halvings}
        numbers = {"inverse": self.inverse, "z_scale": self.z_scale}
        if self.stands is None:
            return text, numbers
        numbers |= {"stands_x": self.stands[1], "stands_q": self.stands[2], "rate": self.rate, "q": self.q}
        numbers |= {"x": self.x, "z": self.z, "past_t": np.array([t for t, _ in self.past])}
        numbers["size"] = getattr(self, "size", np.zeros(0))
        return text, numbers | {"past_u": np.array([u for _, u in self.past])}

    def remember(self, text: Mapping[str, Any], numbers: Mapping[str, np.ndarray]) -> None:
        """Take the memory of an engine with the same model and settings; ValueError where it is of another one."""
        if text["engine"] != "twin":
            raise ValueError("the memory of its solver is that of the compiled one")
        self.made_for, self.age, self.stands = text["made_for"], text["age"], None
        self.cuts, self.halvings = list(text["cuts"]), text["halvings"]
        self.inverse, self.z_scale = numbers["inverse"], numbers["z_scale"]
        if text["stands"] is not None:
            self.stands = (text["stands"], numbers["stands_x"], numbers["stands_q"])
            self.rate, self.q, self.x, self.z, self.size = (numbers[name] for name in ("rate", "q", "x", "z", "size"))
            self.past = [(float(t), u) for t, u in zip(numbers["past_t"], numbers["past_u"], strict=True)]

    def _stands_at(self, t: float, x: np.ndarray, q: np.ndarray) -> bool:
        if self.stands is None:
            return False
        then, states, given = self.stands
        return abs(t - then) <= 1e-9 * self.step and np.array_equal(x, states) and np.array_equal(q, given)

    def _consistent(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        try:
            z = consistent_algebraics(self.at, t, x, z, q)
        except SimulationError as error:
            self.stands = None
            raise StepFailure(str(error)) from None
        self.z_scale = np.maximum(self.z_scale, np.abs(z))
        return z

    def _start(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> None:
        lag = self._lag(t, x)
        self.q, self.x = q.copy(), x.copy()
        self.z = self._consistent(t, x, z, q)
        self.rate = np.array(self.at.residual(t, x, self.z, q)[0]).ravel() + lag
        if not np.all(np.isfinite(self.rate)):
            first = int(np.flatnonzero(~np.isfinite(self.rate))[0])
            raise StepFailure(step_failure(self.dae, [], t, z.size + first, True))
        self.past = [(t, np.concatenate([self.z, self.rate[self.reduced.free]]))]

    def _lag(self, t: float, x: np.ndarray) -> np.ndarray | float:
        """What the rates differ by from the equations; it belongs to the scheme, and stays where only q has jumped."""
        if self.stands is None or abs(t - self.stands[0]) > 1e-9 * self.step or not np.array_equal(x, self.stands[1]):
            return 0.0
        return self.rate - np.array(self.at.residual(t, x, self.z, self.q)[0]).ravel()

    def _predict(self, t: float) -> np.ndarray:
        """The straight line through the last two stages."""
        if len(self.past) < 2:
            return self.past[-1][1]
        (t0, u0), (t1, u1) = self.past
        return u1 + (t - t1) / (t1 - t0) * (u1 - u0)

    def _placed(self, xbar: np.ndarray, k: float, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rates of all states, and the states of the stage."""
        v, nz = np.empty_like(xbar), self.z.size
        v[self.reduced.free] = unknown[nz:]
        for state, source in zip(self.reduced.order, self.reduced.source, strict=True):
            v[state] = xbar[source] + k * v[source] if source >= 0 else unknown[-1 - source]
        return v, xbar + k * v

    def _matrix(self, t: float, x: np.ndarray, z: np.ndarray, k: float) -> np.ndarray:
        """The slopes of (alg, v - ode of the free rates) by (z, free rates)."""
        blocks = self.at.jacobian(t, x, z, self.q)
        ode_x, ode_z, alg_x, alg_z = (np.array(block.full()) for block in blocks)
        nz, free = z.size, self.reduced.free
        v = np.zeros((x.size, nz + len(free)))
        v[free, nz + np.arange(len(free))] = 1.0
        for state, source in zip(self.reduced.order, self.reduced.source, strict=True):
            v[state] = k * v[source] if source >= 0 else np.arange(v.shape[1]) == -1 - source
        matrix = np.vstack([k * alg_x @ v, v[free] - k * ode_x[free] @ v])
        matrix[:nz, :nz] += alg_z
        matrix[nz:, :nz] -= ode_z[free]
        return matrix

    def _step_or_halves(self, t: float, h: float, halvings: int = 0) -> None:
        """A step, and where it is not solved its halves, as in fixed_step.c."""
        try:
            self._step(t, h)
        except StepFailure:
            if halvings == HALVINGS:
                self.stands = None
                raise
        else:
            return
        self.halvings = max(self.halvings, halvings + 1)
        self._step_or_halves(t, 0.5 * h, halvings + 1)
        self._step_or_halves(t + 0.5 * h, 0.5 * h, halvings + 1)
        if halvings == 0 and not (self.cuts and t <= self.cuts[-1]):
            self.cuts.append(t)

    def remarks(self) -> list[str]:
        """Sentences on steps that had to be cut so far; none where there were none."""
        cuts = self.cuts
        return [cut_steps(len(cuts), cuts[0], cuts[-1], 2**self.halvings, self.advice)] if cuts else []

    def _step(self, t: float, h: float) -> None:
        k = self.alpha_f * self.gamma * h / self.alpha_m
        stage = t + self.alpha_f * h
        xbar = self.x + (self.alpha_f * h - k) * self.rate
        if self.age >= KEEP or abs(k - self.made_for) > 0.2 * self.made_for:
            self.inverse = np.zeros((0, 0))
        for fresh in ([] if not self.inverse.size else [False]) + [True]:
            unknown = self._iterate(stage, k, xbar, fresh)
            if unknown is not None:
                break
        else:
            self.age = KEEP
            raise StepFailure(step_failure(self.dae, self.reduced.free, *self.blamed))
        v, x = self._placed(xbar, k, unknown)
        self.stages.append(np.concatenate([[stage, h], x, unknown[: self.z.size]]))
        change = (v - self.rate) / self.alpha_m
        self.x = self.x + h * (self.rate + self.gamma * change)
        self.rate = self.rate + change
        self.age += 1
        self.z_scale = np.maximum(self.z_scale, np.abs(unknown[: self.z.size]))
        self.past = [*self.past[-1:], (stage, unknown)]

    def _iterate(self, t: float, k: float, xbar: np.ndarray, fresh: bool) -> np.ndarray | None:
        """Unknowns of a stage by Newton's method, new matrices with `fresh`; none where it does not converge."""
        nz, unknown, before = self.z.size, self._predict(t), np.inf
        weight = self._weight(k)
        for _ in range(ITERATIONS):
            v, x = self._placed(xbar, k, unknown)
            ode, alg = (np.array(part).ravel() for part in self.at.residual(t, x, unknown[:nz], self.q))
            residual = np.concatenate([alg, v[self.reduced.free] - ode[self.reduced.free]])
            bad = np.flatnonzero(~np.isfinite(residual))
            if len(bad):
                self.blamed = (t, int(bad[0]), True)
                return None
            if fresh:
                matrix = self._matrix(t, x, unknown[:nz], k)
                try:
                    self.inverse, self.made_for, self.age = np.linalg.inv(matrix), k, 0
                except np.linalg.LinAlgError:
                    self.inverse = np.zeros((0, 0))
                    self.blamed = (t, int(np.argmax(np.abs(residual))), False)
                    return None
                self.size = np.abs(matrix) @ (1 / weight)
            move = self.inverse @ residual
            unknown = unknown - move
            now = float(np.max(np.abs(move) * weight, initial=0.0))
            if now <= self.tolerance:
                return unknown
            self.blamed = (t, int(np.argmax(np.abs(residual) / self.size)), False)
            if now > (0.5 if not fresh else 2.0) * before:
                return None
            before = now
        return None

    def _weight(self, k: float) -> np.ndarray:
        """1 / scale of the unknowns: a rate counts by what it moves its state."""
        states = k / np.maximum(np.abs(self.x), self.x_nominal)
        weight = np.zeros(self.z.size)
        for state, source in zip(self.reduced.order, self.reduced.source, strict=True):
            if source < 0:
                weight[-1 - source] = max(weight[-1 - source], states[state])
        return np.concatenate([np.where(weight > 0, weight, 1 / self.z_scale), states[self.reduced.free]])
