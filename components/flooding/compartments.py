"""A ring of compartments around a shaft, filled alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.components.flooding.rings import refuse_inside_out
from fowtlib.components.flooding.sections import Contents, Wedge
from fowtlib.components.flooding.tank import Tank
from fowtlib.language import Number, Scalar, assert_, param, shapes
from fowtlib.language import math as m
from fowtlib.language.declarations import join

_BARE = (
    "the surface comes to floor or roof of a compartment, where it rises by {rises} m at the wall; the loss of "
    "stability by free surfaces is counted larger there than it is"
)


@dataclass(frozen=True)
class Compartments:
    """Vessels of equal sections that are filled alike, seen as one: sections as a Wedge, which may pass the floor."""

    wedge: Wedge

    area = property(lambda self: self.wedge.area)
    height = property(lambda self: self.wedge.height)
    capacity = property(lambda self: self.wedge.capacity)

    def contents(self, h: Any, slope: tuple[Any, Any]) -> Contents:
        """What is under the surfaces."""
        return self.wedge.contents(h, slope)


class CompartmentRing(Tank):
    """A ring-shaped tank parted by radial walls into equal compartments, which are emptied and filled alike.

    Each has its own level surface, at the same height at its own middle: the loss of stability is that of the second
    moments of the compartments about their own middles. With n compartments, from r to R, of the area A, their sum is
    pi (R^4 - r^4)/4 - A b^2/2, with the distance b of a middle from the axis, 2/3 (R^3 - r^3)/(R^2 - r^2) sin(pi/n)
    over pi/n. The turning of the water about these middles is left out of its inertia as well. Where a surface would
    come to floor or roof, the loss is counted as if it did not, which is too much; a run warns of it.
    Source: K.J. Rawson and E.C. Tupper, Basic Ship Theory, ch. 4 (free surfaces, subdivision).
    """

    diameter: Scalar = param(unit="m", min=1e-6, doc="inside, of the outer wall")
    inner_diameter: Scalar = param(unit="m", min=0, doc="of the inner wall")
    height: Scalar = param(unit="m", min=1e-6, doc="from floor to roof")
    compartments: Number = param(default=8, min=3, doc="number of compartments")

    def vessel(self):
        R, r = self.diameter / 2, self.inner_diameter / 2
        area, half = m.pi * (R**2 - r**2), m.pi / self.compartments
        middle = 2 / 3 * (R**3 - r**3) / (R**2 - r**2) * m.sin(half) / half
        own = m.pi / 4 * (R**4 - r**4) - area * middle**2 / 2
        return Compartments(Wedge(area, (own, own, 0.0), self.height, (R - middle, R - middle)))

    def build(self):
        super().build()
        refuse_inside_out(self, "inner_diameter", "diameter")

    def equations(self):
        up, reach = self.frame.R.T @ m.vertcat(0, 0, 1), self.vessel().wedge.reach[0]
        rises = reach * m.sqrt(up[0] ** 2 + up[1] ** 2) / up[2]
        room = m.fmin(self.level, self.height - self.level)
        return [*super().equations(), assert_(rises <= room + 1e-3 * self.height, _BARE, level="warning", rises=rises)]

    def drawing(self) -> shapes.Drawing:
        """The water as one disc on the axis of the frame."""
        up = {name: join(self.path, f"frame.R[{i},2]") for i, name in enumerate("xyz")}
        floor = float(self.parameter_value("place")[2])

        def column(at: Mapping[str, Any]) -> np.ndarray:
            axis = np.stack([at[name] for name in "xyz"], axis=1)
            heights = floor + np.stack([0 * at["level"], at["level"]], axis=1)
            return at["frame"][:, None, :] + heights[:, :, None] * axis[:, None, :]

        of = {"frame": self.frame, "level": join(self.path, "level"), **up}
        return [shapes.Curve(of, column, float(self.parameter_value("diameter")), material="water")]
