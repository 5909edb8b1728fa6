"""Current: its profile in the drag of members and hulls, and what a model without one keeps."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Current
from fowtlib.components.hydro import MorisonDrag, SlenderHullLoads
from fowtlib.components.mechanics import Fixed, Prismatic, RigidBody, World
from fowtlib.components.platform import CircularMember, Floater
from fowtlib.language import Assembly

DEPTH, DRAFT, D, CD, RHO = 100.0, 60.0, 8.0, 0.9, 1025.0


def morison():
    return MorisonDrag(points=[(0, 0, -DRAFT), (0, 0, 0)], diameters=[D, D], drag_coefficient=CD, slices=8)


def hull():
    return SlenderHullLoads(heights=[-DRAFT, 10], diameters=[D, D], drag_coefficient=CD, strips=8)


def held(load, current=None):
    model = Assembly("a column in a current")
    model.world = World(water_depth=DEPTH)
    if current is not None:
        model.sea_current = current
    model.ground = Fixed()
    model.load = load
    model.connect(model.ground.frame, model.load.frame)
    return fw.load(model).compile()


def integral(speed, exponent):
    """1/2 rho C_d D of the square of the profile over the draft, and its moment about the water level, by hand."""
    p = 2 * exponent
    low = 1 - DRAFT / DEPTH
    scale = RHO / 2 * CD * D * speed**2
    force = scale * DEPTH * (1 - low ** (p + 1)) / (p + 1)
    moment = scale * DEPTH**2 * ((1 - low ** (p + 2)) / (p + 2) - (1 - low ** (p + 1)) / (p + 1))
    return force, moment


@pytest.mark.parametrize("load", [morison, hull])
@pytest.mark.parametrize("exponent", [0.0, 1 / 7])
def test_drag_of_a_column_is_the_integral_over_the_profile(load, exponent):
    speed, direction = 1.5, 0.7
    plant = held(load(), Current(speed=speed, direction=direction, exponent=exponent))
    state = plant.initial_state()
    force, moment = integral(speed, exponent)
    along = np.array([np.cos(direction), np.sin(direction), 0])
    assert np.ravel(state["load.force"])[:2] == pytest.approx(force * along[:2], rel=1e-4)
    found = np.ravel(state["load.moment"])
    assert found[:2] == pytest.approx(moment * np.array([-along[1], along[0]]), rel=1e-4)
    other = plant.initial_state({"sea_current.speed": 0.75, "sea_current.direction": 0.0})
    assert np.ravel(other["load.force"])[0] == pytest.approx(force / 4, rel=1e-3)


def test_members_of_a_floater_feel_it():
    floater = Floater(held_upright=True)
    floater.column = CircularMember(start=(0, 0, -DRAFT), end=(0, 0, 10), diameters=D, wall_thickness=0.05,
                                    drag_coefficient=CD, sections=8)  # fmt: skip
    model = Assembly("a floater in a current")
    model.world = World(water_depth=DEPTH)
    model.sea_current = Current(speed=1.5, exponent=1 / 7)
    model.ground = Fixed()
    model.floater = floater
    model.connect(model.ground.frame, model.floater.frame)
    state = fw.load(model).compile().initial_state()
    assert np.ravel(state["floater.column.force"])[0] == pytest.approx(integral(1.5, 1 / 7)[0], rel=1e-3)


def test_without_a_current_a_model_has_no_terms_of_it():
    plain, still = held(morison()), held(morison(), Current())
    assert not [path for path in plain.dae.parameters if "current" in path]
    state = still.initial_state()
    assert np.max(np.abs(np.ravel(state["load.force"]))) == 0


def test_a_free_column_takes_the_speed_of_the_water():
    """A body that gives way takes the speed of the water."""
    model = Assembly("a column that gives way")
    model.world = World(water_depth=DEPTH)
    model.sea_current = Current(speed=1.0)
    model.ground, model.slide = Fixed(), Prismatic(n=(1, 0, 0))
    model.body = RigidBody(mass=3e6, inertia=np.diag([1e9, 1e9, 1e9]))
    model.load = morison()
    model.connect(model.ground.frame, model.slide.frame_a)
    model.connect(model.slide.frame_b, model.body.frame_a)
    model.connect(model.slide.frame_b, model.load.frame)
    plant = fw.load(model).compile()
    result = plant.simulate(400.0, output_step=1.0)
    expected = 1.0 - 1 / (1 + RHO / 2 * CD * D * DRAFT / 3e6 * 400.0)  # v' = k (1 - v)^2
    assert float(np.asarray(result["slide.v"])[-1]) == pytest.approx(expected, rel=1e-4)
