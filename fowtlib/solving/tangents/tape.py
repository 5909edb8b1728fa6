"""What a run of the fixed-step engine did, in the order in which it did it: starts, stages, samples, events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.engines import Engine
from fowtlib.solving.engines.fixed_step import FixedStep
from fowtlib.solving.engines.twin import FixedStepTwin
from fowtlib.solving.timeline import Timeline


@dataclass(frozen=True, eq=False)
class Point:
    """A point of the model: time [s], states, algebraic unknowns, q = [u; d]."""

    t: float
    x: np.ndarray
    z: np.ndarray
    q: np.ndarray


@dataclass(frozen=True, eq=False)
class Start:
    """The engine begins at a point.

    before: where it stood until q jumped there, so that it kept the lag of its rates; else None.
    """

    point: Point
    before: Point | None


@dataclass(frozen=True, eq=False)
class Stretch:
    """Steps with one q: their stages (time, length of the step, states, algebraic unknowns), and where outputs lie.

    each: steps between two points; times: of these points [s]; states: their number.
    """

    stages: np.ndarray
    states: int
    each: int
    times: np.ndarray
    q: np.ndarray


@dataclass(frozen=True, eq=False)
class Sample:
    """A sampled part computes its values at a point."""

    number: int
    point: Point


@dataclass(frozen=True, eq=False)
class Happening:
    """An event of the timeline, by its number there, is carried out at a point."""

    number: int
    point: Point


Record = Start | Stretch | Sample | Happening


class Taped:
    """An engine that writes down what it does; else the one that it is given.

    Raises SimulationError where an event happens at an instant that depends on the motion.
    """

    def __init__(self, inner: FixedStep | FixedStepTwin, timeline: Timeline):
        self.inner, self.at, self.advice, self.timeline = inner, inner.at, inner.advice, timeline
        self.tape: list[Record] = []
        self._stages = np.zeros((0, 0))
        self._stands: Point | None = None
        self._told: tuple[np.ndarray, np.ndarray] | None = None  # x and q at the last point
        self._expected = False  # a sample or an event has just been carried out
        inner.watch = self._take
        timeline.heard = self._hear

    @property
    def attributes(self) -> dict[str, float | str]:
        """What a result says about its solver."""
        return self.inner.attributes

    @property
    def seen(self) -> np.ndarray:
        """What the engine has given at the points of the last `advance`."""
        return self.inner.seen

    def advance(self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray,
                q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """States and algebraic unknowns (rows) at `points` equidistant times after t."""
        begun = self._start(Point(t, x.copy(), z.copy(), q.copy()))
        xs, zs = self.inner.advance(t, length, points, x, z, q)
        if len(xs) < points:  # it was stopped
            return xs, zs
        if begun is not None:
            self.tape.append(begun)
        times = t + length * np.arange(1, points + 1) / points
        self.tape += _stretches(self._stages, x.size, times, q.copy())
        self._stands = Point(float(times[-1]), xs[-1].copy(), zs[-1].copy(), q.copy())
        return xs, zs

    def algebraics(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Algebraic unknowns that satisfy the equations at the states, after a jump."""
        if not self._expected:
            raise SimulationError(
                f"an event of the model's own happens at t = {t:.6g} s, at an instant that depends on the motion"
                f"{self._cause(t, x, z)}. Of what comes after it there are no sensitivities here; end the run before."
            )
        found = self.inner.algebraics(t, x, z, q)
        begun = self._start(Point(t, x.copy(), found.copy(), q.copy()), anew=True)
        if begun is not None:
            self.tape.append(begun)
        self._stands, self._expected = Point(t, x.copy(), found.copy(), q.copy()), False
        return found

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes, as a function of t, x, z, q."""
        update = self.inner.updater(sample)

        def taped(t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
            self.tape.append(Sample(sample, Point(t, x.copy(), z.copy(), q.copy())))
            self._expected = True
            return update(t, x, z, q)

        return taped

    def stop(self, now: bool) -> None:
        """Let `advance` return early; False: no more."""
        self.inner.stop(now)

    def memory(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """All that the next `advance` depends on."""
        return self.inner.memory()

    def remarks(self) -> list[str]:
        """Sentences on what a user should know of the run so far."""
        return self.inner.remarks()

    def remember(self, text: Mapping[str, Any], numbers: Mapping[str, np.ndarray]) -> None:
        """Nothing: a run whose sensitivities are wanted begins at its start."""
        raise SimulationError("sensitivities begin at the start of a run: it cannot go on from an earlier one.")

    def _take(self, stages: np.ndarray) -> None:
        self._stages = stages

    def _hear(self, number: int, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> None:
        planned = self.timeline.planned[number]
        if planned.at is None:
            raise SimulationError(
                f"the event {planned.label} happens at t = {t:.6g} s, when its condition becomes true: the instant "
                "depends on the motion. Let it happen at a time, 'at 100 s', or end the run before."
            )
        self.tape.append(Happening(number, Point(t, x.copy(), z.copy(), q.copy())))
        self._expected = True

    def _start(self, point: Point, anew: bool = False) -> Start | None:
        """The start that the engine makes at a point, by its own rule; None where it just goes on."""
        stands, tiny = self._stands, 1e-9 * float(self.attributes["step"])
        there = stands is not None and abs(point.t - stands.t) <= tiny and np.array_equal(point.x, stands.x)
        if there and not anew and np.array_equal(point.q, stands.q):
            return None
        return Start(point, stands if there else None)

    def _cause(self, t: float, x: np.ndarray, z: np.ndarray) -> str:
        """Which event it probably is: the one whose indicator is nearest to zero."""
        dae = self.at.dae
        if not dae.events or self._stands is None:
            return ""
        values = np.abs(np.array(self.at.call(self.at.functions.indicators, t, x, z, self._stands.q)).ravel())
        path = dae.events[int(np.argmin(values))].path
        return f" ({path})" if path else ""


def taped(engine: Engine, timeline: Timeline) -> Taped:
    """A fixed-step engine that writes down what it does."""
    if not isinstance(engine, (FixedStep, FixedStepTwin)):
        raise SimulationError("sensitivities are those of the solver fixed.")
    return Taped(engine, timeline)


def _stretches(stages: np.ndarray, states: int, times: np.ndarray, q: np.ndarray) -> list[Stretch]:
    """Steps up to the points at `times` as one stretch; where steps were cut on the way to some, one for each."""
    ends = np.searchsorted(stages[:, 0] - 0.25 * stages[:, 1], times)  # a stage lies in the second half of its step
    each = np.diff(ends, prepend=0)
    if np.all(each == each[0]):
        return [Stretch(stages, states, int(each[0]), times, q)]
    begins = ends - each
    return [
        Stretch(stages[first:end], states, int(end - first), times[[k]], q)
        for k, (first, end) in enumerate(zip(begins, ends, strict=True))
    ]
