"""What a response is: means, spectra and deviations of results, and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.fatigue.curves import SNCurve, in_si
from fowtlib.analysis.fatigue.spectral import damage_of, equivalent_load_of
from fowtlib.analysis.fatigue.tube import TubeDamage, TubeSection
from fowtlib.analysis.series import Series
from fowtlib.analysis.spectra import Spectrum, realisation
from fowtlib.frequency.corners import Corner
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.units import from_si, si_unit, to_si
from fowtlib.language.whole_files import write_whole
from fowtlib.solving import LinearModel, State
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Response:
    """Means, spectra and deviations of results, in their units; one-sided, frequency in Hz.

    frequency (q,); mean (m,); density (m, q): spectra per Hz; shares: the same by process, such as "sea" and "wind";
    transfer: by process, complex (q, m, channels), per unit of it, exp(+i omega t); driving: by process the spectra per
    Hz of its channels (q, channels, channels). iterations: of the linearised drag. Of a list of states (`responses`)
    one has neither transfer functions, unless they were asked for, nor the linear model and the state. corners: of
    control laws that the deviations reach over; see frequency.corners. linearisation: "tangent" or "equivalent", see
    fowtlib.frequency.response.
    """

    frequency: np.ndarray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    mean: np.ndarray
    shares: Mapping[str, np.ndarray]
    transfer: Mapping[str, np.ndarray]
    linear: LinearModel | None = field(repr=False)
    state: State | None = field(repr=False)
    iterations: int = 0
    driving: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False)
    corners: Sequence[Corner] = ()
    linearisation: str = "tangent"

    @property
    def density(self) -> np.ndarray:
        """Spectra (m, q) [unit^2/Hz] of the results, of all processes together."""
        return np.sum(list(self.shares.values()), axis=0)

    def _number(self, name: str) -> int:
        if name not in self.outputs:
            raise ModelError(f"the response has no output '{name}'{did_you_mean(name, self.outputs)}")
        return self.outputs.index(name)

    def unit(self, name: str) -> str:
        """Unit of a result."""
        return self.units[self._number(name)]

    def __getitem__(self, name: str) -> Spectrum:
        return self.spectrum(name)

    def spectrum(self, name: str, process: str | None = None) -> Spectrum:
        """Spectrum of a result; of one process, such as "sea", or of all."""
        k = self._number(name)
        if process is not None and process not in self.shares:
            raise ModelError(f"the response has no process '{process}'{did_you_mean(process, list(self.shares))}")
        density = self.density if process is None else self.shares[process]
        return Spectrum(self.frequency, density[k], self.units[k], name)

    def std(self, name: str, process: str | None = None) -> float:
        """Standard deviation of a result."""
        return self.spectrum(name, process).std

    def extreme(self, name: str, duration: float | str = 3600.0, quantile: float = 0.5, side: str = "max") -> float:
        """Quantile of the largest ("max") or smallest ("min") value of a Gaussian result in a duration [s], or "3 h".

        P(largest < y) = exp(-nu T exp(-(y - mean)^2 / (2 std^2))), nu the rate of up-crossings of the mean (Rice 1944).
        """
        sign = {"max": 1.0, "min": -1.0}.get(side)
        if sign is None:
            raise ModelError(f"side: '{side}' is not 'max' or 'min'.")
        duration = float(to_si(duration, "s", "duration"))
        if not (0 < quantile < 1 and duration > 0):
            raise ModelError(f"a quantile between 0 and 1 and a duration above 0 s; not {quantile:g} and {duration:g}.")
        spectrum, mean = self.spectrum(name), float(self.mean[self._number(name)])
        if not spectrum.std > 0:
            return mean
        crossings = spectrum.up_crossing_rate * duration
        size = 2 * np.log(crossings / -np.log(quantile))
        if not size > 0:
            hold = f"{duration:g} s hold {crossings:.2g} up-crossings of the mean"
            raise ModelError(f"{name}: {hold}; take a longer time.")
        return mean + sign * spectrum.std * float(np.sqrt(size))

    def mean_of(self, name: str) -> float:
        """Mean of a result."""
        return float(self.mean[self._number(name)])

    def rate(self, name: str) -> Spectrum:
        """Spectrum of the time derivative of a result, in its unit per second."""
        spectrum = self.spectrum(name)
        density = spectrum.density * (2 * np.pi * self.frequency) ** 2
        return Spectrum(self.frequency, density, f"({spectrum.unit})/s", f"rate of {name}")

    def duty_cycle(self, name: str, limit: float | str) -> float:
        """Actuator duty cycle: mean of the absolute rate of a result over the rate that the actuator can do.

        sqrt(2/pi) s / limit, with the deviation s of the Gaussian rate. limit: in the unit of the result per second, or
        with its unit, as "10 deg/s". Source: J. M. Hegseth, E. E. Bachynski, J. R. R. A. Martins, J. Phys. Conf. Ser.
        (2020), eq. 9 to 11.
        """
        unit = self.unit(name)
        most = from_si(to_si(limit, f"{si_unit(unit)}/s", "limit"), f"{si_unit(unit)}/s", f"{unit}/s") \
            if isinstance(limit, str) else float(limit)  # fmt: skip
        if not most > 0:
            raise ModelError(f"{name}: the rate of an actuator has a limit above 0, not {limit}.")
        return float(np.sqrt(2 / np.pi) * self.rate(name).std / most)

    def combined(self, factors: Mapping[str, float], unit: str = "1", name: str = "") -> Spectrum:
        """Spectrum of a sum of results, each times a factor, as they go together: a stress from two moments."""
        if not self.transfer:
            raise ModelError("a sum of results takes their transfer functions, and this response was kept without "
                             "them; in a list of states ask for them: responses(..., keep_transfer=True).")  # fmt: skip
        rows, weights = [self._number(each) for each in factors], np.array(list(factors.values()), dtype=float)
        density = np.zeros(self.frequency.size)
        for process, H in self.transfer.items():
            h = np.einsum("m,qmk->qk", weights, H[:, rows])
            density += np.einsum("qk,qkl,ql->q", h, self.driving[process], h.conj()).real
        return Spectrum(self.frequency, np.maximum(density, 0.0), unit, name or "sum")

    def series(self, name: str, duration: float = 3600.0, step: float = 0.1, *, seed: int = 1) -> Series:
        """One Gaussian series of a result about its mean: harmonics with random amplitudes and phases (inverse FFT)."""
        return realisation(self.spectrum(name), duration, step, seed=seed, mean=self.mean_of(name))

    def equivalent_load(self, name: str, exponent: float = 4.0, frequency: float = 1.0, *, method: str = "dirlik",
                        **options: Any) -> float:  # fmt: skip
        """Damage-equivalent range of a result, of `frequency` [Hz] cycles.

        method: "dirlik", "tovo_benasciutti", "narrow_band", or "rainflow" of series by inverse FFT, with options of
        fatigue.rainflow_of: seeds, duration [s], step [s].
        """
        return equivalent_load_of(self.spectrum(name), exponent, frequency, method, **options)

    def damage(self, name: str, curve: SNCurve, section: TubeSection | None = None, *, duration: float = 3600.0,
               method: str = "dirlik", **options: Any) -> float:  # fmt: skip
        """Miner's sum of a result in a duration [s], by an S-N curve of one slope or two.

        The result is a stress, or with the section of a tube its bending moment; for the thickness take the curve
        sn_curve(..., thickness=section.wall_thickness). method and options: as for `equivalent_load`.
        """
        spectrum = self.spectrum(name)
        if section is not None:
            size = in_si(spectrum.unit, "N*m", name, "a tube takes bending moments")
            spectrum = spectrum.scaled(size * section.bending, "Pa")
        return damage_of(spectrum, curve, duration, method, **options)

    def tube_damage(self, section: TubeSection, curve: SNCurve, moment_x: str, moment_y: str,
                    axial_force: str | None = None, *, points: int = 24, duration: float = 3600.0,
                    method: str = "dirlik", **options: Any) -> TubeDamage:  # fmt: skip
        """Miner's sums at points around a tube, from the spectrum of the stress at each; see fatigue.tube_damage.

        moment_x, moment_y, axial_force: names of results; the axes are those of fatigue.tube.
        """
        if int(points) != points or points < 1:
            raise ModelError(f"damage is computed at 1, 2, 3 ... points around a tube, not at {points:g}.")
        angles = 2 * np.pi * np.arange(int(points)) / points
        x, y = (in_si(self.unit(each), "N*m", each, "a tube takes moments") for each in (moment_x, moment_y))
        damage = []
        for angle in angles:
            factors = {moment_x: section.bending * np.sin(angle) * x, moment_y: -section.bending * np.cos(angle) * y}
            if axial_force is not None:
                force = in_si(self.unit(axial_force), "N", axial_force, "a tube takes an axial force")
                factors[axial_force] = force / section.area
            damage.append(damage_of(self.combined(factors, "Pa", "stress"), curve, duration, method, **options))
        return TubeDamage(angles, np.array(damage), duration, moment_y)

    def plot(self, path: str | Path | None = None, outputs: Sequence[str] | None = None, **options: Any) -> Figure:
        """Spectra over frequency; options of fowtlib.view.plot_spectra."""
        from fowtlib.solving.results.plots import plot_spectra

        return plot_spectra([self.spectrum(name) for name in outputs or self.outputs], path, **options)

    @property
    def dataset(self) -> xarray.Dataset:
        """Spectra over the coordinate ``frequency``, with mean and deviation as attributes."""
        import xarray

        frequency = xarray.Variable("frequency", self.frequency, {"units": "Hz", "long_name": "frequency"})
        columns = {}
        for k, (name, unit) in enumerate(zip(self.outputs, self.units, strict=True)):
            attrs = {"units": f"({unit})^2/Hz", "mean": float(self.mean[k]), "std": self.std(name)}
            columns[name] = ("frequency", self.density[k], attrs)
        return xarray.Dataset(columns, {"frequency": frequency})

    def save(self, path: str | Path) -> Path:
        """Write the spectra as CSV, one row per frequency, or all as netCDF (.nc)."""
        path = Path(path)
        if path.suffix == ".nc":
            return write_whole(path, lambda temporary: temporary.write_bytes(self.dataset.to_netcdf(engine="scipy")))
        heads = ("frequency [Hz]", *(f"{n} [({u})^2/Hz]" for n, u in zip(self.outputs, self.units, strict=True)))
        return write_table(path, heads, np.column_stack([self.frequency, self.density.T]).tolist(), "a response")

    def __repr__(self) -> str:
        lines = [f"<Response to {' and '.join(self.shares)}>", f"{'':20}{'mean':>12}{'std':>12}"]
        lines += [f"{f'{name} [{unit}]':20}{mean:>12.4g}{self.std(name):>12.4g}"
                  for name, unit, mean in zip(self.outputs, self.units, self.mean, strict=True)]  # fmt: skip
        return "\n".join(lines)
