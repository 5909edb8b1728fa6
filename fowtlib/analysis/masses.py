"""The bodies of a model where they are at a state: masses, centres and inertia in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language import facts
from fowtlib.language.declarations import join


@dataclass(frozen=True, eq=False)
class Placed:
    """A body of the part at `path`: mass [kg], centre (3,) [m] and inertia (3, 3) [kg m^2] about it, world."""

    path: str
    mass: float
    centre: np.ndarray
    inertia: np.ndarray


def placed_bodies(bodies: Sequence[tuple[Any, facts.Mass]], state: Any) -> list[Placed]:
    """Bodies with the parts that tell of them, where their frames are at a state."""
    frames = state.values([join(body.frame.path, name) for _, body in bodies for name in ("r", "R")])
    found = []
    for (part, body), origin, R in zip(bodies, frames[::2], frames[1::2], strict=True):
        centre = origin + R @ np.asarray(body.centre, dtype=float)
        found.append(Placed(part.path, float(body.mass), centre, R @ np.asarray(body.inertia, dtype=float) @ R.T))
    return found


def centre_of_mass(bodies: Sequence[Placed]) -> tuple[float, np.ndarray]:
    """Mass of all, and their centre (3,); zeros where nothing has a mass."""
    mass = sum(body.mass for body in bodies)
    moment = sum((body.mass * body.centre for body in bodies), np.zeros(3))
    return mass, moment / mass if mass else moment
