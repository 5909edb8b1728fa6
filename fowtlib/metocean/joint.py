"""Joint distributions of wind speed, significant wave height and peak period: conditional laws, one inside the other.

    f(u, h, t) = f(u) f(h | u) f(t | u, h)

with Weibull wind, Weibull wave height given the wind, and lognormal peak period given both. Two references have this
form: K. Johannessen, T. S. Meling, S. Haver, Joint distribution for wind and waves in the northern North Sea, Int. J.
Offshore and Polar Eng. 12 (2002), and L. Li, Z. Gao, T. Moan, Joint distribution of environmental condition at five
European offshore sites for design of combined wind and wave energy devices, J. Offshore Mech. Arct. Eng. 137 (2015),
OMAE2013-10156.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.laws import Law, LogNormal, Mixture, Weibull
from fowtlib.metocean.states import States

Three = tuple[float, float, float]
VARIABLES = {"wind_speed": "m/s", "wave_height": "m", "peak_period": "s"}
BEYOND = 1e-6  # probability of states that the form of the period may have no value for
_NODES = np.arange(-8.0, 8.01, 0.1)  # standard normal variables; the rule of trapezoids is exact to rounding there


@dataclass(frozen=True)
class ConditionalModel:
    """Joint distribution of wind speed u [m/s], significant wave height h [m] and peak period t [s].

    u: Weibull with wind_shape and wind_scale [m/s], the mean over `averaging` [s] at reference_height [m]. h given u:
    Weibull, shape a1 + a2 u^a3 (height_shape), scale b1 + b2 u^b3 [m] (height_scale). t given u and h: lognormal, mean
    (e1 + e2 h^e3) (1 + theta ((u - v) / v)^gamma) with the wind that goes with the height v = f1 + f2 h^f3, and
    coefficient of variation k1 + k2 exp(k3 h): period_mean e, period_wind f, period_slope theta, period_exponent gamma
    (a whole number, since u - v has both signs), period_variation k.

    height [m]: where the wind speeds are meant that go in and come out, with the power law of shear_exponent; None is
    the reference height. name, title, source: words for people.
    """

    wind_shape: float
    wind_scale: float
    height_shape: Three
    height_scale: Three
    period_mean: Three
    period_wind: Three
    period_slope: float
    period_variation: Three
    period_exponent: float = 1.0
    reference_height: float = 10.0
    averaging: float = 3600.0
    shear_exponent: float | None = None
    height: float | None = None
    water_depth: float | None = None
    name: str = ""
    title: str = ""
    source: str = ""

    def __post_init__(self):
        for name in ("wind_shape", "wind_scale", "reference_height", "averaging", "height"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ParameterError(f"{name} must be a positive number, not {value}.", where=self.name)
        if self.period_exponent != round(self.period_exponent) or self.period_exponent < 1:
            raise ParameterError(
                f"period_exponent must be a whole number, not {self.period_exponent:g}: the wind may be "
                "stronger or weaker than the one that goes with the waves.",
                where=self.name,
            )
        if self.height is not None and self.height != self.reference_height and self.shear_exponent is None:
            raise ParameterError(
                f"wind at {self.height:g} m needs shear_exponent: the distribution is that of the wind "
                f"at {self.reference_height:g} m.",
                where=self.name,
            )

    def at(self, height: float, shear_exponent: float | None = None) -> ConditionalModel:
        """The same distribution for wind speeds at another height [m], by the power law."""
        exponent = self.shear_exponent if shear_exponent is None else shear_exponent
        return replace(self, height=height, shear_exponent=exponent)

    @property
    def wind_factor(self) -> float:
        """Wind speed at `height` over the one at the reference height."""
        if self.height is None or self.height == self.reference_height:
            return 1.0
        return (self.height / self.reference_height) ** (self.shear_exponent or 0.0)

    # -- the laws -----------------------------------------------------------------------------------------------------

    @property
    def wind_speed(self) -> Weibull:
        """Law of the wind speed at `height`."""
        return Weibull(self.wind_shape, self.wind_scale * self.wind_factor)

    def wave_height(self, wind_speed: Any) -> Weibull:
        """Law of the significant wave height given the wind speed, (n,) or a number."""
        u = self._wind(wind_speed)
        (a1, a2, a3), (b1, b2, b3) = self.height_shape, self.height_scale
        shape, scale = a1 + a2 * u**a3, b1 + b2 * u**b3
        self._refuse(
            ~((shape > 0) & (scale > 0)), "the shape and scale of the wave height are not positive", u=wind_speed
        )
        return Weibull(shape, scale)

    def peak_period(self, wind_speed: Any, wave_height: Any) -> LogNormal:
        """Law of the peak period given wind speed and significant wave height, which broadcast.

        ParameterError where the form has no mean or no deviation above zero: far from what it was fitted to.
        """
        mean, variation = self._period(self._wind(wind_speed), self._positive(wave_height, "wave height", "m"))
        low = "the mean peak period is not positive: so much wind over so low waves is beyond the form"
        high = "the deviation of the peak period is not positive: so high waves are beyond the form"
        self._refuse(~(mean > 0), low, u=wind_speed, h=wave_height)
        self._refuse(~(variation > 0), high, u=wind_speed, h=wave_height)
        return LogNormal.of(mean, variation)

    def reaches(self, wind_speed: Any, wave_height: Any) -> np.ndarray:
        """Whether there is a law of the peak period."""
        mean, variation = self._period(self._wind(wind_speed), self._positive(wave_height, "wave height", "m"))
        return (mean > 0) & (variation > 0)

    def _period(self, u: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        (e1, e2, e3), (f1, f2, f3), (k1, k2, k3) = self.period_mean, self.period_wind, self.period_variation
        usual = f1 + f2 * h**f3
        mean = (e1 + e2 * h**e3) * (1 + self.period_slope * ((u - usual) / usual) ** round(self.period_exponent))
        return mean, k1 + k2 * np.exp(k3 * h) + 0 * mean

    # -- all three ----------------------------------------------------------------------------------------------------

    def pdf(self, wind_speed: Any, wave_height: Any, peak_period: Any) -> np.ndarray:
        """Joint density [1/(m/s m s)]; the arguments broadcast."""
        t = self._positive(peak_period, "peak period", "s")
        seas = self.wave_height(wind_speed).pdf(wave_height) * self.peak_period(wind_speed, wave_height).pdf(t)
        return self.wind_speed.pdf(wind_speed) * seas

    def conditional(self, wind_speed: Any, value: str = "median") -> tuple[Any, Any]:
        """Significant wave height and peak period that go with a wind speed: for the conditions of a case.

        value: "median" is the median of each law, the period given that height; "mean" the mean, likewise. The mean
        period of all seas of a wind speed is somewhat shorter (2 % at 13 m/s), for low seas are shorter.
        """
        if value not in ("median", "mean"):
            raise ParameterError(f"conditional values are 'median' or 'mean', not '{value}'.")
        height = getattr(self.wave_height(wind_speed), value)()
        period = getattr(self.peak_period(wind_speed, height), value)()
        return (float(height), float(period)) if np.ndim(height) == 0 else (height, period)

    def marginal(self, variable: str) -> Law | Mixture:
        """Law of one variable alone: "wind_speed", "wave_height" or "peak_period"."""
        if variable == "wind_speed":
            return self.wind_speed
        if variable not in VARIABLES:
            raise ParameterError(f"there is no variable '{variable}'; there are {', '.join(VARIABLES)}.")
        weights = np.exp(-(_NODES**2) / 2)
        weights /= weights.sum()
        wind = self.wind_speed.from_normal(_NODES)
        if variable == "wave_height":
            return Mixture(weights, self.wave_height(wind))
        nodes, some = _NODES[::2], weights[::2] / weights[::2].sum()
        both = np.outer(some, some).ravel()
        u = np.repeat(wind[::2], nodes.size)
        h = self.wave_height(u).from_normal(np.tile(nodes, nodes.size))
        inside = (both > 1e-16) & self.reaches(u, h)
        lost = 1 - both[inside].sum()
        if lost > BEYOND:
            raise ParameterError(
                f"the form of the peak period has no value for {lost:.2g} of all states.", where=self.name
            )
        return Mixture(both[inside] / both[inside].sum(), self.peak_period(u[inside], h[inside]))

    def to_normal(self, wind_speed: Any, wave_height: Any, peak_period: Any) -> np.ndarray:
        """Rosenblatt transformation: states as independent standard normal variables, (n, 3).

        F(u) = Phi(z1), F(h | u) = Phi(z2), F(t | u, h) = Phi(z3).
        """
        u = self._positive(wind_speed, "wind speed", "m/s")
        h, t = self._positive(wave_height, "wave height", "m"), self._positive(peak_period, "peak period", "s")
        z = (self.wind_speed.to_normal(u), self.wave_height(u).to_normal(h), self.peak_period(u, h).to_normal(t))
        return np.stack(np.broadcast_arrays(*z), axis=-1)

    def from_normal(self, z: Any) -> States:
        """Inverse Rosenblatt transformation: standard normal variables (n, 3) as states."""
        first, second, third = np.moveaxis(np.atleast_2d(np.asarray(z, dtype=float)), -1, 0)
        u = self.wind_speed.from_normal(first)
        h = self.wave_height(u).from_normal(second)
        return States(u, h, self.peak_period(u, h).from_normal(third))

    def sample(self, count: int, seed: int) -> States:
        """So many independent states, each of probability 1 / count; the same for the same seed."""
        if count < 1:
            raise ParameterError(f"a sample has one state or more, not {count}.")
        states = self.from_normal(np.random.default_rng(seed).standard_normal((count, 3)))
        return replace(states, probability=np.full(count, 1 / count))

    # -- refusals -----------------------------------------------------------------------------------------------------

    def _wind(self, wind_speed: Any) -> np.ndarray:
        """Wind speed at the reference height."""
        u = np.asarray(wind_speed, dtype=float)
        self._refuse(~(np.isfinite(u) & (u >= 0)), "a wind speed is a finite number and not negative", u=u)
        return u / self.wind_factor

    def _positive(self, values: Any, what: str, unit: str) -> np.ndarray:
        array = np.asarray(values, dtype=float)
        bad = ~(np.isfinite(array) & (array > 0))
        if bad.any():
            raise ParameterError(
                f"a {what} of {np.atleast_1d(array)[np.atleast_1d(bad)][0]:g} {unit}: it must be positive and finite.",
                where=self.name,
            )
        return array

    def _refuse(self, bad: Any, why: str, u: Any, h: Any = None) -> None:
        if not np.any(bad):
            return
        first = tuple(np.argwhere(np.atleast_1d(bad))[0])
        shape = np.shape(np.atleast_1d(bad))
        words = [
            f"{np.broadcast_to(np.asarray(v, dtype=float), shape)[first]:g} {unit}"
            for v, unit in ((u, "m/s of wind"), (h, "m of waves"))
            if v is not None
        ]
        raise ParameterError(f"at {' and '.join(words)} {why}.", where=self.name)
