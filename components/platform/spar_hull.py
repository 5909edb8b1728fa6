"""The hull of a spar as an elastic tube in the water, ballast in it, with its sizes as parameters of a run."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fowtlib.components.hydro.hull_part import hull_strips
from fowtlib.components.hydro.slender_hull import HullCoefficients, SlenderHullLoads
from fowtlib.components.mechanics.beam_division import pieces
from fowtlib.components.mechanics.beam_settings import BeamSettings
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.tube_beam import drawn_tube
from fowtlib.components.platform.ballasted_tube import BallastedTube, ballasted
from fowtlib.language import Array, RealOutput, Scalar, Vector, eq, facts, like, param, port, shapes
from fowtlib.language.errors import ParameterError

_STEEP = 11.0  # deg; cones that are steeper are told of: the OC3 spar, which was compared, has 10.3 deg
_DECAY = 6.0  # short waves have lost all but exp(-6) of their motion at the keel; which part of a hull has more strips


class SparHull(BallastedTube, HullCoefficients):
    """The hull of a spar: a round steel tube from the keel to where the tower stands, with ballast, in the water.

    A chain of sprung hinges between rigid pieces as other beams are (see Beam), or with hinges = 0 one rigid body; each
    rigid piece bears the loads of the water on it (SlenderHullLoads). Walls are measured inwards from the diameters;
    ring stiffeners are mass and nothing else; solid ballast fills the tube from the keel, up to the level that its mass
    asks for. All are linear between `heights`, which are above the still water level, as nodes and cuts are.

    `frame` is on the axis at the still water level at rest and says how the hull moves: a FreeMotion is joined there.
    frame_a is at the keel, frame_b at the top. Moments at the cuts are those of what is above on what is below, about
    the axes of the hull there: fore-aft about y, side-side about x; axial forces of a cut are without the pressure of
    the water within the section (its weight less its buoyancy above). For validity of the loads see SlenderHullLoads.
    """

    mode_names = {"*_x": "{part} fore-aft", "*_y": "{part} side-side", "*.twisting.*": "{part} torsion"}

    hinges: int = like(BeamSettings.hinges, default=6)
    damping_fore_aft: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, fore-aft")
    damping_side_side: Scalar = param(default=damping_fore_aft, unit="s", min=0, doc="the same, side-side")
    cuts: Array = like(BallastedTube.cuts, doc="places of section loads: height above the still water level")
    node_heights: Array = param(default=(), unit="m", doc="frames on the axis, for fairleads: height above still water")
    n_nodes: int = param(default=lambda self: np.size(self.parameter_value("node_heights")), min=0, doc="their number")
    drag_coefficient: Scalar = like(HullCoefficients.drag_coefficient, default=0.7)
    strips: int = param(default=24, min=1, doc="strips of the whole hull, one at least on each rigid piece")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of `frame` at rest, world; on the still water")

    frame: Frame = port(doc="on the axis at the still water level")
    nodes: Frame = port(size="n_nodes", optional=True, doc="frames at node_heights; parallel to `frame` at rest")
    cut_fore_aft_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about y")
    cut_side_side_moment: RealOutput = port(size="n_cuts", unit="N*m", doc="moment at each cut about x")
    cut_shear: RealOutput = port(size="n_cuts", unit="N", doc="force at each cut along x, of what is above")
    cut_axial_force: RealOutput = port(size="n_cuts", unit="N", doc="force at each cut along the axis, compression < 0")

    def build(self):
        chain, carriers = super().build()
        wet = [name for kind, name in self._chain_keys if kind == "low"]
        for k, name in enumerate(wet):
            loads = self.add(f"water_{name}", SlenderHullLoads(
                heights=self.heights, diameters=self.diameters, low=chain["low", name], high=chain["high", name],
                keel=k == 0, waterline=k == len(wet) - 1, strips=_strips_of(self, name),
                position=(self.position[0], self.position[1], self.position[2] + chain["origin", name]),
                **self.values_of(HullCoefficients),
            ))  # fmt: skip
            self.connect(carriers[name], loads.frame)

    def chain(self):
        return super().chain() | _wet_pieces(self)

    def places_of_nodes(self):
        heights = np.ravel(self.parameter_value("node_heights")) if self.n_nodes else []
        return [(0.0, 0.0, distance) for distance in _distances(self, "node", (*heights, 0.0))]

    def frames_of_nodes(self):
        return [*(self.nodes[k] for k in range(self.n_nodes)), self.frame]

    def distances_of_cuts(self):
        return np.array(_distances(self, "cut", np.ravel(self.parameter_value("cuts"))))

    def hinge_settings(self):
        return {"damping_x": self.damping_fore_aft, "damping_y": self.damping_side_side}

    def equations(self):
        cuts = [getattr(self, f"cut_{k + 1}") for k in range(self.n_cuts)]
        return [
            [eq(self.cut_fore_aft_moment[k], -cut.torque[1]) for k, cut in enumerate(cuts)],
            [eq(self.cut_side_side_moment[k], -cut.torque[0]) for k, cut in enumerate(cuts)],
            [eq(self.cut_shear[k], -cut.force[0]) for k, cut in enumerate(cuts)],
            [eq(self.cut_axial_force[k], -cut.force[2]) for k, cut in enumerate(cuts)],
        ]

    def facts(self) -> list[facts.Fact]:
        return _facts(self)

    def remarks(self) -> list[str]:
        return _remarks(self)

    def drawing(self) -> list[shapes.Shape]:
        return drawn_tube(self, "hull")


def _facts(hull: SparHull) -> list[facts.Fact]:
    heights, diameters = (np.ravel(hull.parameter_value(name)) for name in ("heights", "diameters"))
    wet = hull_strips(heights, diameters, heights[0], min(heights[-1], 0.0), 24)
    steel, level = ballasted(hull)[1:]
    return [
        facts.Number("displaced volume", wet.volume.sum(), "m^3"),
        facts.Number("centre of buoyancy", [0.0, 0.0, wet.volume @ wet.height / wet.volume.sum()], "m"),
        facts.Number("steel mass", steel, "kg"),
        facts.Number("ballast level", level, "m"),
    ]


def _remarks(hull: SparHull) -> list[str]:
    heights, diameters = (np.ravel(hull.parameter_value(name)) for name in ("heights", "diameters"))
    slopes = np.degrees(np.arctan(np.abs(np.diff(diameters) / np.diff(heights) / 2)))[heights[:-1] < 0]
    if slopes.max() <= _STEEP:
        return []
    at, steep = heights[slopes.argmax()], slopes.max()
    said = f"its cone from {at:g} m upwards has {steep:.0f} deg; loads by strips are good for cones of 10 deg or so."
    return [f"{hull.label}: {said}"]


def _distances(hull: SparHull, what: str, places: Iterable[float]) -> list[float]:
    """Distances [m] from the keel of heights above the still water level."""
    keel, *_, top = np.ravel(hull.parameter_value("heights"))
    for k, z in enumerate(places):
        if not keel <= z <= top:
            raise ParameterError(
                f"{hull.label}: {what} {k + 1} at {z:g} m is off the hull, which goes from {keel:g} m to {top:g} m."
            )
    return [float(z - keel) for z in places]


def _strips_of(hull: SparHull, name: str) -> int:
    """Strips of a rigid piece: half of them by its share of the draft, half by what short waves leave of it."""
    wet, draft = _wet_pieces(hull), -float(np.ravel(hull.parameter_value("heights"))[0])
    low, high = wet["low", name], min(wet["high", name], 0.0)
    near = np.exp(_DECAY * high / draft) - np.exp(_DECAY * low / draft)
    return max(1, round(hull.strips * ((high - low) / draft + near) / 2))


def _wet_pieces(hull: SparHull) -> dict[tuple[str, str], float]:
    """Of each rigid piece in the water its ends and its frame, heights [m] above the still water level at rest."""
    table, keel = hull.section_table(), float(np.ravel(hull.parameter_value("heights"))[0])
    found: dict[tuple[str, str], float] = {}
    for piece in pieces(table, hull.division(table), hull.distances_of_cuts()):
        low, high = keel + piece.segment.start, keel + piece.segment.end
        if low < 0 and high > low:
            found |= {("origin", piece.name): keel + piece.root[2]}
            found |= {("low", piece.name): low, ("high", piece.name): high}
    return found
