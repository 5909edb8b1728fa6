"""Loads of the water that are linear in the motion of a body that deforms: those of linear_loads, and of its shapes.

Vectors have the six rigid motions first, in the axes of linear_loads, and then the coordinates of the shapes.
"""

from __future__ import annotations

from pathlib import Path

from fowtlib.components.environment.world import World
from fowtlib.components.hydro.linear_loads import AddedMass, PlatformLoad, Radiation, WaveExcitation
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_radiation import kept_modal_radiation
from fowtlib.components.hydro.potential_flow import LinearPotentialFlow
from fowtlib.components.hydro.turning_waves import TurningWaveExcitation
from fowtlib.components.mechanics.connectors import ModalCoordinates
from fowtlib.language import Array, Data, Number, Vector, data, der, eq, outer, param, port, var
from fowtlib.language import math as m
from fowtlib.language.data_files import remembered
from fowtlib.language.similarity import six_by_six


@remembered()
def read_modal_database(path: str | Path) -> ModalDatabase:
    """ModalDatabase.read; the same object while the content of the file is the same."""
    return ModalDatabase.read(path)


class ModalLoad(PlatformLoad):
    """A load on the reference point of a platform and on its shapes. Partial: a subclass writes the equations."""

    shapes: int = param(min=1, doc="number of shapes")

    modes: ModalCoordinates = port(shape="shapes", doc="coordinates of the shapes")

    def velocity(self):
        return m.vertcat(super().velocity(), der(self.modes.q))

    def in_own_axes(self, motion):
        return m.vertcat(super().in_own_axes(motion[:6]), motion[6:])

    def push_in_own_axes(self, load):
        force, moment = self.heading_axes() @ load[:3], self.frame.R @ load[3:6]
        return self.push(m.vertcat(force, moment, load[6:]))

    def push(self, load):
        return [eq(self.frame.f, -load[:3]), eq(self.frame.t, -load[3:6]), eq(self.modes.f, -load[6:])]


class ModalAddedMass(ModalLoad, AddedMass):
    """Inertia of the water that moves at once with the body and its shapes; see AddedMass."""

    units_within = {"matrix": lambda self: six_by_six("kg", self.shapes)}

    matrix: Array = param(
        shape=lambda self: (6 + self.shapes, 6 + self.shapes), doc="added mass at infinite frequency, SI"
    )

    def facts(self):
        return []


class ModalRadiation(ModalLoad, Radiation):
    """Memory of the waves that the body and its shapes have made; see Radiation, and modal_radiation for the model."""

    database: Data[ModalDatabase] = data(read_modal_database, doc="file of a ModalDatabase, or one itself")

    on_shapes: Array = var(shape="shapes", unit="N", doc="radiation load on the shapes")

    def model(self):
        return kept_modal_radiation(self.database, self.order, self.passive)

    def load(self):
        return m.vertcat(super().load(), self.on_shapes)


class ModalWaveExcitation(ModalLoad, WaveExcitation):
    """First-order load of the waves on the body and its shapes; see WaveExcitation."""

    wave_inputs = ("extra_force", "extra_moment", "extra_on_shapes")

    database: Data[ModalDatabase] = data(read_modal_database, doc="file of a ModalDatabase, or one itself")
    extra_on_shapes: Array = param(
        default=lambda self: [0.0] * self.shapes, shape="shapes", unit="N", doc="load added to that on the shapes"
    )

    on_shapes: Array = var(shape="shapes", unit="N", doc="wave load on the shapes")

    def motions(self):
        return 6 + self.shapes

    def driven(self, load):
        return [*super().driven(load), eq(self.on_shapes, load[6:] + self.extra_on_shapes)]

    def load(self):
        return m.vertcat(super().load(), self.on_shapes)


class TurningModalWaveExcitation(ModalWaveExcitation, TurningWaveExcitation):
    """The same on a body that also turns far about the vertical: all loads by its heading relative to the waves, now.

    Shapes are those of the body, so that their loads need no axes. See TurningWaveExcitation.
    """


class ShapeHydrostatics(ModalLoad):
    """Stiffness that buoyancy gives shapes: between them, and with heave, roll and pitch (slopes) both ways.

    load on shapes = -among q - with_rigid d, on the platform -with_rigid^T q in its heading axes: buoyancy has a
    potential. See hydro.deformation.
    """

    units_within = {"with_rigid": ("N/m", "N/m", "N/m", "N", "N", "N")}

    among: Array = param(shape=("shapes", "shapes"), unit="N/m", doc="stiffness between shapes")
    with_rigid: Array = param(shape=("shapes", 6), doc="stiffness of shapes with the rigid motions, SI")
    reference_density: Number = param(default=1025.0, unit="kg/m^3", min=0, doc="water density of both")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame at rest, world")

    world: World = outer(World)

    def equations(self):
        scale, axes, q = self.world.water_density / self.reference_density, self.heading_axes(), self.modes.q
        on_shapes = m.mtimes(self.among, q) + m.mtimes(self.with_rigid, self.displacement(self.position))
        back = m.mtimes(self.with_rigid.T, q)
        return self.push(-scale * m.vertcat(axes @ back[:3], axes @ back[3:], on_shapes))


class ModalPotentialFlow(LinearPotentialFlow):
    """Added mass, radiation, wave excitation and the stiffness of shapes of a body that deforms, from one database.

    As a LinearPotentialFlow without the buoyancy of the rigid body, with a port for the shapes.
    """

    database: Data[ModalDatabase] = data(read_modal_database, doc="file of a ModalDatabase, or one itself")
    shapes: int = param(min=1, doc="number of shapes")

    modes: ModalCoordinates = port(shape="shapes", doc="coordinates of the shapes")

    def build(self):
        known, given, place, count = self.database, self.parameter_binding("database"), self.position, self.shapes
        self.added_mass = ModalAddedMass(shapes=count, matrix=known.A_inf, reference_density=known.rho)
        self.stiffness = ShapeHydrostatics(
            shapes=count, among=known.among, with_rigid=known.with_rigid, reference_density=known.rho, position=place
        )
        if self.radiation_order:
            self.radiation = ModalRadiation(shapes=count, database=given, order=self.radiation_order)
        if self.excitation:
            kind = TurningModalWaveExcitation if self.turning else ModalWaveExcitation
            self.waves = kind(shapes=count, database=given, position=place)
        for load in self.parts.values():
            self.connect(self.frame, load.frame)
            self.connect(self.modes, load.modes)

    def facts(self):
        return []
