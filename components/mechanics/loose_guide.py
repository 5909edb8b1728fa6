"""A guide with play: rings that are narrower than their shaft, and knock against its wall."""

from __future__ import annotations

from typing import Any, NamedTuple

from fowtlib.components.mechanics.guide import LEAST, Guide
from fowtlib.components.mechanics.rotations import axis_rotation, perpendicular_axes, unit_axis
from fowtlib.language import Array, RealOutput, Scalar, der, eq, param, port, rotation, var
from fowtlib.language import math as m

MIDDLE = 1e-6  # m; the distance of a ring from the axis is smooth below it


class LooseGuide(Guide):
    """A slide on two rings with play in their shaft: it moves aside and leans until a ring is at the wall.

    A ring that is off the axis by more than the play presses on the wall as a slide on an EndStop: Hertzian stiffness
    with damping in proportion to it. Within the play pads hold it, or what is in the gap, where there are any. What a
    ring carries is at right angles to the axis n of the carrier; a key holds the slide against turning about it.
    Without pads nothing holds an upright slide in the middle, and it has no one place of rest.
    Source of the contact: K.H. Hunt and F.R.E. Crossley, J. Appl. Mech. 42 (1975) 440-445.
    """

    play: Scalar = param(unit="m", min=0, doc="how far a ring is from the wall all around when it is in the middle")
    reference_force: Scalar = param(unit="N", min=0, doc="slow force of a ring at the reference depth")
    reference_depth: Scalar = param(default="10 mm", unit="m", min=1e-6, doc="depth of penetration of that force")
    restitution_loss: Scalar = param(default=0.2, unit="s/m", min=0, doc="alpha: share of speed lost per impact speed")
    pad_stiffness: Scalar = param(default=0.0, unit="N/m", min=0, doc="of pads that hold a ring in the middle")
    pad_damping: Scalar = param(default=0.0, unit="N*s/m", min=0, doc="of pads, or of what is in the gap, of a ring")

    lost_power: RealOutput = port(unit="W", doc="power that the rings take out across the axis")

    aside: Array = var(shape=(2,), unit="m", state="prefer", doc="frame_b off the axis, along two directions across n")
    lean: Array = var(shape=(2,), unit="rad", state="prefer", doc="turns about the first, then the second of these")
    aside_rate: Array = var(shape=(2,), unit="m/s", state="prefer", doc="rate of aside", hint="has the slide a mass?")
    lean_rate: Array = var(shape=(2,), unit="rad/s", state="prefer", doc="rate of lean", hint="has it inertia?")
    aside_acceleration: Array = var(shape=(2,), unit="m/s^2", doc="rate of aside_rate")
    lean_acceleration: Array = var(shape=(2,), unit="rad/s^2", doc="rate of lean_rate")
    first_gap: Scalar = var(unit="m", doc="way left of the ring at frame_b to the wall; negative: how deep it is in it")
    second_gap: Scalar = var(unit="m", doc="way left of the other ring")
    key: Scalar = var(unit="N*m", doc="moment of the key on the slide")
    energy: Scalar = var(unit="J", doc="elastic energy in rings and pads")

    def equations(self):
        a, b, n, (e, f) = self.frame_a, self.frame_b, unit_axis(self.n), perpendicular_axes(self.n)
        first, rate = axis_rotation(e, self.lean[0]), self.lean_rate
        rings = [_ring(self, off) for off in _off_the_axis(self)]
        across = [a.R @ (e * ring.force[0] + f * ring.force[1]) for ring in rings]
        key = a.R @ (first @ n) * self.key
        return [
            [eq(der(self.s), self.v), eq(der(self.v), self.a)],
            [eq(der(self.aside), self.aside_rate), eq(der(self.aside_rate), self.aside_acceleration)],
            [eq(der(self.lean), self.lean_rate), eq(der(self.lean_rate), self.lean_acceleration)],
            eq(b.r, a.r + a.R @ (n * self.s + e * self.aside[0] + f * self.aside[1])),
            rotation(a, b, first @ axis_rotation(f, self.lean[1]), e * rate[0] + first @ f * rate[1]),
            eq(self.axis.s, self.s),
            [eq(self.first_ring, across[0]), eq(self.second_ring, across[1])],
            [eq(self.first_gap, -rings[0].depth), eq(self.second_gap, -rings[1].depth)],
            eq(b.f, -(a.R @ n) * (self.force + self.axis.f) - self.first_ring - self.second_ring),
            eq(b.t, -key - m.cross(b.R @ n * self.ring_distance, self.second_ring)),
            self.transmit(b.r - a.r),
            eq(self.load, sum(m.smooth_norm(ring, LEAST) for ring in (self.first_ring, self.second_ring))),
            [eq(self.energy, sum(r.energy for r in rings)), eq(self.lost_power, sum(r.lost for r in rings))],
        ]


def _off_the_axis(guide: LooseGuide) -> tuple[Any, Any]:
    """Where the two rings are across the axis of the carrier, (2,) [m] each."""
    far, lean = guide.ring_distance, guide.lean
    return guide.aside, guide.aside + far * m.vertcat(m.sin(lean[1]), -m.cos(lean[1]) * m.sin(lean[0]))


class _Ring(NamedTuple):
    force: Any
    depth: Any
    energy: Any
    lost: Any


def _ring(guide: LooseGuide, off: Any) -> _Ring:
    """Force (2,) [N] on a ring that is off the axis, its depth in the wall [m], elastic energy [J], lost power [W]."""
    distance, rate = m.smooth_norm(off, MIDDLE), der(off)
    depth = distance - guide.play
    inwards = m.dot(off, rate) / distance
    within = m.fmax(depth, 0.0)
    elastic = guide.reference_force * (within / guide.reference_depth) ** 1.5
    pressed = elastic * m.fmax(1 + 1.5 * guide.restitution_loss * inwards, 0.0)
    force = -pressed / distance * off - guide.pad_stiffness * off - guide.pad_damping * rate
    energy = elastic * within / 2.5 + guide.pad_stiffness * m.dot(off, off) / 2
    return _Ring(force, depth, energy, (pressed - elastic) * inwards + guide.pad_damping * m.dot(rate, rate))
