"""The variables of a netCDF file of hydrodynamic data, checked for damage and for what is missing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.language.data_files import require_file
from fowtlib.language.netcdf_files import read_netcdf

EXCITATION = ("excitation_real", "excitation_imaginary")


def stored_numbers(path: str | Path) -> tuple[dict[str, np.ndarray], str]:
    """The variables by name, and where they are from. Raises HydrodynamicDataError: not there, unreadable, damaged."""
    require_file(path, HydrodynamicDataError)
    try:
        contents = read_netcdf(path)
        data = {name: np.array(item.values, dtype=float) for name, item in contents.variables.items()}
    except OSError as error:
        raise HydrodynamicDataError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (ValueError, TypeError) as error:
        raise HydrodynamicDataError(f"{path}: {error}") from None
    if contents.damaged:
        raise HydrodynamicDataError(f"{path}: the file is damaged: {contents.damage}; make or fetch it anew")
    return data, str(contents.attributes.get("source", ""))


def missing_from(data: Iterable[str], required: Sequence[str]) -> list[str]:
    """Those of the required variables, and of the excitation, that a file does not have."""
    there = set(data)
    return [name for name in (*required, *EXCITATION) if name not in there]


def excitation_of(data: dict[str, np.ndarray]) -> np.ndarray:
    """The complex wave load."""
    real, imaginary = (data[name] for name in EXCITATION)
    return real + 1j * imaginary
