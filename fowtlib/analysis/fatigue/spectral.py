"""Cycles of a Gaussian load from its spectrum: narrow band, Dirlik, Tovo and Benasciutti.

All three say that the ranges of the cycles follow a sum of Weibull laws (exponential for shape 1, Rayleigh for 2), and
how many cycles come in a second. Then the mean of R^m, and that of the ranges between two bounds, are gamma functions
and incomplete ones: damage is in closed form for one slope and for two.

Moments m_n of a spectrum contain f^n: m_4 is decided by its end at high frequencies, where a measured one holds noise.
Sources: Dirlik (1985), as in Halfpenny (1999); Benasciutti and Tovo, Int. Journal of Fatigue 27 (2005), 867-877.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from fowtlib.analysis.fatigue.curves import in_si
from fowtlib.analysis.fatigue.cycles import Cycles, rainflow_cycles
from fowtlib.analysis.fatigue.loads import check_exponents, damage_equivalent_load
from fowtlib.analysis.spectra import realisation
from fowtlib.language.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from fowtlib.analysis.fatigue.curves import SNCurve
    from fowtlib.analysis.spectra import Spectrum

# Below this distance of the irregularity factor from 1 a spectrum is one line. All formulas agree there, and those of a
# broad one divide differences of the order of its square.
NARROW = 1e-6


@dataclass(frozen=True)
class RangeDistribution:
    """Cycles of a stationary load: ``rate`` of them in a second, with ranges after a sum of Weibull laws.

    A law has a weight, a scale in the unit of the load, and a shape: P(R > r) = exp(-(r / scale)^shape). What the
    weights lack to 1 are cycles without a range.
    """

    rate: float
    weights: np.ndarray
    scales: np.ndarray
    shapes: np.ndarray
    unit: str = "1"
    name: str = ""

    def density(self, ranges: ArrayLike) -> np.ndarray:
        """Probability density of the ranges, per unit of the load."""
        relative = np.asarray(ranges, dtype=float)[..., None] / self.scales
        law = self.shapes / self.scales * relative ** (self.shapes - 1) * np.exp(-(relative**self.shapes))
        return law @ self.weights

    def moment(self, exponent: float, low: float = 0.0, high: float = math.inf) -> float:
        """Mean of R^m, counting ranges between two bounds alone."""
        from scipy.special import gammainc, gammaincc, gammaln

        order = 1.0 + exponent / self.shapes
        below, above = (bound / self.scales for bound in (low, high))
        # of two small rests the difference is exact, and of two small shares: take those on the side of the bounds
        rests = gammaincc(order, below**self.shapes) - gammaincc(order, above**self.shapes)
        shares = gammainc(order, above**self.shapes) - gammainc(order, below**self.shapes)
        part = np.where(below**self.shapes > order, rests, shares)
        return float(np.sum(self.weights * np.exp(exponent * np.log(self.scales) + gammaln(order)) * part))

    @overload
    def equivalent_load(self, exponent: float, frequency: float = 1.0) -> float: ...
    @overload
    def equivalent_load(self, exponent: Sequence[float] | np.ndarray, frequency: float = 1.0) -> np.ndarray: ...
    def equivalent_load(
        self, exponent: float | Sequence[float] | np.ndarray, frequency: float = 1.0
    ) -> float | np.ndarray:
        """Damage-equivalent load as a range, in the unit of the load: (rate / frequency x mean of R^m)^(1/m)."""
        slopes = check_exponents(exponent)
        if not (math.isfinite(frequency) and frequency > 0):
            raise ModelError(f"the frequency of the equivalent cycles is above 0 Hz, not {frequency:g} Hz.")
        loads = [(self.rate / frequency * self.moment(m)) ** (1.0 / m) if self.rate else 0.0 for m in slopes.ravel()]
        return np.reshape(loads, slopes.shape) if slopes.ndim else float(loads[0])

    def damage(self, curve: SNCurve, duration: float) -> float:
        """Miner's sum of ``duration`` s of this stress."""
        if not (math.isfinite(duration) and duration >= 0):
            raise ModelError(f"a duration is 0 s or longer, not {duration:g} s.")
        if not self.rate:
            return 0.0
        size = in_si(self.unit, "Pa", self.name or "the spectrum", "an S-N curve takes stresses")
        parts = (each * size**m * self.moment(m, low / size, high / size) for m, each, low, high in curve.lines())
        return self.rate * duration * sum(parts)


def narrow_band(spectrum: Spectrum) -> RangeDistribution:
    """Each up-crossing of the mean is one cycle with a Rayleigh range: exact for a narrow spectrum, else too much."""
    moments = _moments(spectrum)
    if moments is None:
        return _still(spectrum)
    return _made(spectrum, math.sqrt(moments[2] / moments[0]), moments[0], [(1.0, 1.0, 2.0)])


def dirlik(spectrum: Spectrum) -> RangeDistribution:
    """An exponential and two Rayleigh laws that Dirlik fitted to simulated Gaussian loads."""
    moments = _moments(spectrum)
    if moments is None:
        return _still(spectrum)
    m0, m1, m2, m4 = moments
    factor = m2 / math.sqrt(m0 * m4)  # irregularity: up-crossings over maxima
    if 1.0 - factor < NARROW:
        return narrow_band(spectrum)
    x = m1 / m0 * math.sqrt(m2 / m4)
    first = 2 * (x - factor**2) / (1 + factor**2)
    r = (factor - x - first**2) / (1 - factor - first + first**2)
    second = (1 - factor - first + first**2) / (1 - r)
    third = 1 - first - second
    q = 1.25 * (factor - third - second * r) / first
    laws = [(first, q / math.sqrt(2), 1.0), (second, abs(r), 2.0), (third, 1.0, 2.0)]
    return _made(spectrum, math.sqrt(m4 / m2), m0, laws)


def tovo_benasciutti(spectrum: Spectrum) -> RangeDistribution:
    """Between the counting of level crossings and that of ranges, which bound the damage of rainflow counting."""
    moments = _moments(spectrum)
    if moments is None:
        return _still(spectrum)
    m0, m1, m2, m4 = moments
    one, two = m1 / math.sqrt(m0 * m2), m2 / math.sqrt(m0 * m4)
    if 1.0 - two < NARROW:
        return narrow_band(spectrum)
    share = (one - two) / (two - 1) ** 2 * (1.112 * (1 + one * two - (one + two)) * math.exp(2.11 * two) + (one - two))
    return _made(spectrum, math.sqrt(m4 / m2), m0, [(share * two, 1.0, 2.0), (1 - share, two, 2.0)])


def rainflow_of(spectrum: Spectrum, *, seeds: int = 6, duration: float = 3600.0, step: float = 0.1) -> list[Cycles]:
    """Cycles of series of the spectrum by inverse FFT, with the random phases of so many seeds, by rainflow counting.

    duration, step: of each series, s.
    """
    if int(seeds) != seeds or seeds < 1:
        raise ModelError(f"series are made of 1, 2, 3 ... seeds, not of {seeds:g}.")
    return [rainflow_cycles(realisation(spectrum, duration, step, seed=seed)) for seed in range(1, int(seeds) + 1)]


def equivalent_load_of(
    spectrum: Spectrum, exponent: float, frequency: float = 1.0, method: str = "dirlik", **options: Any
) -> float:
    """Damage-equivalent range of a Gaussian load by one of the METHODS; options of rainflow_of for "rainflow"."""
    if _method(method, options) is not None:
        return float(METHODS[method](spectrum).equivalent_load(exponent, frequency))
    if not spectrum.std > 0:
        return 0.0
    loads = [damage_equivalent_load(c, exponent, frequency=frequency) for c in rainflow_of(spectrum, **options)]
    return float(np.mean(np.asarray(loads) ** exponent) ** (1.0 / exponent))


def damage_of(spectrum: Spectrum, curve: SNCurve, duration: float, method: str = "dirlik", **options: Any) -> float:
    """Miner's sum of ``duration`` s of a Gaussian stress by one of the METHODS; options of rainflow_of."""
    if _method(method, options) is not None:
        return METHODS[method](spectrum).damage(curve, duration)
    if not spectrum.std > 0:
        return 0.0
    return float(np.mean([curve.damage(cycles) / cycles.duration for cycles in rainflow_of(spectrum, **options)])
                 * duration)  # fmt: skip


METHODS = {"dirlik": dirlik, "tovo_benasciutti": tovo_benasciutti, "narrow_band": narrow_band}


def _method(method: str, options: Mapping[str, Any]) -> Any:
    """The law of ranges of a method; None for counting."""
    if method != "rainflow" and method not in METHODS:
        raise ModelError(f"there is no method '{method}'{did_you_mean(method, [*METHODS, 'rainflow'])}")
    if method != "rainflow" and options:
        raise ModelError(f"{', '.join(options)}: only the method 'rainflow' takes them, not '{method}'.")
    return METHODS.get(method)


Law = tuple[float, float, float]


def _made(spectrum: Spectrum, rate: float, variance: float, laws: Sequence[Law]) -> RangeDistribution:
    """Laws as (weight, scale over that of the narrow band, shape); its scale is 2 sqrt(2) standard deviations."""
    weights, scales, shapes = np.array(laws, dtype=float).T
    size = 2.0 * math.sqrt(2.0 * variance)
    return RangeDistribution(rate, weights, scales * size, shapes, spectrum.unit, spectrum.name)


def _moments(spectrum: Spectrum) -> tuple[float, float, float, float] | None:
    """m_0, m_1, m_2 and m_4 with frequencies in Hz; None for a load that does not change."""
    if not (np.all(np.isfinite(spectrum.density)) and np.all(spectrum.density >= 0)):
        raise ModelError(f"{spectrum.name or 'the spectrum'}: densities are finite numbers of 0 or more.")
    m0, m1, m2, m4 = (spectrum.moment(order) for order in (0, 1, 2, 4))
    return (m0, m1, m2, m4) if m2 > 0 else None


def _still(spectrum: Spectrum) -> RangeDistribution:
    return RangeDistribution(0.0, np.zeros(1), np.ones(1), np.full(1, 2.0), spectrum.unit, spectrum.name)
