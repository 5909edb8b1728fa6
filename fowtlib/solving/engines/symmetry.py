"""Unknowns and equations of parts in cyclic symmetry, such as the blades of a rotor; see `cyclic_symmetry`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from fowtlib.flattening import FlatDAE
from fowtlib.solving.engines.reduction import Reduction


@dataclass(frozen=True)
class CyclicUnknowns:
    """What the unknowns of an implicit step have of a ring of parts.

    state: the number of the state that is its angle. unknowns, rows: the same unknown, or equation, of each part, in
    the order of the parts. Unknowns are z and then the free rates; equations are alg and then those of the rates.
    """

    state: int
    unknowns: list[list[int]]
    rows: list[list[int]]


def cyclic_unknowns(dae: FlatDAE, reduced: Reduction) -> list[CyclicUnknowns]:
    """Found by the paths; without those whose angle is no state, or of less than three parts, which are of no use."""
    numbers = {dae.x[i].element_hash(): i for i in range(dae.x.shape[0])}
    rates = [dae.states[i].path for i in reduced.free]
    unknowns = [quantity.path for quantity in dae.algebraics] + rates
    rows = list(dae.residual_paths) + rates
    found: dict[int, CyclicUnknowns] = {}
    for symmetry in dae.symmetries:
        state = numbers.get(symmetry.angle.element_hash())
        if state is not None and len(symmetry.parts) > 2:
            known = found.setdefault(state, CyclicUnknowns(state, [], []))
            if not known.unknowns or len(known.unknowns[0]) == len(symmetry.parts):
                known.unknowns.extend(counterparts(unknowns, symmetry.parts))
                known.rows.extend(counterparts(rows, symmetry.parts))
    return [symmetry for symmetry in found.values() if symmetry.unknowns]


def counterparts(paths: Sequence[str], parts: Sequence[str]) -> list[list[int]]:
    """Numbers of the paths that are the same but for the part, in all of the parts; equal ones in their order."""
    of_part: list[dict[tuple[str, int], int]] = [{} for _ in parts]
    for numbers, part in zip(of_part, parts, strict=True):
        seen: dict[str, int] = defaultdict(int)
        for i, path in enumerate(paths):
            before, inside, after = path.partition(f"{part}.")
            if inside and before in ("", "der("):
                numbers[f"{before}|{after}", seen[path]] = i
                seen[path] += 1
    return [[numbers[key] for numbers in of_part] for key in of_part[0] if all(key in n for n in of_part)]
