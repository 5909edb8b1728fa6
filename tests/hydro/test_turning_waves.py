"""Wave loads on a hull that turns: after any turn they are those of a hull that was built at this heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import HydrodynamicDatabase, LinearPotentialFlow, TurningWaveExcitation, WaveExcitation
from fowtlib.components.mechanics import Fixed, FreeMotion, RigidBody
from fowtlib.components.platform import CircularMember, Floater
from fowtlib.language.errors import ParameterError

OC4 = str(Path(__file__).parents[2] / "models" / "data" / "oc4_semi" / "hydrodynamics.nc")
DATA = HydrodynamicDatabase.read(OC4)
IRREGULAR = {"spectrum": "jonswap", "significant_wave_height": 4.0, "peak_period": 10.0, "seed": 3}
REGULAR = {"spectrum": "regular", "wave_height": 2.0, "wave_period": 9.0}


def about_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def loads(part, sea, heading, yaw=0.0, place=(0.0, 0.0, 0.0)):
    """Force and moment over time on a hull that is held at a place with a yaw, world axes."""
    model = fw.Assembly("a hull that is held in waves")
    model.world, model.sea = World(water_depth=200), Sea(heading=heading, **sea)
    model.held, model.part = Fixed(r=place, angles=(0, 0, yaw)), part
    model.connect(model.held.frame, model.part.frame)
    result = fw.load(model).compile().simulate(20.0, output_step=0.5)
    return np.asarray(result["part.force"]), np.asarray(result["part.moment"])


@pytest.mark.parametrize(
    ("sea", "yaw"), [(IRREGULAR, np.pi / 2), (REGULAR, -0.7), (REGULAR, 4.0)], ids=["irregular", "right", "behind"]
)
def test_load_at_a_yaw_is_that_of_a_hull_built_at_this_heading(sea, yaw):
    """Built: the old part, in waves that come from the relative heading, its load turned into the world."""
    heading = 0.5
    force, moment = loads(TurningWaveExcitation(database=OC4, harmonics=30), sea, heading, yaw)
    built = loads(WaveExcitation(database=OC4), sea, heading - yaw)
    for found, expected in zip((force, moment), built, strict=True):
        np.testing.assert_allclose(found, expected @ about_z(yaw).T, atol=2e-3 * np.abs(expected).max())


def test_pivot_holds_the_phase_of_the_waves():
    """A hull that turned about a point 60 m before its middle, against one that was built where this took it."""
    yaw, heading, pivot = 1.1, 0.3, np.array([-60.0, 10.0, 0.0])
    place = pivot - about_z(yaw) @ pivot
    turning = TurningWaveExcitation(database=OC4, harmonics=60, pivot=tuple(pivot))
    force, _ = loads(turning, IRREGULAR, heading, yaw, tuple(place))
    away = tuple(about_z(-yaw) @ place)  # the same place, seen along the axes of the hull
    built, _ = loads(WaveExcitation(database=OC4, position=away), IRREGULAR, heading - yaw)
    np.testing.assert_allclose(force, built @ about_z(yaw).T, atol=2e-3 * np.abs(built).max())


@pytest.mark.parametrize(("heading", "built_turning"), [(0.0, False), (0.4, True)])
def test_motion_of_a_turned_hull_is_the_motion_of_one_built_at_this_heading(heading, built_turning):
    """Against the old part where the waves do not yaw the hull; where they do, it knows nothing of this yaw."""

    def motion(yaw, heading, turning):
        model = fw.Assembly("a floater in waves")
        model.world, model.sea = World(water_depth=200), Sea(heading=heading, **REGULAR)
        model.motion = FreeMotion(yaw_start=yaw)
        model.body = RigidBody(mass=1025 * DATA.volume, r_cm=(0, 0, -13), inertia=np.diag([1.1e10, 1.1e10, 1.2e10]))
        model.water = LinearPotentialFlow(database=OC4, turning=turning)
        model.connect(model.world.frame, model.motion.frame_a)
        model.connect(model.motion.frame_b, model.body.frame_a)
        model.connect(model.motion.frame_b, model.water.frame)
        result = fw.load(model).compile().simulate(40.0, output_step=0.5)
        names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
        return np.array([result[f"motion.{name}"] for name in names]).reshape(6, -1)

    turned, built = motion(np.pi / 2, heading + np.pi / 2, True), motion(0.0, heading, built_turning)
    expected = np.stack([-built[1], *built[[0, 2, 3, 4]], built[5] + np.pi / 2])
    size = np.abs(built).max(axis=1)
    np.testing.assert_allclose(turned, expected, atol=2e-3 * max(size[:3]))
    np.testing.assert_allclose(turned[3:], expected[3:], atol=2e-3 * max(size[3:]))


def test_harmonics_that_are_too_few_are_refused():
    with pytest.raises(ParameterError, match=r"harmonics is 1, too few .* take \d+"):
        loads(TurningWaveExcitation(database=OC4, harmonics=1), IRREGULAR, 0.0)


def test_turning_without_a_database_is_refused():
    model = fw.Assembly("a floater without potential flow")
    model.world, model.motion = World(water_depth=200), FreeMotion()
    model.hull = Floater(turning=True, held_upright=True)
    model.hull.column = CircularMember(start=(0, 0, -30), end=(0, 0, 5), diameters=9.0, wall_thickness=0.05)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.hull.frame)
    with pytest.raises(ParameterError, match="turning is given and would do nothing"):
        fw.load(model).compile()


def test_turning_without_waves_is_refused():
    model = fw.Assembly("a hull without waves")
    model.world, model.motion = World(water_depth=200), FreeMotion()
    model.water = LinearPotentialFlow(database=OC4, turning=True, excitation=False)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.water.frame)
    with pytest.raises(ParameterError, match="no wave load that could know of a turn"):
        fw.load(model).compile()
