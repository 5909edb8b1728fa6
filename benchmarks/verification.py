"""The numbers of docs/verification.md.

`make verification` computes all of them and writes them into the page, between the marks of each section;
`python benchmarks/verification.py NAME ...` prints some. References:

- OC3: J. Jonkman, Definition of the Floating System for Phase IV of OC3, NREL/TP-500-47535 (2010); J. Jonkman and
  W. Musial, OC3 for IEA Wind Task 23, NREL/TP-5000-48191 (2010).
- Thesis: O. El Beshbichi, PhD thesis, University of Stavanger (2023), whose Modelica model has the same physics.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

PAGE = Path(__file__).parent.parent / "docs" / "verification.md"
Table = tuple[tuple[str, ...], list[tuple[object, ...]]]  # heads, rows
SECTIONS: dict[str, Callable[[], Table]] = {}


def section(function: Callable[[], Table]) -> Callable[[], Table]:
    """Register a section of the page under the name of its function."""
    SECTIONS[function.__name__] = function
    return function


@section
def mooring_line() -> Table:
    """One OC3 line: fairlead tension over the distance from the anchor, fairlead 250 m above the seabed."""
    from fowtlib.components.mooring import catenary

    line = catenary.Line(902.2, catenary.weight_in_water(77.7066, 0.09), 384.243e6)
    reference = {800: 353.5, 820: 474.8, 840: 721.1, 848.67: 911.1, 855: 1107.9, 865: 1688.1, 880: 5660.0}
    rows = []
    for distance, tension in reference.items():
        own = float(np.hypot(*catenary.fairlead_tension(distance, 250.0, line))) / 1e3
        rows.append((distance, own, tension, _percent(own, tension)))
    return ("distance [m]", "tension [kN]", "independent solution [kN]", "difference"), rows


@section
def wave_spectrum() -> Table:
    """Energy of JONSWAP seas (Hs 6 m, Tp 10 s) in bands of frequency: the mean of 50 seeds against the spectrum."""
    from fowtlib.components.environment.waves import irregular_waves, jonswap

    seas = [irregular_waves(6.0, 10.0, 320.0, seed=seed) for seed in range(1, 51)]
    omega = seas[0].omega
    energy = np.mean([sea.amplitude**2 / 2 for sea in seas], axis=0)
    rows = []
    for low, high in ((0.04, 0.08), (0.08, 0.095), (0.095, 0.105), (0.105, 0.12), (0.12, 0.2), (0.2, 0.5)):
        inside = (omega >= 2 * np.pi * low) & (omega < 2 * np.pi * high)
        target = float(np.sum(jonswap(omega[inside], 6.0, 10.0)) * (omega[1] - omega[0]))
        own = float(energy[inside].sum())
        rows.append((f"{low:g} to {high:g}", own, target, _percent(own, target)))
    return ("band [Hz]", "mean of 50 seeds [m^2]", "JONSWAP [m^2]", "difference"), rows


def _percent(own: float, reference: float) -> str:
    return f"{100 * (own / reference - 1):+.2f} %"


def markdown(table: Table) -> str:
    """A table as text of the page."""
    heads, rows = table
    lines = [heads, tuple("---" for _ in heads), *rows]
    cells = [[f"{cell:.5g}" if isinstance(cell, float) else str(cell) for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def fill(page: str, name: str, text: str) -> str:
    """The page with the text between the marks of a section."""
    marks = rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)"
    filled, count = re.subn(marks, lambda match: f"{match[1]}{text}\n{match[2]}", page, flags=re.S)
    if count != 1:
        raise SystemExit(f"{PAGE.name} has no place for the section {name}")
    return filled


def main(names: list[str]) -> int:
    """Print the chosen sections, or write all of them into the page."""
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    page = PAGE.read_text()
    for name in names or SECTIONS:
        text = markdown(SECTIONS[name]())
        print(f"{name}\n\n{text}\n", flush=True)
        page = fill(page, name, text)
    if not names:
        PAGE.write_text(page)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
