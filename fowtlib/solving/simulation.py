"""A simulation: from what is asked of a plant to the run that computes it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fowtlib.language.errors import ParameterError
from fowtlib.solving.binding import Binding
from fowtlib.solving.checkpoint import last_time
from fowtlib.solving.conditions import Conditions
from fowtlib.solving.engines import Engine, create_engine
from fowtlib.solving.layout import Values
from fowtlib.solving.paths import names_of
from fowtlib.solving.results import Result
from fowtlib.solving.results.journal import Journal
from fowtlib.solving.run import About, Run
from fowtlib.solving.settings import duration_settings
from fowtlib.solving.starts import start_values
from fowtlib.solving.state import State
from fowtlib.solving.timeline import Timeline

Plant = Any
"""fowtlib.solving.plant.Plant, which imports this module."""


@dataclass(frozen=True)
class SolverChoice:
    """What is asked of the solver; None: what the model file says, or the default. See Plant.simulate."""

    solver: str | None = None
    step: float | str | None = None
    tolerance: float | None = None
    rho_inf: float | None = None


def simulated(plant: Plant, conditions: Conditions, choice: SolverChoice, replaces: bool,
              progress: Callable[[float, float], None] | bool, journal: Journal | None,
              watched: Callable[[Engine, Timeline], Engine] = lambda engine, timeline: engine) -> Result:  # fmt: skip
    """The result of a run under these conditions; see Plant.simulate.

    replaces: whether parameters were given, which then count instead of those of a state to start from.
    watched: gives the engine that the run calls, in place of its own.
    """
    start, inputs = conditions.start, conditions.inputs
    parameters: Values | None = conditions.values or ({} if replaces else None)
    if isinstance(start, State) and parameters is None:
        parameters = start.parameters
    end, interval, relative = duration_settings(
        conditions.duration, conditions.output_step, choice.tolerance, plant.settings
    )
    engine = create_engine(
        plant.at(parameters), lambda: plant.fixed_step_code, choice.solver, relative, interval,
        {"step": choice.step, "rho_inf": choice.rho_inf}, plant.settings,
    )  # fmt: skip
    about = About(plant.name, plant.title, plant.binding(parameters))
    state = start_state(plant, start, parameters, inputs, about.binding)
    names = list(plant.outputs) if conditions.outputs is None else names_of(conditions.outputs)
    if conditions.output_step is not None and interval > end - state.t > 0:
        warnings.warn(f"the output step of {interval:g} s is longer than the run of {end - state.t:g} s, whose results "
                      "are those of its start and its end; give a shorter one for more.", stacklevel=3)  # fmt: skip
    timeline = plant.timeline(conditions.events, about.binding.root)
    resumed = isinstance(start, Result)
    timeline.begin(state.t, resumed, str(start.attributes.get("events", "")).splitlines() if resumed else ())
    run = Run(watched(engine, timeline), state, plant.outputs, names, about, resumed, lambda: plant.code, timeline)
    earlier, point = (start, run.can_go_on(start, end, interval)) if isinstance(start, Result) else (None, b"")
    if journal is not None and earlier is not None:
        earlier = earlier.before(last_time(point) if point else state.t)
    stored = earlier.stored if journal is not None and earlier is not None and earlier.time.size else None
    return run.run(end, interval, progress, conditions.discard or 0.0, point, journal, stored)


def start_state(plant: Plant, start: State | Result | Values | str | None, parameters: Values | None,
                inputs: Values | None, binding: Binding) -> State:  # fmt: skip
    """The state from which a simulation starts."""
    if isinstance(start, Result):
        start.check_resumable(binding.values, binding.structure)
        point = start.final
        x, z, d = plant.layout.vectors(point.x, point.z, point.d)
        return plant.state(point.time, x, z, d, plant.layout.inputs(plant.input_paths(inputs)), parameters)
    if isinstance(start, State):
        same = parameters == start.parameters and inputs is None
        return start if same else plant.initial_state(parameters, None, inputs, base=start)
    if isinstance(start, str):
        start, _ = start_values(plant, start, parameters, inputs)
    if start is not None and not isinstance(start, Mapping):
        raise ParameterError(
            f"start: {start!r} is no State, no Result, no start values by path and no word; "
            "write start=plant.equilibrium(), start={'platform.motion.surge': '5 m'} or start='turning'."
        )
    return plant.initial_state(parameters, start, inputs)
