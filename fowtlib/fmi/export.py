"""Export of a plant as an FMU: the archive, its parts and its settings."""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
import uuid
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.fmi.binaries import chosen, compile_platform, host, require_platforms
from fowtlib.fmi.c_text import Sources, c_sources, refuse_python
from fowtlib.fmi.dependencies import dependencies
from fowtlib.fmi.description import KINDS, Heading, build_description, model_description, terminals
from fowtlib.fmi.guards import guarded
from fowtlib.fmi.variables import Settings, Variables
from fowtlib.language.component import Component
from fowtlib.language.data_files import data_parameters, digest_of
from fowtlib.language.errors import ModelError, ParameterError, did_you_mean
from fowtlib.language.externals import refusals_explained
from fowtlib.language.units import to_si
from fowtlib.language.whole_files import WriteError, write_whole
from fowtlib.solving.engines.base import RHO_INF, STEP
from fowtlib.solving.plant import Plant

VERSIONS = ("2", "3")


@refusals_explained()
def export_fmu(
    plant: Plant, path: str | Path | None = None, *, fmi: str | int = "3", kind: str = "both",
    platforms: Sequence[str] | None = None, parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None, step: Any = None, rho_inf: float | None = None,
    tolerance: float | None = None, progress: Callable[[str], None] | None = None,
) -> Path:  # fmt: skip
    """Write the plant as a Functional Mock-up Unit; the path of the archive, `<name>.fmu` unless one is given.

    fmi: the version of the standard, "2" (2.0) or "3" (3.0).
    kind: "me" (model exchange: the importer integrates), "cs" (co-simulation: the fixed-step engine inside), "both".
    platforms: of the compiled library, "linux64", "win64", "darwin", "linux-arm64"; this machine's without any.
    parameters, start: as for Plant.initial_state; they become the start values of the FMU.
    step [s], rho_inf, tolerance: of the engine; the model's own unless given.
    progress: is told what is being done.
    Raises ModelError: a part that is Python code, no compiler, a file that cannot be written.
    """
    version = str(fmi)
    if version not in VERSIONS:
        raise ParameterError(f"there is no FMI version '{fmi}'{did_you_mean(version, VERSIONS)}")
    if kind not in KINDS:
        raise ParameterError(f"there is no kind of FMU '{kind}'{did_you_mean(kind, KINDS)}")
    names, told = chosen(platforms), progress or (lambda what: None)
    target = checked_target(Path(path) if path else default_archive(plant))
    refuse_python(plant.dae)
    require_platforms(names, version)
    told("start values")
    state = plant.initial_state(parameters, start)
    settings = _settings(plant, step, rho_inf, tolerance)
    plant = guarded(plant, plant.binding(parameters), settings.step)
    variables = Variables(plant, state, settings)
    if parameters:
        _put_parameters(variables, plant.parameter_values(parameters))
    told("C code")
    name = plant.name or plant.title or "model"
    identifier = _identifier(target.stem)
    sources = c_sources(variables, state, int(version), (name, "@"))
    token = _token(sources, version, kind)
    sources.files["tables.h"] = sources.files["tables.h"].replace('"@"', f'"{token}"', 1)
    heading = Heading(
        name, identifier, token, plant.title, datetime.now(UTC), KINDS[kind], [unit for unit, _ in sources.units]
    )
    needs = _needs(variables)
    with _scratch(target) as folder:
        for file, text in sources.files.items():
            (folder / file).write_text(text, encoding="utf-8")
        binaries: dict[str, Path] = {}
        for item in names:
            told(f"library for {item}" + (", which takes minutes the first time" if item != host() else ""))
            binaries.update(compile_platform(folder, sources.units, item, identifier, version))
        description = model_description(variables, heading, int(version), needs)
        more = {}
        if version == "3":
            more["sources/buildDescription.xml"] = build_description(identifier, sources.units)
            more["terminalsAndIcons/terminalsAndIcons.xml"] = terminals(variables)
        more |= data_files(plant.binding(parameters).root)
        _write(target, {"modelDescription.xml": description, **more}, sources, binaries)
    return target


@contextmanager
def _scratch(target: Path) -> Iterator[Path]:
    """A temporary folder for what goes into `target`; WriteError where it has no room."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            yield Path(folder)
    except OSError as error:
        place = error.filename or "in the folder of temporary files"
        raise WriteError(f"{target}: cannot be written: {error.strerror or error} ({place}).") from error


def data_files(root: Component | None) -> dict[str, bytes]:
    """The data files of a model, as resources/data of an FMU, and data.json, which says what each of them is.

    The FMU reads none of them: its tables hold their numbers. They go along so that one can see what it was made from.
    """
    files, index = {}, {}
    for parameter, path in data_parameters(root).items():
        inside = f"{digest_of(path)[:12]}_{Path(path).name}"
        files[f"resources/data/{inside}"] = Path(path).read_bytes()
        index[parameter] = {"file": inside, "sha256": digest_of(path)}
    return {**files, "resources/data/data.json": json.dumps(index, indent=1).encode()} if index else {}


def _settings(plant: Plant, step: Any, rho_inf: float | None, tolerance: float | None) -> Settings:
    def pick(given: Any, key: str, unit: str, default: float) -> float:
        value = plant.settings.get(key, default) if given is None else given
        return float(to_si(value, unit, key))

    output = pick(None, "output_step", "s", 0.1)
    settings = Settings(
        step=pick(step, "step", "s", min(STEP, output)), rho_inf=pick(rho_inf, "rho_inf", "1", RHO_INF),
        tolerance=pick(tolerance, "tolerance", "1", 1e-6), duration=pick(None, "duration", "s", 600.0),
        output_step=output,
    )  # fmt: skip
    if not 0 < settings.step < np.inf:
        raise ParameterError(f"the step of the engine is {settings.step:g} s; it must be above zero, usually 0.01 s.")
    if not 0 <= settings.rho_inf <= 1:
        raise ParameterError(f"rho_inf is {settings.rho_inf:g}; it must lie between 0 and 1, usually 0.7 to 0.9.")
    if not 0 < settings.tolerance < 0.1:
        raise ParameterError(f"the tolerance is {settings.tolerance:g}; it must lie between 0 and 0.1, usually 1e-6.")
    return settings


def _put_parameters(variables: Variables, values: Mapping[str, np.ndarray]) -> None:
    numbers = [float(v) for value in values.values() for v in np.ravel(value, order="F")]
    first = variables.first["parameter"]
    for i, number in enumerate(numbers):
        variables.items[first + i] = variables.items[first + i].with_start(number)


def _needs(variables: Variables) -> dict[int, list[int]]:
    """For each derivative, output and indicator the numbers of what it depends on."""
    dae = variables.plant.dae
    rows = [dae.ode, *variables.output_expressions, *(event.indicator for event in dae.events)]
    table = dependencies(dae, ca.vertcat(*[ca.densify(row) for row in rows]))
    columns = [0, *(v.reference for v in variables.group("state")), *(v.reference for v in variables.group("input"))]
    unknown = [v.reference for group in ("rate", "output", "indicator") for v in variables.group(group)]
    found = {r: [columns[i] for i in np.flatnonzero(row)] for r, row in zip(unknown, table, strict=True)}
    for item in variables.outputs:
        found.setdefault(item.reference, [item.reference] if item.group == "state" else [])
    return found


def _token(sources: Sources, version: str, kind: str) -> str:
    """The same for the same contents."""
    digest = hashlib.sha256(f"{version}{kind}".encode())
    for name, text in sorted(sources.files.items()):
        digest.update(name.encode() + text.encode())
    digest.update(sources.tables)
    return f"{{{uuid.UUID(bytes=digest.digest()[:16], version=5)}}}"


def _identifier(name: str) -> str:
    word = re.sub(r"\W", "_", name, flags=re.ASCII)
    return word if word[:1].isalpha() else f"m_{word}"


def default_archive(plant: Plant) -> Path:
    """The archive where nobody names one."""
    return Path(f"{_identifier(plant.name or 'model')}.fmu")


def checked_target(path: Path) -> Path:
    """Refuse a file of another kind, or one that cannot be written, before the work."""
    if path.suffix != ".fmu":
        raise ModelError(f"{path}: the file must end in '.fmu'.")
    if not path.parent.is_dir():
        raise ModelError(f"{path}: the folder {path.parent} does not exist; make it first, or choose another one.")
    if path.is_dir():
        raise ModelError(f"{path}: is a folder; choose another name.")
    return path


def _write(path: Path, texts: Mapping[str, bytes], sources: Sources, binaries: Mapping[str, Path]) -> None:
    """The archive, whole and on the disk or not at all."""

    def pack(fresh: Path) -> None:
        with zipfile.ZipFile(fresh, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            for name, written in texts.items():
                archive.writestr(name, written)
            for name, text in sources.files.items():
                archive.writestr(f"sources/{name}", text)
            for inside, binary in binaries.items():
                archive.write(binary, inside)
            archive.writestr("resources/tables.bin", sources.tables)
            for name, file_path in sources.resources.items():
                archive.write(file_path, f"resources/{name}")

    write_whole(path, pack)
