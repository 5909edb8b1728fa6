"""How what a run takes in moves with its parameters: numbers of the flat model, and data behind external functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.solving.binding import Binding
from fowtlib.solving.differences import SHORT
from fowtlib.solving.tuned import Tuned, TunedRun

Plant = Any

SAME = 1e-13  # change of a number over its size that is rounding


@dataclass(frozen=True, eq=False)
class MovedData:
    """Data of external function k that move with one parameter, its number: d w = (w(above) - w(below)) / (2 step).

    place: of the handle among the inputs of the function; above, below: the handles of both data.
    """

    external: int
    column: int
    place: int
    step: float
    above: float
    below: float


class RunDirections(TunedRun):
    """A run, not its mean, and the parameters by which it is differentiated.

    numbers: (n_p, m), d p / d parameter, of all entries of the vector p of the flat model. data: what moves beside.
    """

    def __init__(self, plant: Plant, parameters: dict[str, Any] | None, elements: Sequence[Tuned]):
        super().__init__(plant, parameters, elements)
        self.mean = dict(parameters or {})
        self.binding = plant.binding(self.mean)
        self.numbers = np.zeros((plant.dae.p.numel(), len(elements)))
        self.data: list[MovedData] = []
        self._held: list[Binding] = []  # their data stay known as long as they are wanted
        for column, item in enumerate(elements):
            self._one(column, item)

    def _one(self, column: int, item: Tuned) -> None:
        plant = self.plant
        if item.tunable and (plant.root is None or self._acts_alone(item)):
            self.numbers[plant.layout.p[item.path].start + item.number, column] = 1.0
            if plant.root is not None:
                everything = np.eye(len(self.numbers))
                self.numbers[:, column] += self._through_numbers(item, everything, np.ones(len(self.numbers), bool))
            return
        self._through_bindings(column, item)

    def _through_bindings(self, column: int, item: Tuned) -> None:
        """By whole bindings, as of a sea, whose data are made anew. A short step: components come and go with it."""
        plant, dae = self.plant, self.plant.dae
        value = float(self.values[column])
        step = SHORT * (abs(value) or 1.0)
        for limit, beyond in ((item.min, value - step), (item.max, value + step)):
            if limit is not None and (beyond < limit if limit is item.min else beyond > limit):
                raise ParameterError(
                    f"{item.name} = {value:g} is at its bound, {limit:g}: what follows from it when a run starts is "
                    "differentiated by differences, which need both sides. Take a value beside it."
                )
        made = [plant.binding(self.changed(item, value + shift)) for shift in (step, -step)]
        self._held += made
        rows = np.array([np.where(np.isfinite(one.p), one.p, 0.0) for one in made])
        size = np.abs(rows).max(axis=0)
        moved = np.abs(rows - rows[0]).max(axis=0) > SAME * size
        self.numbers[:, column] = np.where(moved, (rows[0] - rows[1]) / (2 * step), 0.0)
        for breaks in (one.breaks for one in made):
            if len(breaks) != len(self.binding.breaks) or not np.allclose(breaks, self.binding.breaks, rtol=1e-12):
                raise ParameterError(
                    f"there is no sensitivity to {item.name}: instants at which the run stops and starts again move "
                    "with it. Take differences of two runs."
                )
        places = self._numbers
        for k, bound in dae.with_data:
            place = places[bound.path]
            self.numbers[place, column] = 0.0
            above, below = rows[:, place.start].tolist()
            if above == below:
                continue
            inputs = ca.vec(ca.densify(dae.externals[k].inputs)).elements()
            mine = bound.symbol[0].element_hash()
            where = next(i for i, entry in enumerate(inputs) if entry.element_hash() == mine)
            self.data.append(MovedData(k, column, where, step, above, below))
