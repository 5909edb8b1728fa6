"""What the blades of a turning rotor meet in a field, as the few winds of its disc over time. Plain numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.wind_file import WindSeries
from fowtlib.language.run_time import TurningRings

if TYPE_CHECKING:
    from scipy.interpolate import RegularGridInterpolator

STEP = 0.1  # s between two samples, about
AT_ONCE = 20_000  # points of one look-up


def disc_of_field(lookup: FieldLookup, disc: TurningRings) -> WindSeries:
    """The channels of a disc in the fluctuation of u of a field, which is u less its mean in time at each place.

    With the angles psi of the blades from y, in the sense of turning: the mean over the blades, 2/B sum u cos(psi) and
    2/B sum u sin(psi), weighted as the disc says. The first blade is at psi = 0 at t = 0; in a periodic field the
    rotor speed is that near the disc's own which is back in place after a period. ParameterError where the field does
    not cover the disc.
    """
    grid, (uniform, once) = lookup.grid, disc.weights
    count = max(4, round(grid.duration / STEP))
    step = grid.duration / (count if grid.periodic else count - 1)
    start = -lookup.shift / grid.speed
    speed, sense = abs(disc.speed), np.sign(disc.speed) or 1.0
    if grid.periodic:
        passing = 2 * np.pi / (disc.blades * grid.duration)
        speed = passing * round(speed / passing)
    mean = _mean_of(lookup)
    found, chunk = [], max(1, AT_ONCE // (disc.blades * len(disc.radii)))
    for first in range(0, count, chunk):
        time = start + step * np.arange(first, min(first + chunk, count))
        psi = speed * time[:, None] + 2 * np.pi * np.arange(disc.blades) / disc.blades
        y, z = np.cos(psi), sense * np.sin(psi)
        across = disc.centre[1:] + np.stack([y, z], axis=-1)[:, :, None] * disc.radii[:, None]
        points = np.concatenate([np.zeros((*across.shape[:-1], 1)), across], axis=-1).reshape(-1, 3)
        u = lookup.velocity(points, np.repeat(time, across[0, ..., 0].size))[:, 0] - mean(points[:, 2:0:-1])
        u = u.reshape(across.shape[:-1])
        alike, round_y, round_z = (np.einsum("tbr,tb->tr", u, part) / disc.blades
                                   for part in (np.ones_like(psi), 2 * np.cos(psi), 2 * np.sin(psi)))  # fmt: skip
        found.append(np.hstack([alike @ uniform.T, round_y @ once.T, round_z @ once.T]))
    return WindSeries(start, step, np.concatenate(found), periodic=grid.periodic)


def _mean_of(lookup: FieldLookup) -> RegularGridInterpolator:
    """Mean of u [m/s] over time, of (z, y) in the plane."""
    from scipy.interpolate import RegularGridInterpolator

    grid = lookup.grid
    total = sum(block[:, : grid.rows * grid.columns, 0].sum(axis=0, dtype=float) for _, block in lookup.field.blocks())
    mean = (total / grid.steps - grid.offset[0]) / grid.slope[0]
    places = lookup.covers["z"][0] + grid.dz * np.arange(grid.rows), grid.y
    return RegularGridInterpolator(places, mean.reshape(grid.rows, grid.columns), bounds_error=False, fill_value=None)
