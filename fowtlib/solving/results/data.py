"""What a result is made of: the series that a file holds, the trajectory of the solver, a point to go on from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.language.errors import SimulationError
from fowtlib.solving.results.packing import unpacked

if TYPE_CHECKING:
    from fowtlib.language.component import Component


def parameter_hash(parameters: Mapping[str, Any]) -> str:
    """Fingerprint of parameter values by name; equal fingerprints mean that a run may be continued."""
    plain = {n: v if isinstance(v, str) else np.asarray(v, dtype=float).tolist() for n, v in parameters.items()}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class RawTrajectory:
    """What the solver computed, on the output grid: rows are points of time, columns are scalar unknowns.

    checkpoint: the run as it stood at one of the last rows, with the memory of its solver, from where it goes on as if
    it had not been interrupted; see fowtlib.solving.checkpoint. Without it a run goes on from the last row, anew.
    """

    time: np.ndarray
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    x_names: tuple[str, ...] = ()
    z_names: tuple[str, ...] = ()
    d_names: tuple[str, ...] = ()
    parameter_hash: str = ""
    checkpoint: bytes = b""

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", np.atleast_1d(np.asarray(self.time, dtype=float)))
        for key in ("x", "z", "d"):
            rows, names = np.asarray(getattr(self, key), dtype=float), tuple(getattr(self, f"{key}_names"))
            if rows.size:
                rows = rows.reshape(self.time.size, -1)
            else:  # no columns, or no points of time
                rows = np.zeros((self.time.size, 0 if self.time.size else len(names)))
            object.__setattr__(self, key, rows)
            names = names or tuple(f"{key}[{i}]" for i in range(rows.shape[1]))
            if len(names) != rows.shape[1]:
                raise ValueError(f"raw trajectory: {len(names)} names for {rows.shape[1]} columns of {key}")
            object.__setattr__(self, f"{key}_names", names)

    def row(self, index: int) -> Continuation:
        """The point of time ``index`` as something to start from."""
        x, z, d = (dict(zip(getattr(self, f"{k}_names"), getattr(self, k)[index].tolist(), strict=True)) for k in "xzd")
        return Continuation(float(self.time[index]), x, z, d, self.parameter_hash)

    @property
    def last(self) -> Continuation | None:
        """The last point: of the rows, or of the checkpoint where there are no rows; None without both."""
        if self.time.size:
            return self.row(-1)
        if not self.checkpoint:
            return None
        text, arrays = unpacked(self.checkpoint)
        x, z, d = (dict(zip(getattr(self, f"{k}_names"), arrays[f"last_{k}"].tolist(), strict=True)) for k in "xzd")
        return Continuation(float(text["last_time"]), x, z, d, self.parameter_hash)

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
            checkpoint=later.checkpoint,
        )

    def before(self, t: float) -> RawTrajectory:
        """The rows before a time, without the checkpoint."""
        kept = self.time < t
        return replace(self, time=self.time[kept], x=self.x[kept], z=self.z[kept], d=self.d[kept], checkpoint=b"")


@dataclass(frozen=True)
class Continuation:
    """A point of time to start from: time [s], and the values of x, z and d by name [SI]."""

    time: float
    x: Mapping[str, float]
    z: Mapping[str, float]
    d: Mapping[str, float]
    parameter_hash: str = ""


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
class Stored:
    """What a result file holds; the fields are those arguments of Result."""

    time: np.ndarray
    values: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)
    long_names: Mapping[str, str] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)
    raw: RawTrajectory | None = None

    @property
    def plain_attributes(self) -> dict[str, Any]:
        """The attributes with parameters, structure and data files as JSON text."""
        texts = {"parameters": plain(self.attributes["parameters"]), "structure": self.attributes["structure"],
                 "data": self.attributes.get("data", {})}  # fmt: skip
        return {**self.attributes, **{key: json.dumps(value) for key, value in texts.items()}}

    def columns(self) -> Iterator[tuple[str, str, np.ndarray]]:
        """Name, unit and values of every scalar series: vectors and matrices element by element."""
        for name, values in self.values.items():
            if values.ndim == 1:
                yield name, self.units[name], values
                continue
            for index in np.ndindex(*values.shape[1:]):
                yield f"{name}[{','.join(map(str, index))}]", self.units[name], values[(slice(None), *index)]


def dimensions(values: np.ndarray) -> tuple[str, ...]:
    """Names of the dimensions of a series of scalars, vectors or matrices."""
    ways = zip(("row", "column", "layer"), values.shape[1:], strict=False)
    return ("time", *(f"{way}_{size}" for way, size in ways))


def plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameter values as numbers and lists, ready for JSON."""
    return {name: value if isinstance(value, str) else np.asarray(value).tolist() for name, value in parameters.items()}
