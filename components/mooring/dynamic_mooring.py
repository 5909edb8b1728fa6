"""A mooring system whose lines have dynamics."""

from __future__ import annotations

from typing import Any

from fowtlib.components.mooring.dynamic_line import DynamicLine
from fowtlib.components.mooring.mooring_system import MooringSystem
from fowtlib.language import Array, Scalar, like, parts
from fowtlib.language.errors import ParameterError

PER_LINE = ("damping_ratio", "axial_drag_coefficient", "axial_added_mass_coefficient", "bending_stiffness")
SHARED = ("elements", "seabed_stiffness", "seabed_damping", "waves")


class DynamicMooring(MooringSystem):
    """A MooringSystem of DynamicLines: the same layout and properties, of which each line gets its own.

    In a model file `class: DynamicMooring` in the place of `class: MooringSystem` is all that a platform needs. The
    lines start at rest for where the body is when a run starts.
    """

    elements: int = like(DynamicLine.elements)
    damping_ratio: Array = like(DynamicLine.damping_ratio)
    axial_drag_coefficient: Array = like(DynamicLine.axial_drag_coefficient)
    axial_added_mass_coefficient: Array = like(DynamicLine.axial_added_mass_coefficient)
    bending_stiffness: Array = like(DynamicLine.bending_stiffness)
    seabed_stiffness: Scalar = like(DynamicLine.seabed_stiffness)
    seabed_damping: Scalar = like(DynamicLine.seabed_damping)
    waves: bool = like(DynamicLine.waves)

    lines: list[DynamicLine] = parts(
        DynamicLine, size=lambda self: len(self.layout()), name="line", each=lambda self, i: self.line_values(i)
    )

    def line_values(self, i: int) -> dict[str, Any]:
        values = super().line_values(i)
        if values.pop("dynamics") != "none":
            raise ParameterError(f"{self.label}.dynamics is that of quasi-static lines; these lines move by themselves.")
        if self.bends():
            values["bending_stiffness"] = self._of_line("bending_stiffness", i)
        values |= {name: self._of_line(name, i) for name in PER_LINE if name != "bending_stiffness"}
        values |= {name: getattr(self, name) for name in SHARED}
        return {"lengths": values.pop("length"), **values}

    def bends(self) -> bool:
        """Whether its lines have bending stiffness."""
        return self.is_set("bending_stiffness")
