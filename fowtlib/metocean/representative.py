"""Few states that stand for all: one sea of each wind speed, and bins by the density at their centres."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.binning import centres
from fowtlib.metocean.joint import VARIABLES, ConditionalModel
from fowtlib.metocean.states import States


def likely_states(joint: ConditionalModel, wind_speeds: ArrayLike) -> States:
    """The most probable sea of each wind speed [m/s], with the probability of the speed among these.

    Wave height: mode of its law given the wind; peak period: mode of its law given both. The probabilities go with the
    density of the wind, and have the sum 1. This is how J. M. Hegseth, E. E. Bachynski and J. R. R. A. Martins choose
    fatigue states: `likely_states(site("northern_north_sea").at(119), range(1, 31))` in Marine Structures 72 (2020)
    102771, with `range(1, 30, 2)` in their study of controllers (J. Phys. Conf. Ser., 2020).
    """
    speeds = np.atleast_1d(np.asarray(wind_speeds, dtype=float))
    if speeds.ndim != 1 or not speeds.size or not (np.diff(speeds) > 0).all():
        raise ParameterError("wind speeds are one or more rising numbers in m/s.")
    heights = joint.wave_height(speeds).mode()
    periods = joint.peak_period(speeds, heights).mode()
    density = joint.wind_speed.pdf(speeds)
    return States(speeds, heights, periods, density / density.sum())


def centre_bins(
    joint: ConditionalModel,
    wind_speeds: ArrayLike,
    wave_heights: ArrayLike,
    peak_periods: ArrayLike,
    *,
    least: float = 1e-4,
    jacobian: bool = True,
) -> States:
    """The states at the centres of bins, as probable as the density there times the widths, to the sum 1.

    The three lists are the centres, equally spaced. Those of a probability of `least` or less are left out. `bins`
    integrates the density instead. jacobian: False takes the density of the wind at the reference height and the width
    of its bin at `height`, as the 546 states of J. M. Hegseth, E. E. Bachynski, Marine Structures 64 (2019) 186 are.
    """
    lists = zip((wind_speeds, wave_heights, peak_periods), VARIABLES, strict=True)
    (u, du), (h, dh), (t, dt) = (centres(values, name) for values, name in lists)
    wind, height, period = np.meshgrid(u, h, t, indexing="ij")
    inside = joint.reaches(wind, height)
    probability = np.zeros(wind.shape)
    probability[inside] = joint.pdf(wind[inside], height[inside], period[inside]) * du * dh * dt
    kept = probability * (1.0 if jacobian else joint.wind_factor) > least
    if not kept.any():
        raise ParameterError(f"no bin has a probability above {least:g}.", where=joint.name)
    share = probability[kept]
    return States(wind[kept], height[kept], period[kept], share / share.sum())
