"""The face: how the results of a run in time change with parameters, at every output point."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from fowtlib.language.errors import ModelError, ParameterError, SimulationError, did_you_mean
from fowtlib.language.externals import refusals_explained
from fowtlib.language.whole_files import write_whole
from fowtlib.solving.conditions import Conditions
from fowtlib.solving.results import Result
from fowtlib.solving.results.statistics import time_weights
from fowtlib.solving.results.tables import write_table
from fowtlib.solving.simulation import SolverChoice, simulated
from fowtlib.solving.state import State
from fowtlib.solving.tangents.beginnings import Beginning
from fowtlib.solving.tangents.directions import RunDirections
from fowtlib.solving.tangents.linearised import Linearised
from fowtlib.solving.tangents.propagation import CHUNK, Grid, Moved, Propagation
from fowtlib.solving.tangents.tape import Happening, Sample, Taped, taped
from fowtlib.solving.timeline import Event, Timeline
from fowtlib.solving.tuned import tuned_elements

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Values = Mapping[str, Any]

GROWTH = 100.0  # by which a perturbation grows in the second half of a run, from which on it is said
PART = 1e-4  # of the change of a series by a parameter: how far `slopes_of` goes to either side


@dataclass(frozen=True, eq=False)
class Slopes:
    """A number of a run, and its derivatives by parameters.

    value, unit; time: where it stands [s], of a largest or smallest value, else None; by (m,): d value / d parameter,
    in the unit of the value per SI unit of the parameter; `slopes["platform.hull.mass"]` is one of them.
    """

    name: str
    value: float
    unit: str
    time: float | None
    parameters: tuple[str, ...]
    parameter_units: tuple[str, ...]
    by: np.ndarray

    def __getitem__(self, parameter: str) -> float:
        return float(self.by[_number(parameter, self.parameters, "parameter")])

    def __repr__(self) -> str:
        at = "" if self.time is None else f" at {self.time:g} s"
        lines = [f"{self.name} = {self.value:.6g} {self.unit}{at}"]
        rows = zip(self.parameters, self.parameter_units, self.by, strict=True)
        lines += [f"  by {name:44}{value:>14.6g} {_per(self.unit, unit)}" for name, unit, value in rows]
        return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives of the results of a run by parameters.

    run: the run itself, a Result. results, units (k,); parameters, parameter_units, at (m,): values of the parameters
    [SI]; derivatives (n, k, m): at each output point, in the unit of the result per SI unit of the parameter.
    growth: of a small perturbation that nothing drives, over the second half of the run [1/s]. Below zero the motion
    forgets its start; above, two runs part exponentially, and a derivative tells less the longer the run is.

    `found["surge", "platform.mooring.length"]` is a labelled series; `found.std("surge")` the derivatives of a number.
    """

    run: Result
    results: tuple[str, ...]
    units: tuple[str, ...]
    parameters: tuple[str, ...]
    parameter_units: tuple[str, ...]
    at: np.ndarray
    derivatives: np.ndarray
    growth: float

    @property
    def time(self) -> np.ndarray:
        """Output points (n,) [s]."""
        return self.run.time

    def array(self, result: str, parameter: str) -> np.ndarray:
        """D result / d parameter at the output points (n,)."""
        k = _number(result, self.results, "result")
        return self.derivatives[:, k, _number(parameter, self.parameters, "parameter")]

    def unit(self, result: str, parameter: str) -> str:
        """Unit of a derivative."""
        below = self.parameter_units[_number(parameter, self.parameters, "parameter")]
        return _per(self.units[_number(result, self.results, "result")], below)

    def __getitem__(self, which: tuple[str, str]) -> xarray.DataArray:
        import xarray

        if not isinstance(which, tuple) or len(which) != 2:
            raise ModelError(
                "a derivative is that of a result by a parameter, as in found['surge', 'platform.hull.mass'], not "
                f"{which!r}."
            )
        name = f"d {which[0]} / d {which[1]}"
        attributes = {"units": self.unit(*which), "long_name": name}
        return xarray.DataArray(self.array(*which), {"time": self.time}, ["time"], name, attributes)

    # --- numbers of a run ----------------------------------------------------------------------------------------

    def mean(self, result: str, discard: float = 0.0) -> Slopes:
        """The mean of a result from `discard` [s] on, and its derivatives."""
        t, y, by = self._series(result, discard)
        weights = time_weights(t)
        return self._slopes(f"mean {result}", result, float(weights @ y), weights @ by)

    def std(self, result: str, discard: float = 0.0) -> Slopes:
        """The standard deviation from `discard` [s] on; SimulationError where the result does not move."""
        t, y, by = self._series(result, discard)
        weights = time_weights(t)
        about = y - weights @ y
        deviation = float(np.sqrt(weights @ about**2))
        if not deviation > 1e-12 * max(float(np.abs(y).max()), 1e-300):
            raise SimulationError(f"{result} does not move: its standard deviation is zero, and has no derivative.")
        return self._slopes(f"std {result}", result, deviation, (weights * about) @ by / deviation)

    def maximum(self, result: str, discard: float = 0.0) -> Slopes:
        """The largest value of the output points, where it stands, and the derivatives there.

        They hold as long as the largest value stays that of the same moment.
        """
        return self._extreme(result, discard, "max", 1.0)

    def minimum(self, result: str, discard: float = 0.0) -> Slopes:
        """The same of the smallest value."""
        return self._extreme(result, discard, "min", -1.0)

    def slopes_of(self, function: Callable[[np.ndarray, np.ndarray], float], result: str, *, discard: float = 0.0,
                  name: str = "", unit: str | None = None) -> Slopes:  # fmt: skip
        """Any number of a series, `function(time, values)`, as a damage-equivalent load, and its derivatives.

        The function is differentiated by central differences along each derivative of the series, to about 1e-8 where
        it is smooth. unit: of the number; None: that of the result.
        """
        t, y, by = self._series(result, discard)
        value, slopes = _one_number(function(t, y)), np.zeros(by.shape[1])
        size = float(np.ptp(y)) or float(np.abs(y).max()) or 1.0
        for column, series in enumerate(by.T):
            largest = float(np.abs(series).max())
            if largest:
                step = PART * size / largest
                slopes[column] = (function(t, y + step * series) - function(t, y - step * series)) / (2 * step)
        return self._slopes(name or f"number of {result}", result, value, slopes, unit=unit)

    def _extreme(self, result: str, discard: float, word: str, sign: float) -> Slopes:
        t, y, by = self._series(result, discard)
        k = int(np.argmax(sign * y))
        return self._slopes(f"{word} {result}", result, float(y[k]), by[k], time=float(t[k]))

    def _series(self, result: str, discard: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        k = _number(result, self.results, "result")
        kept = self.time >= self.time[0] + discard - 1e-9
        if not kept.any():
            raise ModelError(f"discard is {discard:g} s, and the run is shorter; nothing would be left of it.")
        return self.time[kept], self.run.array(result)[kept], self.derivatives[kept, k]

    def _slopes(self, name: str, result: str, value: float, by: np.ndarray, *, time: float | None = None,
                unit: str | None = None) -> Slopes:  # fmt: skip
        unit = self.units[_number(result, self.results, "result")] if unit is None else unit
        return Slopes(name, value, unit, time, self.parameters, self.parameter_units, by)

    # --- what is kept --------------------------------------------------------------------------------------------

    @property
    def dataset(self) -> xarray.DataArray:
        """The derivatives over the coordinates ``time``, ``result`` and ``parameter``."""
        import xarray

        coordinates = {
            "time": ("time", self.time, {"units": "s"}), "result": list(self.results),
            "parameter": list(self.parameters), "unit": ("result", list(self.units)), "at": ("parameter", self.at),
            "parameter_unit": ("parameter", list(self.parameter_units)),
        }  # fmt: skip
        of = {name: self.run.attributes.get(name, "") for name in ("model", "title", "solver", "step", "tolerance")}
        return xarray.DataArray(self.derivatives, dims=("time", "result", "parameter"), coords=coordinates,
                                name="sensitivity", attrs={**of, "growth": self.growth})  # fmt: skip

    def save(self, path: str | Path) -> Path:
        """Write the series: .nc, or .csv with a column for each pair, its unit in the head."""
        path = Path(path)
        if path.suffix == ".nc":
            return write_whole(path, lambda target: self.dataset.to_netcdf(target, engine="scipy"))
        pairs = [(result, parameter) for result in self.results for parameter in self.parameters]
        heads = [f"d {result} / d {parameter} [{self.unit(result, parameter)}]" for result, parameter in pairs]
        columns = np.column_stack([self.time, self.derivatives.reshape(len(self.time), -1)])
        return write_table(path, ["time [s]", *heads], columns.tolist(), "sensitivities")

    def plot(self, path: str | Path | None = None, results: Sequence[str] | None = None) -> Figure:
        """Each result's change for one per cent of each parameter over time; of one that is zero, for 0.01 of its unit.

        So that parameters of different units can be compared. path: .png, .svg or .pdf.
        """
        from fowtlib.solving.tangents.picture import draw

        return draw(self, path, self.results if results is None else results)

    def __repr__(self) -> str:
        return (f"<Sensitivities of {len(self.results)} results to {len(self.parameters)} parameters, "
                f"{self.time[0]:g} to {self.time[-1]:g} s>")  # fmt: skip


def sensitivities(model: Any, by: Sequence[str], results: Sequence[str] | str | None = None, *,
                  t_end: float | str | None = None, output_step: float | str | None = None,
                  start: State | Values | str | None = None, parameters: Values | None = None,
                  inputs: Values | None = None, events: Sequence[Event | str] | None = None,
                  step: float | str | None = None, tolerance: float | None = None, rho_inf: float | None = None,
                  progress: Callable[[float, float], None] | bool = False) -> Sensitivities:  # fmt: skip
    """How the results of a run change with parameters: forward sensitivities of the solver "fixed".

    model        a model, or a compiled one
    by           paths of tunable parameters, or of single elements; also numbers that a sea or a wind reads
    results      names of results, or paths of variables; None: all results of the model
    start        as for a run. The mean position (start="equilibrium") moves with the parameters, start values by path
                 and a State are held; None: the start values of the model file, which parameters may move, too
    The others are as for a run, see Plant.simulate. The derivative is that of what the solver computes, with its steps
    as they are: it differs from that of the exact motion by the error of the steps, and not from differences of runs.

    Raises ParameterError for what has no derivative, and says why; SimulationError where an event happens at an instant
    that depends on the motion. Warns where perturbations grow exponentially.
    """
    plant = model.compile() if hasattr(model, "compile") else model
    if parameters is None and isinstance(start, State):
        parameters = start.parameters
    elements = tuned_elements(plant, by, parameters)
    if not elements:
        raise ParameterError("by: no parameter is given.")
    if not plant.dae.states:
        raise ParameterError("this model has no states: nothing in it moves by itself, and a run has no sensitivities.")
    names = list(plant.outputs) if results is None else [results] if isinstance(results, str) else list(results)
    if not names:
        raise ParameterError("results: no result is given; None takes all of the model.")
    expressions = [_expression(plant, name) for name in names]
    for sample in plant.dae.samples:
        if sample.process is not None:
            raise ParameterError(
                f"{sample.path}: what a process outside of the model computes has no derivative. Take a controller "
                "that is a part of the model."
            )
    with refusals_explained():
        run = RunDirections(plant, dict(parameters or {}), elements)
        at = plant.at(run.parameters)
        beginning = Beginning(plant, start, run.parameters, inputs)
        x, d = beginning.moved(run)
        kept: list[Taped] = []
        plans: list[Timeline] = []

        def watched(engine: Any, timeline: Timeline) -> Any:
            kept.append(taped(engine, timeline))
            plans.append(timeline)
            return kept[0]

        conditions = Conditions({}, run.parameters, inputs, beginning.values, t_end, output_step, None, names, events)
        choice = SolverChoice("fixed", step, tolerance, rho_inf)
        result = simulated(plant, conditions, choice, True, progress, None, watched)
        engine, timeline = kept[0], plans[0]
        _refuse_clocks(at, run)
        moving = _moving(plant, engine, timeline, d)
        lines = Linearised(at, run, moving)
        state = beginning.state(run)
        first = beginning.consistent(at, lines, state, x, d), d
        grid = _propagated(plant, engine, timeline, lines, result.time, first)
        found = _observed(lines, result, grid, expressions, state.u)
    found *= np.array([plant.outputs.factor(name) for name in names])[:, None]
    units = tuple(plant.outputs.entry(name).unit for name in names)
    labels, below = tuple(item.name for item in elements), tuple(item.unit for item in elements)
    growth = _growth(result.time, grid.size)
    return Sensitivities(result, tuple(names), units, labels, below, run.values, found, growth)


def _expression(plant: Any, name: str) -> ca.SX:
    entry = plant.outputs.entry(name)
    try:
        expression = plant.dae.observe_expression(entry.path)
    except ModelError:
        known = [*plant.outputs, *plant.dae.names]
        raise ModelError(f"there is no result or variable '{name}'{did_you_mean(name, known)}") from None
    if expression.numel() != 1:
        raise ModelError(f"'{name}' has {expression.numel()} values; take one of them, as in '{name}[0]'.")
    return expression


def _refuse_clocks(at: Any, run: RunDirections) -> None:
    """Parameters that decide when sampled parts are due."""
    dae = at.dae
    if not dae.samples:
        return
    clocks = ca.vertcat(*[ca.vertcat(sample.period, sample.offset) for sample in dae.samples])
    slope = ca.Function("clocks", [dae.p], [ca.densify(ca.jacobian(clocks, dae.p))])
    moved = np.any(np.array(slope(run.binding.p)) @ run.numbers != 0, axis=0)
    if moved.any():
        name = run.elements[int(np.argmax(moved))].name
        raise ParameterError(
            f"there is no sensitivity to {name}: it decides at which instants a sampled part computes, and so moves "
            "the steps of the solver. Take differences of two runs."
        )


def _moving(plant: Any, engine: Taped, timeline: Timeline, d: np.ndarray) -> list[int]:
    """Numbers of the discrete variables that may move with parameters."""
    found = set(np.flatnonzero(np.any(d != 0, axis=1)).tolist())
    for record in engine.tape:
        if isinstance(record, Sample):
            found |= set(plant.dae.samples[record.number].targets)
        elif isinstance(record, Happening):
            found |= set(timeline.planned[record.number].offer.discrete_targets)
    return sorted(found)


def _propagated(plant: Any, engine: Taped, timeline: Timeline, lines: Linearised, times: np.ndarray,
                first: tuple[np.ndarray, np.ndarray]) -> Grid:  # fmt: skip
    dae, run, (x, d) = plant.dae, lines.run, first
    nominal = np.array([item.nominal for item in dae.states])
    beside = np.random.default_rng(1).standard_normal(len(nominal)) * nominal  # any that is not of one mode alone
    columns = np.column_stack([x, beside]) if len(nominal) else np.zeros((0, x.shape[1] + 1))
    now = Moved(columns, np.zeros_like(columns), np.column_stack([d, np.zeros(len(d))]))
    given = _given(plant, run, timeline, any(isinstance(record, Happening) for record in engine.tape))
    rho_inf = float(engine.attributes["rho_inf"])
    steps = Propagation(lines, engine.inner.reduced, rho_inf, timeline, given)
    return steps.along(engine.tape, now, times)


def _given(plant: Any, run: RunDirections, timeline: Timeline, any_happened: bool) -> list[np.ndarray]:
    """Derivatives of the values of each event, of which defaults may follow from parameters."""
    counts = [item.given.size for item in timeline.planned]
    if not any_happened or not sum(counts) or plant.root is None:
        return [np.zeros((count, len(run.elements))) for count in counts]
    asked, columns = timeline.asked, []
    for item in run.elements:

        def values(value: float, item: Any = item) -> np.ndarray:
            with run.tree_at(item, value) as tree:
                planned = Timeline(asked, plant.dae, plant.outputs, tree).planned
                return np.concatenate([one.given for one in planned])

        columns.append(run.slope(item, values))
    return np.split(np.column_stack(columns), np.cumsum(counts)[:-1])


def _observed(lines: Linearised, result: Result, grid: Grid, expressions: Sequence[ca.SX],
              u: np.ndarray) -> np.ndarray:  # fmt: skip
    """Derivatives of expressions at the output points (n, k, m) [SI]."""
    raw, nz = result.raw, lines.dae.z.numel()
    assert raw is not None
    rows = ca.vertcat(lines.dae.alg, *[ca.densify(expression) for expression in expressions])
    found = np.zeros((len(raw.time), len(expressions), grid.x.shape[2]))
    name = f"results {[expression.__hash__() for expression in expressions]}"
    for first in range(0, len(raw.time), CHUNK):
        part = slice(first, first + CHUNK)
        q = np.hstack([np.repeat(u[None], len(raw.time[part]), axis=0), raw.d[part]])
        points = lines.points(raw.time[part], raw.x[part], raw.z[part], q)
        by_x, by_z, by_d, by_p = lines.slopes(name, rows, points)
        total = by_x @ grid.x[part] + by_d @ grid.d[part][:, lines.moving] + by_p
        if nz:
            total[:, nz:] += by_z[:, nz:] @ np.linalg.solve(-by_z[:, :nz], total[:, :nz])
        found[part] = total[:, nz:]
    return found


def _growth(time: np.ndarray, size: np.ndarray) -> float:
    """Rate [1/s] at which a perturbation grows over the second half of a run; a warning where it does."""
    half = int(np.searchsorted(time, 0.5 * (time[0] + time[-1])))
    if len(time) - half < 3 or not np.all(np.isfinite(size[half:])):
        return float("nan")
    rate = float(np.polyfit(time[half:] - time[half], size[half:], 1)[0])
    if rate * (time[-1] - time[half]) > np.log(GROWTH):
        warnings.warn(
            f"two runs that begin close to each other part exponentially, by a factor of e every {1 / rate:.3g} s: the "
            f"longer the run, the smaller the change of a parameter for which its sensitivities hold. At "
            f"{time[-1]:g} s they are those of changes too small to matter; take a shorter run.", stacklevel=3,
        )  # fmt: skip
    return rate


def _one_number(found: Any) -> float:
    """What a function of a series has given; ParameterError where it is not one number."""
    try:
        return float(found)
    except (TypeError, ValueError):
        raise ParameterError(f"function: it gives one number of time and values, not {found!r}.") from None


def _number(name: str, known: Sequence[str], what: str) -> int:
    if name not in known:
        raise ModelError(f"there is no {what} '{name}' in these sensitivities{did_you_mean(name, known)}")
    return list(known).index(name)


def _per(above: str, below: str) -> str:
    return above if below == "1" else f"{above}/{below}" if below.isalpha() else f"{above}/({below})"
