"""Vectors in world axes among the unknowns and rows of an implicit step, and the frames with which they turn.

A part that is light or slender about one of its axes keeps it in the part and not in the world, so that a Newton
matrix in world axes ages as the part turns, by milliradians. `fixed` turns such vectors with their frames. What is
found here is a hint: where it is wrong it costs time and no accuracy.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import casadi as ca

from fowtlib.flattening import FlatDAE

ACCELERATION = re.compile(r"der\((.*)\.w\[[012]\]\)$")  # angular, of a frame
OF_A_BODY = re.compile(r"der\(der\((.*)\.(?:surge|sway|heave)\)\)$")
ROWS = re.compile(r"(.*) \(.*\)$")  # a part or a connector, and where the equation is written


@dataclass
class TurningFrame:
    """R (3 x 3), from the frame to the world, by states and parameters; numbers of the components of its vectors."""

    R: ca.SX
    unknowns: list[list[int]] = field(default_factory=list)
    rows: list[list[int]] = field(default_factory=list)


Found = dict[tuple[int, ...], TurningFrame]  # by the elements of R


def turning_frames(dae: FlatDAE) -> list[TurningFrame]:
    """Found by the paths; of a frame that turns with a ring of parts, the axes of the ring where its angle is zero.

    Unknowns are numbers of z, rows of alg.
    """
    found: Found = {}
    unknowns = _triples(_first(q.path, ACCELERATION, OF_A_BODY) for q in dae.algebraics)
    rows = _triples(path if ROWS.match(path) else None for path in dae.residual_paths)
    for path, numbers in unknowns:
        _put(found, dae, path, "unknowns", numbers)
    for path, numbers in rows:
        _put(found, dae, _first(path, ROWS), "rows", numbers)
    return list(found.values())


def _first(path: str, *patterns: re.Pattern[str]) -> str | None:
    return next((match[1] for pattern in patterns if (match := pattern.match(path))), None)


def _triples(paths: Iterable[str | None]) -> Iterator[tuple[str, list[int]]]:
    """Numbers of what has the same path, three at a time, where they are three or more."""
    groups: dict[str, list[int]] = defaultdict(list)
    for i, path in enumerate(paths):
        if path is not None:
            groups[path].append(i)
    for path, numbers in groups.items():
        if len(numbers) % 3 == 0:
            yield from ((path, numbers[k : k + 3]) for k in range(0, len(numbers), 3))


def _put(found: Found, dae: FlatDAE, path: str | None, kind: str, numbers: list[int]) -> None:
    names = (f"{path}{end}" for end in (".R", ".frame_a.R", ".frame_b.R"))
    name = next((name for name in names if f"{name}[0,0]" in dae.observed), None)
    if name is None:
        return
    R = dae.observe_expression(name)
    if R.shape != (3, 3) or any(ca.which_depends(R, other, 1, True)[0] for other in (dae.z, dae.w) if other.numel()):
        return
    for ring in dae.symmetries:
        if ring.angle.is_symbolic():
            R = ca.substitute(R, ring.angle, 0)
    key = tuple(R[i, j].element_hash() for i in range(3) for j in range(3))
    getattr(found.setdefault(key, TurningFrame(R)), kind).append(numbers)
