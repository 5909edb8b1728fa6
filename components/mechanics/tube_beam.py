"""A beam that is a round tube, whose heights, diameters, walls and material may change from run to run."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fowtlib.components.mechanics.beam import Beam, BeamHinge
from fowtlib.components.mechanics.beam_division import KEPT, Division, divide, pieces
from fowtlib.components.mechanics.beam_properties import BeamProperties
from fowtlib.components.mechanics.beam_settings import BeamSettings, WallMaterial
from fowtlib.components.mechanics.bodies import FixedTranslation, RigidBody
from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.components.mechanics.sensors import LoadSensor
from fowtlib.language import Array, eq, like, param, shapes
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.errors import ParameterError
from fowtlib.language.expressions import StartNumbers

TUBE = ("heights", "diameters", "wall_thicknesses", "density", "young_modulus", "shear_modulus")
Key = tuple[str, str]


class TubeChain(TwoFrames, WallMaterial, BeamSettings):
    """Partial: a round tube as the chain of a Beam, whose numbers are computed when a run starts.

    Its cuts may move with it as long as they pass no hinge. A subclass says how its hinges lose energy and, where that
    is not the tube alone, what lies along it.
    """

    heights: Array = param(unit="m", doc="stations along the axis, root first")
    diameters: Array = param(unit="m", min=POSITIVE, doc="outer diameters at the stations")
    wall_thicknesses: Array = param(unit="m", min=POSITIVE, doc="wall thicknesses at the stations")
    cuts: Array = param(default=(), unit="m", doc="places of section loads: distance from the root")
    n_cuts: int = like(BeamSettings.n_cuts, default=lambda self: np.size(self.parameter_value("cuts")))

    def build(self):
        self._chain_keys = tuple(self.chain())
        numbers = StartNumbers(self, "chain", len(self._chain_keys), _chain_numbers)
        chain = {key: numbers[k] for k, key in enumerate(self._chain_keys)}
        frame, carriers = self.frame_a, {}
        for kind, name in self._chain_keys:
            if kind == "arm":
                frame = self._link(frame, (0, 0, chain[kind, name]), name)
            elif kind in ("bending", "cut"):
                joint = self.add(name, self._hinge(chain, name) if kind == "bending" else LoadSensor())
                self.connect(frame, joint.frame_a)
                frame = joint.frame_b
            elif kind == "mass":
                self.connect(frame, self.add(name, _body(chain, name)).frame_a)
            carriers.setdefault(name, frame)
        self.connect(frame, self.frame_b)
        for kind, name in (key for key in self._chain_keys if key[0].startswith("node of ")):
            k, carrier = int(name.rpartition("_")[2]) - 1, carriers[kind.removeprefix("node of ")]
            x, y, _ = self.places_of_nodes()[k]
            self.connect(self._link(carrier, (x, y, chain[kind, name]), name), self.frames_of_nodes()[k])
        return chain, carriers

    def section_table(self) -> BeamProperties:
        """What lies along the tube, with the parameter values that it has now."""
        return tube_table(self)

    def chain(self) -> dict[Key, float]:
        """The numbers of the chain with the parameter values that it has now."""
        table, nodes = self.section_table(), [height for _, _, height in self.places_of_nodes()]
        return chain_numbers(table, self.division(table), nodes, self.distances_of_cuts())

    def division(self, table: BeamProperties) -> Division:
        """Its hinges, with the parameter values that it has now."""
        heights = np.ravel(self.parameter_value("heights"))
        return divide(table, self.hinges, self.quadrature, tuple((heights - heights[0]).tolist()))

    def places_of_nodes(self) -> list[tuple[float, float, float]]:
        """The frames along the tube: x, y, and distance from the root [m]."""
        raise NotImplementedError

    def frames_of_nodes(self) -> list:
        """Their ports."""
        raise NotImplementedError

    def distances_of_cuts(self) -> np.ndarray:
        """The cuts: distances from the root [m]."""
        return np.ravel(self.parameter_value("cuts"))

    def hinge_settings(self) -> dict:
        """Damping of the hinges, and whether they stretch."""
        raise NotImplementedError

    def _link(self, frame, r, name):
        link = self.add(name, FixedTranslation(r=r, diameter=0))
        self.connect(frame, link.frame_a)
        return link.frame_b

    def _hinge(self, chain, name):
        k = self.stiffness_factor
        return BeamHinge(
            stiffness_x=k * chain["bending", name], stiffness_y=k * chain["bending", name],
            torsional_stiffness=k * chain["torsion", name], axial_stiffness=k * chain["stretch", name],
            torsion=self.torsion, **self.hinge_settings(),
        )  # fmt: skip


class TubeBeam(TubeChain, Beam):
    """A Beam that is a round tube, given by diameters and walls at heights, linear between them; see Beam.

    Masses, places and stiffnesses of the chain are those of a Beam with the table of the same tube; they are computed
    when a run starts. Where a hinge passes a node or a cut the chain is another one: the run is refused, and the model
    has to be built anew.
    """

    def build(self):
        self.refuse_unused("properties", "table", because="this beam is a tube")
        super().build()

    def section_table(self):
        return tube_table(self)

    def places_of_nodes(self):
        return [_point(given) for given in self.node_points]

    def frames_of_nodes(self):
        return self.nodes

    def hinge_settings(self):
        return {name: getattr(self, name) for name in ("damping_x", "damping_y", "damping", "stretch")}

    def equations(self):
        a, b = self.frame_a, self.frame_b
        cuts = [getattr(self, f"cut_{k + 1}") for k in range(self.n_cuts)]
        length = self.heights[self.heights.shape[0] - 1] - self.heights[0]
        return [
            [eq(self.cut_force[k], cut.force) for k, cut in enumerate(cuts)],
            [eq(self.cut_moment[k], cut.torque) for k, cut in enumerate(cuts)],
            eq(self.deflection, a.R.T @ (b.r - a.r) - m.vertcat(0, 0, length)),
            eq(self.root_force, a.R.T @ a.f),
            eq(self.root_moment, a.R.T @ a.t),
        ]

    def drawing(self):
        return drawn_tube(self, "tower")


def drawn_tube(tube: TubeChain, material: str) -> list[shapes.Shape]:
    """A tube as it bends, for pictures."""
    parts = tube.division(tube.section_table())
    heights, diameters = (np.ravel(tube.parameter_value(name)) for name in ("heights", "diameters"))
    frames = [tube.frame_a, *(tube.parts[f"hinge_{i + 1}"].frame_b for i in range(tube.hinges))]
    drawn, given = [], heights - heights[0]
    for frame, origin, s in zip(frames, [0.0, *parts.s], parts.stations(), strict=True):
        places = np.union1d(s, given[(given > s[0]) & (given < s[-1])])
        axis = [(0, 0, z - origin) for z in places]
        drawn.append(shapes.Tube(frame, axis, np.interp(places, given, diameters), material=material))
    return drawn


def _body(chain, name) -> RigidBody:
    """The rigid segment of this name."""
    across, along = chain["across", name], chain["along", name]
    inertia = ((across, 0, 0), (0, across, 0), (0, 0, along))
    return RigidBody(mass=chain["mass", name], r_cm=(0, 0, chain["centre", name]), inertia=inertia)


def tube_table(component) -> BeamProperties:
    """The properties of the tube that a component has by its parameters of TUBE; a ParameterError says its path."""
    values = [component.parameter_value(name) for name in TUBE]
    try:
        return _table(*(tuple(np.ravel(value)) for value in values[:3]), *map(float, values[3:]))
    except ParameterError as error:
        raise ParameterError(f"{component.label}: {error}") from None


def chain_numbers(table: BeamProperties, parts: Division, nodes: list[float], cuts: np.ndarray) -> dict[Key, float]:
    """The numbers of a chain from root to tip, by kind and name of the part: places [m], masses, stiffnesses.

    nodes, cuts: their distances from the root [m]. A node's kind names the part that carries it.
    """
    found: dict[Key, float] = {}
    origin, carrier, left = 0.0, "", list(range(len(nodes)))
    for k, height in enumerate(nodes):
        if not -1e-9 <= height <= table.length + 1e-9:
            raise ParameterError(f"node {k + 1} at {height:g} m is off the beam of {table.length:g} m.")
    chain = pieces(table, parts, cuts)
    for piece in chain:
        if piece.hinge or piece.cut:
            found["arm", f"arm_{piece.hinge}" if piece.hinge else f"to_cut_{piece.cut}"] = piece.root[2] - origin
            origin, carrier = piece.root[2], f"hinge_{piece.hinge}" if piece.hinge else f"cut_{piece.cut}"
        if piece.hinge:
            i, name = piece.hinge - 1, carrier
            found |= {("bending", name): parts.stiffness_x[i], ("torsion", name): parts.torsion[i]}
            found["stretch", name] = parts.stretch[i]
        elif piece.cut:
            found["cut", carrier] = 0.0
        segment, name = piece.segment, piece.name
        if segment.end > segment.start:
            found |= {("mass", name): segment.mass, ("centre", name): segment.centre[2] - origin}
            found |= {("across", name): segment.inertia[0, 0], ("along", name): segment.inertia[2, 2]}
            carrier = name
        for k in [k for k in left if nodes[k] <= segment.end or piece is chain[-1]]:
            found[f"node of {carrier}", f"to_node_{k + 1}"] = nodes[k] - origin
            left.remove(k)
    found["arm", "end"] = table.length - origin
    return found


def _chain_numbers(tube: TubeChain) -> list[float]:
    chain = tube.chain()
    if tuple(chain) != tube._chain_keys:
        raise ParameterError(
            f"{tube.label}: with these values of the tube a hinge passes one of its nodes or cuts, which makes another "
            "chain; set them in the model and compile it anew."
        )
    return list(chain.values())


def _point(given) -> tuple[float, float, float]:
    return (0.0, 0.0, float(given)) if np.ndim(given) == 0 else tuple(float(value) for value in given)


@lru_cache(maxsize=KEPT)
def _table(heights, diameters, walls, density, young_modulus, shear_modulus) -> BeamProperties:
    """The same object for the same tube, so that its division is found again."""
    return BeamProperties.tube(
        heights, diameters, walls, density=density, young_modulus=young_modulus, shear_modulus=shear_modulus
    )
