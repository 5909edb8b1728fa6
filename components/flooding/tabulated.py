"""A vessel of any shape, by its horizontal sections."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fowtlib.components.flooding.sections import Contents, Cornered
from fowtlib.language import math as m


@dataclass(frozen=True)
class Sections(Cornered):
    """Sections at `levels` (n,) above the floor, what is given of them linear between; for small slopes.

    areas (n,) [m^2]; firsts (n, 2): A x_c, A y_c [m^3]; seconds (n, 3): int x^2, int y^2, int x y [m^4], all about the
    axis. The water is that below the level h on the axis, and a wedge over the section at h, to the first order of the
    slope (its height to the second): exact where the walls there are vertical.
    """

    levels: Any
    areas: Any
    firsts: Any
    seconds: Any
    count: int

    @property
    def area(self) -> Any:
        """Of the uppermost section [m^2]."""
        return self.areas[self._last]

    @property
    def height(self) -> Any:
        """From floor to roof [m]."""
        return self.levels[self._last] - self.levels[0]

    @property
    def capacity(self) -> Any:
        """Volume up to the roof [m^3]."""
        return self._filled(self.levels[self._last], lambda i: self.areas[i], 1)[0]

    @property
    def _last(self) -> int:
        return self.count - 1

    def contents(self, h: Any, slope: tuple[Any, Any]) -> Contents:
        """What is under the surface."""
        (tx, ty), A = slope, lambda i: self.areas[i]
        xs, ys = (lambda i: self.firsts[i, 0]), (lambda i: self.firsts[i, 1])
        squares = [lambda i, k=k: self.seconds[i, k] for k in range(3)]
        volume, z, zz = self._filled(h, A, 3)
        (x, xz), (y, yz) = self._filled(h, xs, 2), self._filled(h, ys, 2)
        xx, yy, xy = (self._filled(h, of, 1)[0] for of in squares)
        X, Y, (XX, YY, XY) = self._at(h, xs), self._at(h, ys), (self._at(h, of) for of in squares)
        lifted, wx, wy = tx * X + ty * Y, tx * XX + ty * XY, tx * XY + ty * YY
        raised = (tx * wx + ty * wy) / 2
        first = m.vertcat(x - wx, y - wy, z - h * lifted + raised)
        xz, yz, zz = xz - h * wx, yz - h * wy, zz - h**2 * lifted + 2 * h * raised
        rows = m.horzcat(xx, xy, xz), m.horzcat(xy, yy, yz), m.horzcat(xz, yz, zz)
        return Contents(volume - lifted, first, m.vertcat(*rows))

    def upright(self, h: Any) -> tuple[Any, Any]:
        """First moments (x, y) [m^4] under a surface without slope."""
        return tuple(self._filled(h, lambda i, k=k: self.firsts[i, k], 1)[0] for k in range(2))

    def lift(self, slope: tuple[Any, Any]) -> Any:
        """How far the water goes above the height of the surface on the axis [m]: not at all, to first order."""
        return 0.0

    def _filled(self, h: Any, of: Any, count: int) -> tuple[Any, ...]:
        """Integrals from the floor to h of a quantity of the section times 1, z, z^2."""
        total: list[Any] = [0.0] * count
        for i in range(self._last):
            low, high = self.levels[i], self.levels[i + 1]
            s = m.fmin(m.fmax(h - low, 0), high - low)
            slope = (of(i + 1) - of(i)) / (high - low)
            start = of(i)
            p = [s, s**2 / 2, s**3 / 3, s**4 / 4]
            over = [start * p[k] + slope * p[k + 1] for k in range(count)]  # with z from the lower section
            lifts = [over[0], *([over[1] + low * over[0]] if count > 1 else ())]
            if count > 2:
                lifts.append(over[2] + 2 * low * over[1] + low**2 * over[0])
            total = [a + b for a, b in zip(total, lifts, strict=True)]
        return tuple(total)

    def _at(self, h: Any, of: Any) -> Any:
        """A quantity of the section at h."""
        value = of(0)
        for i in range(self._last):
            low, high = self.levels[i], self.levels[i + 1]
            value = value + m.fmin(m.fmax((h - low) / (high - low), 0), 1) * (of(i + 1) - of(i))
        return value
