"""Hydrodynamic coefficients of a body that deforms: the rigid motions, and behind them its shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.components.hydro.database import HydrodynamicDatabase, at_heading, loads_between
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.stored_numbers import EXCITATION, excitation_of, missing_from, stored_numbers
from fowtlib.language.netcdf_files import add_variable, set_attributes, write_netcdf
from fowtlib.language.similarity import Similarity, six_by_six
from fowtlib.language.whole_files import write_whole

_SYMMETRY = 0.05  # largest |M_ij - M_ji| / sqrt(M_ii M_jj) of a believable matrix, as of a rigid body
_MIXED = "SI; of shapes per unit of their coordinate [m]"

# By what law a file's stiffness by buoyancy was made: none in the file, points of a section go straight on; 2, they go
# round it with the pressure (pressure_stiffness). Without that, what bends in deep water is too stiff.
_LAW, _LAW_NUMBER = "stiffness_law", 2

# name in the file: (attribute, dimensions, unit, meaning)
_VARIABLES = {
    "omega": ("omega", ("omega",), "rad/s", "wave frequency"),
    "heading": ("heading", ("heading",), "rad", "direction in which the waves travel, 0: along +x"),
    "added_mass": ("A", ("omega", "row", "column"), _MIXED, "added mass"),
    "radiation_damping": ("B", ("omega", "row", "column"), _MIXED, "radiation damping"),
    "added_mass_infinite": ("A_inf", ("row", "column"), _MIXED, "added mass at infinite frequency"),
    "added_mass_zero": ("A_zero", ("row", "column"), _MIXED, "added mass at the lowest frequency"),
    "hydrostatic_stiffness": ("C", ("rigid", "rigid"), "N/m, N, N m", "of the rigid motions, without weight"),
    "shape_stiffness": ("among", ("shape", "shape"), "N/m", "stiffness by buoyancy between shapes"),
    "shape_stiffness_rigid": ("with_rigid", ("shape", "rigid"), "N/m, N", "the same of shapes with rigid motions"),
    "node": ("nodes", ("node", "axis"), "m", "nodes of the structure at rest"),
    "shape": ("shapes", ("shape", "node", "rigid"), "m/m, rad/m", "displacement and turn of each node"),
    "water_at_rest": ("at_rest", ("node", "rigid"), "N, N m", "load of the water at rest on each node"),
    "displaced_volume": ("volume", (), "m^3", "displaced volume at rest"),
    "centre_of_buoyancy": ("centre_of_buoyancy", ("axis",), "m", "centre of the displaced volume at rest"),
    "water_density": ("rho", (), "kg/m^3", "water density"),
    "gravity": ("g", (), "m/s^2", "acceleration of gravity"),
    "water_depth": ("water_depth", (), "m", "water depth (inf: deep water)"),
}


@dataclass(frozen=True, eq=False)
class ModalDatabase:
    """Linear potential-flow coefficients about (0, 0, 0) on the still water level, of m = 6 + k motions.

    The first six are those of a HydrodynamicDatabase, with its conventions; the others are k shapes, each with a
    coordinate q [m] and the displacements `shapes` of the nodes of a structure per q.

    omega (n,), heading (nh,)   as there
    A, B                (n, m, m) added mass, radiation damping;  A_inf, A_zero (m, m)
    X                   (n, nh, m) complex, wave load per unit amplitude
    C                   (6, 6) stiffness of the rigid motions without weight
    among, with_rigid   (k, k) and (k, 6) stiffness of the shapes by buoyancy
    nodes, shapes       (p, 3) [m] and (k, p, 6)
    at_rest             (p, 6) [N, N m] load of the water at rest on each node; zero: shapes are from the hull at rest
    volume, centre_of_buoyancy, rho, g, water_depth, source   as there

    Checked when made: shapes, finite numbers, A and B symmetric within 5 % of sqrt(M_ii M_jj); `rigid` checks the rest.
    Raises HydrodynamicDataError. Source: J.N. Newman, Applied Ocean Research 16 (1994) 47-59.
    """

    omega: np.ndarray
    heading: np.ndarray
    A: np.ndarray
    B: np.ndarray
    A_inf: np.ndarray
    A_zero: np.ndarray
    X: np.ndarray
    C: np.ndarray
    among: np.ndarray
    with_rigid: np.ndarray
    nodes: np.ndarray
    shapes: np.ndarray
    at_rest: np.ndarray
    volume: float
    centre_of_buoyancy: np.ndarray
    rho: float
    g: float
    water_depth: float
    source: str = ""

    def __post_init__(self):
        n, nh, k, p = np.size(self.omega), np.size(self.heading), len(self.shapes), len(self.nodes)
        m = 6 + k
        expected = {
            "omega": (n,), "heading": (nh,), "A": (n, m, m), "B": (n, m, m), "A_inf": (m, m), "A_zero": (m, m),
            "X": (n, nh, m), "C": (6, 6), "among": (k, k), "with_rigid": (k, 6), "nodes": (p, 3), "shapes": (k, p, 6),
            "at_rest": (p, 6),
            "centre_of_buoyancy": (3,),
        }  # fmt: skip
        for name, shape in expected.items():
            value = np.array(getattr(self, name), dtype=complex if name == "X" else float)
            if value.shape != shape:
                raise self._error(f"{name} has the shape {value.shape}, expected {shape} for {k} shapes")
            if not np.isfinite(value).all():
                raise self._error(f"{name} is not finite everywhere")
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        for name in ("A", "B", "A_inf", "A_zero"):
            matrix = getattr(self, name).reshape(-1, m, m)
            size = np.sqrt(np.abs(np.einsum("nii->ni", matrix)).max(axis=0) + 1e-9 * np.abs(matrix).max())
            apart = np.abs(matrix - matrix.transpose(0, 2, 1)) / np.outer(size, size)
            if apart[:, 6:].size and apart[:, 6:].max() > _SYMMETRY:
                raise self._error(f"{name} of the shapes is not symmetric: take smaller panels")
        _ = self.rigid

    @property
    def count(self) -> int:
        """Number of shapes."""
        return len(self.shapes)

    @cached_property
    def rigid(self) -> HydrodynamicDatabase:
        """The six rigid motions alone."""
        return HydrodynamicDatabase(
            omega=self.omega, heading=self.heading, A=self.A[:, :6, :6], B=self.B[:, :6, :6], A_inf=self.A_inf[:6, :6],
            A_zero=self.A_zero[:6, :6], X=self.X[:, :, :6], C=self.C, volume=self.volume,
            centre_of_buoyancy=self.centre_of_buoyancy, rho=self.rho, g=self.g, water_depth=self.water_depth,
            source=self.source,
        )  # fmt: skip

    def __repr__(self):
        return f"ModalDatabase({self.count} shapes of {len(self.nodes)} nodes, {self.rigid!r})"

    def excitation_at(self, omega, heading: float) -> np.ndarray:
        """Complex wave load (n, 6 + k) per unit amplitude at frequencies [rad/s] and one heading [rad].

        As HydrodynamicDatabase.excitation_at; towards omega = 0 a shape is lifted as by a tide.
        """
        rigid = self.rigid.excitation_at(omega, heading)
        shapes = at_heading(self.heading, self.X[:, :, 6:], float(heading))
        asked = np.atleast_1d(np.asarray(omega, dtype=float))
        return np.hstack([rigid, loads_between(self.omega, shapes, self.with_rigid[:, 2], asked)])

    def first(self, count: int) -> ModalDatabase:
        """The same with the first shapes only."""
        kept = slice(0, 6 + count)
        return replace(
            self, A=self.A[:, kept, kept], B=self.B[:, kept, kept], A_inf=self.A_inf[kept, kept],
            A_zero=self.A_zero[kept, kept], X=self.X[:, :, kept], among=self.among[:count, :count],
            with_rigid=self.with_rigid[:count], shapes=self.shapes[:count],
        )  # fmt: skip

    ending = ".nc"

    def in_similarity(self, similarity: Similarity) -> ModalDatabase:
        """The data of the same hull in another scale, its water depth with it; a coordinate is a length."""
        one, mass, damping = similarity.factor, self._factors(similarity, "kg"), self._factors(similarity, "N*s/m")
        stiffness = self._factors(similarity, "N/m")
        rigid = stiffness[:6, :6]
        moved = np.array([1.0] * 3 + [one("rad/m")] * 3)
        return replace(
            self, omega=self.omega * one("rad/s"), A=self.A * mass, B=self.B * damping, A_inf=self.A_inf * mass,
            A_zero=self.A_zero * mass, X=self.X * stiffness[0], C=self.C * rigid, among=self.among * one("N/m"),
            with_rigid=self.with_rigid * rigid[0], nodes=self.nodes * one("m"), shapes=self.shapes * moved,
            at_rest=self.at_rest * np.array([one("N")] * 3 + [one("N*m")] * 3), volume=self.volume * one("m^3"),
            centre_of_buoyancy=self.centre_of_buoyancy * one("m"), rho=self.rho * one("kg/m^3"),
            water_depth=self.water_depth * one("m"),
        )  # fmt: skip

    def _factors(self, similarity: Similarity, unit: str) -> np.ndarray:
        """Factors (m, m) of a matrix over forces, moments, and the loads of shapes, which go as forces do."""
        return np.vectorize(similarity.factor, otypes=[float])(six_by_six(unit, self.count))

    def write(self, path: str | Path) -> None:
        """Write a netCDF file that `read` reads; every variable has a unit and a checksum. Raises WriteError."""

        def fill(file: Any) -> None:
            about = {"title": "fowtlib modal hydrodynamic database", "source": self.source or "unknown"}
            set_attributes(file, about)
            for name, (attribute, dimensions, unit, meaning) in _VARIABLES.items():
                add_variable(file, name, "d", dimensions, getattr(self, attribute), units=unit, long_name=meaning)
            for name, value in zip(EXCITATION, (self.X.real, self.X.imag), strict=True):
                add_variable(file, name, "d", ("omega", "heading", "row"), value, units=_MIXED, long_name="wave load")
            add_variable(file, _LAW, "d", (), _LAW_NUMBER, units="1", long_name="number of the law of shape_stiffness")

        write_whole(path, lambda temporary: write_netcdf(temporary, fill))

    @classmethod
    def read(cls, path: str | Path) -> ModalDatabase:
        """Read a file of `write`.

        Raises HydrodynamicDataError: damaged, of a rigid body, another file, or made with another law of the stiffness
        by buoyancy than that of now, which would bend the hull wrongly without a word.
        """
        data, source = stored_numbers(path)
        missing = missing_from(data, tuple(_VARIABLES))
        if missing:
            rigid = " It has the coefficients of a rigid hull." if "added_mass" in data and "shape" in missing else ""
            raise HydrodynamicDataError(
                f"{path}: the variable '{missing[0]}' is missing; this is not a file of ModalDatabase.write.{rigid}"
            )
        law = float(data.get(_LAW, 1.0))
        if law != _LAW_NUMBER:
            raise HydrodynamicDataError(f"{path}: {_other_law(law)}")
        fields: dict[str, Any] = {attribute: data[name] for name, (attribute, *_) in _VARIABLES.items()}
        for name in ("volume", "rho", "g", "water_depth"):
            fields[name] = float(fields[name])
        fields["X"] = excitation_of(data)
        try:
            return cls(**fields, source=source)
        except HydrodynamicDataError as error:
            raise HydrodynamicDataError(f"{path}: {error}") from None

    def _error(self, message: str) -> HydrodynamicDataError:
        return HydrodynamicDataError(f"modal hydrodynamic data{f' ({self.source})' if self.source else ''}: {message}")


def _other_law(law: float) -> str:
    """What is wrong with a file of another law, and what to do."""
    if law > _LAW_NUMBER:
        return (
            f"its stiffness by buoyancy is of law {law:g}, and this version of fowtlib knows {_LAW_NUMBER} at most; "
            "take the version that made it, or make it anew with this one."
        )
    return (
        "it was made before pressure went round the sections of a hull, and its shapes are too stiff in deep water. "
        "Make it anew, with the same `fowt hydro --shapes` or modal_database."
    )
