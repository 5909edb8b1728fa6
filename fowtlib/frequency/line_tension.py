"""Largest tensions of mooring lines that move, from a response: drag makes them larger than those of a Gaussian."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fowtlib.analysis.drag_maxima import rayleigh_exponential_extreme
from fowtlib.frequency.found import Response
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.solving.model import Model, Output

LAW = ("tension", "shape_velocity")
"""What the law takes from the response of a line, by the names of its variables."""
DRAG = "generalised_drag"


@dataclass(frozen=True)
class LineExtreme:
    """Largest tension of a line in a time, mean, deviation [N], share of drag k, number of maxima.

    std is that of the tension with its drag as it is, not of the linear law in its place.
    """

    largest: float
    mean: float
    std: float
    drag_share: float
    maxima: float

    @property
    def dynamic(self) -> float:
        """The largest tension less its mean [N]."""
        return self.largest - self.mean


def with_line_results(model: Model) -> Model:
    """The model with what `line_extreme` needs of each line that has dynamics as further results, named by path."""
    lines = [part.path for part in model.root.walk() if DRAG in part.variables and "shape_velocity" in part.variables]
    if not lines:
        raise ModelError("no line of this model has dynamics; give its mooring dynamics: coupled or uncoupled.")
    more = {f"{path}.{name}": Output(f"{path}.{name}") for path in lines for name in LAW}

    def rebuild(values: Mapping[str, Any]) -> Model:
        return with_line_results(model.rebuild(values))

    return replace(model, outputs={**model.outputs, **more}, rebuild=rebuild if model.rebuild else None)


def line_extreme(
    found: Response, line: str, duration: float = 3600.0, quantile: float | None = 0.5
) -> LineExtreme:
    """Quantile of the largest tension of a line in a duration [s]; the line moves in one degree of freedom.

    found: response of a model of `with_line_results`; line: path of the line, "platform.mooring.line_2". The tension
    less its mean is c |u'| u' with the velocity u' of the shape, and what is linear; c is that at the mean. The linear
    law has 8/pi (c s_u'^2)^2 of its variance for the drag, the drag itself 3 (c s_u'^2)^2. quantile: None takes
    the characteristic largest of fowtlib.analysis.drag_maxima.
    """
    names = [f"{line}.{name}" for name in LAW]
    if names[0] not in found.outputs or names[1] not in found.outputs:
        lines = [name.removesuffix(f".{LAW[1]}") for name in found.outputs if name.endswith(f".{LAW[1]}")]
        hint = did_you_mean(line, lines) if lines else "; compile fowtlib.frequency.with_line_results(model)."
        raise ModelError(f"the response has no results of a moving line '{line}'{hint}")
    if not duration > 0:
        raise ModelError(f"a duration above 0 s; not {duration:g}.")
    spectrum, u = found.spectrum(names[0]), found.std(names[1])
    mean = float(found.mean[found.outputs.index(names[0])])
    drag = float(found.state[f"{line}.{DRAG}"]) * u**2
    linear = spectrum.std**2 - 8 / np.pi * drag**2
    if not spectrum.std > 0:
        return LineExtreme(mean, mean, 0.0, 0.0, 0.0)
    rest = float(np.sqrt(max(linear, 1e-6 * spectrum.std**2)))
    std, share = float(np.sqrt(rest**2 + 3 * drag**2)), drag / rest
    maxima = spectrum.up_crossing_rate * duration
    above = std * float(rayleigh_exponential_extreme(maxima, share, quantile))
    return LineExtreme(mean + above, mean, std, share, maxima)
