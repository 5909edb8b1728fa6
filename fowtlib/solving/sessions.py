"""The processes of a model during one run: started at their first sample, called once in each, freed at the end."""

from __future__ import annotations

import warnings

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.equations import Session
from fowtlib.language.errors import ModelError, SimulationError


class Sessions:
    """The sessions of one run, by the number of their sampled part."""

    def __init__(self, dae: FlatDAE, resumed: bool = False):
        self.dae = dae
        self._open: dict[int, Session] = {}
        outside = next((sample.path for sample in dae.samples if sample.process is not None), None)
        if resumed and outside is not None:
            raise SimulationError(
                f"this run cannot go on from an earlier result: {outside} has a memory of its own, which the result "
                "does not hold. Start it from the beginning, or from a state."
            )

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
