"""Wind and sea conditions of the IEC 61400 series as formulas; plain numbers, no model.

Wind: IEC 61400-1 ed. 4 (2019), clause 6.3. Clauses and equations are quoted by their numbers in ed. 3 (2005), whose
formulas ed. 4 keeps; it adds turbulence class A+, Weibull's distribution for the normal turbulence, whose 90 % quantile
stays as it was, and wind class T of tropical cyclones. Speeds [m/s] are 10 minute means at hub height,
heights and the rotor diameter D in m, angles in rad. Offshore, IEC 61400-3-1 (2019), and 61400-3-2 for floating
turbines, take them over with a shear exponent of 0.14 in place of 0.2.

Sea: IEC 61400-3-1 (2019), clause 6.3.3; the two factors of wave heights follow from Rayleigh's distribution of them.
"""

from __future__ import annotations

import math

from fowtlib.language.errors import ParameterError

REFERENCE_SPEED = {"I": 50.0, "II": 42.5, "III": 37.5}
"""V_ref [m/s] by wind class: extreme 10 minute mean with a return period of 50 years, 6.2."""

REFERENCE_INTENSITY = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}
"""I_ref by turbulence class: turbulence intensity at 15 m/s, its mean in ed. 3, its 70 % quantile in ed. 4, 6.2."""

TURBULENCE_CLASSES = tuple(REFERENCE_INTENSITY)
WIND_CLASSES = tuple(REFERENCE_SPEED)

OFFSHORE_SHEAR = 0.14  # exponent of the normal wind profile, IEC 61400-3-1; on land 0.2, 61400-1, 6.3.1.2
EXTREME_SHEAR = 0.11  # of the extreme wind speed model, 6.3.2.1
YEARLY = 0.8  # speed with a return period of 1 year over that of 50 years, 6.3.2.1
GUST_FACTOR = 1.4  # 3 s mean over 10 minute mean of the extreme wind speed, 6.3.2.1
EXTREME_INTENSITY = 0.11  # sigma_1 over V_hub of the turbulent extreme wind speed model, 6.3.2.1
COHERENT_GUST = 15.0  # V_cg [m/s] of the extreme coherent gust, 6.3.2.5
DURATIONS = {"eog": 10.5, "edc": 6.0, "ecd": 10.0, "ews": 12.0}
"""T [s] of the transient conditions."""

RETURN_PERIODS = (50, 1)
"""Years."""

ONE_HOUR = 1.09  # Hs with which one hour has the highest wave of 3 hours: sqrt(ln(1000) / ln(1000 / 3))
HIGHEST_WAVE = 1.86  # height of the highest of the 1000 waves of 3 hours over Hs: sqrt(ln(1000) / 2)
PERIOD_FACTORS = (11.1, 14.3)  # period of a design wave over sqrt(Hs / g)


def average_speed(reference_speed: float) -> float:
    """Annual mean V_ave [m/s] of a wind class: 0.2 V_ref, 6.3.1.1."""
    return 0.2 * reference_speed


def normal_turbulence(mean_speed: float, turbulence_class: str = "B") -> float:
    """Standard deviation sigma_1 [m/s] of the longitudinal speed, normal turbulence model: I_ref (0.75 V + 5.6 m/s).

    The 90 % quantile for the mean speed V [m/s] at hub height, (11). I_ref is 0.18, 0.16, 0.14, 0.12 for the classes A+
    (since ed. 4), A, B, C.
    """
    return _intensity(turbulence_class) * (0.75 * mean_speed + 5.6)


def turbulence_distribution(mean_speed: float, turbulence_class: str = "B") -> tuple[float, float]:
    """Scale C [m/s] and shape k of Weibull's distribution of sigma_1 at a mean speed V [m/s], ed. 4, 6.3.2.3.

    C = I_ref (0.75 V + 3.3 m/s), k = 0.27 V + 1.4 with V in m/s.
    """
    return _intensity(turbulence_class) * (0.75 * mean_speed + 3.3), 0.27 * mean_speed + 1.4


def turbulence_quantile(mean_speed: float, turbulence_class: str, quantile: float) -> float:
    """Sigma_1 [m/s] that is not exceeded in this share of all 10 minutes of a mean speed [m/s], by ed. 4."""
    if not 0 < quantile < 1:
        raise ParameterError(f"a quantile of the turbulence lies between 0 and 1, and {quantile:g} does not.")
    scale, shape = turbulence_distribution(mean_speed, turbulence_class)
    return scale * (-math.log1p(-quantile)) ** (1 / shape)


def extreme_turbulence(mean_speed: float, turbulence_class: str = "B", reference_speed: float = 50.0) -> float:
    """Sigma_1 [m/s] of the extreme turbulence model: c I_ref (0.072 (V_ave/c + 3) (V/c - 4) + 10), c = 2 m/s.

    6.3.2.3; V_ave belongs to V_ref.
    """
    c, average = 2.0, average_speed(reference_speed)
    return c * _intensity(turbulence_class) * (0.072 * (average / c + 3) * (mean_speed / c - 4) + 10)


def turbulence_scale(height: float) -> float:
    """Scale parameter Lambda_1 [m] at hub height: 0.7 z up to 60 m, 42 m above, 6.3."""
    return 0.7 * min(height, 60.0)


def extreme_speed(reference_speed: float = 50.0, return_period: int = 50, turbulent: bool = False) -> float:
    """Speed [m/s] at hub height of the extreme wind speed model, with a return period of 50 years or of 1 year.

    Turbulent, the 10 minute mean V_50 = V_ref and V_1 = 0.8 V_50; steady, the 3 s gust V_e50 = 1.4 V_ref and
    V_e1 = 0.8 V_e50. Over the height it goes with (z/z_hub)^0.11. 6.3.2.1.
    """
    if return_period not in RETURN_PERIODS:
        raise ParameterError(f"there is no extreme wind of {return_period:g} years; take 50 or 1.")
    return reference_speed * (1.0 if turbulent else GUST_FACTOR) * (1.0 if return_period == 50 else YEARLY)


def operating_gust(
    mean_speed: float,
    turbulence_class: str = "B",
    rotor_diameter: float = 126.0,
    height: float = 90.0,
    reference_speed: float = 50.0,
) -> float:
    """Gust magnitude V_gust [m/s] of the extreme operating gust, (17).

    The smaller of 1.35 (V_e1 - V) and 3.3 sigma_1 / (1 + 0.1 D / Lambda_1), with V_e1 = 0.8 * 1.4 V_ref at hub height;
    V_ref [m/s] is 50, 42.5, 37.5 for wind classes I, II, III.
    """
    yearly = extreme_speed(reference_speed, 1)
    sigma = normal_turbulence(mean_speed, turbulence_class)
    gust = min(1.35 * (yearly - mean_speed), 3.3 * sigma / _spread(rotor_diameter, height))
    return max(gust, 0.0)


SECOND_EDITION = {"A": (0.18, 2.0), "B": (0.16, 3.0)}
"""I_15 and a of the turbulence categories of ed. 2: sigma_1 = I_15 (15 m/s + a V)/(a + 1)."""

SECOND_EDITION_GUSTS = {50: (6.4, 14.0), 1: (4.8, 10.5)}
"""beta and T [s] of the gust of ed. 2, by its return period in years."""


def second_edition_gust(
    mean_speed: float, turbulence_class: str = "A", rotor_diameter: float = 126.0, height: float = 90.0, years: int = 50
) -> float:
    """Gust magnitude V_gust [m/s] of the extreme operating gust of IEC 61400-1 ed. 2 (1999), 6.3.2.2.

    beta sigma_1/(1 + 0.1 D/Lambda_1), beta = 6.4 for 50 years and 4.8 for one, Lambda_1 = 0.7 z up to 21 m. There are
    categories A and B of turbulence, and no limit by the extreme wind.
    """
    if turbulence_class not in SECOND_EDITION or years not in SECOND_EDITION_GUSTS:
        raise ParameterError(f"the gust of edition 2 is of turbulence class A or B and of 50 years or 1, not of "
                             f"'{turbulence_class}' and {years}.")  # fmt: skip
    intensity, slope = SECOND_EDITION[turbulence_class]
    sigma = intensity * (15.0 + slope * mean_speed) / (slope + 1.0)
    return SECOND_EDITION_GUSTS[years][0] * sigma / (1 + 0.1 * rotor_diameter / min(0.7 * height, 21.0))


def direction_change(
    mean_speed: float, turbulence_class: str = "B", rotor_diameter: float = 126.0, height: float = 90.0
) -> float:
    """Magnitude theta_e [rad] of the extreme direction change: 4 atan(sigma_1 / (V (1 + 0.1 D / Lambda_1))).

    6.3.2.4; not above 180 deg.
    """
    if not mean_speed > 0:
        raise ParameterError(f"a change of direction needs a mean speed above zero, not {mean_speed:g} m/s.")
    sigma = normal_turbulence(mean_speed, turbulence_class)
    return min(4 * math.atan(sigma / (mean_speed * _spread(rotor_diameter, height))), math.pi)


def coherent_direction(mean_speed: float) -> float:
    """Direction change theta_cg [rad] of the extreme coherent gust: 180 deg below 4 m/s, 720 deg m/s / V.

    6.3.2.5.
    """
    return math.pi if mean_speed < 4 else math.radians(720) / mean_speed


def extreme_shear(
    mean_speed: float, turbulence_class: str = "B", rotor_diameter: float = 126.0, height: float = 90.0
) -> float:
    """Gradient [1/s] of the extreme wind shear: (2.5 m/s + 0.2 beta sigma_1 (D/Lambda_1)^(1/4)) / D, beta = 6.4.

    The speed changes by it times (1 - cos(2 pi t/T)) and the distance from the hub, (26) and (27). The 0.2 is a number
    of the formula, not the shear exponent.
    """
    if not rotor_diameter > 0:
        raise ParameterError(f"the extreme wind shear needs a rotor diameter above zero, not {rotor_diameter:g} m.")
    sigma = normal_turbulence(mean_speed, turbulence_class)
    change = 2.5 + 0.2 * 6.4 * sigma * (rotor_diameter / turbulence_scale(height)) ** 0.25
    return change / rotor_diameter


def design_wave_period(significant_wave_height: float, part: float = 0.5, gravity: float = 9.80665) -> float:
    """Period T [s] of a design wave in a sea of Hs [m]: 11.1 sqrt(Hs/g) for part = 0, to 14.3 sqrt(Hs/g) for part = 1.

    IEC 61400-3-1 gives the range for single extreme waves in deep water.
    """
    low, high = PERIOD_FACTORS
    return (low + (high - low) * part) * math.sqrt(significant_wave_height / gravity)


def _intensity(turbulence_class: str) -> float:
    if turbulence_class not in REFERENCE_INTENSITY:
        allowed = ", ".join(TURBULENCE_CLASSES)
        raise ParameterError(f"turbulence class '{turbulence_class}' is not one of {allowed}.")
    return REFERENCE_INTENSITY[turbulence_class]


def _spread(rotor_diameter: float, height: float) -> float:
    """1 + 0.1 D / Lambda_1: what a rotor feels of a gust is less the larger it is."""
    return 1 + 0.1 * rotor_diameter / turbulence_scale(height)
