"""Data, result and FMU files to damage: how a good one is made, how it is read, and the numbers it stands for."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

DATA = Path(__file__).parents[2] / "models" / "data"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="tank" guid="{tank}">
<CoSimulation modelIdentifier="tank" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit></UnitDefinitions>
<DefaultExperiment stepSize="0.0125"/>
<ModelVariables>
<ScalarVariable name="speed" valueReference="0" causality="input" variability="continuous"><Real unit="rpm" start="0"/>
</ScalarVariable>
<ScalarVariable name="level" valueReference="1" causality="output" variability="continuous"><Real unit="m"/>
</ScalarVariable>
<ScalarVariable name="area" valueReference="2" causality="parameter" variability="fixed"><Real start="2.5"/>
</ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""
WAMIT_RADIATION = "".join(
    f"{period:6.2f} {i} {j} {(9.0 if i == j else -2.0) + period / 50:.6f}"
    + ("\n" if period <= 0 else f" {0.1 / period:.6f}\n")
    for period in (-1.0, 0.0, 10.0, 5.0)
    for i in (1, 5)
    for j in (1, 5)
)
WAMIT_EXCITATION = "".join(
    f"{period} {heading} {i} {1.5 * i} 90.0 0.0 {1.5 * i}\n"
    for period in (10.0, 5.0)
    for heading in (0.0, 30.0)
    for i in (1, 5)
)
WAMIT_HYDROSTATICS = "\n".join(f"{i} {j} {10 * i + j}" for i in range(1, 7) for j in range(1, 7))
SERIES = "time [s],speed [m/s]\n" + "".join(f"{0.5 * i},{8 + 0.3 * (i % 7)}\n" for i in range(40))


@dataclass(frozen=True)
class Kind:
    """A kind of file: its name, its good content, its reader; whether it carries checksums of its content."""

    name: str
    content: Callable[[Path], bytes]
    read: Callable[[Path], Any]
    checked: bool = False


def _file(*parts: str) -> Callable[[Path], bytes]:
    return lambda folder: DATA.joinpath(*parts).read_bytes()


def _text(text: str) -> Callable[[Path], bytes]:
    return lambda folder: text.encode()


def _result(suffix: str) -> Callable[[Path], bytes]:
    def make(folder: Path) -> bytes:
        import fowtlib as fw

        plant = fw.load("oc3_spar_rigid").compile()
        result = plant.simulate(1.0, 0.1, parameters={"wind.mean_speed": 8.0})
        return result.save(folder / f"good{suffix}").read_bytes()

    return make


def _journal(folder: Path) -> bytes:
    """The journal of a run that was killed after its third piece."""
    import fowtlib as fw
    from fowtlib.solving import run
    from fowtlib.solving.results.journal import Journal

    plant, piece = fw.load("oc3_spar_rigid").compile(), run.PIECE
    run.PIECE = 0.0
    try:
        plant.simulate(60.0, 0.1, parameters={"wind.mean_speed": 8.0}, journal=Journal(folder / "run.nc"))
    finally:
        run.PIECE = piece
    return (folder / "run.nc.part").read_bytes()


def _read_journal(path: Path) -> Any:
    """Nothing where it ends too early and says so, so that only numbers that have changed count."""
    from fowtlib.language.errors import ModelError
    from fowtlib.solving.results import Result

    result = Result.open(path)
    if "damaged" in result.attributes["status"]:
        raise ModelError(result.attributes["status"])
    return [result.time, *result.stored.values.items(), result.stored.units, result.raw.x, result.raw.z, result.raw.d]


def _field(folder: Path) -> bytes:
    from fowtlib.components.environment.field_file import FieldGrid, write_field

    speeds = 10 + np.random.default_rng(1).standard_normal((12, 3, 4, 3))
    write_field(folder / "good.bts", FieldGrid(3, 4, 12, 10.0, 10.0, 0.5, 10.0, 90.0, 60.0), speeds)
    return (folder / "good.bts").read_bytes()


def _fmu(folder: Path) -> bytes:
    with zipfile.ZipFile(folder / "good.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.writestr("binaries/linux64/tank.so", bytes(range(256)) * 8)
        archive.writestr("resources/table.txt", "1 2 3\n" * 50)
    return (folder / "good.fmu").read_bytes()


def _read_fmu(path: Path) -> Any:
    """The description, and the content of all files, as they are unpacked for a run."""
    from fowtlib.components.fmu.archive import Archive
    from fowtlib.components.fmu.description import read_description

    archive = Archive(path)
    description = read_description(archive.description(), path.name)
    target = path.parent / "unpacked"
    target.mkdir()
    archive.unpack(target)
    files = {str(file.relative_to(target)): file.read_bytes() for file in sorted(target.rglob("*")) if file.is_file()}
    return [list(description.variables.values()), sorted(files.items())]


def _read_result(path: Path) -> Any:
    """The series, and for a resumable file the state from which a run goes on."""
    from fowtlib.solving.results import Result

    result = Result.open(path)
    stored = result.stored
    raw = [] if stored.raw is None else [stored.raw.x, stored.raw.z, stored.raw.d, stored.raw.x_names]
    statistics = [] if not len(stored.values) else [item.mean for item in result.statistics().values()]
    texts = [stored.units, stored.long_names, stored.attributes]
    return [stored.time, *stored.values.items(), *texts, *raw, statistics]


def _read_field(path: Path) -> Any:
    from fowtlib.components.environment.field_file import read_field
    from fowtlib.components.environment.field_lookup import FieldLookup

    field = read_field(path)
    FieldLookup(field, None, "linear").evaluate(np.array([[0.0, 0.0, 75.0]]), 1.0)
    return [field.grid, np.array(field.stored)]


def _lazily(module: str, name: str, *arguments: Any, **options: Any) -> Callable[[Path], Any]:
    def read(path: Path) -> Any:
        import importlib

        return getattr(importlib.import_module(f"fowtlib.components.{module}"), name)(str(path), *arguments, **options)

    return read


KINDS = (
    Kind("airfoils.csv", _file("nrel5mw", "airfoils.csv"), _lazily("aero.blade_aerodynamics", "read_airfoils")),
    Kind("tower.csv", _file("oc3_hywind", "tower.csv"), _lazily("mechanics.beam_properties", "read_beam")),
    Kind("blade.csv", _file("nrel5mw", "blade_structure.csv"), _lazily("mechanics.beam_properties", "read_beam")),
    Kind(
        "rotor.csv", _file("nrel5mw", "rotor_coefficients.csv"), _lazily("aero.coefficient_table", "read_coefficients")
    ),
    Kind(
        "hydrodynamics.nc",
        _file("oc3_hywind", "hydrodynamics.nc"),
        _lazily("hydro.linear_loads", "read_database"),
        True,
    ),
    Kind("field.bts", _field, _read_field),
    Kind("wind.csv", _text(SERIES), _lazily("environment.wind_file", "read_series", 1)),
    Kind("waves.csv", _text(SERIES), _lazily("environment.sea.record", "read_record")),
    Kind("platform.1", _text(WAMIT_RADIATION), _lazily("hydro.wamit", "read_radiation", rho=1025.0)),
    Kind("platform.3", _text(WAMIT_EXCITATION), _lazily("hydro.wamit", "read_excitation", rho=1025.0, g=9.81)),
    Kind("platform.hst", _text(WAMIT_HYDROSTATICS), _lazily("hydro.wamit", "read_hydrostatics", rho=1025.0, g=9.81)),
    Kind("result.nc", _result(".nc"), _read_result, True),
    Kind("run.nc.part", _journal, _read_journal, True),
    Kind("result.csv", _result(".csv"), _read_result),
    Kind("result.outb", _result(".outb"), _read_result),
    Kind("tank.fmu", _fmu, _read_fmu, True),
)


@cache
def good(kind: Kind) -> tuple[bytes, str]:
    """The content of a good file of the kind, and the digest of what it stands for; made once, in the parent."""
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        content = kind.content(folder)
        path = folder / "once" / kind.name
        path.parent.mkdir()
        path.write_bytes(content)
        return content, digest(kind.read(path))


def digest(value: Any) -> str:
    """A digest of all numbers and texts in a value."""
    import hashlib

    found = hashlib.sha256()
    for piece in _pieces(value):
        found.update(piece + b"\0")
    return found.hexdigest()


def _pieces(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        yield f"{value.shape}{value.dtype.kind}".encode() + np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value):
        for field in fields(value):
            if field.name not in ("path", "where", "lines", "lookup"):
                yield from _pieces(getattr(value, field.name))
    elif isinstance(value, dict):
        for key, item in value.items():
            yield str(key).encode()
            yield from _pieces(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from _pieces(item)
    elif isinstance(value, bytes):
        yield value
    elif hasattr(value, "__dict__"):
        yield from _pieces(
            {key: item for key, item in vars(value).items() if not key.startswith("_") and key != "path"}
        )
    else:
        yield str(value).encode()
