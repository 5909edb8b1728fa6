"""The inside of members as closed surfaces: tanks with a free surface, compartments that are open to the sea."""

from __future__ import annotations

from functools import lru_cache

from fowtlib.components.platform.convex import surface
from fowtlib.components.platform.members import Fill, MemberShape
from fowtlib.components.platform.union import as_triangles
from fowtlib.components.platform.wetted import WettedSurface
from fowtlib.language.errors import ParameterError


def compartment(member: MemberShape, low: float = 0.0, high: float | None = None) -> WettedSurface:
    """The inside of a member within its walls, between two distances [m] from its start.

    Raises ParameterError where that is not within the member, or its walls leave nothing.
    """
    end = member.length if high is None else high
    if not -1e-6 <= low < end <= member.length + 1e-6:
        raise ParameterError(
            f"{member.name}: a compartment from {low:g} m to {end:g} m is not within the member of {member.length:g} m."
        )
    return _compartment(member, low, end)


@lru_cache(maxsize=64)
def _compartment(member: MemberShape, low: float, high: float) -> WettedSurface:
    bodies = [member.body(a, b, k, inner=True) for k, (a, b) in enumerate(member.pieces(low, high))]
    found = WettedSurface(as_triangles([facet.corners for _, facet in surface(bodies)]))
    if not len(found.triangles) or found.whole[0, 0] <= 0:
        raise ParameterError(f"{member.name}: its walls leave no room inside.")
    return found


def tank(member: MemberShape, fill: Fill) -> WettedSurface:
    """The tank of a ballast as a closed surface."""
    return compartment(member, max(fill.low, 0.0), min(fill.high, member.length))
