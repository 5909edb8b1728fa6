"""The spectrum of what goes round with a rotor whose speed is random.

exp(i n psi) with psi = Omega t is a line. With a random part of the speed, Gaussian with the one-sided density G
[(rad/s)^2/Hz], the angle has changed after a time tau by Omega tau and a random part of the variance

    D(tau) = integral of G(f) 2 (1 - cos 2 pi f tau) / (2 pi f)^2 df,

and the correlation of exp(i n psi) is exp(i n Omega tau - n^2 D(tau) / 2), exactly. Its transform is the line: where
the speed changes slowly it has the distribution of n times the speed, where it changes quickly and little, a line stays
with its sidebands (A. Papoulis, Probability, Random Variables, and Stochastic Processes, 3rd ed. 1991, section 11-3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtlib.analysis.spectra import mean_square_below

STEP, COUNT = 0.25, 2**16  # of tau [s]: lines 4 Hz wide, parts of them 6e-5 Hz
LEAST = 1e-7  # of a line: shares of it in a part of the axis that count


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts of a line: where (k,), the number of the frequency that each belongs to; omega (k,) [rad/s]; share (k,)."""

    where: np.ndarray
    omega: np.ndarray
    share: np.ndarray


class RandomSpeed:
    """A rotor speed [rad/s] with a random part of the density G (q,) [(rad/s)^2/Hz] at frequencies (q,) [Hz]."""

    def __init__(self, speed: float, frequency: np.ndarray, density: np.ndarray):
        self.speed, self.frequency = speed, frequency
        below = mean_square_below(frequency, density)
        own = np.fft.rfftfreq(COUNT, STEP)
        squares = np.diff(np.interp(np.append(own, own[-1] + own[1]) - own[1] / 2, frequency, below))
        squares[0] = 0.0  # what is slower belongs to the mean
        phases = np.divide(2 * squares, (2 * np.pi * own) ** 2, out=np.zeros_like(own), where=own > 0)
        self.spread = np.maximum(phases.sum() - COUNT * np.fft.irfft(phases / 2, COUNT), 0.0)  # D at tau, then at -tau

    def line(self, n: int) -> Parts:
        """The line of exp(i n psi), by the parts of the axis that belong to each frequency.

        What lies below the lowest frequency and above the highest is left out.
        """
        shares = np.maximum(np.fft.fft(np.exp(-(n**2) * self.spread / 2)).real, 0.0)
        omega = n * self.speed + 2 * np.pi * np.fft.fftfreq(COUNT, STEP)
        shares, found = shares / shares.sum(), []
        for sign in (1.0, -1.0):
            at = sign * omega / (2 * np.pi)
            inside = (at >= self.frequency[0]) & (at <= self.frequency[-1]) & (shares > 0)
            middles = (self.frequency[1:] + self.frequency[:-1]) / 2
            where, share = np.searchsorted(middles, at[inside]), shares[inside]
            total = np.bincount(where, share, len(self.frequency))
            moment = np.bincount(where, share * omega[inside], len(self.frequency))
            kept = np.flatnonzero(total > LEAST)
            found.append((kept, moment[kept] / total[kept], total[kept]))
        return Parts(*(np.concatenate(column) for column in zip(*found, strict=True)))
