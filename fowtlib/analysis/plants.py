"""What the drivers of analyses ask of a model: compiled, in calm weather, with known outputs, at a stable point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fowtlib.language.eigenvectors import eigenvalues
from fowtlib.language.errors import ModelError, SimulationError, did_you_mean
from fowtlib.solving.paths import names_of

MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
CALM = {"sea.spectrum": "still", "wind.kind": "none"}


def calm(model: Any) -> dict[str, str]:
    """Parameters that take wind and waves from a model, for the parts ``sea`` and ``wind`` that it has."""
    return {path: value for path, value in CALM.items() if path.partition(".")[0] in model.root.parts}


def still_water(plant: Any) -> dict[str, str]:
    """Parameters that take the waves from a run of a compiled model, where they may be others in every run."""
    path, value = next(iter(CALM.items()))
    bound = path in plant.dae.bound_parameters
    return {path: value} if bound and plant.root.find("sea").spectrum != "input" else {}


def plant_of(model: Any) -> Any:
    """The compiled model of a model, or of one that is compiled already; ModelError for what is neither."""
    if hasattr(model, "compile"):
        return model.compile()
    if not hasattr(model, "dae"):
        name = repr(model) if isinstance(model, str) else "..."
        raise ModelError(f"a model or a compiled model is expected, not {type(model).__name__}; "
                         f"load one first: fw.load({name}).")  # fmt: skip
    return model


def compiled(model: Any) -> Any:
    """The compiled model: one that is compiled already as it is, a model after wind and waves were taken from it."""
    if not hasattr(model, "compile"):
        return plant_of(model)
    quiet = calm(model)
    return (model.with_parameters(quiet) if quiet else model).compile()


def checked_frequencies(frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
    """Frequencies in Hz as an array; they must be positive."""
    try:
        frequency = np.atleast_1d(np.asarray(frequencies, dtype=float))
    except (TypeError, ValueError):
        raise ModelError(f"frequencies are positive numbers in Hz, not {frequencies!r}.") from None
    if frequency.ndim != 1 or not frequency.size or not (np.isfinite(frequency) & (frequency > 0)).all():
        raise ModelError("frequencies are positive numbers in Hz, at least one.")
    return frequency


def chosen_outputs(plant: Any, outputs: Sequence[str] | None) -> list[str]:
    """The outputs asked for; None takes the six motions as far as there are any, else all."""
    known = list(plant.outputs)
    if outputs is None:
        return [name for name in MOTIONS if name in known] or known
    names = names_of(outputs)
    if not names:
        raise ModelError("outputs are empty: name one result or more, or take None for all.")
    for name in names:
        if name not in known:
            raise ModelError(f"the model has no result '{name}'{did_you_mean(name, known, list_up_to=30)}")
    return names


def shown_unit(plant: Any, name: str) -> str:
    """Unit in which the model gives a result."""
    return plant.outputs[name][1]


def state_behind(plant: Any, linear: Any, name: str) -> tuple[str, float]:
    """The one state that a result follows, and the change of the result (in its unit) per unit of that state."""
    row = np.asarray(linear.C.sel(output=name), dtype=float)
    behind = np.flatnonzero(np.abs(row) > 1e-9 * np.abs(row).max(initial=0.0)) if row.any() else np.zeros(0, dtype=int)
    if behind.size != 1:
        of = ", ".join(linear.states[k] for k in behind[:4]) or "no state at all"
        raise ModelError(
            f"'{name}' cannot be given an offset: it depends on {of}. Take a result that follows one state alone."
        )
    return linear.states[behind[0]], float(row[behind[0]])


class UnstableError(SimulationError):
    """A state that a model does not keep: a mode of its linear model grows."""


def refuse_unstable(linear: Any) -> None:
    """Raise UnstableError when the linear model has a growing mode: then there is no steady response.

    The linear model is to be that of the mean where rotors turn (fowtlib.solving.mean_linear_model): one at a single
    azimuth has a root of the azimuth, which says nothing about stability.
    """
    A = linear.matrices["A"]
    roots = eigenvalues(A) if A.size else np.zeros(0)
    growing = roots[(roots.real > 1e-6 * np.abs(roots)) & (roots.real > 1e-6)]
    if growing.size:
        worst = growing[np.argmax(growing.real)]
        most = next(mode.label for mode in linear.modes() if abs(mode.eigenvalue - complex(worst.real, abs(worst.imag)))
                    <= 1e-6 * abs(worst))  # fmt: skip
        what = f"a mode of {abs(worst.imag) / (2 * np.pi):.4g} Hz" if worst.imag else "a motion that does not oscillate"
        raise UnstableError(
            f"the state is unstable: {what}, in which {most} takes part most, grows by a factor e in "
            f"{1 / worst.real:.4g} s (pole {worst.real:+.4g} {abs(worst.imag):+.4g}i 1/s), so there is no steady "
            "response."
        )
