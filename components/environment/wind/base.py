"""Wind: what all kinds of wind have in common, their equations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.field_wind import NO_FIELD, FieldData, wind_function
from fowtlib.components.environment.wind.discs import OnDiscs
from fowtlib.components.environment.wind.points import Flow, positions
from fowtlib.components.environment.wind.randomness import FieldNumbers, StationSignals
from fowtlib.language import (
    Array,
    Component,
    Number,
    RealOutput,
    Scalar,
    Series,
    assert_,
    at_start,
    eq,
    param,
    port,
    run_time_series,
    shapes,
    var,
)
from fowtlib.language import math as m
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError


def _per_station(wind: Wind) -> tuple[int]:
    return (len(wind.hubs),)


class Wind(OnDiscs, Component, selector="kind", shared=("speeds", "velocity")):
    """Wind with power-law shear, or a full field; parts in the wind find it by `wind: Wind = outer(Wind)`.

    At (y, z) about station i at (y_i, z_i) the speed along the bearing = direction + turn(t) is
    base_i(t) (z/z_i)^shear_exponent + fluctuation_i(t) + gradient(t) . (z - z_i, y - y_i), and
    base_i = (mean_speed share(t) + added(t)) (z_i/reference_height)^shear_exponent + own_i(t);
    y is across the wind. turn, share, added, own, fluctuation and gradient are what the kinds of wind differ in, and
    with a field the velocities are its own: data that are bound when a run starts. One compiled model serves all kinds
    but "input".

    A kind is a class: `SteadyWind(mean_speed=8)` and `Wind(kind="steady", mean_speed=8)` are the same. Another kind
    says in `mean_series`, `station_series`, `shape_series` or `field` what it blows, in `mean_at` what its mean is, and
    in `spectral_density` what its spectrum is.
    """

    kind: str = param(default="none", bound=True, doc="kind of wind")
    mean_speed: Scalar = param(default=0.0, unit="m/s", min=0, doc="mean speed V at reference_height")
    reference_height: Number = param(default=90.0, unit="m", min=0, bound=True, doc="height of mean_speed: the hub")
    stations: Array = param(default=((0, 90),), unit="m", structural=True, doc="(y, z) of each hub, one series each")
    shear_exponent: Scalar = param(default=0.0, doc="exponent of the power law")
    direction: Scalar = param(default=0.0, unit="rad", doc="direction in which the wind blows, from x towards y")

    speed: RealOutput = port(unit="m/s", shape=_per_station, doc="undisturbed speed at each station")
    base: Array = var(unit="m/s", shape=_per_station, doc="sheared part of the speed at each station")
    fluctuation: Array = var(unit="m/s", shape=_per_station, doc="gust or turbulence at each station")
    bearing: Scalar = var(unit="rad", doc="direction in which the wind blows now")
    gradient: Array = var(unit="1/s", shape=(2,), doc="linear shear over height, and across the wind")

    if TYPE_CHECKING:  # the class of the kind takes further parameters

        def __init__(self, **parameters: Any) -> None: ...

    def equations(self):
        base, fluctuation = self.speeds()
        shape = run_time_series(self.time, 3, "shape", lambda it: it.shape_series(), of=self)
        return [
            [eq(self.base, base), eq(self.fluctuation, fluctuation), eq(self.speed, self.base + self.fluctuation)],
            [eq(self.bearing, self.direction + shape[0]), eq(self.gradient, shape[1:])],
            _repetition(self),
        ]

    def drawing(self):
        return _arrows(self)

    # --- what the kinds say, when a run starts -----------------------------------------------------------------------

    def mean_series(self) -> Series | None:
        """Share of the mean speed, and speed [m/s] that is added to it at the reference height; None: neither."""
        return None

    def station_series(self) -> Series | None:
        """Part of the base, then fluctuation [m/s], of all stations: 2 n signals; None: nothing."""
        return None

    def shape_series(self) -> Series | None:
        """Turn of the direction [rad], linear shear over height and across the wind [1/s]: 3 signals; None: nothing."""
        return None

    def field(self) -> FieldData | None:
        """The field of velocities in space and time that takes the place of all this."""
        return None

    def period(self) -> float:
        """Time [s] after which the wind repeats itself."""
        return math.inf

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        """One-sided spectra of the fluctuation of the stations, and cross spectra (real), (k, n, n) [m^2 s^-2/(rad/s)].

        omega: circular frequencies (k,) [rad/s]. Zero where the kind has none; the mean is no part of it.
        """
        return np.zeros((len(np.atleast_1d(omega)), len(self.hubs), len(self.hubs)))

    def mean_at(self, station: int = 0) -> float:
        """Mean speed [m/s] at a station, for start values: before any step or gust."""
        return mean_speed_at(self, self.parameter_value("mean_speed"), station)

    def in_the_mean(self) -> dict[str, Any]:
        """Steady wind of the mean speed and shear; of a kind with a mean of its own, by that at the first station."""
        return _mean(self)

    def require(self, y_range: tuple[float, float], z_range: tuple[float, float], who: str) -> None:
        """ParameterError, which names `who`, where a field does not cover y_range and z_range [m].

        For parts whose size is known before the run: a rotor of radius R about the station (y, z) asks for
        (y - R, y + R), (z - R, z + R). Like the stations, y is across the wind. Other kinds of wind are everywhere.
        """

    # --- the equations -----------------------------------------------------------------------------------------------

    def speeds(self) -> tuple[Any, Any]:
        """Base and fluctuation at the stations, (n,) each [m/s]; while flattening."""
        return _speeds(self)

    def velocity(self, r: ca.SX, station: int = 0, reach: str = "tower") -> ca.SX:
        """Wind velocities (3, n, world) at n positions r (3, n, world), with the series of a station; while flattening.

        A field needs no station: it knows u, v, w everywhere. One call for all nodes of a rotor costs the least. reach:
        how far down a field serves, to the lowest row of its "plane", the lowest point of its "tower", or the "ground",
        with a wind that falls linearly to nothing from there; see field_lookup.
        """
        points, height, side = positions(r), station_height(self, station), float(self.hubs[station, 0])
        now = self.base[station], self.fluctuation[station], self.shear_exponent, self.bearing, self.gradient
        return Flow(self.path, self.time, *now, side, height).velocities(points, _field(self, points.shape[1]), reach)

    @property
    def hubs(self) -> np.ndarray:
        """The stations as numbers, (n, 2)."""
        stations = np.asarray(self.parameter_value("stations"))
        if stations.ndim != 2 or stations.shape[1] != 2:
            raise ParameterError(f"{self.label}.stations: give (y, z) of each hub, as in [[0, 90]]; got {stations}.")
        return stations

    def require_speed(self) -> None:
        """ParameterError where nobody has given the mean speed, for a kind that needs it."""
        if not self.is_set("mean_speed"):
            raise ParameterError(f"{self.label}.mean_speed has no value; a wind of kind '{self.kind}' needs it.")

    def given_speed(self) -> float:
        """The mean speed [m/s] as a number, for data that are made for it; see `require_speed`."""
        self.require_speed()
        return float(self.parameter_value("mean_speed"))


def _mean(wind: Wind) -> dict[str, Any]:
    """The steady wind of a mean, whose speed is to 1 cm/s where it is of data: for many realisations one mean.

    A kind whose mean is that of the data of one realisation says `of_data`. Where it follows from parameters nothing
    but noise is rounded off: results are differentiated by these.
    """
    of_its_own, digits = type(wind).mean_at is not Wind.mean_at, 2 if getattr(type(wind), "of_data", False) else 12
    own = {"mean_speed": round(wind.mean_at(0) / mean_speed_at(wind, 1.0, 0), digits)} if of_its_own else {}
    return {"kind": "steady", "shear_exponent": float(wind.parameter_value("shear_exponent")), **own}


def require_disk(wind: Wind, radius: float, station: int, who: str) -> None:
    """As Wind.require, for a rotor disk [m] about a station; ParameterError also where there is no such station."""
    z, y = station_height(wind, station), float(wind.hubs[station, 0])
    about = f"{who}, of radius {radius:g} m about station {station} of the wind at ({y:g}, {z:g}) m,"
    wind.require((y - radius, y + radius), (z - radius, z + radius), about)


def _speeds(wind: Wind) -> tuple[ca.SX, ca.SX]:
    n, shear = len(wind.hubs), wind.shear_exponent
    mean = run_time_series(wind.time, 2, "mean", lambda it: it.mean_series(), of=wind)
    own = run_time_series(wind.time, 2 * n, "series", StationSignals(), of=wind, message=_ended(wind))
    over = at_start("heights", n, "1", "log(z_i/reference_height)", _logarithms, of=wind)
    hubs = positions(np.insert(wind.hubs, 0, 0.0, axis=1).T)
    field = Flow(wind.path, wind.time, shear_exponent=shear).velocities(hubs, _field(wind, n))[0, :].T
    sheared = (wind.mean_speed * mean[0] + mean[1]) * m.exp(shear * over)
    return sheared + own[:n] + field, own[n:]


def _field(wind: Wind, points: int) -> ca.SX:
    """The numbers of the field of the run, or of none, for so many points."""
    doc = "handle of the field, what it covers, its shift, 1/speed and lowest height"
    functions = (wind_function(points),)
    return at_start("field", len(NO_FIELD), "", doc, FieldNumbers(), of=wind, functions=functions)


def _ended(wind: Wind) -> str:
    """What is said of a run past the end of a series."""
    file = "{%s}" % join(wind.path, "file")  # noqa: UP031 braces for later
    return f"table left at its edge: wind file {file} at time = {{value}}, and the table covers {{low}} to {{high}}."


def _repetition(wind: Wind) -> list[Any]:
    """Warnings, once, of a run that is longer than the wind."""
    period = at_start("period", 1, "s", "time after which the wind repeats itself", lambda it: it.period(), of=wind)
    message = "the wind repeats itself after {period} s; use a longer one, by its repetition_period or its file."
    return [assert_(wind.time < period * (1 + 1e-9), message, level="warning", period=period)]


def _logarithms(wind: Wind) -> np.ndarray:
    heights = wind.hubs[:, 1] / wind.reference_height
    if not np.all(heights > 0):
        raise ParameterError(f"{wind.label}.stations: the heights of the stations must lie above zero.")
    return np.log(heights)


def station_height(wind: Wind, station: int) -> float:
    """Height [m] of a station; ParameterError for one that does not exist."""
    if not 0 <= station < len(wind.hubs):
        raise ParameterError(
            f"station {station} of {wind.label} does not exist (it has {len(wind.hubs)}, counted from 0); "
            "set its parameter stations to the (y, z) of every hub."
        )
    return float(wind.hubs[station, 1])


def mean_speed_at(wind: Wind, speed: float, station: int) -> float:
    """Speed [m/s] at a station by the power law, from the speed at the reference height."""
    height = station_height(wind, station) / wind.reference_height
    return float(speed * height ** wind.parameter_value("shear_exponent"))


def _arrows(wind: Wind) -> list[shapes.Drawn]:
    """An arrow 30 m before each station; its length is the way of the wind in 3 s."""
    angle = wind.parameter_value("direction")
    direction = np.array([math.cos(angle), math.sin(angle), 0.0])
    places = np.insert(wind.hubs, 0, 0.0, axis=1) - 30.0 * direction
    speeds, now = [join(wind.path, f"speed[{i}]") for i in range(len(places))], join(wind.path, "bearing")
    return [shapes.Arrow(place, direction, speed, 3.0, now) for place, speed in zip(places, speeds, strict=True)]
