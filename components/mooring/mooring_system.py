"""A mooring system: any number of catenary lines, in any layout, on one body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fowtlib.components.environment.world import World
from fowtlib.components.mechanics.bodies import FixedTranslation
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mooring import catenary
from fowtlib.components.mooring.anchors import LEVEL
from fowtlib.components.mooring.catenary_line import CatenaryLine
from fowtlib.components.mooring.line_properties import IN_BALANCE, MOVING
from fowtlib.components.mooring.lumped_system import LumpedSystem
from fowtlib.components.mooring.yaw_spring import YawSpring
from fowtlib.language import Array, Component, Scalar, param, parts, port
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError
from fowtlib.language.shapes import Drawing

LINE_PROPERTIES = (
    "length", "axial_stiffness", "mass_per_length", "diameter", "weight_per_length", "friction", "greatest_strain",
    "breaking_load", "drag_coefficient", "added_mass_coefficient",
)  # fmt: skip


class MooringSystem(LumpedSystem):
    """Catenary lines from fairleads on a body to anchors on the seabed; line_1, line_2, ... are its parts.

    Layout: `headings` (the directions of the lines seen from above, counter-clockwise from x) with fairlead radius and
    depth and anchor radius; or explicit lists of `fairleads` (in the body's frame) and `anchors` (world). A property of
    the lines is one number, or one for each line. `yaw_stiffness` adds a YawSpring. `dynamics` is that of CatenaryLine;
    or lumped: the lines are DynamicLines of `elements` elements, which take the parameters above that these have.
    How many lines there are is fixed when the model is built; all numbers may be changed afterwards.
    """

    headings: Array = param(default=None, unit="rad", doc="direction of each line")
    fairlead_radius: Scalar = param(default=None, unit="m", doc="distance of the fairleads from the centreline")
    fairlead_depth: Scalar = param(default=None, unit="m", doc="depth of the fairleads below the origin of the frame")
    anchor_radius: Scalar = param(default=None, unit="m", doc="distance of the anchors from the centreline")
    anchor_depth: Scalar = param(default=None, unit="m", doc="depth of the anchors below the still water level")
    fairleads: Array = param(default=None, unit="m", doc="fairleads (n, 3), resolved in the frame")
    anchors: Array = param(default=None, unit="m", doc="anchors (n, 3), world")
    length: Array = param(unit="m", min=POSITIVE, doc="unstretched length")
    axial_stiffness: Array = param(unit="N", min=POSITIVE, doc="axial stiffness EA")
    mass_per_length: Array = param(default=None, unit="kg/m", min=0, doc="mass per length in air")
    diameter: Array = param(default=0.0, unit="m", min=0, doc="diameter of a bar that displaces the same water")
    weight_per_length: Array = param(default=None, unit="N/m", doc="weight in water, instead of mass and diameter")
    friction: Array = param(default=0.0, min=0, doc="friction coefficient of the seabed")
    greatest_strain: Array = param(default=0.1, min=POSITIVE, doc="stretch per length up to which EA is constant")
    breaking_load: Array = param(default=None, unit="N", min=0, doc="tension above which a line warns")
    dynamics: str = param(
        default="none", choices=("none", "coupled", "uncoupled", "lumped"), doc="inertia and drag of the lines"
    )
    drag_coefficient: Array = param(default=1.33, min=0, doc="of flow across; see CatenaryLine")
    added_mass_coefficient: Array = param(default=1.0, min=0, doc="of flow across, of the displaced water")
    yaw_stiffness: Scalar = param(default=None, unit="N*m/rad", min=0, doc="yaw stiffness of the delta lines")

    frame: Frame = port(doc="frame of the body, on the centreline")

    arms: list[FixedTranslation] = parts(
        FixedTranslation, size=lambda self: len(self.layout()), name="fairlead",
        each=lambda self, i: {"r": self.layout()[i][0]}, doc="from the frame to the fairleads",
    )  # fmt: skip
    lines: list[CatenaryLine] = parts(
        CatenaryLine, size=lambda self: len(self.layout()), name="line", each=lambda self, i: self.line_values(i)
    )

    def build(self):
        if self.dynamics == "lumped":
            for i in range(len(self.layout())):
                self.lines[i] = self.dynamic_line(self.line_values(i), lambda name, i=i: self._of_line(name, i))
        else:
            self.refuse_lumped(self.dynamics)
        if self.dynamics == "none":
            self.refuse_unused(*MOVING, because=IN_BALANCE)
        for arm, line in zip(self.arms, self.lines, strict=True):
            self.connect(self.frame, arm.frame_a)
            self.connect(arm.frame_b, line.fairlead)
        if self._has("yaw_stiffness"):
            self.yaw_spring = YawSpring(stiffness=self.yaw_stiffness)
            self.connect(self.frame, self.yaw_spring.frame)

    def drawing(self) -> Drawing:
        return [shape for line in self.lines for shape in line.drawing()]

    def line_values(self, i: int) -> dict[str, Any]:
        """The parameters of line number i, counted from 0."""
        dynamics = "none" if self.dynamics == "lumped" else self.dynamics
        unused = MOVING if dynamics == "none" else ()
        names = (name for name in LINE_PROPERTIES if self._has(name) and name not in unused)
        properties = {name: self._of_line(name, i) for name in names}
        return {"anchor_position": self.layout()[i][1], "dynamics": dynamics, **properties}

    def layout(self) -> list[tuple[Any, Any]]:
        """Fairlead (in the frame of the body) and anchor (world) of each line."""
        headings, fairleads, anchors = (self._count(name) for name in ("headings", "fairleads", "anchors"))
        if headings and not (fairleads or anchors):
            for name in ("fairlead_radius", "fairlead_depth", "anchor_radius", "anchor_depth"):
                if not self._has(name):
                    raise ParameterError(f"{self.label}.{name} is needed with headings: {self.parameters[name].doc}")
            return [
                (
                    m.vertcat(self.fairlead_radius * c, self.fairlead_radius * s, -self.fairlead_depth),
                    m.vertcat(self.anchor_radius * c, self.anchor_radius * s, -self.anchor_depth),
                )
                for c, s in ((m.cos(self.headings[i]), m.sin(self.headings[i])) for i in range(headings))
            ]
        for name in ("fairlead_radius", "fairlead_depth", "anchor_radius", "anchor_depth"):
            if self._has(name) and not headings:
                raise ParameterError(f"{self.label}.{name} goes with headings, and there are none.")
        points = {np.shape(self.parameter_value(name)) for name in ("fairleads", "anchors")}
        if headings or points != {(fairleads, 3)}:
            raise ParameterError(
                f"{self.label} needs its layout once: give headings, or fairleads and anchors, lists of as many points."
            )
        ends = (self.fairleads, self.anchors)
        return [tuple(m.vertcat(*(end[i, k] for k in range(3))) for end in ends) for i in range(fairleads)]

    def _has(self, name: str) -> bool:
        return self.parameter_value(name) is not None

    def _count(self, name: str) -> int:
        return len(np.atleast_1d(self.parameter_value(name))) if self._has(name) else 0

    def _of_line(self, name: str, i: int) -> Any:
        value, shape = getattr(self, name), np.shape(self.parameter_value(name))
        if shape and shape[0] != len(self.layout()):
            raise ParameterError(f"{self.label}.{name} has {shape[0]} values for {len(self.layout())} lines; "
                                 "give one for all of them, or one for each.")
        return value[i] if shape else value

    def static_load(
        self, position: Sequence[float] = (0, 0, 0), gravity: float = 9.80665, water_density: float = 1025.0,
        water_depth: float | None = None,
    ) -> tuple[np.ndarray, list[dict[str, float]]]:  # fmt: skip
        """Force (3,) [N] of the lines on the body, whose frame is upright at `position`, and the state of each line.

        NumPy, for pre-processing: load-displacement curves, pretension, lift-off of the lines. water_depth [m]: of the
        seabed; None: that of the World of the model which the system is part of, and without one each anchor lies on
        the seabed.
        """
        if water_depth is None:
            root: Component = self
            while root._parent is not None:
                root = root._parent
            worlds = [part for part in root.walk() if isinstance(part, World)]
            water_depth = float(worlds[0].parameter_value("water_depth")) if worlds else -math.inf
        force, states = np.zeros(3), []
        for i, (fairlead, anchor) in enumerate(self.layout()):
            values = {name: float(np.asarray(self._of_line(name, i))) for name in LINE_PROPERTIES if self._has(name)}
            w = values.get("weight_per_length")
            if w is None:
                w = catenary.weight_in_water(values["mass_per_length"], values["diameter"], gravity, water_density)
            clearance = max(float(anchor[2]) + water_depth - LEVEL, 0.0)
            line = catenary.Line(values["length"], w, values["axial_stiffness"], values["friction"], clearance)
            reach = np.array([float(a) + b - float(c) for a, b, c in zip(fairlead, position, anchor, strict=True)])
            distance = float(np.hypot(reach[0], reach[1]))
            H, V = catenary.fairlead_tension(distance, reach[2], line)
            force -= [*(H * reach[:2] / max(distance, 1e-12)), V]
            grounded = float(catenary.state(catenary.catenary_tension(H, line), V, line).grounded)
            states.append({"horizontal": H, "vertical": V, "seabed_length": grounded})
        return force, states
