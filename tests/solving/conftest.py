"""What several tests of the engines ask of a plant."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.solving.engines import create_engine


@pytest.fixture
def leads_to_the_same_motion_with_less_work():
    """A check of a hint in the table of a model: fewer evaluations, and the motion as far as Newton is exact."""

    def check(plant, hint):
        start, runs, table = plant.initial_state(), {}, plant.fixed_step_code.table
        count = getattr(table, hint)
        for given in (count, 0):
            setattr(table, hint, given)
            engine = create_engine(plant.at(), lambda: plant.fixed_step_code, "fixed", 1e-6, 0.1, {"step": 0.0125}, {})
            setattr(table, hint, count)
            x, _ = engine.advance(0.0, 8.0, 80, start.x, start.z, np.concatenate([start.u, start.d]))
            runs[bool(given)] = x, engine.counts()["evaluations"]
        (turned, few), (kept, many) = runs[True], runs[False]
        assert few < 0.9 * many
        scale = np.ptp(kept, axis=0) + 1e-9
        assert np.median(np.abs(turned - kept).max(axis=0) / scale) < 1e-3

    return check
