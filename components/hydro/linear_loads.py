"""Loads of the water that are linear in the motion of a platform: hydrostatics, added mass, damping, radiation, waves.

All of them act on a Frame at the reference point of the platform: on its axis, at the still water level when at rest.
Matrices have the order surge, sway, heave, roll, pitch, yaw and refer to that point; moments are about the origin of
the frame where it is now.

One set of axes for all that is linear in motion and waves (added mass, radiation, damping, excitation): forces and
velocities along the vertical and along the horizontal axes that have turned with the yaw of the hull; moments and
angular velocities about the axes of the hull. The power of a load is the product of these components with these rates
exactly, so that radiation that is passive in the data is passive here.

- Forces stay horizontal and vertical because the data are those of an upright hull: a load that leans with the
  oscillating hull is of second order in the wave, where other terms of the same size (pressure at the displaced hull,
  square of the velocity, wetted surface: J.A. Pinkster, 1980) are not known. A part of the sum is worse than none: in
  waves of 6 m and 10 s the product of pitch with A11 surge'' pushes the OC3 spar to a mean heave of -0.046 m, that of
  pitch with X1 by +0.077 m, both together by +0.031 m. All three grow with the square of the wave height; here they
  are not. Nor may one lean without the other: with added mass in axes of the hull and excitation in those of the
  world, the mean pitch at 8 m/s moved the phase of heave by 7 deg.
- Moments turn with the hull, because a spar that leans turns about its own axis as freely as an upright one. About the
  axes of the world, as HydroDyn has them, a mean pitch of 5 deg would give the yaw of the OC3 spar the inertia
  A44 sin^2(5 deg) = 2.9e8 kg m^2 of water, more than its bodies have. The moment of the waves leans likewise: the
  roll moment that beam waves exert on a hull that pitches is about the axis about which the water resists.

What a mean lean changes of the loads themselves is not in the data of an upright hull. By strips, the whole load on a
leaned spar stands normal to its axis, which adds -pitch x surge to its heave (5 deg and 1 m: 0.09 m); data of the hull
in its mean position hold that. The excitation is for a hull whose mean yaw is zero; of a round one it is for any.

Displacement: the origin against its place at rest, the slope of the frame's z axis towards x and y (positive as pitch
and roll are), and the yaw of its x axis, in the heading axes. Stiffness belongs to the waterplane, which stays
horizontal and turns with the yaw: so does its load. The slope is the tangent of the tilt: of a hull with vertical
walls the moment of the waterplane grows as sin(tilt) (1 + tan^2(tilt) / 2), which is the tangent up to the third power
(K.J. Rawson and E.C. Tupper, Basic Ship Theory, the wall-sided formula).

A port's f and t are positive into the component, so what the water gives to the platform has a minus sign in front.
"""

from __future__ import annotations

from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment.sea import Sea
from fowtlib.components.environment.waves import WaveComponents, wave_number
from fowtlib.components.environment.world import World
from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.radiation_identification import RadiationModel, kept_radiation
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import (
    Array,
    Component,
    Data,
    Number,
    Scalar,
    StateSpace,
    Vector,
    assert_,
    data,
    der,
    eq,
    facts,
    linear_operator,
    outer,
    param,
    port,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE
from fowtlib.language.data_files import remembered
from fowtlib.language.operators import Transfer
from fowtlib.language.similarity import six_by_six

LARGEST_TILT = np.radians(45.0)  # of a hull, beyond which a run says that its loads mean nothing


@remembered()
def read_database(path: str | Path) -> HydrodynamicDatabase:
    """HydrodynamicDatabase.read; the same object while the content of the file is the same."""
    return HydrodynamicDatabase.read(path)


class PlatformLoad(Component):
    """A load on the reference point of a platform. Partial: a subclass writes the equations."""

    frame: Frame = port(doc="reference point of the platform, at the still water level on its axis")

    def velocity(self):
        """Velocity and angular velocity (6,), world."""
        return m.vertcat(der(self.frame.r), self.frame.w)

    def heading_axes(self):
        """Axes (3, 3, world) that are upright and have turned about the vertical with the yaw of the frame's x axis."""
        forward, aside = self.frame.R[0, 0], self.frame.R[1, 0]
        length = m.sqrt(forward**2 + aside**2)
        c, s = forward / length, aside / length
        return m.vertcat(m.horzcat(c, -s, 0), m.horzcat(s, c, 0), m.horzcat(0, 0, 1))

    def in_own_axes(self, motion):
        """A velocity or acceleration (6,), world, with its first half in the heading axes, its second in the hull's."""
        return m.vertcat(self.heading_axes().T @ motion[:3], self.frame.R.T @ motion[3:])

    def push_in_own_axes(self, load):
        """The water gives `load` to the platform: force in the heading axes, moment in the axes of the hull."""
        return self.push(m.vertcat(self.heading_axes() @ load[:3], self.frame.R @ load[3:]))

    def displacement(self, position):
        """Displacement (3,) from `position`, slope about x and y, yaw (6,), in the heading axes."""
        axes, R = self.heading_axes(), self.frame.R
        upward = axes.T @ R[:, 2]
        slope = m.vertcat(-upward[1], upward[0]) / upward[2]
        return m.vertcat(axes.T @ (self.frame.r - position), slope, m.atan2(R[1, 0], R[0, 0]))

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

    units_within = {"stiffness": six_by_six("N/m")}

    volume: Scalar = param(unit="m^3", min=0, doc="displaced volume at rest")
    centre_of_buoyancy: Vector = param(unit="m", doc="centre of that volume, resolved in the frame")
    stiffness: Array = param(shape=(6, 6), form="symmetric", doc="C_w, without buoyancy moments, SI")
    reference_density: Number = param(default=1025.0, unit="kg/m^3", min=POSITIVE, doc="water density rho_0 of C_w")
    position: Vector = param(default=(0, 0, 0), unit="m", doc="place of the frame at rest, world")

    world: World = outer(World)

    buoyancy: Scalar = var(unit="N", doc="buoyancy of the volume at rest")

    def equations(self):
        lift = m.vertcat(0, 0, self.buoyancy)
        scale = self.world.water_density / self.reference_density
        axes = self.heading_axes()
        load = -scale * m.mtimes(self.stiffness, self.displacement(self.position))
        restoring = m.vertcat(axes @ load[:3], axes @ load[3:])
        return [
            eq(self.buoyancy, self.world.water_density * self.world.gravity * self.volume),
            self.push(restoring + m.vertcat(lift, m.cross(self.frame.R @ self.centre_of_buoyancy, lift))),
            assert_(
                self.frame.R[2, 2] > np.cos(LARGEST_TILT),
                "the hull is tilted by more than 45 deg, far outside of what the stiffness of its waterplane is "
                "good for; is its start, or a moment on it, meant so?",
                level="warning",
            ),
        ]

    def facts(self) -> list[facts.Fact]:
        volume, centre, stiffness, reference = (
            np.asarray(self.parameter_value(name), dtype=float)
            for name in ("volume", "centre_of_buoyancy", "stiffness", "reference_density")
        )
        density, gravity = (self.world.parameter_value(name) for name in ("water_density", "gravity"))
        C = stiffness_with_buoyancy(density / reference * stiffness, density * gravity * volume, centre)
        return [
            facts.Number("displaced volume", volume, "m^3"),
            facts.Number("centre of buoyancy", centre, "m"),
            facts.Loads("C", C, "N/m"),
        ]


def waterplane_stiffness(database: HydrodynamicDatabase) -> NDArray[np.float64]:
    """C (6, 6) of the database without the moments of the buoyancy: what Hydrostatics takes; noise is set to zero."""
    lift = database.rho * database.g * database.volume
    stiffness = stiffness_without_buoyancy(database.C, lift, database.centre_of_buoyancy)
    length = np.array([1.0, 1.0, 1.0, *[database.volume ** (1 / 3)] * 3])
    noise = 1e-9 * database.rho * database.g * database.volume ** (2 / 3) * np.outer(length, length)
    return np.where(np.abs(stiffness) > noise, stiffness, 0.0)


def stiffness_without_buoyancy(stiffness: NDArray[np.float64], lift: float, centre: ArrayLike) -> NDArray[np.float64]:
    """C (6, 6) without the moments of the buoyancy `lift` [N] at its centre (3,): C44, C55, C46 and C56."""
    x, y, z = np.asarray(centre, dtype=float)
    plane = np.array(stiffness, dtype=float)
    plane[[3, 4], [3, 4]] -= lift * z
    plane[[3, 4], [5, 5]] += lift * np.array([x, y])
    return plane


def stiffness_with_buoyancy(plane: NDArray[np.float64], lift: float, centre: ArrayLike) -> NDArray[np.float64]:
    """C (6, 6) of a waterplane with the moments of the buoyancy `lift` [N] at its centre (3,)."""
    return stiffness_without_buoyancy(plane, -lift, centre)


class AddedMass(PlatformLoad):
    """Inertia of the water that moves with the body at once: f, t = rho/rho_0 A q'', with A at infinite frequency.

    It stands in the mass matrix of the platform, like the mass of a body. Axes of the module; linear, so without the
    gyroscopic terms of a yawing hull.
    Source: W.E. Cummins, Schiffstechnik 9 (1962) 101-109.
    """

    units_within = {"matrix": six_by_six("kg")}

    matrix: Array = param(shape=(6, 6), form="symmetric", doc="added mass at infinite frequency, SI")
    reference_density: Number = param(
        default=1025.0, unit="kg/m^3", min=POSITIVE, doc="water density rho_0 of the matrix"
    )

    world: World = outer(World)

    def equations(self):
        scale = self.world.water_density / self.reference_density
        return self.push_in_own_axes(-scale * m.mtimes(self.matrix, self.in_own_axes(der(self.velocity()))))

    def facts(self) -> list[facts.Fact]:
        matrix, reference = (np.asarray(self.parameter_value(name)) for name in ("matrix", "reference_density"))
        scale = self.world.parameter_value("water_density") / reference
        return [facts.Loads("A(inf)", scale * matrix, "kg")]


class LinearDamping(PlatformLoad):
    """A load -B q' against the velocity, axes of the module: diagonal, plus a full `matrix`."""

    units_within = {"matrix": six_by_six("N*s/m")}

    translation: Vector = param(default=(0, 0, 0), unit="N*s/m", doc="damping of surge, sway, heave")
    rotation: Vector = param(default=(0, 0, 0), unit="N*m*s/rad", doc="damping of roll, pitch, yaw")
    matrix: Array = param(default=None, shape=(6, 6), doc="damping matrix, SI; without a value: none")

    def equations(self):
        velocity = self.in_own_axes(self.velocity())
        diagonal = m.vertcat(self.translation * velocity[:3], self.rotation * velocity[3:])
        coupled = m.mtimes(self.matrix, velocity) if self.matrix is not None else 0
        return self.push_in_own_axes(-diagonal - coupled)


class Radiation(PlatformLoad):
    """Memory of the waves that the body has made: x' = A x + B q', load = -rho/rho_0 C x, at rest at the start.

    The model is identified from the damping of the database while the model is flattened (0.1 s), see
    radiation_identification; str(radiation.model()) reports the fit. At frequencies (response amplitude operators) the
    load is that of the database itself, A(omega) and B(omega).
    """

    units_within = {"x": ()}  # each state of the fitted model has that of the row it stands for

    memory = "radiated waves"

    database: Data[HydrodynamicDatabase] = data(read_database, doc="file of a HydrodynamicDatabase, or one itself")
    order: int = param(default=4, min=2, doc="states per motion (surge, sway, ...); coupled motions share theirs")
    passive: bool = param(default=True, doc="never feeds energy to the body; false: a little closer to the damping")

    world: World = outer(World)

    x: Array = var(shape=lambda self: (self.model().states,), doc="states of the radiation model")
    force: Vector = var(unit="N", doc="radiation force on the platform, axes turned with its yaw")
    moment: Vector = var(unit="N*m", doc="radiation moment on the platform, axes of the hull")

    def model(self) -> RadiationModel:
        """The identified state-space model, with its report."""
        return _radiation(self.database, self.order, self.passive)

    def load(self):
        """The load on all motions, axes of the module."""
        return m.vertcat(self.force, self.moment)

    def equations(self):
        model = self.model()
        known = self.database
        load, realized = self.load(), StateSpace(model.A, model.B, model.C)
        return [
            linear_operator(
                load, self.in_own_axes(self.velocity()), RadiationTransfer(known, realized), realized, self.x,
                scale=-self.world.water_density / known.rho,
            ),
            self.push_in_own_axes(load),
        ]  # fmt: skip


class RadiationTransfer:
    """H = B(omega) + i omega (A(omega) - A_inf) of a database, complex (n, 6, 6): load -H q' for exp(+i omega t).

    Between the frequencies of the data by Akima's interpolation; outside of them, where the data say nothing, that of
    the realization. Source: T.F. Ogilvie, 5th Symposium on Naval Hydrodynamics (1964).
    """

    def __init__(self, data: HydrodynamicDatabase | ModalDatabase, realization: StateSpace):
        self.range, self.realization, self._data = (data.omega[0], data.omega[-1]), realization, data

    @cached_property
    def known(self) -> Transfer:
        """H between the frequencies of the data."""
        from scipy.interpolate import Akima1DInterpolator  # a run in time asks for none, and it takes long to import

        damping = Akima1DInterpolator(self._data.omega, self._data.B, method="akima")
        added = Akima1DInterpolator(self._data.omega, self._data.A - self._data.A_inf, method="akima")
        return lambda omega: damping(omega) + 1j * omega[:, None, None] * added(omega)

    def __call__(self, omega: np.ndarray) -> np.ndarray:
        transfer = np.array(self.realization.transfer(omega))
        inside = (omega >= self.range[0]) & (omega <= self.range[1])
        transfer[inside] = self.known(omega[inside])
        return transfer


class WaveExcitation(PlatformLoad):
    """First-order load of the incoming and diffracted waves, sum of Re(a_k X(omega_k, heading) exp(i omega_k t + ...)).

    It acts on the platform at rest: motion changes neither its size nor its phase. `position` moves the phase with the
    waves. `extra_force` and `extra_moment` are the inputs of linear models; with `wave_transfer` they give response
    amplitude operators. The moment leans with the hull.
    Source: J.N. Newman, Marine Hydrodynamics (1977), 6.18.
    """

    wave_inputs = ("extra_force", "extra_moment")

    database: Data[HydrodynamicDatabase] = data(read_database, doc="file of a HydrodynamicDatabase, or one itself")
    position: Vector = param(default=(0, 0, 0), unit="m", bound=True, doc="place of the frame at rest, world")
    extra_force: Vector = param(default=(0, 0, 0), unit="N", doc="force added to that of the waves, world")
    extra_moment: Vector = param(default=(0, 0, 0), unit="N*m", doc="moment added to that of the waves, leaning too")

    world: World = outer(World)
    sea: Sea = outer(Sea)

    force: Vector = var(unit="N", doc="wave force on the platform, world")
    moment: Vector = var(unit="N*m", doc="wave moment on the platform, world axes leant as the hull")

    def equations(self):
        scale = self.world.water_density / self.database.rho
        given = self.sea.loads(_excitation, motions=self.motions(), of=self)
        return [self.driven(scale * given), self.push(self.load())]

    def motions(self) -> int:
        """How many motions have a load: the rigid ones."""
        return 6

    def driven(self, load):
        """What the waves drive, with what is added to it."""
        return [eq(self.force, load[:3] + self.extra_force), eq(self.moment, load[3:6] + self.extra_moment)]

    def load(self):
        """The load on the platform, world."""
        return m.vertcat(self.force, self.frame.R @ self.heading_axes().T @ self.moment)

    def wave_transfer(self, omega, heading):
        """Complex load (n, 6) per unit wave amplitude, at circular frequencies [rad/s] and a heading [rad]."""
        database = self.database
        k = wave_number(omega, self.world.water_depth, self.world.gravity)
        x, y, _ = np.asarray(self.parameter_value("position"), dtype=float)
        phase = np.exp(-1j * k * (x * np.cos(heading) + y * np.sin(heading)))
        scale = self.world.parameter_value("water_density") / database.rho
        return scale * database.excitation_at(np.asarray(omega), heading) * phase[:, None]


def _excitation(waves: WaveComponents, part: WaveExcitation) -> NDArray[np.complex128]:
    """Load (n, 6, or more for shapes) per unit amplitude of the waves of a run."""
    load = part.database.excitation_at(waves.omega, waves.heading)
    return load * waves.elevation_transfer(part.parameter_value("position"))


@lru_cache(maxsize=8)
def _radiation(data: HydrodynamicDatabase, order: int, passive: bool) -> RadiationModel:
    return kept_radiation(data.omega, data.B, data.A, data.A_inf, order=order, passive=passive)
