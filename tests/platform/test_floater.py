"""Floaters in models: loads against sums by hand, independence of order, direction and frame, and mistakes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import Sea, World
from fowtlib.components.environment.waves import wave_number
from fowtlib.components.hydro import HydrodynamicDatabase, MorisonDrag, waterplane_stiffness
from fowtlib.components.mechanics import Fixed, FreeMotion, PointMass, WorldForce
from fowtlib.components.platform import Ballast, Bulkhead, CircularMember, Floater, RectangularMember
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.modelfile import dump

RHO, G = 1025.0, 9.80665
COLUMN = {"start": (0, 0, -20), "end": (0, 0, 10), "diameters": 10.0, "wall_thickness": 0.05}
PONTOON = {"start": (0, 0, -17), "end": (20, 0, -17), "widths": 3.0, "heights": 2.0, "wall_thickness": 0.02}


def model(floater, sea=None, **motion):
    """A free floater in the water."""
    whole = fw.Assembly("floater in water")
    whole.world = World(water_depth=200.0, water_density=RHO)
    whole.sea = sea or Sea()
    whole.motion = FreeMotion(**motion)
    whole.floater = floater
    whole.connect(whole.world.frame, whole.motion.frame_a)
    whole.connect(whole.motion.frame_b, floater.frame)
    return whole


def hull(*members, **given):
    floater = Floater(held_upright=True, **given)
    for k, member in enumerate(members):
        floater.add(f"member_{k}", member)
    return floater


def loads(state, name):
    return np.ravel(state[f"floater.{name}.force"]), np.ravel(state[f"floater.{name}.moment"])


# --- drag by hand ----------------------------------------------------------------------------------------------------


def test_drag_of_a_column_and_a_pontoon_is_the_sum_by_hand():
    """Still water, the body moves with (2, 1, 0.5) m/s. The pontoon counts from the wall of the column at x = 5 m."""
    column = CircularMember(**COLUMN, drag_coefficient=0.6, end_drag=(4.8, 0.0))
    pontoon = RectangularMember(**PONTOON, drag_coefficient=(1.5, 2.5), end_drag=(0.0, 1.1))
    v = np.array([2.0, 1.0, 0.5])
    state = fw.load(model(hull(column, pontoon), velocity_start=v)).compile().initial_state()

    across = math.hypot(2, 1)
    force, moment = loads(state, "member_0")
    wanted = RHO / 2 * np.array([*(-0.6 * 10 * 20 * across * v[:2]), -4.8 * math.pi * 25 * 0.5 * 0.5])
    assert force == pytest.approx(wanted, rel=1e-3)  # the bottom less the pontoon is a polygon's
    assert moment == pytest.approx([10 * wanted[1], -10 * wanted[0], 0], rel=1e-3, abs=1e-6 * abs(wanted[0]))

    across = math.hypot(1, 0.5)  # across the pontoon: sideways on its height of 2 m, upwards on its width of 3 m
    force, moment = loads(state, "member_1")
    wanted = -RHO / 2 * np.array([1.1 * 6 * 2 * 2, 1.5 * 2 * 15 * across * 1, 2.5 * 3 * 15 * across * 0.5])
    assert force == pytest.approx(wanted, rel=1e-6)
    end = -RHO / 2 * 1.1 * 6 * 4
    side, lift = wanted[1:]
    assert moment == pytest.approx([17 * side, -17 * end - 12.5 * lift, 12.5 * side], rel=1e-6)


def test_drag_of_a_turning_pontoon_grows_with_the_square_of_the_radius():
    """Yaw at 0.1 rad/s: 1/2 rho C h w^2 integral of r^2 dr sideways, r^3 dr for the moment; Gauss points are exact."""
    pontoon = RectangularMember(**PONTOON, drag_coefficient=(1.5, 2.5))
    floater = hull(CircularMember(**COLUMN), pontoon)
    state = fw.load(model(floater, angle_rates_start=(0, 0, 0.1))).compile().initial_state()
    force, moment = loads(state, "member_1")
    half = RHO / 2 * 1.5 * 2 * 0.01
    assert force == pytest.approx([0, -half * (20**3 - 5**3) / 3, 0], rel=1e-4, abs=1e-6)  # smooth |u| near rest
    assert moment[2] == pytest.approx(-half * (20**4 - 5**4) / 4, rel=1e-4)


def test_each_member_has_its_own_of_the_strips_of_all():
    """With as many as it likes, or none: the load on the pontoon does not go by those of the columns."""
    found = []
    for counts in ((0, 5), (6, 0), (3, 1)):
        pontoon = RectangularMember(**PONTOON, drag_coefficient=(1.5, 2.5), sections=4)
        first, last = (CircularMember(**{**COLUMN, "start": (x, 0, -20), "end": (x, 0, 10)}, drag_coefficient=1.0,
                                      sections=count) for x, count in zip((0, 30), counts, strict=True))  # fmt: skip
        brace = RectangularMember(**{**PONTOON, "start": (20, 0, -17), "end": (30, 0, -17)}, sections=0)
        plant = fw.load(model(hull(first, pontoon, brace, last), velocity_start=(2.0, 1.0, 0.5))).compile()
        assert [path for path in plant.dae.bound if "strips" in path] == ["floater.strips"]
        state = plant.initial_state()
        found.append(np.concatenate(loads(state, "member_1")))
        drags = [np.any(loads(state, f"member_{k}")[0]) for k in (0, 3)]
        assert drags == [bool(count) for count in counts] and not np.any(loads(state, "member_2")[0])
    assert found[1] == pytest.approx(found[0], rel=1e-12) and found[2] == pytest.approx(found[0], rel=1e-12)


def test_drag_of_heave_plates_is_on_what_the_water_touches():
    """A plate of 18 m below a column of 10 m: its upper side is a ring."""
    plate = CircularMember(start=(0, 0, -21), end=(0, 0, -20), diameters=18.0, end_drag=(4.0, 2.0))
    state = fw.load(model(hull(CircularMember(**COLUMN), plate), velocity_start=(0, 0, -1.0))).compile().initial_state()
    force, _ = loads(state, "member_1")
    assert force[2] == pytest.approx(RHO / 2 * math.pi / 4 * (4 * 18**2 + 2 * (18**2 - 10**2)), rel=2e-3)


# --- order, direction, frame -----------------------------------------------------------------------------------------


def braced(order=(0, 1, 2, 3), flip=False, turn=0.0):
    """Two columns, a pontoon and an inclined brace, turned about z."""
    cos, sin = math.cos(turn), math.sin(turn)

    def ends(a, b):
        points = [(cos * x - sin * y, sin * x + cos * y, z) for x, y, z in (a, b)]
        return dict(zip(("start", "end"), points[::-1] if flip else points, strict=True))

    def pair(a, b):
        return (b, a) if flip else (a, b)

    members = [
        CircularMember(**ends((0, 0, -20), (0, 0, 10)), diameters=10.0, wall_thickness=0.05, drag_coefficient=0.6,
                       added_mass_coefficient=1.0, sections=3, end_drag=pair(4.8, 0.0), end_added_mass=pair(1.0, 0.0)),
        CircularMember(**ends((25, 5, -20), (25, 5, 10)), diameters=pair(9.0, 7.0), wall_thickness=0.05,
                       drag_coefficient=0.7, added_mass_coefficient=0.9, sections=3),
        RectangularMember(**ends((0, 0, -17), (25, 5, -17)), widths=3.0, heights=2.0, drag_coefficient=(1.5, 2.5),
                          added_mass_coefficient=(0.8, 1.3), sections=3),
        CircularMember(**ends((0, 0, -12), (25, 5, 8)), diameters=1.8, drag_coefficient=1.0,
                       added_mass_coefficient=1.0, sections=3),
    ]  # fmt: skip
    return hull(*(members[k] for k in order))


WAVE = {"spectrum": "regular", "wave_height": 4.0, "wave_period": 9.0}


def in_waves(floater, turn=0.0, **changes):
    """Loads on the floater at t = 0 in a wave, the body moving and turned."""
    cos, sin = math.cos(turn), math.sin(turn)
    velocity = (cos * 0.7 + sin * 0.3, sin * 0.7 - cos * 0.3, 0.2)
    motion = {"velocity_start": velocity, "angle_rates_start": (0.0, 0.0, 0.05)}
    plant = fw.load(model(floater, Sea(**WAVE, heading=0.4 + turn), **{**motion, **changes})).compile()
    state = plant.initial_state()
    push = state["floater.member_loads.frame.f"].ravel(), state["floater.member_loads.frame.t"].ravel()
    return *push, state["motion.acceleration"].ravel()


def test_order_and_direction_of_members_make_no_difference():
    force, moment, acceleration = in_waves(braced())
    for other in (braced(order=(3, 1, 0, 2)), braced(flip=True)):
        found = in_waves(other)
        scale = np.abs(moment).max()
        np.testing.assert_allclose(found[0], force, rtol=1e-5, atol=1e-7 * scale)
        np.testing.assert_allclose(found[1], moment, rtol=1e-5, atol=1e-6 * scale)
        np.testing.assert_allclose(found[2], acceleration, rtol=1e-5, atol=1e-8)


def test_a_floater_that_is_drawn_turned_or_has_yawed_has_turned_loads():
    """With the sea and the motion turned as well; drawn turned at rest, or drawn as before and yawed by the joint."""
    turn = 0.6
    spin = np.array([[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]])
    force, moment, acceleration = in_waves(braced())
    drawn = in_waves(braced(turn=turn), turn)
    for found, wanted in zip(drawn, (force, moment, acceleration), strict=True):
        np.testing.assert_allclose(found, spin @ wanted, rtol=1e-4, atol=1e-5 * np.abs(wanted).max())
    still = {"velocity_start": (0, 0, 0), "angle_rates_start": (0.01, 0.02, 0.05)}
    a = fw.load(model(braced(), **still)).compile().initial_state()
    b = fw.load(model(braced(), **still, yaw_start=turn)).compile().initial_state()
    for name in ("f", "t"):
        one, other = (state[f"floater.member_loads.frame.{name}"].ravel() for state in (a, b))
        np.testing.assert_allclose(other, spin @ one, rtol=1e-6, atol=1e-6 * np.abs(one).max())


# --- inertia of the water --------------------------------------------------------------------------------------------


def test_added_mass_stands_in_the_mass_matrix():
    """A push of a column with C_a: surge acceleration of F / (m + rho C_a V), with pitch free to follow."""
    floater = hull(CircularMember(**COLUMN, added_mass_coefficient=0.9, end_added_mass=(0.8, 0.0)))
    whole = model(floater)
    whole.force, whole.value = WorldForce(), Constant(value=(1e5, 0.0, 2e5))
    whole.connect(whole.value.y, whole.force.force)
    whole.connect(whole.motion.frame_b, whole.force.frame)
    state = fw.load(whole).compile().initial_state()
    body, volume = floater.hull().mass, math.pi * 25 * 20
    added = RHO * 0.9 * volume
    inertia = np.diag(body.about((0, 0, 0)))[1]
    matrix = [[body.mass + added, body.mass * body.centre[2] - 10 * added],
              [body.mass * body.centre[2] - 10 * added, inertia + added * (100 + 400 / 12)]]  # fmt: skip
    wanted = np.linalg.solve(matrix, [1e5, 0.0])
    assert state["motion.acceleration"].ravel()[0] == pytest.approx(wanted[0], rel=1e-6)
    assert state["motion.angle_accelerations"].ravel()[1] == pytest.approx(wanted[1], rel=1e-6)
    ball = 0.8 * RHO * 2 / 3 * math.pi * 125
    lift = RHO * G * volume - body.mass * G + 2e5
    assert state["motion.acceleration"].ravel()[2] == pytest.approx(lift / (body.mass + ball), rel=1e-4)


def test_a_long_wave_lifts_and_pushes_as_archimedes_and_newton_say():
    """T = 60 s in 200 m: heave load -> C33 times the elevation; surge load rho V (1 + C_a) a at a quarter period."""
    column = CircularMember(**COLUMN, added_mass_coefficient=0.8, sections=8)
    sea = Sea(spectrum="regular", wave_height=2.0, wave_period=60.0)
    plant = fw.load(model(hull(column), sea)).compile()
    area = math.pi * 25
    omega = 2 * math.pi / 60
    state = plant.initial_state()
    water = sea.components()
    acceleration = water.evaluate(water.acceleration_transfer([(0, 0, -10.0)])[:, 0], 0.0)[0]
    own = state["motion.acceleration"].ravel()
    turn = state["motion.angle_accelerations"].ravel()
    force, _ = loads(state, "member_0")
    middle = own[0] - 10 * turn[1]
    assert force[0] + 0.8 * RHO * 20 * area * middle == pytest.approx(1.8 * RHO * 20 * area * acceleration[0], abs=2e3)
    lift = RHO * area * (G * 1.0 + 20 * acceleration[2])  # at the crest, less the inertia of the water above the keel
    assert force[2] == pytest.approx(lift, rel=2e-3)
    assert abs(acceleration[2]) == pytest.approx(omega**2, rel=0.2)


@pytest.mark.parametrize("place", [0.0, 20.0])
def test_the_transfer_of_the_wave_is_the_load_on_a_floater_that_is_held(place):
    """Response operators take X(omega); at t = 0 a wave of 1 m has Re X, and 20 m further on another phase."""
    floater = braced()
    for member in floater.parts.values():
        if "drag_coefficient" in member.parameters:
            member.drag_coefficient = 0.0 * np.asarray(member.parameter_value("drag_coefficient"))
            member.end_drag = (0, 0)
    floater.position = (place, 0, 0)
    whole = fw.Assembly("held")
    whole.world = World(water_depth=200.0, water_density=RHO)
    whole.sea = Sea(spectrum="regular", wave_height=2.0, wave_period=9.0, heading=0.4)
    whole.ground, whole.floater = Fixed(r=(place, 0, 0)), floater
    whole.connect(whole.ground.frame, floater.frame)
    state = fw.load(whole).compile().initial_state()
    found = -np.concatenate([state[f"floater.member_loads.frame.{name}"].ravel() for name in ("f", "t")])
    wanted = floater.member_loads.wave_transfer(np.array([2 * math.pi / 9.0]), 0.4)[0].real
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-6 * np.abs(wanted).max())
    floater_of_drag = hull(CircularMember(**COLUMN, drag_coefficient=0.6))
    assert not hasattr(model(floater_of_drag).floater.member_loads, "wave_transfer")


def test_the_response_operator_of_a_column_in_heave():
    """(C cosh k(h - d) / cosh kh - A w^2 sinh k(h - d) / sinh kh) / (C - w^2 (m + A)), d the draft."""
    column = CircularMember(**COLUMN, added_mass_coefficient=1.0, end_added_mass=(1.0, 0.0))
    column.sand = Ballast(density=2000.0, level=-15.0)
    floater = Floater()
    floater.column = column
    column.sand.level = floater.ballast_level("column.sand")
    frequencies = np.array([0.01, 0.03, 0.05])
    rao = fw.linear_rao(fw.load(model(floater)), frequencies, outputs=["motion.heave"])
    omega, depth, area = 2 * math.pi * frequencies, 200.0, math.pi * 25
    k, C, A = wave_number(omega, depth), RHO * G * area, RHO * 2 / 3 * math.pi * 125
    push = C * np.cosh(k * (depth - 20)) / np.cosh(k * depth)
    push -= A * omega**2 * np.sinh(k * (depth - 20)) / np.sinh(k * depth)
    wanted = push / (C - omega**2 * (RHO * area * 20 + A))
    assert rao.response[:, 0].real == pytest.approx(wanted, rel=1e-3)
    assert np.abs(rao.response[:, 0].imag).max() < 1e-6


def test_a_column_has_the_drag_of_the_older_part():
    column = {"start": (0, 0, -20), "end": (0, 0, 10), "diameters": 10.0, "drag_coefficient": 0.6}
    whole = model(hull(CircularMember(**column, sections=12)), Sea(**WAVE), velocity_start=(0.5, 0, 0))
    whole.drag = MorisonDrag(points=[(0, 0, -20), (0, 0, 10)], diameters=(10.0, 10.0), drag_coefficient=0.6)
    whole.connect(whole.motion.frame_b, whole.drag.frame)
    whole.floater.member_0.wall_thickness = 0.05
    state = fw.load(whole).compile().initial_state()
    force, moment = loads(state, "member_0")
    assert force == pytest.approx(state["drag.force"].ravel(), rel=1e-9)
    assert moment == pytest.approx(state["drag.moment"].ravel(), rel=1e-9, abs=1e-3)


# --- in models -------------------------------------------------------------------------------------------------------


def test_a_hull_with_ballast_for_its_draft_floats_there():
    """With a mass of 40 t on a node at the top."""
    column = CircularMember(**COLUMN, drag_coefficient=0.6)
    column.floor = Bulkhead(place=0.0, thickness=0.05)
    column.sand = Ballast(density=2000.0, level=-15.0)
    floater = Floater(node_points=[(0, 0, 10)])
    floater.column = column
    floater.column.sand.level = floater.ballast_level("column.sand", load=40e3)
    whole = model(floater)
    whole.top = PointMass(mass=40e3)
    whole.connect(floater.nodes[0], whole.top.frame_a)
    plant = fw.load(whole).compile()
    held = {"motion.surge": 0, "motion.sway": 0, "motion.yaw": 0}
    state = plant.equilibrium(hold=held)
    assert state["motion.heave"] == pytest.approx(0.0, abs=1e-6)
    assert np.ravel(state["top.frame_a.r"]) == pytest.approx([0, 0, 10], abs=1e-6)
    # lighter ballast in the built model: it floats as much higher as `rise` says
    lighter = plant.equilibrium(hold=held, parameters={"floater.column.sand.density": 1950.0})
    floater.column.sand.density = 1950.0
    assert lighter["motion.heave"] == pytest.approx(floater.rise(load=40e3), rel=1e-4)
    # and a wider column changes mass, buoyancy and drag of the built model as if it had been built so
    wider = plant.initial_state(parameters={"floater.column.diameters": 10.4})
    column.diameters, column.sand.density = 10.4, 2000.0
    again = fw.load(whole).compile().initial_state()
    for name in ("motion.acceleration", "floater.hydrostatics.buoyancy", "floater.column.force"):
        assert np.ravel(wider[name]) == pytest.approx(np.ravel(again[name]), rel=1e-9, abs=1e-9), name


FILE = """
fowtlib: 1
title: three columns
parameters:
  radius: 25 m
  draft: 18 m
  level: -9 m
  keel: [0 m, 0 m, -18 m]
world: {class: World, water_depth: 200 m}
parts:
  motion: {class: FreeMotion}
  hull:
    class: Floater
    node_points: [[0, 0, 8 m]]
    parts:
      centre: {class: CircularMember, start: keel, end: [0, 0, 8 m], diameters: 7 m, wall_thickness: 40 mm}
    each:
      - for: [{k: 1, angle: 0 deg}, {k: 2, angle: 120 deg}, {k: 3, angle: 240 deg}]
        parts:
          column_{k}:
            class: CircularMember
            start: [radius*cos(angle), radius*sin(angle), -draft]
            end: [radius*cos(angle), radius*sin(angle), 9 m]
            diameters: 10 m
            wall_thickness: 50 mm
            drag_coefficient: 0.6
            parts:
              water: {class: Ballast, level: level}
          pontoon_{k}:
            class: RectangularMember
            start: [0, 0, 2 m - draft]
            end: [radius*cos(angle), radius*sin(angle), 2 m - draft]
            widths: 3 m
            heights: 2 m
            wall_thickness: 30 mm
            drag_coefficient: [1.5, 2.5]
connect:
  - [world.frame, motion.frame_a]
  - [motion.frame_b, hull.frame]
"""


def test_a_floater_in_a_model_file_with_named_joints(tmp_path):
    path = tmp_path / "floater.yaml"
    path.write_text(FILE)
    found = fw.load(path)
    hull = found.root.hull.hull()
    assert len(hull.members) == 7 and len(hull.fills) == 3
    assert hull.buoyancy.centre[:2] == pytest.approx([0, 0], abs=1e-5)
    wide = fw.load(path, set={"radius": "30 m"}).root.hull.hull()
    ratio = wide.buoyancy.waterplane[4, 4] / hull.buoyancy.waterplane[4, 4]
    assert ratio == pytest.approx(900 / 625, rel=0.01)  # 3/2 A r^2, but for the own moments of the columns
    plant = found.compile()
    assert {"radius", "level", "keel"} <= set(plant.dae.parameters)
    state = plant.initial_state(parameters={"level": -7.0})
    mass = hull.mass.mass + RHO * 3 * math.pi / 4 * 9.9**2 * 2.0
    assert state["motion.acceleration"].ravel()[2] == pytest.approx(RHO * G * hull.buoyancy.volume / mass - G, abs=1e-4)
    again = tmp_path / "again.yaml"
    again.write_text(dump(found))
    copy = fw.load(again).root.hull.hull()
    assert copy.mass.mass == pytest.approx(hull.mass.mass) and copy.members[3].fills == hull.members[3].fills


@pytest.mark.parametrize(
    ("old", "new", "line", "says"),
    [
        ("wall_thickness: 30 mm", "wall_thickness: 30", 29, "hull.pontoon_1: its wall of 30 m is thicker than half"),
        ("heights: 2 m", "heights: -2 m", 29, "hull.pontoon_1: a diameter, width or height of -2 m is not above zero"),
        ("water_depth: 200 m", "water_depth: 15 m", 12, "hull: its lowest point is at z = -18 m, below the seabed at"),
        ("level: -9 m", "level: 30 m", 28, "hull.column_1.water: its surface at z = 30 m is above its tank"),
    ],
)
def test_a_mistake_in_a_drawing_has_its_line(tmp_path, old, new, line, says):
    path = tmp_path / "floater.yaml"
    assert old in FILE
    path.write_text(FILE.replace(old, new))
    with pytest.raises(ParameterError) as error:
        fw.load(path).compile()
    place, _, message = str(error.value).partition(": ")
    assert place.endswith(f"floater.yaml:{line}") and message.startswith(says)


def test_the_check_of_a_model_says_the_regime_of_each_member():
    """Regular wave in deep water: KC = pi H / D at the surface, L = g T^2 / 2 pi."""

    def remarks_in(**sea):
        floater = hull(CircularMember(**COLUMN, added_mass_coefficient=1.0), RectangularMember(**PONTOON),
                       CircularMember(start=(0, 0, 5), end=(20, 0, 5), diameters=1.0))  # fmt: skip
        report = fw.load(model(floater, Sea(**sea))).check()
        assert all(f"\n  {remark}" in str(report) for remark in report.remarks)
        return report.remarks

    remarks = remarks_in(spectrum="regular", wave_height=8.0, wave_period=8.0)
    length = G * 64 / (2 * math.pi)
    pattern = "member_0: KC 2.51, diameter over wave length 0.1: inertia and drag both matter"
    assert remarks[0].endswith(pattern) and 8 * math.pi / 10 == pytest.approx(2.51, abs=0.01)
    assert 10 / length == pytest.approx(0.1, abs=2e-3)
    down = math.exp(-2 * math.pi / length * 17)  # waves along the pontoon move the water across it up and down
    found = float(remarks[1].partition("KC ")[2].partition(",")[0])
    assert found == pytest.approx(8 * math.pi / 3 * down, rel=0.01)
    assert "give it an added_mass_coefficient, or the floater a database" in remarks[1]
    assert remarks[2].endswith("above the water")
    short = remarks_in(spectrum="regular", wave_height=2.0, wave_period=5.0)
    assert "it scatters the waves; Morison's formula does not hold, give the floater a database" in short[0]
    assert not remarks_in(spectrum="still")


def test_pictures_show_every_member():
    floater = hull(CircularMember(**COLUMN), RectangularMember(**PONTOON))
    tube, loft = model(floater).floater.drawing()
    assert tube.diameters == pytest.approx([10, 10]) and tube.points[1] == pytest.approx([0, 0, 10])
    assert loft.sections.shape == (2, 4, 3) and np.ptp(loft.sections[0], axis=0) == pytest.approx([0, 3, 2])


# --- mistakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: setattr(f.member_1, "start", (6.5, 0, -17)), r"member_1 and .*member_0 do not meet.*gap is 1.5 m"),
        (lambda f: f.member_0.add("sand", Ballast(level=41.0)), r"member_0.sand.*z = 41 m is above its tank"),
        (lambda f: setattr(f, "held_upright", False), r"floater cannot float upright: .* height .* is -\d"),
        (lambda f: setattr(f.member_0, "diameters", (9, 9, 8)), "its section has 3 values, and there are 2 stations"),
        (lambda f: setattr(f.member_0, "stations", (0, 0.7)), "must go from 0, the start, to 1, the end"),
        (lambda f: setattr(f.member_1, "widths", (3, 3, 3)), "its section has 3 values"),
        (lambda f: setattr(f, "position", (0, 0, 2)), "its z must be zero.*set raised"),
        (lambda f: setattr(f, "node_points", (0, 0, 1)), "must be a list of points"),
        (lambda f: setattr(f, "raised", 40.0), "lies above the water"),
        (lambda f: setattr(f.member_1, "wall_thickness", 1.2), "thicker than half of its 2 m"),
    ],
)  # fmt: skip
def test_mistakes_are_told_with_path_number_and_way_out(change, message):
    floater = hull(CircularMember(**{**COLUMN, "end": (0, 0, 40)}), RectangularMember(**PONTOON))
    whole = model(floater)
    with pytest.raises(ModelError, match=message):
        change(floater)
        fw.load(whole).check()


def test_a_floater_without_members_and_a_database_of_another_hull_are_refused():
    with pytest.raises(ParameterError, match="floater has no members; give it parts of class CircularMember"):
        fw.load(model(Floater())).check()
    known = str(Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc")
    spar = {"start": (0, 0, -120), "end": (0, 0, 10), "stations": (0, 108 / 130, 116 / 130, 1)}
    floater = hull(CircularMember(**spar, diameters=(9.4, 9.4, 6.5, 6.5)), database=known)
    whole = model(floater)
    whole.world.water_depth = 320.0
    fw.load(whole).check()
    assert set(floater.potential_flow.parts) == {"added_mass", "radiation", "waves"}
    data = HydrodynamicDatabase.read(known)
    water = floater.hull().buoyancy
    assert water.volume == pytest.approx(data.volume, rel=1e-4)
    C = RHO * G * water.waterplane
    assert C[2, 2] == pytest.approx(333550, rel=1e-4)  # the round spar; that of the panels is 0.2 % less
    assert waterplane_stiffness(data)[2, 2] == pytest.approx(C[2, 2], rel=3e-3)
    floater.member_0.diameters = (9.4, 9.4, 8.5, 8.5)
    floater.member_0.start = (0, 0, -90)
    with pytest.raises(ParameterError, match=r"its members displace .* and the hull of its database 8029"):
        fw.load(whole).check()
