"""Result files: netCDF (classic, 64-bit offsets, by scipy), CSV with the units in its header, OpenFAST's .outb."""

from __future__ import annotations

import csv
import json
import os
import re
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.solving.results.data import RawTrajectory, Stored, dimensions
from fowtlib.solving.results.journal import ENDING, read_journal
from fowtlib.solving.results.openfast import Named, channel_of, result_of, unique
from fowtlib.solving.results.outb import Channels, read_outb, write_outb
from fowtlib.solving.results.packing import digest

_FORMAT = "fowtlib result 1"
_CHECKPOINT = "checkpoint"
_RAW = "raw_"  # prefix of the solver's arrays in the file
_HEADER = re.compile(r"^(?P<name>.*\S)\s*\[(?P<unit>[^\[\]]*)\]$")


def save(stored: Stored, path: Path) -> Path:
    """Write a result to ``path`` by its ending; the file is replaced in one step, after it has been written whole."""
    writers = {".nc": _write_netcdf, ".csv": _write_csv, ".outb": _write_openfast}
    if path.suffix not in writers:
        ending = path.suffix or "no ending"
        raise ModelError(f"{path}: a result is saved as .nc (netCDF), .csv or .outb (OpenFAST), not as '{ending}'.")
    if not path.parent.is_dir():
        raise ModelError(f"{path}: the folder {path.parent} does not exist. Make it first, or choose another one.")
    if not stored.time.size:
        raise ModelError(f"{path}: the result is empty, there is nothing to save.")
    _write_whole(path, lambda temporary: writers[path.suffix](stored, temporary))
    return path


def read(path: Path) -> Stored:
    """Read a file that ``save`` wrote, or the binary output of OpenFAST."""
    if path.suffix == ENDING:
        return read_journal(path)
    readers = {".nc": _read_netcdf, ".csv": _read_csv, ".outb": _read_openfast}
    if path.suffix not in readers:
        raise ModelError(f"{path}: a result file ends in .nc, .csv or .outb.")
    if not path.is_file():
        raise ModelError(f"{path}: there is no such file.")
    try:
        return readers[path.suffix](path)
    except ModelError:
        raise
    except (ValueError, LookupError, TypeError, ArithmeticError, MemoryError, OSError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise ModelError(f"{path}: the file is damaged, and cannot be read as a result: {reason[:200]}.") from None


def _write_whole(path: Path, write: Callable[[Path], None]) -> None:
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise ModelError(f"{path}: cannot be written: {error.strerror}.") from error
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    except ModelError as error:
        raise error.at(str(path)) from None
    except OSError as error:
        raise ModelError(f"{path}: cannot be written: {error.strerror or error}.") from error
    finally:
        temporary.unlink(missing_ok=True)


# -- netCDF -----------------------------------------------------------------------------------------------------------


def _write_netcdf(stored: Stored, path: Path) -> None:
    from scipy.io import netcdf_file

    attributes = {**stored.plain_attributes, "format": _FORMAT, "result_names": json.dumps(list(stored.values))}
    raw = stored.raw
    if raw is not None:
        names = {"x": raw.x_names, "z": raw.z_names, "d": raw.d_names}
        attributes |= {"raw_names": json.dumps(names), "parameter_hash": raw.parameter_hash}
    with netcdf_file(path, "w", version=2) as file:
        _set_attributes(file, {**attributes, "digest": _digest_of_texts(attributes)})
        _add(file, "time", ("time",), stored.time, units="s", long_name="time")
        for name, values in stored.values.items():
            about = {"units": stored.units[name], "long_name": stored.long_names[name]}
            _add(file, name, dimensions(values), values, **about)
        if raw is None:
            return
        for key in "xzd":
            if getattr(raw, key).size:  # the format has no empty arrays
                about = {"long_name": f"{key} of the solver; columns as in the attribute raw_names"}
                _add(file, _RAW + key, ("raw_time", f"raw_{key}_index"), getattr(raw, key), **about)
        _add(file, _RAW + "time", ("raw_time",), raw.time, units="s", long_name="time of the solver's rows")
        if raw.checkpoint:
            file.createDimension("checkpoint_bytes", len(raw.checkpoint))
            variable = file.createVariable(_CHECKPOINT, "b", ("checkpoint_bytes",))
            variable[...] = np.frombuffer(raw.checkpoint, np.int8)


def _add(file: Any, name: str, dims: tuple[str, ...], values: np.ndarray, **attributes: str) -> None:
    """Write a variable, and the dimensions that are new."""
    for dim, size in zip(dims, np.shape(values), strict=True):
        if dim not in file.dimensions:
            file.createDimension(dim, size)
    variable = file.createVariable(name, "d", dims)
    variable[...] = values
    _set_attributes(variable, {**attributes, "digest": _digest(values)})


def _digest(values: np.ndarray) -> str:
    """Of the numbers of a variable, as they lie in the file."""
    return digest(np.ascontiguousarray(values, ">f8").tobytes()).hex()


def _digest_of_texts(attributes: dict[str, Any]) -> str:
    """Of the attributes that are texts; damage to a number beside them does not change what a result shows."""
    texts = {key: value for key, value in attributes.items() if isinstance(value, str)}
    return digest(json.dumps(texts, sort_keys=True).encode()).hex()


def _check_digests(path: Path, dataset: Any) -> None:
    """Refuse a file in which something has changed since it was written; older files have no digests."""
    about = {key: value for key, value in dataset.attrs.items() if key != "digest"}
    if "digest" in dataset.attrs and dataset.attrs["digest"] != _digest_of_texts(about):
        raise ModelError(f"{path}: the file is damaged: its attributes are not those that were written.")
    for name, variable in dataset.variables.items():
        sum_ = variable.attrs.get("digest")
        missing = sum_ is None and "digest" in dataset.attrs and name != _CHECKPOINT
        if missing or sum_ not in (None, _digest(variable.values)):
            raise ModelError(f"{path}: the file is damaged: the numbers of {name} are not those that were written.")


def _set_attributes(owner: Any, attributes: dict[str, Any]) -> None:
    """Text, as UTF-8, and numbers are all that an attribute can hold."""
    for key, value in attributes.items():
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            setattr(owner, key, np.float64(value) if isinstance(value, float) else np.int32(value))
        else:
            setattr(owner, key, str(value).encode())


def _read_netcdf(path: Path) -> Stored:
    import xarray

    try:
        with xarray.open_dataset(path, engine="scipy", decode_cf=False) as lazy:
            dataset = lazy.load()
    except Exception as error:  # a damaged head leads the reader anywhere
        raise ModelError(f"{path}: is not a netCDF file that can be read, or it is damaged.") from error
    _check_digests(path, dataset)
    try:
        return _stored(path, dataset)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ModelError(f"{path}: the file is damaged: {error} is missing or wrong.") from error


def _stored(path: Path, dataset: Any) -> Stored:
    """What a data set holds."""
    attributes = {key: value.item() if isinstance(value, np.generic) else value for key, value in dataset.attrs.items()}
    attributes.pop("digest", None)
    if attributes.pop("format", None) != _FORMAT:
        raise ModelError(f"{path}: is a netCDF file, but not a result of fowtlib (attribute format = '{_FORMAT}').")
    names = json.loads(attributes.pop("result_names"))
    attributes["parameters"] = json.loads(attributes["parameters"])
    for key in ("structure", "data"):
        attributes[key] = json.loads(attributes.get(key, "{}"))
    raw_names = json.loads(attributes.pop("raw_names", "null"))
    fingerprint = attributes.pop("parameter_hash", "")
    raw = None
    if raw_names is not None:
        raw = RawTrajectory(
            dataset[_RAW + "time"].values,
            **{key: dataset[_RAW + key].values if _RAW + key in dataset else np.zeros(0) for key in "xzd"},
            **{f"{key}_names": tuple(raw_names[key]) for key in "xzd"},
            parameter_hash=fingerprint,
            checkpoint=dataset[_CHECKPOINT].values.tobytes() if _CHECKPOINT in dataset else b"",
        )
    return Stored(
        dataset["time"].values,
        {name: dataset[name].values for name in names},
        {name: dataset[name].attrs["units"] for name in names},
        {name: dataset[name].attrs["long_name"] for name in names},
        attributes,
        raw,
    )


# -- CSV --------------------------------------------------------------------------------------------------------------


def _write_csv(stored: Stored, path: Path) -> None:
    names, units, columns = ["time"], ["s"], [stored.time]
    for name, unit, values in stored.columns():
        names.append(name)
        units.append(unit)
        columns.append(values)
    with path.open("w", newline="", encoding="utf-8") as file:
        heads = [f"{name} [{'-' if unit in ('', '1') else unit}]" for name, unit in zip(names, units, strict=True)]
        csv.writer(file, lineterminator="\n").writerow(heads)
        np.savetxt(file, np.column_stack(columns), fmt="%.10g", delimiter=",")


def _read_csv(path: Path) -> Stored:
    with path.open(newline="", encoding="utf-8") as file:
        heads = next(csv.reader(file), [])
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of a file without rows
                rows = np.loadtxt(file, delimiter=",", ndmin=2)
        except ValueError as error:
            raise ModelError(f"{path}: {error}.") from error
    matches = [_HEADER.match(head.strip()) for head in heads]
    if not heads or None in matches or matches[0]["name"] != "time" or matches[0]["unit"] != "s":
        raise ModelError(f"{path}:1: the header must read 'time [s],surge [m],...': one name and unit per column.")
    if rows.size and rows.shape[1] != len(heads):
        raise ModelError(f"{path}: the header names {len(heads)} columns, the rows have {rows.shape[1]}.")
    rows = rows.reshape(-1, len(heads))
    names = [match["name"] for match in matches]
    values = {name: rows[:, i] for i, name in enumerate(names) if i > 0}
    units = {match["name"]: "1" if match["unit"] == "-" else match["unit"] for match in matches[1:]}
    return Stored(rows[:, 0], values, units, attributes={"status": f"read from {path.name}."})


# -- OpenFAST ---------------------------------------------------------------------------------------------------------


def _write_openfast(stored: Stored, path: Path) -> None:
    """Every scalar series under the name of its channel; see openfast_channels and outb."""
    names, units, columns = [], [], []
    for name, unit, values in stored.columns():
        channel = channel_of(name, unit)
        if channel.name != unique(channel.name, names):  # the second of its kind keeps its own name
            channel = Named(unique(name, names), unit)
        names.append(channel.name)
        units.append("-" if channel.unit in ("", "1") else re.sub(r"[* ]+", "-", channel.unit))
        columns.append(values * channel.factor % 360.0 if channel.turns else values * channel.factor)
    about = stored.attributes
    what = about.get("title") or about.get("model") or "a model"
    description = f"fowtlib {about['fowtlib_version']}: {what}; {about['date']}"
    write_outb(path, Channels(stored.time, tuple(names), tuple(units), np.column_stack(columns), description))


def _read_openfast(path: Path) -> Stored:
    """Channels whose results are known get the name and the unit of the result, the others keep theirs."""
    channels = read_outb(path)
    values, units = {}, {}
    for name, text, column in zip(channels.names, channels.units, channels.values.T, strict=True):
        result = result_of(name, text.replace("-", "*") if text != "-" else "1", channels.names)
        known = result.name if result.name not in values else unique(name, values)
        values[known], units[known] = column * result.factor, result.unit
    attributes = {"title": channels.description, "status": f"read from {path.name}."}
    return Stored(channels.time, values, units, attributes=attributes)
