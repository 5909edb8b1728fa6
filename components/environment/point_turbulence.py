"""Turbulence that is independent from point to point of a grid, as places between these and turning rotors feel it.

So a field has v and w where IEC gives no coherence for them (field_generator). A place has the sum of the points about
it with the weights of the interpolation: with its own spectrum S at every point, places i and j have S sum_g w_ig w_jg
in common, whatever the frequency. On a ring the weights are sum_m W_m exp(i m theta), and all n blades of a rotor
together, at psi = Omega t + 2 pi b / n, feel

    g_p = sum_k a_(p + n k) exp(i n k Omega t),   <a_l a_m*> = S sum_g W_lg W_mg*,

see disc_turbulence. Where the points lie matters here: orders l and m have a part in common, which they have not where
the turbulence is the same everywhere. Of what g_p and g_q have in common the mean over a turn counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.environment.disc_turbulence import HARMONICS
from fowtlib.components.environment.field_lookup import SAMPLES, cell_weights
from fowtlib.language.run_time import RestingPlaces, TurningRings

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Places = RestingPlaces | TurningRings

ROUND = 256  # angles on a ring; points are 10 m apart or so, on rings of 400 m


@dataclass(frozen=True)
class PointGrid:
    """The points of a field in its plane: y of the first column, z of the lowest row, distances [m] and counts."""

    first: float
    lowest: float
    dy: float
    dz: float
    columns: int
    rows: int
    interpolation: str = "linear"

    def weights(self, places: Floats) -> Floats:
        """Of the points (rows x columns), rows slowest, at places (n, 2): y and z [m]; beyond the edge those there."""
        count = SAMPLES[self.interpolation]
        whole = np.zeros((len(places), self.rows, self.columns))
        across = cell_weights(self.columns, (places[:, 0] - self.first) / self.dy, count)
        up = cell_weights(self.rows, (places[:, 1] - self.lowest) / self.dz, count)
        each = np.arange(len(places))[:, None, None]
        np.add.at(whole, (each, up[0][:, :, None], across[0][:, None, :]), up[1][:, :, None] * across[1][:, None, :])
        return whole.reshape(len(places), -1)


def point_density(omega: ArrayLike, places: Sequence[Places], spectrum: Callable[[Floats], Floats], grid: PointGrid,
                  basis: Floats | None = None) -> Complexes:  # fmt: skip
    """One-sided spectra of all channels of places, see TurningRings and RestingPlaces: (q, channels, channels).

    spectrum: one-sided, of circular frequencies omega (q,) [rad/s], at a point. basis (channels, k): of sums of the
    channels with these weights, (q, k, k). What a rotor has in common with other rotors and places is what it has
    without the shift by its turning.
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    still, moving = _factors(tuple(map(_Key, places)), grid)
    take = (lambda factor: factor) if basis is None else (lambda factor: basis.T @ factor)
    shifts, products = [0.0], [take(still)]
    for speed, factor in moving:
        shifts.append(speed)
        products.append(take(factor))
    strengths = np.stack([spectrum(np.maximum(np.abs(omega - shift), 1e-9)) for shift in shifts], axis=1)
    common = np.stack([factor @ factor.conj().T for factor in products])
    return np.tensordot(strengths.astype(complex), common, axes=1)


class _Key:
    """Places as a key, by their numbers."""

    def __init__(self, places: Places):
        self.places = places
        parts = (places.positions,) if isinstance(places, RestingPlaces) else (places.centre, places.radii,
                                                                               *places.weights)  # fmt: skip
        more = () if isinstance(places, RestingPlaces) else (places.speed, places.blades, places.orders)
        self._content = (*((part.shape, np.asarray(part, dtype=float).tobytes()) for part in parts), *more)

    def __hash__(self) -> int:
        return hash(self._content)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self._content == other._content


@lru_cache(maxsize=8)
def _factors(keys: tuple[_Key, ...], grid: PointGrid) -> tuple[Complexes, list[tuple[float, Complexes]]]:
    """Weights of the points in all channels (channels, points), without a shift, and with each shift [rad/s]."""
    channels = sum(key.places.channels for key in keys)
    still = np.zeros((channels, grid.rows * grid.columns), dtype=complex)
    moving: list[tuple[float, Complexes]] = []
    end = 0
    for key in keys:
        own = slice(end, end := end + key.places.channels)
        if isinstance(key.places, RestingPlaces):
            still[own] = grid.weights(key.places.positions[:, 1:])
            continue
        rings, turned = key.places, _round(key.places, grid)
        for k in range(-HARMONICS, HARMONICS + 1):
            factor = _channels(rings, turned, k)
            if k == 0:
                still[own] = factor
            else:
                whole = np.zeros_like(still)
                whole[own] = factor
                moving.append((rings.blades * k * abs(rings.speed), whole))
    return still, moving


def _round(rings: TurningRings, grid: PointGrid) -> Complexes:
    """W_m of each ring (ROUND, r, points), m as in numpy's FFT, of angles in the sense of the turning."""
    angle = 2 * np.pi * np.arange(ROUND) / ROUND
    sense = np.sign(rings.speed) or 1.0
    around = np.stack([np.cos(angle), sense * np.sin(angle)], axis=-1)
    places = rings.centre[1:] + rings.radii[:, None] * around[:, None]
    weights = grid.weights(places.reshape(-1, 2)).reshape(ROUND, len(rings.radii), -1)
    return np.fft.fft(weights, axis=0) / ROUND


def _channels(rings: TurningRings, turned: Complexes, k: int) -> Complexes:
    """Weights of the points in the channels: g_0, then 2 Re g_p = g_p + g_-p and -2 Im g_p = i (g_p - g_-p)."""
    uniform, once = rings.weights
    found = [uniform @ turned[rings.blades * k % ROUND]]
    for p in range(1, rings.orders + 1):
        ahead, behind = (once @ turned[(sign * p + rings.blades * k) % ROUND] for sign in (1, -1))
        found += [ahead + behind, 1j * (ahead - behind)]
    return np.concatenate(found)
