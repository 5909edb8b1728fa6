"""Random fields of velocity in a linear model: what a rotor that turns through one feels, as inputs that do not turn.

A field gives velocities at positions, in an external function. Where the positions turn with a rotor, the velocity at
each blade is a mix of what the ring at its radius has all round: with the angle theta of a place, uniform + cos(theta)
times one part + sin(theta) times the other. Averaged over a turn that is what the slow motions of the model feel, see
components.environment.disc_turbulence for the spectra of these parts; higher orders come in by the turning there.

Along the flow the loads of a blade depend on the velocity in the same way all round. Across it the velocity turns
against the blade, so that its slope goes once round, and what a blade does to the hub twice: there the parts that go
twice round count too. The components of the velocity are independent, each a process of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.expressions import parameters_read
from fowtlib.language.run_time import RandomField, RestingPlaces, TurningRings
from fowtlib.solving.binding import tree_with
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.state import State
from fowtlib.solving.turning import Turn

STEP = 1e-4  # rad of azimuth, for the direction of the turning
POINTS, _WEIGHTS = np.polynomial.hermite_e.hermegauss(7)
SPEEDS = tuple(zip(POINTS.tolist(), (_WEIGHTS / _WEIGHTS.sum()).tolist(), strict=True))  # of a Gaussian speed


@dataclass(frozen=True, eq=False)
class FieldPlaces:
    """Where one external asks a random field for one component of the velocity.

    part: number of the component; external: number of the external, positions: function of its positions; places: what
    these are; axes: of the components (parts, 3), the first along the flow. turn: number of the rotor they turn with;
    spread [rad/s]: deviation of its speed, see density.
    """

    path: str
    owner: str
    compute: RandomField
    part: int
    external: int
    positions: ca.Function
    places: TurningRings | RestingPlaces
    axes: np.ndarray
    turn: int = -1
    spread: float = 0.0

    @property
    def labels(self) -> list[str]:
        """What the inputs are called."""
        name = f"{self.compute.parts[self.part]} {self.path} {self.external}".strip()
        return [f"{name} [{k}]" for k in range(self.places.channels)]

    @property
    def velocities(self) -> list[str]:
        """What the velocities (3 n) are called, those of all components."""
        return [f"{self.path} {self.external} velocity [{k}]" for k in range(self.positions.size1_out(0))]

    def process(self, root: Component) -> str:
        """What the process is called in a run."""
        path = self.compute.process(root.find(self.owner)).path
        return f"{self.compute.parts[self.part]} {path}".strip()

    def along_axes(self, away: float = 0.0) -> TurningRings | RestingPlaces:
        """The places along the axes of the field; away: of the speed from its mean, over its deviation."""
        if isinstance(self.places, RestingPlaces):
            return RestingPlaces(self.places.positions @ self.axes.T)
        speed = self.places.speed + away * self.spread
        return replace(self.places, centre=self.axes @ self.places.centre, speed=speed)

    def mixing(self, at: AtParameters, *point: Any) -> np.ndarray:
        """How the velocities (3 n) at a point follow from the channels: (3 n, channels)."""
        n = self.positions.size1_out(0) // 3
        if isinstance(self.places, RestingPlaces):
            parts = np.eye(n)
        else:
            angle = angles(self._at(at, *point), self.places, self.axes)
            ring = np.tile(np.eye(len(self.places.radii)), (self.places.blades, 1))
            turned = [turn(order * angle)[:, None] * ring for order in range(1, self.places.orders + 1)
                      for turn in (np.cos, np.sin)]  # fmt: skip
            parts = np.hstack([ring, *turned])
        return np.kron(parts, self.axes[self.part][:, None])

    def _at(self, at: AtParameters, *point: Any) -> np.ndarray:
        return np.array(at.call(self.positions, *point)).reshape(-1, 3)


def angles(positions: np.ndarray, rings: TurningRings, axes: np.ndarray) -> np.ndarray:
    """Angles (n,) of places about the flow, whose direction is the first of the axes, in the sense of their turning."""
    across = (positions - rings.centre) @ axes[1:].T
    return np.sign(rings.speed) * np.arctan2(across[:, 1], across[:, 0])


def field_places(plant: Any, at: AtParameters, state: State, turns: Sequence[Turn]) -> list[FieldPlaces]:
    """All places at which parts of a plant ask for a random field, about a mean state; by components."""
    dae, q = plant.dae, np.concatenate([state.u, state.d])
    fields = [(number, item) for number, item in dae.with_data if hasattr(item.compute, "density")]
    speed = at.arrays(at.functions.residual, state.t, state.x, state.z, q)[0].ravel() if turns else np.zeros(0)
    found = []
    for number, item in fields:
        external = dae.externals[number]
        if external.path == item.owner:  # what the field is at the stations, which in a field drives no part
            continue
        n = (external.outputs.stop - external.outputs.start) // 3
        inputs = ca.vec(ca.densify(external.inputs))
        asked = inputs[inputs.numel() - 3 * n :]
        positions = at.general.once(
            ("field positions", number), lambda asked=asked: at.general.function("positions", [asked])
        )
        axes = _axes(plant, state, item)
        now = np.array(at.call(positions, state.t, state.x, state.z, q)).reshape(-1, 3)
        places: TurningRings | RestingPlaces = RestingPlaces(now)
        rotor = -1
        for k, turn in enumerate(turns):
            after = np.array(at.call(positions, state.t, state.x + STEP * turn.direction, state.z, q)).reshape(-1, 3)
            if np.abs(after - now).max() > STEP * 1e-3:
                places, rotor = _rings(dae, now, after - now, speed[turn.azimuth], turn, axes), k
        for part in range(len(axes)):
            own = replace(places, orders=2) if part and isinstance(places, TurningRings) else places
            found.append(FieldPlaces(item.path, item.owner, item.compute, part, number, positions, own, axes,
                                     rotor))  # fmt: skip
    return found


def _axes(plant: Any, state: State, item: Any) -> np.ndarray:
    """Axes of the components of a field (parts, 3) in a run, which may have another direction than the model."""
    with parameters_read() as read:
        axes = item.compute.axes(plant.root.find(item.owner))
    given = state.parameters or {}
    if any(join(*place) in given for place in read) or any(isinstance(value, Component) for value in given.values()):
        axes = item.compute.axes(tree_with(plant.dae, plant.root, given).find(item.owner))
    return np.asarray(axes)


def _rings(dae: Any, now: np.ndarray, moved: np.ndarray, speed: float, turn: Turn, axes: np.ndarray) -> TurningRings:
    """The rings of places that turn with a rotor, blade after blade, as seen along the flow."""
    angle = dae.x[turn.azimuth].element_hash()
    blades = next(len(ring.parts) for ring in dae.symmetries if ring.angle.element_hash() == angle)
    per = len(now) // blades
    centre = now.mean(axis=0)
    across, moved = (now - centre) @ axes[1:].T, moved @ axes[1:].T
    sense = np.sign(np.sum(across[:, 0] * moved[:, 1] - across[:, 1] * moved[:, 0]))
    radii = np.linalg.norm(across.reshape(blades, per, 2), axis=2).mean(axis=0)
    return TurningRings(centre, radii, float(sense * abs(speed)), blades)


def density(places: Sequence[FieldPlaces], root: Component, omega: np.ndarray,
            beside: Sequence[TurningRings | RestingPlaces] = (), basis: np.ndarray | None = None,
            ) -> np.ndarray:  # fmt: skip
    """Spectra (q, channels, channels) of all places of one component in one field, after those of what is beside them.

    basis: see RandomField.density. What a blade meets n times a turn is a band about n times the speed, as wide as what
    it meets lasts. A speed with a deviation widens it: the correlation of exp(i n psi) over a lag t, psi the integral
    of a Gaussian speed, is exp(i n W t - n^2 s^2 t^2/2) while t is short beside the times in which the speed changes,
    as the time is that a gust takes to pass a blade; so it is the mean of the spectra over the speeds.
    """
    component, first = root.find(places[0].owner), places[0]
    nodes = SPEEDS if any(item.spread for item in places) else ((0.0, 1.0),)
    found = np.zeros(())
    for away, share in nodes:
        at = [*beside, *(item.along_axes(away) for item in places)]
        found = found + share * first.compute.density(component, omega, at, first.part, basis)
    return np.asarray(found)


def blows(places: Sequence[FieldPlaces], root: Component) -> bool:
    """Whether there is anything of the field in a run."""
    return bool(np.any(density(places, root, np.geomspace(1e-2, 1.0, 5))))
