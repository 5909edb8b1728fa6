"""Full-field turbulence by Veers' method, written as a `.bts` file. Plain numpy and scipy's FFT.

At each harmonic k/T the amplitudes at the points of the grid are H(f) times random phases, where H H^T is the coherence
matrix of the points, times the root of the variance of the harmonic's band. So each point has the target spectrum, each
pair the target coherence, and the field is periodic with T. IEC gives a coherence for u; v and w are independent from
point to point, as in TurbSim, unless `lateral_coherence` is "iec", which uses that of u for them as well (an average of
v or w over a rotor then is not as small). The components are independent of each other.

What keeps it fast: where even neighbours have a coherence below LEAST_COHERENCE the points are taken as independent,
which is most of the harmonics; below, the symmetry of the grid (field_spectra.PlaneCoherence). What keeps it small: the
series are made for a block of points at a time, and where all of them are more than KEPT twice: for the range of int16
first, then for the file.

Variance of frequencies below 1/(2 T) and above the Nyquist frequency is not in the field, and not made up for.

Sources: P.S. Veers, SAND88-0152 (1988); IEC 61400-1 ed. 3 (2005), 6.3.1.2, 6.3.1.3, annex B; B.J. Jonkman, TurbSim
User's Guide v2.00 (NREL, 2014).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.environment.field_file import (
    COMPONENTS,
    FieldGrid,
    WindField,
    check_grid,
    encode,
    lay_out,
    read_field,
    scale,
)
from fowtlib.components.environment.field_spectra import PlaneCoherence, band_variance
from fowtlib.components.environment.iec import TURBULENCE_CLASSES, normal_turbulence
from fowtlib.components.environment.turbulence import coherence, power_law
from fowtlib.language.errors import ParameterError
from fowtlib.language.whole_files import write_whole

Floats = NDArray[np.float64]

FLUCTUATING = ("uvw", "uv", "uw", "u")
"""Components of a field that may fluctuate together."""

LEAST_COHERENCE = 1e-3
LARGEST_GRID = 20_000  # points; a block of the coherence matrix has (points / 4)^2 numbers
BLOCK = 32 * 2**20  # bytes of the numbers that are worked on at a time, about
KEPT = 128 * 2**20  # bytes of the series of a field that are kept between the range and the file
CACHE = 2 * 2**20  # bytes of the coherence matrices of a few harmonics; beyond a cache they take twice the time


def generate_field(
    path: str | Path,
    *,
    mean_speed: float,
    width: float,
    height: float,
    columns: int,
    rows: int,
    duration: float = 600.0,
    time_step: float = 0.05,
    hub_height: float = 90.0,
    bottom: float | None = None,
    spectrum: str = "kaimal",
    turbulence_class: str = "B",
    turbulence_intensity: float | None = None,
    shear_exponent: float = 0.2,
    lateral_coherence: str = "none",
    components: str = "uvw",
    seed: int = 1,
    progress: Callable[[float, float], None] | None = None,
) -> WindField:
    """Write a turbulent wind field to `path` (.bts) and open it.

    mean_speed V [m/s] at hub_height [m], power law with shear_exponent; sigma_1 by the normal turbulence model of class
    A+, A, B or C, or turbulence_intensity V. The grid is `width` x `height` [m], of columns x rows points, about y = 0;
    it is centred at the hub unless the lowest row is to be at `bottom` [m]. For several rotors make it as wide as all
    of them and their motion. The field repeats itself after `duration` [s], in steps of `time_step` [s].
    spectrum: "kaimal" or "von_karman"; lateral_coherence: "none" or "iec", see the module. components: those
    that fluctuate; the others are those of the mean wind, and these are the same. A seed gives one field.
    progress is told the part of the work that is done, and 1. The file appears, or is replaced, when it is complete.
    """
    low = hub_height - height / 2 if bottom is None else bottom
    spacing = height / max(rows - 1, 1), width / max(columns - 1, 1)
    steps = round(duration / time_step) if time_step > 0 else 0
    note = f"fowtlib: {spectrum}, V = {mean_speed:g} m/s, shear {shear_exponent:g}, seed {seed}"
    grid = FieldGrid(rows, columns, steps, *spacing, time_step, mean_speed, hub_height, low, description=note)
    _check(path, grid, turbulence_class, lateral_coherence)
    if components not in FLUCTUATING:
        raise ParameterError(f"{path}: cannot generate the wind field: components '{components}' is not one of "
                             f"{', '.join(FLUCTUATING)}.")  # fmt: skip
    if seed < 0 or (turbulence_intensity or 0) < 0:
        raise ParameterError(f"{path}: cannot generate the wind field: seed and turbulence_intensity begin at 0.")
    sigma = normal_turbulence(mean_speed, turbulence_class)
    if turbulence_intensity is not None:
        sigma = turbulence_intensity * mean_speed
    told = progress or (lambda done, total: None)
    turbulence = _Turbulence(grid, sigma, spectrum, shear_exponent, lateral_coherence == "iec", components, seed, told)
    kept, low_high = [], []
    for points, block in turbulence.blocks(1 / 3):
        low_high.append([(component.min(), component.max()) for component in block])
        kept += [(points, block)] if 12 * grid.points * grid.steps <= KEPT else []
    lowest, highest = np.array(low_high, dtype=np.float32).transpose(2, 0, 1)
    slope, offset = scale(lowest.min(axis=0), highest.max(axis=0))
    scaled = replace(grid, slope=slope, offset=offset)
    check_grid(path, scaled)

    def fill(temporary: Path) -> None:
        new = lay_out(temporary, scaled)
        told(2 / 3, 1)
        for points, block in kept or turbulence.blocks(2 / 3):
            for k, component in enumerate(block):
                numbers = encode(component, np.float32(slope[k]), np.float32(offset[k])).T
                for start, stored in new.blocks():
                    stored[:, points, k] = numbers[start : start + len(stored)]
                    del stored
        new.stored.flush()

    write_whole(path, fill)
    return read_field(path)


@dataclass(eq=False)
class _Turbulence:
    """The series of a field, a block of points at a time."""

    grid: FieldGrid
    sigma: float
    spectrum: str
    shear_exponent: float
    lateral: bool
    components: str
    seed: int
    told: Callable[[float, float], None]

    def __post_init__(self) -> None:
        grid = self.grid
        self.harmonics = (grid.steps - 1) // 2
        self.frequency = np.arange(1, self.harmonics + 1) / grid.duration
        wind = (grid.speed, self.sigma, grid.hub_height)
        variance = band_variance(self.harmonics, grid.duration, *wind, model=self.spectrum)
        self.amplitude = (grid.steps * np.sqrt(variance / 2)).astype(np.float32).T  # irfft divides by steps, halves
        self.amplitude[[name not in self.components for name in COMPONENTS]] = 0.0
        self.mean = np.repeat(power_law(grid.speed, grid.hub_height, grid.z, self.shear_exponent), grid.columns)
        self.coherent = self._coherent_noise()

    def _coherent_noise(self) -> NDArray[np.complex64]:
        """H(f) times random phases at the harmonics where neighbours are coherent: (components, points, harmonics)."""
        grid, components = self.grid, 3 if self.lateral else 1
        sides = [d for d, n in ((grid.dz, grid.rows), (grid.dy, grid.columns)) if n > 1]
        alike = coherence(self.frequency, min(sides, default=np.inf), grid.speed, grid.hub_height) if sides else []
        count = int(np.count_nonzero(np.asarray(alike) > LEAST_COHERENCE))
        result = np.empty((components, grid.points, count), dtype=np.complex64)
        plane = PlaneCoherence(grid.rows, grid.columns, grid.dz, grid.dy, grid.speed, grid.hub_height)
        random = np.random.default_rng([self.seed, 0])
        batch = max(1, min(BLOCK, CACHE) // (8 * (grid.points // 4 + 1) ** 2))
        for start in range(0, count, batch):
            self.told(start / count / 3, 1)
            f = self.frequency[start : min(start + batch, count)]
            noise = np.exp(2j * np.pi * random.random((len(f), grid.points, components)))
            result[:, :, start : start + len(f)] = plane.apply(f, noise).transpose(2, 1, 0)
        return result

    def blocks(self, done: float) -> Iterator[tuple[slice, list[NDArray[np.float32]]]]:
        """Speeds u, v, w [m/s] of a block of points, (points, steps) each; `done` is the part of all work before it."""
        size = max(1, BLOCK // (12 * self.grid.steps))
        for start in range(0, self.grid.points, size):
            self.told(done + start / self.grid.points / 3, 1)
            points = slice(start, min(start + size, self.grid.points))
            series = [self._fluctuation(component, points) for component in range(3)]
            series[0] += self.mean[points, None].astype(np.float32)
            yield points, series

    def _fluctuation(self, component: int, points: slice) -> NDArray[np.float32]:
        from scipy.fft import irfft  # keeps float32

        half = np.zeros((points.stop - points.start, self.grid.steps // 2 + 1), dtype=np.complex64)
        filled = half[:, 1 : self.harmonics + 1]
        begin = 0
        if component < len(self.coherent):
            begin = self.coherent.shape[2]
            filled[:, :begin] = self.coherent[component, points]
        for row, point in enumerate(range(points.start, points.stop)):
            random = np.random.default_rng([self.seed, 1 + component, point])
            angle = random.random(self.harmonics - begin, dtype=np.float32) * np.float32(2 * np.pi)
            filled.real[row, begin:], filled.imag[row, begin:] = np.cos(angle), np.sin(angle)
        filled *= self.amplitude[component]
        return irfft(half, self.grid.steps, axis=1, overwrite_x=True)


def _check(path: str | Path, grid: FieldGrid, turbulence_class: str, lateral_coherence: str) -> None:
    problem = ""
    if not grid.speed > 0:
        problem = f"mean_speed = {grid.speed:g} m/s, turbulence needs a positive one"
    elif min(grid.rows, grid.columns) < 1 or grid.points > LARGEST_GRID:
        problem = f"{grid.columns} x {grid.rows} points, expected 1 to {LARGEST_GRID}"
    elif (grid.rows > 1 and not grid.dz > 0) or (grid.columns > 1 and not grid.dy > 0):
        problem = "width and height of the grid must be positive"
    elif not grid.bottom > 0:
        problem = (
            f"the lowest row is at {grid.bottom:g} m, where the power law has no wind; give a smaller height, "
            "or the bottom of the grid"
        )
    elif not grid.dt > 0 or grid.steps < 16:
        problem = f"{grid.steps} time steps of {grid.dt:g} s, expected 16 or more"
    elif turbulence_class not in TURBULENCE_CLASSES:
        problem = f"turbulence_class '{turbulence_class}' is not one of {', '.join(TURBULENCE_CLASSES)}"
    elif lateral_coherence not in ("none", "iec"):
        problem = f"lateral_coherence '{lateral_coherence}' is not one of none, iec"
    if problem:
        raise ParameterError(f"{path}: cannot generate the wind field: {problem}.")
