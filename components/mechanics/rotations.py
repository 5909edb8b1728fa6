"""Rotation matrices and what belongs to them; plain functions of CasADi expressions, used by joints and sensors."""

from __future__ import annotations

import numpy as np

from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError


def unit_axis(n) -> np.ndarray:
    """The unit vector along the structural axis n (3 numbers); a zero axis raises ParameterError."""
    n = np.asarray(n, dtype=float).reshape(3)
    length = float(np.linalg.norm(n))
    if length == 0.0:
        raise ParameterError("the axis n is (0, 0, 0): give a direction, for example n=(0, 0, 1).")
    return n / length


def perpendicular_axes(n) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors (e, f) that make a right-handed orthogonal triple (e, f, n) with the axis n."""
    n = unit_axis(n)
    e = np.eye(3)[int(np.argmin(np.abs(n)))]
    e = unit_axis(e - n * (n @ e))
    return e, np.cross(n, e)


def axis_rotation(n, angle):
    """R (3x3) of a turn by `angle` [rad] about the unit axis n (numbers): Rodrigues' formula.

    R maps components in the turned frame to components in the frame where n is given.
    """
    n = unit_axis(n)
    projector = np.outer(n, n)
    skew = np.array([[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]])
    return m.cos(angle) * (np.eye(3) - projector) + m.sin(angle) * skew + projector


def yaw_pitch_roll(roll, pitch, yaw):
    """R (3x3) of the intrinsic sequence yaw (z), pitch (new y), roll (new x): R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return m.rotation_z(yaw) @ m.rotation_y(pitch) @ m.rotation_x(roll)


def yaw_pitch_roll_velocity(pitch, yaw, rates):
    """Angular velocity, resolved in the reference frame, of the sequence above; rates = d/dt (roll, pitch, yaw)."""
    cp, sp, cy, sy = m.cos(pitch), m.sin(pitch), m.cos(yaw), m.sin(yaw)
    roll_rate, pitch_rate, yaw_rate = rates[0], rates[1], rates[2]
    return m.vertcat(
        cy * cp * roll_rate - sy * pitch_rate,
        sy * cp * roll_rate + cy * pitch_rate,
        yaw_rate - sp * roll_rate,
    )
