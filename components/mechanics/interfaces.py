"""Partial classes: the ports that several mechanical parts have in common."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Flange, Frame
from fowtlib.language import Component, eq, port
from fowtlib.language import math as m


class TwoFrames(Component):
    """A part between two frames. Partial: a subclass writes the equations."""

    frame_a: Frame = port(doc="side towards the root, often the carrier")
    frame_b: Frame = port(doc="side towards the tips")

    def start_rotation(self, command):
        """R (3 x 3) from frame_b to frame_a where a run starts; None for a part that holds no orientation.

        Called outside of flattening; command: what is commanded to a drive.
        """
        return None

    def start_translation(self):
        """From frame_a to frame_b (3,) [m], resolved in frame_a, where a run starts. Called outside of flattening."""
        return (0.0, 0.0, 0.0)

    def transmit(self, arm=None):
        """Balance of the loads on both frames of a massless part; arm = r_b - r_a, world (None: zero)."""
        a, b = self.frame_a, self.frame_b
        moment = b.t if arm is None else b.t + m.cross(arm, b.f)
        return [eq(a.f, -b.f), eq(a.t, -moment)]


class TwoFlanges(Component):
    """A part between two shaft ends; either end may be left free. Partial: a subclass writes the equations."""

    flange_a: Flange = port(optional=True, doc="driving side")
    flange_b: Flange = port(optional=True, doc="driven side")
