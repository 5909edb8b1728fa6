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


@pytest.fixture(scope="module")
def cubic(lookups):
    return tuple(FieldLookup(lookup.field, interpolation="cubic") for lookup in lookups)


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


def test_the_mean_over_a_disk(lookups):
    """Of u, over the points within the radius; at radius 0 it is that of the place."""
    for lookup in lookups:
        grid, start = lookup.grid, -lookup.shift / lookup.grid.speed
        times = start + grid.dt * np.arange(grid.steps)
        for y, z, radius in ((0.0, 90.0, 20.0), (5.0, 88.0, 13.0), (-3.0, 91.0, 0.0), (6.0, 80.0, 1.0)):
            points = [[0.0, a, b] for a in grid.y for b in grid.z if np.hypot(a - y, b - z) <= radius]
            points = points or [[0.0, y, z]]
            assert len(points) == {20.0: 12, 13.0: 4}.get(radius, 1)
            expected = [lookup.velocity(points, time)[:, 0].mean() for time in times]
            np.testing.assert_allclose(lookup.over_disk(y, z, radius), expected, atol=1e-11)


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_derivatives(lookups, interpolation):
    """Central differences in the cells."""
    points, time = inside()
    lookup, h = FieldLookup(lookups[0].field, interpolation=interpolation), 1e-5
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


def test_the_points_of_the_grid_and_its_edges(lookups, cubic):
    for lookup in (*lookups, *cubic):
        y, z = (side.ravel() for side in np.meshgrid(GRID.y, GRID.z))
        points = np.column_stack([np.full(20, lookup.shift), y, z])
        for k in (0, 7, 39):
            decoded = lookup.field.speeds(lookup.field.plane[k]).reshape(20, 3)
            np.testing.assert_allclose(lookup.velocity(points, 0.25 * k), decoded, atol=1e-12)


def polynomial(powers, time, z, y):
    """A sum of products of powers up to `powers` of time, z and y, in lengths of the order of the field."""
    s, u, v = time / 5 - 1, (np.asarray(z) - 90) / 15, np.asarray(y) / 24
    random = np.random.default_rng(7)
    return sum(
        random.uniform(-1, 1, 3) * (s**i * u**j * v**k)[..., None]
        for i in range(powers + 1) for j in range(powers + 1) for k in range(powers + 1)
    )  # fmt: skip


@pytest.mark.parametrize(("interpolation", "powers"), [("linear", 0), ("linear", 1), ("cubic", 1), ("cubic", 2)])
def test_polynomials_are_reproduced(tmp_path, interpolation, powers):
    """Keys (1981): cubic convolution is exact for second powers, also in the cells at the edges; linear for first ones.

    What is left is the rounding to int16, of the values and, by 1/dt = 4 per second, of the slopes.
    """
    grid = replace(GRID, periodic=False)
    values = polynomial(powers, *np.meshgrid(np.arange(40) * 0.25, grid.z, grid.y, indexing="ij"))
    lookup = FieldLookup(write_field(tmp_path / "a.bts", grid, values), interpolation=interpolation)
    random = np.random.default_rng(8)
    time, z, y = random.uniform(0, 9.75, 500), random.uniform(75, 105, 500), random.uniform(-24, 24, 500)
    points, step = np.column_stack([np.full(500, lookup.shift), y, z]), np.ptp(values) / 65535
    velocity, rate = lookup.evaluate(points, time)
    np.testing.assert_allclose(velocity, polynomial(powers, time, z, y), atol=2 * step)
    h = 1e-4
    slopes = [
        (polynomial(powers, *(place + h * way)) - polynomial(powers, *(place - h * way))) / (2 * h)
        for way in np.eye(3)[..., None] for place in [np.stack([time, z, y])]
    ]  # fmt: skip
    for axis, slope in zip((3, 2, 1), slopes, strict=True):
        np.testing.assert_allclose(rate[..., axis], slope, atol=16 * step)


def test_slopes_at_the_borders_of_cells(lookups, cubic):
    """From one cell to the next the slope jumps with linear interpolation, and not with cubic."""
    places = np.array([[0.0, 0.0, 90.0, 1.0], [0.0, 12.0, 95.0, 1.1], [0.0, 5.0, 85.0, 2.3], [0.0, 7.0, 91.0, 0.0]])
    for lookup, jumps in ((lookups[0], True), (cubic[0], False)):
        for axis, place in zip((1, 1, 2, 3), places, strict=True):
            aside = 1e-9 * np.eye(4)[axis]
            ends = [lookup.evaluate([at[:3]], at[3]) for at in (place - aside, place + aside)]
            np.testing.assert_allclose(ends[0][0], ends[1][0], atol=1e-7)
            assert (np.abs(ends[0][1][0, :, axis] - ends[1][1][0, :, axis]).max() > 1e-3) == jumps


def test_what_interpolation_leaves_of_the_variance(tmp_path):
    """Of white noise, midway between the samples of one direction, linear leaves 1/2, Keys 2 (9^2 + 1)/16^2 = 0.641."""
    grid = replace(GRID, rows=20, columns=20, steps=400)
    noise = write_field(tmp_path / "a.bts", grid, np.random.default_rng(9).normal(size=(400, 20, 20, 3)))
    y, z = (side.ravel() for side in np.meshgrid(grid.y, grid.z))
    points = np.column_stack([np.zeros(400), y, z])
    for interpolation, share in (("linear", 0.5), ("cubic", 164 / 256)):
        lookup = FieldLookup(noise, interpolation=interpolation)
        values = np.concatenate([lookup.velocity(points, 0.25 * k + 0.125) for k in range(100)])
        assert values.var() == pytest.approx(share, rel=0.02)


def test_mean_of_a_cubic_field(cubic):
    """It is the mean of what is looked up at the time steps."""
    points = np.tile([0.0, 5.0, 83.0], (40, 1))
    assert cubic[0].mean(5.0, 83.0) == pytest.approx(cubic[0].velocity(points, np.arange(40) * 0.25)[:, 0].mean())


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


def test_beyond_the_edge_an_iteration_finds_the_value_of_the_edge(lookups, cubic):
    for lookup in (lookups[0], cubic[0]):
        velocity, rate = lookup.evaluate([(0, 40, 90), (0, 24, 90)], 1.0)
        np.testing.assert_allclose(velocity[0], velocity[1])
        assert not rate[0, :, 1].any()
        assert rate[0, :, 2].any()


def test_a_plane_of_one_column(tmp_path):
    field = write_field(tmp_path / "a.bts", replace(GRID, columns=1), SPEEDS[:, :, :1])
    with pytest.raises(ModelError, match="1 x 4 points cannot be interpolated; a wind field needs 2 columns and 2"):
        FieldLookup(field)


def test_too_few_points_for_cubic_interpolation(tmp_path):
    field = write_field(tmp_path / "a.bts", replace(GRID, columns=3), SPEEDS[:, :, :3])
    with pytest.raises(ModelError) as error:
        FieldLookup(field, interpolation="cubic")
    assert str(error.value) == (
        f"{field.path}: 3 x 4 points cannot be interpolated; a wind field needs 4 columns and 4 rows at least, or "
        "linear interpolation."
    )
    field = write_field(tmp_path / "b.bts", replace(GRID, steps=3), SPEEDS[:3])
    with pytest.raises(ModelError, match="3 time steps cannot be interpolated; a wind field needs 4 at least, or"):
        FieldLookup(field, interpolation="cubic")


def test_a_position_that_is_no_number_gives_none(lookups):
    velocity, _ = lookups[0].evaluate([(np.nan, 0, 90), (0, 0, 90)], 1.0)
    assert np.isnan(velocity[0]).all()
    assert np.isfinite(velocity[1]).all()


@pytest.mark.parametrize("columns", [5, 4])
def test_tower_points(tmp_path, columns):
    """Below the plane: linear between the middle of the lowest row and the tower points, whatever y is."""
    random, grid = np.random.default_rng(7), replace(GRID, tower_points=3, columns=columns)
    speeds = random.normal((8, 0, 0), (1, 0.8, 0.5), (40, 4, columns, 3))
    tower = random.normal((5, 0, 0), (1, 0.8, 0.5), (40, 3, 3))
    lookup = FieldLookup(write_field(tmp_path / "a.bts", grid, speeds, tower))
    middle = speeds[:, 0, 2] if columns == 5 else speeds[:, 0, 1:3].mean(axis=1)
    line = np.concatenate([middle[:, None], tower], axis=1)
    z, y, steps = random.uniform(45, 75, 50), random.uniform(-18, 18, 50), random.integers(0, 40, 50)
    points = np.column_stack([np.zeros(50), y, z])
    expected = [
        [np.interp(-h, [-75, -65, -55, -45], line[i, :, c]) for c in range(3)] for h, i in zip(z, steps, strict=True)
    ]
    np.testing.assert_allclose(lookup.velocity(points, steps * 0.25), expected, atol=2e-4)
    for kind in ("linear", "cubic"):
        smooth, times = FieldLookup(lookup.field, interpolation=kind), random.uniform(0, 10, 50)
        rate, h = smooth.evaluate(points, times)[1], 1e-5
        for k, move in enumerate(np.eye(3) * h):
            difference = smooth.evaluate(points + move, times)[0] - smooth.evaluate(points - move, times)[0]
            np.testing.assert_allclose(rate[..., k], difference / (2 * h), atol=1e-6)
        later, before = (smooth.evaluate(points, times + d)[0] for d in (h, -h))
        np.testing.assert_allclose(rate[..., 3], (later - before) / (2 * h), atol=1e-6)
    assert lookup.mean(10.0, 60.0) == pytest.approx((tower[:, 0, 0].mean() + tower[:, 1, 0].mean()) / 2, abs=1e-3)
    with pytest.raises(ModelError, match=r"point 0 is at z = 44 m, and the field covers 45 to 105 m"):
        lookup.velocity([[0, 0, 44.0]], 0.0)
