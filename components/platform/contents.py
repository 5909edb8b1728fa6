"""What is in a member: ballast, bulkheads, point masses. Parts of a member, which weighs them."""

from __future__ import annotations

from fowtlib.components.platform.members import Fill, Lump, Plate
from fowtlib.language import Component, Scalar, Vector, param


class Ballast(Component):
    """Water, sand or concrete in a member up to a level; its surface is horizontal, whichever way the member runs.

    The tank is the inside of the member between two distances from its start. The surface does not move with the hull:
    a slack tank takes nothing off the stability here.
    """

    density: Scalar = param(default=1025.0, unit="kg/m^3", min=0, doc="density of the ballast")
    level: Scalar = param(unit="m", doc="height z of its surface in the frame of the floater")
    tank_start: Scalar = param(default=0.0, unit="m", min=0, doc="where its tank begins: distance from the start")
    tank_end: Scalar = param(default=None, unit="m", min=0, doc="where its tank ends; without a value: with the member")

    def equations(self):
        return []  # its member weighs it

    def numbers(self, raised: float, length: float) -> Fill:
        """The ballast of a member of this length [m]; raised [m]: how much higher than its level it lies."""
        end = self.parameter_value("tank_end")
        density, level, start = (float(self.parameter_value(name)) for name in ("density", "level", "tank_start"))
        return Fill(self.label, density, level + raised, start, length if end is None else float(end))


class Bulkhead(Component):
    """A plate across the inside of a member: a bulkhead, or the floor or deck that closes it."""

    place: Scalar = param(unit="m", min=0, doc="distance of its middle from the start of the member")
    thickness: Scalar = param(unit="m", min=0, doc="thickness")
    density: Scalar = param(default=7850.0, unit="kg/m^3", min=0, doc="density of its material")

    def equations(self):
        return []  # its member weighs it

    def numbers(self) -> Plate:
        """The bulkhead as numbers."""
        return Plate(self.label, *(float(self.parameter_value(name)) for name in ("place", "thickness", "density")))


class LumpedMass(Component):
    """A point mass on or in a member which nothing else describes: equipment, stiffeners, a fairlead."""

    mass: Scalar = param(unit="kg", min=0, doc="mass")
    place: Vector = param(unit="m", doc="its place in the frame of the floater")

    def equations(self):
        return []  # its member weighs it

    def numbers(self, raised: float) -> Lump:
        """The mass as numbers; raised [m]: how much higher than its place it lies."""
        x, y, z = map(float, self.parameter_value("place"))
        return Lump(self.label, float(self.parameter_value("mass")), (x, y, z + raised))
