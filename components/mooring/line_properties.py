"""What a line of one sort from end to end is: its parameters, and how it moves in the water where that is asked for."""

from __future__ import annotations

from fowtlib.components.mooring.lost_line import LosableLine
from fowtlib.language import Scalar, param
from fowtlib.language.bounds import POSITIVE

MOVING = ("drag_coefficient", "added_mass_coefficient")
"""What counts for a line that moves."""
IN_BALANCE = "the line is in balance at every moment, without drag and inertia (dynamics: none)"


class UniformLine(LosableLine):
    """Partial: a line of the same properties from end to end.

    dynamics: none, the line is in balance at every moment; coupled, it has the inertia and drag of LineMotion, and its
    body feels them; uncoupled, its tension has them and its body feels the line in balance, as is usual in models
    that find motions first and tensions afterwards.
    """

    length: Scalar = param(unit="m", min=POSITIVE, doc="unstretched length")
    axial_stiffness: Scalar = param(unit="N", min=POSITIVE, doc="axial stiffness EA")
    mass_per_length: Scalar = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Scalar = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Scalar = param(
        default=None, unit="N/m", doc="weight in water, instead of mass, diameter; negative: the line floats up"
    )
    friction: Scalar = param(default=0.0, min=0, doc="friction coefficient of the seabed")
    greatest_strain: Scalar = param(default=0.1, min=POSITIVE, doc="stretch per length up to which EA is constant")
    breaking_load: Scalar = param(default=None, unit="N", min=0, doc="tension above which the line warns")
    dynamics: str = param(
        default="none", choices=("none", "coupled", "uncoupled"), doc="inertia and drag of the line: see UniformLine"
    )
    drag_coefficient: Scalar = param(
        default=1.33, min=0, doc="of flow across, on this diameter; 1.33: studless chain, 2.4 on its bar"
    )
    added_mass_coefficient: Scalar = param(default=1.0, min=0, doc="of flow across, of the displaced water")
