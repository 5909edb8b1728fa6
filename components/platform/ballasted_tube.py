"""A steel tube with ring stiffeners and solid ballast, as the chain of a beam."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fowtlib.components.mechanics.beam_division import STIFFNESSES
from fowtlib.components.mechanics.beam_properties import BeamProperties
from fowtlib.components.mechanics.beam_settings import WallMaterial
from fowtlib.components.mechanics.tube_beam import TUBE, TubeChain
from fowtlib.language import Scalar, like, param
from fowtlib.language.errors import ParameterError
from fowtlib.language.expressions import value_of

_STATIONS = 161  # of the table; the mass of a hull with cones is within 1e-5 of the exact one
_SURFACE = 1e-6  # of the length: over so much the mass per length falls at the surface of the ballast
_COLUMNS = ("mass_per_length", *STIFFNESSES, "rotary_inertia_x", "rotary_inertia_y")


class BallastedTube(TubeChain):
    """Partial: a round steel tube, wall measured inwards, with stiffeners and with solid ballast from its root up.

    Ring stiffeners are mass and nothing else. Ballast fills the tube up to the level that its mass asks for, bends with
    it and does not stiffen it. Diameters and walls are linear between `heights`, which are above the still water level.
    """

    density: Scalar = like(WallMaterial.density, default=7850.0, doc="density of the wall")
    young_modulus: Scalar = like(WallMaterial.young_modulus, default=210e9, doc="Young's modulus of the wall")
    shear_modulus: Scalar = like(WallMaterial.shear_modulus, default=80.8e9, doc="shear modulus of the wall")
    stiffener_fraction: Scalar = param(default=0.0, min=0, doc="mass of the ring stiffeners over that of the wall")
    ballast_mass: Scalar = param(default=0.0, unit="kg", min=0, doc="mass of the solid ballast on the keel")
    ballast_density: Scalar = param(default=2600.0, unit="kg/m^3", min=1.0, doc="density of the ballast")

    def section_table(self):
        return ballasted(self)[0]


def ballasted(tube: BallastedTube) -> tuple[BeamProperties, float, float]:
    """The tube with stiffeners and ballast, the mass of the steel [kg], and the level of the ballast [m]."""
    return value_of(tube, "ballasted", lambda: _ballasted(tube))


def _ballasted(tube: BallastedTube) -> tuple[BeamProperties, float, float]:
    heights, diameters, walls = (tuple(np.ravel(tube.parameter_value(name)).tolist()) for name in TUBE[:3])
    others = (*TUBE[3:], "stiffener_fraction", "ballast_mass", "ballast_density")
    try:
        return _table(heights, diameters, walls, *(float(tube.parameter_value(name)) for name in others))
    except ParameterError as error:
        raise ParameterError(f"{tube.label}: {error}") from None


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
