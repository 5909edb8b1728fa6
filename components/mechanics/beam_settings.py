"""Parameters that all have which are beams inside: towers, arms, blades. Records: classes with parameters only."""

from __future__ import annotations

from fowtlib.components.mechanics.beam_division import TREATMENTS
from fowtlib.components.mechanics.beam_properties import BeamProperties, read_beam
from fowtlib.language import Array, Component, Data, Scalar, data, param


class BeamTable(Component):
    """Partial: the properties along a beam, as a table."""

    properties: Data[BeamProperties] = data(read_beam, default=None, doc="CSV with the properties, see read_beam")
    table: object = param(default=None, doc="the properties as BeamProperties, instead of a path")


class WallMaterial(Component):
    """Partial: what the wall of a tube is made of; steel with paint, bolts and flanges by default."""

    density: Scalar = param(default=8500.0, unit="kg/m^3", min=0, doc="density of the wall, with paint, bolts, flanges")
    young_modulus: Scalar = param(default=210e9, unit="Pa", min=0, doc="Young's modulus of the wall")
    shear_modulus: Scalar = param(default=80.8e9, unit="Pa", min=0, doc="shear modulus of the wall")


class BeamSettings(Component):
    """Partial: how a beam is divided, and where its section loads are known; see Beam."""

    units: int = param(default=4, min=0, doc="number of beam units; 0: rigid")
    treatment: str = param(default="loaded_tip", choices=TREATMENTS, doc="see Beam")
    torsion: bool = param(default=False, doc="with torsion")
    stiffness_factor: Scalar = param(default=1.0, min=0, doc="factor on every stiffness")
    cuts: Array = param(default=(), unit="m", structural=True, doc="places of section loads: distance from the root")
    n_cuts: int = param(default=lambda self: len(self.cuts), min=0, doc="number of those cuts")
