"""Openings with a free surface: a hole in the hull, a doorway or an overflow between two compartments."""

from __future__ import annotations

from typing import Any

import numpy as np

from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import WaveComponents, depth_decay
from fowtlib.components.environment.world import World
from fowtlib.components.flooding.connectors import Water
from fowtlib.components.flooding.pipe import TwoWaters
from fowtlib.components.flooding.throttle import SMALL_HEAD, Throttle, signed_root
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Scalar, Vector, eq, outer, param, port, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

SLICES = 8  # of equal height in an opening


class Opening(Throttle):
    """Partial: an opening at a place of a frame, cut into slices of equal height and area.

    A slice at height z passes C_d dA sqrt(2 g |max(H_1, z) - max(H_2, z)|) from the higher to the lower water: all that
    of an orifice where both sides are above it, that of a fall where one is below, nothing where both are. The sum over
    a rectangle is 2/3 C_d b sqrt(2 g) h^1.5 of a weir (Poleni). The compartments are open to the air where it is not
    all under water.
    """

    place: Vector = param(default=(0, 0, 0), unit="m", doc="middle of the opening, resolved in the frame")
    height: Scalar = param(default=0.0, unit="m", min=0, doc="along z of the frame; 0: a hole in a deck or a floor")

    frame: Frame = port(doc="body with the opening")

    def passed(self, first: Any, second: Any, gravity: Any) -> tuple[Any, list[Any]]:
        """Flow from the first head to the second [m^3/s], and what belongs to it."""
        area, more = self.open_area()
        up = self.frame.R.T @ m.vertcat(0, 0, 1)
        middle, flow = self.frame.r[2] + m.dot(up, self.place), 0.0
        for share in ((np.arange(SLICES) + 0.5) / SLICES - 0.5).tolist():
            z = middle + up[2] * share * self.height
            drop = m.fmax(first, z) - m.fmax(second, z)
            flow = flow + signed_root(drop, SMALL_HEAD) / SLICES
        return area * m.sqrt(2 * gravity) * flow, [
            *more,
            [eq(self.frame.f, m.zeros(3)), eq(self.frame.t, m.zeros(3))],
        ]


class Doorway(TwoWaters, Opening):
    """A doorway, an overflow or a hole between two compartments of a body; the port of each at its floor."""

    def equations(self):
        flow, more = self.passed(self.water_a.head, self.water_b.head, self.world.gravity)
        return [*self.through(), eq(self.volume_flow, flow), *more]


class SeaOpening(Opening):
    """An opening to the sea: outside the head is the still water level, and with `waves` that of linear waves at it.

    Damage: shut at the start (opening_start: 0) it comes with the event `turn`. Waves: elevation and pressure where the
    middle of the opening is at rest, `position` being the place of the frame there; z + p / (rho g) of them is the
    elevation times cosh k(z + h) / cosh k h, and above z = 0 the elevation. volume_flow is positive into the
    compartment.
    """

    waves: bool = param(default=False, doc="the waves count, too; needs a Sea")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame at rest, world")

    world: World = outer(World)
    sea: Sea = outer(Sea, optional=True)
    water: Water = port(doc="the compartment; its port at its floor")

    volume_flow: Scalar = var(unit="m^3/s", doc="from the sea into the compartment")
    outside: Scalar = var(unit="m", state="never", doc="head of the sea at the opening")

    def equations(self):
        flow, more = self.passed(self.outside, self.water.head, self.world.gravity)
        return [
            eq(self.outside, _elevation(self)),
            [eq(self.volume_flow, flow), eq(self.water.volume_flow, -flow)],
            *more,
        ]


def _elevation(opening: SeaOpening) -> Any:
    """Head of the sea at the opening [m]."""
    if not opening.waves:
        opening.refuse_unused("position", because="its waves are left out (waves: false)")
        return 0.0
    if opening.sea is None:
        raise ParameterError(f"{opening.label}.waves needs a part of class Sea, and the model has none.")
    return opening.sea.signal(_at_opening, 1, "head of the waves at the opening", "m", of=opening)


def _at_opening(waves: WaveComponents, opening: SeaOpening) -> np.ndarray:
    """Head of linear waves (n, 1) per unit amplitude; above the still water level that of the surface."""
    place = np.ravel(opening.parameter_value("position")) + np.ravel(opening.parameter_value("place"))
    k = waves.wave_number
    fading = depth_decay(k, place[2:], waves.depth)[0] * np.tanh(k * waves.depth)[:, None]  # cosh k(z + h) / cosh k h
    return waves.elevation_transfer(place[None, :]) * fading
