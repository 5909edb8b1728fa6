"""What a run takes in: only what is computed from a changed parameter is computed anew, and it is the same."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.errors import ModelError
from fowtlib.solving.binding import bind


@pytest.mark.parametrize("name", ["oc3_spar_rigid", "two_rotor_support"])
def test_what_is_computed_from_a_changed_parameter_is_that_of_a_binding_from_nothing(name):
    """For every tunable parameter of the model that takes a change of 0.1 %."""
    plant = fw.load(name).compile()
    tried = 0
    for path, item in plant.dae.parameters.items():
        given = {path: item.value * 1.001}
        try:
            whole = bind(plant.dae, plant.root, given)
        except ModelError:  # a limit, or a matrix that has to be symmetric
            continue
        part = plant.binding(given)
        tried += 1
        assert np.array_equal(part.p, whole.p, equal_nan=True), path
    assert tried > 50
    assert any(plant._bindings.needs.values())  # some are computed from others
