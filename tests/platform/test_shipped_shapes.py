"""Databases of shapes that come with the models: their stiffness by still water is that of the law of now."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.hydro.deformation import shape_stiffness


@pytest.mark.parametrize(("model", "size"), [("tlp_elastic", 4.0), ("oo_star_dtu10mw", 8.0), ("wind_tracing", 12.0)])
def test_shipped_stiffness_is_that_of_the_law_of_now(model, size):
    """From wider panels than the file's: 1.8, 2.9, 0.5 % of the largest; by the former law 1.7 to 45 times."""
    hull = fw.load(model).root.find("platform.hull")
    structure, stored = hull.member_frame(), hull.database
    found = shape_stiffness(hull.hull().panels(size), lambda points: structure.field(points, stored.shapes)).among
    among = stored.rho * stored.g * (found + found.T) / 2
    assert np.abs(stored.among - among).max() < 0.05 * np.abs(stored.among).max()
