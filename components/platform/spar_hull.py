"""The hull of a spar as an elastic tube in the water, ballast in it, with its sizes as parameters of a run."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from fowtlib.components.hydro.slender_hull import HullCoefficients, SlenderHullLoads, hull_strips
from fowtlib.components.mechanics.beam_division import STIFFNESSES, divide, pieces
from fowtlib.components.mechanics.beam_properties import BeamProperties
from fowtlib.components.mechanics.beam_settings import BeamSettings, WallMaterial
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.components.mechanics.tube_beam import TUBE, TubeChain
from fowtlib.language import Array, RealOutput, Scalar, Vector, eq, facts, like, param, port, shapes
from fowtlib.language.errors import ParameterError

_STATIONS = 161  # of the table; the mass of a hull with cones is within 1e-5 of the exact one
_SURFACE = 1e-6  # of the length: over so much the mass per length falls at the surface of the ballast
_COLUMNS = ("mass_per_length", *STIFFNESSES, "rotary_inertia_x", "rotary_inertia_y")


class SparHull(TubeChain, HullCoefficients):
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
    density: Scalar = like(WallMaterial.density, default=7850.0, doc="density of the wall")
    young_modulus: Scalar = like(WallMaterial.young_modulus, default=210e9, doc="Young's modulus of the wall")
    shear_modulus: Scalar = like(WallMaterial.shear_modulus, default=80.8e9, doc="shear modulus of the wall")
    stiffener_fraction: Scalar = param(default=0.0, min=0, doc="mass of the ring stiffeners over that of the wall")
    ballast_mass: Scalar = param(default=0.0, unit="kg", min=0, doc="mass of the solid ballast on the keel")
    ballast_density: Scalar = param(default=2600.0, unit="kg/m^3", min=1.0, doc="density of the ballast")
    damping_fore_aft: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness, fore-aft")
    damping_side_side: Scalar = param(default=damping_fore_aft, unit="s", min=0, doc="the same, side-side")
    cuts: Array = like(BeamSettings.cuts, doc="places of section loads: height above the still water level")
    node_heights: Array = param(default=(), unit="m", doc="frames on the axis, for fairleads: height above still water")
    n_nodes: int = param(default=lambda self: np.size(self.parameter_value("node_heights")), min=0, doc="their number")
    drag_coefficient: Scalar = like(HullCoefficients.drag_coefficient, default=0.7)
    strips: int = param(default=16, min=1, doc="strips of a rigid hull; two at least on each piece of an elastic one")
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

    def section_table(self):
        return _ballasted(self)[0]

    def places_of_nodes(self):
        heights = np.ravel(self.parameter_value("node_heights")) if self.n_nodes else []
        return [(0.0, 0.0, distance) for distance in _distances(self, "node", (*heights, 0.0))]

    def frames_of_nodes(self):
        return [*(self.nodes[k] for k in range(self.n_nodes)), self.frame]

    def distances_of_cuts(self):
        return np.array(_distances(self, "cut", np.ravel(self.cuts)))

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
        heights, diameters = (np.ravel(self.parameter_value(name)) for name in ("heights", "diameters"))
        wet = hull_strips(heights, diameters, heights[0], min(heights[-1], 0.0), 24)
        steel, level = _ballasted(self)[1:]
        return [
            facts.Number("displaced volume", wet.volume.sum(), "m^3"),
            facts.Number("centre of buoyancy", [0.0, 0.0, wet.volume @ wet.height / wet.volume.sum()], "m"),
            facts.Number("steel mass", steel, "kg"),
            facts.Number("ballast level", level, "m"),
        ]

    def drawing(self) -> list[shapes.Shape]:
        return self.drawn("hull")


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
    """Strips of a rigid piece, as many as its share of the draft asks for."""
    wet = _wet_pieces(hull)
    length = min(wet["high", name], 0.0) - wet["low", name]
    return max(2, round(hull.strips * length / -float(np.ravel(hull.parameter_value("heights"))[0])))


def _wet_pieces(hull: SparHull) -> dict[tuple[str, str], float]:
    """Of each rigid piece in the water its ends and its frame, heights [m] above the still water level at rest."""
    table, keel = hull.section_table(), float(np.ravel(hull.parameter_value("heights"))[0])
    found: dict[tuple[str, str], float] = {}
    for piece in pieces(table, divide(table, hull.hinges, hull.quadrature), hull.distances_of_cuts()):
        low, high = keel + piece.segment.start, keel + piece.segment.end
        if low < 0 and high > low:
            found |= {("origin", piece.name): keel + piece.root[2]}
            found |= {("low", piece.name): low, ("high", piece.name): high}
    return found


def _ballasted(hull: SparHull) -> tuple[BeamProperties, float, float]:
    """The tube with stiffeners and ballast, the mass of the steel [kg], and the level of the ballast [m]."""
    heights, diameters, walls = (tuple(np.ravel(hull.parameter_value(name)).tolist()) for name in TUBE[:3])
    others = (*TUBE[3:], "stiffener_fraction", "ballast_mass", "ballast_density")
    try:
        return _table(heights, diameters, walls, *(float(hull.parameter_value(name)) for name in others))
    except ParameterError as error:
        raise ParameterError(f"{hull.label}: {error}") from None


@lru_cache(maxsize=64)
def _table(heights: tuple[float, ...], diameters: tuple[float, ...], walls: tuple[float, ...], density: float,
           young_modulus: float, shear_modulus: float, stiffeners: float, ballast: float,
           ballast_density: float) -> tuple[BeamProperties, float, float]:  # fmt: skip
    material = {"young_modulus": young_modulus, "shear_modulus": shear_modulus}
    if not heights[0] < 0 < heights[-1]:
        raise ParameterError(
            f"the hull goes from {heights[0]:g} m to {heights[-1]:g} m; it must begin below the still water level, at "
            "0, and end above it."
        )
    steel = BeamProperties.tube(heights, diameters, walls, density=density, stations=_STATIONS, **material)
    steel = steel.scaled(mass=1 + stiffeners)
    z, length = steel.z, steel.length
    inner = np.interp(z, heights, np.subtract(diameters, 2 * np.asarray(walls)))
    level = z[0] + _filled(z - z[0], np.pi / 4 * inner**2, ballast / ballast_density)
    if ballast:
        around = [level, level + _SURFACE * length]
        z = np.union1d(z, around)
        inner = np.interp(z, heights, np.subtract(diameters, 2 * np.asarray(walls)))
    filled = ballast_density * np.where(z <= level, np.pi / 4 * inner**2, 0.0)
    total = np.trapezoid(filled, z)
    filled *= ballast / total if ballast else 0.0
    columns = {name: steel.at(name, z - z[0]) for name in _COLUMNS}
    rotary = filled * inner**2 / 16
    columns["mass_per_length"] = columns["mass_per_length"] + filled
    columns |= {name: columns[name] + rotary for name in ("rotary_inertia_x", "rotary_inertia_y")}
    return BeamProperties(z, **columns), float(np.trapezoid(steel.mass_per_length, steel.z)), float(level)


def _filled(s: np.ndarray, area: np.ndarray, volume: float) -> float:
    """Height [m] up to which a tube with areas [m^2], linear between places s [m], holds a volume [m^3]."""
    held = np.concatenate([[0.0], np.cumsum(np.diff(s) * (area[1:] + area[:-1]) / 2)])
    if volume > held[-1]:
        raise ParameterError(
            f"the ballast has {volume:.6g} m^3 and the hull holds {held[-1]:.6g} m^3; take less, or one of a greater "
            "density."
        )
    k = min(int(np.searchsorted(held, volume, side="right")) - 1, len(s) - 2)
    left, slope = volume - held[k], (area[k + 1] - area[k]) / (s[k + 1] - s[k])
    return float(s[k] + 2 * left / (area[k] + np.sqrt(area[k] ** 2 + 2 * slope * left)))
