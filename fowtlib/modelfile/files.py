"""Where files are: model files, definitions for `use:`, data, and the models that fowtlib brings."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from fowtlib.language.data_files import require_file
from fowtlib.language.errors import ModelFileError, did_you_mean
from fowtlib.modelfile.permit import Permit

SUFFIX = ".yaml"
DATA_PREFIX = "data:"
DATA_SUFFIXES = (".nc", ".csv", ".yaml", ".yml", ".json", ".dat", ".txt", ".npz", ".1", ".3", ".hst", ".so", ".dll",
                 ".bts")  # fmt: skip
LONGEST_NAME = 1000  # letters of a path
LONGEST_PART = 240  # bytes of one name in it; a file system takes 255, and an ending may follow


def is_file(path: Path) -> bool:
    """Whether a path names a file; no name that a system cannot even ask for does."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or with a zero byte
        return False


def no_file(source: str | os.PathLike[str], known: Sequence[str] = ()) -> ModelFileError:
    """The error of a path that names no file, though a folder perhaps; known: names that may have been meant."""
    path = Path(source)
    try:
        if path.is_dir():
            return ModelFileError(f"'{source}' is a folder; a file is expected.")
    except (OSError, ValueError):
        pass
    return ModelFileError(f"there is no file '{source}'{did_you_mean(path.name, known)}")


def models_folder() -> Path:
    """The folder of the shipped models (`fowtlib.models`)."""
    import fowtlib.models

    return Path(fowtlib.models.__path__[0])


def shipped_models() -> dict[str, Path]:
    """The shipped model files by name."""
    return {path.stem: path for path in sorted(models_folder().glob(f"*{SUFFIX}"))}


def data_path(name: str) -> Path:
    """A shipped data file, such as "oc3_hywind/hydrodynamics.nc"; in model files it is written "data:" + name."""
    folder = models_folder() / "data"
    path = folder / name
    if not is_file(path) or not path.resolve().is_relative_to(folder.resolve()):
        known = [str(item.relative_to(folder)) for item in sorted(folder.rglob("*")) if item.is_file()]
        raise ModelFileError(f"there is no shipped data file '{name}'{did_you_mean(name, known)}")
    return path


def find_model(source: str | os.PathLike[str]) -> Path:
    """The model file for a path or a shipped name."""
    path = Path(source)
    if is_file(path):
        require_file(path, ModelFileError)
        return path
    shipped = shipped_models()
    if path.suffix in (SUFFIX, ".yml") or len(path.parts) > 1:
        here = [item.name for item in sorted(path.parent.glob("*.y*ml"))] if path.parent.is_dir() else []
        raise no_file(source, here)
    if str(source) not in shipped:
        here = [item.name for item in sorted(Path().glob(f"*{SUFFIX}"))]
        hint = did_you_mean(str(source), [f"{source}{SUFFIX}"] if f"{source}{SUFFIX}" in here else [*shipped, *here])
        raise ModelFileError(f"there is no model '{source}', nor a file of that name{hint}")
    return shipped[str(source)]


def find_definition(name: str, folder: Path, permit: Permit | None = None) -> Path:
    """The definition file that `use: name` means: beside the file that says so, or shipped."""
    _check_length(name)
    for base in (folder, models_folder()):
        for path in (base / name, base / f"{name}{SUFFIX}"):
            if permit is not None:
                permit.require(_resolved(base, str(path)), name)
            if is_file(path):
                require_file(path, ModelFileError)
                return path
    beside = (folder / name).parent
    known = [str(Path(name).parent / path.stem) for path in sorted(beside.glob(f"*{SUFFIX}"))]
    shipped = [path.relative_to(models_folder()) for path in sorted(models_folder().glob(f"*/**/*{SUFFIX}"))]
    known += [str(path.with_suffix("")) for path in shipped if path.parts[0] != "data"]
    raise ModelFileError(f"there is no definition '{_short(name)}'{did_you_mean(name, known)}")


def find_data(name: str, folder: Path, permit: Permit | None = None, *, native: bool = False) -> Path:
    """The file that a parameter names: shipped ("data:..."), absolute, or relative to the model file.

    permit: what is allowed, where a model file names it; what the user names is allowed by that. native: it is code.
    """
    path = data_place(name, folder, permit, native=native)
    if path.is_dir():
        raise ModelFileError(f"'{name}' is a folder; a file is expected.")
    require_file(path, ModelFileError)
    if not is_file(path):
        known = [item.name for item in sorted(path.parent.glob("*"))] if path.parent.is_dir() else []
        raise ModelFileError(f"there is no file '{name}'{did_you_mean(path.name, known)}")
    return path


def data_place(name: str, folder: Path, permit: Permit | None = None, *, native: bool = False) -> Path:
    """Where the file of `find_data` lies, whether there is one or not; a shipped one is."""
    _check_length(name)
    if name.startswith(DATA_PREFIX):
        return data_path(name.removeprefix(DATA_PREFIX))
    path = _resolved(folder, name, expand=True)
    if permit is not None:
        permit.require(path, name, native=native)
    return path


def names_file(parameter: str, text: str) -> bool:
    """Whether the text of a parameter names a file: by its prefix or suffix, or because this is called `file`."""
    by_name = parameter in ("file", "path") or parameter.endswith(("_file", "_path"))
    return by_name or text.startswith(DATA_PREFIX) or text.lower().endswith(DATA_SUFFIXES)


def _check_length(name: str) -> None:
    """Refuse a path that no system can look for."""
    if len(name) > LONGEST_NAME:
        raise ModelFileError(f"'{_short(name)}' has {len(name)} letters; the limit is {LONGEST_NAME}.")
    if any(len(part.encode("utf-8", "surrogatepass")) > LONGEST_PART for part in name.split("/")):
        raise ModelFileError(f"'{_short(name)}' is too long for the name of a file.")


def _resolved(folder: Path, name: str, *, expand: bool = False) -> Path:
    """Where a name leads from a folder, links followed."""
    try:
        return (folder / (Path(name).expanduser() if expand else name)).resolve()
    except (OSError, ValueError, RuntimeError) as error:  # RuntimeError: nobody's home folder, or a ring of links
        raise ModelFileError(f"'{name[:60]}' is not the name of a file: {error}.") from None


def shown(path: Path) -> str:
    """How messages call a file: relative to where the user is, or to the shipped models."""
    resolved = path.resolve()
    for base, prefix in ((Path.cwd(), ""), (models_folder().resolve(), "models")):
        if resolved.is_relative_to(base):
            return str(Path(prefix) / resolved.relative_to(base))
    return str(path)


def as_data_name(path: str) -> str:
    """The reverse of `find_data` for a shipped file: "data:...", other paths as they are."""
    folder = (models_folder() / "data").resolve()
    return DATA_PREFIX + str(Path(path).relative_to(folder)) if Path(path).is_relative_to(folder) else path


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
