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
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.language.run_time import RestingPlaces, TurningRings

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

ANGLES = 96  # of the integral over a ring
AROUND = 12  # points on a ring, for what rings of two rotors have in common
TABLE = np.geomspace(1e-4, 20.0, 80)  # Hz, of a table of the shares; below they do not change, above there are none
HARMONICS = 4  # multiples of the number of blades, on both sides
DECAYS = 1e-3, 1e3  # 1/m, of a coherence that decays exponentially with the distance
_LOGARITHMS = np.log(DECAYS[0]) + np.log(DECAYS[1] / DECAYS[0]) * (1 - np.cos(np.pi * np.arange(141) / 140)) / 2

Coherence = Callable[[Floats, Floats], Floats]
"""`(frequency [Hz] (q, 1, 1), distance [m] (1, pairs, angles)) -> coherence`, as one broadcasts them."""


def ring_shares(frequency: ArrayLike, radii: ArrayLike, orders: ArrayLike, coherence: Coherence) -> Floats:
    """K_m of the rings: (q, orders, r, r), at frequencies [Hz], of radii [m], for whole orders m.

    The sum over all orders is the coherence of two points on one ray, and 1 on one ring.
    """
    r, order = np.atleast_1d(np.asarray(radii, dtype=float)), np.atleast_1d(np.asarray(orders, dtype=int))
    return _of_rings((_around(frequency, r, coherence) @ _turns(order)).transpose(0, 2, 1), r.size)


def _of_rings(pairs: Floats, count: int) -> Floats:
    """Shares (q, orders, r, r) from those of each two rings (q, orders, pairs), which are the same in either order."""
    one, other = np.triu_indices(count)
    found = np.empty((*pairs.shape[:2], count, count))
    found[:, :, one, other] = found[:, :, other, one] = pairs
    return found


def _around(frequency: ArrayLike, r: Floats, coherence: Coherence) -> Floats:
    """Coherence of each two rings at the angles of half a ring, (q, pairs, angles); the other half is the same."""
    f = np.atleast_1d(np.asarray(frequency, dtype=float))[:, None, None]
    one, other = np.triu_indices(r.size)
    square = r[one, None] ** 2 + r[other, None] ** 2 - 2 * (r[one] * r[other])[:, None] * np.cos(_HALF)
    return coherence(f, np.sqrt(np.maximum(square, 0.0))[None])


_HALF = np.pi * np.arange(ANGLES // 2 + 1) / (ANGLES // 2)


def _turns(orders: NDArray[np.int64]) -> Floats:
    """Weights (angles, orders) of the angles of half a ring, for its harmonics."""
    weights = np.full(_HALF.size, 2 / ANGLES)
    weights[[0, -1]] = 1 / ANGLES
    return np.cos(_HALF[:, None] * orders) * weights[:, None]


@lru_cache(maxsize=256)
def _tables(radii: bytes, weights: tuple[bytes, ...], orders: tuple[tuple[int, ...], ...],
            coherence: Coherence) -> list[dict[int, PPoly]]:  # fmt: skip
    """Shares of weighted sums of rings over the logarithm of the frequency, by order, for each kind of sum."""
    from scipy.interpolate import PchipInterpolator, PPoly

    r, decay = np.frombuffer(radii), coherence.decay(TABLE) if hasattr(coherence, "decay") else np.zeros(1)
    decays = DECAYS[0] <= decay.min() and decay.max() <= DECAYS[1]
    around = None if decays else _around(TABLE, r, coherence)
    one, other = np.triu_indices(r.size)
    found = []
    for text, of_kind in zip(weights, orders, strict=True):
        w, whole = np.frombuffer(text).reshape(-1, r.size), tuple(sorted({abs(order) for order in of_kind}))
        pairs = _by_decay(radii, whole) if around is None else _of_pairs(around, whole)
        to_table = _barycentric(np.log(decay)).T if around is None else np.eye(TABLE.size)
        if len(w) ** 2 < one.size:
            of_pairs = w[:, None, one] * w[:, other] + np.where(one == other, 0.0, w[:, None, other] * w[:, one])
            sums = (of_pairs.reshape(-1, one.size) @ pairs).reshape(*of_pairs.shape[:2], len(whole), -1) @ to_table
            sums = np.moveaxis(sums, -1, 0)
        else:  # hardly fewer sums than rings
            table = (pairs.reshape(one.size, len(whole), -1) @ to_table).transpose(2, 1, 0)
            sums = np.moveaxis(w @ _of_rings(table, r.size) @ w.T, 1, -1)
        splines = PchipInterpolator(np.log(TABLE), sums, axis=0)
        found.append({order: PPoly.construct_fast(np.ascontiguousarray(splines.c[..., k]), splines.x)
                      for k, order in enumerate(whole)})  # fmt: skip
    return found


def _of_pairs(around: Floats, orders: tuple[int, ...]) -> Floats:
    """Shares of each two rings (pairs, orders q) of their coherence (q, pairs, angles)."""
    shares = (around @ _turns(np.array(orders))).transpose(1, 2, 0)
    return np.ascontiguousarray(shares).reshape(len(shares), -1)


@lru_cache(maxsize=16)
def _by_decay(radii: bytes, orders: tuple[int, ...]) -> Floats:
    """The same with a coherence exp(-rate distance), at rates that stand for all: those of all mean speeds."""
    rates = np.exp(_LOGARITHMS)
    return _of_pairs(_around(rates, np.frombuffer(radii), lambda rate, away: np.exp(-rate * away)), orders)


def _barycentric(places: Floats) -> Floats:
    """Weights (q, points) of the values at Chebyshev's points of the logarithm of the rate, at places (q,).

    J.-P. Berrut, L. N. Trefethen, SIAM Review 46 (2004) 501, eq. 4.2. Exponentials are polynomials there to rounding.
    """
    weights = (-1.0) ** np.arange(_LOGARITHMS.size)
    weights[[0, -1]] /= 2
    off = places[:, None] - _LOGARITHMS
    exact = off == 0
    found = weights / np.where(exact, 1.0, off)
    found[exact.any(axis=1)] = exact[exact.any(axis=1)]
    return found / found.sum(axis=1, keepdims=True)


def turning_density(omega: ArrayLike, radii: ArrayLike, rotor_speed: float, spectrum: Callable[[Floats], Floats],
                    coherence: Coherence, blades: int = 3, uniform: Floats | None = None,
                    once: Floats | None = None, highest: int = 1) -> Complexes:  # fmt: skip
    """One-sided spectra of g_0, 2 Re g_1 and -2 Im g_1 of all rings: (q, 3 r, 3 r) [unit of the spectrum], Hermitian.

    omega: circular frequencies (q,) [rad/s]; spectrum: one-sided, of omega, at a point; rotor_speed [rad/s]. Channels
    in this order, each ring after the other. A load sum_b B_b u(psi_b) of the blades is then, but for what turns with
    the rotor, B_0 g_0 + B_c (2 Re g_1) + B_s (-2 Im g_1), where B_0, B_c and B_s are the means over a turn of the sums
    over the blades of B_b, B_b cos(psi_b) and B_b sin(psi_b).

    uniform (a, r), once (b, r): weighted sums of g_0 and of g_1 in place of each ring: (q, a + 2 b, a + 2 b).
    highest: with the same of g_2 and so on behind, for slopes B_b that go round themselves, as those of a force along a
    fixed direction by the wind across.
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    r = np.atleast_1d(np.asarray(radii, dtype=float))
    alone, turned = (np.eye(r.size) if w is None else np.array(w, dtype=float, ndmin=2) for w in (uniform, once))
    harmonics = range(-HARMONICS, HARMONICS + 1)
    orders = tuple(tuple(p + blades * k for k in harmonics) for p in range(highest + 1))
    weights = alone.tobytes(), *[turned.tobytes()] * highest
    shares = _tables(r.tobytes(), weights, orders, coherence)

    def shifted(p: int, sense: int) -> Floats:
        """Of g_p at omega, or in the sense -1 at -omega, as if one-sided."""
        total = 0.0
        for k in harmonics:
            moved = np.maximum(np.abs(sense * omega - blades * k * rotor_speed), 1e-9)
            share = shares[p][abs(p + blades * k)](np.log(np.clip(moved / (2 * np.pi), TABLE[0], TABLE[-1])))
            total = total + share * np.asarray(spectrum(moved))[:, None, None]
        return total

    a, b = len(alone), len(turned)
    size = a + 2 * b * highest
    density = np.zeros((omega.size, size, size), dtype=complex)
    density[:, :a, :a] = shifted(0, 1)
    for p in range(1, highest + 1):
        forward, backward = shifted(p, 1), shifted(p, -1)
        even, odd = (slice(a + (2 * p - 2 + k) * b, a + (2 * p - 1 + k) * b) for k in range(2))
        density[:, even, even] = density[:, odd, odd] = forward + backward
        density[:, even, odd] = -1j * (forward - backward)
        density[:, odd, even] = 1j * (forward - backward)
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
                                                   *one.weights, one.orders)  # fmt: skip
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
