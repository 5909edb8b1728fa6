"""What an airfoil makes of the flow, the part of a blade-element rotor that can be another one; the steady airfoil.

An airfoil model is C text beside this file, which defines `flow` as polar.c says, and its NumPy twin. The balance of
momentum takes the polars, whatever the model, and the loads come from the model: in equilibrium it must be the polar.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from fowtlib.components.aero.blade_aerodynamics import Airfoil

Look = Callable[[np.ndarray], tuple[np.ndarray, ...]]


@dataclass(frozen=True)
class SectionFlow:
    """The flow at n sections: what a model is told.

    angle [rad] of attack and speed [m/s] of the relative wind at the aerodynamic centre; chord [m]; turn [rad/s], nose
    up; states (states, n); step [s], see stage_step; airfoil (n,): the number of each section's airfoil.
    """

    angle: np.ndarray
    speed: np.ndarray
    chord: np.ndarray
    turn: np.ndarray
    states: np.ndarray
    step: float
    airfoil: np.ndarray


@dataclass(frozen=True)
class AirfoilModel:
    """The steady airfoil: lift, drag and moment are those of the polar at the angle of attack now."""

    source: ClassVar[str] = "steady_airfoil.c"
    state_units: ClassVar[tuple[str, ...]] = ()

    @property
    def states(self) -> int:
        """Number of states of a section."""
        return len(self.state_units)

    def cubics(self, foil: Airfoil) -> np.ndarray:
        """The polar and what the model adds to it, by power of (angle - knot): (n - 1, columns, 4)."""
        return foil.cubics

    def data(self, foils: Sequence[Airfoil]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Macros of the C text, and arrays of numbers, one for each airfoil."""
        return {}, {}

    def flow(self, look: Look, told: SectionFlow, foils: Sequence[Airfoil]) -> tuple[np.ndarray, np.ndarray]:
        """C_l, c_d, c_m (3, n) and the rates of the states (states, n). look: the columns at angles (n,)."""
        return np.array(look(told.angle)[:3]), np.zeros((0, len(told.angle)))


STEADY = AirfoilModel()
