"""Slopes of the strips of a part of a hull in closed form, against extrapolated differences of its strips."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.components.hydro.hull_part import HullPart
from fowtlib.components.hydro.hull_part_slopes import HullPartSlopes
from fowtlib.solving.differences import derivative

HEIGHTS = np.array([-80.0, -62.0, -45.0, -20.0, 0.0, 10.0])
DIAMETERS = np.array([21.0, 15.0, 13.0, 20.0, 12.8, 12.6])


@pytest.mark.parametrize(("low", "high", "count"), [(-80.0, -50.0, 1), (-70.0, -30.0, 4), (-33.0, 6.0, 3)])
def test_strips_of_a_part(low, high, count):
    """Diameters, ends, place and added mass change at once; differences of fourth order are good to 1e-9."""
    rng = np.random.default_rng(2)
    wide, ends, place = rng.uniform(0.5, 1.5, 6), rng.uniform(-1.0, 1.0, 2), rng.uniform(-1.0, 1.0, 3)
    ends[0] *= low > HEIGHTS[0]  # a keel stays at the first station

    def at(change: float) -> HullPart:
        return HullPart(HEIGHTS, DIAMETERS + change * wide, low + change * ends[0], high + change * ends[1],
                        change * place, count, low == HEIGHTS[0], high > 0, 1.0 + 0.3 * change)  # fmt: skip

    def numbers(change: float) -> np.ndarray:
        part = at(change)
        return np.concatenate([part.head, part.rows.ravel(), part.places.ravel(), part.widths])

    slopes = HullPartSlopes(at(0.0), wide[:, None], ends[:1], ends[1:] * (high < 0), place[:, None], np.array([0.3]))
    found = np.concatenate([slopes.numbers, slopes.places, slopes.widths])[:, 0]
    np.testing.assert_allclose(found, derivative(numbers, 0.0, size=10.0), rtol=1e-7, atol=1e-7)


def test_stations_that_move_and_ends_on_the_water_level_are_not_known():
    """There the strips have kinks, which differences see and refuse."""
    part = HullPart(HEIGHTS, DIAMETERS, -80.0, 0.0, np.zeros(3), 3, True, True)
    tangents = {"heights": np.zeros((6, 3)), "diameters": np.eye(6)[:, :3], "low": np.zeros((1, 3)),
                "high": np.array([[0.0, 1.0, 0.0]]), "position": np.zeros((3, 3)),
                "added_mass_coefficient": np.zeros((1, 3))}  # fmt: skip
    tangents["heights"][2, 2] = 1.0
    found = HullPartSlopes.along(part, None, lambda _, name: tangents[name])
    assert np.isfinite(found.numbers).all(axis=0).tolist() == [True, False, False]
