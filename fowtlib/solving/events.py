"""Events of a run: when the indicator of a state event waits, where it crosses zero, and what an event does.

They are counted through: first the `when` of the model, then all events of the timeline of the run, of which those that
wait for a condition have an indicator too.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from fowtlib.flattening.flat_dae import Event, Offer
from fowtlib.language.errors import SimulationError
from fowtlib.solving import event_rules as rules
from fowtlib.solving.engines import Engine
from fowtlib.solving.initial import consistent_algebraics
from fowtlib.solving.timeline import Timeline


class Moving(Protocol):
    """What is asked of a run: its point t, x, z, d, with q = [u; d], and its way on from there; step [s]: of output."""

    engine: Engine
    timeline: Timeline
    t: float
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    step: float

    @property
    def q(self) -> np.ndarray:
        """Inputs and discrete variables."""

    def advance(self, length: float, points: int) -> tuple[np.ndarray, np.ndarray]:
        """Rows of x and z at equidistant points behind the present one; fewer rows where the engine fails."""

    def failure(self) -> SimulationError:
        """Why it fails."""


class StateEvents:
    """The events of one run; each indicator is armed where it waits to fall below zero."""

    def __init__(self, run: Moving):
        self.run, self.at = run, run.engine.at
        self.last_event: dict[int, float] = {}
        self.returns: dict[int, int] = {}
        self.just_fired: set[int] = set()
        self.last_act = -np.inf
        self.own = len(self.at.dae.events)
        self.numbers = [*range(self.own), *(self.own + k for k in run.timeline.waiting)]  # of the indicators
        self.armed = np.zeros(len(self.numbers), bool)

    @property
    def watching(self) -> bool:
        """Whether there is a condition that may become true."""
        return self.own > 0 or any(not self.run.timeline.planned[k].done for k in self.run.timeline.waiting)

    def _indicators(self, t: float, x: np.ndarray, z: np.ndarray) -> np.ndarray:
        q = self.run.q
        own = np.array(self.at.call(self.at.functions.indicators, t, x, z, q)).ravel() if self.own else np.zeros(0)
        more = self.run.timeline.indicators(self.at, np.array([t]), x[None], z[None], q[None])[0]
        return np.concatenate([own, more]) if more.size else own

    def _indicator_values(self) -> np.ndarray:
        return self._indicators(self.run.t, self.run.x, self.run.z)

    def first_crossing(self, times: np.ndarray, x: np.ndarray, z: np.ndarray) -> int | None:
        """First point at which an armed indicator is not positive any more."""
        if not len(times):
            return None
        q = np.repeat(self.run.q[None], len(times), axis=0)
        values = self.run.timeline.indicators(self.at, times, x, z, q)
        if self.own:
            values = np.hstack([self.at.along(self.at.functions.indicators, times, x, z, q), values])
        for k in range(len(times)):
            if np.any(self.armed & (values[k] <= 0)):
                return k
            self.armed = values[k] > 0
        return None

    def carry_out(self, times: np.ndarray, x: np.ndarray, z: np.ndarray, k: int) -> None:
        """Find the event inside the interval that ends at point k, and carry out its actions."""
        length = times[k] - (times[k - 1] if k else self.run.t)
        if k:
            self.run.t, self.run.x, self.run.z = float(times[k - 1]), x[k - 1].copy(), z[k - 1].copy()
        after = self._indicators(times[k], x[k], z[k])
        candidates = np.flatnonzero(self.armed & (after <= 0))

        def state_at(h: float) -> tuple[np.ndarray, np.ndarray]:
            if h <= 0:
                return self.run.x, self.run.z
            xs, zs = self.run.advance(h, 1)
            if not len(xs):
                raise self.run.failure()
            return xs[0], zs[0]

        def indicator(h: float, i: int) -> float:
            xs, zs = state_at(h)
            return float(self._indicators(self.run.t + h, xs, zs)[i])

        instants = {int(i): self._instant(int(i), indicator, length) for i in candidates}
        first = min(instants.values())
        self.run.x, self.run.z = (values.copy() for values in state_at(first))
        self.run.t += first
        due = {i for i, h in instants.items() if h <= first * (1 + rules.TOGETHER)}
        self._act(due)

    def _instant(self, i: int, indicator: Callable[[float, int], float], length: float) -> float:
        """Time from now until indicator i is not positive any more: the first point behind its root."""
        from scipy.optimize import brentq

        low = 0.0
        if indicator(low, i) <= 0:  # it was zero at the last event and has risen since
            shorter = (length * 0.5**k for k in range(1, rules.HALVINGS))
            low = next((h for h in shorter if indicator(h, i) > 0), 0.0)
            if not low and self.last_event.get(i) == self.run.t:
                raise self._chatter(i)
            if not low:
                return 0.0
        if indicator(length, i) > 0:  # it crosses so close to the end that integrating anew decides otherwise
            return length
        accuracy = rules.INSTANT * max(1.0, self.run.t)
        root = float(brentq(indicator, low, length, args=(i,), xtol=accuracy, rtol=1e-14))
        while root < length and indicator(root, i) > 0:
            root, accuracy = min(root + accuracy, length), 2 * accuracy
        return root

    def arm(self) -> None:
        """An indicator waits for its event where it is positive or zero; one that has just had it, where it rises."""
        if not self.numbers:
            return
        now = self._indicator_values()
        self.armed = now >= 0
        fired = list(self.just_fired) if self.last_act == self.run.t else []
        self.armed[fired] = now[fired] > 0
        if np.all(self.armed):
            return
        h = rules.AHEAD * self.run.step / rules.SUBSTEPS
        x = self.run.x + h * np.array(self.at.residual(self.run.t, self.run.x, self.run.z, self.run.q)[0]).ravel()
        try:
            z = consistent_algebraics(self.at, self.run.t + h, x, self.run.z, self.run.q)
        except SimulationError:
            return
        then = self._indicators(self.run.t + h, x, z)
        self.armed |= (then > 0) & (then > now)

    def _count(self, due: set[int]) -> None:
        """Count the events; stop where one returns again and again without time going on."""
        for i in due:
            soon = self.run.t - self.last_event.get(i, -np.inf) < rules.AT_ONCE * self.run.step / rules.SUBSTEPS
            self.returns[i] = self.returns.get(i, 0) + 1 if soon else 0
            self.last_event[i] = self.run.t
            if self.returns[i] > rules.CHATTER:
                raise self._chatter(i)

    def _chatter(self, i: int) -> SimulationError:
        """Of a when(); an event of the timeline happens once."""
        return SimulationError(
            f"{self.at.dae.events[i].path or 'the model'}: the event of a when() returns at once, again and again, "
            f"at t = {self.run.t:.6g} s. Give the condition a hysteresis, or let the motion come to rest there."
        )

    def happen(self, planned: list[int]) -> None:
        """Carry out events of the timeline, by their numbers in it, one after the other, and what they set off."""
        for k in planned:
            self._act(set(), k)

    def _act(self, due: set[int], planned: int | None = None) -> None:
        """Carry out events by the numbers of their indicators, or one of the timeline, and what they set off."""
        also = [] if planned is None else [self.own + planned]
        self.just_fired, self.last_act = set(), self.run.t
        for _ in range(rules.ROUNDS):
            self._count(due)
            self.just_fired |= due
            before = self._indicator_values()
            x, d = self.run.x.copy(), self.run.d.copy()
            for number in [*(self.numbers[i] for i in sorted(due)), *also]:
                point = self.run.t, self.run.x, self.run.z, self.run.q
                if number < self.own:
                    event: Event | Offer = self.at.dae.events[number]
                    on_states, on_discretes = self.at.call(self.at.functions.actions[number], *point)
                else:
                    event = self.run.timeline.planned[number - self.own].offer
                    on_states, on_discretes = self.run.timeline.carry_out(number - self.own, self.at, *point)
                x[list(event.state_targets)] = np.array(on_states).ravel()
                d[list(event.discrete_targets)] = np.array(on_discretes).ravel()
            also = []
            self.run.x, self.run.d = x, d
            self.run.z = self.run.engine.algebraics(self.run.t, self.run.x, self.run.z, self.run.q)
            after = self._indicator_values()
            due = {i for i in range(len(after)) if before[i] > 0 >= after[i] and i not in due}
            if not due:
                break
        self.arm()
