"""Mean offsets: equilibria over a range of one parameter, such as the mean wind speed or a force on the platform."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.plants import chosen_outputs, shown_unit
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.language.whole_files import write_whole

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class StaticCurve:
    """Equilibrium values (n_value, n_output) of the outputs, over the values of one parameter (in its SI unit)."""

    parameter: str
    values: np.ndarray
    outputs: tuple[str, ...]
    table: np.ndarray
    units: tuple[str, ...]

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.outputs:
            raise ModelError(f"the curve has no output '{name}'{did_you_mean(name, self.outputs)}")
        return self.table[:, self.outputs.index(name)]

    @property
    def dataset(self) -> xarray.Dataset:
        """The outputs over the coordinate that is named like the parameter."""
        import xarray

        columns = {
            name: (self.parameter, self.table[:, i], {"units": unit, "long_name": name})
            for i, (name, unit) in enumerate(zip(self.outputs, self.units, strict=True))
        }
        return xarray.Dataset(columns, {self.parameter: self.values})

    def save(self, path: str | Path) -> Path:
        """Write a table as CSV, with units in the header line."""
        path = Path(path)
        if path.suffix != ".csv":
            raise ModelError(f"{path}: a static curve is saved as .csv, not as '{path.suffix or 'no ending'}'.")
        heads = [self.parameter, *(f"{name} [{unit}]" for name, unit in zip(self.outputs, self.units, strict=True))]
        table = np.column_stack([self.values, self.table])
        head = ",".join(heads)
        return write_whole(
            path, lambda file: np.savetxt(file, table, fmt="%.8g", delimiter=",", header=head, comments="")
        )


def static_curve(
    plant: Any,
    parameter: str,
    values: Sequence[float] | np.ndarray,
    *,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
) -> StaticCurve:
    """Equilibrium of a compiled model for every value of one tunable parameter, such as "wind.mean_speed".

    outputs     result names; None takes the six motions as far as the model has them, else all results
    parameters  values of further parameters, the same for every point
    """
    names = chosen_outputs(plant, outputs)
    values = np.atleast_1d(np.asarray(values, dtype=float))
    rows = []
    for value in values:
        state = plant.equilibrium(parameters={**(parameters or {}), parameter: float(value)})
        rows.append([float(np.asarray(state[name])) for name in names])
    return StaticCurve(
        parameter, values, tuple(names), np.array(rows), tuple(shown_unit(plant, name) for name in names)
    )
