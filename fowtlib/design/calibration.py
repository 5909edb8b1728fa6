"""Calibration: the parameters of a model with which a run of it is nearest to a record, and how sure they are.

Least squares over all channels, each over its standard deviation, by the exact derivatives of the run
(fw.sensitivities), or by differences of runs where it has none. Zero points of instruments are not those of a model, so
a constant of each channel is fitted too. Parameters that the record does not tell, alone or from each other, are
refused. Confidence: from the curvature at the end, with the residuals as a process whose neighbours are correlated
(AR(1): variance times (1 + r)/(1 - r), r the correlation of neighbours). What the model lacks is no noise: residuals
that are not small against the record say that the model is another one, whatever the intervals are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.decay_fits import decay_equation
from fowtlib.analysis.estimates import Estimate, covariance_of
from fowtlib.analysis.plants import plant_of, state_behind
from fowtlib.analysis.series import Series, as_series
from fowtlib.design.stopped import SearchStopped
from fowtlib.language.errors import ModelError, ParameterError, SimulationError
from fowtlib.solving import sensitivities
from fowtlib.solving.results import Result
from fowtlib.solving.results.tables import write_table
from fowtlib.solving.tuned import Tuned, TunedRun, tuned_elements

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fowtlib.analysis.series import SeriesLike

RANK = 1e-4  # smallest over largest singular value of the scaled derivatives, below which parameters are not told
_SMALL = 1e-6  # change of all channels by a parameter that doubles, over them, that counts as none
_DIFFERENCE = 1e-4  # of a parameter, where derivatives are differences of runs


class CalibrationStopped(SearchStopped):
    """Of a fit: values by the names of the parameters, nearest to the record; tried: runs.

    left: root of the mean square of the residuals, over the standard deviations of their channels.
    """


@dataclass(frozen=True)
class Calibration:
    """What was found. ``parameters`` goes to a run as it is: ``plant.simulate(..., parameters=found.parameters)``.

    estimates           values [SI] with their confidence, by the names of the parameters; start: values before
    correlation         (m, m) of the estimates: near 1 or -1, the record tells a combination of both only
    left, left_before   standard deviation of the residuals by channel, over that of the record
    measured, run, run_before, residuals   at the times of the record, (n,) by channel, with the fitted constants
    gradients           "exact", or "differences" and why
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    start: np.ndarray
    estimates: tuple[Estimate, ...]
    correlation: np.ndarray
    parameters: dict[str, Any]
    time: np.ndarray
    measured: dict[str, Series]
    run: dict[str, np.ndarray]
    run_before: dict[str, np.ndarray]
    constants: dict[str, float]
    gradients: str
    runs: int

    def __getitem__(self, name: str) -> Estimate:
        if name not in self.names:
            raise ModelError(f"'{name}' was not fitted; {', '.join(self.names)} were.")
        return self.estimates[self.names.index(name)]

    @property
    def residuals(self) -> dict[str, np.ndarray]:
        """Record less run by channel, in the unit of the result."""
        return {name: series.values - self.run[name] for name, series in self.measured.items()}

    @property
    def left(self) -> dict[str, float]:
        """Standard deviation of the residuals over that of the record, by channel."""
        return {name: float(rest.std() / self.measured[name].values.std()) for name, rest in self.residuals.items()}

    @property
    def left_before(self) -> dict[str, float]:
        """The same with the values that the model had."""
        series = self.measured.items()
        return {name: float((one.values - self.run_before[name]).std() / one.values.std()) for name, one in series}

    def rows(self) -> list[tuple[str, float, float, float, float, str]]:
        """Name, value before, value, lower and upper end at 95 %, unit."""
        found = zip(self.names, self.start.tolist(), self.estimates, self.units, strict=True)
        return [(name, start, one.value, *one.interval(), unit) for name, start, one, unit in found]

    def save(self, path: str | Path) -> Path:
        """Write the rows as CSV."""
        return write_table(path, ("parameter", "before", "value", "from", "to", "unit"), self.rows(), "a calibration")

    def plot(self, path: str | Path | None = None) -> Figure:
        """Record, run before and after, and residuals of every channel."""
        from fowtlib.design.pictures import plot_calibration

        return plot_calibration(self, path)

    def __repr__(self) -> str:
        lines = [f"<Calibration by {len(self.measured)} channels, {self.runs} runs, gradients {self.gradients}>"]
        lines += [f"  {name:44} {start:.6g} -> {one!r} {unit}"
                  for (name, start, *_, unit), one in zip(self.rows(), self.estimates, strict=True)]  # fmt: skip
        lines += [f"  left of {name}: {100 * part:.3g} % (before: {100 * self.left_before[name]:.3g} %)"
                  for name, part in self.left.items()]  # fmt: skip
        return "\n".join(lines)


def calibrate(
    model: Any, record: Result | Mapping[str, SeriesLike], fit: Sequence[str], *, results: Sequence[str] | None = None,
    release: str = "", start: Any = None, parameters: Mapping[str, Any] | None = None, discard: float = 0.0,
    constants: bool = True, step: float | None = None, tolerance: float | None = None,
) -> Calibration:  # fmt: skip
    """Fit parameters of a model to a record.

    model      a model, or a compiled one, in the conditions of the test: its wind and sea, or ``parameters`` for them
    record     by names of results of the model, in their units: a Result (a file), or {"heave": (time, values)}
    fit        paths of tunable parameters, or of elements of them: "platform.damping.translation[2]"; they begin at the
               values of the model and stay within the bounds that the parameters declare
    results    channels of the record that count; None: all that the model has
    release    the motion that is let go in a decay test: the run begins with its offset and speed, as decay_equation
               finds them in the record, and everything else at equilibrium; else it begins as ``start`` says, at the
               first time of the record
    discard    seconds at the beginning that do not count (of a run in waves)
    constants  a constant of each channel is fitted too

    step and tolerance are those of the solver "fixed". Ctrl-C raises CalibrationStopped, a KeyboardInterrupt that has
    the values so far. Raises ModelError: channels or parameters that are not there, a parameter without influence,
    parameters whose influences are proportional.
    """
    plant = plant_of(model)
    elements = tuned_elements(plant, fit, parameters)
    channels = _channels(plant, record, results)
    fitting = _Fitting(plant, elements, channels, parameters, constants, discard, step, tolerance)
    fitting.release(release) if release else fitting.begin(start)
    return fitting.found()


class _Fitting:
    """Residuals and derivatives over parameters in units of their size."""

    def __init__(self, plant: Any, elements: list[Tuned], channels: dict[str, Series], parameters: Any,
                 constants: bool, discard: float, step: float | None, tolerance: float | None):  # fmt: skip
        self.plant, self.elements, self.channels, self.constants = plant, elements, channels, constants
        self.parameters, self.discard = dict(parameters or {}), discard
        self.options = {"step": step, "tolerance": tolerance}
        self.start_values = TunedRun(plant, self.parameters, elements).values
        self.sizes = np.where(self.start_values != 0.0, np.abs(self.start_values), 1.0)
        self.gradients, self.runs = "exact", 0
        self.known: dict[bytes, tuple[dict[str, np.ndarray], np.ndarray | None]] = {}
        self.nearest: tuple[float, np.ndarray] | None = None  # mean square of residuals, and the values

    # --- where the run begins ---------------------------------------------------------------------------------------

    def begin(self, start: Any) -> None:
        self.time = next(iter(self.channels.values())).time
        self.state = lambda values: start

    def release(self, name: str) -> None:
        """Let the run begin where the motion of the record does: position and speed by the equation fitted to it."""
        if name not in self.channels:
            raise ModelError(f"release: '{name}' is no channel of the record that counts.")
        motion = decay_equation(self.channels[name])
        self.time = self.channels[name].time
        self.state = lambda values: self._released(name, motion.begin, values)

    def _released(self, name: str, begin: tuple[float, float], values: np.ndarray) -> Any:
        """The equilibrium with these values, moved by the offset and given the speed."""
        parameters = self.with_values(values)
        rest = self.plant.equilibrium(parameters=parameters)
        linear = self.plant.linearize(rest, outputs=[name])
        state, slope = state_behind(self.plant, linear, name)
        offset, speed = begin[0] / slope, begin[1] / slope
        moved = {state: float(np.asarray(rest[state])) + offset}
        rates = np.asarray(linear.matrices["A"])[list(linear.states).index(state)]
        first = int(np.argmax(np.abs(rates)))
        if np.count_nonzero(np.abs(rates) > 1e-9 * np.abs(rates).max()) == 1:
            moved[linear.states[first]] = speed / float(rates[first])
        elif abs(speed) > 1e-3 * abs(offset):
            raise ModelError(f"release: the speed of {name} is no state of its own; cut the record where it turns.")
        return self.plant.initial_state(parameters=parameters, start=moved, base=rest)

    # --- runs -------------------------------------------------------------------------------------------------------

    def with_values(self, values: np.ndarray) -> dict[str, Any]:
        """The parameters of a run with these values of the elements."""
        parameters = dict(self.parameters)
        for item, value in zip(self.elements, values.tolist(), strict=True):
            parameters = TunedRun(self.plant, parameters, [item]).changed(item, value)
        return {path: value.tolist() if isinstance(value, np.ndarray) else value for path, value in parameters.items()}

    def simulated(self, values: np.ndarray, slopes: bool) -> tuple[dict[str, np.ndarray], np.ndarray | None]:
        """The channels at the times of the record, and their derivatives (n k, m)."""
        key = values.tobytes()
        if key in self.known and not (slopes and self.known[key][1] is None):
            return self.known[key]
        parameters, state = self.with_values(values), self.state(values)
        duration = float(self.time[-1] - self.time[0])
        output_step = float(self.time[1] - self.time[0])
        begin = {"start": state, "parameters": parameters, "output_step": output_step}
        self.runs += 1
        table = None
        if slopes and self.gradients == "exact":
            try:
                found = sensitivities(self.plant, [item.name for item in self.elements], list(self.channels),
                                      t_end=duration, **begin, **self.options)  # fmt: skip
                result = found.run
                table = np.vstack([
                    self._at(result.time, np.column_stack([found.array(name, item.name) for item in self.elements]))
                    for name in self.channels
                ])  # fmt: skip
            except (ParameterError, SimulationError) as error:
                self.gradients = f"differences: {error}"
        if table is None:
            result = self.plant.simulate(duration, solver="fixed", **begin, **self.options)
        motions = {name: self._at(result.time, result.array(name)) for name in self.channels}
        self.known[key] = motions, table
        return self.known[key]

    def _at(self, time: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Values of a run at the times of the record."""
        from scipy.interpolate import CubicSpline

        return CubicSpline(time, values, axis=0)(self.time - self.time[0])

    def weights(self) -> dict[str, tuple[np.ndarray, float]]:
        """Which points of a channel count, and what it is divided by."""
        counted = self.time >= self.time[0] + self.discard - 1e-9
        return {name: (counted, 1 / float(one.values[counted].std())) for name, one in self.channels.items()}

    def residuals(self, scaled: np.ndarray) -> np.ndarray:
        motions, _ = self.simulated(scaled * self.sizes, False)
        rows = []
        for name, (counted, weight) in self.weights().items():
            rest = (self.channels[name].values - motions[name])[counted]
            rows.append(weight * (rest - rest.mean() if self.constants else rest))
        found = np.concatenate(rows)
        square = float(np.mean(found**2))
        if self.nearest is None or square < self.nearest[0]:
            self.nearest = square, scaled * self.sizes
        return found

    def slopes(self, scaled: np.ndarray) -> np.ndarray:
        _, table = self.simulated(scaled * self.sizes, True)
        if table is None:
            return self._differences(scaled)
        blocks = np.split(table * self.sizes, len(self.channels))
        rows = []
        for block, (counted, weight) in zip(blocks, self.weights().values(), strict=True):
            inside = block[counted]
            rows.append(-weight * (inside - inside.mean(axis=0) if self.constants else inside))
        return np.vstack(rows)

    def _differences(self, scaled: np.ndarray) -> np.ndarray:
        columns = []
        for k in range(scaled.size):
            moved = [scaled + sign * _DIFFERENCE * np.eye(scaled.size)[k] for sign in (1, -1)]
            columns.append((self.residuals(moved[0]) - self.residuals(moved[1])) / (2 * _DIFFERENCE))
        return np.column_stack(columns)

    # --- the fit ----------------------------------------------------------------------------------------------------

    def found(self) -> Calibration:
        """The fit; CalibrationStopped where it is interrupted after its first run."""
        try:
            return self._found()
        except KeyboardInterrupt:
            if self.nearest is None:
                raise
            square, values = self.nearest
            named = {item.name: float(value) for item, value in zip(self.elements, values, strict=True)}
            units = {item.name: item.unit for item in self.elements}
            raise CalibrationStopped(named, units, float(np.sqrt(square)), self.runs) from None

    def _found(self) -> Calibration:
        from scipy.optimize import least_squares

        begin = self.start_values / self.sizes
        self.refuse_unknown(self.slopes(begin))
        low = np.array([_bound(item.min, item.number, -np.inf) for item in self.elements]) / self.sizes
        high = np.array([_bound(item.max, item.number, np.inf) for item in self.elements]) / self.sizes
        best = least_squares(self.residuals, np.clip(begin, low + 1e-12, high - 1e-12), self.slopes, (low, high),
                             xtol=1e-8, ftol=1e-10, gtol=1e-12, max_nfev=60)  # fmt: skip
        if not best.success:
            raise ModelError("the calibration does not come to an end in 60 runs; take other parameters, or a start "
                             "nearer to the record.")  # fmt: skip
        rest, table = self.residuals(best.x), self.slopes(best.x)
        self.refuse_unknown(table)
        covariance = covariance_of(table, rest) * _inflation(rest, len(self.channels))
        errors = np.sqrt(np.diag(covariance))
        values, freedom = best.x * self.sizes, max(rest.size / _inflation(rest, len(self.channels)) - best.x.size, 1.0)
        estimates = tuple(Estimate(float(v), float(e), float(freedom)) for v, e in zip(values, errors * self.sizes,
                                                                                       strict=True))  # fmt: skip
        after, before = (self.simulated(x * self.sizes, False)[0] for x in (best.x, begin))
        shifts = {name: self._constant(name, after) for name in self.channels}
        return Calibration(
            tuple(item.name for item in self.elements), tuple(item.unit for item in self.elements), self.start_values,
            estimates, covariance / np.outer(errors, errors), self.with_values(values), self.time, self.channels,
            {name: motion + shifts[name] for name, motion in after.items()},
            {name: motion + self._constant(name, before) for name, motion in before.items()}, shifts, self.gradients,
            self.runs,
        )  # fmt: skip

    def _constant(self, name: str, motions: Mapping[str, np.ndarray]) -> float:
        counted, _ = self.weights()[name]
        return float((self.channels[name].values - motions[name])[counted].mean()) if self.constants else 0.0

    def refuse_unknown(self, table: np.ndarray) -> None:
        """ModelError where the record tells nothing of a parameter, or two of them only together."""
        sizes = np.linalg.norm(table, axis=0) / np.sqrt(len(table))
        for item, size in zip(self.elements, sizes, strict=True):
            if size < _SMALL:
                raise ModelError(f"{item.name} cannot be fitted: the record does not change with it.")
        _, singular, rows = np.linalg.svd(table / sizes, full_matrices=False)
        if singular[-1] < RANK * singular[0]:
            together = np.argsort(-np.abs(rows[-1]))[:2]
            names = " and ".join(self.elements[k].name for k in sorted(together))
            raise ModelError(
                f"{names} cannot be told apart by this record: it changes with both in the same way; fit one of them, "
                "or add a channel or a test that tells them apart."
            )


def _channels(
    plant: Any, record: Result | Mapping[str, SeriesLike], results: Sequence[str] | None
) -> dict[str, Series]:
    """The channels that count, at common times, in the units of the model."""
    from fowtlib.language.units import conversion, parse_unit

    if isinstance(record, Result):
        there = {name: Series(record.time, values, unit, name) for name, unit, values in record.stored.columns()}
    else:
        there = {name: as_series(series, name) for name, series in record.items()}
    names = [name for name in there if name in plant.outputs] if results is None else list(results)
    if not names:
        raise ModelError(f"the record has no channel that is a result of the model; it has {', '.join(there)}.")
    found: dict[str, Series] = {}
    for name in names:
        for known, what in ((there, "the record"), (plant.outputs, "the model")):
            if name not in known:
                raise ModelError(f"{what} has no '{name}'; it has {', '.join(list(known)[:12])}.")
        series, unit = there[name], plant.outputs[name][1]
        factor = 1.0
        if series.unit not in ("1", "", unit):
            one, out = parse_unit(series.unit), parse_unit(unit)
            if one.dimension != out.dimension:
                raise ModelError(f"the record has {name} in {series.unit}, and the model in {unit}.")
            factor = conversion(one, out)
        _ = series.step
        first = next(iter(found.values()), series)
        if series.time.shape != first.time.shape or np.abs(series.time - first.time).max() > 1e-6:
            raise ModelError(f"{name} and {first.name} are not at the same times; interpolate one of them.")
        if np.ptp(series.values) == 0.0:
            raise ModelError(f"{name} does not change in the record, so nothing can be fitted to it.")
        found[name] = Series(series.time, factor * series.values, unit, name)
    return found


def _bound(declared: Any, number: int, none: float) -> float:
    """The bound of one element; declared for all of them, or for each."""
    if declared is None:
        return none
    bounds = np.ravel(np.asarray(declared, dtype=float), order="F")
    return float(bounds[number if bounds.size > 1 else 0])


def _inflation(rest: np.ndarray, channels: int) -> float:
    """(1 + r)/(1 - r) of the correlation r of neighbouring residuals within the channels; 1 or more."""
    parts = np.split(rest, channels)
    power = sum(float(part @ part) for part in parts)
    r = sum(float(part[1:] @ part[:-1]) for part in parts) / power if power > 0 else 0.0
    return (1 + max(r, 0.0)) / max(1 - r, 1e-3)
