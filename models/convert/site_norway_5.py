"""The site of load cases models/data/sites/norway_5.yaml, from a joint distribution of wind and waves.

Run: python models/convert/site_norway_5.py > models/data/sites/norway_5.yaml

Li, Gao and Moan (OMAE2013-10156), site 14, Norway 5: U (1 h mean at 10 m) is Weibull, Hs given U is Weibull, Tp given U
and Hs is lognormal. Normal sea: mean of Hs and median of Tp given U. Severe sea: Hs on the 50-year contour by IFORM at
each U, one sea state an hour. Extreme seas: quantiles of the marginal distribution of Hs, with the most likely U. Where
the median of Tp is too short for the height, by the limit of steepness of DNV-RP-C205, the period at that limit stands
in its place. Wind speeds are taken to the hub by a power law.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.stats import norm, weibull_min

SHAPE, SCALE, SHEAR, HUB = 2.029, 9.409, 0.1, 90.0
A, B = (2.136, 0.013, 1.709), (1.816, 0.024, 1.787)
E, F, K = (8.0, 1.938, 0.486), (2.5, 3.001, 0.745), (-0.001, 0.316, -0.145)
SLOPE, EXPONENT = -0.255, 1.0
FACTOR = (HUB / 10.0) ** SHEAR
HOURS = 365.25 * 24

wind = weibull_min(SHAPE, scale=SCALE)


def height(u: float):
    """Distribution of Hs [m] in wind u [m/s] at 10 m."""
    return weibull_min(A[0] + A[1] * u ** A[2], scale=B[0] + B[1] * u ** B[2])


def period(u: float, h: float) -> float:
    """Median of Tp [s]."""
    t, v = E[0] + E[1] * h ** E[2], F[0] + F[1] * h ** F[2]
    mean = t * (1 + SLOPE * ((u - v) / v) ** EXPONENT)
    variation = K[0] + K[1] * math.exp(K[2] * h)
    return max(mean / math.sqrt(1 + variation**2), shortest(h))


def shortest(h: float) -> float:
    """The period [s] with which a sea of h [m] is as steep as DNV-RP-C205, 3.5.4, allows."""
    def over(t: float) -> float:
        return 9.80665 * t**2 / (2 * np.pi) * np.interp(t, [8, 15], [1 / 15, 1 / 25]) - h

    return float(brentq(over, 0.1, 40))


def on_contour(u: float, years: float) -> float:
    """Hs [m] that goes with u on the contour of a return period."""
    beta, z = norm.isf(1 / (years * HOURS)), norm.ppf(wind.cdf(u))
    return float(height(u).ppf(norm.cdf(math.sqrt(max(beta**2 - z**2, 0.0)))))


def extreme(years: float) -> tuple[float, float]:
    """Hs [m] that is exceeded in one of so many years of hours, and the median of Tp [s] with it."""
    def over(h: float) -> float:
        return quad(lambda u: wind.pdf(u) * height(u).sf(h), 0, 60, limit=200)[0] - 1 / (years * HOURS)

    h = round(brentq(over, 3, 40), 2)
    u = max(np.linspace(5, 40, 3501), key=lambda u: wind.pdf(u) * height(u).pdf(h))
    return h, period(u, h)


def two(value: float, key: str) -> str:
    """Two decimals; periods are rounded up, so that no sea becomes steeper."""
    return f"{math.ceil(value * 100) / 100 if key == 'Tp' else value:.2f}"


def main() -> None:
    """Print the file."""
    speeds = np.arange(2.0, 41.0, 2.0)
    at_10 = speeds / FACTOR
    normal = [round(float(height(u).mean()), 2) for u in at_10]
    severe = [round(on_contour(u, 50), 2) for u in at_10]
    rows = {
        "normal_sea": (normal, [period(u, h) for u, h in zip(at_10, normal, strict=True)]),
        "severe_sea": (severe, [period(u, h) for u, h in zip(at_10, severe, strict=True)]),
    }
    lines = [
        "# Made by models/convert/site_norway_5.py; what it takes for what stands there.",
        "fowtlib_site: 1",
        "title: Norway 5 (site 14), northern North Sea",
        "source: >-",
        "  L. Li, Z. Gao, T. Moan, Joint distribution of environmental condition at five European offshore sites for",
        "  design of combined wind and wave energy devices, OMAE2013-10156, site 14; numbers as coded in two public",
        "  repositories that cite it. 1 h means; the wind is taken to the hub with the exponent 0.1. Periods are",
        "  medians, or the shortest that the limit of steepness of DNV-RP-C205 allows, where that is longer.",
        "water_depth: 202 m",
        f"hub_height: {HUB:g} m",
        f"wind: {{weibull: {{scale: {SCALE * FACTOR:.3f} m/s, shape: {SHAPE:g}}}}}",
    ]
    for name, (heights, periods) in rows.items():
        lines += [f"{name}:", f"  wind_speed: [{', '.join(f'{v:g}' for v in speeds)}]"]
        for key, values in (("Hs", heights), ("Tp", periods)):
            lines.append(f"  {key}: [{', '.join(two(v, key) for v in values)}]")
    lines.append("extreme_sea:")
    for years in (1, 50):
        h, t = extreme(years)
        lines.append(f"  {years}: {{Hs: {two(h, 'Hs')} m, Tp: {two(t, 'Tp')} s}}")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
