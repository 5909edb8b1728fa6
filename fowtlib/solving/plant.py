"""Plant: a compiled model, which gives states, results and linear models and is not changed by any of them."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.component import Component
from fowtlib.language.errors import SimulationError
from fowtlib.language.externals import refusals_explained
from fowtlib.language.native import compiler
from fowtlib.solving.binding import Binding
from fowtlib.solving.bindings import Bindings
from fowtlib.solving.checks import check_state, search_from
from fowtlib.solving.conditions import Conditions
from fowtlib.solving.engines import FixedStepCode
from fowtlib.solving.engines.fixed_step_code import Written, begin
from fowtlib.solving.equilibrium import equilibrium, next_equilibrium
from fowtlib.solving.freed import freed_equilibrium
from fowtlib.solving.functions import AtParameters, Functions
from fowtlib.solving.initial import start_point
from fowtlib.solving.layout import Layout, Values
from fowtlib.solving.linear import LinearModel, linearize
from fowtlib.solving.observation import Observation, observed
from fowtlib.solving.operating_point import operating_point
from fowtlib.solving.outputs import Outputs
from fowtlib.solving.paths import by_path, names_of, start_by_path
from fowtlib.solving.results import Observer, RawTrajectory, Result
from fowtlib.solving.results.html import table
from fowtlib.solving.results.journal import Journal
from fowtlib.solving.simulation import SolverChoice, simulated
from fowtlib.solving.state import State
from fowtlib.solving.timeline import Event, Offered, Timeline, events_of, offered


class Plant:
    """A model as one flat DAE, ready for numbers.

    outputs: name -> (path of a variable, unit, description), as the model file gives them; without any, all states.
    input_names: name -> path, of inputs that have a name of their own; wherever an input is asked for, it will do.
    """

    def __init__(self, dae: FlatDAE, outputs: Mapping[str, Any] | None = None, *, name: str = "", title: str = "",
                 settings: Mapping[str, Any] | None = None, root: Any = None,
                 input_names: Mapping[str, str] | None = None):  # fmt: skip
        self.dae, self.name, self.title = dae, name, title
        self.root = copy.deepcopy(root)  # what is done to the model later is no part of this
        self._bindings = Bindings(dae, self.root)
        self.settings, self.input_names = copy.copy(settings or {}), dict(input_names or {})
        self.layout, self.outputs, self.functions = Layout(dae), Outputs(dae, outputs), Functions(dae)
        self.code: FixedStepCode | None = None
        self._written: Written | None = None
        self.kept_starts: dict[str, dict[str, float]] = {}  # means that runs have started from; see solving.starts

    @property
    def stats(self) -> Mapping[str, float]:
        """Counts and times of the flattening."""
        return self.dae.stats

    @property
    def fixed_step_code(self) -> FixedStepCode:
        """The compiled functions of the solver "fixed"; the same for all values of tunable parameters."""
        if self.code is None:
            self.code = FixedStepCode(self.dae, self.outputs.paths, self._written)
        return self.code

    def begin_code(self) -> None:
        """Let `fixed_step_code` be compiled beside what is done until it is asked for; not without a compiler."""
        if compiler() and self.code is None and self._written is None:
            self._written = begin(self.dae, self.outputs.paths)

    def describe(self, path: str) -> tuple[str, str]:
        """SI unit and description of any variable."""
        return self.outputs.describe(path)

    def parameter_values(self, parameters: Values | None = None) -> dict[str, np.ndarray]:
        """Values of all tunable parameters in SI, with those given put in."""
        return {path: value.copy() for path, value in self.binding(parameters).values.items()}

    def binding(self, parameters: Values | None = None) -> Binding:
        """What a run with these parameters takes in; see fowtlib.solving.binding.bind."""
        return self._bindings(parameters)

    def at(self, parameters: Values | None = None) -> AtParameters:
        """The numeric functions at parameter values."""
        return self.functions.at(self.binding(parameters))

    def offered_events(self) -> list[Offered]:
        """What can happen in a run: the events that the parts offer."""
        return offered(self.dae, self.root)

    def timeline(self, events: Sequence[Event | str] | None = None, root: Component | None = None) -> Timeline:
        """The events of a run, checked; None: those of the model file. root: the component tree of the run."""
        asked = self.settings.get("events", ()) if events is None else events
        return Timeline(events_of(asked), self.dae, self.outputs, self.root if root is None else root)

    @refusals_explained()
    def initial_state(self, parameters: Values | None = None, start: Values | None = None, inputs: Values | None = None,
                      t: float = 0.0, base: State | None = None) -> State:  # fmt: skip
        """The consistent state at the start of a simulation.

        start: values of states (SI or with unit) in place of their start values; of an algebraic unknown, a guess.
        base: a state to change by `start`, instead of the start values.
        """
        u, before = self.layout.inputs(self.input_paths(inputs)), None if base is None else State.of(base, "base")
        given = start_by_path(start, "base")
        return self.state(*start_point(self.at(parameters), self.layout, u, given, t, before), u, parameters)

    @refusals_explained()
    def equilibrium(self, parameters: Values | None = None, hold: Values | None = None, start: Values | None = None,
                    inputs: Values | None = None, *, free: Values | Sequence[str] | None = None,
                    targets: Values | None = None, near: State | None = None) -> State:  # fmt: skip
        """The state at which nothing changes, with the controllers in the loop; `hold` keeps states at values.

        free: tunable parameters by path, perhaps with first guesses, that take the values at which `targets` hold: as
        many conditions on results or variables. The state's `parameters` hold them; see fowtlib.solving.freed.
        near: an equilibrium of other parameters, from which Newton is tried first, in a tenth of the time.
        """
        near, hold = None if near is None else State.of(near, "near"), by_path(hold or {}, "states to hold")
        start = start_by_path(start, "near")
        if free or targets:
            beside = None if hold or start or inputs else near
            found = freed_equilibrium(self, free or (), targets or {}, parameters, hold, start, inputs, beside)
            check_state(self.at(found.parameters), found, self.name, rest=True)
            return found
        at = self.at(parameters)
        alone = near is None or hold or start or inputs
        beside = None if alone else next_equilibrium(at, near)
        if beside is not None:
            found = self.state(near.t, *beside, near.u, parameters)
        else:
            state = self.initial_state(parameters, {**start, **hold}, inputs)
            held = {self.layout.x[path] for path in hold}
            with search_from(at, state, self.name):
                x, z = equilibrium(at, state.t, state.x, state.z, np.concatenate([state.u, state.d]), held)
            found = self.state(state.t, x, z, state.d, state.u, parameters)
        check_state(at, found, self.name, rest=True)
        return found

    @refusals_explained()
    def simulate(
        self,
        t_end: float | str | None = None,
        output_step: float | str | None = None,
        *,
        start: State | Result | Values | str | None = None,
        parts: Mapping[str, Component] | None = None,
        solver: str | None = None,
        step: float | str | None = None,
        tolerance: float | None = None,
        rho_inf: float | None = None,
        parameters: Values | None = None,
        inputs: Values | None = None,
        outputs: Sequence[str] | None = None,
        progress: Callable[[float, float], None] | bool = False,
        events: Sequence[Event | str] | None = None,
        conditions: Conditions | None = None,
        journal: Journal | None = None,
    ) -> Result:
        """Simulate to `t_end` [s] and give the outputs every `output_step` [s].

        start: a State, an earlier Result to go on from, start values by path, or a word, see solving.starts: "turning",
        "equilibrium", "rest", "file", the path of a result or state, or "" for that of the model file. solver: "idas",
        with steps of its own, or "fixed", with equal steps of at most `step` [s], whose fastest oscillations keep the
        share `rho_inf` of their amplitude at each step. Arguments left out come from the model file, else t_end 600 s,
        output_step 0.1 s, solver "idas", step 12.5 ms, tolerance 1e-6, rho_inf 0.8. Raises SimulationError; its
        attribute `result` holds what was computed.

        parameters: by path, tunable and bound ones. parts: by path, components that take the place of others of their
        family for this run, as in `parts={"wind": SteadyWind(mean_speed=8)}`; nothing is flattened or compiled anew.
        A run that goes on from an earlier Result with the same solver and output step computes what it would have
        without the end between, bit for bit: it begins at the last checkpoint of that result, and `earlier.followed_by`
        puts its own points in the place of those that came after. With another solver it begins at the last point.
        events: what happens in the run, of what the parts offer; see Event and `offered_events`. None: what the model
        file says.
        journal: where the results are kept while the run goes on; see Journal and docs/reliability.md.
        conditions: all of this as one value; what is given beside it counts more.
        """
        given = Conditions(parts or {}, parameters or {}, inputs, start, t_end, output_step, None, outputs, events)
        choice = SolverChoice(solver, step, tolerance, rho_inf)
        return simulated(self, given.over(conditions), choice, parameters is not None, progress, journal)

    @refusals_explained()
    def linearize(self, state: State, inputs: Sequence[str] = (), outputs: Sequence[str] | None = None) -> LinearModel:
        """Exact linear model at a state, from inputs or tunable parameters by path to results or variables.

        All states are kept; algebraic unknowns are eliminated.
        """
        state, inputs = State.of(state, "what a model is linear about"), names_of(inputs, "inputs")
        names = list(self.outputs) if outputs is None else names_of(outputs)
        at = self.at(state.parameters)
        check_state(at, state, self.name, warn=False)
        paths = [self.input_names.get(name, name) for name in inputs]
        linear = linearize(at, self.layout, self.outputs, state, paths, names)
        own = {path: name for name, path in self.input_names.items() if name in inputs}
        linear.inputs = [own.get(path, path) for path in linear.inputs]
        linear.point = partial(operating_point, self, state, inputs, names)
        return linear

    def observer(self, raw: RawTrajectory, parameters: Values | None = None) -> Observer:
        """What rebuilds any variable along an earlier trajectory of this model, with the inputs at their defaults."""
        if raw.x_names != tuple(self.layout.x):
            raise SimulationError("the result is of another model: its states are not those of this one.")
        at, u = self.at(parameters), self.layout.inputs()
        observation = Observation(at, raw.time, raw.x, raw.z, u, raw.d, self.code)
        return Observer(observation.values, self.describe, self.dae.names, at.binding.root)

    def state(self, t: float, x: np.ndarray, z: np.ndarray, d: np.ndarray, u: np.ndarray,
              parameters: Values | None) -> State:  # fmt: skip
        """A state of this plant from its numbers."""
        return State(t, x, z, d, u, dict(parameters or {}), self._observe, self)

    def input_paths(self, inputs: Values | None) -> dict[str, Any]:
        """Values of inputs by path."""
        return {self.input_names.get(name, name): value for name, value in by_path(inputs or {}, "inputs").items()}

    @refusals_explained()
    def _observe(self, names: Sequence[str], state: State) -> list[np.ndarray]:
        values = observed(self.at(state.parameters), [self.outputs.entry(name).path for name in names], state)
        return [np.asarray(self.outputs.shown(name, value)) for name, value in zip(names, values, strict=True)]

    def _repr_html_(self) -> str:
        rows = [(name, entry.path, entry.unit, entry.doc) for name, entry in self.outputs.items()]
        return table(("output", "variable", "unit", ""), rows, repr(self)[1:-1])

    def __repr__(self) -> str:
        return f"<Plant {self.title or self.name}: {self.dae!r}>"
