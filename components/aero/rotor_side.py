"""On which side of its tower a rotor turns."""

from __future__ import annotations

from fowtlib.components.mechanics import FixedRotation, Frame, RigidBody
from fowtlib.language import Component, param


class RotorSide(Component):
    """Partial: upwind of the tower, or downwind of it, with the nacelle turned round and all signs kept."""

    downwind: bool = param(default=False, doc="the rotor is behind its tower; overhang, tilt and cone count there")

    @property
    def side(self) -> int:
        """1 upwind, -1 downwind: sign of what counts towards the hub, such as overhang, tilt and cone."""
        return -1 if self.downwind else 1

    def carry(self, frame: Frame, body: RigidBody) -> None:
        """In build(): a body on a frame (x downwind), turned by 180 deg about z with a nacelle that looks downwind."""
        if not self.downwind:
            self.connect(frame, body.frame_a)
            return
        self.turned_round = FixedRotation(n=(0, 0, 1), angle="180 deg")
        self.connect(frame, self.turned_round.frame_a)
        self.connect(self.turned_round.frame_b, body.frame_a)
