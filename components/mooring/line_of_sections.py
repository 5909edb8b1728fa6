"""What a line of several sections is made of: parameters, and the numbers that equations take from them."""

from __future__ import annotations

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.mooring import catenary, sections
from fowtlib.components.mooring.catenary_line import weight_is_given
from fowtlib.components.mooring.lost_line import LosableLine
from fowtlib.language import Array, outer, param
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError

OF_POINTS = ("point_mass", "point_volume")


class LineOfSections(LosableLine):
    """Partial: sections and the points between them, counted from the anchor; a property is one number, or one each."""

    lengths: Array = param(unit="m", min=POSITIVE, doc="unstretched lengths of the sections, from the anchor on")
    axial_stiffness: Array = param(unit="N", min=POSITIVE, doc="axial stiffness EA")
    mass_per_length: Array = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Array = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Array = param(
        default=None, unit="N/m", doc="weight in water, instead of mass, diameter; negative: the section floats up"
    )
    friction: Array = param(default=0.0, min=0, doc="friction coefficient of the seabed")
    point_mass: Array = param(default=0.0, unit="kg", min=0, doc="masses between the sections, from the anchor on")
    point_volume: Array = param(default=0.0, unit="m^3", min=0, doc="volumes of water that these displace")
    breaking_load: Array = param(default=None, unit="N", min=0, doc="tension above which the line warns")

    world: World = outer(World)

    def count(self):
        """The number of sections."""
        return len(np.atleast_1d(self.parameter_value("lengths")))

    def each(self, name, values=None):
        """A property of each section, or of each point; values: where it is taken from, the equations or a function."""
        count = self.count() - (name in OF_POINTS)
        shape, value = np.shape(self.parameter_value(name)), values(name) if values else getattr(self, name)
        if shape and shape[0] != count:
            of = "points between the sections" if name in OF_POINTS else "sections"
            raise ParameterError(
                f"{self.label}.{name} has {shape[0]} values for {count} {of}; give one for all of them, or one for "
                f"each. There are as many sections as lengths, {self.count()}."
            )
        return [value[i] if shape else value for i in range(count)]

    def section_weights(self):
        """Weights in water per length of the sections."""
        if weight_is_given(self):
            return self.each("weight_per_length")
        pairs = zip(self.each("mass_per_length"), self.each("diameter"), strict=True)
        return [catenary.weight_in_water(*pair, self.world.gravity, self.world.water_density) for pair in pairs]

    def point_weights(self):
        """Weights in water of the points."""
        pairs = zip(*map(self.each, OF_POINTS), strict=True)
        return [(mass - self.world.water_density * volume) * self.world.gravity for mass, volume in pairs]

    def pieces(self, weights):
        """The sections as the equations take them, of these weights per length."""
        lengths, stiffness, friction = map(self.each, ("lengths", "axial_stiffness", "friction"))
        return [sections.Section(*item, 0) for item in zip(lengths, weights, stiffness, friction, strict=True)]

    def start_lift(self):
        """Start value of the vertical tension over the weights: all of it hangs."""
        pieces, points = self.pieces(self.section_weights()), self.point_weights()
        total = sum(piece.weight * piece.length for piece in pieces) + sum(points)
        return total / catenary.scales(sections.whole(pieces, points), m)[0]

    def start_heights(self):
        """Start values of the heights: half the water depth, in proportion to the way along the line."""
        lengths = self.each("lengths")
        whole = sum(lengths)
        return [0.5 * self.world.water_depth * sum(lengths[: i + 1]) / whole for i in range(len(lengths) - 1)]
