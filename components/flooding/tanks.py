"""Tanks by their shape."""

from __future__ import annotations

from fowtlib.components.flooding.sections import Box, Disc
from fowtlib.components.flooding.tank import Tank
from fowtlib.language import Scalar, param


class BoxTank(Tank):
    """A tank with a rectangular section, walls along the axes of its frame; exact also where floor or roof is bare."""

    length: Scalar = param(unit="m", min=1e-6, doc="inside, along x of the frame")
    width: Scalar = param(unit="m", min=1e-6, doc="inside, along y of the frame")
    height: Scalar = param(unit="m", min=1e-6, doc="from floor to roof")

    def vessel(self):
        return Box(self.length, self.width, self.height)


class RoundTank(Tank):
    """A tank with a round section, or a ring around a shaft where it has an inner diameter.

    Where floor or roof is bare volumes are found by strips of the section: see fowtlib.components.flooding.sections.
    """

    diameter: Scalar = param(unit="m", min=1e-6, doc="inside, of the outer wall")
    inner_diameter: Scalar = param(default=None, unit="m", min=0, doc="of the inner wall of a ring; without: none")
    height: Scalar = param(unit="m", min=1e-6, doc="from floor to roof")

    def vessel(self):
        ring = self.is_set("inner_diameter")
        return Disc(self.diameter / 2, self.inner_diameter / 2 if ring else 0.0, self.height, ring)
