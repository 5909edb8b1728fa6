"""Normal and extreme turbulence, and the normal profile, of IEC 61400-1."""

from __future__ import annotations

from fowtlib.components.environment import iec
from fowtlib.components.environment.wind.kaimal import KaimalWind
from fowtlib.components.environment.wind.steady import SteadyWind
from fowtlib.language import Number, Scalar, param


class NormalProfile(SteadyWind, kind="nwp"):
    """Steady wind of the normal wind profile model, NWP: V (z/z_hub)^0.14, the exponent of IEC 61400-3-1."""

    shear_exponent: Scalar = param(default=iec.OFFSHORE_SHEAR, doc="exponent of the power law; on land 0.2")


class NormalTurbulence(KaimalWind, kind="ntm"):
    """Normal turbulence model, NTM: Kaimal turbulence at the stations of sigma_1 = I_ref (0.75 V + 5.6 m/s).

    That is the 90 % quantile of the turbulence class; `quantile` takes another one from the Weibull distribution of ed.
    4. The mean is the normal profile. Rotors of blade elements, which cut through eddies smaller than themselves, need
    a field of the same class: the kinds "turbulence" and "field".
    """

    void = ("turbulence_intensity",)

    shear_exponent: Scalar = param(default=iec.OFFSHORE_SHEAR, doc="exponent of the power law; on land 0.2")
    quantile: Number = param(default=None, min=0, max=1, bound=True, doc="of sigma_1; without a value the 90 % formula")

    def standard_deviation(self) -> float:
        """Sigma [m/s] of the speed at a station, of the whole spectrum."""
        speed, name = self.given_speed(), self.turbulence_class
        if self.quantile is None:
            return iec.normal_turbulence(speed, name)
        return iec.turbulence_quantile(speed, name, self.quantile)


class ExtremeTurbulence(NormalTurbulence, kind="etm"):
    """Extreme turbulence model, ETM: as the normal one, with sigma_1 by wind class and turbulence class.

    sigma_1 = c I_ref (0.072 (V_ave/c + 3) (V/c - 4) + 10), c = 2 m/s, V_ave = 0.2 V_ref; see iec.extreme_turbulence.
    """

    void = ("turbulence_intensity", "quantile")

    wind_class: str = param(default="I", choices=iec.WIND_CLASSES, bound=True, doc="IEC wind class, of V_ref")
    reference_speed: Number = param(
        default=None, unit="m/s", min=0, bound=True, instead_of=("wind_class",), doc="V_ref; else by the wind class"
    )

    def standard_deviation(self) -> float:
        """Sigma [m/s] of the speed at a station, of the whole spectrum."""
        reference = reference_speed(self.wind_class, self.reference_speed)
        return iec.extreme_turbulence(self.given_speed(), self.turbulence_class, reference)


def reference_speed(wind_class: str, given: float | None) -> float:
    """V_ref [m/s] that is given, or that of a wind class."""
    return iec.REFERENCE_SPEED[wind_class] if given is None else float(given)
