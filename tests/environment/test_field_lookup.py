"""Wind at points: against scipy's interpolation, finite differences and Taylor's hypothesis; no silent clamping."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from fowtlib.components.environment.field_file import FieldGrid, write_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.language import ModelError

GRID = FieldGrid(rows=4, columns=5, steps=40, dz=10.0, dy=12.0, dt=0.25, speed=8.0, hub_height=90.0, bottom=75.0)
SPEEDS = np.random.default_rng(3).normal((8, 0, 0), (1, 0.8, 0.5), (40, 4, 5, 3))


@pytest.fixture(scope="module")
def lookups(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fields")
    periodic = write_field(folder / "periodic.bts", GRID, SPEEDS)
    ending = write_field(folder / "ending.bts", replace(GRID, periodic=False), SPEEDS)
    return FieldLookup(periodic), FieldLookup(ending)


def inside(n=200, time=(-30.0, 60.0)):
    low, high = np.array([-20, -24, 75, time[0]]), np.array([30, 24, 105, time[1]])
    sample = np.random.default_rng(4).uniform(low, high, (n, 4))
    return sample[:, :3], sample[:, 3]


def test_against_scipy(lookups):
    points, time = inside()
    for lookup, shift in zip(lookups, (0.0, 24.0), strict=True):
        decoded = lookup.field.speeds(lookup.field.plane)
        grid = lookup.grid
        steps = np.arange(40)
        if grid.periodic:
            decoded, steps = np.concatenate([decoded, decoded[:1]]), np.arange(41)
        oracle = RegularGridInterpolator((steps * 0.25, grid.z, grid.y), decoded)
        t = time if grid.periodic else np.abs(time) / 10 + (points[:, 0] - 20) / 8  # 0.5 to 9.5 s in the field
        tau = t + (shift - points[:, 0]) / 8
        tau = np.mod(tau, 10.0) if grid.periodic else tau
        expected = oracle(np.column_stack([tau, points[:, 2], points[:, 1]]))
        np.testing.assert_allclose(lookup.velocity(points, t), expected, atol=1e-11)


def test_derivatives(lookups):
    """Central differences in the cells: the interpolation is of second degree at most along each direction."""
    points, time = inside()
    lookup, h = lookups[0], 1e-5
    rate = lookup.evaluate(points, time)[1]
    for i in range(4):
        shift = np.zeros(4)
        shift[i] = h
        ends = [lookup.evaluate(points + s * shift[:3], time + s * shift[3])[0] for s in (1, -1)]
        wrong = np.abs((ends[0] - ends[1]) / (2 * h) - rate[..., i]).max(axis=1) > 1e-7
        assert wrong.sum() <= 1  # the step crosses the edge of a cell


def test_taylor(lookups):
    """The field moves downwind with 8 m/s: what is at x now is at x + 8 s in a second."""
    points, time = inside()
    later = lookups[0].velocity(points + [16, 0, 0], time + 2)
    np.testing.assert_allclose(later, lookups[0].velocity(points, time), atol=1e-10)
    np.testing.assert_allclose(lookups[0].velocity(points, time + 30), lookups[0].velocity(points, time), atol=1e-10)


def test_the_points_of_the_grid_and_its_edges(lookups):
    for lookup in lookups:
        y, z = (side.ravel() for side in np.meshgrid(GRID.y, GRID.z))
        points = np.column_stack([np.full(20, lookup.shift), y, z])
        for k in (0, 7, 39):
            decoded = lookup.field.speeds(lookup.field.plane[k]).reshape(20, 3)
            np.testing.assert_allclose(lookup.velocity(points, 0.25 * k), decoded, atol=1e-12)


def test_mean(lookups):
    assert lookups[0].mean(12, 85) == pytest.approx(SPEEDS[:, 1, 3, 0].mean(), abs=1e-3)
    between = SPEEDS[:, 2:4, 0:2, 0].mean()
    assert lookups[1].mean(-18, 100) == pytest.approx(between, abs=1e-3)


@pytest.mark.parametrize(
    ("which", "point", "time", "message"),
    [
        (0, (0, 25, 90), 0, "point 1 is at y = 25 m, and the field covers -24 to 24 m; use a larger field."),
        (0, (0, 0, 74), 0, "point 1 is at z = 74 m, and the field covers 75 to 105 m; use a larger field."),
        (0, (0, 0, 140), 0, "point 1 is at z = 140 m, and the field covers 75 to 105 m; use a larger field."),
        (0, (0, np.nan, 90), 0, "point 1 is at y = nan m, and the field covers -24 to 24 m; use a larger field."),
        (1, (0, 0, 90), 7, "point 0 is at time = 10 s, and the field covers 0 to 9.75 s; use a longer field."),
        (1, (32, 0, 90), 0, "point 1 is at time = -1 s, and the field covers 0 to 9.75 s; use a longer field."),
    ],
)
def test_a_field_that_is_too_small(lookups, which, point, time, message):
    lookup = lookups[which]
    with pytest.raises(ModelError, match=re.escape(f"{lookup.field.path}: the wind field is too small: {message}")):
        lookup.velocity([(0, 0, 90), point], time)


def test_beyond_the_edge_an_iteration_finds_the_value_of_the_edge(lookups):
    velocity, rate = lookups[0].evaluate([(0, 40, 90), (0, 24, 90)], 1.0)
    np.testing.assert_allclose(velocity[0], velocity[1])
    assert not rate[0, :, 1].any()
    assert rate[0, :, 2].any()


def test_a_plane_of_one_column(tmp_path):
    field = write_field(tmp_path / "a.bts", replace(GRID, columns=1), SPEEDS[:, :, :1])
    with pytest.raises(ModelError, match="1 x 4 points cannot be interpolated; a wind field needs 2 columns and 2"):
        FieldLookup(field)


def test_a_position_that_is_no_number_gives_none(lookups):
    velocity, _ = lookups[0].evaluate([(np.nan, 0, 90), (0, 0, 90)], 1.0)
    assert np.isnan(velocity[0]).all()
    assert np.isfinite(velocity[1]).all()
