"""Response amplitude operators: response per metre of wave amplitude, over frequency.

Convention: elevation a cos(omega t) at the origin gives the response a |H| cos(omega t + phase); complex amplitudes go
with exp(+i omega t), so a positive phase leads the crest at the origin.

The wave load is not causal in the elevation (a diffracting hull feels the wave before its crest arrives), so no state
space has the elevation as its input. The linear operator is therefore H(omega) = G(i omega) X(omega): G from a
generalized load at the hull to the outputs, exact from the linear model with its radiation states and mooring, and
X(omega) from the hydrodynamic data. A part offers this pair by two attributes: ``wave_inputs``, the names of tunable
parameters that are added to its wave load, and ``wave_transfer(omega, heading)``, the complex load per unit amplitude
in their order.

Quadratic drag, linearised about still water, is zero: the linear operator is the limit of small waves. Near resonance
it is larger than what a run with drag shows; compare with runs in small waves, or without drag. The same holds for the
controller of a turbine near rated wind, which switches between two laws as soon as waves move the rotor: the linear
model is that of one side.

A rotor of blade elements that turns makes the equations periodic. Its linear model is the mean over a revolution
(fowtlib.solving.mean_linear), without the azimuth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.harmonics import harmonic_fit
from fowtlib.analysis.plants import (
    calm,
    checked_frequencies,
    chosen_outputs,
    compiled,
    refuse_unstable,
    shown_unit,
    still_water,
)
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.whole_files import write_whole
from fowtlib.solving import mean_linear_model, mean_state
from fowtlib.solving.results.html import table

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


_SHOWN = 20
SPREAD = np.array([-8, -5, -3, -1.5, -0.7, 0, 0.7, 1.5, 3, 5, 8])  # half-widths about a resonance
LOWEST, HIGHEST, COUNT = 0.005, 0.3, 60  # of the frequencies taken by default: each 0.005 Hz; drifts lie below waves


@dataclass(frozen=True)
class Rao:
    """Complex response per metre of wave amplitude, ``response`` (n_frequency, n_output), at ``frequency`` [Hz].

    outputs and units are the names of the columns and their units per metre of wave ("m/m", "deg/m"); heading in rad;
    method is one phrase for a figure's legend.
    """

    frequency: np.ndarray
    outputs: tuple[str, ...]
    response: np.ndarray
    units: tuple[str, ...]
    heading: float = 0.0
    method: str = "linear"

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.outputs:
            raise ModelError(f"the response has no output '{name}'{did_you_mean(name, self.outputs)}")
        return self.response[:, self.outputs.index(name)]

    def amplitude(self, name: str) -> np.ndarray:
        """Amplitude of an output per metre of wave amplitude, in its unit per metre."""
        return np.abs(self[name])

    def phase(self, name: str) -> np.ndarray:
        """Phase in degrees against the crest at the origin, within (-180, 180]; positive leads."""
        return np.degrees(np.angle(self[name]))

    def unit(self, name: str) -> str:
        """Unit of an output's amplitude, per metre of wave."""
        return self.units[self.outputs.index(name)]

    @property
    def dataset(self) -> xarray.Dataset:
        """Amplitude and phase of every output over the coordinate ``frequency``."""
        import xarray

        frequency = xarray.Variable("frequency", self.frequency, {"units": "Hz", "long_name": "wave frequency"})
        columns = {}
        for name, unit in zip(self.outputs, self.units, strict=True):
            amplitude = {"units": unit, "long_name": f"amplitude of {name} per wave amplitude"}
            phase = {"units": "deg", "long_name": f"phase of {name} against the crest at the origin"}
            columns[f"{name}_amplitude"] = ("frequency", self.amplitude(name), amplitude)
            columns[f"{name}_phase"] = ("frequency", self.phase(name), phase)
        attrs = {"heading_deg": float(np.degrees(self.heading)), "method": self.method}
        return xarray.Dataset(columns, {"frequency": frequency}, attrs)

    def save(self, path: str | Path) -> Path:
        """Write a table as CSV, one row per frequency, with units in the header line."""
        path = Path(path)
        if path.suffix != ".csv":
            raise ModelError(f"{path}: a response operator is saved as .csv, not as '{path.suffix or 'no ending'}'.")
        dataset = self.dataset
        heads = ["frequency [Hz]", *(f"{name} [{dataset[name].attrs['units']}]" for name in dataset)]
        table = np.column_stack([self.frequency, *(dataset[name].values for name in dataset)])
        head = ",".join(heads)
        return write_whole(
            path, lambda file: np.savetxt(file, table, fmt="%.8g", delimiter=",", header=head, comments="")
        )

    def plot(self, path: str | Path | None = None, **options: Any) -> Figure:
        """Amplitude and phase over frequency; options of fowtlib.view.plot_rao."""
        from fowtlib.solving.results.plots import plot_rao

        return plot_rao(self, path, **options)

    def _repr_html_(self) -> str:
        heads = ("frequency [Hz]", *(f"{n} [{u}]" for n, u in zip(self.outputs, self.units, strict=True)))
        rows = [(float(f), *map(float, row)) for f, row in zip(self.frequency, np.abs(self.response), strict=True)]
        return table(heads, rows, f"response to waves, {self.method}, heading {np.degrees(self.heading):g} deg")

    def __repr__(self) -> str:
        widths = [max(12, len(f"{name} [{unit}]") + 2) for name, unit in zip(self.outputs, self.units, strict=True)]
        heads = (f"{f'{n} [{u}]':>{w}}" for n, u, w in zip(self.outputs, self.units, widths, strict=True))
        lines = [f"<Rao, {self.method}, heading {np.degrees(self.heading):g} deg>", f"{'[Hz]':>8}" + "".join(heads)]
        for i in range(min(_SHOWN, self.frequency.size)):
            numbers = (f"{abs(value):>{width}.4g}" for value, width in zip(self.response[i], widths, strict=True))
            lines.append(f"{self.frequency[i]:>8.4g}" + "".join(numbers))
        if self.frequency.size > _SHOWN:
            lines.append(f"... and {self.frequency.size - _SHOWN} more frequencies")
        return "\n".join(lines)


def per_metre(plant: Any, names: Sequence[str]) -> tuple[str, ...]:
    """Units of results per metre of wave: "deg/m", "(m/s)/m"."""
    units = [shown_unit(plant, name) for name in names]
    return tuple(f"({unit})/m" if "/" in unit else f"{unit}/m" for unit in units)


def wave_inputs(root: Any) -> list[tuple[list[str], Callable[[np.ndarray, float], np.ndarray]]]:
    """Every part below ``root`` that feels the wave: paths of its inputs, and its load per unit amplitude."""
    return [
        ([f"{part.path}.{name}" if part.path else name for name in part.wave_inputs], part.wave_transfer)
        for part in root.walk()
        if hasattr(type(part), "wave_inputs") and hasattr(part, "wave_transfer")
    ]


def linear_rao(
    model: Any,
    frequencies: Sequence[float] | np.ndarray | None = None,
    *,
    outputs: Sequence[str] | None = None,
    heading: float = 0.0,
    state: Any = None,
    parameters: Mapping[str, Any] | None = None,
) -> Rao:
    """Response operator of the linear model, at ``frequencies`` [Hz] and a wave ``heading`` [rad].

    Without frequencies those of ``wave_frequencies``: the waves of the sea, closer near the natural modes.

    model    a compiled model, used as it is; or a model, which is first put into still water without wind
    outputs  result names; None takes the six motions as far as the model has them, else all results
    state    point of linearisation; None takes the mean state with these ``parameters``
    """
    plant = compiled(model)
    inputs = wave_inputs(model.root if hasattr(model, "root") else plant.root)
    if not inputs:
        raise ModelError(
            "no part of this model feels the waves (such as a WaveExcitation), so there is no response to them."
        )
    frequency = None if frequencies is None else checked_frequencies(frequencies)
    names = chosen_outputs(plant, outputs)
    if state is None:
        state = mean_state(plant, {**still_water(plant), **(parameters or {})})
    linear = mean_linear_model(plant, state, inputs=[path for paths, _ in inputs for path in paths], outputs=names)
    refuse_unstable(linear)
    if frequency is None:
        frequency = wave_frequencies(linear, [transfer for _, transfer in inputs], heading)
    load = np.hstack([np.asarray(transfer(2.0 * np.pi * frequency, heading)) for _, transfer in inputs])
    response = np.einsum("foi,fi->fo", linear.frequency_response(2.0 * np.pi * frequency), load)
    return Rao(frequency, tuple(names), response, per_metre(plant, names), heading, "linear")


def wave_frequencies(linear: Any, transfers: Sequence[Any], heading: float) -> np.ndarray:
    """Frequencies [Hz] for a response operator: 0.005 to 0.3 Hz, and round the modes that answer to waves.

    From 3.3 s to 100 s of period, as far as there are wave loads; more of them within eight half-widths of each
    resonance with a damping ratio below 0.2.
    """
    points = [np.linspace(LOWEST, HIGHEST, COUNT)]
    for mode in linear.modes():
        damping = max(mode.damping_ratio, 1e-3)
        if LOWEST < mode.frequency_hz < HIGHEST and damping < 0.2 and mode.eigenvalue.imag > 0:
            points.append(mode.frequency_hz * (1 + damping * SPREAD))
    frequency = np.sort(np.concatenate(points))
    frequency = frequency[(frequency >= LOWEST) & (frequency <= HIGHEST)]
    frequency = frequency[np.diff(frequency, prepend=0.0) > 1e-6 * frequency]
    loads = np.hstack([np.asarray(transfer(2 * np.pi * frequency, heading)) for transfer in transfers])
    felt = np.abs(loads).any(axis=1)
    return frequency[felt] if felt.any() else frequency


def simulated_rao(
    model: Any,
    frequencies: Sequence[float] | np.ndarray,
    *,
    outputs: Sequence[str] | None = None,
    height: float = 2.0,
    heading: float = 0.0,
    periods: int = 10,
    settle: float = 400.0,
    sea: str = "sea",
    in_wind: bool = False,
    parameters: Mapping[str, Any] | None = None,
    **simulate: Any,
) -> Rao:
    """Response operator from one run in regular waves of ``height`` [m] per frequency, for comparison.

    Every run starts at the mean state in still water, the waves grow during half of ``settle`` seconds, and the
    ``periods`` wave periods after it are fitted by a harmonic. The part named ``sea`` must be a Sea. Motions in the
    natural modes die out slowly: lengthen ``settle`` where the response is small. Further arguments go to
    ``plant.simulate``. in_wind: in the wind of the model, which must be steady (``model.in_the_mean()``).
    """
    frequency = checked_frequencies(frequencies)
    if not hasattr(model, "with_parameters"):
        raise ModelError("simulated_rao needs the model, fw.load(...), and not the plant: it is put into waves anew.")
    quiet = calm(model)
    if in_wind:
        quiet.pop("wind.kind", None)
    plant = model.with_parameters(quiet).compile()
    rest = mean_state(plant, parameters)
    start = dict(zip((state.path for state in plant.dae.states), rest.x.tolist(), strict=True))
    names = chosen_outputs(plant, outputs)
    rows = []
    for f in frequency:
        waves = {"spectrum": "regular", "wave_height": height, "wave_period": 1.0 / f, "heading": heading}
        waves["build_up"] = 0.5 * settle
        values = {**(parameters or {}), **{f"{sea}.{name}": value for name, value in waves.items()}}
        step = min(0.5, 1.0 / (40.0 * f))
        end = settle + periods / f
        result = plant.simulate(end, output_step=step, start=start, parameters=values, **simulate)
        rows.append([_response(result, name, f, settle, height) for name in names])
    method = f"regular waves, H = {height:g} m"
    return Rao(frequency, tuple(names), np.array(rows), per_metre(plant, names), heading, method)


def _response(result: Any, name: str, frequency: float, settle: float, height: float) -> complex:
    return harmonic_fit(result[name], frequency, discard=settle).coefficients[0] / (0.5 * height)
