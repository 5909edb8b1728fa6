"""Parts without physics, which give a picture the form of what has only mass or only loads."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Array, Component, eq, param, port, shapes
from fowtlib.language import math as m


class VisualPart(Component):
    """Partial: something to look at, fixed to a frame; it has no mass and carries no load."""

    material: str = param(default="structure", choices=shapes.MATERIALS, doc="what it looks like")

    frame: Frame = port(doc="frame that it is fixed to")

    def equations(self):
        return [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, m.zeros(3))]


class VisualTube(VisualPart):
    """A round member in pictures: the column of a hull, a tower, an arm. No mass, no load.

    Reference: Modelica.Mechanics.MultiBody.Visualizers.FixedShape.
    """

    points: Array = param(
        unit="m", structural="pictures alone use it", doc="points (n, 3) along the axis, resolved in the frame"
    )
    diameters: Array = param(
        unit="m", min=0, structural="pictures alone use it", doc="diameter at each point, or one for all"
    )

    def drawing(self) -> shapes.Drawing:
        return [shapes.Tube(self.frame, self.points, self.diameters, material=self.material)]


class VisualBox(VisualPart):
    """A box in pictures: a pontoon, a nacelle. No mass, no load.

    Reference: Modelica.Mechanics.MultiBody.Visualizers.FixedShape.
    """

    centre: Array = param(
        default=(0, 0, 0), unit="m", structural="pictures alone use it", shape=3, doc="its centre, in the frame"
    )
    size: Array = param(
        unit="m", min=0, structural="pictures alone use it", shape=3, doc="lengths along the axes of the frame"
    )

    def drawing(self) -> shapes.Drawing:
        return [shapes.Box(self.frame, self.centre, self.size, material=self.material)]
