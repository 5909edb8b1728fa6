"""Meshes of hulls in the GDF files of WAMIT (low-order panels, IGDEF = 0), which HAMS and many others read too.

=====  ====================  =====================================================================================
line   content               meaning
=====  ====================  =====================================================================================
1      any text
2      ULEN GRAV             length scale of the results of WAMIT; acceleration of gravity [m/s^2]
3      ISX ISY               1: the plane x = 0, y = 0 is one of symmetry, the panels beyond it are not in the file
4      NPAN                  number of panels
5 ...  X Y Z                 the four corners of one panel after the other [m], counter-clockwise seen from the
                             water; a triangle repeats a corner; each panel begins on a new line
=====  ====================  =====================================================================================

Panels on the water level (a lid in the file) are taken as lid.

Source: WAMIT User Manual, version 7, section 6.1 (the geometric data file).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.fortran_numbers import number_of, wrong
from fowtlib.components.hydro.hull_mesh import HullMesh, clipped
from fowtlib.language.data_files import text_of
from fowtlib.language.whole_files import write_text

_LEVEL = 1e-6  # of the extent: panels that are nearer to z = 0 with all corners are a lid
_JOIN = 5e-5  # of the extent: corners that are further apart were not one point before they were rounded
_MIRROR = {"x": np.array([-1.0, 1.0, 1.0]), "y": np.array([1.0, -1.0, 1.0])}


def read_gdf(path: str | Path, *, leaky: bool = False) -> HullMesh:
    """The hull of a .gdf file, its mirror images added, cut at z = 0 where it reaches above the water.

    Corners that differ by no more than the last digits of the file are one point. leaky: see HullMesh.

    Raises HydrodynamicDataError, with file and line, for what is not such a file, and ParameterError for a hull that
    leaks or is turned inside out.
    """
    path = Path(path)
    lines = text_of(path, "the GDF file", HydrodynamicDataError).splitlines()
    if len(lines) < 5:
        raise wrong(path, None, "the file ends before its first panel")
    _, g = _head(path, lines, 2, "ULEN GRAV")
    isx, isy = _head(path, lines, 3, "ISX ISY")
    (count,) = _head(path, lines, 4, "NPAN")
    if not g > 0:
        raise wrong(path, 2, f"gravity is {g:g}; a GDF file has ULEN and GRAV in its second line")
    if isx not in (0, 1) or isy not in (0, 1):
        raise wrong(path, 3, f"ISX and ISY are 0 or 1, found {isx:g} {isy:g}")
    if count != int(count) or count < 1:
        raise wrong(path, 4, f"'{count:g}' is not a number of panels")
    if _patches(lines[3]):
        raise wrong(path, 4, "this is a file of patches (IGDEF > 0); export flat panels (IGDEF = 0, ILOWHI = 0)")
    corners = _corners(path, lines, 12 * int(count))
    panels = np.array(corners).reshape(-1, 4, 3)
    for mirrored, axis in ((isx, "x"), (isy, "y")):
        if mirrored:
            panels = np.concatenate([panels, (panels * _MIRROR[axis])[:, ::-1]])
    extent = float(np.ptp(panels, axis=(0, 1)).max())
    flat = np.abs(panels[:, :, 2]).max(axis=1) < _LEVEL * extent
    hull, lid = clipped(panels[~flat]), panels[flat]
    if not len(hull):
        raise wrong(path, None, "no panel lies below the still water level, z = 0")
    join = min(_rounding(lines[4:]), _JOIN * extent)
    return HullMesh(hull, lid if len(lid) else None, name=str(path), join=join, leaky=leaky)


def write_gdf(hull: HullMesh, path: str | Path, *, g: float = 9.80665) -> None:
    """Write all panels of a hull, and of its lid, without use of symmetry; ULEN is 1 m. Raises WriteError."""
    panels = np.concatenate([hull.panels, hull.lid])
    title = f"{hull.name}: {len(hull.panels)} panels, {len(hull.lid)} of a lid; made by fowtlib"
    head = [" ".join(title.split()), f"1.0 {g:.6g}  ULEN GRAV", "0 0  ISX ISY", f"{len(panels)}  NPAN"]
    rows = [" ".join(f"{value + 0.0:16.9E}" for value in corner) for panel in panels for corner in panel]
    write_text(path, "\n".join([*head, *rows]) + "\n")


def _head(path: Path, lines: list[str], line: int, names: str) -> list[float]:
    """The numbers at the start of a line; what stands behind them is a remark."""
    wanted = names.split()
    words = lines[line - 1].replace(",", " ").split()[: len(wanted)]
    if len(words) < len(wanted):
        raise wrong(path, line, f"expected '{names}', found '{lines[line - 1].strip()}'")
    return [number_of(path, line, word, f", expected '{names}'") for word in words]


def _corners(path: Path, lines: list[str], wanted: int) -> list[float]:
    """So many numbers from the fifth line on; what follows (dipole panels, which have no volume) must be none.

    Each panel begins on a line of its own; what stands behind its twelve numbers is a remark.
    """
    found: list[float] = []
    for number, line in enumerate(lines[4:], start=5):
        words = line.replace(",", " ").split()
        if len(found) == wanted and words:
            if number_of(path, number, words[0]) != 0:
                raise wrong(path, number, f"more than the {wanted // 12} panels of line 4; dipole panels are unknown")
            break
        found += [number_of(path, number, word) for word in words[: 12 - len(found) % 12]]
    if len(found) != wanted:
        raise wrong(path, len(lines), f"{wanted // 12} panels have {wanted} numbers, and the file has {len(found)}")
    return found


def _rounding(lines: list[str]) -> float:
    """A little more than twice the last digit that the numbers of the file have [m]."""
    digits = [len(mantissa.partition(".")[2]) - (int(exponent) if exponent else 0)
              for line in lines[:40] for mantissa, _, exponent in [_parts(word) for word in line.split()]]  # fmt: skip
    return 2.5 * 10.0 ** -max(digits, default=0)


def _parts(word: str) -> tuple[str, str, str]:
    return word.upper().replace("D", "E").partition("E")


def _patches(line: str) -> bool:
    """Whether the line of NPAN has an IGDEF above zero behind it."""
    words = line.split()
    return len(words) > 1 and words[1].isdigit() and int(words[1]) > 0
