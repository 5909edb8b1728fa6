"""Steady operation of a blade-element momentum rotor: rigid, in uniform wind; its tables of coefficients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.aero.airfoil_models import STEADY
from fowtlib.components.aero.bem import BladeElementRotor
from fowtlib.components.aero.coefficient_table import CoefficientTable
from fowtlib.language.errors import ParameterError


@dataclass(frozen=True)
class RigidRotor:
    """Nodes of a turning rotor with rigid blades: where they are, how they lie and move.

    precone and tilt [rad]: positive moves the tips upwind and the upwind end of the shaft up; yaw [rad] about z.
    """

    rotor: BladeElementRotor
    precone: float = 0.0
    tilt: float = 0.0
    yaw: float = 0.0

    def hub_axes(self) -> np.ndarray:
        """Orientation of the hub without its azimuth, world from hub; x is the rotor normal."""
        return _about("z", self.yaw) @ _about("y", self.tilt)

    def inputs(self, wind: Any, speed: float, pitch: Any = 0.0, azimuth: float = 0.0, hub: Any = (0.0, 0.0, 90.0),
               air_density: float = 1.225, induced: Any = 0.0) -> np.ndarray:  # fmt: skip
        """The inputs of the external function as one column.

        wind (3,) or (n, 3) [m/s]; speed [rad/s], positive when the rotor drives the shaft; pitch [rad], one number or
        one for each blade; azimuth [rad] of the first blade, zero when it points up; induced [m/s] one number or one
        for each station, for a rotor with dynamic inflow.
        """
        rotor, blade, rotation = self.rotor, self.rotor.blade, self.rotor.rotation
        axes, hub = self.hub_axes(), np.asarray(hub, dtype=float)
        pitches = np.broadcast_to(pitch, rotor.blades)
        position, orientation = [], []
        for k in range(rotor.blades):
            turn = _about("x", rotation * (azimuth + 2 * np.pi * k / rotor.blades))
            root = axes @ turn @ _about("y", -self.precone)
            pitched = root @ _about("z", -rotation * pitches[k])
            for r, twist, curve, sweep in zip(blade.radius, blade.twist, blade.curve, blade.sweep, strict=True):
                position.append(hub + root @ [0, 0, r] + pitched @ [curve, rotation * sweep, 0])
                orientation.append(pitched @ _about("z", -rotation * twist))
        position = np.array(position)
        velocity = np.cross(rotation * speed * axes[:, 0], position - hub)
        wind = np.broadcast_to(wind, position.shape)
        flat = [o.T.ravel() for o in orientation]
        groups = [position.ravel(), np.concatenate(flat), velocity.ravel(), wind.ravel(), hub,
                  (axes @ _about("x", rotation * azimuth)).T.ravel(), np.zeros(3), wind.mean(axis=0), [air_density],
                  blade.chord]
        if rotor.dynamic_inflow:
            groups.append(np.broadcast_to(induced, len(blade.radius)))
        if rotor.airfoil_model.states:  # after a long step: in equilibrium
            groups += [np.zeros(rotor.nodes), np.zeros(rotor.airfoil_model.states * rotor.nodes), [1e15]]
        return np.concatenate(groups)

    def loads(self, inputs: np.ndarray) -> np.ndarray:
        """Force and moment of every node, (n, 6)."""
        outputs = self.rotor.external.function(ca.DM(inputs)).full().ravel()
        return outputs[: 6 * self.rotor.nodes].reshape(-1, 6)

    def quasi_steady(self, inputs: np.ndarray) -> np.ndarray:
        """Induced speed of the balance of momentum at every station, mean of the blades [m/s]; with dynamic inflow."""
        if not self.rotor.dynamic_inflow:
            raise ParameterError("the quasi-steady induced speed is an output of a rotor with dynamic_inflow only.")
        outputs = self.rotor.external.function(ca.DM(inputs)).full().ravel()
        return outputs[6 * self.rotor.nodes :].reshape(self.rotor.blades, -1).mean(axis=0)

    def thrust_and_torque(self, wind: Any, speed: float, pitch: Any = 0.0, **more: Any) -> tuple[float, float]:
        """Thrust along the rotor normal [N], torque that drives the shaft [N m]."""
        thrust, torque = self._along_the_shaft(self.inputs(wind, speed, pitch, **more)[:, None])[0]
        return float(thrust), float(torque)

    def _along_the_shaft(self, inputs: np.ndarray) -> np.ndarray:
        """Thrust and torque for each column of inputs, which have the nodes and the hub at the same places."""
        n, start = self.rotor.nodes, 18 * self.rotor.nodes
        loads = self.rotor.external.function(ca.DM(inputs)).full()[: 6 * n].T.reshape(-1, n, 6)
        arm = inputs[: 3 * n, 0].reshape(n, 3) - inputs[start : start + 3, 0]
        moment = (np.cross(arm, loads[..., :3]) + loads[..., 3:]).sum(axis=1)
        normal = self.hub_axes()[:, 0]
        return np.stack([loads[..., :3].sum(axis=1) @ normal, self.rotor.rotation * moment @ normal], axis=1)

    def over_speeds(self, wind: Any, speeds: np.ndarray, pitch: float, **more: Any) -> np.ndarray:
        """Thrust and torque, (n, 2), at n rotor speeds [rad/s] in the same wind, pitch and azimuth."""
        n = self.rotor.nodes
        inputs = np.repeat(self.inputs(wind, 1.0, pitch, **more)[:, None], len(speeds), axis=1)
        inputs[12 * n : 15 * n] *= speeds  # the velocities of the nodes
        return self._along_the_shaft(inputs)

    def sweep(self, winds: np.ndarray, speed: float, pitch: float, **more: Any) -> np.ndarray:
        """Thrust and torque, (n, 2), in n uniform winds [m/s] along x, at the same rotor speed and pitch."""
        n = self.rotor.nodes
        inputs = np.repeat(self.inputs([1.0, 0, 0], speed, pitch, **more)[:, None], len(winds), axis=1)
        inputs[15 * n : 18 * n : 3] = inputs[18 * n + 15] = winds  # x of the wind at the nodes and of the disk wind
        return self._along_the_shaft(inputs)


def coefficient_table(
    rotor: BladeElementRotor, tip_speed_ratios: Any, blade_pitch: Any, *, precone: float = 0.0, speed: float = 1.0,
    progress: Callable[[int, int], None] | None = None,
) -> CoefficientTable:  # fmt: skip
    """C_t and C_q over tip speed ratio and collective pitch [rad], by this theory: shaft along the wind, no tilt.

    As in CoefficientRotor the tip speed ratio counts the radius along the blade and the coefficients R = radius
    cos(precone). C_p = tip speed ratio C_q cos(precone). speed [rad/s] scales the wind, and the coefficients do not
    depend on it: the airfoils have no Reynolds number. A rotor that stands, idles or turns backwards has tip speed
    ratios of 0 and below. progress(done, all) is called after each pitch angle.
    """
    quasi_steady = rotor
    if rotor.dynamic_inflow or rotor.airfoil_model.states:
        quasi_steady = replace(rotor, dynamic_inflow=False, airfoil_model=STEADY)
    rigid, radius = RigidRotor(quasi_steady, precone), rotor.blade.tip_radius
    R = radius * np.cos(precone)
    ratios, pitches = np.asarray(tip_speed_ratios, dtype=float), np.asarray(blade_pitch, dtype=float)
    values = np.empty((len(ratios), len(pitches), 2))
    turning, wind = ratios > 0.1, speed * radius
    winds = np.where(turning, wind / np.where(turning, ratios, 1), wind)
    pressures = 0.5 * np.pi * R**2 * winds**2
    for j, pitch in enumerate(pitches):
        loads = np.empty((len(ratios), 2))
        loads[turning] = rigid.sweep(winds[turning], speed, float(pitch), air_density=1.0)
        for i in np.flatnonzero(~turning):
            loads[i] = rigid.thrust_and_torque([wind, 0, 0], ratios[i] * speed, float(pitch), air_density=1.0)
        values[:, j] = loads / np.stack([pressures, pressures * R], axis=1)
        if progress is not None:
            progress(j + 1, len(pitches))
    return CoefficientTable(ratios, pitches, values[..., 0], values[..., 1])


def _about(axis: str, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array({"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
                     "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis])  # fmt: skip
