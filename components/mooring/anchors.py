"""Where a line ends: an anchor in the water or on the seabed, or a body that holds it."""

from __future__ import annotations

from fowtlib.language import assert_, eq, fix_orientation
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

LEVEL = 0.01
"""Height [m] above or below the seabed up to which an end of a line lies on it."""


def ends_above_seabed(depth, anchor, fairlead):
    """Heights z of the ends of a line that are not below the seabed."""
    return [
        assert_(anchor > -depth - LEVEL, "the anchor is at {z} m, below the seabed at {seabed} m (World.water_depth)",
                z=anchor, seabed=-depth),
        assert_(fairlead > -depth - LEVEL, "the fairlead is at {z} m, below the seabed at {seabed} m",
                z=fairlead, seabed=-depth),
    ]  # fmt: skip


TOO_SHORT = (
    "the line is too short: its ends are {apart} m apart and it is {length} m long, so that it is stretched by "
    "{strain} of its length, more than its greatest_strain. Take a longer line, or move its anchor"
)


def long_enough(line, length):
    """A line of this length reaches from end to end; however it hangs, it is stretched by the rest on the average."""
    strain = line.intact * (m.norm(line.fairlead.r - line.anchor.r) / length - 1)
    return assert_(strain < line.greatest_strain, TOO_SHORT, strain=strain, length=length, apart=(1 + strain) * length)


def hold_anchor(line, load):
    """The anchor is a frame of a body, which takes the load of the line, or a point in the water or on the seabed."""
    if line.anchor.connected:
        return [eq(line.anchor.f, load), eq(line.anchor.t, m.zeros(3))]
    if not line.is_set("anchor_position"):
        raise ParameterError(f"{line.label} has no anchor: give anchor_position, or connect a frame to its anchor.")
    z, depth = line.parameter_value("anchor_position")[2], line.world.parameter_value("water_depth")
    _refuse_outside_water(line.label, float(z), -float(depth))
    return [
        eq(line.anchor.r, line.anchor_position),
        fix_orientation(line.anchor, m.eye(3), m.zeros(3)),
        _in_water(line.anchor_position[2], -line.world.water_depth),
    ]


def _in_water(z, seabed):
    said = "the anchor is at {z} m, above the water; on the seabed it is at {seabed} m"
    return assert_(z <= 0, said, z=z, seabed=seabed)


def _refuse_outside_water(label, z, seabed):
    """ParameterError for an anchor below the seabed or above the water."""
    if z < seabed - LEVEL:
        raise ParameterError(
            f"{label} has its anchor at z = {z:g} m, below the seabed: World.water_depth is {-seabed:g} m. "
            "Change the depth of one to that of the other; an anchor above the seabed ends the line in mid-water."
        )
    if z > 0:
        raise ParameterError(
            f"{label} has its anchor at z = {z:g} m, above the water, where its weight in water does not hold. On the "
            f"seabed z is {seabed:g} m; a body that holds the line above the water is connected to its anchor."
        )
