"""The run of a simulation: stretches between events and samples, output points, checks, and what survives a failure."""

from __future__ import annotations

import sys
import threading
import time as clock
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.language.leave import require_leave
from fowtlib.solving import event_rules as rules
from fowtlib.solving.binding import Binding
from fowtlib.solving.checkpoint import checkpoint as make_checkpoint
from fowtlib.solving.checkpoint import differences, restore
from fowtlib.solving.checks import broken, too_coarse
from fowtlib.solving.engines import Engine
from fowtlib.solving.engines.fixed_step_code import FixedStepCode
from fowtlib.solving.events import StateEvents
from fowtlib.solving.failure import StepFailure, integration_failure
from fowtlib.solving.initial import consistent_algebraics
from fowtlib.solving.interrupts import deferred_interrupt, stoppable
from fowtlib.solving.observation import Observation
from fowtlib.solving.outputs import Outputs
from fowtlib.solving.pace import announcement, is_slow, longest_stretch, seconds_per_second
from fowtlib.solving.results import Observer, RawTrajectory, Result, parameter_hash, signature
from fowtlib.solving.results.data import Stored
from fowtlib.solving.results.journal import Journal
from fowtlib.solving.sessions import Sessions
from fowtlib.solving.state import State
from fowtlib.solving.timeline import Timeline

TOLD = 5.0  # s that a run without a compiler may take before something is said about it
SLOW_STRETCH = 50  # output points of a stretch without a compiler; never by the clock, which results do not depend on
MOST_PARTS = 10_000  # stretches of an output step
PIECE = 5.0  # s between two pieces of the journal, and checkpoints
LONG = 0.2  # s of a stretch, expected, above which it runs in a thread, so that Ctrl-C is heard


class Interrupted(SimulationError):
    """Ctrl-C during a simulation; `result` holds what was computed."""


@dataclass(frozen=True)
class About:
    """What a run is of, for its result.

    name, title: of the model; binding: what the run takes in.
    """

    name: str
    title: str
    binding: Binding


class Run:
    """One run from a state, with an engine that knows the model and its parameters.

    names: the results to give. resumed: whether the state is the end of another run, whose samples are done. code: the
    compiled functions that rebuild variables, where they have been made. timeline: the events of the run.
    """

    def __init__(self, engine: Engine, start: State, outputs: Outputs, names: Sequence[str], about: About,
                 resumed: bool = False, code: Callable[[], FixedStepCode | None] = lambda: None,
                 timeline: Timeline | None = None):  # fmt: skip
        self.engine, self.at, self.dae = engine, engine.at, engine.at.dae
        self.outputs, self.names, self.about, self.code = outputs, list(names), about, code()
        self.binding, self.resumed = about.binding, resumed
        self.most, self.parts = rules.STRETCH, 1  # output points of a stretch, or stretches of an output step
        require_leave(self.binding.root)
        self.interrupted, self.pace = threading.Event(), np.inf  # s of the clock for one simulated, by the last stretch
        self.checkpoint, self.final_checkpoint, self.saved = b"", False, 0.0
        self.journal: Journal | None = None
        self.written = 0  # output points in the journal
        self.pieces: list[dict[str, np.ndarray]] = []  # their results, which are not computed again at the end
        self.went_on_from: float | None = None
        self.sessions = Sessions(self.dae)
        if resumed:
            self.sessions.require_states()
        self.t = start.t
        self.x, self.z, self.d, self.u = start.x.copy(), start.z.copy(), start.d.copy(), start.u.copy()
        self.rows: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []
        self.seen: list[np.ndarray] = []  # what compiled code has given at these rows; NaN where they were amended
        self.warned: dict[int, str] = {}
        self.timeline = timeline or Timeline((), self.dae, outputs, about.binding.root)
        self.events = StateEvents(self)
        self._prepare_samples(start.t)

    # --- preparation ---------------------------------------------------------------------------------------------

    def _prepare_samples(self, t: float) -> None:
        samples = self.dae.samples
        self.updates = [self.engine.updater(k) for k in range(len(samples))]
        self.clocks: list[tuple[float, float, int]] = []
        for sample, (period, offset) in zip(samples, self.at.clocks(), strict=True):
            if not period > 0:
                raise SimulationError(
                    f"{sample.path}: the period of a sampled part is {period:g} s; it must be above zero."
                )
            first = self._next_sample((t - offset) / period)
            self.clocks.append((offset, period, first))

    def _next_sample(self, passed: float) -> int:
        """Number of the first sample; a run that is resumed has carried out the one at its start already."""
        if passed <= 0 and not self.resumed:
            return 0
        return max(0, int(np.floor(passed + rules.DUE)) + 1 if self.resumed else int(np.ceil(passed - rules.DUE)))

    @property
    def q(self) -> np.ndarray:
        return np.concatenate([self.u, self.d])

    # --- the run -------------------------------------------------------------------------------------------------

    def run(self, t_end: float, step: float, progress: Callable[[float, float], None] | bool,
            discard: float = 0.0, checkpoint: bytes = b"", journal: Journal | None = None,
            earlier: Stored | None = None) -> Result:  # fmt: skip
        """Integrate to t_end; see Plant.simulate. The result does not hold the first `discard` seconds.

        checkpoint: where an earlier run stood, to go on from; its first output point is the last before. journal: where
        the results are written while the run goes on, behind those of an `earlier` run.
        """
        if discard >= t_end - self.t > 0 and not checkpoint:  # reckoned from the first start of the run
            raise SimulationError(
                f"discard is {discard:g} s, and the run is {t_end - self.t:g} s long; nothing would be left of it."
            )
        self.discard = discard
        if not step > 0:
            raise SimulationError(f"the output step is {step:g} s; it must be above zero.")
        if t_end < self.t:
            raise SimulationError(f"the end of the simulation, {t_end:g} s, lies before its start, {self.t:g} s.")
        told = _console if progress is True else progress or (lambda t, t_end: None)
        began, self.t_start, self.step, self.wall_time = clock.perf_counter(), self.t, step, float("nan")
        try:
            with deferred_interrupt() as self.interrupted:

                def report(t: float, t_end: float) -> None:
                    if self.interrupted.is_set():
                        raise KeyboardInterrupt
                    told(t, t_end)  # may raise KeyboardInterrupt, too

                self._plan_stretches(step)
                if checkpoint:
                    self._go_on(checkpoint)
                else:
                    self._let_happen(0.0)
                    self._sample_now()
                    self._record(np.array([self.t]), self.x[None], self.z[None])
                self._say_what_is_slow(t_end - self.t)
                self._begin_journal(journal, earlier)
                report(self.t, t_end)
                self._integrate(t_end, step, report, bool(checkpoint))
        except KeyboardInterrupt:
            if self.interrupted.is_set():
                self.engine.stop(False)
            if self.rows and self.t > self.rows[-1][0][-1]:  # within an output step
                self._record(np.array([self.t]), self.x[None], self.z[None])
            raise self._stopped(Interrupted(f"interrupted at t = {self.t:g} s.")) from None
        except SimulationError as error:
            raise self._stopped(error) from None
        finally:
            self.sessions.close()
            if journal is not None:
                journal.close()
        self.wall_time = clock.perf_counter() - began
        for text in [*self.timeline.missing(), *self.engine.remarks()]:
            self.warned[-1 - len(self.warned)] = text
            warnings.warn(text, stacklevel=4)
        return self.result("finished.")

    def can_go_on(self, earlier: Result, t_end: float, step: float) -> bytes:
        """The checkpoint of an earlier result to go on from exactly; empty, with a warning, without one that fits."""
        data, self.step = earlier.raw.checkpoint if earlier.raw is not None else b"", step
        if t_end < earlier.final.time:
            return b""
        if not data:
            self.sessions.require_none("the result has none")
            warnings.warn(
                "the run goes on with a new start of its solver, not exactly as it would have: the result to resume "
                f"from holds no checkpoint. It was {earlier.attributes['status']}", stacklevel=4,
            )  # fmt: skip
            return b""
        try:
            changed = differences(data, self)
        except ValueError as error:
            raise SimulationError(f"the result to resume from is damaged: of its checkpoint, {error}.") from None
        if not changed:
            return data
        self.sessions.require_none(f"that does not fit: {'; '.join(changed)}")
        warnings.warn(
            f"the run goes on with a new start of its solver, not exactly as it would have: {'; '.join(changed)}.",
            stacklevel=4,
        )  # fmt: skip
        return b""

    def _plan_stretches(self, step: float) -> None:
        """Stretches so short that each is expected to take a few seconds, by what the model is, not by the clock."""
        longest = longest_stretch(self.engine)
        most = SLOW_STRETCH if is_slow(self.engine) else rules.STRETCH
        self.most = int(min(max(longest / step, 1), most))
        self.parts = int(np.ceil(min(step / longest, MOST_PARTS))) if step > longest else 1

    def _say_what_is_slow(self, duration: float) -> None:
        """One line at the start without a compiler."""
        if duration <= 0:
            return
        pace = seconds_per_second(self.engine, self.t, self.x, self.z, self.q)
        if pace[1] * duration > TOLD:
            warnings.warn(announcement(self.engine, pace, duration), RuntimeWarning, stacklevel=4)

    def _stopped(self, error: SimulationError) -> SimulationError:
        self.wall_time = float("nan")
        error.result = self.result(str(error)) if self.rows else None  # type: ignore[attr-defined]
        return error

    def _go_on(self, checkpoint: bytes) -> None:
        try:
            restore(checkpoint, self)
            self.seen = [self._unseen(1)]
        except (ValueError, KeyError) as error:
            raise SimulationError(f"the result to resume from does not fit: of its checkpoint, {error}.") from None
        self.checkpoint, self.went_on_from = checkpoint, float(self.rows[0][0][0])

    # --- what survives -------------------------------------------------------------------------------------------

    def _begin_journal(self, journal: Journal | None, earlier: Stored | None) -> None:
        self.journal, self.saved = journal, clock.perf_counter()
        if journal is None:
            return
        entries = {name: self.outputs.entry(name) for name in self.names}
        journal.begin(
            {
                "units": {name: entry.unit for name, entry in entries.items()},
                "long_names": {name: entry.doc or name for name, entry in entries.items()},
                "attributes": {**signature(), **self._attributes("")},
                "raw": {
                    **dict(zip("xzd", self._names(), strict=True)),
                    "parameter_hash": parameter_hash(self.binding.values),
                },
            },
            earlier,
            self.checkpoint,
        )

    def _look_back(self, cut: bool) -> None:
        """Between two stretches: keep the point to go on from, and write a piece where it is time.

        cut: the next stretch is shorter than it would be in a longer run.
        """
        if self.final_checkpoint and not self.journal:
            return
        time = clock.perf_counter()
        due = time - self.saved > PIECE
        if not self.final_checkpoint and (due or cut or not self.checkpoint):
            self.checkpoint, self.final_checkpoint = make_checkpoint(self), cut
        if due:
            self._write_piece()
            self.saved = clock.perf_counter()

    def _write_piece(self) -> None:
        """To the journal: all output points but the last, which may change yet and is in the checkpoint."""
        if self.journal is None:
            return
        new, left = [], sum(len(row[0]) for row in self.rows) - self.written
        rows = [(*row, seen) for row, seen in zip(self.rows, self.seen, strict=True)]
        for row in reversed(rows):  # what is written already is not copied again
            if left <= 0:
                break
            new.insert(0, tuple(column[-left:] for column in row))
            left -= len(row[0])
        t, x, z, d, seen = (np.concatenate([row[i] for row in new])[:-1] for i in range(5))
        kept = t >= self.t_start + self.discard - 1e-9 * self.step
        self.written += len(t)
        t, x, z, d, seen = t[kept], x[kept], z[kept], d[kept], seen[kept]
        if not len(t):
            self.journal.write(None, {}, self.checkpoint)
            return
        self.pieces.append(self._series(self._observe(t, x, z, d, seen)))
        self.journal.write(self._raw(t, x, z, d), self.pieces[-1], self.checkpoint)

    def _integrate(self, t_end: float, step: float, report: Callable[[float, float], None], goes_on: bool) -> None:
        tiny = rules.TINY * step
        if not goes_on:
            self.events.arm()
        while self.t < t_end - tiny:
            passed = round((self.rows[-1][0][-1] - self.t_start) / step)
            after = self._next_end(passed, step)
            next_output = min(after, t_end)
            next_sample = min((o + k * p for o, p, k in self.clocks), default=np.inf)
            next_break = next((t for t in self.binding.breaks if t > self.t + tiny), np.inf)
            next_break = min(next_break, self.timeline.next_time(self.t + tiny))
            free, stop = min(next_sample, next_break), min(next_sample, next_break, t_end)
            on_grid = self.parts == 1 and abs(self.t - (self.t_start + passed * step)) < tiny
            points, most = ((min(int(min((end - self.t) / step + rules.TINY, self.most)), self.most) if on_grid else 0)
                            for end in (stop, free))  # fmt: skip
            self._look_back(points != most or (not points and min(stop, next_output) != min(free, after)))
            if points:
                self._stretch(points * step, points)
            else:
                self._stretch(min(stop, next_output) - self.t, 1, record=False)
            self._let_happen(tiny)
            if abs(self.t - next_sample) < tiny:
                self._sample_now()
            recorded = self.rows[-1][0][-1]
            on_output = abs(self.t - self.t_start - round((self.t - self.t_start) / step) * step) < tiny
            if abs(recorded - self.t) < tiny:
                self._amend_last()
            elif on_output or self.t > t_end - tiny:
                self._record(np.array([self.t]), self.x[None], self.z[None])
            report(self.t, t_end)

    def _next_end(self, passed: int, step: float) -> float:
        """The next output point, or the next end of a stretch before it where an output step has several."""
        last, part = self.t_start + passed * step, step / self.parts
        done = int((self.t - last) / part + rules.TINY * self.parts) + 1 if self.parts > 1 else 1
        return last + done * part if done < self.parts else self.t_start + (passed + 1) * step

    def _stretch(self, length: float, points: int, record: bool = True) -> None:
        """Advance by `length` with `points` output points, or to the first state event."""
        watching = self.events.watching
        substeps = rules.SUBSTEPS if watching else 1
        x, z = self.advance(length, points * substeps)
        reached, seen = len(x), self.engine.seen
        seen = seen if len(seen) == reached else self._unseen(reached)
        times = self.t + length * np.arange(1, points * substeps + 1) / (points * substeps)
        if watching:
            crossing = self.events.first_crossing(times[:reached], x, z)
            if crossing is not None:
                whole = (crossing // substeps) * substeps
                self._keep(times, x, z, seen, whole, substeps, record)
                self.events.carry_out(times, x, z, crossing)
                return
        self._keep(times, x, z, seen, reached, substeps, record)
        if reached < points * substeps:
            if self.interrupted.is_set():
                raise KeyboardInterrupt
            raise self.failure()

    def _keep(self, times: np.ndarray, x: np.ndarray, z: np.ndarray, seen: np.ndarray, reached: int, substeps: int,
              record: bool) -> None:  # fmt: skip
        if reached == 0:
            return
        chosen = slice(substeps - 1, reached, substeps)
        self.t, self.x, self.z = float(times[reached - 1]), x[reached - 1].copy(), z[reached - 1].copy()
        if record and len(times[chosen]):
            self._record(times[chosen], x[chosen], z[chosen], seen[chosen])

    def advance(self, length: float, points: int) -> tuple[np.ndarray, np.ndarray]:
        """Rows of x and z at equidistant points; fewer rows where the engine fails."""
        if not self.x.size:
            return self._advance_static(length, points)
        try:
            return self._timed(length, points)
        except StepFailure as failure:
            self.reason = str(failure)
        if self.interrupted.is_set():
            raise KeyboardInterrupt
        xs, zs = [], []  # again in single steps, to keep what can be computed
        x, z = self.x, self.z
        for k in range(points):
            try:
                xk, zk = self.engine.advance(self.t + k * length / points, length / points, 1, x, z, self.q)
            except StepFailure as failure:
                self.reason = str(failure)
                break
            x, z = xk[0], zk[0]
            xs.append(x)
            zs.append(z)
        return np.array(xs).reshape(len(xs), self.x.size), np.array(zs).reshape(len(zs), self.z.size)

    def _timed(self, length: float, points: int) -> tuple[np.ndarray, np.ndarray]:
        """The engine's rows; where that may take long it runs in a thread, which hears of an interrupt."""
        began, point = clock.perf_counter(), (self.t, length, points, self.x, self.z, self.q)
        try:
            if self.pace * length < LONG or threading.current_thread() is not threading.main_thread():
                return self.engine.advance(*point)
            try:
                return stoppable(lambda: self.engine.advance(*point), self.interrupted, lambda: self.engine.stop(True))
            finally:
                if self.interrupted.is_set():
                    self.engine.stop(False)
        finally:
            self.pace = (clock.perf_counter() - began) / length

    def _advance_static(self, length: float, points: int) -> tuple[np.ndarray, np.ndarray]:
        """A model without states: algebraic unknowns at each point."""
        z, rows = self.z, []
        for k in range(points):
            z = consistent_algebraics(self.at, self.t + (k + 1) * length / points, self.x, z, self.q)
            rows.append(z)
        return np.zeros((points, 0)), np.array(rows).reshape(points, -1)

    # --- samples -------------------------------------------------------------------------------------------------

    def _sample_now(self) -> None:
        """Carry out the sampled parts that are due, in order of their dependence."""
        clocks = enumerate(self.clocks)
        due = [k for k, (offset, period, n) in clocks if offset + n * period <= self.t + rules.DUE * period]
        if not due:
            return
        for k in due:
            sample, values = self.dae.samples[k], self.updates[k](self.t, self.x, self.z, self.q)
            offset, period, n = self.clocks[k]
            assigned = self.sessions.step(k, offset + n * period, values) if sample.process else values
            self.d[list(sample.targets)] = assigned
            self.clocks[k] = (offset, period, n + 1)
        self.z = self.engine.algebraics(self.t, self.x, self.z, self.q)
        self.events.arm()

    def _let_happen(self, tiny: float) -> None:
        """Carry out the events of the timeline that are due."""
        due = self.timeline.due(self.t + tiny)
        if due:
            self.events.happen(due)

    # --- output points -------------------------------------------------------------------------------------------

    def _record(self, times: np.ndarray, x: np.ndarray, z: np.ndarray, seen: np.ndarray | None = None) -> None:
        """seen: what the engine has given there, rows of NaN where nothing."""
        self.rows.append((times, x, z, np.repeat(self.d[None], len(times), axis=0)))
        if seen is None or not seen.shape[1] or np.isnan(seen).all():
            seen = self._observe(*self.rows[-1]).rows()
        self.seen.append(self._unseen(len(times)) if seen is None else seen)
        self._check(times, x, z)

    def _unseen(self, points: int) -> np.ndarray:
        return np.full((points, self.code.width if self.code else 0), np.nan)

    def _amend_last(self) -> None:
        """The last output point lies at an event or a sample: keep the values after it."""
        times, *values = self.rows[-1]
        for rows, now in zip(values, (self.x, self.z, self.d), strict=True):
            rows[-1] = now
        self.seen[-1][-1] = np.nan

    def _check(self, times: np.ndarray, x: np.ndarray, z: np.ndarray) -> None:
        """Assertions at output points; the first broken one of level error stops the run there."""
        if not self.dae.checks:
            return
        n, values = len(times), self.seen[-1][:, -len(self.dae.checks) :]
        if not values.size or np.isnan(values).any():
            values = self.at.along(self.at.functions.conditions, times, x, z, np.repeat(self.q[None], n, axis=0))
        for k in np.flatnonzero((values == 0).any(axis=1)):
            for i in np.flatnonzero(values[k] == 0).tolist():
                check = self.dae.checks[i]
                if check.level == "rest" or (check.level != "error" and i in self.warned):
                    continue
                point = times[k], x[k], z[k], self.q
                coarse = too_coarse(self.at, i, *point, self.engine, self.step) if check.level == "step" else ""
                if check.level == "step" and not coarse:
                    continue
                text = f"{broken(self.at, i, self.about.name, *point)}{coarse} (t = {times[k]:g} s)."
                if check.level != "error":
                    self.warned[i] = text
                    warnings.warn(text, stacklevel=2)
                    continue
                last = self.rows[-1]
                self.rows[-1] = tuple(part[: k + 1] for part in last)  # type: ignore[assignment]
                self.seen[-1] = self.seen[-1][: k + 1]
                self.t, self.x, self.z = float(times[k]), x[k], z[k]
                raise SimulationError(text)

    def failure(self) -> SimulationError:
        """The error at the last good point."""
        return SimulationError(
            integration_failure(self.at, self.t, self.x, self.z, self.q, self.step, self.reason, self.engine.advice)
        )

    def _warn_of_gaps(self, name: str, t: np.ndarray, series: np.ndarray) -> None:
        """Say which result is not a number somewhere: such a value does not stop a run that does not need it."""
        gaps = ~np.isfinite(series.reshape(len(t), -1)).all(axis=1)
        if gaps.any():
            points = f"{gaps.sum()} of {len(t)} output points, first at t = {t[gaps][0]:g} s"
            text = f"{name} is not a finite number at {points}."
            self.warned[-1 - len(self.warned)] = text
            warnings.warn(text, stacklevel=4)

    def result(self, status: str) -> Result:
        """What has been computed, as a Result."""
        t, x, z, d = (np.concatenate([row[i] for row in self.rows]) for i in range(4))
        seen = np.concatenate(self.seen)
        kept = t >= min(self.t_start + self.discard - 1e-9 * self.step, t[-1])
        t, x, z, d = t[kept], x[kept], z[kept], d[kept]
        observe, values = self._observe(t, x, z, d), self._all_series(t, x, z, d, seen[kept])
        for name, series in values.items():
            self._warn_of_gaps(name, t, series)
        raw = self._raw(t, x, z, d, self.checkpoint)
        observer = Observer(observe.values, self.outputs.describe, self.dae.names, self.binding.root)
        entries = {name: self.outputs.entry(name) for name in self.names}
        units, docs = ({name: getattr(entry, of) for name, entry in entries.items()} for of in ("unit", "doc"))
        return Result(t, values, units, docs, self._attributes(status), raw, observer)

    def _observe(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, d: np.ndarray,
                 seen: np.ndarray | None = None) -> Observation:  # fmt: skip
        return Observation(self.at, t, x, z, self.u, d, self.code, seen)

    def _series(self, observe: Observation) -> dict[str, np.ndarray]:
        """The results along rows of a trajectory."""
        paths = [self.outputs.entry(name).path for name in self.names]
        series = zip(self.names, observe.arrays(paths), strict=True)
        return {name: self.outputs.shown(name, values) for name, values in series}

    def _all_series(self, *rows: np.ndarray) -> dict[str, np.ndarray]:
        """The same along all rows that are kept, of which the first may be in the journal."""
        done = sum(len(next(iter(piece.values()), ())) for piece in self.pieces)
        last = self._series(self._observe(*(values[done:] for values in rows)))
        return {name: np.concatenate([*(piece[name] for piece in self.pieces), last[name]]) for name in self.names}

    def _raw(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, d: np.ndarray,
             checkpoint: bytes = b"") -> RawTrajectory:  # fmt: skip
        return RawTrajectory(t, x, z, d, *self._names(), parameter_hash(self.binding.values), checkpoint)

    def _names(self) -> list[tuple[str, ...]]:
        return [tuple(q.path for q in group) for group in (self.dae.states, self.dae.algebraics, self.dae.discretes)]

    def _attributes(self, status: str) -> dict[str, Any]:
        about, numbers = self.about, self.binding.values
        return {
            "model": about.name,
            "title": about.title,
            **self.engine.attributes,
            "status": status,
            **({} if self.went_on_from is None else {"goes_on_from": self.went_on_from}),
            "parameters": {path: value.tolist() for path, value in numbers.items()},
            "structure": dict(self.binding.structure),
            "data": dict(self.binding.data),
            "wall_time": self.wall_time,
            "warnings": "\n".join(self.warned.values()),
            **({"events": "\n".join(self.timeline.happened)} if self.timeline.happened else {}),
        }


def _console(t: float, t_end: float) -> None:
    """Progress on stderr for Python users: simulated time."""
    print(f"\rt = {t:.1f} of {t_end:.1f} s", end="\n" if t >= t_end else "", file=sys.stderr, flush=True)
