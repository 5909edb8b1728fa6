"""A full field of wind velocities."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fowtlib.components.environment.disc_of_field import disc_of_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_wind import FieldData, check_mean, open_field, require_range
from fowtlib.components.environment.wind.base import Wind, station_height
from fowtlib.components.environment.wind_file import WindSeries
from fowtlib.language import Number, Series, param
from fowtlib.language.errors import ParameterError
from fowtlib.language.run_time import RestingPlaces, TurningRings


class FieldWind(Wind, kind="field"):
    """u, v, w in space and time from a .bts file, see field_lookup; mean speed and shear are those of the file."""

    in_own_units = {"": "a field of turbulence has lengths and speeds of its own"}

    void = ("mean_speed", "shear_exponent")
    of_data = True

    file: str = param(default="", bound=True, doc="TurbSim .bts file")
    field_shift: Number = param(
        default=None, unit="m", bound=True, doc="x of its first plane at t = 0, see field_lookup"
    )
    interpolation: str = param(
        default="linear", choices=("linear", "cubic"), bound=True, doc="between its points, in time"
    )

    def lookup(self) -> FieldLookup:
        """The look-up of the file."""
        if not self.file:
            raise ParameterError(
                f"{self.label}.file has no value; a wind of kind 'field' needs the path of a .bts file."
            )
        return open_field(self.file, self.field_shift, self.interpolation)

    def field(self) -> FieldData | None:
        """The field, if it holds all stations and has a mean."""
        lookup, hubs = self.lookup(), np.insert(self.hubs, 0, 0.0, axis=1)
        check_mean(lookup)
        lookup.velocity(hubs + [lookup.shift, 0, 0], 0.0)  # an error if a station is outside of the field
        return FieldData(lookup)

    def period(self) -> float:
        """That of a periodic field [s]."""
        grid = self.lookup().grid
        return grid.duration if grid.periodic else np.inf

    def field_density(self, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces], part: int = 0,
                      basis: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
        """Nobody knows the spectrum of a file."""
        raise ParameterError(
            f"{self.label}: the spectrum of a field in a file is not known; give the wind that it was made of, as in "
            "--wind turbulence:12."
        )

    @property
    def turbulent(self) -> bool:
        """A field is."""
        return True

    def places_density(self, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces]) -> np.ndarray:
        return self.field_density(omega, places)

    def disc_series(self, places: Sequence[TurningRings | RestingPlaces], number: int) -> WindSeries:
        """What the places of a disc meet of u on their way, less its mean there."""
        return disc_of_field(self.lookup(), places[number])

    def mean_at(self, station: int = 0) -> float:
        """Mean [m/s] of u at a station."""
        station_height(self, station)
        return self.lookup().mean(*self.hubs[station].tolist())

    def before_the_run(self) -> dict[str, Series | None]:
        """A fluctuation of the stations, what each rotor's disk has of the field on average; none of a field that ends.

        A rotor of coefficients feels the wind at the hub. What differs over a disk, and yaws it, is no part.
        """
        lookup = self.lookup()
        if not lookup.grid.periodic:
            return {"series": None}
        parts = [self, *self.enclosing()][-1].walk()
        radii = dict(part.felt_disk() for part in parts if hasattr(part, "felt_disk"))
        speeds = np.column_stack([lookup.over_disk(y, z, radii.get(k, 0.0)) for k, (y, z) in enumerate(self.hubs)])
        values = np.hstack([np.zeros_like(speeds), speeds - speeds.mean(axis=0)])
        start = -lookup.shift / lookup.grid.speed
        return {"series": Series.samples(values, lookup.grid.dt, start, periodic=True, interpolation="linear")}

    def require(self, y_range: tuple[float, float], z_range: tuple[float, float], who: str) -> None:
        """ParameterError where the field does not cover the ranges [m]."""
        require_range(self.lookup(), y_range, z_range, who)
