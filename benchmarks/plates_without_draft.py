"""Floating plates without draft by the pressure on them: a check of the panel method, and a plate of two stiffnesses.

    python benchmarks/plates_without_draft.py

The water answers a pressure p on its surface by eta = -p / (rho g) - nu / (rho g) (g * p), nu = omega^2 / g, where g is
the Green function of the water level, a series over the roots of the dispersion relation. With p constant on cells of
one size and the plate as a sum of shapes this is a small linear system, which shares nothing with the panel method.

1. Yago and Endo's plate (see floating_plate.py), as a plate that bends both ways, by Legendre's polynomials.
2. Two dimensions: 12.5 m, 8.36 kg/m^2, depth 1.1 m, waves of 0.249 lengths; E I 47100 N m up to a fifth of the length
   and 471 N m beyond, with and without a hinge there (T.I. Khabakhpasheva and A.A. Korobkin, J. Engineering Mathematics
   44 (2002) 21-36; digits of public data, O. Colomes and others, MonolithicFEMVLFS, whose model has these stiffnesses).
   The beam is a SpaceFrame.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq
from scipy.special import hankel1, k0

from fowtlib.components.platform.space_frame import Beam, Section, SpaceFrame

RHO, G = 1025.0, 9.81


def waves(k: float, depth: float, count: int) -> tuple[float, float, np.ndarray, np.ndarray]:
    """Nu, 1 / (dK/dk) at k, where K = k tanh(k h), the imaginary roots, and what stands for it there."""
    nu, kh = k * math.tanh(k * depth), k * depth
    low, high = ((np.arange(1, count + 1) - part) * math.pi / depth for part in (0.5, 0.0))
    roots = np.array([
        brentq(lambda x: x * math.sin(x * depth) + nu * math.cos(x * depth), a + 1e-12, b - 1e-12)
        for a, b in zip(low, high, strict=True)
    ])  # fmt: skip
    tan = -nu / roots
    return nu, 1 / (math.tanh(kh) + kh / math.cosh(kh) ** 2), roots, 1 / (tan + roots * depth * (1 + tan**2))


def yago(ratio: float, cells: tuple[int, int], shapes: tuple[int, int]) -> np.ndarray:
    """Amplitude on the centre line at -1, -0.75 ... 1, 1: the end that the waves meet."""
    size, depth, mass, bend, poisson = np.array([300.0, 60.0]), 58.5, 256.25 * 2, 8.07e9, 0.13
    k = 2 * math.pi / (ratio * size[0])
    nu, first, roots, others = waves(k, depth, 1200)

    def green(r: np.ndarray) -> np.ndarray:  # less 1 / (2 pi r)
        far = sum(b * a / np.pi * k0(np.minimum(a * r, 600)) for a, b in zip(roots, others, strict=True))
        return 0.5j * k * first * hankel1(0, k * r) + far - 1 / (2 * np.pi * r)

    radii = np.geomspace(0.1, 310.0, 1200)
    log, value = np.log(radii), green(radii)
    slope = (value[3] - value[0]) / (log[3] - log[0])

    def smooth(r: np.ndarray) -> np.ndarray:
        at = np.log(r)
        found = np.interp(at, log, value.real) + 1j * np.interp(at, log, value.imag)
        return found + np.where(at < log[0], slope * (at - log[0]), 0)

    a, b = size / cells
    x, y = np.meshgrid(np.arange(cells[0]) * a, np.arange(cells[1]) * b, indexing="ij")
    cell = np.zeros_like(x, dtype=complex)
    for i in (-1, 1):
        for j in (-1, 1):  # of 1 / r over a cell
            u, v = x + i * a / 2, y + j * b / 2
            cell += i * j / (2 * np.pi) * (u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v)))
    places, weights = legendre.leggauss(4)
    for p, wp in zip(places, weights, strict=True):
        for q, wq in zip(places, weights, strict=True):
            cell += wp * wq * a * b / 4 * smooth(np.hypot(x + p * a / 2, y + q * b / 2))
    along, across = np.arange(cells[0]), np.arange(cells[1] // 2)  # the other half is its image
    apart = np.abs(along[:, None] - along)[:, None, :, None]
    one, other = np.abs(across[:, None] - across), np.abs(across[:, None] - (cells[1] - 1 - across))
    water = sum(cell[apart, rows[None, :, None, :]] for rows in (one, other)).reshape(len(along) * len(across), -1)
    water = (np.eye(len(water)) + nu * water) / (RHO * G)
    middle = -size / 2 + (np.array([a, b]) / 2)
    x, y = middle[0] + along * a, middle[1] + across * b

    def series(u: np.ndarray, count: int, step: int, order: int) -> np.ndarray:
        return np.array([legendre.Legendre.basis(step * i).deriv(order)(u) for i in range(count)])

    moved = np.einsum("ix,jy->ijxy", series(2 * x / size[0], shapes[0], 1, 0), series(2 * y / size[1], shapes[1], 2, 0))
    moved = moved.reshape(shapes[0] * shapes[1], -1)
    wave = np.repeat(np.exp(1j * k * x), len(across))
    load = 2 * a * b * moved @ np.linalg.solve(water, np.column_stack([wave, moved.T]))
    u, w = legendre.leggauss(24)

    def product(axis: int, one: int, other: int) -> np.ndarray:
        left, right = (series(u, shapes[axis], axis + 1, n) * (2 / size[axis]) ** n for n in (one, other))
        return left * w * size[axis] / 2 @ right.T

    cross = np.kron(product(0, 2, 0), product(1, 0, 2))
    stiffness = bend * (
        np.kron(product(0, 2, 2), product(1, 0, 0)) + np.kron(product(0, 0, 0), product(1, 2, 2))
        + poisson * (cross + cross.T) + 2 * (1 - poisson) * np.kron(product(0, 1, 1), product(1, 1, 1))
    )  # fmt: skip
    inertia = nu * G * mass * np.kron(product(0, 0, 0), product(1, 0, 0))
    q = np.linalg.solve(stiffness - inertia + load[:, 1:], load[:, 0]).reshape(shapes)
    where = -np.linspace(-1, 1, 9)
    return np.abs(
        np.einsum("ix,j,ij->x", series(where, shapes[0], 1, 0), series(np.zeros(1), shapes[1], 2, 0)[:, 0], q)
    )


HINGE_PLACES = [0, 0.12, 0.24, 0.36, 0.48, 0.60, 0.72, 0.84, 0.96, 1]
PUBLISHED = {
    "joined": [1.071, 0.299, 0.502, 0.471, 0.442, 0.432, 0.438, 0.523, 0.589, 0.972],
    "hinged": [1.205, 0.280, 0.475, 0.433, 0.398, 0.390, 0.386, 0.463, 0.497, 0.850],
}


def two_parts(hinged: bool, cells: int = 200, beams: int = 80) -> np.ndarray:
    """Amplitude of the two-dimensional plate at HINGE_PLACES; a hinge is a short beam of 0.05 N m a radian."""
    length, depth, mass, short = 12.5, 1.1, 8.36, 1e-4
    k = 2 * math.pi / (0.249 * length)
    nu, first, roots, others = waves(k, depth, 1500)
    a = length / cells
    d = np.arange(cells) * a
    near, far = np.abs(d - a / 2), d + a / 2
    cell = first / k * (np.exp(1j * k * far) - np.exp(1j * k * near))
    cell += (others / roots * (np.exp(-np.outer(near, roots)) - np.exp(-np.outer(far, roots)))).sum(axis=1)
    cell[0] = 2 * (first / k * (np.exp(0.5j * k * a) - 1) + (others / roots * (1 - np.exp(-roots * a / 2))).sum())
    number = np.arange(cells)
    water = (np.eye(cells) + nu * cell[np.abs(number[:, None] - number)]) / (RHO * G)
    places, joint = np.linspace(0, length, beams + 1), beams // 5
    if hinged:
        places = np.insert(places, joint + 1, places[joint] + short)
    parts = []
    for i, middle in enumerate((places[1:] + places[:-1]) / 2):
        bend = 5e-6 if hinged and i == joint else 47100.0 if middle < length / 5 else 471.0
        parts.append(Beam(i, i + 1, Section(1e3, 1e-3, bend, 1e-3, 1.0, 1e3, mass, 1e-6), (0.0, 0.0, 1.0)))
    frame = SpaceFrame(np.column_stack([places, 0 * places, 0 * places]), parts)
    free = np.zeros((len(places), 6), dtype=bool)
    free[:, 2] = free[:, 4] = True  # heave and the turn about y
    kept = free.ravel()
    units = np.eye(kept.size)[kept].reshape(-1, len(places), 6)
    x = (number + 0.5) * a

    def motion(at: float) -> np.ndarray:
        beam = min(max(int(np.searchsorted(places, at)) - 1, 0), len(parts) - 1)
        share = (at - places[beam]) / (places[beam + 1] - places[beam])
        return frame.section_motion(beam, share, units)[1][:, 2]

    moved = np.array([motion(at) for at in x])
    load = a * moved.T @ np.linalg.solve(water, np.column_stack([np.exp(1j * k * x), moved]))
    stiffness, inertia = (matrix.toarray()[np.ix_(kept, kept)] for matrix in (frame.stiffness, frame.mass))
    q = np.linalg.solve(stiffness - nu * G * inertia + load[:, 1:], load[:, 0])
    return np.abs([motion(share * length) @ q for share in HINGE_PLACES])


def main() -> None:
    for ratio in (0.4, 0.6, 0.8, 1.0):
        for cells, shapes in (((60, 12), (12, 3)), ((100, 20), (14, 3))):
            print(ratio, cells, shapes, np.round(yago(ratio, cells, shapes), 3))
    for name, published in PUBLISHED.items():
        print(name, np.round(two_parts(name == "hinged"), 3), "published", published)


if __name__ == "__main__":
    main()
