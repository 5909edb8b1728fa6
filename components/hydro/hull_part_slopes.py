"""How the strips of a part of a hull change with its diameters, its ends and its place: closed forms. NumPy.

Strips are a Gauss rule of the displaced volume: for each polynomial q of degree 2 n - 1 or less, sum_j w_j q(x_j) is
the integral of q. So for any change sum_j (dw_j q(x_j) + w_j q'(x_j) dx_j) is the change of that integral, and the
polynomials of Hermite, which are zero at all x_j with all slopes but one value or one slope, give each dx_j and dw_j.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fowtlib.components.hydro.hull_part import NEAR, Floats, HullPart, strip_marks, strip_rule

Tangent = Callable[[Any, str], Floats]
"""Changes (size, m) of the value of a parameter of a component; NaN where they are not known."""
ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class HullPartSlopes:
    """Changes along m directions, in which diameters (n, m), ends (m,), place (3, m) and C_a (m,) of a part change.

    NaN stands for a direction in which stations move, or an end that is on the still water level: there is a kink.
    """

    part: HullPart
    diameters: Floats
    low: Floats
    high: Floats
    position: Floats
    added: Floats

    @classmethod
    def along(cls, part: HullPart, component: Any, tangent: Tangent) -> HullPartSlopes:
        """Those of a part that a component says, where its parameters change by tangents."""
        names = ("low", "high", "added_mass_coefficient")
        low, high, added = (tangent(component, name).reshape(-1) for name in names)
        fixed = ~tangent(component, "heights").any(axis=0)
        if abs(part.high) < NEAR:
            fixed &= np.abs(high) <= ROUNDING * np.abs(part.heights[0])
        low = np.where(fixed, low, np.nan)
        return cls(part, tangent(component, "diameters"), low, np.where(part.high < -NEAR, high, 0.0),
                   tangent(component, "position"), added)  # fmt: skip

    @property
    def numbers(self) -> Floats:
        """Changes of the head of the part and of the rows of its strips, one after the other, (6 + 3 k, m)."""
        wet, (height, volume, drag), origin = self.part.wet, self._strips, self.position[2]
        total = wet.volume.sum()
        centre = wet.volume @ wet.height / total
        centre_moves = ((wet.height - centre) @ volume + wet.volume @ height) / total - origin
        width, moved = float(self.part.width(0.0)), self._widths(np.zeros(1), np.zeros((1, 1)))[0]
        keel = self._widths(np.array([self.part.low]), self.low[None])[0]
        plane = [np.pi / 2 * width * moved, np.pi / 16 * width**3 * moved]
        head = [volume.sum(axis=0), centre_moves, -origin, *plane, keel]
        rows = np.stack([height - origin, volume, drag], axis=1)
        return np.concatenate([np.broadcast_arrays(*head), rows.reshape(-1, rows.shape[-1])])

    @property
    def places(self) -> Floats:
        """Changes of the places of strips and keel, (3 k, m)."""
        z = self._heights
        x, y = (np.broadcast_to(self.position[i], z.shape) for i in range(2))
        return np.stack([x, y, z], axis=1).reshape(-1, z.shape[1])

    @property
    def widths(self) -> Floats:
        """Changes of the diameters there, (k, m)."""
        return self._widths(self.part.places[:, 2], self._heights)

    @property
    def _heights(self) -> Floats:
        height = self._strips[0]
        return np.concatenate([height, self.low[None]]) if self.part.keel else height

    def _widths(self, z: Floats, moved: Floats) -> Floats:
        """Changes (k, m) of the diameter at heights z (k,), which change by moved (k, m)."""
        heights, diameters = self.part.heights, self.part.diameters
        k = np.clip(np.searchsorted(heights, z, "right") - 1, 0, len(heights) - 2)
        length = heights[k + 1] - heights[k]
        upper = np.clip((z - heights[k]) / length, 0.0, 1.0)[:, None]
        slope = (diameters[k + 1] - diameters[k]) / length
        return (1 - upper) * self.diameters[k] + upper * self.diameters[k + 1] + slope[:, None] * moved

    @cached_property
    def _strips(self) -> tuple[Floats, Floats, Floats]:
        """Changes (k, m) of height, volume and drag area of the strips."""
        part, wet = self.part, self.part.wet
        marks, (x, w) = strip_marks(part.heights, part.low, min(part.high, 0.0)), strip_rule(part.count)
        ends = np.zeros((len(marks), len(self.low)))
        ends[0], ends[-1] = self.low, self.high
        size = len(x) * (len(marks) - 1)

        def between(at: Floats) -> tuple[Floats, Floats]:  # points, and lengths, of what is linear between two marks
            middle, half = (at[1:] + at[:-1])[:, None] / 2, (at[1:] - at[:-1])[:, None] / 2
            by = x.reshape(-1, *([1] * (at.ndim - 1)))
            shape = (size, *at.shape[1:])
            return (middle + half * by).reshape(shape), (half * w.reshape(by.shape)).reshape(shape)

        (z, length), (z_moves, length_moves) = between(marks), between(ends)
        width = part.width(z)
        volume = np.pi / 4 * width**2 * length
        width_moves = self._widths(z, z_moves)
        moves = np.pi / 4 * width[:, None] * (2 * length[:, None] * width_moves + width[:, None] * length_moves)
        values, slopes = _hermite(wet.height, z)
        by_value, by_slope = (values[i] @ moves + slopes[i] @ (volume[:, None] * z_moves) for i in range(2))
        height = by_slope / wet.volume[:, None]
        here = self._widths(wet.height, height) / part.width(wet.height)[:, None]
        return height, by_value, wet.drag_area[:, None] * (by_value / wet.volume[:, None] - here)


def _hermite(nodes: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Polynomials with one value of 1, or one slope of 1, at nodes (n,): values and slopes (2, n, q) at z (q,)."""
    count, there = len(nodes), z - nodes[:, None]
    lagrange, slope, own = np.ones((count, len(z))), np.zeros((count, len(z))), np.zeros((count, 1))
    for j in range(count):
        for k in range(count):
            if k != j:  # the product rule, factor by factor
                gap = nodes[j] - nodes[k]
                slope[j] = slope[j] * there[k] / gap + lagrange[j] / gap
                lagrange[j] = lagrange[j] * there[k] / gap
                own[j] += 1 / gap
    square, change = lagrange**2, 2 * lagrange * slope
    turned = 1 - 2 * own * there
    slopes = np.stack([turned * change - 2 * own * square, square + there * change])
    return np.stack([turned * square, there * square]), slopes
