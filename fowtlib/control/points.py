"""Operating points: a model at rest in winds from cut-in to cut-out, and its exact linear models there.

The states are those of the closed loop, with the controllers of the model; the linear model is cut at the signals that
the new controller is to give. So the plant is linearised where it will be operated, and no controller is in it but
those that stay, as that of the generator torque.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from fowtlib.language.errors import NotFoundError, SimulationError, did_you_mean
from fowtlib.solving import LinearModel, Model, Plant, State, mean_state

OVER = "wind.mean_speed"


def rest_at(plant: Plant, over: str, value: float, parameters: Mapping[str, object] | None = None) -> State:
    """A plant at rest at a value of the schedule. Raises SimulationError that names it."""
    try:
        return mean_state(plant, {**(parameters or {}), over: value})
    except SimulationError as error:
        unit = plant.dae.parameters[over].unit
        raise error.at(f"{over} = {value:g}{'' if unit == '1' else f' {unit}'}") from None


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """The state of the cut plant at rest at a value of the schedule, and the linear model from inputs to outputs."""

    value: float
    state: State
    linear: LinearModel
    inputs: Mapping[str, float]

    def __getitem__(self, name: str) -> float:
        """Any variable there, or one of the inputs by its name."""
        return self.inputs[name] if name in self.inputs else float(self.state[name])


class OperatingPoints:
    """The points of one model cut at signals, each found when it is asked for: `points.at(13.0)`.

    inputs: names for the signals that the new controller gives, {"pitch": "turbine.rotor.blade_pitch"}. disturbances:
    inputs or tunable parameters whose effect the linear models also have. over: the tunable parameter of the schedule.
    The model is taken in the mean of its wind and its sea.
    """

    def __init__(self, model: Model, inputs: Mapping[str, str], outputs: Sequence[str] | None = None, *,
                 disturbances: Sequence[str] = (OVER,), over: str = OVER):  # fmt: skip
        self.model = model.in_the_mean()
        self.over, self.inputs = over, dict(inputs)
        self.disturbances, self.outputs = list(disturbances), outputs
        self.closed: Plant = self.model.compile()
        self.plant: Plant = self.model.compile(inputs=self.inputs)

    def at(self, value: float, held: Mapping[str, float] | None = None,
           parameters: Mapping[str, object] | None = None) -> OperatingPoint:  # fmt: skip
        """The point at a value of the schedule.

        held: values of inputs [SI] at which the plant is to be at rest instead of those of its own controllers.
        parameters: further ones, by path. Raises SimulationError where there is no rest.
        """
        for name in held or {}:
            if name not in self.inputs:
                raise NotFoundError(f"the points have no input '{name}'{did_you_mean(name, self.inputs)}")
        given = {**(parameters or {}), self.over: value}
        closed = rest_at(self.closed, self.over, value, parameters)
        known = dict(zip(self.closed.layout.x, closed.x.tolist(), strict=True))
        known = {path: x for path, x in known.items() if path in self.plant.layout.x}
        signals = {name: float(closed[path]) for name, path in self.inputs.items()} | dict(held or {})
        if held:
            state = self.plant.equilibrium(given, start=known, inputs=signals)
        else:
            state = self.plant.initial_state(given, known, signals)
        linear = self.plant.linearize(state, [*self.inputs, *self.disturbances], self.outputs)
        return OperatingPoint(value, state, linear, signals)

    def over_values(self, values: Iterable[float]) -> list[OperatingPoint]:
        """The points at several values of the schedule."""
        return [self.at(float(value)) for value in values]
