"""Azimuths of a rotor whose speed is random and depends on the azimuth: where it lingers, and spectra of its phasors.

What passes the dam of the tower, and hangs, turns unevenly. With the speeds that the loads of the turning make, v_n,
and a Gaussian part xi that the rest makes,

    dpsi/dt = Omega + sum_n 2 Re(v_n exp(i n psi)) + xi.

For the phasors z_n = exp(i n psi) the mean over xi obeys

    d E[z_n]/dt = i n sum_k v_k E[z_(n + k)] - n^2 D'(t)/2 E[z_n],  v_0 = Omega, v_-k = v_k*,

with the variance D of the angle that xi adds in a time t (frequency.lines). That is exact where all v_n vanish, with
the lines of RandomSpeed, and where xi is white: then it is the Fokker-Planck equation of the azimuth, whose
stationary density is 1/speed where nothing is random (H. Risken, The Fokker-Planck Equation, 2nd ed. 1989, ch. 11;
time-local cumulants: N. G. van Kampen, Physica 74 (1974) 215). Between them it asks that a change of xi lasts short
beside the time in which the rotor passes what v_n has. xi is independent of the azimuth at the beginning of a lag.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import gcd

import numpy as np
from scipy.linalg import expm

from fowtlib.frequency.lines import COUNT, STEP, RandomSpeed

FURTHER = 4  # orders that are kept on the way, over those that are asked for
SKIP = 2  # steps of D in one of the correlation
LENGTH = COUNT // 4 // SKIP  # of a correlation: 4096 s, parts of spectra 1.2e-4 Hz
SOME = 1e-6  # of the largest: speeds that tie orders together
EVEN = 0.01  # of a phasor in the mean, up to which a rotor is at all azimuths alike
SHARP = 0.02  # of a phasor of the highest order: a density that these orders do not show


@dataclass(frozen=True, eq=False)
class Lingering:
    """The azimuth of a rotor with speeds v_n (orders,) [rad/s], n = 1, ..., that come from the azimuth."""

    speed: RandomSpeed
    by_azimuth: np.ndarray

    @property
    def orders(self) -> int:
        """Number of orders that are asked for."""
        return len(self.by_azimuth)

    @cached_property
    def step(self) -> int:
        """Orders that differ by a multiple of it are tied together: the number of blades, where these are alike."""
        sizes = np.abs(self.by_azimuth)
        tied = np.flatnonzero((sizes > SOME * sizes.max()) & (sizes > 0)) + 1
        return gcd(*tied.tolist()) if tied.size else 1

    def _rates(self, orders: np.ndarray) -> np.ndarray:
        """Of the phasors of these orders by themselves, without xi."""
        apart = orders[None, :] - orders[:, None]
        size = np.abs(apart)
        v = np.concatenate([[self.speed.speed / 2], self.by_azimuth, [0.0]])[np.minimum(size, self.orders + 1)]
        speeds = np.where(apart >= 0, v, 0.0) + np.where(apart <= 0, v.conj(), 0.0)
        return 1j * orders[:, None] * speeds

    @cached_property
    def lag(self) -> int:
        """Steps of D after which the first orders that are tied together have gone round, or xi has left nothing."""
        gone = np.flatnonzero(self.speed.spread[: COUNT // 2] > 2 / self.step**2)
        round_once = 2 * np.pi / (self.step * max(abs(self.speed.speed), 1e-12) * STEP)
        return max(1, int(min(round_once, gone[0] if gone.size else np.inf, COUNT // 2 - 1)))

    @cached_property
    def diffusion(self) -> float:
        """D / (2 t) [rad^2/s] at this lag."""
        return float(self.speed.spread[self.lag] / (2 * STEP * self.lag))

    @cached_property
    def means(self) -> np.ndarray:
        """E[z_n] for n = 0, ...: (orders FURTHER + 1,); where nothing is random, those of all azimuths alike."""
        highest = self._highest
        tied = np.arange(-highest, highest + 1, self.step)
        rates, middle = self._rates(tied) - np.diag(self.diffusion * tied**2), len(tied) // 2
        others = tied != 0
        found = np.zeros(FURTHER * self.orders + 1, dtype=complex)
        found[0] = 1.0
        if self.diffusion > 0:
            z = np.linalg.solve(rates[np.ix_(others, others)], -rates[others, middle])
            found[self.step : highest + 1 : self.step] = z[middle:]
        return found

    @property
    def _highest(self) -> int:
        """The highest order that is tied to the mean."""
        return FURTHER * self.orders // self.step * self.step

    @property
    def matters(self) -> bool:
        """Whether the rotor is at some azimuths longer than at others, and the orders show by how much.

        They do not where hardly anything is random and the rotor all but stops: a density that is too sharp.
        """
        sizes = np.abs(self.means[1:])
        return bool(sizes.max() > EVEN and sizes[self._highest - 1] < SHARP)

    def spectra(self, frequency: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Orders (k,) that are tied together, and what parts of the axis have of their covariance: (parts, k, k).

        frequency: limits (parts + 1,) [Hz] of the parts, rising, of both signs.
        """
        found = []
        for rest in range(self.step):
            orders = np.arange(-FURTHER * self.orders, FURTHER * self.orders + 1)
            orders = orders[orders % self.step == rest]
            kept = np.flatnonzero(np.abs(orders) <= self.orders)
            whole = _of_correlation(self._correlation(orders, kept))
            below = np.concatenate([np.zeros_like(whole[:1]), np.cumsum(whole, axis=0)])
            at = np.clip(2 * LENGTH * SKIP * STEP * frequency + LENGTH + 0.5, 0, 2 * LENGTH)  # in parts of `whole`
            low = np.minimum(at.astype(int), 2 * LENGTH - 1)
            share = (at - low)[:, None, None]
            found.append((orders[kept], np.diff(below[low] * (1 - share) + below[low + 1] * share, axis=0)))
        return found

    @property
    def _spread(self) -> np.ndarray:
        """D at the lags (LENGTH + 1,) of a correlation, which does not fall, and at long lags grows with the diffusion.

        What would fall is what comes back of an angle, and tied orders of a phasor do not.
        """
        steps = SKIP * np.arange(LENGTH + 1)
        known = np.maximum.accumulate(self.speed.spread[: COUNT // 2])[steps]
        return np.where(steps < self.lag, known, 2 * self.diffusion * STEP * steps)

    def _correlation(self, orders: np.ndarray, kept: np.ndarray) -> np.ndarray:
        """E[z_n(t) z_m*(0)] - E[z_n] E[z_m]* at lags (LENGTH,), of the orders that are kept: (LENGTH, k, k)."""
        means = np.concatenate([self.means[:0:-1].conj(), self.means])
        zero = len(self.means) - 1
        apart = orders[:, None] - orders[None, kept]
        now = np.where(np.abs(apart) <= zero, means[np.clip(apart + zero, 0, 2 * zero)], 0.0)
        now = now - np.outer(means[orders + zero], means[orders[kept] + zero].conj())
        on = expm(SKIP * STEP * self._rates(orders))
        halves = np.exp(-np.outer(np.diff(self._spread), orders**2) / 4)
        found = np.empty((LENGTH, len(kept), len(kept)), dtype=complex)
        for lag, half in enumerate(halves[:, :, None]):
            found[lag] = now[kept]
            now = half * (on @ (half * now))
        return found


def _of_correlation(correlation: np.ndarray) -> np.ndarray:
    """What each frequency has, from the lowest, -1/2 over the step, on: (2 LENGTH, k, k)."""
    both = np.zeros((2 * LENGTH, *correlation.shape[1:]), dtype=complex)
    both[:LENGTH] = correlation * (1 - np.arange(LENGTH) / LENGTH)[:, None, None]  # so that no spectrum is below zero
    both[LENGTH + 1 :] = both[LENGTH - 1 : 0 : -1].conj().transpose(0, 2, 1)
    return np.fft.fftshift(np.fft.fft(both, axis=0), axes=0) / (2 * LENGTH)
