"""What all have which are beams, or have one inside: towers, arms, blades. Records have parameters only."""

from __future__ import annotations

import numpy as np

from fowtlib.components.mechanics.beam_division import QUADRATURES
from fowtlib.components.mechanics.beam_properties import BeamProperties, read_beam
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Array, Component, Data, Scalar, data, param, port
from fowtlib.language.bounds import POSITIVE


class BeamTable(Component):
    """Partial: the properties along a beam, as a table."""

    properties: Data[BeamProperties] = data(read_beam, default=None, doc="CSV with the properties, see read_beam")
    table: object = param(default=None, doc="the properties as BeamProperties, instead of a path")


def of_a_tube(value):
    """Default of a number of a tube: none without diameters, as a number that nothing uses is no parameter of a run."""
    return lambda component: value if np.size(component.parameter_value("diameters")) else None


class WallMaterial(Component):
    """Partial: what the wall of a tube with `diameters` is made of; steel with paint, bolts and flanges by default."""

    density: Scalar = param(
        default=of_a_tube(8500.0), unit="kg/m^3", min=0,
        doc="density of the wall, with paint, bolts, flanges; 8500 unless given",
    )  # fmt: skip
    young_modulus: Scalar = param(
        default=of_a_tube(210e9), unit="Pa", min=POSITIVE, doc="Young's modulus of the wall; 210 GPa unless given"
    )
    shear_modulus: Scalar = param(
        default=of_a_tube(80.8e9), unit="Pa", min=POSITIVE, doc="shear modulus of the wall; 80.8 GPa unless given"
    )


class BeamCuts(Component):
    """Partial: where the section loads of a beam are known."""

    cuts: Array = param(
        default=(), unit="m", structural="it parts the chain of segments",
        doc="places of section loads: distance from the root",
    )  # fmt: skip
    n_cuts: int = param(default=lambda self: len(self.cuts), min=0, doc="number of those cuts")


class BeamSettings(BeamCuts):
    """Partial: how a beam is divided, and where its section loads are known; see Beam."""

    hinges: int = param(default=4, min=0, doc="number of beam hinges; 0: rigid")
    quadrature: str = param(default="loaded_tip", choices=QUADRATURES, doc="where the hinges are: see Beam")
    torsion: bool = param(default=False, doc="with torsion")
    stiffness_factor: Scalar = param(default=1.0, min=0, doc="factor on every stiffness")


class BeamNodes(Component):
    """Partial: frames along a beam."""

    node_points: list = param(default=[], unit="m", doc="frames along it: distance from the root, or a point (x, y, z)")
    n_nodes: int = param(default=lambda self: len(self.node_points), min=0, doc="number of those frames")

    nodes: Frame = port(size="n_nodes", optional=True, doc="those frames, for loads and sensors; parallel to frame_a "
                        "while undeflected")  # fmt: skip
