"""Water in a vessel of constant section under a plane surface: volume and moments, in axes whose z is along the vessel.

The surface is z = h - t.x - t.y, where h is its height on the axis of the vessel and t = (k_x, k_y) / k_z the slope of
a level plane when k is the vertical, resolved in the vessel. Water fills the vessel between its floor z = 0 and its
roof z = H: the column over a point of the section is u = h - t.(x, y), held between 0 and H. With the plus function
(u)+ = max(u, 0) and v = u - H powers of a column are sums of powers of (u)+ and (v)+ (`_columns`), and integrals of
these over a strip of the section, between the place where the surface meets its floor and the end of the strip, are
polynomials of that place. Nothing is divided by a small number, whatever the slope.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language import math as m

Sum = tuple[Any, ...]  # what _strips gives
_ODD_IN_Y = (2, 4, 8)  # of these integrals
NOTHING = 1e-9  # of the capacity: below it a vessel is empty, and that far from it full


@dataclass(frozen=True)
class Contents:
    """volume [m^3], first moments (3,) [m^4] and second moments (3, 3) [m^5] about the middle of the floor."""

    volume: Any
    first: Any
    second: Any


@dataclass(frozen=True)
class Wedge:
    """A vessel of any section in which the surface meets all walls: exact where the section has two axes of symmetry.

    area [m^2]; moments: second moments of area (I_xx = int x^2, I_yy = int y^2, I_xy = int x y) [m^4] about its middle;
    reach: how far the section goes along x and along y [m].
    """

    area: Any
    moments: tuple[Any, Any, Any]
    height: Any
    reach: tuple[Any, Any]

    @property
    def capacity(self) -> Any:
        """Volume up to the roof [m^3]."""
        return self.area * self.height

    def contents(self, h: Any, slope: tuple[Any, Any]) -> Contents:
        """What is under the surface; nothing is held at floor or roof."""
        xx, yy, xy = self.moments
        tilted = xx * slope[0] + xy * slope[1], xy * slope[0] + yy * slope[1]
        raised = tilted[0] * slope[0] + tilted[1] * slope[1]
        x_z, y_z, z_z = -h * tilted[0], -h * tilted[1], self.area * h**3 / 3 + h * raised
        first = m.vertcat(-tilted[0], -tilted[1], (self.area * h**2 + raised) / 2)
        rows = m.horzcat(h * xx, h * xy, x_z), m.horzcat(h * xy, h * yy, y_z), m.horzcat(x_z, y_z, z_z)
        return Contents(self.area * h, first, m.vertcat(*rows))

    def lift(self, slope: tuple[Any, Any]) -> Any:
        """How far the surface is above its height on the axis at the highest wall [m]."""
        return m.abs(slope[0]) * self.reach[0] + m.abs(slope[1]) * self.reach[1]


class Cornered:
    """Partial: a vessel that knows what it holds where its floor or its roof is bare."""

    capacity: Any

    def lift(self, slope: tuple[Any, Any]) -> Any:
        """How far the surface is above its height on the axis at the highest wall [m]."""
        raise NotImplementedError

    def upright(self, h: Any) -> tuple[Any, Any]:
        """First moments (x, y) [m^4] under a surface without slope."""
        return 0.0, 0.0

    def settled(self, held: Contents, h: Any, volume: Any) -> Contents:
        """Without what a surface shifts sideways where there is none: in an empty and in a full vessel.

        Over 1e-9 of the capacity, so that a linear model of such a tank in an upright body knows it.
        """
        least, wet, room = NOTHING * self.capacity, m.fmax(volume, 0), m.fmax(self.capacity - volume, 0)
        share = wet / (wet + least) * room / (room + least)
        x, y = (still + share * (held.first[i] - still) for i, still in enumerate(self.upright(h)))
        return Contents(held.volume, m.vertcat(x, y, held.first[2]), held.second)


@dataclass(frozen=True)
class Box(Cornered):
    """A vessel with a rectangular section, length along x, width along y; exact also where floor or roof is bare."""

    length: Any
    width: Any
    height: Any

    @property
    def area(self) -> Any:
        """Area of the section [m^2]."""
        return self.length * self.width

    @property
    def capacity(self) -> Any:
        """Volume up to the roof [m^3]."""
        return self.area * self.height

    def contents(self, h: Any, slope: tuple[Any, Any]) -> Contents:
        """What is under the surface between floor and roof."""
        return _columns(self._plus(h, slope), self._plus(h - self.height, slope), self.height)

    def lift(self, slope: tuple[Any, Any]) -> Any:
        """How far the surface is above its height on the axis at the highest wall [m]."""
        return m.abs(slope[0]) * self.length / 2 + m.abs(slope[1]) * self.width / 2

    def _plus(self, u0: Any, slope: tuple[Any, Any]) -> Sum:
        """Integrals of the plus function over the rectangle.

        Along y the integral over a strip is a polynomial between the places where the edge of the water passes a
        corner line x = +-length / 2; points of Gauss are exact for each of the three pieces.
        """
        half, side = self.length / 2, self.width / 2
        corners = [_held((u0 - slope[0] * x) / _not_zero(slope[1]), side) for x in (-half, half)]
        ends = (-side, m.fmin(*corners), m.fmax(*corners), side)
        total: Sum = (0.0,) * 10
        for piece, count in enumerate((2, 3, 2)):  # of the outer two each strip is wet or dry as a whole: degree 3
            low, high = ends[piece], ends[piece + 1]
            for node, weight in zip(*(a.tolist() for a in np.polynomial.legendre.leggauss(count)), strict=True):
                y, width = (low + high) / 2 + node * (high - low) / 2, weight * (high - low) / 2
                u = u0 - slope[1] * y
                strip = _part(u, -slope[0], half) if piece == 1 else _whole(u, -slope[0], half)
                total = _added(total, strip, y, width)
        return total


@dataclass(frozen=True)
class Disc(Cornered):
    """A vessel with a round section, or a ring where it has an inner radius.

    Strips lie along the slope, at the points of Gauss and Chebyshev (second kind), exact where the surface meets all
    walls. Where floor or roof is bare, what `strips` leave out is below 1e-3 of the volume that is above or below the
    bare part.
    """

    radius: Any
    inner: Any
    height: Any
    ring: bool = False
    strips: int = 16

    @property
    def area(self) -> Any:
        """Area of the section [m^2]."""
        return m.pi * (self.radius**2 - (self.inner**2 if self.ring else 0.0))

    @property
    def moment(self) -> Any:
        """Second moment of area about a diameter [m^4]."""
        return m.pi / 4 * (self.radius**4 - (self.inner**4 if self.ring else 0.0))

    @property
    def capacity(self) -> Any:
        """Volume up to the roof [m^3]."""
        return self.area * self.height

    def contents(self, h: Any, slope: tuple[Any, Any]) -> Contents:
        """What is under the surface between floor and roof."""
        x, y = slope[0] + 1e-9, slope[1]  # so that its direction exists; what is left across it matters at the upright
        steepness = m.sqrt(x**2 + y**2)
        c, s = x / steepness, y / steepness
        along = c * slope[0] + s * slope[1], 0.0
        found = _columns(self._plus(h, along), self._plus(h - self.height, along), self.height)
        left = (s * slope[0] - c * slope[1]) * m.if_else(h * (self.height - h) > 0, self.moment, 0)
        found = _lifted(found, left, h)
        turn = m.vertcat(m.horzcat(c, -s, 0), m.horzcat(s, c, 0), m.horzcat(0, 0, 1))
        return Contents(found.volume, turn @ found.first, turn @ found.second @ turn.T)

    def lift(self, slope: tuple[Any, Any]) -> Any:
        """How far the surface is above its height on the axis at the highest wall [m]."""
        return self.radius * m.smooth_norm(m.vertcat(*slope), 1e-9)

    def _plus(self, u0: Any, slope: tuple[Any, Any]) -> Sum:
        found = _strips(u0, slope, self._chords(self.radius))
        if self.ring:
            hole = _strips(u0, slope, self._chords(self.inner))
            found = tuple(a - b for a, b in zip(found, hole, strict=True))
        return tuple(0.0 if i in _ODD_IN_Y else a for i, a in enumerate(found))

    def _chords(self, radius: Any) -> Iterable[tuple[Any, Any, Any]]:
        """Strips of one half, twice as wide: the other half is its mirror image, and what is odd in y cancels."""
        step = np.pi / (self.strips + 1)
        for i in range(1, self.strips // 2 + 1):
            y, half = np.cos(i * step), np.sin(i * step)
            yield radius * float(y), 2 * radius * float(step * half), radius * float(half)


def _lifted(held: Contents, moment: Any, h: Any) -> Contents:
    """With the first moment of a wedge along y, over all of a section at height h."""
    z = m.zeros(3, 3)
    z[1, 2] = z[2, 1] = h * moment
    return Contents(held.volume, held.first + m.vertcat(0, moment, 0), held.second + z)


Strip = tuple[Any, Any, Any, Any, Any, Any]  # integrals of u, x u, x^2 u, u^2, x u^2, u^3 over what is wet of it


def _whole(u: Any, s: Any, half: Any) -> Strip:
    """Of a strip from -half to half with the column u + s x, which is wet where its middle is."""
    wet = m.if_else(u > 0, 2 * half, 0)
    square = wet * half**2 / 3
    one, x, xx = wet * u, square * s, square * u
    return one, x, xx, u * one + s * x, 2 * u * x, u * (u * one + s * x) + 2 * s * u * x


def _part(u: Any, s: Any, half: Any) -> Strip:
    """Of a strip that may be wet in part."""
    steep = _not_zero(s)
    edge = _held(-u / steep, half)
    low, high = m.if_else(steep > 0, edge, -half), m.if_else(steep > 0, half, edge)
    p = [0.0] + [(high**n - low**n) / n for n in range(1, 5)]  # p[n]: integral of x^(n - 1)
    one, x, xx = u * p[1] + s * p[2], u * p[2] + s * p[3], u * p[3] + s * p[4]
    square, x_square = u * one + s * x, u * x + s * xx
    return one, x, xx, square, x_square, u * square + s * x_square


def _added(total: Sum, strip: Strip, y: Any, width: Any) -> Sum:
    """With a strip at y: integrals of (u)+ times 1, x, y, x^2, x y, y^2; of (u)+^2 times 1, x, y; and of (u)+^3."""
    one, x, xx, square, x_square, cube = strip
    each = (one, x, y * one, xx, y * x, y * y * one, square, x_square, y * square, cube)
    return tuple(a + width * b for a, b in zip(total, each, strict=True))


def _strips(u0: Any, slope: tuple[Any, Any], strips: Iterable[tuple[Any, Any, Any]]) -> Sum:
    """The sum over strips (y, width, half length)."""
    total: Sum = (0.0,) * 10
    for y, width, half in strips:
        total = _added(total, _part(u0 - slope[1] * y, -slope[0], half), y, width)
    return total


def _columns(u: Sum, v: Sum, height: Any) -> Contents:
    """Volume and moments from the integrals of (u)+ and of (v)+, v = u - height.

    A column c is u between 0 and H, and H above: c = (u)+ - (v)+, c^2 = (u)+^2 - (v)+^2 - 2 H (v)+ and
    c^3 = (u)+^3 - (v)+^3 - 3 H (v)+^2 - 3 H^2 (v)+.
    """
    volume, x, y, xx, xy, yy = (a - b for a, b in zip(u[:6], v[:6], strict=True))
    z, xz, yz = ((u[6 + i] - v[6 + i] - 2 * height * v[i]) / 2 for i in range(3))
    zz = (u[9] - v[9] - 3 * height * v[6] - 3 * height**2 * v[0]) / 3
    rows = m.horzcat(xx, xy, xz), m.horzcat(xy, yy, yz), m.horzcat(xz, yz, zz)
    return Contents(volume, m.vertcat(x, y, z), m.vertcat(*rows))


def _not_zero(slope: Any) -> Any:
    """A slope to divide by: one below 1e-12 is 1e-12, which lifts no point of a vessel by more than the rounding."""
    return m.if_else(m.abs(slope) > 1e-12, slope, 1e-12)


def _held(x: Any, limit: Any) -> Any:
    """X, not beyond +-limit."""
    return m.fmax(-limit, m.fmin(limit, x))
