"""Results of a simulation: labelled time series, and what is needed to go on from their end.

A ``Result`` holds the chosen variables with unit and long name, the raw trajectory of the solver (states, algebraic and
discrete variables), and the run's attributes. Any other variable of the model is rebuilt from the raw trajectory by an
``Observer`` that the compiled model hands in; nothing here knows a model or a solver. File formats: result_files.py.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import ModelError, NotFoundError, SimulationError, did_you_mean
from fowtlib.language.upstairs import handed_in

if TYPE_CHECKING:
    import pandas
    import xarray

    from fowtlib.language.component import Component

_INDEXED = re.compile(r"^(?P<name>.+)\[(?P<index>\d+(?:\s*,\s*\d+)*)\]$")
_SAME_TIME = 1e-9  # relative distance below which two points of time are the same output point
_SHOWN_ROWS = 40


def parameter_hash(parameters: Mapping[str, Any]) -> str:
    """Fingerprint of parameter values by name; equal fingerprints mean that a run may be continued."""
    plain = {n: v if isinstance(v, str) else np.asarray(v, dtype=float).tolist() for n, v in parameters.items()}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class RawTrajectory:
    """What the solver computed, on the output grid: rows are points of time, columns are scalar unknowns.

    ``memory`` holds whatever else the solver must remember to go on from the last row (accelerations of a multistep
    method, the state of a clock). It is kept in the file, and its meaning is the solver's own business.
    """

    time: np.ndarray
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    x_names: tuple[str, ...] = ()
    z_names: tuple[str, ...] = ()
    d_names: tuple[str, ...] = ()
    parameter_hash: str = ""
    memory: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", np.atleast_1d(np.asarray(self.time, dtype=float)))
        for key in ("x", "z", "d"):
            rows = np.asarray(getattr(self, key), dtype=float)
            rows = rows.reshape(self.time.size, -1) if rows.size else np.zeros((self.time.size, 0))
            object.__setattr__(self, key, rows)
            names = tuple(getattr(self, f"{key}_names")) or tuple(f"{key}[{i}]" for i in range(rows.shape[1]))
            if len(names) != rows.shape[1]:
                raise ValueError(f"raw trajectory: {len(names)} names for {rows.shape[1]} columns of {key}")
            object.__setattr__(self, f"{key}_names", names)

    def row(self, index: int) -> Continuation:
        """The point of time ``index`` as something to start from."""
        x, z, d = (dict(zip(getattr(self, f"{k}_names"), getattr(self, k)[index].tolist(), strict=True)) for k in "xzd")
        last = index in (-1, self.time.size - 1)
        return Continuation(float(self.time[index]), x, z, d, self.parameter_hash, self.memory if last else {})

    def followed_by(self, later: RawTrajectory, skip: int) -> RawTrajectory:
        """Append the rows of ``later`` without its first ``skip`` ones."""
        for key in ("x_names", "z_names", "d_names"):
            if getattr(self, key) != getattr(later, key):
                raise SimulationError("these two results come from different models: their unknowns are not the same.")
        joined = {k: np.concatenate([getattr(self, k), getattr(later, k)[skip:]]) for k in ("time", "x", "z", "d")}
        return RawTrajectory(
            **joined,
            x_names=self.x_names,
            z_names=self.z_names,
            d_names=self.d_names,
            parameter_hash=later.parameter_hash,
            memory=later.memory,
        )


@dataclass(frozen=True)
class Continuation:
    """A point of time to start from: time [s], and the values of x, z and d by name [SI]."""

    time: float
    x: Mapping[str, float]
    z: Mapping[str, float]
    d: Mapping[str, float]
    parameter_hash: str = ""
    memory: Mapping[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True)
class Observer:
    """How a compiled model rebuilds variables that were not chosen as results.

    values(names) gives an array (n_time, len(names)), or (n_time, *shape) for a single vector or matrix;
    describe(name) gives (unit, long name); names are all paths that may be asked for; root is the component tree.
    """

    values: Callable[[Sequence[str]], np.ndarray]
    describe: Callable[[str], tuple[str, str]] = lambda name: ("1", name)
    names: Collection[str] = ()
    root: Component | None = None


@dataclass(frozen=True)
class Summary:
    """Mean, standard deviation, minimum, maximum and root mean square of one series, in its own unit."""

    name: str
    unit: str
    mean: float
    std: float
    min: float
    max: float
    rms: float


class Statistics(Mapping[str, Summary]):
    """Summaries by name; prints as a table, and ``to_pandas()`` gives it as one."""

    def __init__(self, rows: Sequence[Summary], first: float, last: float) -> None:
        self._rows = {row.name: row for row in rows}
        self.first, self.last = first, last

    def __getitem__(self, name: str) -> Summary:
        if name not in self._rows:
            raise NotFoundError(f"there is no result '{name}'{did_you_mean(name, self._rows, list_up_to=30)}")
        return self._rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def to_pandas(self) -> pandas.DataFrame:
        import pandas

        return pandas.DataFrame([vars(row) for row in self._rows.values()]).set_index("name")

    def __repr__(self) -> str:
        shown = list(self._rows.values())[:_SHOWN_ROWS]
        width = max([len(row.name) for row in shown] + [4])
        unit_width = max([len(row.unit) for row in shown] + [4])
        heads = "".join(f"{head:>12}" for head in ("mean", "std", "min", "max"))
        lines = [f"{'name':<{width}} {'unit':<{unit_width}}{heads}"]
        for row in shown:
            numbers = "".join(f"{value:>12.5g}" for value in (row.mean, row.std, row.min, row.max))
            lines.append(f"{row.name:<{width}} {_shown_unit(row.unit):<{unit_width}}{numbers}")
        if len(self) > len(shown):
            lines.append(f"... and {len(self) - len(shown)} more")
        return "\n".join(lines)


def _shown_unit(unit: str) -> str:
    return "-" if unit in ("", "1") else unit


def _time_weights(time: np.ndarray) -> np.ndarray:
    """Weights of the samples in a mean over time: equal on a uniform grid, trapezoidal on any other."""
    steps = np.diff(time)
    if time.size < 3 or np.ptp(steps) <= 1e-6 * abs(steps[0]):
        return np.full(time.size, 1.0 / time.size)
    weights = np.zeros(time.size)
    weights[:-1] += 0.5 * steps
    weights[1:] += 0.5 * steps
    return weights / weights.sum()


class Result:
    """Labelled time series of a run. ``result["surge"]`` is an ``xarray.DataArray`` with its unit and long name.

    time        points of time, s, shape (n,), rising (a point may be repeated at a jump)
    values      name -> array (n,), (n, m) or (n, m, k), in the units given
    units       name -> unit text, "1" for none
    long_names  name -> one phrase for a figure's axis
    attributes  of the run: model, title, solver, tolerance, parameters (mapping), status (a sentence)
    raw         the solver's trajectory; needed to observe other variables and to go on from the end
    observe     rebuilds any variable of the model by path: an ``Observer``, or observe(names) -> array
    """

    def __init__(
        self,
        time: Sequence[float] | np.ndarray,
        values: Mapping[str, Any],
        units: Mapping[str, str] | None = None,
        long_names: Mapping[str, str] | None = None,
        attributes: Mapping[str, Any] | None = None,
        raw: RawTrajectory | None = None,
        observe: Observer | Callable[[Sequence[str]], np.ndarray] | None = None,
    ) -> None:
        self.time = np.atleast_1d(np.asarray(time, dtype=float))
        self._values = {name: np.asarray(value, dtype=float) for name, value in values.items()}
        for name, value in self._values.items():
            if value.shape[:1] != self.time.shape:
                raise ValueError(f"result '{name}': {value.shape[:1]} values for {self.time.size} points of time")
        self._units = {name: (units or {}).get(name, "1") for name in self._values}
        self._long_names = {name: (long_names or {}).get(name, "") or name for name in self._values}
        self.raw = raw
        self._observer: Observer | None = None
        self._observed: dict[str, np.ndarray] = {}
        if observe is not None:
            self.attach(observe)
        self.attributes: dict[str, Any] = {
            "model": "",
            "title": "",
            "solver": "",
            "tolerance": float("nan"),
            "fowtlib_version": _version(),
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "status": "finished.",
            "parameters": {},
            "structure": {},
            **(attributes or {}),
        }

    # -- reading ------------------------------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> xarray.DataArray:
        import xarray

        values = self.array(name)
        dims = dimensions(values)
        time = xarray.Variable("time", self.time, {"units": "s", "long_name": "time"})
        attrs = {"units": self.unit(name), "long_name": self.long_name(name)}
        return xarray.DataArray(values, {"time": time}, dims, name, attrs)

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def array(self, name: str) -> np.ndarray:
        """Values of a result, of an element ``name[i]`` or ``name[i,j]`` of it, or of any variable of the model."""
        if name in self._values:
            return self._values[name]
        indexed = _INDEXED.match(name)
        if indexed and indexed["name"] in self._values:
            whole = self._values[indexed["name"]]
            index = tuple(int(i) for i in indexed["index"].split(","))
            if len(index) != whole.ndim - 1 or any(i >= n for i, n in zip(index, whole.shape[1:], strict=True)):
                shape = " x ".join(map(str, whole.shape[1:]))
                size = f"has {shape} elements, counted from 0" if shape else "is a single number"
                raise NotFoundError(f"there is no '{name}': the result '{indexed['name']}' {size}.")
            return whole[(slice(None), *index)]
        if name not in self._observed:
            self._observed[name] = self._observe(name)
        return self._observed[name]

    def _observe(self, name: str) -> np.ndarray:
        observer = self._observer
        if observer is None or (observer.names and name not in observer.names):
            message = f"there is no result '{name}'"
            message += did_you_mean(name, [*self._values, *(observer.names if observer else ())], list_up_to=30)
            if observer is None and not message.endswith("?"):
                message += " Other variables of the model can be asked for after Result.open(path, plant=plant)."
            raise NotFoundError(message)
        values = np.asarray(observer.values([name]), dtype=float)
        return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values

    def unit(self, name: str) -> str:
        """Unit of a result or of any variable of the model; "1" for none."""
        return self._describe(name)[0]

    def long_name(self, name: str) -> str:
        """What a figure's axis calls the variable."""
        return self._describe(name)[1]

    def _describe(self, name: str) -> tuple[str, str]:
        if name in self._values:
            return self._units[name], self._long_names[name]
        indexed = _INDEXED.match(name)
        if indexed and indexed["name"] in self._values:
            return self._units[indexed["name"]], f"{self._long_names[indexed['name']]} [{indexed['index']}]"
        return self._observer.describe(name) if self._observer else ("1", name)

    @property
    def names(self) -> list[str]:
        return list(self._values)

    @property
    def duration(self) -> float:
        """Span of time of the result, s."""
        return float(self.time[-1] - self.time[0]) if self.time.size else 0.0

    @property
    def dataset(self) -> xarray.Dataset:
        """All stored results as one labelled ``xarray.Dataset``; parameters are JSON text in its attributes."""
        import xarray

        time = xarray.Variable("time", self.time, {"units": "s", "long_name": "time"})
        variables = {name: self[name].variable for name in self._values}
        return xarray.Dataset(variables, {"time": time}, self.plain_attributes)

    @property
    def plain_attributes(self) -> dict[str, Any]:
        """The attributes with parameters and structure as JSON text."""
        texts = {"parameters": _plain(self.attributes["parameters"]), "structure": self.attributes["structure"]}
        return self.attributes | {key: json.dumps(value) for key, value in texts.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """A table with time [s] as index and one column per scalar result or element ("line.force[2]")."""
        import pandas

        table = pandas.DataFrame(dict(self.columns()), index=pandas.Index(self.time, name="time"))
        table.attrs["units"] = {name: self.unit(name) for name in table.columns}
        return table

    def columns(self) -> Iterator[tuple[str, np.ndarray]]:
        """Every scalar series: the results as they are, vectors and matrices element by element."""
        for name, values in self._values.items():
            if values.ndim == 1:
                yield name, values
                continue
            for index in np.ndindex(*values.shape[1:]):
                yield f"{name}[{','.join(map(str, index))}]", values[(slice(None), *index)]

    def statistics(self, discard: float = 0.0) -> Statistics:
        """Summary of every series without the first ``discard`` seconds (the field's usual choice: 400 s of 4000 s)."""
        keep = self.time >= self.time[0] + discard if self.time.size else np.zeros(0, dtype=bool)
        if not keep.any():
            raise ModelError(
                f"statistics: discarding {discard:g} s leaves nothing of a result of {self.duration:g} s. "
                "Discard less, or simulate longer."
            )
        time = self.time[keep]
        weights = _time_weights(time)
        rows = []
        for name, values in self.columns():
            part = values[keep]
            mean = float(weights @ part)
            std = float(np.sqrt(weights @ (part - mean) ** 2))
            rms = float(np.sqrt(weights @ part**2))
            rows.append(Summary(name, self.unit(name), mean, std, float(part.min()), float(part.max()), rms))
        return Statistics(rows, float(time[0]), float(time[-1]))

    def __repr__(self) -> str:
        what = self.attributes.get("title") or self.attributes.get("model") or "a model"
        if not self.time.size:
            return f"<Result of {what}: empty>"
        span = f"{self.time[0]:g} s to {self.time[-1]:g} s, {self.time.size} points"
        return f"<Result of {what}: {span}; {self.attributes['status']}>\n{self.statistics()!r}"

    # -- more variables -----------------------------------------------------------------------------------------------

    def attach(self, observe: Observer | Callable[[Sequence[str]], np.ndarray]) -> None:
        """Let this result answer for every variable of the model again."""
        self._observer = observe if isinstance(observe, Observer) else Observer(observe)
        self._observed = {}

    @property
    def root(self) -> Component:
        """The component tree of the model that this result came from."""
        if self._observer is None or self._observer.root is None:
            raise SimulationError(
                "this result does not know its model: open it with the compiled model, Result.open(path, plant=plant)."
            )
        return self._observer.root

    def observe(self, names: Sequence[str]) -> np.ndarray:
        """Scalar variables of the model by path, SI, all in one pass: (n_time, len(names))."""
        self.root  # noqa: B018  the error for a result without a model
        return np.asarray(self._observer.values(list(names)), dtype=float).reshape(self.time.size, len(names))

    def view(self, path: str | Path | None = None, **options: Any) -> Any:
        """Write an animation in 3-D as one HTML file for the browser; see fowtlib.view.view."""
        return handed_in("view")(self, path, **options)

    def keep(self, *names: str) -> Result:
        """Store observed variables, so that they are saved too. Returns this result."""
        for name in names:
            values, (unit, long_name) = self.array(name), self._describe(name)
            self._values[name], self._units[name], self._long_names[name] = values, unit, long_name
        return self

    # -- going on -----------------------------------------------------------------------------------------------------

    @property
    def final(self) -> Continuation:
        """The last computed point, to start from."""
        if self.raw is None or not self.raw.time.size:
            raise SimulationError(
                "this result holds nothing to resume from (only .nc files do): save the first run as .nc."
            )
        return self.raw.row(-1)

    def check_resumable(self, parameters: Mapping[str, Any], structure: Mapping[str, Any] | None = None) -> None:
        """Stop when a run with these values of the tunable and the structural parameters would not be the same run."""
        final = self.final
        earlier = self.attributes["structure"]
        same_structure = structure is None or not earlier or earlier == structure
        if same_structure and (not final.parameter_hash or final.parameter_hash == parameter_hash(parameters)):
            return
        old, new = _plain(self.attributes["parameters"]), _plain(parameters)
        changed = [n for n in sorted({*old, *new}) if old.get(n) != new.get(n)]
        if not same_structure:
            old, new = {**old, **earlier}, {**new, **structure}
            changed = [n for n in sorted({*earlier, *structure}) if old.get(n) != new.get(n)] + changed
        shown = [f"{n} was {old.get(n, 'absent')}, is {new.get(n, 'absent')}" for n in changed[:5]]
        if len(changed) > 5:
            shown.append(f"and {len(changed) - 5} more")
        raise SimulationError(
            f"the run to resume had other parameters: {'; '.join(shown) or 'names or values differ'}. "
            "Give the same parameters, or start a new run."
        )

    def followed_by(self, later: Result) -> Result:
        """One result of this run and its continuation; the point that both share is kept once."""
        missing = sorted({*self._values} ^ {*later._values})
        if missing:
            raise SimulationError(f"these two results cannot be joined: only one of them has {', '.join(missing)}.")
        for name in self._values:
            if self.unit(name) != later.unit(name):
                raise SimulationError(
                    f"these two results cannot be joined: {name} is in {self.unit(name)} and in {later.unit(name)}."
                )
        end, begin = self.time[-1], later.time[0]
        near = _SAME_TIME * max(1.0, abs(end))
        if begin < end - near:
            raise SimulationError(f"these two results overlap: one ends at {end:g} s, the other begins at {begin:g} s.")
        skip = int(begin <= end + near)
        raw = self.raw.followed_by(later.raw, skip) if self.raw is not None and later.raw is not None else None
        first, second = self._observer, later._observer
        observer = None
        if first and second:

            def both(names: Sequence[str]) -> np.ndarray:
                return np.concatenate([first.values(names), second.values(names)[skip:]])

            observer = Observer(both, second.describe, second.names, second.root)
        return Result(
            np.concatenate([self.time, later.time[skip:]]),
            {name: np.concatenate([values, later._values[name][skip:]]) for name, values in self._values.items()},
            later._units,
            later._long_names,
            later.attributes,
            raw,
            observer,
        )

    # -- files --------------------------------------------------------------------------------------------------------

    def save(self, path: str | Path) -> Path:
        """Write netCDF (.nc: everything, resumable), CSV (.csv: the series, 10 digits) or OpenFAST's output (.outb).

        An .outb file has 16 bits for a number, the names of OpenFAST's channels (see openfast_channels) and evenly
        spaced times only. Never leaves half a file.
        """
        from fowtlib.solving.result_files import save

        return save(self, Path(path))

    @staticmethod
    def open(path: str | Path, plant: Any = None) -> Result:
        """Read a result file: .nc, .csv, or .outb, also of OpenFAST itself.

        With the compiled model that an .nc file came from, any variable can be observed again.

        plant is anything with ``observer(raw, parameters) -> Observer``: the raw trajectory and the run's parameters.
        """
        from fowtlib.solving.result_files import read

        result = read(Path(path))
        if plant is not None and result.raw is not None:
            from fowtlib.solving.binding import bound_values

            bound = bound_values(getattr(plant, "root", None), result.attributes["structure"])
            result.attach(plant.observer(result.raw, {**bound, **result.attributes["parameters"]}))
        return result


def dimensions(values: np.ndarray) -> tuple[str, ...]:
    """Names of the dimensions of a series of scalars, vectors or matrices."""
    ways = zip(("row", "column", "layer"), values.shape[1:], strict=False)
    return ("time", *(f"{way}_{size}" for way, size in ways))


def _plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameter values as numbers and lists, ready for JSON."""
    return {name: value if isinstance(value, str) else np.asarray(value).tolist() for name, value in parameters.items()}


def _version() -> str:
    try:
        return metadata.version("fowtlib")
    except metadata.PackageNotFoundError:
        return "unknown"
