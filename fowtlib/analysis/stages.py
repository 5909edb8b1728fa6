"""Construction and transport in stages: what floats at each, how deep, how stable, and the depth of water it needs.

At stage j the water carries what is there by then: rho V(d) = sum of m_i, i <= j. Each stage builds on the one before.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fowtlib.analysis.afloat import Afloat, Floating
from fowtlib.analysis.afloat_models import ALL, as_liquid
from fowtlib.components.platform import Floater, Hull, MemberShape, WettedSurface
from fowtlib.components.platform.solids import NOTHING, point, together
from fowtlib.components.platform.union import union
from fowtlib.language.errors import NotFoundError, ParameterError, did_you_mean

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Stage:
    """A stage of construction; what it says holds from then on.

    members: names below the floater of those that are built now; where no stage names any, all are there at first.
    levels [m]: height z of ballast by its name, in the frame of the floater; None: pumped out. Ballast is empty before.
    masses: by any name mass [kg] and place (3,) [m] in the frame of what is put on; None: taken off.
    """

    name: str
    members: tuple[str, ...] = ()
    levels: Mapping[str, float | None] = field(default_factory=dict)
    masses: Mapping[str, tuple[float, Point] | None] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class StageFound:
    """What comes out of a stage: how it floats at rest, and upright; needed_depth [m]: of the water, with clearance."""

    name: str
    hull: Afloat
    rest: Floating
    upright: Floating
    needed_depth: float

    def row(self) -> tuple[float | str, ...]:
        """As in STAGE_HEADS."""
        floats = self.rest
        return (
            self.name, floats.mass, floats.draft, math.degrees(floats.heel), float(self.upright.centre_of_mass[2]),
            float(self.upright.centre_of_buoyancy[2]), self.upright.metacentric_height, self.needed_depth,
        )  # fmt: skip


STAGE_HEADS = ("stage", "mass [kg]", "draft [m]", "heel [deg]", "z_G [m]", "z_B [m]", "GM [m]", "water depth [m]")


def construction_stages(
    floater: Floater, stages: Sequence[Stage], *, clearance: float = 0.0, least: float = 0.0,
    slack: str | Sequence[str] = ALL,
) -> list[StageFound]:  # fmt: skip
    """How a floater floats at each of the stages of its construction.

    clearance [m]: below the keel. least [m]: GM that is needed at every stage. slack: names of ballast with a free
    surface, or "all"; the rest, as sand and concrete, is solid. Raises ParameterError where it sinks or GM is not above
    `least`, with the stage.
    """
    if not stages:
        raise ParameterError("there are no stages; give one or more.")
    shapes = {shape.name.removeprefix(f"{floater.label}."): shape for shape in floater.hull().members}
    fills = {fill.name.removeprefix(f"{floater.label}.") for shape in shapes.values() for fill in shape.fills}
    loose = fills if slack == ALL else {slack} if isinstance(slack, str) else set(slack)
    if unknown := sorted(loose - fills):
        raise NotFoundError(f"{floater.label} has no ballast '{unknown[0]}'{did_you_mean(unknown[0], sorted(fills))}")
    built: list[str] = [] if any(stage.members for stage in stages) else list(shapes)
    levels: dict[str, float | None] = {}
    masses: dict[str, tuple[float, Point] | None] = {}
    found = []
    for stage in stages:
        _known(stage, shapes, stage.members, f"member of {floater.label}")
        _known(stage, fills, stage.levels, f"ballast of {floater.label}")
        built += [name for name in stage.members if name not in built]
        levels |= stage.levels
        masses |= stage.masses
        if not built:
            raise ParameterError(f"stage '{stage.name}': nothing is built yet; name its members.")
        hull = _at_stage(floater, stage.name, [shapes[name] for name in built], levels, masses, loose)
        found.append(_floats(stage.name, hull, clearance, least))
    return found


def _known(stage: Stage, known: object, names: object, what: str) -> None:
    for name in names:  # type: ignore[attr-defined]
        if name not in known:  # type: ignore[operator]
            raise NotFoundError(f"stage '{stage.name}': there is no {what} '{name}'{did_you_mean(name, known)}")


def _at_stage(
    floater: Floater, name: str, shapes: list[MemberShape], levels: Mapping[str, float | None],
    masses: Mapping[str, tuple[float, Point] | None], loose: set[str],
) -> Afloat:  # fmt: skip
    """What is there at a stage."""
    raised = float(floater.parameter_value("raised"))
    members = tuple(replace(shape, fills=tuple(
        replace(fill, level=level + raised) for fill in shape.fills
        if (level := levels.get(fill.name.removeprefix(f"{floater.label}."))) is not None
    )) for shape in shapes)  # fmt: skip
    hull = Hull(members, f"{floater.label} at stage '{name}'")
    hull.check_joined()
    water = {fill.name: (member, fill) for member in members for fill in member.fills}
    prefix = f"{floater.label}."
    liquids = [as_liquid(*water[key], fill.mass) for key, fill in hull.fills.items()
               if fill.mass and key.removeprefix(prefix) in loose]  # fmt: skip
    put = [point(mass, place) for mass, place in filter(None, masses.values())]
    put += [fill for key, fill in hull.fills.items() if key.removeprefix(prefix) not in loose]
    solid = together([hull.structure, *put])
    if solid is NOTHING:
        raise ParameterError(f"{hull.name}: it has no mass; give its members walls, or the stage masses.")
    density, gravity = (float(floater.world.parameter_value(key)) for key in ("water_density", "gravity"))
    surface = WettedSurface(union(members).triangles())
    return Afloat(surface, solid.mass, np.asarray(solid.centre), density, gravity, tuple(liquids), name=hull.name)


def _floats(name: str, hull: Afloat, clearance: float, least: float) -> StageFound:
    upright = hull.at()
    GM = upright.metacentric_height
    if least >= GM:
        limit = "it turns over" if GM <= 0 else f"{least:.3g} m are wanted"
        raise ParameterError(
            f"{hull.name}: the metacentric height is {GM:.3g} m: {limit}. Its draft is {upright.draft:.4g} m, its "
            f"centre of mass lies at z = {upright.centre_of_mass[2]:.4g} m. Put ballast lower, fill tanks to the "
            "top, or put what is high on later."
        )
    rest = hull.at_rest()
    return StageFound(name, hull, rest, upright, rest.draft + clearance)
