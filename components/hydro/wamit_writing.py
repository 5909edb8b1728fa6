"""Writer of the WAMIT output files .1 (radiation), .3 (excitation) and .hst (hydrostatics).

Numbers without dimension, periods in seconds, headings in degrees, phases with exp(+i omega t): the conventions of the
module wamit, which reads what is written here. With the length scale 1 m, the default, the numbers are those with
dimension divided by the water density alone (added mass, damping over omega) or by density times gravity (loads and
stiffness); programs that read the files (OpenFAST: WAMITULEN) must be told the same length scale, density and gravity.

Every one of the 36 pairs of modes and all six modes stand in the files, zeros too, so that nothing is left to guess.
Ten digits: what is read again differs by 1e-9 at most. No file of WAMIT has the displaced volume and its centre, the
water depth, the density and gravity; who reads the files needs them besides.

Source: WAMIT User Manual, version 7, sections 4.2, 4.3, 4.9 (output of forces, optional numeric output files).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.components.hydro.database import HydrodynamicDatabase

ENDINGS = (".1", ".3", ".hst")
ZERO_FREQUENCY, INFINITE_FREQUENCY = -1.0, 0.0  # periods that stand for the two limits of the added mass

_ROTATION = np.array([0, 0, 0, 1, 1, 1])
_PAIRS = _ROTATION[:, None] + _ROTATION


def write_wamit(database: HydrodynamicDatabase, stem: str | Path, *, length: float = 1.0) -> list[Path]:
    """Write `stem`.1, `stem`.3 and `stem`.hst; length: ULEN [m], by which the numbers lose their dimension.

    The files that were written. Raises HydrodynamicDataError for a length that is not positive, WriteError.
    """
    if not (length > 0 and math.isfinite(length)):
        raise HydrodynamicDataError(f"the length scale of WAMIT files must be positive, found {length:g} m")
    texts = (_radiation(database, length), _excitation(database, length), _hydrostatics(database, length))
    named = zip(ENDINGS, texts, strict=True)
    return [write_text(f"{stem}{ending}", "\n".join(lines) + "\n") for ending, lines in named]


def _radiation(database: HydrodynamicDatabase, length: float) -> Iterator[str]:
    scale = database.rho * length ** (3.0 + _PAIRS)
    limits = ((ZERO_FREQUENCY, database.A_zero), (INFINITE_FREQUENCY, database.A_inf))
    for period, matrix in limits:
        if matrix is not None:
            for (i, j), value in np.ndenumerate(matrix / scale):
                yield f"{_number(period)} {i + 1:5d} {j + 1:5d} {_number(value)}"
    for omega, A, B in zip(database.omega, database.A, database.B, strict=True):
        A, B = A / scale, B / (scale * omega)
        for (i, j), value in np.ndenumerate(A):
            yield f"{_number(2 * math.pi / omega)} {i + 1:5d} {j + 1:5d} {_number(value)} {_number(B[i, j])}"


def _excitation(database: HydrodynamicDatabase, length: float) -> Iterator[str]:
    X = database.X / (database.rho * database.g * length ** (2.0 + _ROTATION))
    for k, omega in enumerate(database.omega):
        for j, heading in enumerate(database.heading):
            for mode, load in enumerate(X[k, j]):
                numbers = (abs(load), math.degrees(math.atan2(load.imag, load.real)), load.real, load.imag)
                place = f"{_number(2 * math.pi / omega)} {_number(math.degrees(heading))} {mode + 1:5d}"
                yield " ".join((place, *map(_number, numbers)))


def _hydrostatics(database: HydrodynamicDatabase, length: float) -> Iterator[str]:
    scale = database.rho * database.g * length ** (2.0 + _PAIRS)
    for (i, j), value in np.ndenumerate(database.C / scale):
        yield f"{i + 1:5d} {j + 1:5d} {_number(value)}"


def _number(value: float) -> str:
    return f"{value + 0.0:17.9E}"  # + 0.0: no minus sign before zero
