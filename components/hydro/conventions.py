"""Whether the numbers of a hydrodynamic database follow its conventions: the limit of long waves tells.

A wave that is long against the hull accelerates the water around it evenly and lifts it like a tide, so that the load
of the waves follows from volume, added mass and stiffness alone. With X going with exp(+i omega t), waves that travel
along `heading`, wave number k, and A at the lowest frequency, up to terms of (k times the size of the hull)^2,

    X_i = C_i3 + i k cos(heading) (g A_i1 + C_i5 + rho g V [for i = 1])
               + i k sin(heading) (g A_i2 - C_i4 + rho g V [for i = 2]),

and X_3 less omega^2 (rho V + A_33) times the decay of the vertical motion at the centre of the volume. So
X_1 = +i rho g k V (1 + A_11 / (rho V)) cos(heading), and X_3 = C_33 at last. For the spar of OC3 at 0.05 rad/s X_1 is
0.986, X_3 1.000, X_5 0.983 of that; at 0.15 rad/s 0.88, 1.00 and 0.85.

A database that misses it by more than 35 % is refused where another convention fits within 15 %, which the message
names. Where none does, a warning shows the numbers, if there are long waves (k times the size at most 0.5). The size
is the largest of twice the depth of the centre of the volume, twice the gyration radius of the waterplane, and the cube
root of the volume.

Source: J.N. Newman, Marine Hydrodynamics (1977), sections 6.17, 6.18; G.I. Taylor, Proc. R. Soc. A 120 (1928) 13-21.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.environment.waves import wave_number
from fowtlib.components.hydro.errors import HydrodynamicDataError

if TYPE_CHECKING:
    from fowtlib.components.hydro.database import HydrodynamicDatabase

Floats = NDArray[np.float64]

MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_LONG = 0.5  # wave number times size of the hull, below which a wave is long
_LARGE = 0.35  # error of the limit, relative, that no long wave has
_WIDE = 4.0  # gyration radius of a waterplane, in cube roots of the volume; barges and semisubmersibles have below 2
_SMALL = 0.15  # error within which another convention is said to fit, the waves being long then


@dataclass(frozen=True, eq=False)
class _LongWave:
    """The longest wave of a database: loads X (nh, 6) at omega, with the matrices of the lowest frequency."""

    omega: float
    heading: Floats
    X: NDArray[np.complex128]
    A: Floats
    C: Floats
    volume: float
    depth_of_volume: float
    rho: float
    g: float
    water_depth: float

    @property
    def number(self) -> float:
        return float(wave_number(self.omega, self.water_depth, self.g))

    @property
    def size(self) -> float:
        """Size of the hull [m]."""
        lift, section = self.rho * self.g * self.volume, max(self.C[2, 2], 0.0)
        moment = max(self.C[3, 3], self.C[4, 4]) + lift * self.depth_of_volume
        gyration = np.sqrt(moment / section) if moment > 0 and section > 0 else 0.0
        return max(2 * self.depth_of_volume, 2 * gyration, self.volume ** (1 / 3))

    @property
    def shortness(self) -> float:
        """Wave number times size."""
        return self.number * self.size

    def expected(self) -> NDArray[np.complex128]:
        """X (nh, 6) of the limit."""
        along, aside = self.g * self.A[:, 0] + self.C[:, 4], self.g * self.A[:, 1] - self.C[:, 3]
        along[0] += self.rho * self.g * self.volume
        aside[1] += self.rho * self.g * self.volume
        cos, sin = np.cos(self.heading)[:, None], np.sin(self.heading)[:, None]
        load = self.C[:, 2] + 1j * self.number * (cos * along + sin * aside)
        load[:, 2] -= self.omega**2 * (self.rho * self.volume + self.A[2, 2]) * self._decay()
        return load

    def _decay(self) -> float:
        k, z, h = self.number, self.depth_of_volume, self.water_depth
        if not np.isfinite(h):
            return float(np.exp(-k * z))
        return float(np.exp(-k * z) * np.expm1(-2 * k * max(h - z, 0.0)) / np.expm1(-2 * k * h))

    def scale(self) -> Floats:
        """Load (5,) that errors are measured by, surge to pitch; the load of yaw has no limit worth a check."""
        k, lift = self.number, self.rho * self.g * self.volume
        push = k * (lift + self.g * max(self.A[0, 0], self.A[1, 1]))
        heave = max(abs(self.C[2, 2]), push)
        A, C = np.abs(self.A), np.abs(self.C)
        turn = k * (self.g * max(A[3, 1], A[4, 0]) + max(C[3, 3], C[4, 4])) + max(C[3, 2], C[4, 2])
        return np.array([push, push, heave, *[turn + 0.2 * k * lift * self.volume ** (1 / 3)] * 2])

    def error(self) -> Floats:
        """Difference (nh, 5) between X and its limit, relative."""
        return np.abs(self.X - self.expected())[:, :5] / self.scale()

    def fits(self) -> bool:
        """Whether the wave is long and the load has its limit, closely."""
        return self.shortness <= _LONG and self.error().max() <= _SMALL


def check_conventions(data: HydrodynamicDatabase) -> None:
    """Refuse data that follow another convention than HydrodynamicDatabase has. Raises HydrodynamicDataError."""
    wave = _longest(data, data.omega)
    if wave.error().max() > _LARGE:
        _find_other_convention(data, wave)
    _check_limits_of_added_mass(data)
    _check_waterplane(data)


def _find_other_convention(data: HydrodynamicDatabase, wave: _LongWave) -> None:
    for other, meaning in _other_conventions(data, wave):
        if other.fits():
            raise HydrodynamicDataError(f"{meaning}.{_evidence(wave)}")
    if wave.shortness <= _LONG:
        warnings.warn(
            f"{data.source or 'hydrodynamic data'}: the load of the waves does not have its limit for long waves. Are "
            "frequency, heading, phase (exp(+i omega t)), length scale, density, volume and order of the modes right?"
            f"{_evidence(wave)}",
            stacklevel=4,
        )


def _longest(data: HydrodynamicDatabase, omega: Floats) -> _LongWave:
    """The longest wave, if the frequencies were `omega`."""
    row = int(np.argmin(omega))
    added = data.A[row] if data.A_zero is None else data.A_zero
    return _LongWave(
        float(omega[row]), data.heading, data.X[row], added, data.C, data.volume, -float(data.centre_of_buoyancy[2]),
        data.rho, data.g, data.water_depth,
    )  # fmt: skip


def _other_conventions(data: HydrodynamicDatabase, wave: _LongWave) -> Iterator[tuple[_LongWave, str]]:
    """What the data may have meant, and the sentence that says so and what to do."""
    yield (
        replace(wave, X=wave.X.conj()),
        "the phase of the wave load has the wrong sign: the data go with exp(-i omega t), or their headings are those "
        "from which the waves come. Turn the sign of the phase and of the imaginary part, or the headings by 180 deg",
    )
    turn = 2 * np.pi
    yield (
        _longest(data, turn / data.omega),
        "periods [s] and circular frequencies [rad/s] are mixed up, what was read as the one is the other: the first "
        "column of WAMIT files must be the period (IPEROUT = 1), omega of a netCDF file must be in rad/s",
    )
    yield (
        _longest(data, turn**2 / data.omega),
        "the column of the periods holds frequencies in Hz: write the periods in s there",
    )
    yield _longest(data, turn * data.omega), "omega is in Hz: it must be in rad/s, 2 pi times as much"
    yield from _other_headings(wave)
    yield from _other_scales(wave)
    yield from _other_modes(wave)
    _check_waterplane(data)  # matrices about another point make the moments of the waves look wrong
    yield from _other_point(wave)


def _other_headings(wave: _LongWave) -> Iterator[tuple[_LongWave, str]]:
    if np.abs(wave.heading).max() <= 2 * np.pi * np.pi / 180 * 1.001:
        meaning = "the headings are in rad where degrees are expected: multiply them by 180 / pi"
        yield replace(wave, heading=wave.heading * 180 / np.pi), meaning
    yield (
        replace(wave, heading=-wave.heading),
        "the headings turn the wrong way: they count from x towards y, which is to port (z up). Turn their sign",
    )
    for turned in (np.pi / 2 - wave.heading, np.pi / 2 + wave.heading):
        meaning = "the headings count from the y axis: they are the directions in which the waves travel, 0 along +x"
        yield replace(wave, heading=turned), meaning


def _other_scales(wave: _LongWave) -> Iterator[tuple[_LongWave, str]]:
    """Loads that are all too large by one factor, or matrices and loads of another length scale."""
    row = int(np.abs(np.cos(wave.heading)).argmax())
    found, expected = wave.X[row, 2].real, wave.expected()[row, 2].real
    factor = found / expected if expected else 0.0
    meanings = {
        2.0: "the wave load is per wave height, it seems, twice that per amplitude: divide it by 2",
        0.5: "the wave load is half of what it should be: it must be per amplitude of the wave, not per height",
        1e-3: "the wave load is in kN, it seems: it must be in N",
        1e3: "the wave load is 1000 times too large: it must be in N per m of amplitude",
    }
    for size, meaning in meanings.items():
        if abs(factor / size - 1) < _SMALL:
            yield replace(wave, X=wave.X / size), meaning
    for length in _lengths(wave, row):
        power = np.array([0, 0, 0, 1, 1, 1])
        other = replace(
            wave,
            X=wave.X * length ** (2 + power),
            A=wave.A * length ** (3 + power[:, None] + power),
            C=wave.C * length ** (2 + power[:, None] + power),
        )
        lift = wave.rho * wave.g * wave.volume * wave.depth_of_volume
        if min(other.C[3, 3], other.C[4, 4]) > -1.3 * lift:  # else the waterplane were negative
            yield (
                other,
                f"the data were written with another length scale: they fit with a ULEN of about {length:.2g} times "
                "the `length` given here; give that of the run (or check volume, density and units)",
            )


def _lengths(wave: _LongWave, row: int) -> list[float]:
    """Length scales L with which |X1| L^2 = rho g k V (1 + A11 L^3 / (rho V)) holds along a heading."""
    lift = wave.number * wave.rho * wave.g * wave.volume
    cosine = abs(np.cos(wave.heading[row]))
    roots = np.roots([wave.number * wave.g * wave.A[0, 0], -abs(wave.X[row, 0]) / cosine, 0.0, lift])
    lengths = [float(root.real) for root in roots if abs(root.imag) < 1e-9 * abs(root) and root.real > 0]
    return sorted(length for length in lengths if abs(np.log(length)) > np.log(1.5))


def _other_modes(wave: _LongWave) -> Iterator[tuple[_LongWave, str]]:
    """Loads whose modes stand in another order."""
    same = np.arange(3)
    orders = [np.array(order) for order in itertools.permutations(range(3))]
    for moved, turned in [(o, o) for o in orders] + [(o, same) for o in orders] + [(same, o) for o in orders]:
        order = np.append(moved, 3 + turned)
        if (order == np.arange(6)).all():
            continue
        names = ", ".join(MODES[mode] for mode in order)
        yield (
            replace(wave, X=wave.X[:, np.argsort(order)]),
            f"the modes of the wave load stand in the order {names}: it must be {', '.join(MODES)}",
        )


def _other_point(wave: _LongWave) -> Iterator[tuple[_LongWave, str]]:
    """Moments of the waves about another height than that of the matrices."""
    lever = wave.expected()[:, 4] - wave.X[:, 4], wave.X[:, 0]
    lever = np.append(lever[0], wave.X[:, 3] - wave.expected()[:, 3]), np.append(lever[1], wave.X[:, 1])
    height = float((np.conj(lever[1]) @ lever[0]).real / max((np.abs(lever[1]) ** 2).sum(), 1e-300))
    X = wave.X.copy()
    X[:, 4] += height * X[:, 0]
    X[:, 3] -= height * X[:, 1]
    yield (
        replace(wave, X=X),
        f"the moments of the waves are about a point at z = {height:.3g} m, those of the matrices are not: all must be "
        "about the origin on the still water level",
    )


def _check_limits_of_added_mass(data: HydrodynamicDatabase) -> None:
    """A_zero and A_inf at the wrong ends: A is near the one at its first and near the other at its last frequency."""
    if data.A_zero is None:
        return
    for mode in (0, 1, 2):
        first, last, zero, infinite = (float(M[mode, mode]) for M in (data.A[0], data.A[-1], data.A_zero, data.A_inf))
        apart = abs(zero - infinite)
        if apart > 0.02 * max(abs(zero), abs(infinite)) and max(abs(first - infinite), abs(last - zero)) < 0.25 * apart:
            raise HydrodynamicDataError(
                f"the added mass at zero and at infinite frequency are mixed up: {MODES[mode]} has {first:.5g} at "
                f"{data.omega[0]:.3g} rad/s and {last:.5g} at {data.omega[-1]:.3g} rad/s, but {zero:.5g} at zero and "
                f"{infinite:.5g} at infinity. In a .1 file PER < 0 means zero and PER = 0 means infinite frequency"
            )


def _check_waterplane(data: HydrodynamicDatabase) -> None:
    """C44 and C55 less the moment of the buoyancy are second moments of the waterplane, which are not negative."""
    lift = data.rho * data.g * data.volume
    depth = -float(data.centre_of_buoyancy[2])
    for mode in (3, 4):
        moment = float(data.C[mode, mode]) + lift * depth
        if moment < -0.02 * lift * max(depth, data.volume ** (1 / 3)):
            raise HydrodynamicDataError(
                f"the stiffness of {MODES[mode]}, {data.C[mode, mode]:.5g} N m, is less than the moment of buoyancy "
                f"alone, {-lift * depth:.5g} N m (volume {data.volume:.5g} m^3, its centre at z = {-depth:.4g} m): is "
                "it about another point than the origin on the still water level, has it the weight in it, or is the "
                "length scale another?"
            )
        radius = np.sqrt(max(moment, 0.0) / max(data.C[2, 2], 1e-6 * lift))
        if radius > _WIDE * data.volume ** (1 / 3):
            warnings.warn(
                f"{data.source or 'hydrodynamic data'}: by the stiffness of {MODES[mode]} the waterplane has a "
                f"gyration radius of {radius:.3g} m, for a volume of {data.volume:.4g} m^3: is the stiffness about "
                "another point than the origin on the still water level, or has it the weight in it?",
                stacklevel=4,
            )


def _evidence(wave: _LongWave) -> str:
    """The numbers, for a person who must find out."""
    row = int(np.abs(np.cos(wave.heading)).argmax())
    found, expected = wave.X[row], wave.expected()[row]

    def shown(value: complex) -> str:
        return f"{value.real:.4g} {'-' if value.imag < 0 else '+'} {abs(value.imag):.4g}i"

    return (
        f" At {wave.omega:.4g} rad/s and heading {np.degrees(wave.heading[row]):.4g} deg X1 is {shown(found[0])} N/m "
        f"and X3 {shown(found[2])} N/m; the limit for long waves is {shown(expected[0])} and {shown(expected[2])}."
    )
