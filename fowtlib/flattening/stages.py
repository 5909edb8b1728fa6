"""States whose implicit steps an external function solves: only that function may read them."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from fowtlib.flattening.flat_dae import External
from fowtlib.language.errors import StructureError
from fowtlib.language.stages import Stage


def stages(given: Sequence[Stage], x: ca.SX, rows: Sequence[ca.SX], externals: Sequence[External]) -> list[Stage]:
    """The same, once it is sure that each is states of the model, and read by one external function alone.

    rows: all equations of the model, as they are solved. Raises StructureError.
    """
    numbers = {x[i].element_hash(): i for i in range(x.shape[0])}
    read = [_read(x, ca.vertcat(*rows)), *(_read(x, external.inputs) for external in externals)]
    for stage in given:
        elements = [stage.states[i] for i in range(stage.states.numel())]
        found = [numbers.get(element.element_hash()) for element in elements]
        label = stage.path or "the model"
        if None in found:
            raise StructureError(
                f"{label}: {elements[found.index(None)]} is given to stage_step() and is no state of the model; "
                'declare it with state="prefer".'
            )
        readers = [i for i, some in enumerate(read) if some & set(found)]
        if len(readers) != 1 or readers[0] == 0:
            raise StructureError(
                f"{label}: the states that are given to stage_step() are read by "
                f"{'equations' if 0 in readers else f'{len(readers)} external functions'}; only the one external "
                "function that solves their steps may read them."
            )
    return list(given)


def _read(x: ca.SX, rows: ca.SX) -> set[int]:
    """Numbers of the states on which rows depend themselves."""
    pattern = ca.Function("read", [x], [ca.densify(rows)], {"allow_free": True}).jac_sparsity(0, 0)
    return set(pattern.get_triplet()[1])
