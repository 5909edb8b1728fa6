"""Loads of the water that are linear in the motion of a platform: hydrostatics, added mass, damping, radiation, waves.

All of them act on a Frame at the reference point of the platform: on its axis, at the still water level when at rest.
Matrices have the order surge, sway, heave, roll, pitch, yaw and refer to that point. Forces and moments are resolved in
the world, moments are about the origin of the frame where it is now.

Added mass, damping and radiation are properties of the hull and refer to its axes: a spar that leans turns about its
own axis as freely as an upright one. In the axes of the world, as HydroDyn has them, a mean pitch of 5 deg would give
the yaw of the OC3 spar the inertia A44 sin^2(5 deg) = 2.9e8 kg m^2 of water, more than its bodies have. Wave loads and
stiffness refer to the axes of the world.

Displacement: the origin against its place at rest, the tilt about x and y of the frame's z axis, and the yaw of its
x axis. The tilt is that of the vertical seen from the world, atan2(-R23, R33) and atan2(R13, R33): equal to roll and
pitch without yaw, and still right for a platform that has yawed, whose roll and pitch axes have turned. HydroDyn takes
the angles of a small rotation from R as well; the two agree to first order.

A port's f and t are positive into the component, so what the water gives to the platform has a minus sign in front.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import wave_number
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.radiation_identification import RadiationModel, kept_radiation
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Array, Component, Scalar, Vector, der, eq, outer, param, port, var
from fowtlib.language import math as m


class PlatformLoad(Component):
    """A load on the reference point of a platform. Partial: a subclass writes the equations."""

    frame: Frame = port(doc="reference point of the platform, at the still water level on its axis")

    def velocity(self):
        """Velocity and angular velocity (6,), world."""
        return m.vertcat(der(self.frame.r), self.frame.w)

    def in_hull(self, motion):
        """A velocity or acceleration (6,), world, resolved in the axes of the hull."""
        R = self.frame.R
        return m.vertcat(R.T @ motion[:3], R.T @ motion[3:])

    def push_in_hull(self, load):
        """The water gives `load` (6,), resolved in the axes of the hull, to the platform."""
        R = self.frame.R
        return self.push(m.vertcat(R @ load[:3], R @ load[3:]))

    def displacement(self, position):
        """Displacement (3,) from `position`, tilt about x and y, yaw (6,), world."""
        r, R = self.frame.r, self.frame.R
        tilt = m.vertcat(m.atan2(-R[1, 2], R[2, 2]), m.atan2(R[0, 2], R[2, 2]))
        return m.vertcat(r - position, tilt, m.atan2(R[1, 0], R[0, 0]))

    def push(self, load):
        """The water gives `load` (6,) to the platform."""
        return [eq(self.frame.f, -load[:3]), eq(self.frame.t, -load[3:])]


class Hydrostatics(PlatformLoad):
    """Buoyancy of the volume displaced at rest, at its centre, which moves with the body, and waterplane stiffness.

    f = rho g V z and t = (R r_B) x f, and -rho/rho_0 C_w q with the displacement q. The weight is not in it: gravity
    acts on the bodies. C_w is rho_0 g times the moments of the waterplane: C33 = rho g S, C34 = rho g S_y,
    C35 = -rho g S_x, C44 = rho g S_yy, C45 = -rho g S_xy, C55 = rho g S_xx. The C of a WAMIT .hst file (without weight)
    has the moments of the buoyancy in it: C44, C55 + rho g V z_B; C46 - rho g V x_B; C56 - rho g V y_B.
    `waterplane_stiffness` takes them off, because here the buoyancy turns exactly, with the sine of the angle, as the
    weight of the bodies does; at small angles the sum is that of the file.
    Source: J.N. Newman, Marine Hydrodynamics (1977), 6.16; WAMIT User Manual 7, section 3.1.
    """

    volume: Scalar = param(unit="m^3", min=0, doc="displaced volume at rest")
    centre_of_buoyancy: Vector = param(unit="m", doc="centre of that volume, resolved in the frame")
    stiffness: Array = param(shape=(6, 6), structural=True, doc="C_w, without buoyancy moments, SI")
    reference_density: float = param(default=1025.0, unit="kg/m^3", min=0, doc="water density rho_0 of C_w")
    position: Vector = param(default=(0, 0, 0), unit="m", structural=True, doc="place of the frame at rest, world")

    world: World = outer(World)

    buoyancy: Scalar = var(unit="N", doc="buoyancy of the volume at rest")

    def equations(self):
        lift = m.vertcat(0, 0, self.buoyancy)
        scale = self.world.water_density / self.reference_density
        restoring = -scale * m.mtimes(self.stiffness, self.displacement(self.position))
        return [
            eq(self.buoyancy, self.world.water_density * self.world.gravity * self.volume),
            self.push(restoring + m.vertcat(lift, m.cross(self.frame.R @ self.centre_of_buoyancy, lift))),
        ]


def waterplane_stiffness(database: HydrodynamicDatabase) -> NDArray[np.float64]:
    """C (6, 6) of the database without the moments of the buoyancy: what Hydrostatics takes; noise is set to zero."""
    lift = database.rho * database.g * database.volume
    x, y, z = database.centre_of_buoyancy
    stiffness = database.C.copy()
    stiffness[[3, 4], [3, 4]] -= lift * z
    stiffness[[3, 4], [5, 5]] += lift * np.array([x, y])
    length = np.array([1.0, 1.0, 1.0, *[database.volume ** (1 / 3)] * 3])
    noise = 1e-9 * database.rho * database.g * database.volume ** (2 / 3) * np.outer(length, length)
    return np.where(np.abs(stiffness) > noise, stiffness, 0.0)


class AddedMass(PlatformLoad):
    """Inertia of the water that moves with the body at once: f, t = rho/rho_0 A q'', with A at infinite frequency.

    It stands in the mass matrix of the platform, like the mass of a body. Axes of the hull; linear, so without the
    gyroscopic terms.
    Source: W.E. Cummins, Schiffstechnik 9 (1962) 101-109.
    """

    matrix: Array = param(shape=(6, 6), structural=True, doc="added mass at infinite frequency, SI")
    reference_density: float = param(default=1025.0, unit="kg/m^3", min=0, doc="water density rho_0 of the matrix")

    world: World = outer(World)

    def equations(self):
        scale = self.world.water_density / self.reference_density
        return self.push_in_hull(-scale * m.mtimes(self.matrix, self.in_hull(der(self.velocity()))))


class LinearDamping(PlatformLoad):
    """A load -B q' against the velocity, axes of the hull: diagonal, plus a full `matrix`."""

    translation: Vector = param(default=(0, 0, 0), unit="N*s/m", doc="damping of surge, sway, heave")
    rotation: Vector = param(default=(0, 0, 0), unit="N*m*s/rad", doc="damping of roll, pitch, yaw")
    matrix: Array = param(default=np.zeros((6, 6)), shape=(6, 6), structural=True, doc="damping matrix, SI")

    def equations(self):
        velocity = self.in_hull(self.velocity())
        diagonal = m.vertcat(self.translation * velocity[:3], self.rotation * velocity[3:])
        return self.push_in_hull(-diagonal - m.mtimes(self.matrix, velocity))


class Radiation(PlatformLoad):
    """Memory of the waves that the body has made: x' = A x + B q', load = -rho/rho_0 C x, at rest at the start.

    The model is identified from the damping of the database while the model is flattened (0.1 s), see
    radiation_identification; str(radiation.model()) reports the fit.
    """

    memory = "radiated waves"

    database: str = param(doc="file of a HydrodynamicDatabase")
    order: int = param(default=4, min=2, doc="states per motion (surge, sway, ...); coupled motions share theirs")
    passive: bool = param(default=True, doc="never feeds energy to the body; false: a little closer to the damping")

    world: World = outer(World)

    x: Array = var(shape=lambda self: (self.model().states,), doc="states of the radiation model")
    force: Vector = var(unit="N", doc="radiation force on the platform, axes of the hull")
    moment: Vector = var(unit="N*m", doc="radiation moment on the platform, axes of the hull")

    def model(self) -> RadiationModel:
        """The identified state-space model, with its report."""
        return _radiation(self.database, Path(self.database).stat().st_mtime, self.order, self.passive)

    def equations(self):
        model = self.model()
        scale = self.world.water_density / read_database(self.database).rho
        load = m.vertcat(self.force, self.moment)
        statements = [eq(load, -scale * m.mtimes(model.C, self.x)), self.push_in_hull(load)]
        if model.states:
            statements.append(
                eq(der(self.x), m.mtimes(model.A, self.x) + m.mtimes(model.B, self.in_hull(self.velocity())))
            )
        return statements


class WaveExcitation(PlatformLoad):
    """First-order load of the incoming and diffracted waves, sum of Re(a_k X(omega_k, heading) exp(i omega_k t + ...)).

    It acts on the platform at rest: motion changes neither its size nor its phase. `position` moves the phase with the
    waves. `extra_force` and `extra_moment` are the inputs of linear models; with `wave_transfer` they give response
    amplitude operators.
    Source: J.N. Newman, Marine Hydrodynamics (1977), 6.18.
    """

    wave_inputs = ("extra_force", "extra_moment")

    database: str = param(doc="file of a HydrodynamicDatabase")
    position: Vector = param(default=(0, 0, 0), unit="m", structural=True, doc="place of the frame at rest, world")
    extra_force: Vector = param(default=(0, 0, 0), unit="N", doc="force added to that of the waves, world")
    extra_moment: Vector = param(default=(0, 0, 0), unit="N*m", doc="moment added to that of the waves, world")

    world: World = outer(World)
    sea: Sea = outer(Sea)

    force: Vector = var(unit="N", doc="wave force on the platform, world")
    moment: Vector = var(unit="N*m", doc="wave moment on the platform, world")

    def equations(self):
        database, waves = read_database(self.database), self.sea.components()
        transfer = np.zeros((len(waves), 6), dtype=complex)
        if len(waves):
            transfer = database.excitation_at(waves.omega, waves.heading) * waves.elevation_transfer(self.position)
        scale = self.world.water_density / database.rho
        load = scale * self.sea.loads(transfer)
        return [
            eq(self.force, load[:3] + self.extra_force),
            eq(self.moment, load[3:] + self.extra_moment),
            self.push(m.vertcat(self.force, self.moment)),
        ]

    def wave_transfer(self, omega, heading):
        """Complex load (n, 6) per unit wave amplitude, at circular frequencies [rad/s] and a heading [rad]."""
        database = read_database(self.database)
        k = wave_number(omega, self.world.water_depth, self.world.gravity)
        x, y, _ = np.asarray(self.position, dtype=float)
        phase = np.exp(-1j * k * (x * np.cos(heading) + y * np.sin(heading)))
        scale = self.world.parameter_value("water_density") / database.rho
        return scale * database.excitation_at(np.asarray(omega), heading) * phase[:, None]


def read_database(path: str | Path) -> HydrodynamicDatabase:
    """HydrodynamicDatabase.read, remembered while the file is the same."""
    try:
        changed = Path(path).stat().st_mtime
    except OSError:
        return HydrodynamicDatabase.read(path)
    return _database(str(path), changed)


@lru_cache(maxsize=8)
def _database(path: str, changed: float) -> HydrodynamicDatabase:
    return HydrodynamicDatabase.read(path)


@lru_cache(maxsize=8)
def _radiation(path: str, changed: float, order: int, passive: bool) -> RadiationModel:
    data = _database(path, changed)
    return kept_radiation(data.omega, data.B, data.A, data.A_inf, order=order, passive=passive)
