"""Result files: netCDF (classic, 64-bit offsets, with checksums), CSV with the units in its header, OpenFAST's .outb.

A netCDF file is refused where a checksum does not fit; .csv and .outb cannot tell.
"""

from __future__ import annotations

import codecs
import csv
import json
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError
from fowtlib.language.netcdf_files import HEAD, Contents, add_variable, read_netcdf, set_attributes, write_netcdf
from fowtlib.language.whole_files import WriteError, write_whole
from fowtlib.solving.results.data import RawTrajectory, Stored, dimensions
from fowtlib.solving.results.journal import ENDING, read_journal
from fowtlib.solving.results.openfast import Named, channel_of, result_of, unique
from fowtlib.solving.results.outb import Channels, read_outb, write_outb

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
    try:
        return write_whole(path, lambda temporary: writers[path.suffix](stored, temporary))
    except WriteError:
        raise
    except ModelError as error:
        raise error.at(str(path)) from None


def read(path: Path, damaged: bool = False) -> Stored:
    """Read a file that ``save`` wrote, or the binary output of OpenFAST.

    damaged: of a netCDF file read what is sound, and say in a warning what is not; else such a file is refused.
    """
    if path.suffix == ENDING:
        return read_journal(path)
    netcdf = _read_damaged if damaged else _read_netcdf
    readers = {".nc": netcdf, ".csv": _read_csv, ".outb": _read_openfast}
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


# -- netCDF -----------------------------------------------------------------------------------------------------------


def _write_netcdf(stored: Stored, path: Path) -> None:
    attributes = {**stored.plain_attributes, "format": _FORMAT, "result_names": json.dumps(list(stored.values))}
    raw = stored.raw
    if raw is not None:
        names = {"x": raw.x_names, "z": raw.z_names, "d": raw.d_names}
        attributes |= {"raw_names": json.dumps(names), "parameter_hash": raw.parameter_hash}

    def fill(file: Any) -> None:
        set_attributes(file, attributes)
        add_variable(file, "time", "d", ("time",), stored.time, units="s", long_name="time")
        for name, values in stored.values.items():
            about = {"units": stored.units[name], "long_name": stored.long_names[name]}
            add_variable(file, name, "d", dimensions(values), values, **about)
        if raw is None:
            return
        for key in "xzd":
            if getattr(raw, key).size:  # the format has no empty arrays
                about = {"long_name": f"{key} of the solver; columns as in the attribute raw_names"}
                add_variable(file, _RAW + key, "d", ("raw_time", f"raw_{key}_index"), getattr(raw, key), **about)
        about = {"units": "s", "long_name": "time of the solver's rows"}
        add_variable(file, _RAW + "time", "d", ("raw_time",), raw.time, **about)
        if raw.checkpoint:
            add_variable(file, _CHECKPOINT, "b", ("checkpoint_bytes",), np.frombuffer(raw.checkpoint, np.int8))

    write_netcdf(path, fill, version=2)


def _read_netcdf(path: Path) -> Stored:
    try:
        contents = read_netcdf(path)
    except ValueError as error:
        raise ModelError(f"{path}: is not a netCDF file that can be read, or it is damaged.") from error
    if contents.damaged:
        raise ModelError(
            f"{path}: the file is damaged: {contents.damage}. What is sound in it can be read: "
            "Result.open(path, damaged=True), or fowt view --damaged."
        )
    try:
        return _stored(path, contents)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ModelError(f"{path}: the file is damaged: {error} is missing or wrong.") from error


def _read_damaged(path: Path) -> Stored:
    """What is sound in a file, also in one whose end is missing; a warning names what is left out."""
    try:
        contents = read_netcdf(path, cut=True)
    except ValueError as error:
        raise ModelError(f"{path}: the file is damaged at its beginning; nothing in it can be read.") from error
    if not contents.damaged:
        return _read_netcdf(path)
    sound = {name: item for name, item in contents.variables.items() if name not in contents.damaged}
    if "time" not in sound and _RAW + "time" in sound:
        sound["time"] = sound[_RAW + "time"]  # the same points of time
    if "time" not in sound:
        raise ModelError(f"{path}: the file is damaged: its points of time are lost, and with them all series.")
    about, lost = dict(contents.attributes), [name for name in contents.damaged if name != HEAD]
    solver = [_RAW + key for key in ("time", *"xzd")]
    series = [name for name in sound if name not in (*solver, _CHECKPOINT, "time")]
    if HEAD in contents.damaged:
        lost.insert(0, "its attributes")
        about = {"format": _FORMAT, "parameters": "{}", "status": "stopped or finished."}
    about["result_names"] = json.dumps(series)
    if HEAD in contents.damaged or any(name in lost for name in solver):
        about.pop("raw_names", None)  # no states, and nothing to go on from
    left_out = ", ".join(lost)
    about["status"] = f"{about.get('status', '')} Read from a damaged file, without {left_out}.".strip()
    stored = _stored(path, Contents(about, sound, ()))
    states = "" if stored.raw is not None or not contents.variables.keys() & set(solver) else "; the states are lost"
    warnings.warn(f"{path}: the file is damaged; read without {left_out}{states}.", stacklevel=4)
    return stored


def _stored(path: Path, contents: Contents) -> Stored:
    """What a file holds."""
    attributes, variables = dict(contents.attributes), contents.variables
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
            variables[_RAW + "time"].values,
            **{key: variables[_RAW + key].values if _RAW + key in variables else np.zeros(0) for key in "xzd"},
            **{f"{key}_names": tuple(raw_names[key]) for key in "xzd"},
            parameter_hash=fingerprint,
            checkpoint=variables[_CHECKPOINT].values.tobytes() if _CHECKPOINT in variables else b"",
        )
    return Stored(
        variables["time"].values,
        {name: variables[name].values for name in names},
        {name: variables[name].attributes["units"] for name in names},
        {name: variables[name].attributes["long_name"] for name in names},
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
    with path.open(newline="", encoding=_encoding(path)) as file:
        heads = next(csv.reader(file), [])
        matches = [_HEADER.match(head.strip()) for head in heads]
        if not heads or None in matches or matches[0]["name"] != "time" or matches[0]["unit"] != "s":
            raise ModelError(f"{path}:1: the header must read 'time [s],surge [m],...': one name and unit per column.")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of a file without rows
                rows = np.loadtxt(file, delimiter=",", ndmin=2)
        except ValueError as error:
            raise ModelError(_wrong_row(path, len(heads)) or f"{path}: {error}.") from error
    if rows.size and rows.shape[1] != len(heads):
        raise ModelError(f"{path}: the header names {len(heads)} columns, the rows have {rows.shape[1]}.")
    rows = rows.reshape(-1, len(heads))
    names = [match["name"] for match in matches]
    for k, name in enumerate(names):
        if name in names[:k]:
            raise ModelError(f"{path}:1: there are two columns '{name}'.")
    _check_time(path, rows[:, 0])
    values = {name: rows[:, i] for i, name in enumerate(names) if i > 0}
    units = {match["name"]: "1" if match["unit"] == "-" else match["unit"] for match in matches[1:]}
    return Stored(rows[:, 0], values, units, attributes={"status": f"read from {path.name}."})


def _encoding(path: Path) -> str:
    """UTF-8 as we write it, or with the byte order mark of spreadsheets; UTF-16 where that mark says so."""
    with path.open("rb") as file:
        mark = file.read(2)
    return "utf-16" if mark in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else "utf-8-sig"


def _check_time(path: Path, time: np.ndarray) -> None:
    """ModelError with the line where time is no number or goes back."""
    wrong = np.flatnonzero(~np.isfinite(time) | (np.diff(time, prepend=time[:1]) < 0))
    if not wrong.size:
        return
    k = int(wrong[0])
    with path.open(newline="", encoding=_encoding(path)) as file:
        reader = csv.reader(file)
        lines = [reader.line_num for row in reader if row]
    said = f"the time {time[k]:.10g} s comes after {time[k - 1]:.10g} s"
    if not np.isfinite(time[k]):
        said = "the time is no number"
    raise ModelError(f"{path}:{lines[k + 1]}: {said}.")


def _wrong_row(path: Path, width: int) -> str:
    """What is wrong with the first row that is not `width` numbers, with its line; empty where there is none."""
    with path.open(newline="", encoding=_encoding(path)) as file:
        rows = csv.reader(file)
        next(rows, None)
        for row in rows:
            if row and len(row) != width:
                return f"{path}:{rows.line_num}: has {len(row)} values, and the header names {width} columns."
            for value in row:
                try:
                    float(value)
                except ValueError:
                    return f"{path}:{rows.line_num}: '{value.strip()}' is not a number."
    return ""


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
