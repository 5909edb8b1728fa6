"""Transfer functions from a run under a swept force (SweptForce), and those of the linear model beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.plants import checked_frequencies, chosen_outputs, plant_of, refuse_unstable, shown_unit
from fowtlib.analysis.series import as_series
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.solving import mean_linear_model, mean_state
from fowtlib.solving.starts import mean_parameters

if TYPE_CHECKING:
    from fowtlib.analysis.series import SeriesLike

_DONE = 0.02  # of its largest value: what may be left of a response at the end of a record
_FELT = 0.05  # of the largest spectrum of the load: below, it does not tell a response


@dataclass(frozen=True)
class Transfer:
    """Complex response (n, m) per unit of load at ``frequency`` [Hz]; exp(+i omega t), a positive phase leads."""

    frequency: np.ndarray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    response: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.outputs:
            raise ModelError(f"there is no response '{name}'{did_you_mean(name, self.outputs)}")
        return self.response[:, self.outputs.index(name)]


def swept_transfer(
    share: SeriesLike, responses: Mapping[str, SeriesLike], amplitude: float, *, low: float, high: float,
    unit: str = "N",
) -> Transfer:  # fmt: skip
    """Response per unit of load between two frequencies [Hz], from a run in which a sweep passes through them.

    share      the result "sweep.share"; amplitude: of the force or moment that the response is referred to
    responses  records from the same run, which begin at rest; it lasts until they have died out

    Quotient of the Fourier transforms of both records. Raises ModelError where a response goes on at the end, and
    where the sweep has no strength.
    """
    drive = as_series(share, "share")
    step = drive.step
    count = 2 * drive.values.size
    frequency = np.fft.rfftfreq(count, step)
    inside = (frequency >= low) & (frequency <= high)
    force = amplitude * np.fft.rfft(drive.values, count)
    if not inside.any() or np.abs(force[inside]).min() < _FELT * np.abs(force).max():
        raise ModelError(f"the sweep has no strength everywhere between {low:g} and {high:g} Hz; take a narrower band.")
    columns, units = [], []
    for name, record in responses.items():
        series = as_series(record, name)
        moved = series.values - series.values[0]
        size, tail = np.abs(moved).max(), np.abs(moved[-max(moved.size // 50, 2) :]).max()
        if tail > _DONE * size:
            raise ModelError(
                f"{series.name}: {100 * tail / size:.2g} % of its largest value is left at the end of the record; let "
                "it die out before the run ends."
            )
        columns.append((np.fft.rfft(moved, count) / np.where(force == 0, 1, force))[inside])
        units.append(f"{series.unit}/({unit})" if "*" in unit else f"{series.unit}/{unit}")
    return Transfer(frequency[inside], tuple(responses), tuple(units), np.column_stack(columns))


def linear_transfer(
    model: Any, load: str, frequencies: Sequence[float] | np.ndarray, *, outputs: Sequence[str] | None = None,
    axis: int = 0, parameters: Mapping[str, Any] | None = None,
) -> Transfer:  # fmt: skip
    """The same of the linear model about its mean: load is a vector parameter, such as "sweep.rest_force".

    Damping that goes with the square of the speed is none about still water: see fowtlib.analysis.rao.
    """
    plant = plant_of(model)
    frequency, names = checked_frequencies(frequencies), chosen_outputs(plant, outputs)
    if load not in plant.dae.parameters:
        raise ModelError(f"there is no tunable load '{load}'; take rest_force or rest_moment of a SweptForce.")
    mean = mean_parameters(plant, parameters)
    linear = mean_linear_model(plant, mean_state(plant, mean), inputs=[load], outputs=names)
    refuse_unstable(linear)
    size = plant.dae.parameters[load].symbol.numel()
    if not 0 <= axis < size:
        raise ModelError(f"{load} has {size} components; axis {axis} is none of them.")
    response = np.asarray(linear.frequency_response(2 * np.pi * frequency))[:, :, axis]
    unit = plant.dae.parameters[load].unit
    units = tuple(f"{shown_unit(plant, name)}/({unit})" if "*" in unit else f"{shown_unit(plant, name)}/{unit}"
                  for name in names)  # fmt: skip
    return Transfer(frequency, tuple(names), units, response)
