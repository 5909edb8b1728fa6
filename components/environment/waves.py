"""Linear waves: dispersion, JONSWAP spectrum, realisations and the kinematics of the water.

Plain numpy; nothing here knows the equation kernel. Airy theory in constant depth h, still water level z = 0, z up.
A sea is a sum of long-crested harmonics that travel along ``heading``, or each along a direction of its own,

    elevation(x, y, t) = sum_k a_k cos(omega_k t - k_k (x cos(heading) + y sin(heading)) + phase_k),

that is Re(sum_k a_k exp(i phase_k) T_k exp(+i omega_k t)) with the transfer T_k = exp(-i k_k (...)). Loads, velocities
and accelerations differ in nothing but T_k. The sign of i omega t is that of WAMIT.

An irregular sea has the frequencies n 2 pi / (repetition period), n = 1, 2, ...: it repeats itself after that period,
and its time functions come from one inverse FFT. Do not average over more than one period.

Sources: C.C. Mei, The Applied Dynamics of Ocean Surface Waves (1989), ch. 1; Hasselmann et al., JONSWAP (1973);
DNV-RP-C205 (2010), 3.5.5; J. Jonkman, NREL/TP-500-41958 (2007), sec. 2.4.1 (white noise of Box and Muller).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache, lru_cache
from threading import RLock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.language.errors import ParameterError

GRAVITY = 9.80665  # m/s^2, standard gravity
MOST_PERIODS = 20_000  # of a sea until it repeats itself: 100,000 components
LOWEST_FREQUENCY = 0.4  # of the peak frequency; less than 1e-21 of the energy lies below
HIGHEST_FREQUENCY = 5.0  # of the peak frequency; 0.20 % (gamma 1) to 0.12 % (gamma 5) of the energy lies above
SAMPLES_PER_PERIOD = 8  # in the shortest period; a cubic spline through them errs by 1e-3 there, 3e-5 of the whole sea

MOST_TABLES = 100  # of unit waves
_LOCK = RLock()

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def wave_number(omega: ArrayLike, depth: float, gravity: float = GRAVITY) -> Floats:
    """Wave number k [rad/m], the positive root of k tanh(k h) = omega^2 / g; same shape as `omega` [rad/s].

    Newton's iteration on x = k h from the explicit formula of Guo (Coastal Engineering 45, 2002), within 0.8 %; four
    steps reach the rounding error everywhere between shallow and deep water. `depth` [m] may be infinite.
    """
    omega = np.asarray(omega, dtype=float)
    if not depth > 0:
        raise ParameterError(f"water depth must be positive, got {depth:g} m")
    deep = omega**2 / gravity
    if math.isinf(depth):
        return deep
    y = deep * depth
    positive = np.where(y > 0, y, 1.0)
    x = positive / (-np.expm1(-(positive**1.245))) ** (1 / 2.49)
    for _ in range(4):
        tanh = np.tanh(x)
        x = x - (x * tanh - positive) / (tanh + x * (1 - tanh**2))
    return np.where(y > 0, x / depth, 0.0)


def default_gamma(significant_wave_height: float, peak_period: float) -> float:
    """Peak enhancement factor gamma [1] where none is given: DNV-RP-C205 3.5.5.5, the same in IEC 61400-3-1 annex D.

    gamma = 5 for Tp/sqrt(Hs) <= 3.6, 1 for >= 5, exp(5.75 - 1.15 Tp/sqrt(Hs)) between, with Hs [m] and Tp [s].
    """
    if significant_wave_height <= 0:
        return 1.0
    steepness = peak_period / math.sqrt(significant_wave_height)
    if steepness <= 3.6:
        return 5.0
    return 1.0 if steepness >= 5 else math.exp(5.75 - 1.15 * steepness)


def _peak_shape(x: Floats) -> Floats:
    """Exponent of gamma over x = omega / omega_p: a bell of width 0.07 below and 0.09 above the peak."""
    width = np.where(x <= 1, 0.07, 0.09)
    return np.exp(-0.5 * ((x - 1) / width) ** 2)


@cache
def _gauss_points() -> tuple[Floats, Floats]:
    """Of 100 points, whose eigenvalues take as long as all other numbers of a sea."""
    return np.polynomial.legendre.leggauss(100)


@lru_cache(maxsize=64)
def _peak_energy(gamma: float) -> float:
    """Energy of the JONSWAP shape relative to Pierson-Moskowitz, by Gauss quadrature on both sides of the peak."""
    node, weight = _gauss_points()
    energy = 1.0
    for low, high in ((0.3, 1.0), (1.0, 1.9)):
        x = 0.5 * (high - low) * node + 0.5 * (high + low)
        extra = 5 * x**-5 * np.exp(-1.25 * x**-4) * (gamma ** _peak_shape(x) - 1)
        energy += 0.5 * (high - low) * float(weight @ extra)
    return energy


def jonswap(omega: ArrayLike, significant_wave_height: float, peak_period: float, gamma: float | None = None) -> Floats:
    """One-sided JONSWAP spectrum S(omega) [m^2 s/rad] of the elevation; zero for omega <= 0.

    S = (5/16) Hs^2 omega_p^4 omega^-5 exp(-1.25 (omega_p/omega)^4) gamma^b / E(gamma),
    b = exp(-((omega/omega_p - 1)/sigma)^2 / 2), sigma = 0.07 below and 0.09 above the peak.
    E(gamma) is the exact energy of the shape, by quadrature, so that the integral over all frequencies is Hs^2/16 for
    every gamma. IEC 61400-3 and DNV print the fit 1/E = 1 - 0.287 ln(gamma), which is 0.3 % off for gamma <= 5 and
    1.8 % at 7.
    """
    if gamma is None:
        gamma = default_gamma(significant_wave_height, peak_period)
    omega = np.asarray(omega, dtype=float)
    x = np.where(omega > 0, omega * peak_period / (2 * np.pi), 1.0)
    with np.errstate(over="ignore", under="ignore"):
        decay = np.exp(-1.25 * x**-4.0 - 5 * np.log(x))
    density = 5 / 16 * significant_wave_height**2 * peak_period / (2 * np.pi) * decay
    return np.where(omega > 0, density * gamma ** _peak_shape(x) / _peak_energy(float(gamma)), 0.0)


@dataclass(frozen=True, eq=False)
class WaveComponents:
    """The harmonics of one sea; every array has shape (n,), n = 0 in still water.

    omega [rad/s], amplitude [m], phase [rad], wave_number [rad/m], heading [rad], period of repetition [s], depth [m].
    directions [rad]: of each harmonic, about `heading`, where the sea is short-crested; None: all travel along it.
    A transfer is a complex array (n, m): m real quantities per metre of wave amplitude at every frequency.
    """

    omega: Floats
    amplitude: Floats
    phase: Floats
    wave_number: Floats
    heading: float
    period: float
    depth: float
    tables: dict[Any, Any] | None = field(default=None, repr=False)
    directions: Floats | None = None

    def of_each_direction(self) -> Iterator[tuple[Any, WaveComponents]]:
        """The harmonics that travel alike, as long-crested waves, with their places among all."""
        if self.directions is None:
            yield slice(None), self
            return
        for direction in np.unique(self.directions):
            rows = np.flatnonzero(self.directions == direction)
            arrays = (self.omega[rows], self.amplitude[rows], self.phase[rows], self.wave_number[rows])
            yield rows, WaveComponents(*arrays, self.heading + float(direction), self.period, self.depth)

    def by_direction(self, transfer: Callable[[WaveComponents], ArrayLike]) -> Complexes:
        """A transfer of long-crested waves, complex (n, m), of all harmonics."""
        if self.directions is None:
            return self.columns(transfer(self))
        parts = [(rows, waves.columns(transfer(waves))) for rows, waves in self.of_each_direction()]
        found = np.empty((len(self), parts[0][1].shape[1]), dtype=complex)
        for rows, values in parts:
            found[rows] = values
        return found

    def kept(self, key: Any, make: Callable[[], Any]) -> Any:
        """What `make` computes of these waves, not to be changed; of unit waves it is kept, the last ones, by key."""
        if self.tables is None:
            return make()
        with _LOCK:
            made = self.tables.pop(key) if key in self.tables else make()
            self.tables[key] = made  # the last one used is the last to go
            while len(self.tables) > MOST_TABLES:
                del self.tables[next(iter(self.tables))]
        return made

    def __len__(self) -> int:
        return len(self.omega)

    def __repr__(self) -> str:
        if not len(self):
            return "WaveComponents(still water)"
        low, high = self.omega[0], self.omega[-1]
        height = self.significant_wave_height
        return f"WaveComponents({len(self)} from {low:.3g} to {high:.3g} rad/s, Hs {height:.3g} m)"

    @property
    def complex_amplitude(self) -> Complexes:
        """Complex amplitudes a exp(i phase), shape (n,), m."""
        return self.amplitude * np.exp(1j * self.phase)

    @property
    def variance(self) -> float:
        """Variance of this realisation's elevation over one period, m^2."""
        return float(np.sum(self.amplitude**2) / 2)

    @property
    def significant_wave_height(self) -> float:
        """Four standard deviations of this realisation, m; with random amplitudes it differs from seed to seed."""
        return 4 * math.sqrt(self.variance)

    def elevation_transfer(self, points: ArrayLike) -> Complexes:
        """Elevation at `points` (p, 2 or 3) [m] per unit amplitude at the origin; shape (n, p)."""
        points = np.atleast_2d(np.asarray(points, dtype=float))
        if self.directions is not None:
            return self.by_direction(lambda waves: waves.elevation_transfer(points))
        along = points[:, 0] * math.cos(self.heading) + points[:, 1] * math.sin(self.heading)
        return np.exp(-1j * np.outer(self.wave_number, along))

    def velocity_transfer(self, points: ArrayLike) -> Complexes:
        """Water velocity (world) at fixed `points` (p, 3) [m] per unit amplitude [1/s]; shape (n, p, 3).

        Horizontal omega cosh(k(z+h))/sinh(kh), vertical i omega sinh(k(z+h))/sinh(kh), times exp(-i k x).
        Zero above the still water level: linear theory ends at z = 0. Raises ParameterError below the sea bed.
        """
        points = np.atleast_2d(np.asarray(points, dtype=float))
        z = points[:, 2]
        if np.any(z < -self.depth * (1 + 1e-9)):
            raise ParameterError(f"point at z = {z.min():g} m lies below the sea bed at {-self.depth:g} m")
        if self.directions is not None:
            flat = self.by_direction(lambda waves: waves.velocity_transfer(points).reshape(len(waves), -1))
            return flat.reshape(len(self), len(points), 3)
        horizontal, vertical = depth_decay(self.wave_number, z, self.depth)
        wave = self.omega[:, None] * self.elevation_transfer(points) * (z <= 0)
        along = wave * horizontal
        return np.stack([along * math.cos(self.heading), along * math.sin(self.heading), 1j * wave * vertical], axis=-1)

    def acceleration_transfer(self, points: ArrayLike) -> Complexes:
        """Local acceleration i omega (velocity transfer), per unit amplitude [1/s^2]; shape (n, p, 3)."""
        return 1j * self.omega[:, None, None] * self.velocity_transfer(points)

    def evaluate(self, transfer: ArrayLike, time: ArrayLike) -> Floats:
        """Sum of the harmonics at any times (nt,) [s]; shape (nt, m). Direct and slow, for checks and few points."""
        weighted = self.complex_amplitude[:, None] * self.columns(transfer)
        angle = np.outer(np.atleast_1d(np.asarray(time, dtype=float)), self.omega)
        return np.cos(angle) @ weighted.real - np.sin(angle) @ weighted.imag

    @property
    def samples(self) -> int:
        """Samples of one repetition period: a power of two with SAMPLES_PER_PERIOD in the shortest wave period."""
        return 1 << math.ceil(math.log2(max(16, SAMPLES_PER_PERIOD * int(self._harmonic[-1])))) if len(self) else 16

    def series(self, transfer: ArrayLike) -> Floats:
        """One whole period on the uniform grid t = j period / samples, by inverse FFT; shape (samples, m)."""
        return np.fft.irfft(self.spectrum(transfer), self.samples, axis=1).T

    def spectrum(self, transfer: ArrayLike) -> Complexes:
        """The discrete Fourier transform of `series`; shape (m, samples // 2 + 1)."""
        columns = self.columns(transfer)
        half = np.zeros((columns.shape[1], self.samples // 2 + 1), dtype=complex)
        half[:, self._harmonic] = (0.5 * self.samples * self.complex_amplitude[:, None] * columns).T
        return half

    @property
    def _harmonic(self) -> NDArray[np.int64]:
        return np.rint(self.omega * self.period / (2 * np.pi)).astype(int)

    def columns(self, transfer: ArrayLike) -> Complexes:
        """A transfer as a complex array (n, m); raises ValueError where the rows are not one per component."""
        columns = np.asarray(transfer, dtype=complex)
        columns = columns.reshape(-1, 1) if columns.ndim == 1 else columns
        if columns.ndim != 2 or len(columns) != len(self):
            raise ValueError(f"transfer has shape {np.shape(transfer)}, expected ({len(self)}, m): one row a component")
        return columns


def depth_decay(number: Floats, z: Floats, depth: float) -> tuple[Floats, Floats]:
    """Factors cosh(k(z+h))/sinh(kh) and sinh(k(z+h))/sinh(kh), shape (n, p), for -h <= z; z > 0 counts as 0.

    Written with decaying exponentials only, exact in shallow water and without overflow in deep water.
    """
    k, z = np.asarray(number, dtype=float)[:, None], np.minimum(np.asarray(z, dtype=float), 0.0)[None, :]
    direct = np.exp(k * z)
    if math.isinf(depth):
        return direct, direct
    scale = -np.expm1(-2 * k * depth)
    return (
        direct * (1 + np.exp(-2 * k * (z + depth))) / scale,
        direct * -np.expm1(-2 * k * np.maximum(z + depth, 0.0)) / scale,
    )


def unit_waves(omega: ArrayLike, depth: float, heading: float = 0.0, gravity: float = GRAVITY) -> WaveComponents:
    """Harmonics of 1 m of amplitude, whose crests pass the origin at t = 0, at omega (n,) [rad/s].

    The same ones again, with what was computed of them, where they were asked for lately: all parts of a model ask.
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    return _unit_waves(omega.tobytes(), float(depth), float(heading), float(gravity))


@lru_cache(maxsize=24)  # of a short-crested sea each direction
def _unit_waves(frequencies: bytes, depth: float, heading: float, gravity: float) -> WaveComponents:
    omega = np.frombuffer(frequencies)
    number = wave_number(omega, depth, gravity)
    waves = omega, np.ones(omega.size), np.zeros(omega.size), number, heading, math.inf, depth
    return WaveComponents(*waves, tables={})


def still_water(depth: float, heading: float = 0.0) -> WaveComponents:
    """No waves at all."""
    none = np.zeros(0)
    return WaveComponents(none, none, none, none, heading, math.inf, depth)


def steepest_sea(peak_period: float, gravity: float = GRAVITY) -> float:
    """Highest Hs [m] for a peak period [s]: the limits of steepness 2 pi Hs/(g Tp^2) of DNV-RP-C205 (2010), 3.5.4.

    1/15 up to 8 s, 1/25 from 15 s on, linear between.
    """
    return float(gravity * peak_period**2 / (2 * np.pi) * np.interp(peak_period, [8, 15], [1 / 15, 1 / 25]))


def breaking_height(period: float, depth: float, gravity: float = GRAVITY) -> float:
    """Height [m] at which a regular wave breaks: 0.142 L tanh(2 pi d/L), Miche; DNV-RP-C205 (2010), 3.4.6.1."""
    k = float(wave_number(np.array([2 * np.pi / period]), depth, gravity)[0])
    return float(0.142 * 2 * np.pi / k * np.tanh(k * depth))


def regular_waves(
    height: float, period: float, depth: float, *, heading: float = 0.0, gravity: float = GRAVITY
) -> WaveComponents:
    """One harmonic of amplitude height/2 [m] with a crest at the origin at t = 0; `period` [s], `heading` [rad]."""
    if not period > 0:
        raise ParameterError(f"wave period must be positive, got {period:g} s")
    omega = np.array([2 * np.pi / period])
    number = wave_number(omega, depth, gravity)
    return WaveComponents(omega, np.array([height / 2]), np.zeros(1), number, heading, period, depth)


def irregular_waves(
    significant_wave_height: float,
    peak_period: float,
    depth: float,
    *,
    gamma: float | None = None,
    heading: float = 0.0,
    seed: int = 1,
    random_amplitudes: bool = True,
    repetition_period: float = 4096.0,
    gravity: float = GRAVITY,
) -> WaveComponents:
    """One realisation of a JONSWAP sea with spacing 2 pi / repetition_period, from 0.4 to 5 times the peak frequency.

    Random amplitudes make the elevation a Gaussian process: the white noise of Box and Muller, r exp(i phi) with
    r = sqrt(-2 ln U1) and phi = 2 pi U2, shapes the amplitude sqrt(S d_omega) r, so that E[a^2/2] = S d_omega and the
    variance differs from seed to seed. Otherwise a = sqrt(2 S d_omega), only the phases are random and every seed has
    the same variance. The noise belongs to the number of the harmonic: seas of one seed and one repetition period have
    the same phases whatever their peak period is.

    Turbulence of the same seed draws from the same stream (numpy takes 3 and [3, 0] for one seed): the phase of the
    k-th harmonic is that of the 2k-th of turbulence.kaimal_series at its first station. Of equal periods these are
    different frequencies, and no harmonic of the one is coherent with that of the other; but over the seeds elevation
    and wind are correlated at t = 0 (0.15 to 0.23), below 0.05 after 2 to 4 s. Where the wind has twice the period of
    the sea they are the same frequencies, and coherent (coherence squared pi/4). Give wind and sea different seeds.

    The upper end leaves out 0.1 to 0.2 % of the elevation's variance (not made up for by scaling); particle
    accelerations near the surface, whose spectrum decays as 1/omega only, are those of this cut-off sea.
    """
    if not (peak_period > 0 and significant_wave_height >= 0):
        raise ParameterError(
            f"significant wave height {significant_wave_height:g} m must not be negative and peak period "
            f"{peak_period:g} s must be positive"
        )
    if repetition_period < 20 * peak_period:
        raise ParameterError(
            f"repetition period {repetition_period:g} s is too short for a peak period of {peak_period:g} s; "
            "take 4096 s or more"
        )
    if repetition_period / peak_period > MOST_PERIODS:
        raise ParameterError(
            f"a repetition period of {repetition_period:g} s has {repetition_period / peak_period:.3g} peak periods of "
            f"{peak_period:g} s; the limit is {MOST_PERIODS}."
        )
    step = 2 * np.pi / repetition_period
    first = math.ceil(LOWEST_FREQUENCY * repetition_period / peak_period)
    last = math.floor(HIGHEST_FREQUENCY * repetition_period / peak_period)
    omega = step * np.arange(first, last + 1)
    uniform = np.random.default_rng(seed).random((last, 2))[first - 1 :]
    radius = np.sqrt(-2 * np.log1p(-uniform[:, 0])) if random_amplitudes else math.sqrt(2)
    amplitude = np.sqrt(step * jonswap(omega, significant_wave_height, peak_period, gamma)) * radius
    phase = 2 * np.pi * uniform[:, 1]
    number = wave_number(omega, depth, gravity)
    return WaveComponents(omega, amplitude, phase, number, heading, repetition_period, depth)
