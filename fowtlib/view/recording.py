"""What an animation plays: where the drawn frames are, how lines hang and what results read, at chosen moments."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language import shapes
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError

Observe = Callable[[Sequence[str]], np.ndarray]
BLOCK = 360  # scalars observed together
POSE, POINT, SCALAR = 7 * 4, 3 * 2, 4  # bytes of a pose, a point of a curve and a value in the file
POINTS = 31  # of a curve, as many as a mooring line has, to guess the size of a file
POSE_NAMES = (*(f"r[{i}]" for i in range(3)), *(f"R[{i},{j}]" for i in range(3) for j in range(3)))


@dataclass(frozen=True, eq=False)
class Reading:
    """A result to be read beside the picture: values (n_time,) in `unit`."""

    name: str
    unit: str
    long_name: str
    values: np.ndarray


class Cast:
    """What a model shows, sorted: rigid shapes with the number of their frame (-1: world), curves, arrows, the sea."""

    def __init__(self, drawn: Iterable[shapes.Drawn]) -> None:
        drawn = list(drawn)
        self.frames: list[Any] = []
        self._numbers: dict[Any, int] = {}
        self.solids = [(self._number(s.frame), s) for s in drawn if isinstance(s, shapes.Shape)]
        self.curves = [s for s in drawn if isinstance(s, shapes.Curve)]
        self.arrows = [s for s in drawn if isinstance(s, shapes.Arrow)]
        self.water = next((s for s in drawn if isinstance(s, shapes.Water)), None)
        if not self.solids and not self.curves:
            raise ModelError(
                "the model has no part with a form: bodies, links, towers, rotors and mooring lines have one; "
                "VisualTube and VisualBox give one to anything with a frame."
            )

    def _number(self, frame: Any) -> int:
        if frame is None:
            return -1
        derived = isinstance(frame, shapes.Turned | shapes.Carried)
        key = frame if derived else frame.path
        if key not in self._numbers:
            if derived:
                self._number(frame.frame)
            self._numbers[key] = len(self.frames)
            self.frames.append(frame)
        return self._numbers[key]

    @property
    def names(self) -> list[str]:
        """Names of the frames, in their order."""
        return [_name(frame) for frame in self.frames]

    def bytes_per_moment(self, readings: int) -> float:
        """Size of one moment in the file, as base64."""
        points = POINTS * len(self.curves)
        turning = [arrow for arrow in self.arrows if arrow.bearing]
        raw = POSE * len(self.frames) + POINT * points + SCALAR * (readings + len(self.arrows) + len(turning) + 1)
        return raw * 4 / 3

    def poses(self, observe: Observe, moments: int) -> np.ndarray:
        """Position [m] and unit quaternion (x, y, z, w) of every frame: (n_time, n_frames, 7)."""
        plain = [frame for frame in self.frames if not isinstance(frame, shapes.Turned | shapes.Carried)]
        carried = [frame for frame in self.frames if isinstance(frame, shapes.Carried)]
        moving = list(dict.fromkeys(path for frame in carried for path in frame.of))
        turned = [frame for frame in self.frames if isinstance(frame, shapes.Turned)]
        names = [join(frame.path, name) for frame in plain for name in POSE_NAMES]
        values = _observed(observe, [*names, *(frame.angle for frame in turned), *moving], moments)
        given = dict(zip(moving, values[:, len(names) + len(turned) :].T, strict=True))
        poses = np.zeros((moments, len(self.frames), 7))
        for i, frame in enumerate(plain):
            columns = values[:, 12 * i : 12 * i + 12]
            number = self._numbers[frame.path]
            poses[:, number, :3] = columns[:, :3]
            poses[:, number, 3:] = quaternions(columns[:, 3:].reshape(-1, 3, 3))
        for i, frame in enumerate(turned):  # a frame comes before those that turn on it
            base = self._number(frame.frame)
            angle = frame.factor * values[:, len(names) + i]
            number = self._numbers[frame]
            poses[:, number, :3] = poses[:, base, :3]
            poses[:, number, 3:] = product(poses[:, base, 3:], turn(frame.axis, angle))
        for frame in carried:
            base = poses[:, self._number(frame.frame)]
            amounts = np.stack([given[path] for path in frame.of], axis=1)
            number = self._numbers[frame]
            poses[:, number, :3] = base[:, :3] + rotated(base[:, 3:], frame.point + amounts @ frame.displacement.T)
            poses[:, number, 3:] = product(base[:, 3:], small_turn(amounts @ frame.turn.T))
        return _continuous(poses)

    def lines(self, observe: Observe, moments: int) -> list[np.ndarray]:
        """The points of every curve: (n_time, n_points, 3)."""
        names: list[str] = []
        for curve in self.curves:
            for source in curve.of.values():
                names += [source] if isinstance(source, str) else [join(source.path, f"r[{i}]") for i in range(3)]
        values = iter(_observed(observe, names, moments).T)
        found = []
        for curve in self.curves:
            columns: dict[str, np.ndarray] = {}
            for key, source in curve.of.items():
                one = isinstance(source, str)
                columns[key] = next(values) if one else np.stack([next(values) for _ in range(3)], axis=1)
            found.append(curve.points(columns))
        return found

    def speeds(self, observe: Observe, moments: int) -> np.ndarray:
        """The values of the arrows: (n_time, n_arrows)."""
        return _observed(observe, [arrow.value for arrow in self.arrows], moments)

    def bearings(self, observe: Observe, moments: int) -> list[np.ndarray | None]:
        """The angles about z [rad] of the arrows that turn, (n_time,) each; None for another."""
        paths = list(dict.fromkeys(arrow.bearing for arrow in self.arrows if arrow.bearing))
        found = dict(zip(paths, _observed(observe, paths, moments).T, strict=True))
        return [found.get(arrow.bearing) for arrow in self.arrows]


def moments_of(time: np.ndarray, rate: float | None, most: int) -> np.ndarray:
    """Numbers of the output points to show: at most `rate` a second and `most` in all, first and last included.

    Without a rate 10 a second, and 600 in all of a shorter run.
    """
    duration = float(time[-1] - time[0]) if time.size else 0.0
    if duration <= 0:
        return np.arange(min(time.size, 1))
    rate = max(10.0, 600.0 / duration) if rate is None else rate
    step = max(1.0 / rate, duration / max(most - 1, 1))
    wanted = time[0] + step * np.arange(math.floor(duration / step * (1 + 1e-9)) + 1)
    numbers = np.searchsorted(time, wanted - 1e-6 * step)
    return np.unique(np.append(numbers[numbers < time.size], time.size - 1))


def quaternions(matrices: np.ndarray) -> np.ndarray:
    """Unit quaternions (n, 4), x y z w, of rotation matrices (n, 3, 3); the largest component is found first."""
    m = matrices
    trace = np.trace(m, axis1=1, axis2=2)
    squares = np.stack([1 + 2 * m[:, i, i] - trace for i in range(3)] + [1 + trace], axis=1)
    products = np.empty((len(m), 4, 4))
    for i in range(4):
        products[:, i, i] = squares[:, i]
    for i, j in ((0, 1), (0, 2), (1, 2)):
        products[:, i, j] = products[:, j, i] = m[:, i, j] + m[:, j, i]
    for i, (j, k) in enumerate(((2, 1), (0, 2), (1, 0))):
        products[:, i, 3] = products[:, 3, i] = m[:, j, k] - m[:, k, j]
    rows = products[np.arange(len(m)), np.argmax(squares, axis=1)]
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def turn(axis: Sequence[float], angle: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) of turns by `angle` (n,) [rad] about an axis of any length."""
    unit = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return np.concatenate([np.sin(angle / 2)[:, None] * unit, np.cos(angle / 2)[:, None]], axis=1)


def small_turn(angles: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) of turns by vectors of angles (n, 3) [rad]."""
    size = np.linalg.norm(angles, axis=1, keepdims=True)
    return np.concatenate([angles / 2 * np.sinc(size / 2 / np.pi), np.cos(size / 2)], axis=1)


def rotated(q: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3), resolved in frames of quaternions (n, 4), in the world."""
    across = 2 * np.cross(q[:, :3], vectors)
    return vectors + q[:, 3:] * across + np.cross(q[:, :3], across)


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) of the turn q, resolved in the frame of p, after p."""
    a, b, v, w = p[:, :3], q[:, :3], p[:, 3:], q[:, 3:]
    return np.concatenate([v * b + w * a + np.cross(a, b), v * w - np.sum(a * b, axis=1, keepdims=True)], axis=1)


def _continuous(poses: np.ndarray) -> np.ndarray:
    """Of the two quaternions of an orientation the one nearer to the moment before."""
    follow = np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=2)
    signs = np.cumprod(np.where(follow < 0, -1.0, 1.0), axis=0)
    poses[1:, :, 3:] *= signs[..., None]
    return poses


def _observed(observe: Observe, names: list[str], moments: int) -> np.ndarray:
    blocks = [observe(names[i : i + BLOCK]) for i in range(0, len(names), BLOCK)]
    values = np.concatenate(blocks, axis=1) if blocks else np.zeros((moments, 0))
    bad = ~np.isfinite(values).all(axis=0)
    if bad.any():
        raise ModelError(f"{names[int(np.argmax(bad))]} is not a finite number at some moment: nothing can be drawn.")
    return values


def _name(frame: Any) -> str:
    if isinstance(frame, shapes.Turned):
        return f"{_name(frame.frame)} turned by {frame.angle}"
    if isinstance(frame, shapes.Carried):
        x, y, z = frame.point
        return f"{_name(frame.frame)} bent at ({x:g}, {y:g}, {z:g}) m"
    return frame.path
