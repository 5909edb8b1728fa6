"""An artificial stiffness that gives one mode another period: what a linear model is calibrated by.

A force in the shape of the mode, in proportion to how far the mode is deflected. How far it is, its left eigenvector
says, which is blind to all other modes; so these keep their frequencies and their damping exactly, and the mode keeps
its rate of decay (partial pole placement; Y. Saad, Math. Comp. 51 (1988)). The force acts in the equations of motion:
accelerations and section loads follow from it as from any other spring.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError, UnitError
from fowtlib.language.units import to_si
from fowtlib.solving import LinearModel, Mode
from fowtlib.solving.excited import ExcitedModel

NEAR = 0.2  # how far a mode may be from the period that names it, relative
SHOWN = 12  # modes that a message lists
MOTION = 0.5  # share of positions and speeds in a mode, from which on it is a motion

Shifts = Mapping[str | int, str | float]


def shifted(excited: ExcitedModel, gains: Sequence[np.ndarray], shifts: Shifts) -> ExcitedModel:
    """The model in which modes have other periods, with gains of drag with which it has its modes.

    shifts: the number of an oscillating mode (1 is the slowest), the state that takes part most, or its period ("1.85
    s"): the damped period [s] that it shall have ("1.79 s").
    """
    if not isinstance(shifts, Mapping):
        raise ModelError(f"shifted: modes with their new periods are expected, as in {{'1.85 s': '1.79 s'}}, not "
                         f"{shifts!r}.")  # fmt: skip
    for name, wanted in shifts.items():
        linear = excited.with_gains(gains)
        period = _seconds(wanted, f"the new period of {name}")
        excited = _moved(excited, linear, _chosen(linear, name), 2 * np.pi / period)
    return excited


def _moved(excited: ExcitedModel, linear: LinearModel, mode: Mode, omega: float) -> ExcitedModel:
    A, forces = linear.matrices["A"], excited.forces
    if not forces.speeds or len(forces.speeds) != forces.B.shape[1]:
        raise ModelError("the equations of motion of this model cannot be told from its other ones: no mode is moved.")
    roots, right = np.linalg.eig(A)
    k = int(np.argmin(np.abs(roots - mode.eigenvalue)))
    root, shape = roots[k], right[:, k]
    left = np.linalg.inv(right)[k]
    rates = shape[list(forces.speeds)]
    rates = np.real(rates * np.exp(-1j * np.angle(rates[np.argmax(np.abs(rates))])))
    share = _share_of_motion(A, forces.speeds, left, shape)
    if share < MOTION:
        raise ModelError(
            f"the mode of {mode.label}, {_text(mode)}, is no motion ({100 * share:.2g} % of it is): a stiffness does "
            "not move it. Say another one by its period."
        )
    force = np.linalg.solve(forces.B[list(forces.speeds)], rates)
    reached = left @ (forces.B @ force)
    stiffness = 1j * (omega**2 - root.imag**2) / (2 * root.imag) / reached
    row = 2 * np.real(stiffness * left)  # of the states: the force for the deflection of this mode alone
    return replace(excited, linear=_sprung(excited.linear, forces, np.outer(force, row)))


def _share_of_motion(A: np.ndarray, speeds: Sequence[int], left: np.ndarray, right: np.ndarray) -> float:
    """How much of a mode is in speeds, and in positions whose rates these are; the rest is of filters and the like."""
    own = set(speeds)
    positions = {k for k, row in enumerate(A) if np.count_nonzero(row) == 1 and int(np.argmax(np.abs(row))) in own}
    parts = np.abs(left * right)
    return float(parts[sorted(own | positions)].sum() / parts.sum())


def _sprung(linear: LinearModel, forces: Any, law: np.ndarray) -> LinearModel:
    """The model with forces that follow from the states by a law (forces, states)."""
    A, B, C, D = (linear.matrices[name] for name in "ABCD")
    operators = linear.operators
    if operators is not None:
        operators = replace(operators, C=operators.C + forces.D_operators @ law)
    return LinearModel(A + forces.B @ law, B, C + forces.D @ law, D, linear.states, linear.inputs, linear.outputs,
                       linear.units, operators)  # fmt: skip


def _chosen(linear: LinearModel, name: str | int) -> Mode:
    """The oscillating mode of a number, a state or a period."""
    modes = [mode for mode in linear.modes() if mode.eigenvalue.imag > 1e-9 * abs(mode.eigenvalue)]
    if isinstance(name, int):
        if not 1 <= name <= len(modes):
            raise ModelError(f"there is no mode {name}; there are {_list(modes)}.")
        return modes[name - 1]
    labelled = [mode for mode in modes if mode.label == name]
    if len(labelled) == 1:
        return labelled[0]
    if len(labelled) > 1:
        raise ModelError(
            f"'{name}' takes part most in {len(labelled)} modes: {_list(labelled)}. Say the period of one."
        )
    if name in linear.states or not name.strip()[:1].isdigit():
        raise ModelError(f"'{name}' takes part most in no oscillating mode; there are {_list(modes)}.")
    period = _seconds(name, "a mode by its period")
    nearest = min(modes, key=lambda mode: abs(mode.period / period - 1), default=None)
    if nearest is None or abs(nearest.period / period - 1) > NEAR:
        raise ModelError(f"there is no mode near a period of {period:g} s; there are {_list(modes)}.")
    return nearest


def _seconds(value: str | float, what: str) -> float:
    try:
        seconds = float(to_si(value, "s", what))
    except (TypeError, ValueError, UnitError):
        seconds = np.nan
    if not (np.isfinite(seconds) and seconds > 0):
        raise ModelError(f"{what}: '{value}' is not a period, such as '1.79 s'.")
    return seconds


def _text(mode: Mode) -> str:
    return f"{mode.period:.4g} s"


def _list(modes: Sequence[Mode]) -> str:
    found = [f"{number} of {_text(mode)} ({mode.label})" for number, mode in enumerate(modes, 1)]
    return ", ".join(found[:SHOWN]) + (f" and {len(found) - SHOWN} more" if len(found) > SHOWN else "") or "none"
