"""The processes of a model during one run: started at their first sample, called once in each, freed at the end."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.equations import Session
from fowtlib.language.errors import ModelError, SimulationError


class Sessions:
    """The sessions of one run, by the number of their sampled part."""

    def __init__(self, dae: FlatDAE):
        self.dae = dae
        self._open: dict[int, Session] = {}
        self._outside = {k: sample for k, sample in enumerate(dae.samples) if sample.process is not None}
        self._fails = False

    def require_states(self) -> None:
        """Refuse to go on from an earlier result with a process that cannot save what it remembers."""
        without = [k for k, sample in self._outside.items() if not getattr(sample.process, "keeps_state", False)]
        if without:
            raise self._cannot_go_on(without[0], "which the result does not hold")

    def require_none(self, reason: str) -> None:
        """Refuse to go on from an earlier result without its checkpoint, for the reason given."""
        for k in self._outside:
            raise self._cannot_go_on(k, f"which only a checkpoint holds, and {reason}")

    def _cannot_go_on(self, k: int, why: str) -> SimulationError:
        return SimulationError(
            f"this run cannot go on from an earlier result: {self._outside[k].path or 'the model'} has a memory of its "
            f"own, {why}. Start it from the beginning, or from a state."
        )

    def saved(self) -> dict[int, bytes] | None:
        """What the sessions remember, by number; None, with one warning, where one of them cannot save it."""
        if self._fails or not all(getattr(sample.process, "keeps_state", False) for sample in self._outside.values()):
            return None if self._outside else {}
        states = {}
        for k, session in self._open.items():
            try:
                states[k] = bytes(session.saved_state())
            except ModelError as error:
                self._fails = True
                warnings.warn(
                    f"{self._outside[k].path or 'the model'}: what it remembers cannot be saved, so that this run "
                    f"cannot be resumed: {str(error).rstrip('.')}.", stacklevel=4,
                )  # fmt: skip
                return None
        return states

    def restore(self, states: Mapping[int, bytes]) -> None:
        """Start sessions that go on from what others have saved; SimulationError with the path where that fails."""
        for k, state in states.items():
            if k not in self._outside:
                raise ValueError("it is of another model")
            try:
                self._open[k] = self._outside[k].process.start()
                self._open[k].restore_state(state)
            except ModelError as error:
                path = self._outside[k].path or "the model"
                raise SimulationError(f"{path}: cannot go on from what it has saved: {error}") from error

    def step(self, sample: int, t: float, inputs: np.ndarray) -> np.ndarray:
        """The outputs of a process; SimulationError with its path and the time where it fails."""
        part = self.dae.samples[sample]
        try:
            if not np.all(np.isfinite(inputs)):
                raise SimulationError("one of its inputs is not a finite number")
            if sample not in self._open:
                self._open[sample] = part.process.start()
            outputs = np.array(self._open[sample].step(t, inputs), dtype=float).ravel()
        except Exception as error:
            text = str(error).strip() or "no message"
            text = text if isinstance(error, ModelError) else f"{type(error).__name__}: {text}"
            raise SimulationError(f"{part.path or 'the model'}: {text.rstrip('.')} (t = {t:.6g} s).") from error
        if outputs.size != len(part.targets):
            raise SimulationError(f"{part.path}: gives {outputs.size} outputs instead of {len(part.targets)}.")
        for number, value in zip(part.targets, outputs, strict=True):
            if not np.isfinite(value):
                name = self.dae.discretes[number].path
                raise SimulationError(f"{name} is {value:g}: the process behind it has failed (t = {t:.6g} s).")
        return outputs

    def close(self) -> None:
        """Free all sessions; what goes wrong in it does not cost the results."""
        while self._open:
            sample, session = self._open.popitem()
            try:
                session.close()
            except Exception as error:
                warnings.warn(f"{self.dae.samples[sample].path}: closing it fails: {error}", stacklevel=3)
