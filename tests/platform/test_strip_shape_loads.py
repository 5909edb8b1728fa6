"""Loads of the waves on the shapes of a column by strips: its closed form, and the panel method in long waves."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.environment.sea import RegularWaves
from fowtlib.components.environment.waves import wave_number
from fowtlib.components.mechanics import FreeMotion
from fowtlib.components.platform import Ballast, CircularMember, ElasticFloater, Floater, modal_database
from fowtlib.components.platform.shape_numbers import shapes_in_use

RHO, G, DEPTH = 1025.0, 9.80665, 150.0
DIAMETER, DRAFT, SHAPES, C_A = 4.0, 60.0, 4, 1.0  # m, m; the first two bendings, each in both planes


def column(kind, **settings):
    floater = kind(**settings)
    floater.column = CircularMember(
        start=(0, 0, -DRAFT), end=(0, 0, 10), diameters=DIAMETER, wall_thickness=0.05, added_mass_coefficient=C_A,
        sections=60,
    )  # fmt: skip
    floater.column.ballast = Ballast(density=2500.0, level=-50.0)
    return floater


@pytest.fixture(scope="module")
def hull():
    model = fw.Assembly("column")
    model.world, model.motion = World(water_depth=DEPTH, water_density=RHO, gravity=G), FreeMotion()
    model.hull = column(ElasticFloater, shapes=SHAPES, longest=4.0)
    model.sea = RegularWaves(wave_height=1.0, wave_period=8.0)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.hull.frame)
    fw.load(model)
    return model.hull


@pytest.mark.parametrize("heading", [0.0, 0.6])
def test_the_load_is_the_integral_of_shape_and_acceleration(hull, heading):
    """By strips as rho A (1 + C_a) int phi . a dz, a = i omega^2 cosh k (z + h) / sinh k h along the waves: 0.2 %.

    J.R. Morison et al. (1950), waves of Airy. 60 strips of one metre against 6000 of a centimetre.
    """
    omega = np.array([0.3, 0.6, 0.9, 1.2])
    found = hull.member_loads.wave_transfer(omega, heading)[:, 6:]
    z = -DRAFT + (np.arange(6000) + 0.5) / 100
    axis = np.column_stack([0 * z, 0 * z, z])
    shapes = hull.member_frame().field(axis, shapes_in_use(hull).shapes).displacement
    along = shapes[:, :, 0] * math.cos(heading) + shapes[:, :, 1] * math.sin(heading)
    k = wave_number(omega, DEPTH, G)[:, None]
    acceleration = 1j * omega[:, None] ** 2 * np.cosh(k * (z + DEPTH)) / np.sinh(k * DEPTH)
    wanted = RHO * math.pi / 4 * DIAMETER**2 * (1 + C_A) * acceleration @ along.T / 100
    assert np.abs(wanted).max(axis=0).min() > 5e3  # N per m: every shape is loaded
    np.testing.assert_allclose(found, wanted, rtol=2e-3, atol=2e-3 * np.abs(wanted).max())


def test_the_panel_method_has_the_same_load_in_long_waves(hull):
    """Waves 60 to 170 diameters long, panels of 1.5 m: 4 % and 1 deg of every shape.

    What is left is the water at the foot and at the level, which strips do not know: a rigid column has 1.5 to 2 % more
    load in surge by panels as well.
    """
    pytest.importorskip("capytaine")
    omega = np.array([0.3, 0.5])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        data = modal_database(
            column(Floater), SHAPES, omega=omega, headings=[0.6], panel=1.5, water_depth=DEPTH, longest=4.0,
            rho=RHO, g=G,
        )  # fmt: skip
    np.testing.assert_allclose(data.shapes, shapes_in_use(hull).shapes, atol=1e-6)
    ratio = hull.member_loads.wave_transfer(omega, 0.6)[:, 6:] / data.X[:, 0, 6:]
    np.testing.assert_allclose(np.abs(ratio), 1.0, atol=0.04)
    assert np.degrees(np.abs(np.angle(ratio))).max() < 1.0
