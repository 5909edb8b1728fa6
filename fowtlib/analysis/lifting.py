"""Raising a tower by the water in its shaft, quasi-statically: balance and stability for every place on its way.

Nothing is modelled anew: masses, centres and levels are those of the compiled model at states with the tower at s, the
water in the shaft with which it floats there, and the rest of the water in the tanks. The shaft then holds V(s) = A_s s
+ (A_s - A_c) d, d = m/(rho A_c), for a tower and cylinder of the mass m, so that dV/ds = A_s.

GM is that of a small lean theta: (C theta - g sum(m x)) / (rho g V_d theta), with the stiffness C of the water outside
about the frame of the hull, buoyancy included, and the distances x by which all masses have gone aside, water with its
level surfaces too. The loss by free surfaces is in it, moorings are not; of roll and pitch it is the smaller one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fowtlib.analysis.masses import placed_bodies
from fowtlib.components.flooding import FloatingPiston, Tank
from fowtlib.components.mechanics import FreeMotion, Prismatic
from fowtlib.language import facts
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError

Floats = NDArray[np.float64]
LEAN = 5e-3  # rad


@dataclass(frozen=True, eq=False)
class Stroke:
    """A tower on its way: arrays (n,) over its places, and what does not change.

    position [m] of the foot above the floor; metacentric_height [m]; shaft_volume and tank_volume [m^3]; level [m] of
    the water in the shaft above its floor; centre_of_mass [m], over the frame of the hull. lifted_mass [kg]: tower and
    cylinder; immersion [m] with which they float, of a cylinder of `cylinder_height`; excess [kg]: all masses less what
    the hull displaces, which moorings or a change of draft must carry.
    """

    position: Floats
    metacentric_height: Floats
    shaft_volume: Floats
    tank_volume: Floats
    level: Floats
    centre_of_mass: Floats
    lifted_mass: float
    immersion: float
    cylinder_height: float
    excess: float

    def check(self, least: float = 1.0) -> None:
        """Raises ModelError where the cylinder is too small, the tanks run dry, or GM is below `least` [m]."""
        if self.immersion > self.cylinder_height:
            raise ModelError(
                f"the flotation cylinder is too small: {self.lifted_mass:.6g} kg float on it at {self.immersion:.4g} "
                f"m, and it is {self.cylinder_height:.4g} m high. Make it wider or higher, or what it lifts lighter."
            )
        if (self.tank_volume < 0).any():
            raise ModelError(
                f"the tanks run dry when the tower is at s = {self._crossing(self.tank_volume, 0.0):.4g} m: the "
                f"whole way takes {-self.tank_volume.min():.4g} m3 more than there is. Give them more water."
            )
        if (self.metacentric_height < least).any():
            low, worst = self.metacentric_height < least, int(np.argmin(self.metacentric_height))
            first = self.position[0] if low[0] else self._crossing(self.metacentric_height, least)
            turns = ""
            if (self.metacentric_height < 0).any():
                turns = f" From s = {self._crossing(self.metacentric_height, 0.0):.4g} m on the floater turns over."
            raise ModelError(
                f"GM is below {least:.4g} m from s = {first:.4g} m on, and {self.metacentric_height[worst]:.4g} m at "
                f"s = {self.position[worst]:.4g} m.{turns} Put mass lower, or widen the waterplane."
            )

    def _crossing(self, values: Floats, level: float) -> float:
        """The first place at which values pass a level."""
        sign = np.flatnonzero(np.diff(np.sign(values - level)))
        if not sign.size:
            return float(self.position[0])
        k = int(sign[0])
        share = (level - values[k]) / (values[k + 1] - values[k])
        return float(self.position[k] + share * (self.position[k + 1] - self.position[k]))


def stroke(
    plant: Any, top: float, bottom: float = 0.0, *, count: int = 26, parameters: Mapping[str, Any] | None = None
) -> Stroke:
    """The way of a tower from `bottom` to `top` [m above the floor of its shaft], of a compiled model.

    The model has one FloatingPiston, tanks for the rest of the water, one FreeMotion, and one hull that floats; all
    water of the start counts. Raises ModelError where something of that is missing. See Stroke.check for the limits.
    """
    tower = _Tower(plant, parameters)
    places = np.linspace(bottom, top, count)
    rows = [tower.at(float(s)) for s in places]
    height, shaft, tanks, level, centre = (np.array([row[k] for row in rows]) for k in range(5))
    return Stroke(
        places, height, shaft, tanks, level, centre, tower.lifted, tower.immersion, tower.height, tower.excess
    )


class _Tower:
    """What a model says of its tower, shaft and hull."""

    def __init__(self, plant: Any, parameters: Mapping[str, Any] | None):
        self.plant, self.parameters = plant, parameters
        root = plant.at(parameters).binding.root
        self.piston, self.motion = _only(root, FloatingPiston), _only(root, FreeMotion)
        self.tanks = [part for part in root.walk() if isinstance(part, Tank)]
        self.slide = next(part for part in root.walk() if isinstance(part, Prismatic))
        if not self.tanks:
            raise ModelError(f"{plant.name}: the water of {self.piston.path} comes from a tank, and there is none.")
        told = [(part, fact) for part in root.walk() for fact in part.facts()]
        water = (self.piston, *self.tanks)  # whose masses are those of a state, not of the start
        self.bodies = [(part, fact) for part, fact in told if isinstance(fact, facts.Mass) and part not in water]
        hulls = [(part, fact) for part, fact in told if isinstance(fact, facts.Loads) and fact.name == "C"]
        if len(hulls) != 1:
            raise ModelError(f"{plant.name}: it has {len(hulls)} hulls with a linear stiffness; this asks for one.")
        self.hull, self.stiffness = hulls[0][0], np.asarray(hulls[0][1].matrix, dtype=float)
        numbers = {fact.name: fact.value for part, fact in told if part is self.hull and isinstance(fact, facts.Number)}
        self.density = float(self.hull.world.parameter_value("water_density"))
        self.gravity = float(self.hull.world.parameter_value("gravity"))
        self.displaced = self.density * float(np.asarray(numbers["displaced volume"]))
        self._balance()

    def _balance(self) -> None:
        number = {name: float(self.piston.parameter_value(name)) for name in ("diameter", "piston_diameter")}
        self.section, self.cylinder = (np.pi / 4 * d**2 for d in number.values())
        self.height = float(self.piston.parameter_value("piston_height"))
        first = self.plant.initial_state(self.parameters)
        paths = [self.piston.path, *(tank.path for tank in self.tanks)]
        volumes = np.array([float(first[join(path, "volume")]) for path in paths])
        self.water, self.shares = volumes.sum(), volumes[1:] / volumes[1:].sum()
        low, high = (self._weight_moment(self._state(s, float(volumes[0]), 0.0), 0.0)[2] for s in (0.0, 1.0))
        bodies = sum(float(fact.mass) for _, fact in self.bodies)
        self.lifted = high - low
        self.immersion = self.lifted / (self.density * self.cylinder)
        self.excess = bodies + self.density * self.water - self.displaced

    def at(self, s: float) -> tuple[float, float, float, float, float]:
        """GM, volumes of shaft and tanks, level, centre of mass at a place."""
        volume = self.section * s + (self.section - self.cylinder) * self.immersion
        heights = []
        for roll, pitch in ((LEAN, 0.0), (0.0, LEAN)):
            aside = self._weight_moment(self._state(s, volume, roll, pitch), None)
            k, moved = (3, -aside[1]) if roll else (4, aside[0])
            heights.append((self.stiffness[k, k] * LEAN / self.gravity - moved) / (self.displaced * LEAN))
        upright = self._weight_moment(self._state(s, volume, 0.0), None)
        centre = upright[2] / (self.displaced + self.excess)
        return min(heights), volume, self.water - volume, s + self.immersion, centre

    def _state(self, s: float, volume: float, roll: float, pitch: float = 0.0) -> Any:
        held = {join(self.slide.path, "s"): s, join(self.piston.path, "volume"): volume}
        rest = max(self.water - volume, 0.0)
        held |= {join(tank.path, "volume"): rest * share for tank, share in zip(self.tanks, self.shares, strict=True)}
        for name, value in (("roll", roll), ("pitch", pitch), ("heave", 0.0)):
            held[join(self.motion.path, name)] = value
        return self.plant.initial_state(self.parameters, held)

    def _weight_moment(self, state: Any, water: float | None) -> Floats:
        """Sum of mass times place (3,) [kg m] over the frame of the hull; water: None counts it."""
        origin = np.asarray(state[join(self.hull.path, "frame.r")])
        found = sum((body.mass * (body.centre - origin) for body in placed_bodies(self.bodies, state)), np.zeros(3))
        if water is not None:
            return found
        for part, frame in ((self.piston, "frame_a"), *((tank, "frame") for tank in self.tanks)):
            r, R, centre, mass = state.values(
                [join(part.path, n) for n in (f"{frame}.r", f"{frame}.R", "centre", "mass")]
            )
            found = found + mass * (r + R @ centre - origin)
        return found


def _only(root: Any, kind: type) -> Any:
    found: Sequence[Any] = [part for part in root.walk() if isinstance(part, kind)]
    if len(found) != 1:
        raise ModelError(f"the model has {len(found)} parts of class {kind.__name__}; a stroke is of one.")
    return found[0]
