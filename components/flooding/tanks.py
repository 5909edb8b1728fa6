"""Tanks by their shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from fowtlib.components.flooding import sloshing
from fowtlib.components.flooding.rings import refuse_inside_out
from fowtlib.components.flooding.sections import Box, Disc, Wedge
from fowtlib.components.flooding.tabulated import Sections
from fowtlib.components.flooding.tank import Tank
from fowtlib.components.flooding.waterline import waterline
from fowtlib.language import Array, Scalar, assert_, param, shapes
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


class BoxTank(Tank):
    """A tank with a rectangular section, walls along the axes of its frame; exact also where floor or roof is bare."""

    length: Scalar = param(unit="m", min=1e-6, doc="inside, along x of the frame")
    width: Scalar = param(unit="m", min=1e-6, doc="inside, along y of the frame")
    height: Scalar = param(unit="m", min=1e-6, doc="from floor to roof")
    walls_wet: bool = param(default=False, doc="floor and roof are never bare, which is checked: far fewer operations")

    def vessel(self):
        a, b = self.length, self.width
        if not self.walls_wet:
            return Box(a, b, self.height)
        return Wedge(a * b, (a**3 * b / 12, a * b**3 / 12, 0.0), self.height, (a / 2, b / 2))

    def modes(self, density: Any):
        depth, g = self.volume / (self.length * self.width), self.world.gravity
        along_x = sloshing.box_mode(self.length, self.width, depth, density, g)
        return along_x, sloshing.box_mode(self.width, self.length, depth, density, g)

    def first_mode_share(self):
        return sloshing.BOX

    def drawing(self) -> shapes.Drawing:
        size = np.array([float(self.parameter_value(name)) for name in ("length", "width", "height")])
        middle = np.ravel(self.parameter_value("place")) + (0, 0, size[2] / 2)
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) / 2 * size[:2]
        return [shapes.Box(self.frame, middle, size, material="body"), waterline(self, corners)]


class RoundTank(Tank):
    """A tank with a round section, or a ring around a shaft where it has an inner diameter.

    Where floor or roof is bare volumes are found by strips of the section: see fowtlib.components.flooding.sections.
    """

    diameter: Scalar = param(unit="m", min=1e-6, doc="inside, of the outer wall")
    inner_diameter: Scalar = param(default=None, unit="m", min=0, doc="of the inner wall of a ring; without: none")
    height: Scalar = param(unit="m", min=1e-6, doc="from floor to roof")
    walls_wet: bool = param(default=False, doc="floor and roof are never bare, which is checked: far fewer operations")

    def build(self):
        super().build()
        if self.is_set("inner_diameter"):
            refuse_inside_out(self, "inner_diameter", "diameter")

    def vessel(self):
        ring = self.is_set("inner_diameter")
        disc = Disc(self.diameter / 2, self.inner_diameter / 2 if ring else 0.0, self.height, ring)
        if not self.walls_wet:
            return disc
        return Wedge(disc.area, (disc.moment, disc.moment, 0.0), self.height, (disc.radius, disc.radius))

    def modes(self, density: Any):
        radius = self.diameter / 2
        mode = sloshing.round_mode(radius, self.volume / (m.pi * radius**2), density, self.world.gravity)
        return mode, mode

    def first_mode_share(self):
        return super().first_mode_share() if self.is_set("inner_diameter") else sloshing.ROUND

    def drawing(self) -> shapes.Drawing:
        floor, height = np.ravel(self.parameter_value("place")), float(self.parameter_value("height"))
        ends = np.array([floor, floor + (0, 0, height)])
        diameter, turn = float(self.parameter_value("diameter")), np.linspace(0, 2 * np.pi, 37)
        ring = diameter / 2 * np.column_stack([np.cos(turn), np.sin(turn)])
        return [shapes.Tube(self.frame, ends, [diameter] * 2, material="body"), waterline(self, ring)]


class PrismaticTank(Tank):
    """A tank of one section of any form with two axes of symmetry, which must be wet on all walls below its roof.

    half_length and half_width: how far the section reaches along x and y; the run stops where the surface could meet
    floor or roof there.
    """

    area: Scalar = param(unit="m^2", min=1e-9, doc="area of the section")
    second_moments: Array = param(
        unit="m^4", shape=(3,), doc="int x^2, int y^2, int x y over the section, about its middle"
    )
    half_length: Scalar = param(unit="m", min=0, doc="greatest |x| of the section")
    half_width: Scalar = param(unit="m", min=0, doc="greatest |y| of the section")
    height: Scalar = param(unit="m", min=1e-6, doc="from floor to roof")

    def vessel(self):
        moments = tuple(self.second_moments[i] for i in range(3))
        return Wedge(self.area, moments, self.height, (self.half_length, self.half_width))


class TabulatedTank(Tank):
    """A tank of any shape by its horizontal sections, for tilts up to `steepest`: linear in the tilt.

    levels [m], from 0, the floor; areas, first and second moments of the sections about the axis, linear between them.
    """

    levels: Array = param(unit="m", min=0, doc="heights (n,) of the sections above the floor, from 0 upwards")
    areas: Array = param(unit="m^2", min=1e-9, doc="area (n,) of each section")
    second_moments: Array = param(unit="m^4", doc="int x^2, int y^2, int x y (n, 3) of each section, about the axis")
    first_moments: Array = param(
        default=lambda self: np.zeros((np.size(self.parameter_value("levels")), 2)),
        unit="m^3", shape=lambda self: (np.size(self.parameter_value("levels")), 2),
        doc="area times centroid x, y (n, 2) of each section, about the axis",
    )  # fmt: skip
    steepest: Scalar = param(default="10 deg", unit="rad", min=0, max=0.5, doc="tilt up to which the table holds")

    def build(self):
        super().build()
        levels = np.ravel(self.parameter_value("levels"))
        if len(levels) < 2 or levels[0] != 0 or np.any(np.diff(levels) <= 0):
            raise ParameterError(f"{self.label}.levels must begin with 0 and rise; they are {levels.tolist()}.")
        for name, shape in (("areas", (len(levels),)), ("second_moments", (len(levels), 3))):
            if np.shape(self.parameter_value(name)) != shape:
                raise ParameterError(f"{self.label}.{name} must have the shape {shape}, a row for each level.")

    def vessel(self):
        count = np.size(self.parameter_value("levels"))
        return Sections(self.levels, self.areas, self.first_moments, self.second_moments, count)

    def start_level(self):
        volume, levels, areas = (np.ravel(self.parameter_value(k)) for k in ("volume_start", "levels", "areas"))
        filled = np.concatenate([[0.0], np.cumsum((areas[1:] + areas[:-1]) / 2 * np.diff(levels))])
        return float(np.interp(volume[0], filled, levels))

    def start_height(self):
        levels, areas = (np.ravel(self.parameter_value(k)) for k in ("levels", "areas"))
        z = np.linspace(0, max(self.start_level(), 1e-9), 1001)
        area = np.interp(z, levels, areas)
        return float(np.trapezoid(area * z, z) / np.trapezoid(area, z))

    def equations(self):
        up = self.frame.R.T @ m.vertcat(0, 0, 1)
        return [
            *super().equations(),
            assert_(up[2] > m.cos(self.steepest), "the tank is tilted by {tilt} rad, more than steepest, up to which "
                    "its table of sections holds", tilt=m.acos(m.fmin(up[2], 1))),
        ]  # fmt: skip
