"""The stationary response of a model to random waves and wind, about its mean, without a run.

The mean position and the mean loads come from the equilibrium with all nonlinear equations and the controllers in the
loop; the model is linear about it, exactly, with the radiation of the database itself. Signals that the parts take from
waves and wind have transfer functions from the process (the elevation at the origin, the turbulence at each station),
so that S_y = H S H^H over each process, and the processes are independent. Drag is the best linear law of the response
itself (frequency.drag), found by a fixed point on the relative velocities at each place.

Left out: what is of second order in the waves, the mean of drag in waves, controllers that change their region within
the turbulence, dead bands and limits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.fatigue.spectral import dirlik
from fowtlib.analysis.plants import chosen_outputs, refuse_unstable
from fowtlib.analysis.spectra import Spectrum
from fowtlib.flattening import FlatDAE
from fowtlib.frequency.drag import best_gain
from fowtlib.frequency.grid import response_frequencies
from fowtlib.frequency.rotation import with_rotation
from fowtlib.language.component import Component
from fowtlib.language.errors import ModelError, SimulationError, did_you_mean
from fowtlib.language.series import Series
from fowtlib.solving import LinearModel, State, mean_state
from fowtlib.solving.binding import tree_with
from fowtlib.solving.excited import ExcitedModel, Signal, excited_model
from fowtlib.solving.random_fields import density as field_density
from fowtlib.solving.results.tables import write_table
from fowtlib.solving.starts import mean_parameters

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

ITERATIONS = 60
GUESS = 1.0  # m/s; deviation of the velocities of drag before the first iteration
REGRIDDED = 1e-2  # change of the gains below which the frequencies are chosen for good


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


def response(
    model: Any,
    *,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    frequencies: Sequence[float] | np.ndarray | None = None,
    state: State | None = None,
    tolerance: float = 1e-4,
) -> Response:
    """The response of a model, or of a compiled one, to its waves and its wind (see the module).

    outputs      results; None: all
    parameters   as for a run: what wind and what waves, for instance
    frequencies  [Hz], rising; None: chosen by the modes (frequency.grid)
    state        mean state; None: found
    tolerance    of the gains of drag, relative, at which the fixed point ends
    Raises SimulationError where there is no mean, where it is unstable, and where the drag does not settle.
    """
    plant = model.compile() if hasattr(model, "compile") else model
    names = list(plant.outputs) if outputs is None else chosen_outputs(plant, outputs)
    root = tree_with(plant.dae, plant.root, parameters)
    if state is None:
        state = mean_state(plant, mean_parameters(plant, parameters))
    excited = excited_model(plant, state, names, root)
    processes = _processes(excited, root)
    _refuse_without_spectrum(plant.dae, root, processes)
    if not processes:
        raise ModelError("no part of this model takes anything from random waves or wind; there is no response.")
    given = None if frequencies is None else np.asarray(frequencies, dtype=float)
    linear, grid, iterations = _settled(excited, processes, given, tolerance)
    refuse_unstable(linear)
    m = excited.results
    H = {path: answer[:, :m] for path, answer in grid.answers(linear).items()}
    shares = {path: _spectra(H[path], grid.spectra[path]) for path in H}
    mean = np.concatenate([np.ravel(state[name]) for name in names])
    labels = linear.outputs[:m]
    units = tuple(linear.units.get(name, "1") for name in labels)
    found = Response(grid.frequency, tuple(labels), units, mean, shares, H, linear, state, iterations)
    return with_rotation(found, plant, names, excited.rotating, grid.spectra)


Processes = Mapping[str, "Process"]
"""The random processes by path."""


@dataclass(frozen=True, eq=False)
class Process:
    """A random process: its spectrum [unit^2 s/rad] and what it drives, complex (q, inputs, channels), over omega."""

    density: Callable[[np.ndarray], np.ndarray]
    drive: Callable[[np.ndarray], np.ndarray]


def _settled(excited: ExcitedModel, processes: Processes, frequency: np.ndarray | None,
             tolerance: float) -> tuple[LinearModel, Grid, int]:  # fmt: skip
    """The linear model with the drag of its own response, the frequencies, and the count of iterations."""
    gains = [best_gain(GUESS**2 * np.eye(place.stop - place.start)) for _, place in excited.laws]
    linear = excited.with_gains(gains)
    refuse_unstable(linear)
    final = frequency is not None or not excited.laws
    grid = Grid(excited, processes, response_frequencies(linear.modes()) if frequency is None else frequency)
    for iteration in range(1, ITERATIONS + 1):
        found = grid.gains(grid.answers(linear))
        change = max((float(np.linalg.norm(new - old) / max(np.linalg.norm(new), 1e-12))
                      for new, old in zip(found, gains, strict=True)), default=0.0)  # fmt: skip
        gains, linear = found, excited.with_gains(found)
        if final and change < tolerance:
            return linear, grid, iteration
        if not final and change < REGRIDDED:
            final, grid = True, Grid(excited, processes, response_frequencies(linear.modes()))
    last = f"the last change is {change:.2g}"
    raise SimulationError(f"the linearised drag does not settle within {ITERATIONS} iterations; {last}.")


def _processes(excited: ExcitedModel, root: Component) -> dict[str, Process]:
    """The random processes that drive the signals, and the fields."""
    members: dict[str, tuple[Any, list[Signal]]] = {}
    for signal in excited.signals:
        process = signal.process(root)
        if np.any(process.spectral_density(np.geomspace(1e-2, 10.0, 50))):
            members.setdefault(process.path, (process, []))[1].append(signal)
    found = {path: Process(process.spectral_density, partial(_of_signals, excited.driven, signals, root))
             for path, (process, signals) in members.items()}  # fmt: skip
    for columns, places in excited.fields:
        path = places[0].compute.process(root.find(places[0].owner)).path
        found[path] = Process(partial(field_density, places, root), partial(_of_field, excited.driven, columns))
    return found


def _refuse_without_spectrum(dae: FlatDAE, root: Component, processes: Processes) -> None:
    """ModelError where a run has signals of time that no spectrum stands for: regular waves, a gust, a file."""
    for _, item in dae.with_data:
        if item.owner in processes or hasattr(item.compute, "density"):
            continue
        part = root.find(item.owner)
        if hasattr(item.compute, "process") and item.compute.process(part).path in processes:
            continue
        series = item.compute(part)
        if isinstance(series, Series) and not series.steady:
            family = part.family
            kind = f" of kind '{family.kind_of(type(part))}'" if family is not None else ""
            raise ModelError(
                f"{part.label}{kind}: its signals have no spectrum, and the response would be without them. Take what "
                "is random, as in --wind kaimal:12 or turbulence:12, --waves jonswap:Hs=3,Tp=10, or none of it."
            )


def _of_signals(driven: int, signals: Sequence[Signal], root: Component, omega: np.ndarray) -> np.ndarray:
    responses = [signal.response(root, omega) for signal in signals]
    drive = np.zeros((omega.size, driven, responses[0].shape[2]), dtype=complex)
    for signal, values in zip(signals, responses, strict=True):
        drive[:, signal.columns] = values
    return drive


def _of_field(driven: int, columns: slice, omega: np.ndarray) -> np.ndarray:
    chosen = np.eye(driven, dtype=complex)[:, columns]
    return np.broadcast_to(chosen, (omega.size, *chosen.shape))


class Grid:
    """What does not change with the gains of drag, at frequencies (q,) [Hz].

    spectra: of the processes (q, channels, channels) per Hz.
    """

    def __init__(self, excited: ExcitedModel, processes: Processes, frequency: np.ndarray):
        self.excited, self.frequency, self.omega = excited, frequency, 2 * np.pi * frequency
        steps = np.diff(frequency)
        self.widths = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
        operators = excited.linear.operators
        self.errors = operators.errors(self.omega) if operators is not None else None
        self.spectra: dict[str, np.ndarray] = {}
        self.columns: dict[str, slice] = {}
        drives, first = [], 0
        for path, process in processes.items():
            density = 2 * np.pi * np.asarray(process.density(self.omega))
            self.spectra[path] = density.reshape(len(density), *(density.shape[1:] or (1, 1)))
            channels = self.spectra[path].shape[1]
            drives.append(process.drive(self.omega))
            self.columns[path] = slice(first, first + channels)
            first += channels
        self.drive = np.concatenate(drives, axis=2)

    def answers(self, linear: LinearModel) -> dict[str, np.ndarray]:
        """Transfer functions (q, outputs, channels) by process."""
        H = linear.driven(self.omega, self.drive, self.errors)
        return {path: H[:, :, columns] for path, columns in self.columns.items()}

    def gains(self, answers: Mapping[str, np.ndarray]) -> list[np.ndarray]:
        """Gains of the laws of drag, from the covariance of their inputs."""
        gains = []
        for _, place in self.excited.laws:
            rows = slice(self.excited.results + place.start, self.excited.results + place.stop)
            covariance = np.zeros((place.stop - place.start,) * 2)
            for path, H in answers.items():
                u = H[:, rows]
                weighted = (u @ self.spectra[path]) * self.widths[:, None, None]
                covariance += np.tensordot(weighted, u.conj(), axes=([0, 2], [0, 2])).real
            gains.append(best_gain(covariance))
        return gains


def _spectra(H: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Spectra (m, q) of outputs, from transfer functions and the spectra of what drives them."""
    return ((H @ S) * H.conj()).sum(axis=2).real.T
