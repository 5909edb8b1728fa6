"""Distributed properties of a beam: the table behind a tower, a blade or an arm. NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.data_files import cells_of, lines_of, remembered
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.language.similarity import Similarity

COLUMNS = {
    "z_m": "z",
    "mass_per_length_kg_per_m": "mass_per_length",
    "bending_stiffness_fore_aft_N_m2": "stiffness_x",
    "bending_stiffness_flapwise_N_m2": "stiffness_x",
    "bending_stiffness_side_side_N_m2": "stiffness_y",
    "bending_stiffness_edgewise_N_m2": "stiffness_y",
    "torsional_stiffness_N_m2": "torsional_stiffness",
    "axial_stiffness_N": "axial_stiffness",
    "structural_twist_deg": "twist",
    "rotary_inertia_flapwise_kg_m": "rotary_inertia_x",
    "rotary_inertia_edgewise_kg_m": "rotary_inertia_y",
    "reference_x_m": "reference_x",
    "reference_y_m": "reference_y",
    "centre_of_mass_x_m": "centre_of_mass_x",
    "centre_of_mass_y_m": "centre_of_mass_y",
    "outer_diameter_m": "outer_diameter",
    "wall_thickness_m": "wall_thickness",
}
REQUIRED = ("mass_per_length", "stiffness_x", "stiffness_y")
POSITIVE = ("stiffness_x", "stiffness_y", "torsional_stiffness", "axial_stiffness")


@dataclass(frozen=True, eq=False)
class BeamProperties:
    """Properties along a beam whose axis is z; between the stations they are linear.

    z (n,) [m] increases from the root to the tip. x and y are the directions in which the beam bends: `stiffness_x` is
    EI of bending that moves the tip along x (fore-aft, flapwise), `rotary_inertia_x` [kg m] the inertia per length that
    goes with it (about the y axis). `twist` [rad] turns these principal axes about -z, as the structural twist of a
    blade does (leading edge upwind). `reference` is the place of the elastic axis off the z axis (prebend, sweep),
    `centre_of_mass` that of the mass off the elastic axis, along the principal axes. A property that is None is
    unknown; the others of the last three rows are zero.
    """

    z: np.ndarray
    mass_per_length: np.ndarray
    stiffness_x: np.ndarray
    stiffness_y: np.ndarray
    torsional_stiffness: np.ndarray | None = None
    axial_stiffness: np.ndarray | None = None
    twist: np.ndarray | float = 0.0
    rotary_inertia_x: np.ndarray | float = 0.0
    rotary_inertia_y: np.ndarray | float = 0.0
    reference_x: np.ndarray | float = 0.0
    reference_y: np.ndarray | float = 0.0
    centre_of_mass_x: np.ndarray | float = 0.0
    centre_of_mass_y: np.ndarray | float = 0.0

    def __post_init__(self) -> None:
        z = np.asarray(self.z, dtype=float)
        if z.ndim != 1 or len(z) < 2 or not np.all(np.isfinite(z)) or not np.all(np.diff(z) > 0):
            raise ParameterError("the stations of a beam must increase from root to tip, two or more.")
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if value is None:
                continue
            try:
                column = np.broadcast_to(np.asarray(value, dtype=float), z.shape)
            except ValueError:
                raise ParameterError(f"{name} of a beam: {np.size(value)} values for {len(z)} stations.") from None
            wrong = {True: column <= 0, False: (column < 0) & (name == "mass_per_length")}[name in POSITIVE]
            bad = ~np.isfinite(column) | wrong
            if bad.any():
                raise ParameterError(f"{name} of a beam is {column[bad][0]:g} at z = {z[bad][0]:g} m.")
            object.__setattr__(self, name, column)

    @property
    def length(self) -> float:
        """From root to tip along z [m]."""
        return float(self.z[-1] - self.z[0])

    @cached_property
    def distances(self) -> np.ndarray:
        """Of the stations from the root [m]."""
        return self.z - self.z[0]

    def at(self, name: str, s: Any) -> np.ndarray:
        """A property at the distance s [m] from the root."""
        return np.interp(s, self.distances, getattr(self, name))

    def outline(self, s: Any) -> tuple[np.ndarray, np.ndarray]:
        """Sizes [m] along the principal axes x and y at the distance s, for pictures: estimates from the inertia.

        A thin-walled round tube of diameter D has the radius of gyration D / sqrt(8); the chord of a blade is about 4
        radii of gyration (the NREL 5 MW: within 15 %). Without rotary inertia, from EI / mass, as of steel.
        """
        radii = []
        for axis in "xy":
            rotary = self.at(f"rotary_inertia_{axis}", s)
            steel = self.at(f"stiffness_{axis}", s) / (210e9 / 8500.0)
            mass = np.maximum(self.at("mass_per_length", s), 1e-12)
            radii.append(np.sqrt(np.where(rotary > 0, rotary, steel) / mass))
        x, y = np.sqrt(8) * radii[0], np.sqrt(8) * radii[1]
        flat = np.clip((0.95 - x / y) / 0.35, 0, 1)
        return x, y * (1 + 0.41 * flat)

    def scaled(self, mass: float = 1.0, stiffness: float = 1.0) -> BeamProperties:
        """The same beam with other mass (and rotary inertia) and other stiffness."""
        factors = dict.fromkeys(("mass_per_length", "rotary_inertia_x", "rotary_inertia_y"), mass)
        factors |= dict.fromkeys(POSITIVE, stiffness)
        columns = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return BeamProperties(**{n: v if v is None else v * factors.get(n, 1.0) for n, v in columns.items()})

    ending = ".csv"

    def in_similarity(self, similarity: Similarity) -> BeamProperties:
        """The beam of a model in another scale: EI as N m^2."""
        units = {
            "z": "m", "mass_per_length": "kg/m", "stiffness_x": "N*m^2", "stiffness_y": "N*m^2",
            "torsional_stiffness": "N*m^2", "axial_stiffness": "N", "twist": "rad", "rotary_inertia_x": "kg*m",
            "rotary_inertia_y": "kg*m", "reference_x": "m", "reference_y": "m", "centre_of_mass_x": "m",
            "centre_of_mass_y": "m",
        }  # fmt: skip
        columns = {name: (getattr(self, name), similarity.factor(unit)) for name, unit in units.items()}
        return BeamProperties(**{n: None if value is None else value * f for n, (value, f) in columns.items()})

    def write(self, path: str | Path) -> None:
        """Write a CSV that read_beam reads. Raises WriteError."""
        columns: dict[str, np.ndarray] = {}
        for head, name in COLUMNS.items():
            value = getattr(self, name, None)
            if value is not None and name not in {COLUMNS[known] for known in columns}:
                columns[head] = np.degrees(value) if name == "twist" else value
        rows = [",".join(f"{value:.17g}" for value in row) for row in zip(*columns.values(), strict=True)]
        write_text(path, "\n".join([",".join(columns), *rows]) + "\n")

    def mirrored(self) -> BeamProperties:
        """The mirror image, y to -y: the blade of a rotor that turns the other way."""
        columns = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return BeamProperties(**columns | {n: -columns[n] for n in ("twist", "reference_y", "centre_of_mass_y")})

    @classmethod
    def uniform(cls, length: float, mass_per_length: float, stiffness_x: float, stiffness_y: float | None = None,
                **others: float) -> BeamProperties:  # fmt: skip
        """The same section from z = 0 to `length`."""
        stiffness_y = stiffness_x if stiffness_y is None else stiffness_y
        return cls(np.array([0.0, length]), mass_per_length, stiffness_x, stiffness_y, **others)

    @classmethod
    def tube(cls, z: Any, outer_diameter: Any, wall_thickness: Any, *, density: float = 8500.0,
             young_modulus: float = 210e9, shear_modulus: float = 80.8e9,
             stations: int = 41) -> BeamProperties:  # fmt: skip
        """A round tube; diameter and wall are linear between the given heights. Default: steel with paint and bolts.

        Default material: J. Jonkman et al. (2009), NREL/TP-500-38060, chapter 6.
        """
        given = [np.asarray(values, dtype=float) for values in (z, outer_diameter, wall_thickness)]
        if len({len(values) for values in given}) != 1 or len(given[0]) < 2:
            raise ParameterError("heights, outer diameters and walls of a tube: as many of each, two or more.")
        if not np.all(np.diff(given[0]) > 0):
            raise ParameterError("the heights of a tube must increase from root to tip.")
        fine = np.union1d(given[0], np.linspace(given[0][0], given[0][-1], stations))
        outer, wall = (np.interp(fine, given[0], values) for values in given[1:])
        if np.any(wall <= 0) or np.any(2 * wall > outer):
            raise ParameterError("the wall of a tube must be thicker than zero and at most half the diameter.")
        inner = outer - 2 * wall
        area, second_moment = np.pi / 4 * (outer**2 - inner**2), np.pi / 64 * (outer**4 - inner**4)
        EI, rotary = young_modulus * second_moment, density * second_moment
        return cls(fine, density * area, EI, EI, 2 * shear_modulus * second_moment, young_modulus * area,
                   rotary_inertia_x=rotary, rotary_inertia_y=rotary)  # fmt: skip


def given_beam(component: Any) -> BeamProperties:
    """The beam of a component by its parameters `properties`, a CSV or BeamProperties, or `table`, BeamProperties."""
    given, table = component.properties, component.table
    if (given is None) == (table is None):
        raise ParameterError(f"{component.label}: give properties, the path of a CSV, or table, BeamProperties.")
    if table is not None and not isinstance(table, BeamProperties):
        raise ParameterError(f"{component.label}.table is a {type(table).__name__}; BeamProperties are expected.")
    return given if given is not None else table


@remembered()
def read_beam(path: str) -> BeamProperties:
    """Read a CSV with the columns of COLUMNS; lines that start with # are comments.

    Required: z_m, the mass and both bending stiffnesses. Outer diameter and wall thickness of a tube, where given, make
    its rotary inertia. Raises ModelError with the path for a column that is missing, unknown or not a number.
    """
    lines = lines_of(path, "the properties of a beam", ModelError)
    if len(lines) < 3:
        raise ModelError(f"{path}: a beam needs two stations or more.")
    header = cells_of(lines[0][1])
    rows = [dict(zip(header, cells_of(line), strict=False)) for _, line in lines[1:]]
    unknown = [name for name in header if name not in COLUMNS]
    if unknown:
        raise ModelError(f"{path}: unknown column '{unknown[0]}'; known are {', '.join(COLUMNS)}.")
    try:
        table = {COLUMNS[name]: np.array([float(row[name]) for row in rows]) for name in header}
    except (KeyError, ValueError) as error:
        raise ModelError(f"{path}: a value is missing or not a number ({error}).") from None
    missing = [name for name in ("z", *REQUIRED) if name not in table]
    if missing:
        columns = [column for column, name in COLUMNS.items() if name == missing[0]]
        raise ModelError(f"{path}: the column {' or '.join(columns)} is missing.")
    falls = np.flatnonzero(~(np.diff(table["z"]) > 0))
    if falls.size:
        last, first = (f"{table['z'][falls[0] + k]:g} m" for k in (0, 1))
        place = lines[falls[0] + 2][0]
        raise ModelError(
            f"{path}:{place}: the stations of a beam must increase from root to tip; {last} is followed by {first}."
        )
    if "twist" in table:
        table["twist"] = np.radians(table["twist"])
    outer, wall = table.pop("outer_diameter", None), table.pop("wall_thickness", None)
    if outer is not None and wall is not None:
        rotary = table["mass_per_length"] * (outer**2 + (outer - 2 * wall) ** 2) / 16
        table = {"rotary_inertia_x": rotary, "rotary_inertia_y": rotary} | table
    try:
        return BeamProperties(**table)
    except ParameterError as error:
        raise ModelError(f"{path}: {error}") from None
