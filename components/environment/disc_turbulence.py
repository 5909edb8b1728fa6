"""Turbulence as a turning rotor feels it: spectra of its means over the blades, from those at rest.

On a ring of radius r the fluctuation along the wind is u = sum_m a_m(r, t) exp(i m theta). Where turbulence is the same
at all places and in all directions across the wind, amplitudes of different m are independent, and

    <a_m(r_j) a_m(r_k)*> = K_m S,  K_m = 1/pi int_0^pi coherence(d(angle)) cos(m angle) d angle,
    d^2 = r_j^2 + r_k^2 - 2 r_j r_k cos(angle).

What all n blades of a rotor do together, at azimuths psi = Omega t + 2 pi b / n, depends on the sums

    g_p = sum_k a_(p + n k) exp(i n k Omega t):  p = 0 thrust and torque, p = 1 the tilt and yaw moments,

so that the shift of a ring's eddies by the rotation puts energy at multiples of n Omega and none between.
Source: P.S. Veers, SAND88-0152 (1988); A. Halfpenny, Dynamic analysis of both on and offshore wind turbines in the
frequency domain, PhD thesis (1998), ch. 4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from fowtlib.language.run_time import RestingPlaces, TurningRings

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

ANGLES = 96  # of the integral over a ring
AROUND = 12  # points on a ring, for what rings of two rotors have in common
TABLE = np.geomspace(1e-4, 20.0, 80)  # Hz, of a table of the shares; below they do not change, above there are none
HARMONICS = 4  # multiples of the number of blades, on both sides

Coherence = Callable[[Floats, Floats], Floats]
"""`(frequency [Hz] (q, 1, 1, 1), distance [m] (1, r, r, angles)) -> coherence`."""


def ring_shares(frequency: ArrayLike, radii: ArrayLike, orders: ArrayLike, coherence: Coherence) -> Floats:
    """K_m of the rings: (q, orders, r, r), at frequencies [Hz], of radii [m], for whole orders m.

    The sum over all orders is the coherence of two points on one ray, and 1 on one ring.
    """
    r, order = np.atleast_1d(np.asarray(radii, dtype=float)), np.atleast_1d(np.asarray(orders, dtype=int))
    f = np.atleast_1d(np.asarray(frequency, dtype=float))[:, None, None, None]
    angle = np.pi * np.arange(ANGLES // 2 + 1) / (ANGLES // 2)  # the other half of a ring is the same
    square = r[:, None, None] ** 2 + r[None, :, None] ** 2 - 2 * r[:, None, None] * r[None, :, None] * np.cos(angle)
    one, other = np.triu_indices(r.size)  # two rings have the same in common in either order
    values = np.empty((f.shape[0], r.size, r.size, angle.size))
    values[:, one, other] = coherence(f[..., 0], np.sqrt(np.maximum(square[one, other], 0.0))[None])
    values[:, other, one] = values[:, one, other]
    turns = np.cos(angle[:, None] * order) * np.where((angle == 0) | (angle == angle[-1]), 1, 2)[:, None] / ANGLES
    return np.moveaxis(values @ turns, 3, 1)


@lru_cache(maxsize=256)
def _tables(radii: bytes, weights: tuple[bytes, ...], orders: tuple[tuple[int, ...], ...],
            coherence: Coherence) -> list[dict[int, PchipInterpolator]]:  # fmt: skip
    """Shares of weighted sums of rings over the logarithm of the frequency, by order, for each kind of sum."""
    r = np.frombuffer(radii)
    whole = sorted({abs(order) for of_kind in orders for order in of_kind})
    table = ring_shares(TABLE, r, whole, coherence)
    found = []
    for text, of_kind in zip(weights, orders, strict=True):
        w = np.frombuffer(text).reshape(-1, r.size)
        sums = {abs(order): w @ table[:, whole.index(abs(order))] @ w.T for order in of_kind}
        found.append({order: PchipInterpolator(np.log(TABLE), sums[order], axis=0) for order in sums})
    return found


def turning_density(omega: ArrayLike, radii: ArrayLike, rotor_speed: float, spectrum: Callable[[Floats], Floats],
                    coherence: Coherence, blades: int = 3, uniform: Floats | None = None,
                    once: Floats | None = None) -> Complexes:  # fmt: skip
    """One-sided spectra of g_0, 2 Re g_1 and -2 Im g_1 of all rings: (q, 3 r, 3 r) [unit of the spectrum], Hermitian.

    omega: circular frequencies (q,) [rad/s]; spectrum: one-sided, of omega, at a point; rotor_speed [rad/s]. Channels
    in this order, each ring after the other. A load sum_b B_b u(psi_b) of the blades is then, but for what turns with
    the rotor, B_0 g_0 + B_c (2 Re g_1) + B_s (-2 Im g_1), where B_0, B_c and B_s are the means over a turn of the sums
    over the blades of B_b, B_b cos(psi_b) and B_b sin(psi_b).

    uniform (a, r), once (b, r): weighted sums of g_0 and of g_1 in place of each ring: (q, a + 2 b, a + 2 b).
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    r = np.atleast_1d(np.asarray(radii, dtype=float))
    alone, turned = (np.eye(r.size) if w is None else np.array(w, dtype=float, ndmin=2) for w in (uniform, once))
    harmonics = range(-HARMONICS, HARMONICS + 1)
    orders = tuple(blades * k for k in harmonics), tuple(1 + blades * k for k in harmonics)
    shares_of_0, shares_of_1 = _tables(r.tobytes(), (alone.tobytes(), turned.tobytes()), orders, coherence)

    def shifted(shares: dict[int, PchipInterpolator], order: int, at: Floats) -> Floats:
        moved = np.maximum(np.abs(at), 1e-9)
        share = shares[abs(order)](np.log(np.clip(moved / (2 * np.pi), TABLE[0], TABLE[-1])))
        return share * np.asarray(spectrum(moved))[:, None, None]

    a, b = len(alone), len(turned)
    still = np.zeros((omega.size, a, a))
    forward, backward = np.zeros((2, omega.size, b, b))  # of g_1 at omega and at -omega, two-sided
    for k in harmonics:
        shift = blades * k * rotor_speed
        still += shifted(shares_of_0, blades * k, omega - shift)
        forward += shifted(shares_of_1, 1 + blades * k, omega - shift) / 2
        backward += shifted(shares_of_1, 1 + blades * k, -omega - shift) / 2
    density = np.zeros((omega.size, a + 2 * b, a + 2 * b), dtype=complex)
    density[:, :a, :a] = still
    density[:, a : a + b, a : a + b] = density[:, a + b :, a + b :] = 2 * (forward + backward)
    density[:, a : a + b, a + b :] = -2j * (forward - backward)
    density[:, a + b :, a : a + b] = 2j * (forward - backward)
    return density


def places_density(omega: ArrayLike, places: Sequence[TurningRings | RestingPlaces],
                   spectrum: Callable[[Floats], Floats], coherence: Coherence) -> Complexes:  # fmt: skip
    """One-sided spectra of all channels of places, see TurningRings and RestingPlaces: (q, channels, channels).

    Between rotors, and between rotors and places at rest, the uniform parts of the rings go together, with the mean of
    the coherence over the rings; what goes once round is taken as independent there.
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    ends = np.cumsum([0, *(item.channels for item in places)])
    density = np.zeros((omega.size, ends[-1], ends[-1]), dtype=complex)
    alone = np.asarray(spectrum(omega))[:, None, None]
    for i, one in enumerate(places):
        own = slice(ends[i], ends[i + 1])
        if isinstance(one, TurningRings):
            density[:, own, own] = turning_density(omega, one.radii, abs(one.speed), spectrum, coherence, one.blades,
                                                   *one.weights)  # fmt: skip
        else:
            density[:, own, own] = _together(omega, one, one, coherence) * alone
        for k in range(i):
            other = places[k]
            cross = _together(omega, one, other, coherence) * alone
            rows, columns = (slice(ends[j], ends[j] + cross.shape[1 + n]) for n, j in enumerate((i, k)))
            density[:, rows, columns] = cross
            density[:, columns, rows] = cross.transpose(0, 2, 1)
    return density


def _together(omega: Floats, one: Any, other: Any, coherence: Coherence) -> Floats:
    """Mean coherence of each ring, sum of rings or place of one with each of the other: (q, a, a)."""
    a, b = _points(one), _points(other)
    distance = np.linalg.norm(a[:, None, :, None] - b[None, :, None, :], axis=-1)
    frequency = (omega / (2 * np.pi))[:, None, None]
    flat = distance.reshape(len(a), len(b), -1)
    mean = sum(coherence(frequency, flat[..., k]) for k in range(flat.shape[-1])) / flat.shape[-1]
    left, right = (item.weights[0] if isinstance(item, TurningRings) else np.eye(len(item.positions))
                   for item in (one, other))  # fmt: skip
    return left @ mean @ right.T


def _points(places: Any) -> Floats:
    """Points across the flow (y, z) of rings (r, angles, 2), or of places (n, 1, 2)."""
    if isinstance(places, RestingPlaces):
        return places.positions[:, None, 1:]
    angle = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    around = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return places.centre[1:] + places.radii[:, None, None] * around
