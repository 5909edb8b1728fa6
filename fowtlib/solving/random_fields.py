"""Random fields of velocity in a linear model: what a rotor that turns through one feels, as inputs that do not turn.

A field gives velocities at positions, in an external function. Where the positions turn with a rotor, the velocity at
each blade is a mix of what the ring at its radius has all round: with the angle theta of a place, uniform + cos(theta)
times one part + sin(theta) times the other. Averaged over a turn that is what the slow motions of the model feel, see
components.environment.disc_turbulence for the spectra of these parts; higher orders come in by the turning there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.component import Component
from fowtlib.language.run_time import RandomField, RestingPlaces, TurningRings
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.state import State
from fowtlib.solving.turning import Turn

STEP = 1e-4  # rad of azimuth, for the direction of the turning


@dataclass(frozen=True, eq=False)
class FieldPlaces:
    """Where one external asks a random field: number of the external, its positions, and the places that these are."""

    path: str
    owner: str
    compute: RandomField
    external: int
    positions: ca.Function
    places: TurningRings | RestingPlaces
    along: np.ndarray

    @property
    def labels(self) -> list[str]:
        """What the inputs are called."""
        return [f"{self.path} {self.external} [{k}]" for k in range(self.places.channels)]

    def mixing(self, at: AtParameters, *point: Any) -> np.ndarray:
        """How the velocities (3 n) at a point follow from the channels: (3 n, channels)."""
        n = self.positions.size1_out(0) // 3
        if isinstance(self.places, RestingPlaces):
            parts = np.eye(n)
        else:
            angle = angles(self._at(at, *point), self.places)
            ring = np.tile(np.eye(len(self.places.radii)), (self.places.blades, 1))
            parts = np.hstack([ring, np.cos(angle)[:, None] * ring, np.sin(angle)[:, None] * ring])
        return np.kron(parts, self.along[:, None])

    def _at(self, at: AtParameters, *point: Any) -> np.ndarray:
        return np.array(at.call(self.positions, *point)).reshape(-1, 3)


def angles(positions: np.ndarray, rings: TurningRings) -> np.ndarray:
    """Angles (n,) of places about the axis along x, in the sense of their turning."""
    across = positions[:, 1:] - rings.centre[1:]
    return np.sign(rings.speed) * np.arctan2(across[:, 1], across[:, 0])


def field_places(plant: Any, at: AtParameters, state: State, turns: Sequence[Turn]) -> list[FieldPlaces]:
    """All places at which parts of a plant ask for a random field, about a mean state."""
    dae, q = plant.dae, np.concatenate([state.u, state.d])
    speed = at.arrays(at.functions.residual, state.t, state.x, state.z, q)[0].ravel() if turns else np.zeros(0)
    found = []
    for number, item in dae.with_data:
        external = dae.externals[number]
        if not hasattr(item.compute, "density"):
            continue
        if external.path == item.owner:  # what the field is at the stations, which in a field drives no part
            continue
        n = (external.outputs.stop - external.outputs.start) // 3
        inputs = ca.vec(ca.densify(external.inputs))
        asked = inputs[inputs.numel() - 3 * n :]
        positions = at.general.once(
            ("field positions", number), lambda asked=asked: at.general.function("positions", [asked])
        )
        along = np.asarray(item.compute.along(plant.root.find(item.owner)))
        now = np.array(at.call(positions, state.t, state.x, state.z, q)).reshape(-1, 3)
        places: TurningRings | RestingPlaces = RestingPlaces(now)
        for turn in turns:
            after = np.array(at.call(positions, state.t, state.x + STEP * turn.direction, state.z, q)).reshape(-1, 3)
            if np.abs(after - now).max() > STEP * 1e-3:
                places = _rings(dae, now, after - now, speed[turn.azimuth], turn)
        found.append(FieldPlaces(item.path, item.owner, item.compute, number, positions, places, along))
    return found


def _rings(dae: Any, now: np.ndarray, moved: np.ndarray, speed: float, turn: Turn) -> TurningRings:
    """The rings of places that turn with a rotor, blade after blade."""
    angle = dae.x[turn.azimuth].element_hash()
    blades = next(len(ring.parts) for ring in dae.symmetries if ring.angle.element_hash() == angle)
    per = len(now) // blades
    centre = now.mean(axis=0)
    across = now[:, 1:] - centre[1:]
    sense = np.sign(np.sum(across[:, 0] * moved[:, 2] - across[:, 1] * moved[:, 1]))
    radii = np.linalg.norm(across.reshape(blades, per, 2), axis=2).mean(axis=0)
    return TurningRings(centre, radii, float(sense * abs(speed)), blades)


def density(places: Sequence[FieldPlaces], root: Component, omega: np.ndarray,
            beside: Sequence[TurningRings | RestingPlaces] = ()) -> np.ndarray:  # fmt: skip
    """Spectra (q, channels, channels) of all places in one field, after those of what is beside them."""
    component = root.find(places[0].owner)
    return places[0].compute.density(component, omega, [*beside, *(item.places for item in places)])


def blows(places: Sequence[FieldPlaces], root: Component) -> bool:
    """Whether there is anything of the field in a run."""
    return bool(np.any(density(places, root, np.geomspace(1e-2, 1.0, 5))))
