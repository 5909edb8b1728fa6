"""Plant: a compiled model. Frozen; states, results and linear models come from its methods."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.component import Component
from fowtlib.language.errors import NotFoundError, ParameterError, SimulationError, did_you_mean
from fowtlib.language.externals import refusals_explained
from fowtlib.language.units import from_si, to_si
from fowtlib.language.upstairs import handed_in
from fowtlib.solving.binding import Binding, Bindings, structural_values
from fowtlib.solving.conditions import Conditions
from fowtlib.solving.engine import create_engine
from fowtlib.solving.equilibrium import equilibrium
from fowtlib.solving.evaluation import Evaluation
from fowtlib.solving.initial import consistent_algebraics, initial_values
from fowtlib.solving.linear import LinearModel
from fowtlib.solving.results import Continuation, Observer, RawTrajectory, Result
from fowtlib.solving.state import State

if TYPE_CHECKING:
    from fowtlib.solving.fixed_step_code import FixedStepCode

Values = Mapping[str, Any]


class Plant:
    """A model as one flat DAE, ready for numbers.

    outputs: name -> (path of a variable, unit, description), as the model file gives them; without any, all states.
    """

    def __init__(self, dae: FlatDAE, outputs: Mapping[str, Any] | None = None, *, name: str = "", title: str = "",
                 settings: Mapping[str, Any] | None = None, root: Any = None):  # fmt: skip
        self.dae = dae
        self.name = name
        self.title = title
        self.root = copy.deepcopy(root)  # what is done to the model later is no part of this
        self._bindings = Bindings(dae, self.root)
        self.settings = dict(settings or {})
        self._declared = dict(outputs or {})
        self.outputs = {name: self._output(name, item) for name, item in self._declared.items()} or {
            quantity.path: (quantity.path, quantity.unit, quantity.doc) for quantity in dae.states
        }
        self._evaluations: dict[bytes, Evaluation] = {}

    @cached_property
    def structure(self) -> dict[str, Any]:
        """Structural and bound parameters of all parts; see structural_values."""
        return structural_values(self.root)

    @property
    def stats(self) -> dict[str, float]:
        """Counts and times of the flattening."""
        return self.dae.stats

    def _output(self, name: str, item: Any) -> tuple[str, str, str]:
        path, unit, doc = (item, None, "") if isinstance(item, str) else (item.of, item.unit, item.doc)
        self._known(path, f"output '{name}'")
        si, long_name = self.describe(path)
        from_si(1.0, si, unit or si, f"output '{name}'")
        return path, unit or si, doc or long_name

    def _known(self, path: str, where: str) -> None:
        try:
            self.dae.observe_expression(path)
        except NotFoundError as error:
            raise error.at(where) from None

    def describe(self, path: str) -> tuple[str, str]:
        """SI unit and description of any variable."""
        dae = self.dae
        key = next((key for key in (path, f"{path}[0]", f"{path}[0,0]") if key in dae.units), path)
        return dae.units.get(key, "1"), dae.docs.get(key, "") or path

    # --- parameters and states -----------------------------------------------------------------------------------

    def parameter_values(self, parameters: Values | None = None) -> dict[str, np.ndarray]:
        """Values of all tunable parameters in SI, with those given put in."""
        return dict(self.binding(parameters).values)

    def binding(self, parameters: Values | None = None) -> Binding:
        """What a run with these parameters takes in; see fowtlib.solving.binding.bind."""
        return self._bindings(parameters)

    def evaluation(self, parameters: Values | None = None) -> Evaluation:
        """The numeric functions at parameter values; kept for the next call with the same values."""
        binding = self.binding(parameters)
        key = binding.p.tobytes()
        if key not in self._evaluations:
            if len(self._evaluations) >= 4:
                self._evaluations.pop(next(iter(self._evaluations)))
            self._evaluations[key] = Evaluation(self.dae, binding.p)
            self._evaluations[key].binding = binding  # its data stay known as long as the functions are used
        return self._evaluations[key]

    @cached_property
    def fixed_step_code(self) -> FixedStepCode:
        """The compiled functions of the solver "fixed"; the same for all values of tunable parameters."""
        from fowtlib.solving.fixed_step_code import FixedStepCode

        return FixedStepCode(self.dae, [path for path, _, _ in self.outputs.values()])

    def inputs(self, inputs: Values | None = None) -> np.ndarray:
        """Values of the inputs of the model: their defaults, with those given put in."""
        values = {path: item.default for path, item in self.dae.inputs.items()}
        for path, value in (inputs or {}).items():
            if path not in values:
                raise ParameterError(f"there is no input '{path}'{did_you_mean(path, values)}")
            item = self.dae.inputs[path]
            values[path] = np.broadcast_to(
                np.asarray(to_si(value, item.unit, path), dtype=float).ravel(), item.default.shape
            )
        return np.concatenate(list(values.values())) if values else np.zeros(0)

    def start_opened_inputs(self) -> None:
        """Inputs that a part of the model drove before take its value at the start."""
        opened = [item for item in self.dae.inputs.values() if item.driver]
        if not opened:
            return
        state = self.initial_state()
        for item in opened:
            item.default = np.ravel(np.asarray(self._observe_state(item.driver, state), dtype=float), order="F")

    @refusals_explained()
    def initial_state(self, parameters: Values | None = None, start: Values | None = None, inputs: Values | None = None,
                      t: float = 0.0, base: State | None = None) -> State:  # fmt: skip
        """The consistent state at the start of a simulation.

        start: values of states (SI or with unit) in place of their start values; of an algebraic unknown, a guess.
        base: a state to change by `start`, instead of the start values.
        """
        evaluation = self.evaluation(parameters)
        x, z, d, _ = evaluation.start_values()
        if base is not None:
            x, z, d = base.x.copy(), base.z.copy(), base.d.copy()
            t = base.t
        u = self.inputs(inputs)
        given: set[int] = set()
        guesses = {quantity.path: k for k, quantity in enumerate(self.dae.algebraics)}
        discretes = {quantity.path: k for k, quantity in enumerate(self.dae.discretes)}
        for path, value in (start or {}).items():
            unit, _ = self.describe(path)
            number = to_si(value, unit, path)
            if path in self.dae.state_number:
                x[self.dae.state_number[path]] = number
                given.add(self.dae.state_number[path])
            elif path in guesses:
                z[guesses[path]] = number
            elif path in discretes:
                d[discretes[path]] = number
            else:
                names = [*self.dae.state_number, *guesses, *discretes]
                raise ParameterError(
                    f"'{path}' is not a state and cannot be given a start value{did_you_mean(path, names)}"
                )
        q = np.concatenate([u, d])
        if base is not None:
            z = consistent_algebraics(evaluation, t, x, z, q)
        else:
            x, z = initial_values(evaluation, t, x, z, q, given)
        return self._state(t, x, z, d, u, parameters)

    @refusals_explained()
    def equilibrium(self, parameters: Values | None = None, hold: Values | None = None, start: Values | None = None,
                    inputs: Values | None = None) -> State:  # fmt: skip
        """The state at which nothing changes, with the controllers in the loop; `hold` keeps states at values."""
        state = self.initial_state(parameters, {**(start or {}), **(hold or {})}, inputs)
        held = {self.dae.state_number[path] for path in hold or {}}
        q = np.concatenate([state.u, state.d])
        x, z = equilibrium(self.evaluation(parameters), state.t, state.x, state.z, q, held)
        return self._state(state.t, x, z, state.d, state.u, parameters)

    def _state(
        self, t: float, x: np.ndarray, z: np.ndarray, d: np.ndarray, u: np.ndarray, parameters: Values | None
    ) -> State:
        return State(t, x, z, d, u, dict(parameters or {}), self._observe_state)

    @refusals_explained()
    def _observe_state(self, name: str, state: State) -> np.ndarray:
        if name in self.outputs and self._declared:
            path, unit, _ = self.outputs[name]
            return np.asarray(from_si(self._observe_state(path, state), self.describe(path)[0], unit))
        function = self.evaluation(state.parameters).function("observe", [self.dae.observe_expression(name)])
        return np.array(function(state.t, state.x, state.z, np.concatenate([state.u, state.d])))

    def resume_point(self, continuation: Continuation, parameters: Values | None, inputs: Values | None) -> State:
        """The state at the end of an earlier result."""
        groups = []
        for quantities, values in (
            (self.dae.states, continuation.x),
            (self.dae.algebraics, continuation.z),
            (self.dae.discretes, continuation.d),
        ):  # fmt: skip
            missing = [q.path for q in quantities if q.path not in values]
            if missing:
                raise SimulationError(
                    f"the result to resume from is of another model: it has no {missing[0]}. "
                    "Resume with the model it came from."
                )
            groups.append(np.array([values[q.path] for q in quantities]))
        x, z, d = groups
        return self._state(continuation.time, x, z, d, self.inputs(inputs), parameters)

    def observer(self, raw: RawTrajectory, parameters: Values | None = None) -> Observer:
        """What rebuilds any variable along an earlier trajectory of this model, with the inputs at their defaults."""
        from fowtlib.solving.observation import Observation

        if raw.x_names != tuple(q.path for q in self.dae.states):
            raise SimulationError("the result is of another model: its states are not those of this one.")
        u = np.repeat(self.inputs()[None], len(raw.time), axis=0)
        observation = Observation(self, self.evaluation(parameters), raw.time, raw.x, raw.z, u, raw.d)
        root = self.binding(parameters).root
        return Observer(observation.values, self.describe, self.dae.names, root)

    # --- uses ----------------------------------------------------------------------------------------------------

    @refusals_explained()
    def simulate(
        self,
        t_end: float | str | None = None,
        output_step: float | str | None = None,
        *,
        start: State | Result | Values | None = None,
        parts: Mapping[str, Component] | None = None,
        solver: str | None = None,
        step: float | str | None = None,
        tolerance: float | None = None,
        rho_inf: float | None = None,
        parameters: Values | None = None,
        inputs: Values | None = None,
        outputs: Sequence[str] | None = None,
        progress: Callable[[float, float], None] | bool = False,
        conditions: Conditions | None = None,
    ) -> Result:
        """Simulate to `t_end` [s] and give the outputs every `output_step` [s].

        start: a State, an earlier Result to go on from, or start values by path. solver: "idas", with steps of its own,
        or "fixed", with equal steps of at most `step` [s], whose fastest oscillations keep the share `rho_inf` of their
        amplitude at each step. Arguments left out come from the model file, else t_end 600 s, output_step 0.1 s, solver
        "idas", step 12.5 ms, tolerance 1e-6, rho_inf 0.8. Raises SimulationError; its attribute `result` holds what was
        computed.

        parameters: by path, tunable and bound ones. parts: by path, components that take the place of others of their
        family for this run, as in `parts={"wind": SteadyWind(mean_speed=8)}`; nothing is flattened or compiled anew.
        conditions: all of this as one value; what is given beside it counts more.
        """
        from fowtlib.solving.simulation import Simulation

        given = Conditions(parts or {}, parameters or {}, inputs, start, t_end, output_step, None, outputs)
        chosen_here = given.over(conditions)
        t_end, output_step, outputs = chosen_here.duration, chosen_here.output_step, chosen_here.outputs
        start, inputs = chosen_here.start, chosen_here.inputs
        parameters = chosen_here.values or (None if parameters is None else {})  # None: those of a state to start from

        def chosen(value: Any, key: str, default: Any) -> Any:
            return self.settings.get(key, default) if value is None else value

        end, interval, relative = (
            float(to_si(chosen(value, key, default), unit, key))
            for value, key, default, unit in (
                (t_end, "duration", 600.0, "s"),
                (output_step, "output_step", 0.1, "s"),
                (tolerance, "tolerance", 1e-6, "1"),
            )
        )
        if not 0 < relative < 1:
            raise ParameterError(f"the tolerance is {relative:g}; it must lie between 0 and 1, usually 1e-4 to 1e-9.")
        engine = create_engine(
            self, start.parameters if isinstance(start, State) and parameters is None else parameters,
            chosen(solver, "solver", "idas"), relative, interval, {"step": step, "rho_inf": rho_inf}, self.settings,
        )  # fmt: skip
        if isinstance(start, Result):
            binding = self.binding(parameters)
            start.check_resumable(binding.values, binding.structure)
            state = self.resume_point(start.final, parameters, inputs)
        elif isinstance(start, State):
            parameters = start.parameters if parameters is None else parameters
            same = parameters == start.parameters and inputs is None
            state = start if same else self.initial_state(parameters, None, inputs, base=start)
        else:
            state = self.initial_state(parameters, start, inputs)
        simulation = Simulation(self, state, engine, parameters, outputs, isinstance(start, Result))
        return simulation.run(end, interval, progress, chosen_here.discard or 0.0)

    @refusals_explained()
    def linearize(self, state: State, inputs: Sequence[str] = (), outputs: Sequence[str] | None = None) -> LinearModel:
        """Exact linear model at a state, from inputs or tunable parameters by path to results or variables.

        All states are kept; algebraic unknowns are eliminated.
        """
        dae = self.dae
        names = list(self.outputs) if outputs is None else list(outputs)
        positions = self._positions()
        kept: list[int] = []
        columns, labels = [], []
        for path in inputs:
            if path in positions["inputs"]:
                first, count = positions["inputs"][path]
                columns += [dae.u[i] for i in range(first, first + count)]
            elif path in positions["parameters"]:
                first, count = positions["parameters"][path]
                kept += range(first, first + count)
                columns += [dae.p[i] for i in range(first, first + count)]
            else:
                known = [*positions["inputs"], *positions["parameters"]]
                raise NotFoundError(f"there is no input or tunable parameter '{path}'{did_you_mean(path, known)}")
            labels += [path] if count == 1 else [f"{path}[{i}]" for i in range(count)]
        vector = self.binding(state.parameters).p
        evaluation = Evaluation(dae, vector, kept) if kept else self.evaluation(state.parameters)
        rows, factors, out_labels, units = [], [], [], {}
        for name in names:
            path, unit, _ = self.outputs[name] if name in self.outputs else (name, self.describe(name)[0], "")
            expression = ca.vec(dae.observe_expression(path))
            factor = float(from_si(1.0, self.describe(path)[0], unit))
            rows.append(expression)
            factors += [factor] * expression.shape[0]
            fresh = [name] if expression.shape[0] == 1 else [f"{name}[{i}]" for i in range(expression.shape[0])]
            out_labels += fresh
            units |= dict.fromkeys(fresh, unit)
        u = ca.vertcat(*columns) if columns else ca.SX(0, 1)
        slopes = evaluation.torn_jacobian("linear", ca.vertcat(dae.ode, dae.alg, *rows), [dae.x, dae.z, u])
        q = np.concatenate([state.u, state.d, vector[kept]])
        by_x, by_z, by_u = (np.array(ca.densify(block)) for block in slopes(state.t, state.x, state.z, q))
        nx, nz = dae.x.shape[0], dae.z.shape[0]
        ode, alg, out = slice(0, nx), slice(nx, nx + nz), slice(nx + nz, None)
        by_xu = np.hstack([by_x[alg], by_u[alg]])
        dz = -np.linalg.solve(by_z[alg], by_xu) if nz else by_xu
        A, B = by_x[ode] + by_z[ode] @ dz[:, :nx], by_u[ode] + by_z[ode] @ dz[:, nx:]
        scale = np.array(factors)[:, None] if factors else np.zeros((0, 1))
        C, D = (by_x[out] + by_z[out] @ dz[:, :nx]) * scale, (by_u[out] + by_z[out] @ dz[:, nx:]) * scale
        return LinearModel(A, B, C, D, [s.path for s in dae.states], labels, out_labels, units)

    @refusals_explained()
    def export_fmu(self, path: str | Path | None = None, **options: Any) -> Path:
        """Write a Functional Mock-up Unit, `<name>.fmu` unless a path is given; see fowtlib.fmi.export_fmu."""
        return handed_in("export_fmu")(self, path, **options)

    def _positions(self) -> dict[str, dict[str, tuple[int, int]]]:
        """First element and length of each input in u and of each parameter in p."""
        table: dict[str, dict[str, tuple[int, int]]] = {}
        for group, items in (("inputs", self.dae.inputs), ("parameters", self.dae.parameters)):
            first, table[group] = 0, {}
            for path, item in items.items():
                table[group][path] = (first, item.symbol.numel())
                first += item.symbol.numel()
        return table

    def __repr__(self) -> str:
        return f"<Plant {self.title or self.name}: {self.dae!r}>"
