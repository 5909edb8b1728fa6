"""Derivatives of the start of a run: of start values, of a mean position, of what initial equations leave."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.errors import ParameterError, SimulationError
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.initial import freed_states
from fowtlib.solving.results import Result
from fowtlib.solving.simulation import start_state
from fowtlib.solving.starts import mean_parameters, start_values
from fowtlib.solving.state import State
from fowtlib.solving.stationary_gradients import LinearGradient, Partial
from fowtlib.solving.tangents.directions import RunDirections
from fowtlib.solving.tangents.linearised import Linearised
from fowtlib.solving.tuned import TunedRun

Plant = Any
Values = Mapping[str, Any]
MEAN = "from the mean position"


class Beginning:
    """Where a run starts, and how that moves with parameters.

    start: as of Plant.simulate, but no Result. values: what the run is given. A word for the mean position moves with
    the parameters; a State and values by path are held as they are.
    """

    def __init__(self, plant: Plant, start: State | Values | str | None, parameters: Values | None,
                 inputs: Values | None):  # fmt: skip
        self.plant, self.parameters, self.inputs = plant, parameters, inputs
        self.values: State | dict[str, Any] | None = None
        self.moves = False
        if isinstance(start, Result):
            raise ParameterError(
                "start: sensitivities begin at the start of a run, so that it cannot go on from an earlier Result; "
                "start from its end as a State, or from the mean: start='equilibrium'."
            )
        if isinstance(start, str):
            self.values, told = start_values(plant, start, parameters, inputs)
            if told.startswith("from the stationary"):
                raise ParameterError(
                    "start: the stationary state about the mean has no sensitivities; take start='equilibrium'."
                )
            self.moves = told == MEAN
        else:
            self.values = dict(start) if isinstance(start, Mapping) else start

    def state(self, run: RunDirections) -> State:
        """The state at the start."""
        return start_state(self.plant, self.values, self.parameters, self.inputs, run.binding)

    def moved(self, run: RunDirections) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the start values of states and discrete variables by the parameters."""
        dae = self.plant.dae
        starts = ca.vertcat(*[item.start for item in (*dae.states, *dae.discretes)])
        slope = run.plant.functions.once("start slopes", lambda: ca.Function(
            "start_slopes", [dae.p], [ca.densify(ca.jacobian(starts, dae.p))]
        ))  # fmt: skip
        both = np.array(ca.DM(slope(run.binding.p))) @ run.numbers
        x, d = both[: len(dae.states)], both[len(dae.states) :]
        if isinstance(self.values, State):
            return np.zeros_like(x), np.zeros_like(d)
        if self.moves:
            return self._mean(run), d
        for places, column in ((self.plant.layout.x, x), (self.plant.layout.d, d)):
            for path in self.values if isinstance(self.values, Mapping) else ():
                if path in places:
                    column[places[path]] = 0.0
        return x, d

    def _mean(self, run: RunDirections) -> np.ndarray:
        plant = self.plant
        mean = mean_parameters(plant, self.parameters)
        state = plant.initial_state(mean, self.values, self.inputs)
        try:
            found = LinearGradient(plant, state)
        except SimulationError as error:
            error.message += (
                " To hold the start as it is: start='file' or 'rest' (--start rest), or in Python a State, as "
                "plant.equilibrium(...) gives it, or start values."
            )
            raise
        states = Partial(np.eye(found.nx, found.point.by_v.shape[1]), np.zeros((found.nx, plant.dae.w.numel())))
        return found.total(states, TunedRun(plant, self.parameters, run.elements))

    def consistent(self, at: AtParameters, model: Linearised, state: State, x: np.ndarray,
                   d: np.ndarray) -> np.ndarray:  # fmt: skip
        """Derivatives of the states at the start, where initial equations take the place of start values."""
        dae = self.plant.dae
        if isinstance(self.values, State) or not dae.initial_equations.shape[0]:
            return x
        layout = self.plant.layout
        given = {layout.x[path] for path in self.values or {} if path in layout.x}
        kept, free = at.functions.once(("freed", frozenset(given)), lambda: freed_states(dae, given))
        if not free:
            return x
        rows = ca.vertcat(dae.alg, dae.initial_equations[kept])
        q = np.concatenate([state.u, state.d])
        points = model.points(np.array([state.t]), state.x[None], state.z[None], q[None])
        by_x, by_z, by_d, by_p = (block[0] for block in model.slopes(f"initial {kept}", rows, points))
        x = x.copy()
        x[free] = 0.0
        left = by_x @ x + by_d @ d[model.moving] + by_p
        try:
            found = np.linalg.solve(np.hstack([by_x[:, free], by_z]), -left)
        except np.linalg.LinAlgError:
            raise SimulationError("the initial equations are singular at the start: it has no sensitivities.") from None
        x[free] = found[: len(free)]
        return x
