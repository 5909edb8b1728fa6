"""The fixed-step engine: generalized-alpha in compiled code; see fixed_step.c for the scheme and docs/solvers.md."""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.engines.fixed_step_code import FixedStepCode, Options, runtime
from fowtlib.solving.failure import StepFailure, cut_steps, step_failure
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.initial import consistent_algebraics

NEWTON = 200.0  # times the tolerance: what the iterations leave of a rate, relative to the largest it has been
AT_POINTS = 1.0  # times the tolerance: the same of the algebraic unknowns at output points, where it costs little
KEEP = 100  # steps over which a Newton matrix is kept, as long as it leads on
PREDICTOR = 2  # degree of the polynomial through the last stages
PARTS = 8  # of a step that is not solved, at most: 2 to the power of FS_HALVINGS of fixed_step.c
EXTERNAL, STOPPED = 3, 5  # FS_EXTERNAL and FS_STOPPED of fixed_step.c


class FixedStep:
    """Integrates over an interval with equal steps of at most `step`, with equidistant output points.

    It goes on with its own rates where it stands at the point it is called from; anywhere else it starts anew.
    watch: is given the stages of each call of `advance`, rows of time, length of the step, states, algebraic unknowns.
    """

    def __init__(self, code: FixedStepCode, at: AtParameters, step: float, tolerance: float,
                 rho_inf: float, keep: int = KEEP, predictor: int = PREDICTOR):  # fmt: skip
        self.code, self.at, self.reduced = code, at, code.reduction
        self.watch: Callable[[np.ndarray], None] | None = None
        self.seen = np.empty((0, code.width))
        self.attributes = {"solver": "fixed", "step": step, "rho_inf": rho_inf, "tolerance": tolerance}
        self.advice = f"or take a shorter step (--step {500 * step:g}ms)"
        self._library, self._watched = runtime(), (code.address("observed"), code.size, code.address("checked"))
        options = Options(step, rho_inf, NEWTON * tolerance, AT_POINTS * tolerance, keep, predictor)
        self._instance = self._library.fs_create(c.byref(code.table), c.byref(options))
        if not self._instance:
            raise MemoryError("no memory for the fixed-step engine")

    def __del__(self):
        if getattr(self, "_instance", None):
            self._library.fs_free(self._instance)
            self._instance = None

    def advance(
        self, t: float, length: float, points: int, x: np.ndarray, z: np.ndarray, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic unknowns (rows) at `points` equidistant times after t; StepFailure where it fails."""
        self.code.raised.clear()
        x, z, given = _numbers(x), _numbers(z), self.at.whole(q)
        xs, zs, reached = np.empty((points, len(x))), np.empty((points, len(z))), c.c_int()
        seen, self.seen = np.empty((points, self.code.width)), self.seen[:0]
        rows = seen.ctypes.data if seen.size else None
        self._library.fs_watch(self._instance, *self._watched, self.code.width, self.code.constants, rows)
        stages = None
        if self.watch is not None:
            rows = points * max(1, int(np.ceil(length / points / self.attributes["step"] * (1 - 1e-9))))
            stages = np.empty((PARTS * rows, 2 + len(x) + len(z)))  # most of it is never touched
            self._library.fs_record(self._instance, stages.ctypes.data)
        status = self._library.fs_advance(
            self._instance, t, length, points, x.ctypes.data, z.ctypes.data, given.ctypes.data, xs.ctypes.data,
            zs.ctypes.data, c.byref(reached),
        )  # fmt: skip
        self._library.fs_watch(self._instance, None, 0, None, 0, None, None)
        if stages is not None:
            end = self._library.fs_record(self._instance, None)
            if not status and self.watch is not None:
                self.watch(stages[: (end - stages.ctypes.data) // stages.strides[0]].copy())
        self.seen = seen[: reached.value]
        if status == STOPPED:
            return xs[: reached.value], zs[: reached.value]
        if status:
            raise self._failure(status)
        return xs, zs

    def stop(self, now: bool) -> None:
        """Let `advance`, which runs in another thread, return what it has; False: no more."""
        self._library.fs_stop(self._instance, int(now))

    def memory(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """All that the next step depends on, as a text and numbers."""
        image = np.zeros(self._library.fs_image_size(self._instance), np.uint8)
        self._library.fs_save(self._instance, image.ctypes.data)
        return {"engine": "fixed"}, {"image": image}

    def remember(self, text: Mapping[str, Any], numbers: Mapping[str, np.ndarray]) -> None:
        """Take the memory of an engine with the same model and settings; ValueError where it is of another one."""
        image = np.ascontiguousarray(numbers.get("image", ()), np.uint8)
        if text["engine"] != "fixed" or not self._library.fs_fits(self._instance, image.ctypes.data, image.size):
            raise ValueError("the memory of its solver is that of another one")
        self._library.fs_restore(self._instance, image.ctypes.data)

    def algebraics(self, t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Algebraic unknowns that satisfy the equations at the states; SimulationError where none are found."""
        self.code.raised.clear()
        x, new, given = _numbers(x), np.array(z, dtype=float), self.at.whole(q)
        status = self._library.fs_consistent(self._instance, t, x.ctypes.data, new.ctypes.data, given.ctypes.data)
        return consistent_algebraics(self.at, t, x, z, q) if status else new

    def updater(self, sample: int) -> Callable[..., np.ndarray]:
        """What a sampled part computes (see SampledUpdate.values), as a function of t, x, z, q."""
        function, outputs = self.code.address(f"sample_{sample}"), self.code.samples_need_outputs[sample]
        count = self.code.dae.samples[sample].values.numel()

        def update(t: float, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray:
            self.code.raised.clear()
            x, z, given = _numbers(x), _numbers(z), self.at.whole(q)
            values = np.empty(count)
            status = self._library.fs_observe(
                self._instance, function, outputs, t, x.ctypes.data, z.ctypes.data, given.ctypes.data,
                values.ctypes.data,
            )  # fmt: skip
            if status:
                raise SimulationError(str(self._failure(status)))
            return values

        return update

    def remarks(self) -> list[str]:
        """Sentences on steps that had to be cut so far; none where there were none."""
        first, last, parts = c.c_double(), c.c_double(), c.c_int()
        found = self._library.fs_cuts(self._instance, c.byref(first), c.byref(last), c.byref(parts))
        return [cut_steps(found, first.value, last.value, parts.value, self.advice)] if found else []

    def counts(self) -> dict[str, int]:
        """What has been done so far: steps, evaluations of the equations, Newton matrices, starts, steps cut."""
        names = ("steps", "evaluations", "matrices", "algebraic_matrices", "starts", "slopes", "cut")
        values = (c.c_longlong * len(names))()
        self._library.fs_counts(self._instance, c.byref(values))
        return dict(zip(names, values, strict=True))

    def _failure(self, status: int) -> StepFailure:
        if self.code.raised:
            raise self.code.raised[-1]
        t, row, not_finite, external = c.c_double(), c.c_int(), c.c_int(), c.c_int()
        self._library.fs_failure(self._instance, c.byref(t), c.byref(row), c.byref(not_finite), c.byref(external))
        dae = self.code.dae
        if status == EXTERNAL:
            item = dae.externals[self.code.external_order[external.value]]
            name = item.function.name()
            return StepFailure(f"the external function {name} of {item.path} fails at t = {t.value:.6g} s")
        return StepFailure(step_failure(dae, self.code.reduction.free, t.value, row.value, bool(not_finite.value)))


def _numbers(array: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(array, dtype=float)
