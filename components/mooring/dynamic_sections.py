"""What a line with dynamics is made of: parameters, elements and the water around it, for equations and for numbers."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.mooring import line_water
from fowtlib.components.mooring.line_of_sections import LineOfSections
from fowtlib.components.mooring.lumped_mass import Elements, Points, Surroundings
from fowtlib.language import Array, Scalar, Vector, param
from fowtlib.language.errors import ParameterError


class DynamicSections(LineOfSections):
    """Partial: sections of a line with dynamics, counted from the anchor; a property is one number, or one each."""

    units_within = {"strain_table": ("1", "N")}

    elements: int = param(default=20, min=2, max=400, doc="elements of the line, shared out by lengths of sections")
    damping_ratio: Array = param(
        default=0.8, min=0, doc="internal damping: of the fastest axial mode of the elements; less in slower ones"
    )
    drag_coefficient: Array = param(
        default=1.33, min=0, doc="of flow across, on this diameter; 1.33: studless chain, 2.4 on its bar"
    )
    axial_drag_coefficient: Array = param(default=0.1, min=0, doc="of flow along, on pi times this diameter")
    added_mass_coefficient: Array = param(default=1.0, min=0, doc="of flow across, of the displaced water")
    axial_added_mass_coefficient: Array = param(default=0.0, min=0, doc="of flow along, of the displaced water")
    bending_stiffness: Array = param(default=0.0, unit="N*m^2", min=0, doc="bending stiffness EI")
    least_bending_radius: Array = param(
        default=None, unit="m", min=0, doc="radius of curvature below which it warns; 0: of any"
    )
    strain_table: Array = param(default=None, doc="strains and tensions [N] (k, 2) of a fibre rope, in place of EA")
    fibre: Array = param(default=None, structural=True, doc="1 for each section that has the strain_table; else 0")
    seabed_stiffness: Scalar = param(default=1e5, unit="Pa/m", min=1.0, doc="of the seabed, on the diameter")
    seabed_damping: Scalar = param(default=1e4, unit="Pa*s/m", min=0, doc="of the seabed, on the diameter")
    point_drag_area: Array = param(default=0.0, unit="m^2", min=0, doc="C_d A of the points")
    point_added_mass: Array = param(default=0.5, min=0, doc="added mass of the points over the displaced water")
    fairlead_start: Vector = param(
        default=None, unit="m", doc="fairlead where a run starts, world; without a value: as the parts lead to it"
    )
    waves: bool = param(default=True, doc="waves move the water at the nodes, as it moves where these are at rest")

    def nodes(self) -> int:
        """How many nodes there are, both ends among them."""
        return sum(self.shared_out()) + 1

    def shared_out(self) -> list[int]:
        """Elements of the sections: one at least, the others by the lengths that these were built with."""
        lengths = np.atleast_1d(np.asarray(self.parameter_value("lengths"), dtype=float))
        if self.elements < len(lengths):
            raise ParameterError(
                f"{self.label} has {len(lengths)} sections and {self.elements} elements; give one for each at least."
            )
        counts = np.ones(len(lengths), int)
        for _ in range(self.elements - len(lengths)):
            counts[np.argmax(lengths / counts)] += 1
        return counts.tolist()

    def each(self, name: str, values: Any = None) -> list[Any]:
        if not name.startswith("point_"):
            return super().each(name, values)
        count = self.count() - 1
        shape, value = np.shape(self.parameter_value(name)), values(name) if values else getattr(self, name)
        if shape and shape[0] != count:
            raise ParameterError(
                f"{self.label}.{name} has {shape[0]} values for {count} points between the sections; give one for all."
            )
        return [value[i] if shape else value for i in range(count)]

    def of_elements(self, name: str, values: Any = None) -> list[Any]:
        """A property of each element."""
        if values is None and self.parameter_value(name) is None:
            raise ParameterError(f"{self.label}.{name} has no value; a line with dynamics needs it.")
        return [value for value, n in zip(self.each(name, values), self.shared_out(), strict=True) for _ in range(n)]

    def of_nodes(self, name: str, values: Any = None) -> list[Any]:
        """A property of the points, for all nodes: zero where there is none."""
        found: list[Any] = [0.0] * self.nodes()
        for value, place in zip(self.each(name, values), np.cumsum(self.shared_out()[:-1]), strict=True):
            found[place] = value
        return found

    def element_lengths(self, values: Any = None) -> list[Any]:
        """Unstretched lengths of the elements."""
        return [L / n for L, n in zip(self.each("lengths", values), self.shared_out(), strict=True) for _ in range(n)]

    def shares(self) -> Any:
        """Share of the unstretched length that lies below each node, (1, n + 1)."""
        lengths = self.element_lengths()
        below = [sum(lengths[:k], start=ca.SX(0)) for k in range(self.nodes())]
        return ca.horzcat(*below) / below[-1]

    def bends(self) -> bool:
        """Whether it has bending stiffness."""
        return bool(np.any(self.parameter_value("bending_stiffness"))) or self.is_set("bending_stiffness")

    def elements_now(self) -> Elements:
        """The elements as the equations take them."""
        row = lambda name: ca.horzcat(*self.of_elements(name))  # noqa: E731
        if self.parameter_value("weight_per_length") is not None or self.parameter_value("mass_per_length") is None:
            raise ParameterError(f"{self.label}: dynamics need mass_per_length and diameter, not weight_per_length.")
        if not np.all(np.asarray(self.parameter_value("diameter"), dtype=float) > 0):
            raise ParameterError(f"{self.label}.diameter is 0; water and seabed act on the diameter of a line.")
        length, EA, mass = ca.horzcat(*self.element_lengths()), row("axial_stiffness"), row("mass_per_length")
        table = fibre = None
        if self.parameter_value("strain_table") is not None:
            given, table = np.asarray(self.parameter_value("strain_table"), dtype=float), self.strain_table
            if given.ndim != 2 or given.shape[1] != 2 or len(given) < 2 or not np.all(np.diff(given, axis=0) > 0):
                raise ParameterError(f"{self.label}.strain_table needs rows of strain and tension, both rising.")
            fibre = ca.horzcat(*(self.of_elements("fibre") if self.parameter_value("fibre") is not None else [1] * len(
                self.element_lengths())))  # fmt: skip
        return Elements(
            length, EA, row("damping_ratio") * length * ca.sqrt(EA * mass), mass, row("diameter"),
            row("bending_stiffness"), row("drag_coefficient"), row("axial_drag_coefficient"),
            row("added_mass_coefficient"), row("axial_added_mass_coefficient"), table, fibre,
        )  # fmt: skip

    def points_now(self) -> Points:
        """What stands on the nodes, as the equations take it."""
        names = ("point_mass", "point_volume", "point_drag_area", "point_added_mass")
        return Points(*(ca.horzcat(*self.of_nodes(name)) for name in names))

    def surroundings(self, nodes: Any) -> Surroundings:
        """Water and seabed at the nodes (3, n + 1), as the equations take them."""
        world = self.world
        velocity, acceleration = line_water.at_nodes(self, nodes)
        friction = ca.horzcat(*self.of_elements("friction"))
        return Surroundings(
            world.water_density, world.gravity, world.water_depth, self.seabed_stiffness, self.seabed_damping, friction,
            velocity, acceleration,
        )  # fmt: skip

    def whole(self, count: int) -> Any:
        """1 for each element, 0 for the last one of a line that is lost."""
        return ca.horzcat(ca.SX.ones(1, count - 1), self.intact)
