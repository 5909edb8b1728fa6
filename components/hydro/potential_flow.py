"""The linear potential-flow loads of a platform, from one hydrodynamic database."""

from __future__ import annotations

from fowtlib.components.environment.world import World
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.linear_loads import (
    AddedMass,
    Hydrostatics,
    Radiation,
    WaveExcitation,
    read_database,
    waterplane_stiffness,
)
from fowtlib.components.hydro.turning_waves import TurningWaveExcitation
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, Data, Vector, data, facts, outer, param, port
from fowtlib.language.errors import ParameterError


class FlowSettings(Component):
    """Partial: what of a database acts on a hull."""

    radiation_order: int = param(default=4, min=0, doc="states per motion of the radiation memory; 0: none")
    excitation: bool = param(default=True, doc="wave loads of the database; the model needs a Sea for them")
    turning: bool = param(default=False, doc="the hull turns far about the vertical; see TurningWaveExcitation")


class LinearPotentialFlow(FlowSettings):
    """Hydrostatics, added mass, radiation and wave excitation of a floating body on one frame, from one database.

    The frame is the point (0, 0, 0) of the database, fixed to the body; `position` is its place at rest. Gravity and
    water depth of the World must be those of the database (0.1 % and 1 %); all loads scale with the World's density.
    Conventions: module linear_loads. Drag is another part: MorisonDrag.
    """

    database: Data[HydrodynamicDatabase] = data(read_database, doc="file of a HydrodynamicDatabase, or one itself")
    buoyancy: bool = param(default=True, doc="hydrostatics of the database; false where another part has them")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame at rest, world")

    world: World = outer(World)
    frame: Frame = port(doc="reference point of the body, at the still water level on its axis")

    def build(self):
        known, given, place = self.database, self.parameter_binding("database"), self.position
        if self.buoyancy:
            self.hydrostatics = Hydrostatics(
                volume=known.volume,
                centre_of_buoyancy=known.centre_of_buoyancy,
                stiffness=waterplane_stiffness(known),
                reference_density=known.rho,
                position=place,
            )
        self.added_mass = AddedMass(matrix=known.A_inf, reference_density=known.rho)
        if self.radiation_order:
            self.radiation = Radiation(database=given, order=self.radiation_order)
        if self.excitation:
            kind = TurningWaveExcitation if self.turning else WaveExcitation
            self.waves = kind(database=given, position=place)
        for load in self.parts.values():
            self.connect(self.frame, load.frame)

    def equations(self):
        known = self.database
        if self.turning and not any(isinstance(load, TurningWaveExcitation) for load in self.parts.values()):
            raise ParameterError(
                f"{self.label}.turning is true, and there is no wave load that could know of a turn: leave it false "
                "where there is no excitation."
            )
        given = {"gravity": (known.g, 1e-3, "m/s^2"), "water_depth": (known.water_depth, 1e-2, "m")}
        for name, (expected, tolerance, unit) in given.items():
            value = getattr(self.world, name)
            if abs(value - expected) > tolerance * min(value, expected):
                raise ParameterError(
                    f"{self.world.label}.{name} is {value:g} {unit}, and {self.label}.database was computed for "
                    f"{expected:g} {unit}: change the one or compute the other again."
                )
        return []

    def facts(self) -> list[facts.Fact]:
        known = self.database
        scale = self.world.parameter_value("water_density") / known.rho
        return [] if known.A_zero is None else [facts.Loads("A(0)", scale * known.A_zero, "kg")]
