"""Wave loads on the shapes of a hull that turns: after any turn they are those of a hull built at this heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_loads import ModalWaveExcitation, TurningModalWaveExcitation
from fowtlib.components.mechanics import ElasticBody, Fixed

FILE = Path(__file__).parents[2] / "models" / "data" / "wind_tracing" / "shapes.nc"
REGULAR = {"spectrum": "regular", "wave_height": 2.0, "wave_period": 9.0}
SHAPES = 3


@pytest.fixture(scope="module")
def database():
    return ModalDatabase.read(FILE).first(SHAPES)


def loads(part, heading, yaw=0.0):
    """Force, moment and load on the shapes over time, of a hull that is held at a yaw; world axes."""
    model = fw.Assembly("a hull that is held in waves")
    model.world, model.sea = World(water_depth=200), Sea(heading=heading, **REGULAR)
    model.held, model.part = Fixed(angles=(0, 0, yaw)), part
    model.shapes = ElasticBody(shapes=SHAPES, mass=1e12 * np.eye(SHAPES), stiffness=1e12 * np.eye(SHAPES))
    model.connect(model.held.frame, model.part.frame)
    model.connect(model.shapes.modes, model.part.modes)
    result = fw.load(model).compile().simulate(20.0, output_step=0.5)
    return [np.asarray(result[f"part.{name}"]) for name in ("force", "moment", "on_shapes")]


@pytest.mark.parametrize("yaw", [np.pi / 2, -2.3])
def test_load_on_shapes_at_a_yaw_is_that_of_a_hull_built_at_this_heading(database, yaw):
    heading = 0.5
    kept = {"shapes": SHAPES, "database": database}
    found = loads(TurningModalWaveExcitation(harmonics=80, **kept), heading, yaw)
    built = loads(ModalWaveExcitation(**kept), heading - yaw)
    c, s = np.cos(yaw), np.sin(yaw)
    turned = [one @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) for one in built[:2]]
    for one, expected in zip(found, [*turned, built[2]], strict=True):
        np.testing.assert_allclose(one, expected, atol=2e-3 * np.abs(expected).max())
    assert np.abs(built[2]).max() > 1e6  # the waves bend it
