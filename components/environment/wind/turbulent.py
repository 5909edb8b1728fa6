"""A full field of turbulence that is made when a run starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.components.environment import iec
from fowtlib.components.environment.disc_turbulence import places_density
from fowtlib.components.environment.field_file import COMPONENTS
from fowtlib.components.environment.field_generator import FLUCTUATING, generate_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_spectra import spectra
from fowtlib.components.environment.field_store import made_field
from fowtlib.components.environment.field_wind import open_field
from fowtlib.components.environment.point_turbulence import PointGrid, point_density
from fowtlib.components.environment.turbulence import PlaneCoherence
from fowtlib.components.environment.wind.base import mean_speed_at
from fowtlib.components.environment.wind.field import FieldWind
from fowtlib.components.environment.wind.transient import rotor_diameter
from fowtlib.language import Number, Scalar, param
from fowtlib.language.errors import ParameterError
from fowtlib.language.run_time import RestingPlaces, TurningRings

MARGIN = 0.15  # of the rotor diameter, around the disks: for the motion of the turbine
LEAST_HEIGHT = 1.0  # m of the lowest row


class TurbulentWind(FieldWind, kind="turbulence"):
    """Turbulence u, v, w in space and time by Veers' method, made for the run from its numbers; see field_generator.

    For rotors of blade elements, which feel eddies smaller than themselves. Its plane holds the disks of all rotors at
    the stations with a margin. It repeats itself after `repetition_period`. Sigma_1 is that of the normal or the
    extreme turbulence model of IEC 61400-1, or of an intensity. Nothing of it stays on the disk; `fowt wind-field`
    writes one to keep.
    """

    void = ("file",)
    of_data = False

    shear_exponent: Scalar = param(default=iec.OFFSHORE_SHEAR, doc="exponent of the power law; on land 0.2")
    turbulence_class: str = param(
        default="B", choices=iec.TURBULENCE_CLASSES, bound=True, doc="IEC turbulence class, of sigma_1"
    )
    turbulence_model: str = param(default="ntm", choices=("ntm", "etm"), bound=True, doc="normal or extreme sigma_1")
    wind_class: str = param(default="I", choices=iec.WIND_CLASSES, bound=True, doc="of etm: IEC wind class, of V_ref")
    turbulence_intensity: Number = param(
        default=None, min=0, max=2, bound=True, instead_of=("turbulence_class", "turbulence_model", "wind_class"),
        doc="sigma/V; without a value by the class",
    )  # fmt: skip
    field_spectrum: str = param(default="kaimal", choices=("kaimal", "von_karman"), bound=True, doc="spectra")
    lateral_coherence: str = param(
        default="none", choices=("none", "iec"), bound=True, doc="of v and w: none from point to point, or that of u"
    )
    components: str = param(default="uvw", choices=FLUCTUATING, bound=True, doc="those that fluctuate")
    seed: int = param(default=1, min=0, bound=True, doc="number of the realisation")
    rotor_diameter: Number = param(
        default=None, unit="m", min=0, bound=True, doc="D; without a value that of the largest rotor of the model"
    )
    point_spacing: Number = param(default=10.0, unit="m", min=0.5, bound=True, doc="distance of the points, at most")
    sample_step: Number = param(default=0.05, unit="s", min=1e-3, bound=True, doc="between two planes")
    repetition_period: Number = param(default=720.0, unit="s", min=1, bound=True, doc="period of the realisation")

    def lookup(self) -> FieldLookup:
        """The look-up of the field, which is made where it is not there yet."""
        numbers = self.numbers()
        path = made_field(numbers, lambda path: _make(self, path, numbers))
        return open_field(str(path), self.field_shift, self.interpolation)

    def numbers(self) -> dict[str, Any]:
        """What the field depends on, as generate_field takes it."""
        hubs, reach = self.hubs, (0.5 + MARGIN) * rotor_diameter(self)
        low, high = max(LEAST_HEIGHT, float(hubs[:, 1].min()) - reach), float(hubs[:, 1].max()) + reach
        width, height = 2 * (float(np.abs(hubs[:, 0]).max()) + reach), high - low
        columns, rows = (max(2, math.ceil(size / self.point_spacing - 1e-9) + 1) for size in (width, height))
        return {
            "mean_speed": self.given_speed(), "width": width, "height": height, "columns": columns, "rows": rows,
            "duration": float(self.repetition_period), "time_step": float(self.sample_step), "bottom": low,
            "hub_height": float(self.reference_height), "spectrum": self.field_spectrum, "seed": int(self.seed),
            "turbulence_class": self.turbulence_class, "turbulence_intensity": self.intensity(),
            "shear_exponent": float(self.parameter_value("shear_exponent")),
            "lateral_coherence": self.lateral_coherence, "components": self.components,
        }  # fmt: skip

    def field_density(self, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces], part: int = 0,
                      basis: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
        """By spectrum and coherence of u, v or w, without the limits of a realisation.

        v and w without a coherence are those of the points of the field: between them they are interpolated.
        """
        if COMPONENTS[part] not in self.components:
            size = sum(item.channels for item in places) if basis is None else basis.shape[1]
            return np.zeros((np.size(omega), size, size))
        speed, height = self.given_speed(), float(self.reference_height)
        intensity = self.intensity()
        sigma = iec.normal_turbulence(speed, self.turbulence_class) if intensity is None else intensity * speed

        def spectrum(omega: np.ndarray) -> np.ndarray:
            return spectra(omega / (2 * np.pi), speed, sigma, height, self.field_spectrum)[..., part] / (2 * np.pi)

        if part and self.lateral_coherence == "none":
            return point_density(omega, places, spectrum, self.points(), basis)
        found = places_density(omega, places, spectrum, PlaneCoherence(speed, height))
        return found if basis is None else basis.T @ found @ basis

    def points(self) -> PointGrid:
        """The points of the field in its plane."""
        given = self.numbers()
        dy, dz = (given[size] / (given[count] - 1) for size, count in (("width", "columns"), ("height", "rows")))
        return PointGrid(-given["width"] / 2, given["bottom"], dy, dz, given["columns"], given["rows"],
                         self.interpolation)  # fmt: skip

    def intensity(self) -> float | None:
        """Sigma/V; None for that of the normal turbulence model."""
        if self.turbulence_intensity is not None or self.turbulence_model == "ntm":
            return self.turbulence_intensity
        speed, reference = self.given_speed(), iec.REFERENCE_SPEED[self.wind_class]
        return iec.extreme_turbulence(speed, self.turbulence_class, reference) / speed

    def mean_at(self, station: int = 0) -> float:
        """Mean speed [m/s] at a station, of the profile; no field is made for it."""
        return mean_speed_at(self, self.given_speed(), station)

    def period(self) -> float:
        """That of the field [s]."""
        return float(self.repetition_period)


def _make(wind: TurbulentWind, path: Path, numbers: dict[str, Any]) -> None:
    try:
        generate_field(path, **numbers)
    except ParameterError as error:
        raise ParameterError(f"{wind.label}: {str(error).removeprefix(f'{path}: ')}") from None
