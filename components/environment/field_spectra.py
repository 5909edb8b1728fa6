"""Spectra of the three wind components and their coherence over a plane of points. Plain numpy.

Kaimal (IEC 61400-1 ed. 3, annex B.2): S_k = 4 sigma_k^2 (L_k/V) / (1 + 6 f L_k/V)^(5/3) with sigma_k = (1, 0.8, 0.5)
sigma_1 and L_k = (8.1, 2.7, 0.66) Lambda_1 for k = u, v, w.
von Karman, isotropic (IEC 61400-1 ed. 2, annex B.1): with x = f L/V, L = 3.5 Lambda_1, sigma_1 for all components,
S_u = 4 sigma_1^2 (L/V) / (1 + c x^2)^(5/6), S_v = S_w = 2 sigma_1^2 (L/V) (1 + 8/3 c x^2) / (1 + c x^2)^(11/6);
c = (2 sqrt(pi) Gamma(1/3) / Gamma(5/6))^2 = 70.78 makes the integral of each exactly sigma_1^2.

Coherence of two points at the distance r across the wind: exp(-12 r sqrt((f/V)^2 + (0.12/L_c)^2)), L_c = 8.1 Lambda_1,
which IEC gives for u. It gives none for v and w.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment.turbulence import coherence, turbulence_scale
from fowtlib.language.errors import ParameterError

Floats = NDArray[np.float64]

SPECTRA = ("kaimal", "von_karman")
_VON_KARMAN = (2 * math.sqrt(math.pi) * math.gamma(1 / 3) / math.gamma(5 / 6)) ** 2


def spectra(
    frequency: ArrayLike, mean_speed: float, sigma: float, height: float = 90.0, model: str = "kaimal"
) -> Floats:
    """One-sided spectra [m^2/s^2/Hz] of u, v, w at `frequency` [Hz]: (..., 3).

    V = `mean_speed` [m/s] at hub `height` [m], `sigma` [m/s] of the longitudinal component.
    """
    if model not in SPECTRA:
        raise ParameterError(f"there is no spectrum '{model}'; the spectra are {', '.join(SPECTRA)}.")
    f = np.asarray(frequency, dtype=float)[..., None]
    if model == "kaimal":
        scale = np.array([8.1, 2.7, 0.66]) * turbulence_scale(height) / mean_speed
        return 4 * (sigma * np.array([1, 0.8, 0.5])) ** 2 * scale / (1 + 6 * f * scale) ** (5 / 3)
    scale = 3.5 * turbulence_scale(height) / mean_speed
    square = _VON_KARMAN * (f * scale) ** 2
    along = 4 * sigma**2 * scale / (1 + square) ** (5 / 6)
    across = 2 * sigma**2 * scale * (1 + 8 / 3 * square) / (1 + square) ** (11 / 6)
    return np.concatenate([along, across, across], axis=-1)


def band_variance(harmonics: int, period: float, *args: float, model: str = "kaimal") -> Floats:
    """Variance [m^2/s^2] of u, v, w in the bands of width 1/period about k/period, k = 1 ...: (harmonics, 3).

    Simpson's rule over the band; `args` are mean speed, sigma and height of `spectra`.
    """
    edges = spectra((np.arange(harmonics + 1) + 0.5) / period, *args, model=model)
    middle = spectra(np.arange(1, harmonics + 1) / period, *args, model=model)
    return (edges[:-1] + 4 * middle + edges[1:]) / (6 * period)


class PlaneCoherence:
    """Factors of the coherence matrix of a uniform grid: C(f) = H H^T for rows x columns points, rows slowest.

    The matrix depends on |dy| and |dz| alone, so it does not mix fields that are even and odd in y about the middle
    column, nor in z about the middle row. In that basis it falls into four blocks of a quarter of the size each, whose
    Cholesky factors cost a sixteenth of that of the whole; H is the basis times the blocks' factors.
    """

    def __init__(self, rows: int, columns: int, dz: float, dy: float, mean_speed: float, height: float):
        self.shape = (rows, columns)
        self.wind = (mean_speed, height)
        self.distance = np.hypot(dz * np.arange(rows)[:, None], dy * np.arange(columns)).ravel()
        self.basis_z, self.parts_z = _even_and_odd(rows)
        self.basis_y, self.parts_y = _even_and_odd(columns)

    def apply(self, frequency: Floats, noise: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """H(f) times independent noise (n, rows x columns, m) at n frequencies [Hz]; the same shape."""
        kernel = coherence(frequency[:, None], self.distance, *self.wind).reshape(-1, *self.shape)
        count, m = len(frequency), noise.shape[-1]
        result = np.empty((count, *self.shape, m), dtype=complex)
        along_y = _combinations(kernel, self.parts_y)
        used = 0
        for z in self.parts_z:
            for y, sums in zip(self.parts_y, along_y, strict=True):
                sides = z.stop - z.start, y.stop - y.start
                rows = slice(used, used := used + sides[0] * sides[1])
                part = _cholesky(_block(sums, z)) @ np.ascontiguousarray(noise[:, rows]).view(float)
                result[:, z, y] = part.view(complex).reshape(count, *sides, -1)
        numbers = result.view(float).reshape(count, self.shape[0], -1)  # small real products, which start no threads
        mixed = np.matmul(self.basis_y, (self.basis_z @ numbers).reshape(count, *self.shape, 2 * m))
        return mixed.view(complex).reshape(noise.shape)


def _combinations(kernel: Floats, parts: tuple[slice, ...]) -> list[Floats]:
    """Of kernel[f, |dz|, |dy|] the even and the odd combinations in y, (f, |dz|, i, j): sums over mirror images."""
    near, far, weight = _distances(kernel.shape[2], parts[0])
    direct, mirrored = np.take(kernel, near, axis=2), np.take(kernel, far, axis=2)
    odd = [(direct - mirrored)[..., : p.stop - p.start, : p.stop - p.start] for p in parts[1:]]  # their weights are 1
    return [(direct + mirrored) * weight, *odd]


def _block(along_y: Floats, z: slice) -> Floats:
    """The block of one parity in z of combinations in y; of the symmetric matrix the lower triangle alone."""
    near, far, weight = _distances(along_y.shape[1], z)
    rows, side = len(weight), along_y.shape[-1]
    block = np.zeros((len(along_y), rows, side, rows, side))
    for i in range(rows):
        direct, mirrored = along_y[:, near[i, : i + 1]], along_y[:, far[i, : i + 1]]
        both = direct - mirrored if z.start else direct + mirrored
        both *= weight[i, : i + 1, None, None]
        block[:, i, :, : i + 1] = both.swapaxes(1, 2)
    return block.reshape(len(along_y), rows * side, rows * side)


def _cholesky(matrix: Floats, width: int = 16) -> Floats:
    """Lower factors of (n, m, m) positive definite matrices, whose lower triangle is given, in panels.

    Products of this size run in the thread that asks for them; LAPACK's own factorisation of one moderate matrix starts
    threads for it, which on a machine with other work costs ten times what they compute.
    """
    factor = np.zeros_like(matrix)
    for start in range(0, matrix.shape[1], width):
        end = min(start + width, matrix.shape[1])
        panel = matrix[:, start:, start:end]
        if start:
            panel = panel - factor[:, start:, :start] @ factor[:, start:end, :start].swapaxes(1, 2)
        corner = np.linalg.cholesky(panel[:, : end - start])
        factor[:, start:end, start:end] = corner
        factor[:, end:, start:end] = panel[:, end - start :] @ np.linalg.inv(corner).swapaxes(1, 2)
    return factor


def _even_and_odd(n: int) -> tuple[Floats, tuple[slice, ...]]:
    """Orthonormal basis of n values, first the even, then any odd combinations, and where each kind stands."""
    half, even = n // 2, (n + 1) // 2
    basis = np.zeros((n, n))
    for i in range(half):
        basis[[i, n - 1 - i], i] = math.sqrt(0.5)
        basis[[i, n - 1 - i], even + i] = math.sqrt(0.5), -math.sqrt(0.5)
    if n % 2:
        basis[half, half] = 1
    return basis, (slice(0, even), slice(even, n))[: min(n, 2)]


def _distances(n: int, part: slice) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Steps between points i and j, between i and the mirror image of j, and the weights, of one parity."""
    i = np.arange(part.stop - part.start)
    weight = np.where(2 * i + 1 == n, math.sqrt(0.5), 1.0)
    return np.abs(i[:, None] - i), n - 1 - i[:, None] - i, weight[:, None] * weight
