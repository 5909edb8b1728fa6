"""Shapes: what a component says of its looks in `drawing()`, for pictures and animations. They carry no physics.

A shape rides on a frame (a Frame port of a component, or a `Turned` one); None is the world. Lengths are in m, points
are resolved in the frame. `material` is one of MATERIALS and decides about the colour. Sizes that are None are chosen
by the picture, in proportion to what it shows. How shapes become triangles is the business of fowtlib.view.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language.errors import ParameterError

MATERIALS = ("structure", "hull", "tower", "nacelle", "blade", "line", "rod", "body", "glass", "water")
"""What a shape looks like; glass is a hull that is seen through."""


@dataclass(frozen=True)
class Turned:
    """A frame turned against another by factor * angle about an axis through its origin.

    angle: path of a variable [rad]; axis (3,), of any length, resolved in `frame`.
    """

    frame: Any
    axis: tuple[float, float, float]
    angle: str
    factor: float = 1.0


@dataclass(frozen=True, eq=False)
class Carried:
    """A frame at a point of a body that deforms: moved and turned against another by what variables say, linearly.

    point (3,): where it is without them; of: paths of n variables; displacement, turn (3, n) [rad]: per variable, turns
    small. All are resolved in `frame`.
    """

    frame: Any
    point: tuple[float, float, float]
    of: tuple[str, ...]
    displacement: np.ndarray
    turn: np.ndarray


@dataclass(frozen=True, eq=False)
class Shape:
    """Partial: a rigid shape on a frame."""

    frame: Any
    material: str = field(default="structure", kw_only=True)

    def __post_init__(self) -> None:
        if self.material not in MATERIALS:
            raise ParameterError(f"a shape is made of {', '.join(MATERIALS)}, not of '{self.material}'.")
        for name in self._arrays:
            values = np.asarray(getattr(self, name), dtype=float)
            if not np.all(np.isfinite(values)):
                raise ParameterError(f"{type(self).__name__} on {self.frame}: {name} has a value that is not finite.")
            object.__setattr__(self, name, values)

    _arrays = ()


@dataclass(frozen=True, eq=False)
class Tube(Shape):
    """A round member: points (n, 3) along its axis, with a diameter at each (n,); None: one chosen by the picture."""

    points: ArrayLike
    diameters: ArrayLike | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        points = np.asarray(self.points, dtype=float)
        if points.ndim != 2 or points.shape[0] < 2 or points.shape[1] != 3 or not np.all(np.isfinite(points)):
            raise ParameterError(f"a tube on {self.frame} needs two points or more, of three coordinates each.")
        object.__setattr__(self, "points", points)
        if self.diameters is not None:
            diameters = np.asarray(self.diameters, dtype=float)
            if diameters.shape not in ((), (len(points),)) or not np.all(diameters >= 0):
                raise ParameterError(f"a tube on {self.frame}: {diameters.size} diameters for {len(points)} points.")
            object.__setattr__(self, "diameters", np.broadcast_to(diameters, len(points)))


@dataclass(frozen=True, eq=False)
class Box(Shape):
    """A box with its edges along the axes of the frame: centre (3,) and lengths of the edges (3,)."""

    centre: ArrayLike
    size: ArrayLike
    _arrays = ("centre", "size")


@dataclass(frozen=True, eq=False)
class Ball(Shape):
    """A sphere: centre (3,) and diameter."""

    centre: ArrayLike = (0.0, 0.0, 0.0)
    diameter: float | None = None
    _arrays = ("centre",)


@dataclass(frozen=True, eq=False)
class Loft(Shape):
    """A skin over sections (n, k, 3), closed lines of k points each in the same order: a blade.

    closed: with a cap at both ends; a piece that others go on from needs none.
    """

    sections: ArrayLike
    closed: bool = True
    _arrays = ("sections",)


@dataclass(frozen=True, eq=False)
class Curve:
    """A line in the world whose form changes: points(values) gives its n points at all moments, (n_time, n, 3).

    of: what it depends on, by the names under which `points` finds it: a frame, whose position (n_time, 3) it gets, or
    the path of a scalar variable (n_time,).
    """

    of: Mapping[str, Any]
    points: Callable[[Mapping[str, Any]], np.ndarray]
    diameter: float | None = None
    material: str = "line"


@dataclass(frozen=True, eq=False)
class Arrow:
    """An arrow in the world with its tip at `tip`, along `direction`; its length is scale [m per unit] times `value`.

    value: path of a scalar variable. bearing: path of the angle [rad] about z, from x, along which it points now; then
    it is level, and direction is where it starts.
    """

    tip: tuple[float, float, float]
    direction: tuple[float, float, float]
    value: str
    scale: float = 1.0
    bearing: str = ""


@dataclass(frozen=True, eq=False)
class Water:
    """The sea: still water level z = 0 over a flat bed at z = -depth, and its long-crested waves, arrays (n,).

    elevation(x, y, t) = sum_k amplitude cos(omega t - wave_number (x cos(heading) + y sin(heading)) + phase); within
    `build_up` [s] it grows from nothing as 10 s^3 - 15 s^4 + 6 s^5.
    """

    depth: float
    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    wave_number: np.ndarray
    heading: float = 0.0
    build_up: float = 0.0


Drawn = Shape | Curve | Arrow | Water
Drawing = Sequence[Drawn]


def link(frame_a: Any, frame_b: Any, diameter: float | None = None, material: str = "rod") -> Curve:
    """A straight line between the origins of two frames: a spring, a cable, a slide."""
    return Curve({"a": frame_a, "b": frame_b}, lambda at: np.stack([at["a"], at["b"]], axis=1), diameter, material)


def rod(frame: Any, end: Any, diameter: float | None = None) -> list[Shape]:
    """A rod from the origin of the frame to `end`; nothing where its length or the given diameter is zero."""
    end = np.asarray(end, dtype=float)
    if diameter == 0 or not np.any(end):
        return []
    return [Tube(frame, np.array([np.zeros(3), end]), diameter, material="rod")]
