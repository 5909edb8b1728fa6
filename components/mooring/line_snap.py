"""How short steps must be for a line that goes slack and comes taut: its snap, and the time of a wave in an element."""

from __future__ import annotations

from typing import Any

import casadi as ca

from fowtlib.components.mooring import lumped_mass
from fowtlib.language import assert_
from fowtlib.language import math as m

SLACK = 1e-6
"""Tension, as a share of the axial stiffness, below which an element is slack: ten times the rounding of its law."""
SMALL = 0.01
"""Share of the weight of a line below which a snap does not count."""

_SAID = (
    "an element is slack, and its ends part at {speed} m/s: where it comes taut its tension jumps by up to {snap} N, "
    "which steps and output points resolve that are not further apart than {seconds} s"
)


def resolved(line: Any, nodes: Any, velocities: Any, elements: lumped_mass.Elements, weight: Any) -> Any:
    """A condition of level "step" on a DynamicLine: a snap that counts is resolved.

    An element whose ends part at v comes taut with v sqrt(EA m), the tension of a bar that is pulled at v, and a wave
    runs through it in l sqrt(m / EA): no step may be longer than the least of these times. A snap counts where it is
    larger than the tension at the fairlead as it is and SMALL of the weight of all nodes, `weight` (1, n + 1) [N].
    """
    lengths, along = lumped_mass.directions(nodes)
    parting = ca.sum1(along * (velocities[:, 1:] - velocities[:, :-1]))
    slack = lumped_mass.tensions(nodes, velocities, elements) < SLACK * elements.stiffness
    waves = m.sqrt(elements.stiffness * elements.mass)
    snaps = slack * ca.fmax(parting, 0) * waves * line.whole(lengths.shape[1])
    largest, seconds = ca.mmax(snaps), ca.mmin(elements.length * ca.sqrt(elements.mass / elements.stiffness))
    speed = ca.mmax(snaps / waves)
    counts = line.tension + SMALL * ca.sum2(ca.fabs(weight))
    return assert_(largest <= counts, _SAID, "step", seconds=seconds, speed=speed, snap=largest)
