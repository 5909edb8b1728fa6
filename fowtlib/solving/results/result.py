"""Results of a simulation: labelled time series, and what is needed to go on from their end.

A ``Result`` holds the chosen variables with unit and long name, the raw trajectory of the solver (states, algebraic and
discrete variables), and the run's attributes. Any other variable of the model is rebuilt from the raw trajectory by an
``Observer`` that the compiled model hands in; nothing here knows a model or a solver. File formats: files.py.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import NotFoundError, SimulationError, did_you_mean
from fowtlib.solving.results.data import (
    Continuation,
    Observer,
    RawTrajectory,
    Stored,
    dimensions,
    parameter_hash,
    plain,
)
from fowtlib.solving.results.files import read, save
from fowtlib.solving.results.html import table
from fowtlib.solving.results.statistics import Statistics, summarise

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from fowtlib.language.component import Component

_INDEXED = re.compile(r"^(?P<name>.+)\[(?P<index>\d+(?:\s*,\s*\d+)*)\]$")
_SAME_TIME = 1e-9  # relative distance below which two points of time are the same output point


class Result:
    """Labelled time series of a run. ``result["surge"]`` is an ``xarray.DataArray`` with its unit and long name.

    time        points of time, s, shape (n,), rising (a point may be repeated at a jump)
    values      name -> array (n,), (n, m) or (n, m, k), in the units given
    units       name -> unit text, "1" for none
    long_names  name -> one phrase for a figure's axis
    attributes  of the run: model, title, solver, tolerance, parameters (mapping), data (files with
                their digests, by the parameters that name them), status (a sentence)
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
            **signature(),
            "status": "finished.",
            "parameters": {},
            "structure": {},
            "data": {},
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
        return xarray.Dataset(variables, {"time": time}, self.stored.plain_attributes)

    @property
    def stored(self) -> Stored:
        """What a file of this result holds."""
        return Stored(self.time, self._values, self._units, self._long_names, self.attributes, self.raw)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with time [s] as index and one column per scalar result or element ("line.force[2]")."""
        import pandas

        table = pandas.DataFrame(dict(self.columns()), index=pandas.Index(self.time, name="time"))
        table.attrs["units"] = {name: self.unit(name) for name in table.columns}
        return table

    def columns(self) -> Iterator[tuple[str, np.ndarray]]:
        """Every scalar series: the results as they are, vectors and matrices element by element."""
        return ((name, values) for name, _, values in self.stored.columns())

    def statistics(self, discard: float = 0.0) -> Statistics:
        """Summary of every series without the first ``discard`` seconds (the field's usual choice: 400 s of 4000 s)."""
        return summarise(self.time, self.stored.columns(), discard)

    def plot(self, path: str | Path | None = None, *names: str, discard: float = 0.0) -> Figure:
        """Figure of the usual series, or of those named, also any variable of the model; written to ``path`` if given.

        Without the first ``discard`` seconds. In a notebook the figure shows itself.
        """
        from fowtlib.solving.results.plots import plot_result

        return plot_result(self, names or None, path, discard=discard)

    def _repr_html_(self) -> str:
        rows = [(row.name, row.unit, row.mean, row.std, row.min, row.max) for row in self.statistics().values()]
        head = repr(self).partition(">")[0].removeprefix("<")
        return table(("result", "unit", "mean", "std", "min", "max"), rows if self.time.size else [], head)

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

    def attach_plant(self, plant: Any) -> None:
        """Let this result answer for every variable of the compiled model that it came from, where it holds states."""
        if self.raw is None:
            return
        from fowtlib.solving.binding import bound_values

        bound = bound_values(getattr(plant, "root", None), self.attributes["structure"])
        self.attach(plant.observer(self.raw, {**bound, **self.attributes["parameters"]}))

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
        last = self.raw.last if self.raw is not None else None
        if last is None:
            raise SimulationError(
                "this result holds nothing to resume from (only .nc files do): save the first run as .nc."
            )
        return last

    def check_resumable(self, parameters: Mapping[str, Any], structure: Mapping[str, Any] | None = None) -> None:
        """Stop when a run with these values of the tunable and the structural parameters would not be the same run."""
        final = self.final
        earlier = self.attributes["structure"]
        same_structure = structure is None or not earlier or earlier == structure
        if same_structure and (not final.parameter_hash or final.parameter_hash == parameter_hash(parameters)):
            return
        old, new = plain(self.attributes["parameters"]), plain(parameters)
        changed = [n for n in sorted({*old, *new}) if old.get(n) != new.get(n)]
        if not same_structure:
            old, new = {**old, **earlier}, {**new, **structure}
            changed = [n for n in sorted({*earlier, *structure}) if old.get(n) != new.get(n)] + changed
        shown = [f"{n} was {_shown(old.get(n, 'absent'))}, is {_shown(new.get(n, 'absent'))}" for n in changed[:5]]
        if len(changed) > 5:
            shown.append(f"and {len(changed) - 5} more")
        raise SimulationError(
            f"the run to resume had other parameters: {'; '.join(shown) or 'names or values differ'}. "
            "Give the same parameters, or start a new run."
        )

    def followed_by(self, later: Result) -> Result:
        """One result of this run and its continuation; the point that both share is kept once.

        A run that went on from a checkpoint has computed anew what came after it; that takes the place of what this
        result holds there.
        """
        if not self.time.size:
            return later
        missing = sorted({*self._values} ^ {*later._values})
        if missing:
            raise SimulationError(f"these two results cannot be joined: only one of them has {', '.join(missing)}.")
        for name in self._values:
            if self.unit(name) != later.unit(name):
                raise SimulationError(
                    f"these two results cannot be joined: {name} is in {self.unit(name)} and in {later.unit(name)}."
                )
        if later.attributes.get("goes_on_from") == later.time[0] <= self.time[-1]:
            return self.before(float(later.time[0])).followed_by(later) if self.time[0] < later.time[0] else later
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
            {key: value for key, value in later.attributes.items() if key != "goes_on_from"},
            raw,
            observer,
        )

    def before(self, t: float) -> Result:
        """The result without what lies at t [s] and behind it; nothing goes on from there."""
        kept, observer = self.time < t, self._observer
        if observer is not None:
            of = observer.values
            observer = replace(observer, values=lambda names: of(names)[kept])
        values = {name: array[kept] for name, array in self._values.items()}
        raw = None if self.raw is None else self.raw.before(t)
        return Result(self.time[kept], values, self._units, self._long_names, self.attributes, raw, observer)

    # -- files --------------------------------------------------------------------------------------------------------

    def save(self, path: str | Path) -> Path:
        """Write netCDF (.nc: everything, resumable), CSV (.csv: the series, 10 digits) or OpenFAST's output (.outb).

        An .outb file has 16 bits for a number, the names of OpenFAST's channels (see openfast.py) and evenly
        spaced times only. A file that is there already is written over, in one step: what stands there stays until
        the new file is whole and on the disk, and no half file is left.

        Raises WriteError where there is no room or no permission, and other ModelErrors for what the format cannot
        hold; the result itself is as it was, and can be saved elsewhere.
        """
        return save(self.stored, Path(path))

    @staticmethod
    def open(path: str | Path, plant: Any = None, *, damaged: bool = False) -> Result:
        """Read a result file: .nc, .csv, or .outb, also of OpenFAST itself; or a journal, up to its last sound piece.

        A damaged .nc file is refused; with ``damaged=True`` what is sound in it is read, without the variables whose
        checksum does not fit, which a warning names. The formats .csv and .outb have no checksums.

        With the compiled model that an .nc file came from, any variable can be observed again.

        plant is anything with ``observer(raw, parameters) -> Observer``: the raw trajectory and the run's parameters.
        """
        result = Result(**vars(read(Path(path), damaged)))
        if plant is not None:
            result.attach_plant(plant)
        return result


def _shown(value: Any) -> str:
    """A value of a parameter; of a file its name and the beginning of its digest."""
    name, found, digest = str(value).partition(" sha256:")
    return f"{name} with the content {digest[:12]}" if found else name


def signature() -> dict[str, str]:
    """Version and date, for the attributes of a result."""
    return {"fowtlib_version": _version(), "date": datetime.now(UTC).isoformat(timespec="seconds")}


def _version() -> str:
    try:
        return metadata.version("fowtlib")
    except metadata.PackageNotFoundError:
        return "unknown"
