"""Gradients of results by parameters, exact, by adjoints: of the mean, of modes, of the response to waves and wind.

Any set of tunable parameters, however many, costs one adjoint for each result, through the equilibrium, the linear
model about it, the answers at all frequencies, the fixed point of the drag, and the poles. See docs/gradients.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from fowtlib.analysis.plants import plant_of, refuse_unstable
from fowtlib.frequency.adjoint import Asked, Forcing, RandomResponse, Slopes
from fowtlib.frequency.known_rows import Known
from fowtlib.frequency.quantities import (
    Mean,
    ModeDamping,
    ModeFrequency,
    Quantity,
    label,
    quantities,
    with_slopes,
)
from fowtlib.frequency.responses import Process, _processes, _refuse_without_spectrum, _signals
from fowtlib.frequency.settled import SettledResponse
from fowtlib.frequency.settling import settled_gains
from fowtlib.frequency.signal_slopes import SignalSlopes
from fowtlib.frequency.studies import study_of
from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError, ParameterError, did_you_mean
from fowtlib.language.expressions import one_evaluation, parameters_read
from fowtlib.language.run_time import RestingPlaces
from fowtlib.solving import State, mean_state
from fowtlib.solving.differences import derivative
from fowtlib.solving.excited import ExcitedModel, Signal, excited_model
from fowtlib.solving.known_slopes import Known as KnownOfRun
from fowtlib.solving.linear import NOTHING
from fowtlib.solving.pullback import Pullback
from fowtlib.solving.random_fields import blows
from fowtlib.solving.stationary_gradients import Bars, LinearGradient, Partial, Pole, pole, refuse_turning
from fowtlib.solving.tuned import TunedRun, tuned_elements

if TYPE_CHECKING:
    import xarray

Plant = Any
Values = Mapping[str, Any]

NEAR = 1e-4  # change of the gains of drag from which on Newton's iteration goes to their rounding
NEAREST = 2.0  # factor within which a mode that is named by its frequency must be
PLACES = 10.0  # m; a thousandth of it is the step by which a place in a field is moved


@dataclass(frozen=True, eq=False)
class Gradient:
    """Values of results, and their derivatives by parameters.

    results, units, values (k,); parameters, parameter_units, at (m,): values of the parameters [SI]; jacobian (k, m):
    d result / d parameter, in the unit of the result per SI unit of the parameter. `gradient["std pitch", "length"]`.
    """

    results: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    parameters: tuple[str, ...]
    parameter_units: tuple[str, ...]
    at: np.ndarray
    jacobian: np.ndarray

    def __getitem__(self, which: tuple[str, str]) -> float:
        if not isinstance(which, tuple) or len(which) != 2:
            raise ModelError(f"a derivative is that of a result by a parameter, as in gradient['std pitch', "
                             f"'platform.hull.mass'], not {which!r}.")  # fmt: skip
        result, parameter = which
        return float(self.jacobian[_number(result, self.results, "result"),
                                   _number(parameter, self.parameters, "parameter")])  # fmt: skip

    def unit(self, result: str, parameter: str) -> str:
        """Unit of a derivative."""
        above = self.units[_number(result, self.results, "result")]
        below = self.parameter_units[_number(parameter, self.parameters, "parameter")]
        return above if below == "1" else f"{above}/{below}" if below.isalpha() else f"{above}/({below})"

    @property
    def relative(self) -> np.ndarray:
        """Relative change of each result for a relative change of each parameter (k, m)."""
        return self.jacobian * self.at / self.values[:, None]

    @property
    def dataset(self) -> xarray.DataArray:
        """The derivatives over the coordinates ``result`` and ``parameter``."""
        import xarray

        coordinates = {
            "result": list(self.results), "parameter": list(self.parameters), "value": ("result", self.values),
            "unit": ("result", list(self.units)), "at": ("parameter", self.at),
            "parameter_unit": ("parameter", list(self.parameter_units)),
        }  # fmt: skip
        return xarray.DataArray(self.jacobian, dims=("result", "parameter"), coords=coordinates, name="gradient")

    def __repr__(self) -> str:
        lines = ["<Gradient>"]
        for k, (result, unit) in enumerate(zip(self.results, self.units, strict=True)):
            lines.append(f"{result} = {self.values[k]:.6g} {unit}")
            lines += [f"  by {name:40}{self.jacobian[k, j]:>14.6g} {self.unit(result, name)}"
                      for j, name in enumerate(self.parameters)]  # fmt: skip
        return "\n".join(lines)


def _number(name: str, known: Sequence[str], what: str) -> int:
    if name not in known:
        raise ModelError(f"there is no {what} '{name}' in this gradient{did_you_mean(name, known)}")
    return list(known).index(name)


def gradient(model: Any, results: Sequence[str | Quantity] | str | Quantity, by: Sequence[str], *,
             parameters: Values | None = None, frequencies: Sequence[float] | np.ndarray | None = None,
             free: Values | Sequence[str] | None = None, targets: Values | None = None) -> Gradient:  # fmt: skip
    """The gradient of results of a model, or of a compiled one, with respect to parameters.

    results      such as "mean pitch", "std pitch", "max thrust", "range pitch", "frequency heave", "damping surge", or
                 quantities of fowtlib.frequency with options: Extreme("pitch", "max", 3 * 3600), OfSpectrum(...)
    by           paths of tunable parameters, or of single elements; also numbers that a sea or a wind reads
    parameters   as for a run: what wind and what waves, for instance
    frequencies  [Hz], rising; None: chosen by the modes; they stay what they are when the parameters change
    free         parameters that take the values at which `targets` hold in the mean, see Plant.equilibrium: ballast
                 that fills until the draft is right; they do so with every change of the others
    Raises ParameterError for what is no tunable number, and says why; SimulationError where there is no derivative.
    """
    prepared = PreparedGradient(model, results, by, parameters=parameters, frequencies=frequencies, free=free,
                                targets=targets)  # fmt: skip
    values, jacobian = prepared.evaluate()
    return Gradient(prepared.results, prepared.units, values, prepared.parameters, prepared.parameter_units,
                    prepared.start, jacobian)  # fmt: skip


class PreparedGradient:
    """Results and their gradients at one point after the other, as an optimiser asks for them.

    The protocol: `results`, `units` (k names), `parameters`, `parameter_units`, `low`, `high` (m names, SI units and
    bounds, infinite where there are none), `start` (m values [SI]), and

        values, jacobian = prepared.evaluate(point)      # point (m,) in SI; (k,) and (k, m)
        values = prepared.values(point)                  # the same values alone, in a part of the time

    Each point starts from the equilibrium and the gains of the last one. The frequencies are those of the first point,
    so that results are smooth functions of the parameters; `choose_frequencies()` before a point chooses anew.
    tolerance: of the gains of drag, relative, in `values`; None: to rounding, as they always are in `evaluate`.
    Raises SimulationError where a point has no equilibrium, or no stable one.
    """

    def __init__(self, model: Any, results: Sequence[str | Quantity] | str | Quantity, by: Sequence[str], *,
                 parameters: Values | None = None, frequencies: Sequence[float] | np.ndarray | None = None,
                 free: Values | Sequence[str] | None = None, targets: Values | None = None,
                 tolerance: float | None = None):  # fmt: skip
        self.plant, self.tolerance = plant_of(model), tolerance
        self.quantities = quantities(results)
        if not self.quantities or not len(by):
            raise ModelError("a gradient is of one result or more, by one parameter or more.")
        self.elements = tuned_elements(self.plant, by, parameters)
        self.given = dict(parameters or {})
        self.frequencies = None if frequencies is None else np.asarray(frequencies, dtype=float)
        self.start = TunedRun(self.plant, self.given, self.elements).values
        names = [item.of for item in self.quantities if not isinstance(item, ModeFrequency)]
        self.free, self.targets = free or (), dict(targets or {})
        self.freed = tuned_elements(self.plant, list(self.free))
        if both := {item.name for item in self.freed} & {item.name for item in self.elements}:
            raise ModelError(f"{both.pop()} is free, and follows from the others: there is no derivative by it.")
        self.names = list(dict.fromkeys([*names, *self.targets]))
        self.columns = [self.names.index(item.of) if not isinstance(item, ModeFrequency) else -1
                        for item in self.quantities]  # fmt: skip
        for name in self.names:
            self._check(name)
        self.units = tuple(item.unit("1" if k < 0 else self.plant.outputs.entry(self.names[k]).unit)
                           for item, k in zip(self.quantities, self.columns, strict=True))  # fmt: skip
        self.results = tuple(label(item) for item in self.quantities)
        self.parameters = tuple(item.name for item in self.elements)
        self.parameter_units = tuple(item.unit for item in self.elements)
        self.low = np.array([-np.inf if item.min is None else item.min for item in self.elements])
        self.high = np.array([np.inf if item.max is None else item.max for item in self.elements])
        self._state: State | None = None
        self._gains: list[np.ndarray] | None = None
        self._newton: np.ndarray | None = None

    def _check(self, name: str) -> None:
        known = [*self.plant.outputs, *self.plant.dae.names]
        if name not in known:
            raise ModelError(f"the model has no result '{name}'{did_you_mean(name, known)}")
        size = self.plant.dae.observe_expression(self.plant.outputs.entry(name).path).numel()
        if size != 1:
            raise ModelError(f"a gradient is of one number, and {name} has {size}: take one of its elements.")

    def choose_frequencies(self) -> None:
        """At the next point the frequencies are chosen anew, by the modes there."""
        self.frequencies = None

    def values(self, point: Sequence[float] | np.ndarray | None = None) -> np.ndarray:
        """Results (k,) at values of the parameters (m,) [SI]; None: as they are."""
        return self._evaluated(point, slopes=False)[0]

    def evaluate(self, point: Sequence[float] | np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Results (k,) and their derivatives (k, m) at values of the parameters (m,) [SI]; None: as they are."""
        return self._evaluated(point, slopes=True)

    def _evaluated(self, point: Sequence[float] | np.ndarray | None, slopes: bool) -> tuple[np.ndarray, np.ndarray]:
        parameters = self._parameters(point)
        run = TunedRun(self.plant, parameters, self.elements)
        state, freed = self._mean(run), None
        self._state = state
        if self.freed:
            parameters = {**parameters, **{item.path: state.parameters[item.path] for item in self.freed}}
            run, freed = (TunedRun(self.plant, parameters, items) for items in (self.elements, self.freed))
        return _Evaluation(self, run, freed, state, slopes).found(slopes)

    def _parameters(self, point: Sequence[float] | np.ndarray | None) -> dict[str, Any]:
        """The parameters of a run at a point."""
        if point is None:
            return self.given
        point = np.asarray(point, dtype=float)
        if point.shape != (len(self.elements),):
            raise ModelError(f"a point has {len(self.elements)} values, not {point.size}.")
        run, whole = TunedRun(self.plant, self.given, self.elements), {}
        for item, value in zip(self.elements, point.tolist(), strict=True):
            array = np.array(whole.get(item.path, run.whole(item)), dtype=float)
            array.T.flat[item.number] = value
            whole[item.path] = array
        return {**self.given, **{path: value if value.shape else float(value) for path, value in whole.items()}}

    def _mean(self, run: TunedRun) -> State:
        """The mean state, from the last one if that is near enough."""
        if self.freed or self.targets:
            refuse_turning(self.plant, self.plant.initial_state(run.mean))
            return self.plant.equilibrium(run.mean, free=self.free, targets=self.targets, near=self._state)
        if self._state is None:
            refuse_turning(self.plant, self.plant.initial_state(run.mean))
            return mean_state(self.plant, run.mean)
        return self.plant.equilibrium(run.mean, near=self._state)


class _Evaluation:
    """All results at one point, and what their adjoints need."""

    def __init__(self, prepared: PreparedGradient, run: TunedRun, freed: TunedRun | None, state: State,
                 slopes: bool = True):  # fmt: skip
        self.prepared, self.run, self.freed = prepared, run, freed
        self.state, self.plant = state, prepared.plant
        kinds = prepared.quantities
        self.of_spectra = any(not isinstance(item, Mean | ModeFrequency) for item in kinds)
        further, self.excited = NOTHING, None
        self.response: RandomResponse | SettledResponse | None = None
        if self.of_spectra:
            self.excited = excited_model(self.plant, state, prepared.names)
            with study_of(self.plant).tree(run.parameters) as root, one_evaluation():
                self.fields = [number for number, (_, places) in enumerate(self.excited.fields) if blows(places, root)]
                self._refuse_fields()
                rough = None if slopes else prepared.tolerance
                self.response = self._response(root) if rough is None else self._settled(root, rough)
            further = self.excited.further
        self._further = further

    @cached_property
    def model(self) -> LinearGradient:
        """The linear model with its own gradients."""
        return LinearGradient(self.plant, self.state, self.prepared.names, self._further)

    def _refuse_fields(self) -> None:
        """ParameterError for what turns a field, of which no slope is taken."""
        for number in self.fields:
            for item in self.excited.fields[number][1]:
                owner = self.run.tree.find(item.owner)
                with parameters_read() as read:
                    item.compute.axes(owner)
                paths = {f"{path}.{name}" if path else name for path, name in read}
                if turned := next((element.name for element in self.run.elements if element.path in paths), None):
                    raise ParameterError(f"there is no derivative by {turned}, which turns a wind that is a field.")

    def _driving(self, root: Component, known: Known) -> dict[str, Process]:
        """The random processes that drive the model."""
        signals = _signals(self.excited, root, known)
        processes = _processes(self.excited, root, signals, known)
        _refuse_without_spectrum(self.plant.dae, root, processes)
        if not processes:
            raise ModelError("no part of this model takes anything from random waves or wind; there is no response.")
        for item in self.prepared.quantities:
            process = getattr(item, "process", None)
            if process is not None and process not in processes:
                raise ModelError(f"the response has no process '{process}'{did_you_mean(process, list(processes))}")
        return processes

    def _response(self, root: Component) -> RandomResponse:
        prepared, excited = self.prepared, self.excited
        processes = self._driving(root, study_of(self.plant).rows(self.run.parameters, root))
        gains = prepared._gains
        if prepared.frequencies is None or gains is None:
            gains, grid, _ = settled_gains(excited, processes, prepared.frequencies, NEAR, gains)
            prepared.frequencies = grid.frequency
        found = RandomResponse(excited, forcing(processes, prepared.frequencies), gains, prepared._newton)
        refuse_unstable(found.linear)
        prepared._gains, prepared._newton = found.gains, found.newton
        return found

    def _settled(self, root: Component, tolerance: float) -> SettledResponse:
        """The response without what slopes need."""
        prepared = self.prepared
        processes = self._driving(root, study_of(self.plant).rows(self.run.parameters, root))
        gains, grid, _ = settled_gains(self.excited, processes, prepared.frequencies, tolerance, prepared._gains)
        prepared.frequencies, prepared._gains = grid.frequency, gains
        return SettledResponse(self.excited, grid, gains)

    def found(self, slopes: bool) -> tuple[np.ndarray, np.ndarray]:
        """Values (k,) and derivatives (k, m)."""
        prepared = self.prepared
        count = len(prepared.quantities)
        values = np.zeros(count)
        weights = np.zeros((count, len(self.model.slopes.scale) if slopes else len(prepared.names)))  # of outputs
        means = np.array([float(np.squeeze(value)) for value in self.state.values(prepared.names)])
        driven: list[Slopes | None] = [None] * count
        bars: dict[int, Bars] = {}
        asked: dict[int, Asked] = {}
        for k, (item, column) in enumerate(zip(prepared.quantities, prepared.columns, strict=True)):
            if isinstance(item, Mean):
                values[k], weights[k, column] = means[column], 1.0
            elif isinstance(item, ModeFrequency):
                found = self._pole(item)
                values[k], by_A = found.damping if isinstance(item, ModeDamping) else found.frequency
                bars[k] = self._of_A(by_A)
            else:
                process = getattr(item, "process", None)
                moments = self.response.moments(column, process)
                unit = self.plant.outputs.entry(prepared.names[column]).unit
                values[k], by_moments, weights[k, column] = with_slopes(item, moments, means[column], unit, slopes)
                if slopes:
                    asked[k] = Asked(column, by_moments, process)
        if not slopes:
            return values, np.zeros((0, 0))
        if asked:
            found_of = self.response.slopes(list(asked.values()), self._moved_processes)
            for k, of in zip(asked, found_of, strict=True):
                driven[k], bars[k] = of, of.bars
                first = self.excited.results  # the inputs of the laws stand behind the results
                weights[k, first : first + of.means.size] = of.means
        partial = self.model.of_outputs(weights).plus(list(bars), self.model.of_matrices(list(bars.values())))
        targets = [prepared.names.index(name) for name in prepared.targets]
        if self.response is not None and self.fields:
            partial = partial + self._through_places(driven)
        total = self.model.total(partial, self.run, self.freed, targets)
        return values, total + self._through_processes(driven)

    # --- modes -----------------------------------------------------------------------------------------------------

    def _pole(self, item: ModeFrequency) -> Pole:
        A = self.model.linear.matrices["A"]
        return pole(A, self._eigenvalue(item, A), together=item.together, what=label(item))

    def _eigenvalue(self, item: ModeFrequency, A: np.ndarray) -> complex:
        roots, right = np.linalg.eig(A)
        upper = roots.imag > 0
        if not upper.any():
            raise ModelError(f"{label(item)}: no mode of the model oscillates.")
        if isinstance(item.of, int | float):
            return _nearest(roots[upper], item.of, label(item))
        path, states = self.plant.outputs.entry(item.of).path, self.model.linear.states
        if path not in states:
            row = self._state_behind(path)
            if row is None:
                known = [name for name, entry in self.plant.outputs.items() if entry.path in states]
                raise ModelError(f"{label(item)}: '{item.of}' is no state{did_you_mean(item.of, [*known, *states])}")
        else:
            row = states.index(path)
        share = np.abs(np.linalg.pinv(right).T * right)
        share = share / np.maximum(share.sum(axis=0), 1e-300)
        return roots[upper][np.argmax(share[row, upper])]

    def _state_behind(self, path: str) -> int | None:
        """The number of the state that a variable is an alias of."""
        expression = self.plant.dae.observed.get(path)
        known = [element.element_hash() for element in self.plant.dae.x.elements()]
        if expression is None or expression.numel() != 1 or expression.element_hash() not in known:
            return None
        return known.index(expression.element_hash())

    def _of_A(self, by_A: np.ndarray) -> Bars:
        slopes = self.model.slopes
        nx, columns, rows = len(by_A), len(slopes.columns), len(slopes.scale)
        if slopes.further.mixing is not None:
            columns = self.model.directions.v.shape[1] - nx
        return Bars(by_A, np.zeros((nx, columns)), np.zeros((rows, nx)), np.zeros((rows, columns)))

    # --- what drives it --------------------------------------------------------------------------------------------

    def _through_places(self, driven: Sequence[Slopes | None]) -> Partial:
        """Slopes through the places at which parts feel a field: its spectra depend on their distances."""
        items = [(number, k, item) for number in self.fields for k, item in enumerate(self.excited.fields[number][1])]
        kept = [(k, of) for k, of in enumerate(driven) if of is not None]
        frequency, at, columns = self.response.forcing.frequency, self.model.at, []
        by_density = [self.response.density_slopes(of) for _, of in kept]

        def weighted(now: Forcing) -> np.ndarray:
            """Slopes by drive and densities times these: scalars that change with them as the results do."""
            drives = {path: now.drive[:, now.driven[path], columns].transpose(1, 0, 2)
                      for path, columns in now.columns.items()}  # fmt: skip
            return np.array([sum(np.sum((of.drive[path].conj() * drive).real) for path, drive in drives.items())
                             + np.sum((density * now.density).real)
                             for (_, of), density in zip(kept, by_density, strict=True)])  # fmt: skip

        here = weighted(self.response.forcing)
        for number, k, item in items:
            for row in range(item.places.positions.size):

                def moved(value: float, number: int = number, k: int = k, row: int = row) -> np.ndarray:
                    excited = _with_position(self.excited, number, k, row, value)
                    return weighted(forcing(_processes(excited, self.run.tree), frequency))

                now = float(item.places.positions.ravel()[row])
                columns.append(derivative(moved, now, here=here, size=PLACES, what=f"the wind at {item.path}"))
        weights = np.zeros((len(columns), len(driven)))
        weights[:, [k for k, _ in kept]] = columns

        def rows() -> ca.SX:
            asked = [ca.vec(ca.densify(at.dae.externals[item.external].inputs)) for _, _, item in items]
            sizes = [item.places.positions.size for _, _, item in items]
            return ca.vertcat(*[column[column.numel() - size :] for column, size in zip(asked, sizes, strict=True)])

        key = ("places", *(item.external for _, _, item in items))
        state = self.state
        point = Pullback(at, key, rows).point(state.t, state.x, state.z, np.concatenate([state.u, state.d]))
        v, w = point.plain(weights)
        return Partial(v.T, w.T)

    def _through_processes(self, driven: Sequence[Slopes | None]) -> np.ndarray:
        """Slopes (k, m) through transfer functions and spectra of waves and wind, which are functions in Python.

        Only elements that these read are moved, and nothing but these functions is computed.
        """
        found = np.zeros((len(driven), len(self.run.elements)))
        if self.response is None:
            return found
        kept = [k for k, item in enumerate(driven) if item is not None]
        slopes = [driven[k] for k in kept]
        found[kept] = self._through_signals(slopes) + self._through_densities(slopes)
        return found

    @cached_property
    def _moved_signals(self) -> list[tuple[str, Signal, list[int], np.ndarray]]:
        """Signals that change with elements: their process, themselves, numbers of these elements, and slopes by them.

        Slopes (elements, q, signals, channels) are those per channel of the process.
        """
        driving = _signals(self.excited, self.run.tree)  # others stay at rest, as stations in a field
        places = [(path, signal) for path, (_, signals) in driving.items() for signal in signals]
        by_element = SignalSlopes(self.run, [signal for _, signal in places], self.response.omega)
        changes: list[list[tuple[int, np.ndarray]]] = [[] for _ in places]
        for column, item in enumerate(self.run.elements):
            for number, change in by_element.of(item).items():
                changes[number].append((column, change))
        return [(path, signal, [column for column, _ in of_signal], np.array([change for _, change in of_signal]))
                for (path, signal), of_signal in zip(places, changes, strict=True) if of_signal]  # fmt: skip

    @cached_property
    def _moved_processes(self) -> frozenset[str]:
        """Processes by whose drive slopes are asked for."""
        return frozenset(self.response.forcing.columns if self.fields else (path for path, *_ in self._moved_signals))

    def _through_signals(self, slopes: Sequence[Slopes]) -> np.ndarray:
        """Those through what signals are per channel of their process."""
        found = np.zeros((len(slopes), len(self.run.elements)))
        for path, signal, columns, moved in self._moved_signals:
            first = self.response.forcing.driven[path].tolist().index(signal.columns.start)
            rows, channels = slice(first, first + moved.shape[2]), slice(moved.shape[3])
            bars = np.array([of.drive[path][rows, :, channels] for of in slopes])
            bars, moved = bars.reshape(len(bars), -1), moved.transpose(0, 2, 1, 3).reshape(len(moved), -1)
            found[:, columns] += np.ascontiguousarray(bars).view(float) @ np.ascontiguousarray(moved).view(float).T
        return found

    def _through_densities(self, slopes: Sequence[Slopes]) -> np.ndarray:
        """Those through the spectra of processes."""
        known, omega = self.response.forcing, self.response.omega
        found = np.zeros((len(slopes), len(self.run.elements)))
        for path, columns in known.columns.items():

            def density(root: Component, path: str = path) -> np.ndarray:
                values = 2 * np.pi * np.asarray(_processes(self.excited, root)[path].density(omega), dtype=complex)
                return np.ravel(values).view(float)

            with self.run.beside().here() as (root, read):
                here = density(root)
            paths = {join(*place) for place in read}
            items = [item for item in self.run.elements if item.path in paths]
            name = ("density", path)
            apart = self.run.kept_apart(name, KnownOfRun({}), items, here, density)
            for item in (one for one in items if one.name not in apart):

                def moved(value: float, item: Any = item, density: Any = density) -> np.ndarray:
                    with self.run.tree_at(item, value) as root:
                        return density(root)

                slope = self.run.slope(item, moved, here)
                if slope.any():
                    change = slope.view(complex).reshape(omega.size, columns.stop - columns.start, -1)
                    found[:, self.run.elements.index(item)] += self.response.by_density(slopes, columns, change)
                else:
                    self.run.set_apart(name, item)
        return found


def _nearest(roots: np.ndarray, frequency: float, what: str) -> complex:
    """The pole nearest to an undamped frequency [Hz]. ModelError where none is within a factor of NEAREST."""
    known = np.abs(roots) / (2 * np.pi)
    k = int(np.argmin(np.abs(known - frequency)))
    if not known[k] / NEAREST < frequency < known[k] * NEAREST:
        raise ModelError(f"{what}: no mode is near {frequency:g} Hz, the nearest has {known[k]:.4g} Hz; a mode is "
                         "named by its frequency [Hz], or by the state that takes part most.")  # fmt: skip
    return complex(roots[k])


def _with_position(excited: ExcitedModel, number: int, k: int, row: int, value: float) -> ExcitedModel:
    """The model with one coordinate of a place in a field elsewhere, as far as its spectra go."""
    columns, members = excited.fields[number]
    positions = members[k].places.positions.copy()
    positions.reshape(-1)[row] = value
    item = replace(members[k], places=RestingPlaces(positions))
    fields = list(excited.fields)
    fields[number] = (columns, (*members[:k], item, *members[k + 1 :]))
    return replace(excited, fields=tuple(fields))


def forcing(processes: Mapping[str, Process], frequency: np.ndarray) -> Forcing:
    """What random processes drive, at frequencies (q,) [Hz]."""
    omega, blocks, drives, columns, first = 2 * np.pi * frequency, [], [], {}, 0
    for path, process in processes.items():
        density = 2 * np.pi * np.asarray(process.density(omega))
        density = density.reshape(len(density), *(density.shape[1:] or (1, 1)))
        blocks.append(density)
        drives.append(process.drive(omega))
        columns[path] = slice(first, first := first + density.shape[1])
    whole = np.zeros((omega.size, first, first), dtype=complex)
    for place, block in zip(columns.values(), blocks, strict=True):
        whole[:, place, place] = block
    driven = {path: process.driven for path, process in processes.items()}
    return Forcing(frequency, np.concatenate(drives, axis=2), whole, columns, driven)
