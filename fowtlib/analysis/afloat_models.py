"""What floats in a model, as a rigid hull: its members' surface, all that it carries, its ballast as liquids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fowtlib.analysis.afloat import Afloat, Liquid
from fowtlib.analysis.masses import Placed, centre_of_mass, placed_bodies
from fowtlib.analysis.plants import plant_of
from fowtlib.analysis.tank_water import water_in
from fowtlib.analysis.upright import facts_of
from fowtlib.components.flooding import FloatingPiston, Tank
from fowtlib.components.platform import Floater, MemberHydrostatics, MemberShape
from fowtlib.components.platform.compartments import compartment, tank
from fowtlib.components.platform.member_hydrostatics import surface_of
from fowtlib.components.platform.members import Fill
from fowtlib.components.platform.wetted import WettedSurface
from fowtlib.language import facts
from fowtlib.language.declarations import join
from fowtlib.language.errors import NotFoundError, ParameterError, did_you_mean
from fowtlib.language.expressions import one_evaluation

ALL = "all"


def afloat(model: Any, slack: str | Sequence[str] = (), state: Any = None) -> Afloat:
    """The floating part of a model in the axes of its Floater, with all bodies where they are at a state.

    slack: names of Ballast below the floater whose surface stays level, or "all"; the rest is as solid. Water in tanks
    (components.flooding) is liquid always, and stays in its tank; that around a FloatingPiston is as solid. state: by
    default that at the start. Moorings and wind are not in it. Raises ParameterError where the model has not one
    Floater with members.
    """
    if hasattr(model, "root"):
        the_floater(model.root)  # before it is compiled
    plant = plant_of(model)
    state = plant.initial_state() if state is None else state
    with plant.binding(state.parameters).tree() as root, one_evaluation():
        floater = the_floater(root)
        told = [(part, fact) for part, fact in facts_of(root) if isinstance(fact, facts.Mass)]
        told = [(part, fact) for part, fact in told if not isinstance(part, Tank)]  # its water is a liquid
        origin, R = state.values([join(floater.frame.path, name) for name in ("r", "R")])
        mass, centre = centre_of_mass([*placed_bodies(told, state), *_in_shafts(root, state)])
        density, gravity = (float(floater.world.parameter_value(name)) for name in ("water_density", "gravity"))
        water = tuple(water_in(part, state, origin, R) for part in root.walk() if isinstance(part, Tank))
        found = Afloat(_surface(floater), mass, R.T @ (centre - origin), density, gravity, water, name=floater.label)
        return with_slack(found, floater, slack)


def the_floater(root: Any) -> Floater:
    """The one Floater of a model."""
    found = [part for part in root.walk() if isinstance(part, Floater)]
    if len(found) != 1:
        raise ParameterError(
            f"{len(found) or 'no'} parts of class Floater are in the model, and one is needed: the geometry of what "
            "floats is known from its members."
        )
    return found[0]


def compartment_of(floater: Floater, member: str, low: float = 0.0, high: float | None = None) -> WettedSurface:
    """The inside of a member of a floater, between distances [m] from its start, as a compartment that may flood."""
    return compartment(shape_of(floater, member), low, high)


def shape_of(floater: Floater, member: str) -> MemberShape:
    """The shape of a member by its name below the floater."""
    known = {shape.name.removeprefix(f"{floater.label}."): shape for shape in floater.hull().members}
    if member not in known:
        raise NotFoundError(f"{floater.label} has no member '{member}'{did_you_mean(member, known)}")
    return known[member]


def with_slack(hull: Afloat, floater: Floater, slack: str | Sequence[str]) -> Afloat:
    """The same hull with some ballast of the floater as liquids, whose mass is in that of the hull."""
    shapes = floater.hull()
    known = {fill.name.removeprefix(f"{floater.label}."): (member, fill)
             for member in shapes.members for fill in member.fills}  # fmt: skip
    names = list(known) if slack == ALL else [slack] if isinstance(slack, str) else list(slack)
    for name in names:
        if name not in known:
            raise NotFoundError(f"{floater.label} has no ballast '{name}'{did_you_mean(name, known)}")
    mass, moment, liquids = hull.mass, hull.mass * np.asarray(hull.centre), []
    for name in names:
        member, fill = known[name]
        solid = shapes.fills[fill.name]
        if solid.mass:
            mass, moment = mass - solid.mass, moment - solid.mass * solid.centre
            liquids.append(as_liquid(member, fill, solid.mass))
    return replace(hull, mass=mass, centre=moment / mass, liquids=(*hull.liquids, *liquids))


def as_liquid(member: MemberShape, fill: Fill, mass: float) -> Liquid:
    """Ballast as a liquid in its tank. Raises ParameterError where it does not fit."""
    return Liquid(tank(member, fill), mass / fill.density, fill.density, fill.name)


def _in_shafts(root: Any, state: Any) -> list[Placed]:
    """The water around each FloatingPiston, as a mass at a state."""
    found: list[Placed] = []
    for part in root.walk():
        if isinstance(part, FloatingPiston):
            names = ("frame_a.r", "frame_a.R", "centre", "mass")
            r, R, centre, mass = state.values([join(part.path, name) for name in names])
            found.append(Placed(part.path, float(np.ravel(mass)[0]), r + R @ np.ravel(centre), np.zeros((3, 3))))
    return found


def _surface(floater: Floater) -> WettedSurface:
    for part in floater.parts.values():
        if isinstance(part, MemberHydrostatics):
            return part.surface()
    return surface_of(floater)
