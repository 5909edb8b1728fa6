"""The water at the nodes of a line: waves as they are at the nodes at rest, and the current where the nodes are."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment.waves import WaveComponents
from fowtlib.components.mooring import line_at_rest


def at_nodes(line: Any, nodes: Any) -> tuple[Any, Any]:
    """Velocities and accelerations (3, n) of the water at nodes (3, n), world."""
    n = nodes.shape[1]
    velocity = acceleration = ca.SX.zeros(3, n)
    if line.sea is not None and line.waves:
        velocity = ca.reshape(line.sea.signal(_velocity, 3 * n, "water velocity", "m/s", of=line), 3, n)
        acceleration = ca.reshape(line.sea.signal(_acceleration, 3 * n, "water acceleration", "m/s^2", of=line), 3, n)
    if line.sea_current is not None:
        velocity = velocity + line.sea_current.velocities(nodes[2, :])
    return velocity, acceleration


def _places(line: Any, depth: float) -> np.ndarray:
    nodes = line_at_rest.shape_at_rest(line).reshape(-1, 3)
    return np.column_stack([nodes[:, :2], np.maximum(nodes[:, 2], -depth)])


def _velocity(waves: WaveComponents, line: Any) -> np.ndarray:
    return waves.velocity_transfer(_places(line, waves.depth)).reshape(len(waves), -1)


def _acceleration(waves: WaveComponents, line: Any) -> np.ndarray:
    return waves.acceleration_transfer(_places(line, waves.depth)).reshape(len(waves), -1)
