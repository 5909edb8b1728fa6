"""Floaters: hulls described by their members."""

# the connectors of the mechanics come first, see components/environment
from fowtlib.components import mechanics as _mechanics  # noqa: F401  isort: skip
from fowtlib.components.platform.contents import Ballast, Bulkhead, LumpedMass
from fowtlib.components.platform.elastic_floater import ElasticFloater, modal_database
from fowtlib.components.platform.floater import Floater
from fowtlib.components.platform.hull import Buoyancy, Hull
from fowtlib.components.platform.member_hydrostatics import MemberHydrostatics
from fowtlib.components.platform.member_parts import CircularMember, Member, MemberLoads, RectangularMember
from fowtlib.components.platform.members import MemberShape
from fowtlib.components.platform.solids import MassProperties
from fowtlib.components.platform.spar_hull import SparHull
from fowtlib.components.platform.stepped_spar import SteppedSpar
from fowtlib.components.platform.wetted import WettedSurface

__all__ = [
    "Ballast",
    "Buoyancy",
    "Bulkhead",
    "CircularMember",
    "ElasticFloater",
    "Floater",
    "Hull",
    "LumpedMass",
    "MassProperties",
    "Member",
    "MemberHydrostatics",
    "MemberLoads",
    "MemberShape",
    "RectangularMember",
    "SparHull",
    "SteppedSpar",
    "WettedSurface",
    "modal_database",
]
