"""A line of several sections with weights and floats between them: the equations, for numbers and expressions.

Sections and points are counted from the anchor. All lies in one vertical plane. With the tensions T (horizontal) and V
(vertical, positive: the line pulls down) at the fairlead, each section is the elastic catenary of
fowtlib.components.mooring.catenary, solved from its upper end downwards: its lower end has the vertical tension V_a,
and the section below it V_a - W at its upper end, W the weight in water of the point between them (negative: a float).
The horizontal tension is the same all along, but for the friction of the seabed.

Below the lowest of what floats a line from an anchor on the seabed lies where V comes down to zero: of a point V_a - W
is at least zero there, and what is below lies. Elsewhere a point that comes down to the seabed rests on a spring, SINK
of the length deep under the weight of the whole line. Each section touches the seabed by itself where it hangs down to
it between its ends, as a line from an anchor in mid-water does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from fowtlib.components.mooring import catenary
from fowtlib.language import math as m

SINK = 1e-3
"""Depth to which a point sinks into the seabed under the weight of its line, as a share of the length of the line."""


class Section(NamedTuple):
    """What catenary.Line has, and that weight and friction are those of a section; numbers or expressions."""

    length: Any
    weight: Any
    axial_stiffness: Any
    friction: Any
    clearance: Any


class Hung(NamedTuple):
    """A section as it hangs: tensions at its upper end [N] (horizontal: of the catenary), its state, its share of H."""

    horizontal: Any
    vertical: Any
    state: catenary.State
    share: Any
    line: Section

    @property
    def span(self) -> Any:
        """Horizontal distance of its ends [m], along the line that is drawn aside."""
        return self.state.grounded + self.horizontal * self.state.flexibility

    @property
    def left(self) -> Any:
        """What friction leaves of the horizontal tension at its lower end."""
        return 1 - m.fmin(self.state.held, 1)


def whole(sections: Sequence[Section], points: Sequence[Any]) -> Section:
    """One line with the length and stiffness of all sections, and the sizes of all weights: the measure of forces."""
    length = sum(section.length for section in sections)
    weight = sum(m.abs(section.weight) * section.length for section in sections) + sum(m.abs(W) for W in points)
    return Section(length, weight / length, length / sum(s.length / s.axial_stiffness for s in sections), 0, 0)


def hung(T: Any, V: Any, sections: Sequence[Section], points: Sequence[Any], heights: Sequence[Any]) -> list[Hung]:
    """The sections below tensions at the fairlead [N]; heights [m] of the points and, first, the anchor over the bed.

    sections: their clearance is not used. points: weights in water [N], negative for floats.
    """
    measure = whole(sections, points)
    force, aside, _ = catenary.scales(measure, m)
    bed, found, share = force / (SINK * measure.length), [], 1
    for i in reversed(range(len(sections))):
        section, sinks = sections[i], _sinks(sections[: i + 1], points[:i], heights[0])
        clearance = m.if_else(sinks, 0, m.fmax(heights[i], 0)) if i else heights[0]
        line = section._replace(clearance=clearance, friction=m.if_else(sinks, section.friction, 0))
        found.append(Hung(T, V, catenary.state(T, V, line, m), share, line))
        if i:
            below = found[-1].state.anchor - points[i - 1]
            V = m.if_else(sinks, m.fmax(below, 0), below + bed * m.fmax(-heights[i], 0))
            T, share = m.fmax(T * found[-1].left, aside), share * found[-1].left
    return found[::-1]


def _sinks(sections: Sequence[Section], points: Sequence[Any], clearance: Any) -> Any:
    """Whether all of it would lie on the seabed: nothing floats, and the anchor is on the seabed."""
    lightest = 1.0
    for section in sections:
        lightest = m.fmin(lightest, m.if_else(section.weight > 0, 1, 0))
    for W in points:
        lightest = m.fmin(lightest, m.if_else(W < 0, 0, 1))
    return m.fmin(lightest, m.if_else(clearance > 0, 0, 1)) > 0.5
