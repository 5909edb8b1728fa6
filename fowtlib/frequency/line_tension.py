"""Largest tensions of mooring lines that move, from a response: larger than those of a Gaussian, because of drag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fowtlib.analysis.drag_maxima import rayleigh_exponential_extreme
from fowtlib.analysis.line_maxima import harmonic_extreme
from fowtlib.analysis.spectra import Spectrum
from fowtlib.frequency.found import Response
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.solving.model import Model, Output

LAW = ("tension", "shape_velocity")
"""What the law takes from the response of a line, by the names of its variables."""
DRAG = "generalised_drag"


@dataclass(frozen=True)
class LineExtreme:
    """Largest tension of a line in a time, mean, deviation [N], share of drag k, number of maxima.

    std: by the law "rayleigh_exponential" with the drag as it is, by "harmonic" that of the response.
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
    found: Response, line: str, duration: float = 3600.0, quantile: float | None = 0.5, law: str = "harmonic"
) -> LineExtreme:
    """Quantile of the largest tension of a line in a duration [s]; the line moves in one degree of freedom.

    found: response of a model of `with_line_results`; line: path of the line, "platform.mooring.line_2". quantile: None
    takes the characteristic largest, which one of N + 1 maxima exceeds. law, of how drag changes the maxima:

    harmonic             the tension of a motion of the largest amplitude, with the drag that a harmonic motion of it
                         has, 8/(3 pi) c U u'; slower motions of a Gaussian beside it. Tension stays below that of
                         pure stretch, as it must. 5 to 18 % above the dynamic tension of runs of a spar.
    rayleigh_exponential the tension less its mean is c |u'| u' with a Gaussian velocity u' of the shape, and what is
                         linear (analysis.drag_maxima). Where drag prevails it is far on the safe side: it knows no
                         limit of u'. The linear law has 8/pi (c s_u'^2)^2 of its variance for the drag, and the drag
                         3 (c s_u'^2)^2.
    """
    spectrum, speed, mean = _results(found, line)
    if law not in ("harmonic", "rayleigh_exponential"):
        raise ModelError(f"law: '{law}' is not 'harmonic' or 'rayleigh_exponential'.")
    if not duration > 0:
        raise ModelError(f"a duration above 0 s; not {duration:g}.")
    if not (spectrum.std > 0 and speed.std > 0):
        return LineExtreme(mean, mean, 0.0, 0.0, 0.0)
    drag, maxima = float(found.state[f"{line}.{DRAG}"]) * speed.std**2, spectrum.up_crossing_rate * duration
    rest = float(np.sqrt(max(spectrum.std**2 - 8 / np.pi * drag**2, 1e-6 * spectrum.std**2)))
    share = drag / rest
    if law == "harmonic":
        sizes = float(rayleigh_exponential_extreme(maxima, 0.0, quantile))
        return LineExtreme(mean + _harmonic(found, line, sizes), mean, spectrum.std, share, maxima)
    std = float(np.sqrt(rest**2 + 3 * drag**2))
    above = std * float(rayleigh_exponential_extreme(maxima, share, quantile))
    return LineExtreme(mean + above, mean, std, share, maxima)


def _results(found: Response, line: str) -> tuple[Spectrum, Spectrum, float]:
    """Spectra of the tension of a line and of the velocity of its shape, and its mean tension."""
    names = [f"{line}.{name}" for name in LAW]
    if any(name not in found.outputs for name in names):
        lines = [name.removesuffix(f".{LAW[1]}") for name in found.outputs if name.endswith(f".{LAW[1]}")]
        hint = did_you_mean(line, lines) if lines else "; compile fowtlib.frequency.with_line_results(model)."
        raise ModelError(f"the response has no results of a moving line '{line}'{hint}")
    return found.spectrum(names[0]), found.spectrum(names[1]), float(found.mean[found.outputs.index(names[0])])


def _harmonic(found: Response, line: str, sizes: float) -> float:
    """Tension above the mean [N] in a motion of `sizes` deviations, of the frequency at which the shape moves."""
    spectrum, speed, _ = _results(found, line)
    of_line = {
        "elastic_stiffness": "elastic_stiffness", "geometric_stiffness": "geometric_stiffness",
        "mass": "generalised_mass", "drag": DRAG, "axial_mass": "axial_mass",
    }  # fmt: skip
    values = {name: float(found.state[f"{line}.{variable}"]) for name, variable in of_line.items()}
    omega = 2 * np.pi * speed.up_crossing_rate
    return float(harmonic_extreme(sizes, spectrum.std, speed.std, omega, **values))
