"""The tendons of a tension leg platform: any number of legs around one body, several tendons each."""

from __future__ import annotations

from typing import Any

import numpy as np

from fowtlib.components.mechanics.bodies import FixedTranslation
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring.tendon import Tendon
from fowtlib.language import Array, Component, Scalar, param, parts, port
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError
from fowtlib.language.shapes import Drawing

TENDON_PROPERTIES = (
    "pretension", "axial_stiffness", "mass_per_length", "diameter", "weight_per_length", "damping", "slack_tension",
    "greatest_strain", "breaking_load",
)  # fmt: skip


class TendonSystem(Component):
    """Tendons from the legs of a body down to the seabed; tendon_1, tendon_2, ... are its parts, leg by leg.

    Layout: `headings` (the directions of the legs seen from above, counter-clockwise from x), the radius and depth of
    the fairleads, and the depth of the anchors, which lie right below them or on a circle of `anchor_radius`. Each leg
    has `tendons_per_leg`, side by side across the leg, `spacing` apart. A property is one number, or one for each
    tendon. Without a `length` it is the distance of fairlead and anchor while the frame is upright at the still water
    level: then `pretension` is the tension at the drawn draft. How many tendons there are is fixed when the model is
    built; all numbers may be changed afterwards.
    """

    headings: Array = param(unit="rad", doc="direction of each leg")
    radius: Scalar = param(unit="m", min=0, doc="distance of the fairleads from the centreline, along the leg")
    depth: Scalar = param(unit="m", doc="depth of the fairleads below the origin of the frame")
    anchor_depth: Scalar = param(unit="m", doc="depth of the anchors below the still water level")
    anchor_radius: Scalar = param(default=None, unit="m", min=0, doc="that of the anchors; none: the fairleads' radius")
    tendons_per_leg: int = param(default=1, min=1, doc="number of tendons of each leg")
    spacing: Scalar = param(default=0.0, unit="m", min=0, doc="distance of the tendons of a leg from each other")
    length: Array = param(default=None, unit="m", min=1e-3, doc="as that of a Tendon; none: the distance as drawn")
    pretension: Array = param(default=None, unit="N", min=0, doc="tension at the fairlead at that length, upright")
    axial_stiffness: Array = param(unit="N", min=1e-3, doc="axial stiffness EA")
    mass_per_length: Array = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Array = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Array = param(default=None, unit="N/m", doc="weight in water, instead of mass and diameter")
    damping: Array = param(default=0.0, unit="N*s/m", min=0, doc="axial damping")
    slack_tension: Array = param(default=1000.0, unit="N", min=1e-6, doc="width of the rounding where one goes slack")
    greatest_strain: Array = param(default=0.1, min=POSITIVE, doc="stretch per length up to which EA is constant")
    breaking_load: Array = param(default=None, unit="N", min=0, doc="tension above which a tendon warns")

    frame: Frame = port(doc="frame of the body, on the centreline")

    arms: list[FixedTranslation] = parts(
        FixedTranslation, size=lambda self: self.count, name="fairlead",
        each=lambda self, i: {"r": self.ends(i)[0], "diameter": 0}, doc="from the frame to the fairleads",
    )  # fmt: skip
    tendons: list[Tendon] = parts(
        Tendon, size=lambda self: self.count, name="tendon", each=lambda self, i: self.tendon_values(i)
    )

    def build(self):
        for arm, tendon in zip(self.arms, self.tendons, strict=True):
            self.connect(self.frame, arm.frame_a)
            self.connect(arm.frame_b, tendon.fairlead)

    def drawing(self) -> Drawing:
        return [shape for tendon in self.tendons for shape in tendon.drawing()]

    @property
    def count(self) -> int:
        """How many tendons there are."""
        legs = len(np.atleast_1d(self.parameter_value("headings")))
        if not legs:
            raise ParameterError(f"{self.label}.headings has no leg: give the direction of each.")
        return legs * int(self.parameter_value("tendons_per_leg"))

    def ends(self, i: int) -> tuple[Any, Any]:
        """Fairlead (in the frame of the body) and anchor (world) of tendon number i, counted from 0."""
        legs, each = np.shape(self.parameter_value("headings")), int(self.parameter_value("tendons_per_leg"))
        heading = self.headings[i // each] if legs else self.headings
        along, across = (m.cos(heading), m.sin(heading)), (-m.sin(heading), m.cos(heading))
        aside = (i % each - (each - 1) / 2) * self.spacing
        return tuple(
            m.vertcat(*(out * a + aside * b for a, b in zip(along, across, strict=True)), -down)
            for out, down in ((self.radius, self.depth), (self._foot, self.anchor_depth))
        )

    def tendon_values(self, i: int) -> dict[str, Any]:
        """The parameters of tendon number i, counted from 0."""
        properties = {name: self._of(name, i) for name in TENDON_PROPERTIES if self.parameter_value(name) is not None}
        drawn = m.sqrt((self._foot - self.radius) ** 2 + (self.anchor_depth - self.depth) ** 2)
        length = drawn if self.parameter_value("length") is None else self._of("length", i)
        return {"anchor_position": self.ends(i)[1], "length": length, **properties}

    @property
    def _foot(self) -> Any:
        """Distance of the anchors from the centreline, along the leg."""
        return self.radius if self.parameter_value("anchor_radius") is None else self.anchor_radius

    def _of(self, name: str, i: int) -> Any:
        value, shape = getattr(self, name), np.shape(self.parameter_value(name))
        if shape and shape[0] != self.count:
            raise ParameterError(f"{self.label}.{name} has {shape[0]} values for {self.count} tendons; "
                                 "give one for all of them, or one for each.")
        return value[i] if shape else value
