"""Facts: what a component says of itself in `facts()`, for the sheet of a model. They carry no physics.

A body says where its mass is; anything may say a number, or name a variable whose value at rest people ask for. How
they are summed up is the business of fowtlib.analysis.sheet. Numbers are those of `parameter_value`, in SI.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Mass:
    """A rigid mass [kg] on a frame: centre (3,) from its origin, inertia (3, 3) about the centre, both in its axes."""

    frame: Any
    mass: float
    centre: ArrayLike = (0.0, 0.0, 0.0)
    inertia: ArrayLike = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, eq=False)
class Number:
    """A number or an array of a part, by a name that is the same for all parts of its sort, such as "volume"."""

    name: str
    value: ArrayLike
    unit: str = "1"


@dataclass(frozen=True)
class Reading:
    """A variable of a part, by its name there, whose value at rest belongs on the sheet, such as "tension"."""

    variable: str


@dataclass(frozen=True, eq=False)
class Loads:
    """A matrix (6, 6) between motion and load of a floating body, such as its stiffness: "C", "A(0)" or "A(inf)".

    Rows and columns: surge, sway, heave [m], roll, pitch, yaw [rad]; forces [N], moments [N m] about the frame. unit:
    of the part that belongs to two translations; the others have a m or m^2 more.
    """

    name: str
    matrix: ArrayLike
    unit: str


Fact = Mass | Number | Reading | Loads
