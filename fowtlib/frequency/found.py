"""What a response is: means, spectra and deviations of results, and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.fatigue.spectral import dirlik
from fowtlib.analysis.spectra import Spectrum
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.solving import LinearModel, State
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Response:
    """Means, spectra and deviations of results, in their units; one-sided, frequency in Hz.

    frequency (q,); mean (m,); density (m, q): spectra per Hz; shares: the same by process, such as "sea" and "wind";
    transfer: by process, complex (q, m, channels), per unit of it, exp(+i omega t). iterations: of the linearised drag.
    """

    frequency: np.ndarray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    mean: np.ndarray
    shares: Mapping[str, np.ndarray]
    transfer: Mapping[str, np.ndarray]
    linear: LinearModel = field(repr=False)
    state: State = field(repr=False)
    iterations: int = 0

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

    def extreme(self, name: str, duration: float = 3600.0, quantile: float = 0.5, side: str = "max") -> float:
        """Quantile of the largest ("max") or smallest ("min") value in a duration [s], of a Gaussian result.

        P(largest < y) = exp(-nu T exp(-(y - mean)^2 / (2 std^2))), nu the rate of up-crossings of the mean (Rice 1944).
        """
        sign = {"max": 1.0, "min": -1.0}.get(side)
        if sign is None:
            raise ModelError(f"side: '{side}' is not 'max' or 'min'.")
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

    def equivalent_load(self, name: str, exponent: float = 4.0, frequency: float = 1.0) -> float:
        """Damage-equivalent range of a result by Dirlik's law, of `frequency` [Hz] cycles."""
        return dirlik(self.spectrum(name)).equivalent_load(exponent, frequency)

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
            self.dataset.to_netcdf(path)
            return path
        heads = ("frequency [Hz]", *(f"{n} [({u})^2/Hz]" for n, u in zip(self.outputs, self.units, strict=True)))
        return write_table(path, heads, np.column_stack([self.frequency, self.density.T]).tolist(), "a response")

    def __repr__(self) -> str:
        lines = [f"<Response to {' and '.join(self.shares)}>", f"{'':20}{'mean':>12}{'std':>12}"]
        lines += [f"{f'{name} [{unit}]':20}{mean:>12.4g}{self.std(name):>12.4g}"
                  for name, unit, mean in zip(self.outputs, self.units, self.mean, strict=True)]  # fmt: skip
        return "\n".join(lines)
