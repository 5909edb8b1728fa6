"""What a mooring system says of its lines where these are lines of point masses."""

from __future__ import annotations

from typing import Any

from fowtlib.components.mooring.dynamic_line import DynamicLine
from fowtlib.components.mooring.line_properties import MOVING
from fowtlib.language import Array, Component, Scalar, like

PER_LINE = ("damping_ratio", "axial_drag_coefficient", "axial_added_mass_coefficient")
SHARED = ("elements", "seabed_stiffness", "seabed_damping", "waves")


class LumpedSystem(Component):
    """Partial: parameters of DynamicLines, which count with `dynamics: lumped` only."""

    elements: int = like(DynamicLine.elements)
    damping_ratio: Array = like(DynamicLine.damping_ratio)
    axial_drag_coefficient: Array = like(DynamicLine.axial_drag_coefficient)
    axial_added_mass_coefficient: Array = like(DynamicLine.axial_added_mass_coefficient)
    bending_stiffness: Array = like(DynamicLine.bending_stiffness)
    seabed_stiffness: Scalar = like(DynamicLine.seabed_stiffness)
    seabed_damping: Scalar = like(DynamicLine.seabed_damping)
    waves: bool = like(DynamicLine.waves)

    def refuse_lumped(self, dynamics: str) -> None:
        """Raise ParameterError where one of these parameters is given, and the lines are no DynamicLines."""
        names = (*PER_LINE, "bending_stiffness", *SHARED)
        self.refuse_unused(*names, because=f"it is of lines of point masses (dynamics: lumped; here {dynamics})")

    def dynamic_line(self, values: dict[str, Any], of_line: Any) -> DynamicLine:
        """A line with the values of a CatenaryLine and those of this class; of_line(name): that of the line."""
        names = PER_LINE if not self.is_set("bending_stiffness") else (*PER_LINE, "bending_stiffness")
        own = {name: of_line(name) for name in (*names, *MOVING)} | {name: getattr(self, name) for name in SHARED}
        given = {name: value for name, value in values.items() if name not in ("dynamics", "length")}
        return DynamicLine(lengths=values["length"], **given, **own)
