"""Equilibria with freed parameters: pretension, ballast and draft, stiffness and deflection; and mistakes."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.hydro import Hydrostatics
from fowtlib.components.mechanics import (
    Fixed,
    FixedTranslation,
    FreeMotion,
    Prismatic,
    RigidBody,
    SpringDamper,
    World,
    WorldForce,
)
from fowtlib.components.mooring import CatenaryLine, MooringSystem, Tendon
from fowtlib.components.mooring.catenary import Line, fairlead_tension
from fowtlib.language import Assembly
from fowtlib.language.errors import NotFoundError, ParameterError, SimulationError

WATER = 1025 * 9.80665


def held_line(**line):
    """A line between two fixed points."""
    model = Assembly("a line")
    model.world = World(water_depth=200)
    model.left, model.right = Fixed(r=(0, 0, -200)), Fixed(r=(480, 0, -20))
    model.line = CatenaryLine(**{"length": 520, "axial_stiffness": 5e8, "weight_per_length": 900, **line})
    model.connect(model.left.frame, model.line.anchor)
    model.connect(model.right.frame, model.line.fairlead)
    return fw.load(model).compile()


@pytest.mark.parametrize("tension", [2.2e5, 4e5, 3e6])
def test_length_from_pretension_and_back(tension):
    plant = held_line()
    state = plant.equilibrium(free=["line.length"], targets={"line.tension": f"{tension / 1e3} kN"})
    length = state.parameters["line.length"]
    assert np.hypot(*fairlead_tension(480, 180, Line(length, 900, 5e8))) == pytest.approx(tension, rel=1e-6)
    assert plant.equilibrium({"line.length": length})["line.tension"] == pytest.approx(tension, rel=1e-9)
    back = plant.equilibrium(free={"line.length": "510 m"}, targets={"line.tension": tension})
    assert back.parameters["line.length"] == pytest.approx(length, rel=1e-9)


def floating(mass=4e6):
    """A vertical buoy of 100 m^2 waterplane that displaces 5000 m^3, on one upright tendon from its keel."""
    model = Assembly("a buoy on a tendon")
    model.world = World(water_depth=200)
    model.motion = FreeMotion()
    model.body = RigidBody(mass=mass, inertia=np.eye(3) * 1e9, r_cm=(0, 0, -40))
    stiffness = np.zeros((6, 6))
    stiffness[2, 2] = 100 * WATER
    model.water = Hydrostatics(volume=5000, centre_of_buoyancy=(0, 0, -25), stiffness=stiffness)
    model.keel = FixedTranslation(r=(0, 0, -50))
    model.tendon = Tendon(length=150, pretension=5e6, axial_stiffness=1.5e9, weight_per_length=500,
                          anchor_position=(0, 0, -200))  # fmt: skip
    model.connect(model.world.frame, model.motion.frame_a)
    for frame in (model.body.frame_a, model.water.frame, model.keel.frame_a):
        model.connect(model.motion.frame_b, frame)
    model.connect(model.keel.frame_b, model.tendon.fairlead)
    return model


@pytest.fixture(scope="module")
def buoy():
    return fw.load(floating()).compile()


@pytest.mark.parametrize(("heave", "mass"), [(0.0, 4e6), (-0.3, 4e6), (0.0, 4.8e6)])
def test_pretension_of_a_tendon_from_the_draft(buoy, heave, mass):
    """What buoyancy lifts more than the body weighs, by either description of the tendon."""
    lift = (5000 - 100 * heave) * WATER - mass * 9.80665
    for freed in ("tendon.length", "tendon.pretension"):
        state = buoy.equilibrium({"body.mass": mass}, free=[freed], targets={"motion.heave": heave})
        assert state["tendon.tension"] == pytest.approx(lift, rel=1e-6)
        assert state["motion.heave"] == pytest.approx(heave, abs=1e-9)
    if heave == 0:
        assert state.parameters["tendon.pretension"] == pytest.approx(lift, rel=1e-4)  # w of length and unstretched


@pytest.mark.parametrize(("heave", "tension"), [(0.0, 3e6), (-0.2, 8e6)])
def test_ballast_and_length_from_draft_and_tension(buoy, heave, tension):
    """Two parameters and two conditions, one with a unit of its own."""
    state = buoy.equilibrium(
        free={"body.mass": "3000 t", "tendon.length": None},
        targets={"motion.heave": f"{100 * heave} cm", "tendon.tension": tension},
    )
    mass = ((5000 - 100 * heave) * WATER - tension) / 9.80665
    assert state.parameters["body.mass"] == pytest.approx(mass, rel=1e-9)
    assert state["tendon.tension"] == pytest.approx(tension, rel=1e-9)
    again = buoy.equilibrium(state.parameters)
    assert again["motion.heave"] == pytest.approx(heave, abs=1e-9)


def test_a_run_may_start_there(buoy):
    state = buoy.equilibrium(free=["tendon.length"], targets={"motion.heave": -0.3})
    result = buoy.simulate(1.0, 0.1, start=state, outputs=["motion.heave"])
    assert result["motion.heave"].to_numpy() == pytest.approx(-0.3, abs=1e-6)


def test_a_draft_that_leaves_the_tendon_slack(buoy):
    with pytest.raises(SimulationError, match="heave = 0 m is found by freeing tendon.length|slack at rest"):
        buoy.equilibrium({"body.mass": 5.3e6}, free=["tendon.length"], targets={"motion.heave": 0.0})


def hanging(stiffness=2e3):
    model = Assembly("a weight on a spring")
    model.world = World()
    model.hold, model.slide = Fixed(r=(0, 0, 10)), Prismatic(n=(0, 0, -1), s_start=1.0)
    model.body, model.spring = RigidBody(mass=100.0, inertia=np.eye(3)), SpringDamper(stiffness=stiffness)
    model.connect(model.hold.frame, model.slide.frame_a)
    model.connect(model.hold.frame, model.spring.frame_a)
    for frame in (model.body.frame_a, model.spring.frame_b):
        model.connect(model.slide.frame_b, frame)
    return fw.load(model).compile()


@pytest.mark.parametrize("deflection", [0.01, 0.5, 30.0])
@pytest.mark.parametrize("stiffness", [2e3, 1.0])
def test_a_stiffness_from_the_deflection(stiffness, deflection):
    plant = hanging(stiffness)
    state = plant.equilibrium(free=["spring.stiffness"], targets={"slide.s": deflection})
    assert state.parameters["spring.stiffness"] == pytest.approx(980.665 / deflection, rel=1e-9)
    state = plant.equilibrium({"spring.stiffness": 980.665}, free={"body.mass": 3.0}, targets={"slide.s": deflection})
    assert state.parameters["body.mass"] == pytest.approx(100 * deflection, rel=1e-9)


def test_elements_of_an_array_of_parameters():
    """Two of three lines get their length from the place of the body."""
    model = Assembly("a body on three lines")
    model.world = World(water_depth=320)
    model.motion = FreeMotion()
    model.body = RigidBody(mass=7e6, r_cm=(0, 0, -70), inertia=np.diag([8e9, 8e9, 2e8]))
    model.lift, model.force = Constant(value=(0, 0, 7e6 * 9.80665 + 1.6e6)), WorldForce()
    model.mooring = MooringSystem(
        headings=np.radians([60, 180, 300]), fairlead_radius=5.2, fairlead_depth=70, anchor_radius=853.87,
        anchor_depth=320, length=[902.2] * 3, axial_stiffness=384.243e6, weight_per_length=698.1, yaw_stiffness=1e8,
    )  # fmt: skip
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.lift.y, model.force.force)
    for frame in (model.body.frame_a, model.force.frame, model.mooring.frame):
        model.connect(model.motion.frame_b, frame)
    plant = fw.load(model).compile()
    state = plant.equilibrium(free=["mooring.length[0]", "mooring.length[2]"],
                              targets={"motion.surge": 3.0, "motion.sway": 1.0})  # fmt: skip
    assert state["motion.surge"] == pytest.approx(3.0, abs=1e-9)
    lengths = state.parameters["mooring.length"]
    assert lengths[1] == 902.2 and lengths[0] < lengths[2] < 902.2
    again = plant.equilibrium({"mooring.length": lengths})
    assert [again["motion.surge"], again["motion.sway"]] == pytest.approx([3.0, 1.0], abs=1e-8)


@pytest.mark.parametrize(
    ("free", "targets", "error", "message"),
    [
        (["tendon.length"], {}, ParameterError, "1 parameter is freed .* and no conditions are given"),
        (["tendon.length"], {"motion.heave": 0, "tendon.tension": 1e6}, ParameterError, "2 conditions are given"),
        ([], {"motion.heave": 0}, ParameterError, r"no parameters are freed \(none\)"),
        (["keel.r"], {"motion.heave": 0}, ParameterError, r"3 parameters are freed \(keel.r\[0\], keel.r\[1\]"),
        (["keel.r[4]"], {"motion.heave": 0}, ParameterError, r"the elements of keel.r are keel.r\[0\] to keel.r\[2\]"),
        (["tendon.lenght"], {"motion.heave": 0}, ParameterError, "no tunable parameter 'tendon.lenght'; did you mean"),
        (["world.gravity"], {"motion.heave": 0}, ParameterError, "A structural or dependent parameter is changed in"),
        (["tendon.length"], {"motion.heve": 0}, NotFoundError, "no variable 'motion.heve'; did you mean"),
        (["tendon.length"], {"tendon.fairlead.f": 0}, ParameterError, "tendon.fairlead.f has 3: take"),
        (["tendon.length"], {"motion.heave": None}, ParameterError, "the condition on motion.heave has no value"),
        (["tendon.breaking_load"], {"motion.heave": 0}, ParameterError, "no tunable parameter 'tendon.breaking_load'"),
        (["world.air_density"], {"motion.heave": 0}, SimulationError, "does not change with world.air_density"),
        (["body.mass", "water.volume"], {"motion.heave": 0, "tendon.tension": 1e6}, SimulationError, "all alike"),
        (["tendon.length"], {"tendon.tension": -1e6}, SimulationError, r"-1e\+06 N is found by freeing tendon"),
    ],
)  # fmt: skip
def test_mistakes(buoy, free, targets, error, message):
    with pytest.raises(error, match=message):
        buoy.equilibrium(free=free, targets=targets)


@pytest.fixture(scope="module")
def turbine():
    """The OC3 spar in steady wind of 11.4 m/s, where its controller begins to pitch."""
    return fw.load("oc3_spar_rigid").in_the_mean().compile()


@pytest.mark.parametrize(
    ("free", "target"),
    [("wind.mean_speed", ("surge", 10)), ("world.air_density", ("surge", 8)), ("wind.mean_speed", ("thrust", 300))],
)
def test_a_wish_on_the_other_side_of_rated_wind(turbine, free, target):
    """Between here and there the controller changes its region; the values are found again by an equilibrium."""
    state = turbine.equilibrium(free=[free], targets=dict([target]))
    value = state.parameters[free]
    assert float(turbine.equilibrium({free: value})[target[0]]) == pytest.approx(target[1], rel=1e-5)
    assert abs(value / float(turbine.parameter_values()[free].item()) - 1) > 0.2


def test_what_no_direction_reaches_is_told_with_the_nearest(turbine):
    """A rotor that looks along x is not pushed aside by a wind from the side."""
    with pytest.raises(SimulationError, match=r"no equilibrium with sway = 1 m .* The search came to sway ="):
        turbine.equilibrium(free={"wind.direction": 0.05}, targets={"sway": 1.0})


def test_a_parameter_is_found_where_nothing_can_move():
    """Both ends of the tendon are held, so that an equilibrium has no unknown: the pretension is one of a formula."""
    model = Assembly("held tendon")
    model.world, model.top = World(water_depth=200.0), Fixed(r=(0, 0, -50))
    model.tendon = Tendon(length=150.0, axial_stiffness=1e9, pretension=1e6, weight_per_length=0.0,
                          anchor_position=(0, 0, -200))  # fmt: skip
    model.connect(model.top.frame, model.tendon.fairlead)
    plant = fw.load(model).compile()
    state = plant.equilibrium(free=["tendon.pretension"], targets={"tendon.tension": 5e6})
    assert state.parameters["tendon.pretension"] == pytest.approx(5e6, rel=1e-5)
    with pytest.raises(SimulationError, match="it does not change with"):
        plant.equilibrium(free=["tendon.slack_tension"], targets={"tendon.least_tension": 5e6})
