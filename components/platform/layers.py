"""Coaxial cylinders and frusta above each other: volumes, moments, walls and fillings, in closed form.

For numbers and for expressions. z is measured upwards from the keel [m]. A frustum of the height h with the radii R_1
below and R_2 above has, about its foot,

    int A dz   = pi h (R_1^2 + R_1 R_2 + R_2^2) / 3
    int A z dz = pi h^2 (R_1^2 + 2 R_1 R_2 + 3 R_2^2) / 12
    int A z^2 dz = pi h^3 (R_1^2 + 3 R_1 R_2 + 6 R_2^2) / 30
    int pi R^4 / 4 dz = pi h (R_1^4 + R_1^3 R_2 + R_1^2 R_2^2 + R_1 R_2^3 + R_2^4) / 20
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from fowtlib.language import math as m


class Layer(NamedTuple):
    """A cylinder or frustum: z of its foot, its height above 0, diameters below and above [m]."""

    foot: Any
    height: Any
    lower: Any
    upper: Any


class Moments(NamedTuple):
    """Of a solid of revolution: volume [m^3], int A z dz [m^4], int A z^2 dz, int pi R^4/4 dz [m^5]; or of a mass."""

    amount: Any
    first: Any
    second: Any
    lateral: Any

    def __add__(self, other: Any) -> Moments:  # type: ignore[override]
        """Both together."""
        return Moments(*(a + b for a, b in zip(self, other, strict=True)))

    def __sub__(self, other: Moments) -> Moments:
        """The first without the second, which is a hole in it."""
        return Moments(*(a - b for a, b in zip(self, other, strict=True)))

    def times(self, factor: Any) -> Moments:
        """With a density [kg/m^3], or a share of it."""
        return Moments(*(factor * a for a in self))

    @property
    def centre(self) -> Any:
        """Z of the centre [m]."""
        return self.first / self.amount

    @property
    def across(self) -> Any:
        """Second moment about a horizontal axis at z = 0: of a mass its moment of inertia [kg m^2]."""
        return self.second + self.lateral

    @property
    def along(self) -> Any:
        """Second moment about the axis of revolution."""
        return 2 * self.lateral


NOTHING = Moments(0.0, 0.0, 0.0, 0.0)


def stack(heights: Sequence[Any], diameters: Sequence[tuple[Any, Any]]) -> list[Layer]:
    """Layers on top of each other from z = 0, each with its height and its diameters below and above [m]."""
    found, foot = [], 0.0
    for height, (lower, upper) in zip(heights, diameters, strict=True):
        found.append(Layer(foot, height, lower, upper))
        foot = foot + height
    return found


def thinner(layers: Iterable[Layer], wall: Any) -> list[Layer]:
    """What is within walls that are `wall` [m] thick, measured level."""
    return [layer._replace(lower=layer.lower - 2 * wall, upper=layer.upper - 2 * wall) for layer in layers]


def frustum(foot: Any, height: Any, lower: Any, upper: Any) -> Moments:
    """Moments of one frustum; lower, upper: diameters [m]."""
    a, b = lower / 2, upper / 2
    volume = m.pi * height * (a**2 + a * b + b**2) / 3
    first = m.pi * height**2 * (a**2 + 2 * a * b + 3 * b**2) / 12
    second = m.pi * height**3 * (a**2 + 3 * a * b + 6 * b**2) / 30
    lateral = m.pi * height * (a**4 + a**3 * b + a**2 * b**2 + a * b**3 + b**4) / 20
    return Moments(volume, foot * volume + first, foot**2 * volume + 2 * foot * first + second, lateral)


def up_to(layers: Sequence[Layer], level: Any) -> Moments:
    """Moments of what lies below a level z [m]; with kinks where the level passes from one layer to the next.

    Beyond the ends the layers go on as cylinders (below with a negative volume), so that a solver always has a slope:
    whoever uses it checks that the level lies within.
    """
    first, last = layers[0], layers[-1]
    above = m.fmax(level - last.foot - last.height, 0)
    below = m.fmax(first.foot - level, 0)
    total = frustum(last.foot + last.height, above, last.upper, last.upper)
    total = total - frustum(first.foot - below, below, first.lower, first.lower)
    for layer in layers:
        height = m.fmin(m.fmax(level - layer.foot, 0), layer.height)
        upper = layer.lower + (layer.upper - layer.lower) * height / layer.height
        total = total + frustum(layer.foot, height, layer.lower, upper)
    return total


def whole(layers: Iterable[Layer]) -> Moments:
    """Moments of all layers."""
    return sum((frustum(*layer) for layer in layers), NOTHING)


def diameter_at(layers: Sequence[Layer], level: Any) -> Any:
    """Outer diameter at a level z [m]; at a step that above, beyond the ends that of the end."""
    found = layers[0].lower
    for layer in layers:
        share = m.fmin(m.fmax(level - layer.foot, 0), layer.height) / layer.height
        found = m.if_else(level >= layer.foot, layer.lower + (layer.upper - layer.lower) * share, found)
    return found


def plate_added_mass(plate: Any, column: Any, density: Any = 1025.0) -> Any:
    """Added mass [kg] in heave of a plate of the diameter D_d at the foot of a column of the diameter D_s [m].

    rho/12 (2 D_d^3 + 3 pi D_d^2 zeta - pi^3 zeta^3 - 3 pi D_s^2 zeta), zeta = sqrt(D_d^2 - D_s^2)/pi; a form that is
    used with the name of L. Tao, B. Molin, Y.-M. Scolan and K. Thiagarajan (J. Fluids Struct. 23, 2007). Its limits: a
    free disc, rho D_d^3/3, for D_s = 0; half of it, rho D_d^3/6, for D_s = D_d. Of a plate below a wider base below a
    column it says nothing: D_s is then the designer's choice between both (see docs/sizing.md).
    """
    rim = m.sqrt(m.fmax(plate**2 - column**2, 0)) / m.pi
    return density / 12 * (
        2 * plate**3 + 3 * m.pi * plate**2 * rim - m.pi**3 * rim**3 - 3 * m.pi * column**2 * rim
    )  # fmt: skip


def disc_added_inertia(plate: Any, density: Any = 1025.0) -> Any:
    """Added moment of inertia [kg m^2] of a thin disc about its diameter, 16/45 rho (D/2)^5; Lamb (1932), art. 103."""
    return 16 / 45 * density * (plate / 2) ** 5
