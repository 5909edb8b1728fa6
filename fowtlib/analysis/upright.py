"""Whether a floating model stays upright at rest: the whole of it, with turbines on top and with its moorings.

The judge is the linear model at the position at rest, in which everything that holds the floater counts: a motion of
the floater that grows without oscillating, as exp(s t) with a real s > 0, is one that nothing holds. The metacentric
height says how much is missing and whether weight is the cause: GM = (C44 - m g z_G) / (rho g V), C44 the stiffness of
the water about the frame of the hull with the moment of the buoyancy, z_G the centre of mass of all bodies over that
frame; least over the directions in which it may lean, while it is free to heave. Moorings do not count in GM: a tension
leg platform has a negative one, and stands. Source: J. M. J. Journee and W. W. Massie, Offshore Hydromechanics (2001),
2.3.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.analysis.masses import centre_of_mass, placed_bodies
from fowtlib.language import facts
from fowtlib.language.declarations import join
from fowtlib.language.expressions import one_evaluation
from fowtlib.solving import mean_linear_model

GROWTH = 1e-3  # 1/s: slower is a drift that rounding makes of a motion that nothing holds
_OWN = 0.3  # the least share that the floater itself has in a mode of its own
_ROUND = 0.05  # of the larger stiffness: two directions that differ by less are alike


@dataclass(frozen=True)
class Metacentre:
    """Of all that floats: height GM [m], and z of metacentre and centre of mass [m] over the still water.

    direction [rad]: of the axis about which it leans most easily, from x towards y; None where all are alike.
    """

    height: float
    z: float
    centre_of_mass_z: float
    direction: float | None

    @property
    def leans(self) -> str:
        """`in roll`, `in pitch`, `to any side`, or about which axis."""
        if self.direction is None:
            return "to any side"
        degrees = math.degrees(self.direction) % 180.0
        if min(degrees, 180.0 - degrees) < 10.0:
            return "in roll"
        return "in pitch" if abs(degrees - 90.0) < 10.0 else f"about the axis at {degrees:.0f} deg from x towards y"


def facts_of(root: Any) -> list[tuple[Any, facts.Fact]]:
    """What all parts say of themselves, each with its part."""
    return [(part, fact) for part in root.walk() for fact in part.facts()]


def metacentre(told: Sequence[tuple[Any, facts.Fact]], state: Any) -> Metacentre | None:
    """Of the whole, without its moorings; None where nothing floats, or more than one hull does.

    told: what the parts say, with the values that they have; state: where they are.
    """
    hulls = [(part, fact) for part, fact in told if isinstance(fact, facts.Loads) and fact.name == "C"]
    if len(hulls) != 1:
        return None
    part, stiffness = hulls[0]
    volumes = [fact.value for owner, fact in told
               if owner is part and isinstance(fact, facts.Number) and fact.name == "displaced volume"]  # fmt: skip
    bodies = placed_bodies([(owner, fact) for owner, fact in told if isinstance(fact, facts.Mass)], state)
    gravity = float(part.world.parameter_value("gravity"))
    density = float(part.world.parameter_value("water_density"))
    volume = float(np.asarray(volumes[0])) if volumes else 0.0
    C = np.asarray(stiffness.matrix, dtype=float)
    frame_z = float(np.asarray(state[join(part.path, "frame.r")])[2])
    if hasattr(part, "upright"):  # it knows its water at any draft
        volume, _, C = part.upright(frame_z)
    lift, (mass, centre) = density * gravity * volume, centre_of_mass(bodies)
    if not lift or not mass:
        return None
    arm = mass * gravity * (centre[2] - frame_z)
    coupled = C[2, 3:5]  # with heave, which gives way
    leaning = C[3:5, 3:5] - np.outer(coupled, coupled) / C[2, 2] if C[2, 2] > 0 else C[3:5, 3:5]
    values, axes = np.linalg.eigh((leaning + leaning.T) / 2 - arm * np.eye(2))
    alike = values[1] - values[0] < _ROUND * max(np.abs(leaning).max(), abs(arm))
    direction = None if alike else math.atan2(axes[1, 0], axes[0, 0])
    height = float(values[0]) / lift
    return Metacentre(height, height + float(centre[2]), float(centre[2]), direction)


def unstable_motion(plant: Any, state: Any) -> tuple[str, str, float] | None:
    """The floater, its motion that grows fastest without oscillating, and the rate [1/s]; None where none does."""
    floaters = [part.path for part in plant.root.walk() if "roll" in getattr(type(part), "mode_names", {})]
    worst: tuple[str, str, float] | None = None
    for mode in mean_linear_model(plant, state, outputs=[]).modes() if floaters else ():
        growth = mode.eigenvalue.real
        if growth < GROWTH or abs(mode.eigenvalue.imag) > 1e-3 * growth:
            continue
        for path in floaters:
            shares = _shares(plant.root.find(path), mode.participation)
            if sum(shares.values()) > _OWN and (worst is None or growth > worst[2]):
                worst = path, max(shares, key=shares.__getitem__), growth
    return worst


def _shares(joint: Any, participation: dict[str, float]) -> dict[str, float]:
    """What each of the six motions takes part in a mode, with its rate."""
    shares: dict[str, float] = {}
    for pattern, name in type(joint).mode_names.items():
        inner, dot, number = pattern.partition(".")
        motion = name.rpartition(" ")[2]
        state = join(joint.path, f"{inner}[{number}]" if dot else inner)
        shares[motion] = shares.get(motion, 0.0) + participation.get(state, 0.0)
    return shares


def upright_faults(plant: Any, state: Any) -> Iterator[str]:
    """One sentence where a floating model does not keep the position at rest by itself."""
    found = unstable_motion(plant, state)
    if found is None:
        return
    path, motion, growth = found
    twice = f"the motion doubles every {math.log(2.0) / growth:.3g} s"
    if motion not in ("roll", "pitch"):
        yield (f"{path}: it does not keep its place at rest: with all that holds it, it moves off in {motion}, and "
               f"{twice}. What holds it against {motion} is missing or turns it on: look at the moorings and at the "
               "wind.")  # fmt: skip
        return
    with plant.binding(state.parameters).tree() as root, one_evaluation():
        of = metacentre(facts_of(root), state)
    start = f"{path}: it cannot float upright: with all that holds it, moorings too, it leans over"
    if of is None:
        yield f"{start} in {motion}, and {twice}. Put mass lower, or widen the waterplane."
    elif of.height < 0:
        yield (f"{start} {of.leans}, and {twice}. The metacentric height of the whole, without moorings, is "
               f"{of.height:.3g} m: its centre of mass lies at z = {of.centre_of_mass_z:.4g} m, the metacentre at "
               f"{of.z:.4g} m. Put ballast lower or take more of it, widen the waterplane, or make the top "
               "lighter.")  # fmt: skip
    else:
        yield (f"{start} in {motion}, and {twice}. Weight and water alone would hold it, with a metacentric height of "
               f"{of.height:.3g} m: moorings, wind or controllers turn it over.")  # fmt: skip


def warn_unless_upright(plant: Any, state: Any) -> None:
    """A warning where a floating model does not keep the position at rest by itself."""
    for text in upright_faults(plant, state):
        warnings.warn(text, stacklevel=3)
