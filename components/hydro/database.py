"""Hydrodynamic coefficients of one floating body: the data that the potential-flow load is made of."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.components.hydro import wamit
from fowtlib.components.hydro.conventions import check_conventions
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.stored_numbers import EXCITATION, excitation_of, missing_from, stored_numbers
from fowtlib.components.hydro.wamit_writing import write_wamit
from fowtlib.language.cubics import between, makima_slopes
from fowtlib.language.netcdf_files import add_variable, set_attributes, write_netcdf
from fowtlib.language.similarity import Similarity, six_by_six
from fowtlib.language.whole_files import write_whole

_MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_SYMMETRY = 0.05  # largest |M_ij - M_ji| / sqrt(M_ii M_jj) of a believable matrix
_NEGATIVE = 1e-3  # negative damping, relative to the maximum of the same mode, that is forgiven in silence
_TOO_NEGATIVE = 1e-2  # the same, that is refused; published sets have some that is negative at short waves
_TAIL = 0.05  # |X| at the highest frequency, relative to its maximum, below which X is zero beyond
_SAME_OMEGA = 1e-5  # relative; periods in WAMIT files have six digits
_GAP = np.radians(60) + 1e-6  # headings further apart are not interpolated
_FULL_TURN = 2 * np.pi

# name in the file: (attribute, dimensions, unit, meaning)
_VARIABLES = {
    "omega": ("omega", ("omega",), "rad/s", "wave frequency"),
    "heading": ("heading", ("heading",), "rad", "direction in which the waves travel, 0: along +x"),
    "added_mass": ("A", ("omega", "row", "column"), "kg, kg m, kg m^2", "added mass"),
    "radiation_damping": ("B", ("omega", "row", "column"), "N s/m, N s, N m s", "radiation damping"),
    "added_mass_infinite": ("A_inf", ("row", "column"), "kg, kg m, kg m^2", "added mass at infinite frequency"),
    "added_mass_zero": ("A_zero", ("row", "column"), "kg, kg m, kg m^2", "added mass at zero frequency"),
    "hydrostatic_stiffness": ("C", ("row", "column"), "N/m, N, N m", "stiffness of buoyancy and waterplane, no weight"),
    "displaced_volume": ("volume", (), "m^3", "displaced volume at rest"),
    "centre_of_buoyancy": ("centre_of_buoyancy", ("axis",), "m", "centre of the displaced volume at rest"),
    "water_density": ("rho", (), "kg/m^3", "water density"),
    "gravity": ("g", (), "m/s^2", "acceleration of gravity"),
    "water_depth": ("water_depth", (), "m", "water depth (inf: deep water)"),
}


@dataclass(frozen=True, eq=False)
class HydrodynamicDatabase:
    """Linear potential-flow coefficients of a rigid body about the point (0, 0, 0) on the still water level.

    Row and column order surge, sway, heave, roll, pitch, yaw; SI units; x downwind, z up. The wave load is
    Re(a X exp(i omega t)) for the elevation a cos(omega t - k (x cos(heading) + y sin(heading))).

    omega               (n,) rad/s, rising, positive
    heading             (nh,) rad, rising
    A, B                (n, 6, 6) added mass, radiation damping
    A_inf, A_zero       (6, 6) limits of A; A_zero may be None
    X                   (n, nh, 6) complex, wave load per unit amplitude [N/m, N m/m]
    C                   (6, 6) buoyancy and waterplane terms only; the weight belongs to the bodies
    volume              m^3; centre_of_buoyancy (3,) m
    rho, g, water_depth kg/m^3, m/s^2, m
    source              one line on the origin of the data

    Checked when made: shapes, finite numbers, A and B symmetric within 5 % of sqrt(M_ii M_jj), no negative damping on
    the diagonal (0.1 % of the mode's maximum is forgiven, up to 1 % is warned of). Data from files and from the panel
    method must have the limit of long waves besides (module conventions). Raises HydrodynamicDataError. The arrays are
    read-only.

    Source: Newman, Marine Hydrodynamics (1977), chapter 6; Falnes, Ocean Waves and Oscillating Systems (2002), ch. 5.
    """

    omega: np.ndarray
    heading: np.ndarray
    A: np.ndarray
    B: np.ndarray
    A_inf: np.ndarray
    A_zero: np.ndarray | None
    X: np.ndarray
    C: np.ndarray
    volume: float
    centre_of_buoyancy: np.ndarray
    rho: float
    g: float
    water_depth: float
    source: str = ""

    def __post_init__(self):
        n, nh = np.size(self.omega), np.size(self.heading)
        shapes = {"omega": (n,), "heading": (nh,), "A": (n, 6, 6), "B": (n, 6, 6), "A_inf": (6, 6), "A_zero": (6, 6),
                  "X": (n, nh, 6), "C": (6, 6), "centre_of_buoyancy": (3,)}
        for name, shape in shapes.items():
            if name == "A_zero" and self.A_zero is None:
                continue
            value = np.array(getattr(self, name), dtype=complex if name == "X" else float)
            if value.shape != shape:
                raise self._error(f"{name} has the shape {value.shape}, expected {shape}")
            if not np.isfinite(value).all():
                where = tuple(int(i) for i in np.argwhere(~np.isfinite(value))[0])
                raise self._error(f"{name}{list(where)} is not finite")
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        for name in ("volume", "rho", "g", "water_depth"):
            value = float(getattr(self, name))
            if not value > 0 or (name != "water_depth" and value == np.inf):
                raise self._error(f"{name} must be positive, found {value:g}")
            object.__setattr__(self, name, value)
        self._check()

    def __repr__(self):
        return (f"HydrodynamicDatabase({self.omega.size} frequencies {self.omega[0]:.3g}..{self.omega[-1]:.3g} rad/s, "
                f"{self.heading.size} headings, volume {self.volume:.6g} m^3, depth {self.water_depth:g} m)")

    @classmethod
    def from_wamit(cls, stem: str | Path, *, volume: float, centre_of_buoyancy, rho: float, g: float,
                   water_depth: float, length: float = 1.0, source: str = "") -> HydrodynamicDatabase:
        """Read `stem`.1, `stem`.3 and `stem`.hst (see the module wamit for their conventions, which are checked).

        volume [m^3] and centre_of_buoyancy [m] stand in the .out file of WAMIT only; length [m] is ULEN of the run.
        """
        stem = str(stem)
        radiation = wamit.read_radiation(stem + ".1", rho=rho, length=length)
        excitation = wamit.read_excitation(stem + ".3", rho=rho, g=g, length=length)
        if radiation.A_inf is None:
            raise HydrodynamicDataError(
                f"{stem}.1: no lines for infinite frequency (PER = 0); the time domain needs this limit, "
                "run WAMIT with the period 0 as well")
        if not _same(radiation.omega, excitation.omega):
            raise HydrodynamicDataError(
                f"{stem}.3: its periods ({_range(excitation.omega)}) are not those of {stem}.1 "
                f"({_range(radiation.omega)}); both must come from the same WAMIT run")
        C = wamit.read_hydrostatics(stem + ".hst", rho=rho, g=g, length=length)
        data = cls(omega=radiation.omega, heading=excitation.heading, A=radiation.A, B=radiation.B,
                   A_inf=radiation.A_inf, A_zero=radiation.A_zero, X=excitation.X, C=C, volume=volume,
                   centre_of_buoyancy=centre_of_buoyancy, rho=rho, g=g, water_depth=water_depth,
                   source=source or f"WAMIT {Path(stem).name}")
        return data._checked(stem)

    def to_wamit(self, stem: str | Path, *, length: float = 1.0) -> list[Path]:
        """Write `stem`.1, `stem`.3 and `stem`.hst (see the module wamit_writing); what was written.

        length [m] is ULEN, which whoever reads the files must give again, with rho, g, volume and centre of buoyancy.
        """
        return write_wamit(self, stem, length=length)

    @classmethod
    def read(cls, path: str | Path) -> HydrodynamicDatabase:
        """Read a netCDF file that `write` has made; one that has changed since is refused.

        Files of earlier versions have no checksums, and are believed. Raises HydrodynamicDataError.
        """
        stored, source = stored_numbers(path)
        missing = missing_from(stored, [name for name in _VARIABLES if name != "added_mass_zero"])
        if missing:
            raise HydrodynamicDataError(f"{path}: the variable '{missing[0]}' is missing; "
                                        "this is not a file of HydrodynamicDatabase.write")
        fields: dict[str, Any] = {attribute: stored.get(name) for name, (attribute, *_) in _VARIABLES.items()}
        fields["X"] = excitation_of(stored)
        try:
            data = cls(**fields, source=source)
        except HydrodynamicDataError as error:
            raise HydrodynamicDataError(f"{path}: {error}") from None
        return data._checked(path)

    def _checked(self, place: str | Path) -> HydrodynamicDatabase:
        """The same, once its conventions are known to be right. Raises HydrodynamicDataError with its place."""
        try:
            check_conventions(self)
        except HydrodynamicDataError as error:
            raise HydrodynamicDataError(f"{place}: {error}") from None
        return self

    def write(self, path: str | Path) -> None:
        """Write a netCDF file (format 3) that `read` reads; units are attributes, every variable has a checksum.

        A file that is there is replaced in one step, when the new one is whole. Raises WriteError.
        """
        conventions = (
            "about the point (0, 0, 0) on the still water level; x downwind, y to port, z up; "
            f"modes {', '.join(_MODES)}; loads are Re(a X exp(+i omega t)), a wave of zero phase at the origin"
        )
        title = "fowtlib hydrodynamic database"

        def fill(file: Any) -> None:
            set_attributes(file, {"title": title, "conventions": conventions, "source": self.source or "unknown"})
            for name, (attribute, dimensions, unit, meaning) in _VARIABLES.items():
                value = getattr(self, attribute)
                if value is not None:
                    add_variable(file, name, "d", dimensions, value, units=unit, long_name=meaning)
            about = {"units": "N/m, N m/m", "long_name": "wave load per unit amplitude"}
            for name, value in zip(EXCITATION, (self.X.real, self.X.imag), strict=True):
                add_variable(file, name, "d", ("omega", "heading", "mode"), value, **about)

        write_whole(path, lambda temporary: write_netcdf(temporary, fill))

    ending = ".nc"

    def in_similarity(self, similarity: Similarity) -> HydrodynamicDatabase:
        """The data of the same hull in another scale, its water depth with it."""
        one = similarity.factor
        mass, damping, stiffness = (_factors(similarity, unit) for unit in ("kg", "N*s/m", "N/m"))
        return replace(
            self, omega=self.omega * one("rad/s"), A=self.A * mass, B=self.B * damping, A_inf=self.A_inf * mass,
            A_zero=None if self.A_zero is None else self.A_zero * mass, X=self.X * stiffness[0], C=self.C * stiffness,
            volume=self.volume * one("m^3"), centre_of_buoyancy=self.centre_of_buoyancy * one("m"),
            rho=self.rho * one("kg/m^3"), water_depth=self.water_depth * one("m"),
        )  # fmt: skip

    def nearest_heading(self, heading: float = 0.0) -> int:
        """The number of the heading of the data that is nearest to a heading [rad], all round."""
        return int(np.argmin(np.abs(np.mod(self.heading - heading + np.pi, 2 * np.pi) - np.pi)))

    def excitation_at(self, omega, heading: float) -> np.ndarray:
        """Complex wave load (n, 6) per unit amplitude at the frequencies omega [rad/s] and one heading [rad].

        Heading: any real number; cubic spline, periodic if the data go all round; a heading between two headings of
        the data that are more than 60 deg apart is refused. Frequency: Akima interpolation of the real and imaginary
        parts.

        Below the data: towards omega = 0 a long wave lifts the water like a tide, so X tends to the third column of C
        (heave C33) and is interpolated from there. Above the data: zero for a mode whose |X| has decayed to 5 % of its
        maximum at the last frequency; else refused. Raises HydrodynamicDataError.
        """
        omega = np.atleast_1d(np.asarray(omega, dtype=float))
        if omega.ndim != 1 or not np.isfinite(omega).all() or (omega < 0).any():
            raise HydrodynamicDataError("excitation: the frequencies must be finite numbers, not negative")
        X = at_heading(self.heading, self.X, float(heading))
        if (omega > self.omega[-1] * (1 + _SAME_OMEGA)).any():
            self._check_tail(float(omega.max()))
        return loads_between(self.omega, X, self.C[:, 2], omega)

    def _check_tail(self, wanted: float) -> None:
        largest = np.abs(self.X).max(axis=(0, 1))
        tail = np.abs(self.X[-1]).max(axis=0)
        size = self.rho * self.g * self.volume ** np.array([2 / 3] * 3 + [1.0] * 3)
        for mode, name in enumerate(_MODES):
            if largest[mode] > 1e-6 * size[mode] and tail[mode] > _TAIL * largest[mode]:
                raise HydrodynamicDataError(
                    f"excitation: the frequency {wanted:.4g} rad/s is above the data, which end at "
                    f"{self.omega[-1]:.4g} rad/s, and the load in {name} has not decayed there "
                    f"({tail[mode] / largest[mode]:.0%} of its maximum); compute the loads up to there, "
                    f"for example `fowt hydro MODEL --omega 0.1:{np.ceil(wanted * 10) / 10:g}:0.1`")

    def _check(self) -> None:
        if self.omega.size < 2 or (self.omega <= 0).any() or (np.diff(self.omega) <= 0).any():
            raise self._error("omega must be positive and rising, with two frequencies at least")
        if self.heading.size < 1 or (np.diff(self.heading) <= 0).any():
            raise self._error("heading must be rising, with one heading at least")
        turns = self.heading[-1] - self.heading[0] - _FULL_TURN
        if turns > 1e-6:
            raise self._error(f"the headings span {np.degrees(turns + _FULL_TURN):.6g} deg, more than a full turn; "
                              "they must be in rad")
        if abs(turns) <= 1e-6 and np.abs(self.X[:, 0] - self.X[:, -1]).max() > 1e-3 * np.abs(self.X).max():
            raise self._error("the first and the last heading are the same direction, but X differs")
        length = np.array([1.0] * 3 + [self.volume ** (1 / 3)] * 3)
        floor = 1e-6 * self.rho * self.volume * length**2  # below it a coefficient is numerical noise
        self._check_symmetry("A", self.A, floor)
        self._check_symmetry("A_inf", self.A_inf[None], floor)
        if self.A_zero is not None:
            self._check_symmetry("A_zero", self.A_zero[None], floor)
        self._check_symmetry("B", self.B, floor * self.omega[-1])
        diagonal = np.einsum("nii->ni", self.B)
        largest = np.maximum(diagonal.max(axis=0), 0.0)
        part = -diagonal / np.maximum(largest, floor * self.omega[-1])
        worst = np.where(diagonal < -_NEGATIVE * largest - floor * self.omega[-1], part, 0.0)
        if worst.any():
            k, i = np.unravel_index(int(worst.argmax()), worst.shape)
            error = self._error(f"the radiation damping of {_MODES[i]} is negative at {self.omega[k]:.4g} rad/s "
                                f"({diagonal[k, i]:.4g}, {worst[k, i]:.2g} of its maximum): irregular frequency or too "
                                "coarse a mesh?")
            if worst[k, i] > _TOO_NEGATIVE:
                raise error
            warnings.warn(str(error), stacklevel=5)

    def _check_symmetry(self, name: str, M: np.ndarray, floor: np.ndarray) -> None:
        size = np.sqrt(np.abs(np.einsum("nii->ni", M)).max(axis=0) + floor)
        error = np.abs(M - M.transpose(0, 2, 1)) / np.outer(size, size)
        if error.max() > _SYMMETRY:
            k, i, j = np.unravel_index(int(error.argmax()), error.shape)
            at = f" at {self.omega[k]:.4g} rad/s" if M.shape[0] > 1 else ""
            raise self._error(f"{name} is not symmetric{at}: ({i + 1}, {j + 1}) is {M[k, i, j]:.5g}, "
                              f"({j + 1}, {i + 1}) is {M[k, j, i]:.5g} (allowed: {_SYMMETRY:.0%} of the diagonal)")

    def _error(self, message: str) -> HydrodynamicDataError:
        return HydrodynamicDataError(f"hydrodynamic data{f' ({self.source})' if self.source else ''}: {message}")


def _factors(similarity: Similarity, unit: str) -> np.ndarray:
    """Factors (6, 6) of a matrix over forces and moments."""
    return np.vectorize(similarity.factor, otypes=[float])(six_by_six(unit))


def loads_between(known: np.ndarray, X: np.ndarray, tide: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Loads X (n, m) of the frequencies `known` at others [rad/s]; tide (m,): at zero frequency; zero above."""
    beyond, inside = omega > known[-1] * (1 + _SAME_OMEGA), np.minimum(omega, known[-1])
    x, y = np.concatenate([[0.0], known]), np.vstack([tide.astype(complex)[None, :], X])
    values = _interpolate(x, y.real, inside) + 1j * _interpolate(x, y.imag, inside)
    values[beyond] = 0.0
    return values


def at_heading(headings: np.ndarray, X: np.ndarray, heading: float) -> np.ndarray:
    """Loads (n, m) at a heading [rad] from those X (n, nh, m) at some; see HydrodynamicDatabase.excitation_at."""
    if not np.isfinite(heading):
        raise HydrodynamicDataError("excitation: the heading must be a finite number")
    known = np.mod(headings, _FULL_TURN)
    known[_FULL_TURN - known < 1e-9] = 0.0
    known, index = np.unique(np.round(known, 9), return_index=True)
    X = X[:, index, :]
    wanted = float(np.mod(heading, _FULL_TURN))
    offset = np.abs(np.mod(known - wanted + np.pi, _FULL_TURN) - np.pi)
    if offset.min() < 1e-6:
        return X[:, int(offset.argmin()), :]
    start = float(known[int(np.diff(np.append(known, known[0] + _FULL_TURN)).argmax()) + 1 - known.size])
    order = np.argsort(np.mod(known - start, _FULL_TURN))  # the widest gap comes last
    angle = np.append(np.mod(known - start, _FULL_TURN)[order], _FULL_TURN)
    X = X[:, np.append(order, order[0]), :]
    position = float(np.mod(wanted - start, _FULL_TURN))
    wide = np.diff(angle) > _GAP
    after = int(np.searchsorted(angle, position))
    if wide[after - 1]:
        before, behind = np.degrees(start + angle[[after - 1, after]]) % 360
        raise HydrodynamicDataError(
            f"excitation: the heading {np.degrees(heading):.6g} deg is outside of the data: there is none between "
            f"{before:.6g} and {behind:.6g} deg; compute the missing headings")
    from scipy.interpolate import CubicSpline  # asked for seldom, and it takes long to import

    if not wide.any():
        return CubicSpline(angle, X, axis=1, bc_type="periodic")(position)
    ends = np.flatnonzero(np.concatenate([[True], wide, [True]]))  # runs of headings between wide gaps
    run = slice(ends[ends < after].max(), ends[ends >= after].min())
    return CubicSpline(angle[run], X[:, run], axis=1)(position)


def _interpolate(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    return between(x, y, makima_slopes(x, y), at)


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and bool(np.allclose(a, b, rtol=_SAME_OMEGA, atol=0.0))


def _range(omega: np.ndarray) -> str:
    return f"{omega.size} values, {2 * np.pi / omega[-1]:.4g} to {2 * np.pi / omega[0]:.4g} s"
