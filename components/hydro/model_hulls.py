"""The hulls that a model has: what of its parts a panel mesh can be made of.

- A part with a method `hull()`, whose result meshes itself: `panels(size)` and `lids(size)` (n, 4, 3), and `buoyancy`
  with `volume` and `waterplane` (6, 6), of which [2, 2] is the area: a Floater of members.
- Upright round columns, as MorisonDrag or, where there is none in the same composite, as VisualTube of the material
  "hull". Their coordinates are taken as those of the database: from the still water level, on the axis of the platform.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.linear_loads import Hydrostatics
from fowtlib.components.hydro.mesh_mirror import with_mirrored_panels
from fowtlib.components.hydro.morison import MorisonDrag
from fowtlib.components.hydro.panel_mesh import Column, members_mesh
from fowtlib.components.mechanics.visual import VisualTube
from fowtlib.language import Component
from fowtlib.language.errors import ParameterError

_UPRIGHT = 1e-3  # m that a column may lean from end to end
_CUT = 1e-3  # m: shorter edges, where members that nearly touch cut each other, are points


@dataclass(frozen=True)
class ModelHull:
    """A hull of a model: path of its part, what meshes it for a panel size [m], the volume that the model has [m^3]."""

    path: str
    mesh: Callable[[float], HullMesh]
    volume: float | None


def hulls(root: Component) -> dict[str, ModelHull]:
    """The hulls of a model by the path of their part (a composite, where its columns are parts)."""
    found: dict[str, ModelHull] = {}
    for part in root.walk():
        if callable(getattr(type(part), "hull", None)):
            found[part.path] = ModelHull(part.path, _floater_mesher(part), part.hull().buoyancy.volume)
        else:
            own = list(part.parts.values())
            tubes = [tube for tube in own if isinstance(tube, MorisonDrag)] or [
                tube for tube in own if isinstance(tube, VisualTube) and tube.parameter_value("material") == "hull"]
            if tubes:
                found[part.path] = ModelHull(part.path, _column_mesher(part, tubes), _volume(part))
    floaters = [part for part in root.walk() if callable(getattr(type(part), "hull", None))]
    inside = {below.path for floater in floaters for below in floater.walk() if below is not floater}
    return {path: hull for path, hull in found.items() if path not in inside}


def _floater_mesher(part: Any) -> Callable[[float], HullMesh]:
    def mesh(size: float) -> HullMesh:
        hull = part.hull()
        made = HullMesh(hull.panels(size), hull.lids(size), part.path or "hull", join=_CUT)
        made.expect(hull.buoyancy.volume, hull.buoyancy.waterplane[2, 2])
        return with_mirrored_panels(made)

    return mesh


def _column_mesher(part: Component, tubes: list[Component]) -> Callable[[float], HullMesh]:
    return lambda size: members_mesh([_column(tube) for tube in tubes], [], size, name=part.path or "hull")


def _column(tube: Component) -> Column:
    """An upright tube as a column. Raises ParameterError for one that leans or has no thickness."""
    points = np.asarray(tube.parameter_value("points"), dtype=float)
    diameters = np.broadcast_to(np.asarray(tube.parameter_value("diameters"), dtype=float), len(points))
    if isinstance(tube, MorisonDrag):
        points = points + np.asarray(tube.parameter_value("position"), dtype=float)
    if np.ptp(points[:, :2], axis=0).max() > _UPRIGHT:
        raise ParameterError(
            f"{tube.path} is no upright column: the panel method meshes upright round columns of MorisonDrag or "
            "VisualTube, floaters of members, and meshes in .gdf files")
    if points[0, 2] > points[-1, 2]:
        points, diameters = points[::-1], diameters[::-1]
    try:
        sections = tuple(zip(points[:, 2].tolist(), diameters.tolist(), strict=True))
        return Column(sections, x=float(points[0, 0]), y=float(points[0, 1]))
    except ParameterError as error:
        raise ParameterError(f"{tube.path}: {error.message}") from None


def _volume(part: Component) -> float | None:
    """What the model lets its hull displace [m^3], by the Hydrostatics in it, if there is one alone."""
    volumes = {float(other.parameter_value("volume")) for other in part.walk() if isinstance(other, Hydrostatics)}
    return volumes.pop() if len(volumes) == 1 else None
