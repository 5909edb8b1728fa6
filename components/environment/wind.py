"""The wind of a model: none, steady, a step, a gust, Kaimal turbulence at the hubs, series or a field from a file."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.environment import turbulence
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_wind import check_mean, field_velocity, open_field, require_range
from fowtlib.components.environment.time_functions import (
    cosine_gust,
    extreme_gust,
    progress,
    smooth_step,
    warn_of_repetition,
)
from fowtlib.components.environment.wind_file import WindSeries, read_series
from fowtlib.language import (
    Array,
    Component,
    Number,
    RealOutput,
    Scalar,
    assert_,
    eq,
    open_input,
    param,
    port,
    shapes,
    time_series,
    var,
    when,
)
from fowtlib.language import math as m
from fowtlib.language.declarations import join
from fowtlib.language.errors import ParameterError, StructureError

LOWEST_HEIGHT = 1e-3  # of the station's height: below, and under water, the power law keeps its value

_turbulence = lru_cache(maxsize=8)(turbulence.kaimal_series)


def _per_station(wind: Wind) -> tuple[int]:
    return (len(wind.hubs),)


class Wind(Component):
    """Wind with power-law shear, or a full field; parts in the wind find it by `wind: Wind = outer(Wind)`.

    At height z over station i, which has the height z_i, the speed along `direction` is
    base_i(t) (z/z_i)^shear_exponent + fluctuation_i(t).
    Steady, step, gust, kaimal: base_i = V (z_i/reference_height)^shear_exponent with the mean speed V; gust and
    turbulence are the fluctuation, not sheared (IEC 61400-1 (18), annex B). File: base_i is the series of the station.

    step: V goes smoothly to `step_speed` within `step_duration` from `start_time` on.
    gust: "eog" is the extreme operating gust of IEC 61400-1, magnitude by (17) unless given; "1-cos" is one hump.
    kaimal: normal turbulence model by class, or an intensity. What a series holds and loses: module turbulence.
    file: see wind_file.read_series; a run past the end of the series stops there.
    field: u, v, w in space and time from a .bts file, see field_lookup; mean speed and shear are those of the file.
    input: the speed at each station comes from outside of the model; where nobody gives it, it is that of steady wind.
    The mean speed is tunable, but turbulence and the IEC gust are made for the speed that the model is compiled with.
    """

    kind: str = param(
        default="none", choices=("none", "steady", "step", "gust", "kaimal", "file", "field", "input"),
        doc="kind of wind",
    )  # fmt: skip
    mean_speed: Scalar = param(default=0.0, unit="m/s", min=0, doc="mean speed V at reference_height")
    reference_height: Number = param(default=90.0, unit="m", min=0, doc="height of mean_speed: the hub")
    stations: Array = param(default=((0, 90),), unit="m", structural=True, doc="(y, z) of each hub, one series each")
    shear_exponent: Scalar = param(default=0.0, doc="exponent of the power law")
    direction: Scalar = param(default=0.0, unit="rad", doc="direction in which the wind blows, from x towards y")
    start_time: Scalar = param(default=0.0, unit="s", min=0, doc="step, gust: start")
    step_speed: Scalar = param(default=0.0, unit="m/s", min=0, doc="step: speed afterwards, at reference_height")
    step_duration: Scalar = param(default=1.0, unit="s", min=1e-3, doc="step: time of the change")
    gust_shape: str = param(default="eog", choices=("eog", "1-cos"), doc="gust: time function")
    gust_speed: Number = param(default=None, unit="m/s", doc="gust: magnitude; without a value by IEC 61400-1 (17)")
    gust_duration: Scalar = param(default=10.5, unit="s", min=1e-3, doc="gust: duration")
    rotor_diameter: Number = param(default=126.0, unit="m", min=0, doc="gust by IEC: rotor diameter")
    extreme_speed: Number = param(default=50.0, unit="m/s", min=0, doc="gust by IEC: V_ref, 50 m/s for wind class I")
    turbulence_class: str = param(default="B", choices=("A", "B", "C"), doc="gust by IEC, kaimal: turbulence class")
    turbulence_intensity: Number = param(default=None, min=0, doc="kaimal: sigma/V; without a value by the class")
    seed: int = param(default=1, min=0, doc="kaimal: number of the realisation")
    sample_step: Number = param(default=0.25, unit="s", min=0, doc="kaimal: step; harmonics up to 1/(4 sample_step)")
    repetition_period: Number = param(default=4096.0, unit="s", min=0, doc="kaimal: period of the realisation")
    file: str = param(default="", doc="file: CSV with time [s] and speed [m/s] of each station; field: .bts file")
    field_shift: Number = param(default=None, unit="m", doc="field: x of its first plane at t = 0, see field_lookup")
    interpolation: str = param(default="linear", choices=("linear", "cubic"), doc="field: between its points, in time")

    speed: RealOutput = port(unit="m/s", shape=_per_station, doc="undisturbed speed at each station")
    base: Array = var(unit="m/s", shape=_per_station, doc="sheared part of the speed at each station")
    fluctuation: Array = var(unit="m/s", shape=_per_station, doc="gust or turbulence at each station")

    def equations(self):
        base, fluctuation, statements = _TIME_FUNCTIONS[self.kind](self)
        speed = self.base + self.fluctuation
        return [eq(self.base, base), eq(self.fluctuation, fluctuation), eq(self.speed, speed), *statements]

    def drawing(self) -> shapes.Drawing:
        return [] if self.kind == "none" else _arrows(self)

    def velocity(self, r: ca.SX, station: int = 0, reach: str = "tower") -> ca.SX:
        """Wind velocities (3, n, world) at n positions r (3, n, world), with the series of a station; while flattening.

        A field needs no station: it knows u, v, w everywhere. One call for all nodes of a rotor costs the least. reach:
        how far down a field serves, to the lowest row of its "plane", the lowest point of its "tower", or the "ground",
        with a wind that falls linearly to nothing from there; see field_lookup.
        """
        r = _positions(r)
        if self.kind == "field":
            world = m.rotation_z(self.direction)  # from the axes of the field
            return world @ field_velocity(_lookup(self), self.time, world.T @ r, reach)
        return _along(self, r, station)

    def require(self, y_range: tuple[float, float], z_range: tuple[float, float], who: str) -> None:
        """ParameterError, which names `who`, where a field does not cover y_range and z_range [m].

        For parts whose size is known before the run: a rotor of radius R about the station (y, z) asks for
        (y - R, y + R), (z - R, z + R). Like the stations, y is across the wind. Other kinds of wind are everywhere.
        """
        if self.kind == "field":
            require_range(_lookup(self), y_range, z_range, who)

    @property
    def hubs(self) -> np.ndarray:
        """The stations as numbers, (n, 2)."""
        return np.asarray(self.parameter_value("stations"))

    def mean_at(self, station: int = 0) -> Any:
        """Mean speed at a station, a start value for filters: of a file's series, else before any step or gust."""
        if self.kind == "file":
            return float(_read(self).values[:, station].mean())
        if self.kind == "field":
            _height(self, station)
            return _lookup(self).mean(*self.hubs[station].tolist())
        return 0.0 if self.kind == "none" else self.mean_speed * _shear(self, _height(self, station))

    def turbulence(self) -> WindSeries:
        """The turbulent fluctuation at the stations as numbers."""
        speed = _built_speed(self)
        if self.turbulence_intensity is None:
            sigma = turbulence.normal_turbulence(speed, self.turbulence_class)
        else:
            sigma = self.turbulence_intensity * speed
        grid = {name: getattr(self, name) for name in ("seed", "sample_step", "repetition_period")}
        return _turbulence(tuple(map(tuple, self.hubs.tolist())), speed, sigma, height=self.reference_height, **grid)


def _arrows(wind: Wind) -> list[shapes.Drawn]:
    """An arrow 30 m before each station; its length is the way of the wind in 3 s."""
    angle = wind.parameter_value("direction")
    direction = np.array([math.cos(angle), math.sin(angle), 0.0])
    places = np.insert(wind.hubs, 0, 0.0, axis=1) - 30.0 * direction
    speeds = [join(wind.path, f"speed[{i}]") for i in range(len(places))]
    return [shapes.Arrow(place, direction, speed, 3.0) for place, speed in zip(places, speeds, strict=True)]


def require_disk(wind: Wind, radius: float, station: int, who: str) -> None:
    """As Wind.require, for a rotor disk [m] about a station; ParameterError also where there is no such station."""
    if wind.kind == "field":
        _height(wind, station)
        y, z = wind.hubs[station].tolist()
        about = f"{who}, of radius {radius:g} m about station {station} of the wind at ({y:g}, {z:g}) m,"
        wind.require((y - radius, y + radius), (z - radius, z + radius), about)


def _positions(r: Any) -> ca.SX:
    r = ca.SX(r)
    if r.shape[0] != 3:
        raise StructureError(f"the wind is wanted at positions {r.shape[0]} x {r.shape[1]}; give them as 3 x n.")
    return r


def _along(wind: Wind, r: ca.SX, station: int) -> ca.SX:
    """Velocities (3, n) of a wind that has one speed over a station at each height."""
    height = m.fmax(r[2, :] / _height(wind, station), LOWEST_HEIGHT)
    speed = wind.base[station] * height**wind.shear_exponent + wind.fluctuation[station]
    return m.vertcat(speed * m.cos(wind.direction), speed * m.sin(wind.direction), m.zeros(1, r.shape[1]))


def _none(wind: Wind) -> tuple[Any, Any, list[Any]]:
    return 0, 0, []


def _steady(wind: Wind) -> tuple[Any, Any, list[Any]]:
    return _sheared(wind, wind.mean_speed), 0, []


def _input(wind: Wind) -> tuple[Any, Any, list[Any]]:
    mean, exponent = (float(wind.parameter_value(name)) for name in ("mean_speed", "shear_exponent"))
    speeds = mean * (wind.hubs[:, 1] / wind.reference_height) ** exponent
    return open_input("speed_input", len(speeds), "m/s", "wind speed at each station", speeds), 0, []


def _step(wind: Wind) -> tuple[Any, Any, list[Any]]:
    change = smooth_step(progress(wind.time, wind.start_time, wind.step_duration))
    mean = wind.mean_speed + (wind.step_speed - wind.mean_speed) * change
    return _sheared(wind, mean), 0, [when(wind.time > wind.start_time)]


def _gust(wind: Wind) -> tuple[Any, Any, list[Any]]:
    statements = [when(wind.time > wind.start_time)]  # the integrator restarts here, and cannot step over the gust
    magnitude = wind.gust_speed
    if magnitude is None:
        speed, sizes = _built_speed(wind), (wind.rotor_diameter, wind.reference_height, wind.extreme_speed)
        magnitude = turbulence.operating_gust(speed, wind.turbulence_class, *sizes)
        statements.append(_same_speed(wind))
    shape = extreme_gust if wind.gust_shape == "eog" else cosine_gust
    gust = magnitude * shape(progress(wind.time, wind.start_time, wind.gust_duration))
    return _sheared(wind, wind.mean_speed), gust, statements


def _kaimal(wind: Wind) -> tuple[Any, Any, list[Any]]:
    series = wind.turbulence()
    statements = [_same_speed(wind), warn_of_repetition(wind.time, series.end, "wind")]
    return _sheared(wind, wind.mean_speed), _series(wind, series, "turbulence"), statements


def _file(wind: Wind) -> tuple[Any, Any, list[Any]]:
    return _series(wind, _read(wind), f"wind file {wind.file}"), 0, []


def _field(wind: Wind) -> tuple[Any, Any, list[Any]]:
    lookup, hubs = _lookup(wind), np.insert(wind.hubs, 0, 0.0, axis=1)
    check_mean(lookup)
    lookup.velocity(hubs + [lookup.shift, 0, 0], 0.0)  # an error now, if a station is outside of the field
    repeats = f"the wind field {wind.file} repeats itself after {lookup.grid.duration:g} s; use a longer one."
    periodic = lookup.grid.periodic
    warning = [assert_(wind.time < lookup.grid.duration * (1 + 1e-6), repeats, level="warning")] if periodic else []
    return field_velocity(lookup, wind.time, hubs.T)[0, :].T, 0, warning


_TIME_FUNCTIONS = {
    "none": _none, "steady": _steady, "step": _step, "gust": _gust, "kaimal": _kaimal, "file": _file, "field": _field,
    "input": _input,
}  # fmt: skip


def _sheared(wind: Wind, speed: Any) -> Any:
    """Speed at every station from the speed at the reference height."""
    _built_speed(wind)
    return m.vertcat(*[speed * _shear(wind, height) for height in wind.hubs[:, 1].tolist()])


def _shear(wind: Wind, height: float) -> Any:
    """Power law as exp(shear_exponent log(ratio)), which also works on references to parameters."""
    return m.exp(wind.shear_exponent * math.log(height / wind.reference_height))


def _height(wind: Wind, station: int) -> float:
    if not 0 <= station < len(wind.hubs):
        raise ParameterError(
            f"station {station} of {wind.label} does not exist (it has {len(wind.hubs)}, counted from 0); "
            "set its parameter stations to the (y, z) of every hub."
        )
    return float(wind.hubs[station, 1])


def _read(wind: Wind) -> WindSeries:
    if not wind.file:
        raise ParameterError(f"{wind.label}.file has no value; a wind of kind 'file' needs the path of a CSV file.")
    return read_series(wind.file, len(wind.hubs))


def _lookup(wind: Wind) -> FieldLookup:
    if not wind.file:
        raise ParameterError(f"{wind.label}.file has no value; a wind of kind 'field' needs the path of a .bts file.")
    return open_field(wind.file, wind.field_shift, wind.interpolation)


def _series(wind: Wind, series: WindSeries, name: str) -> Any:
    return time_series(wind.time, series.start, series.step, series.values, periodic=series.periodic, name=name)


def _built_speed(wind: Wind) -> float:
    """The mean speed as a number, when the model is compiled."""
    if not wind.is_set("mean_speed"):
        raise ParameterError(f"{wind.label}.mean_speed has no value; a wind of kind '{wind.kind}' needs it.")
    return float(wind.parameter_value("mean_speed"))


def _same_speed(wind: Wind) -> Any:
    built = _built_speed(wind)
    message = (
        f"mean_speed was changed after the model was compiled, and the {wind.kind} wind is made for {built:g} m/s; "
        "compile it again with the new speed."
    )
    return assert_(m.abs(wind.mean_speed - built) < 1e-9 * (1 + built), message)
