"""CatenaryLine, MooringSystem and YawSpring in compiled models, against the NumPy solver and published numbers."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import Fixed, FreeMotion, Prismatic, RigidBody, World, WorldForce
from fowtlib.components.mooring import CatenaryLine, MooringSystem, Tendon, YawSpring
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError, SimulationError

LINE = {"length": "902.2 m", "axial_stiffness": "384.243 MN", "mass_per_length": 77.7066, "diameter": 0.09}
LAYOUT = {"fairlead_radius": 5.2, "fairlead_depth": 70, "anchor_radius": 853.87, "anchor_depth": 320}
DOWNWIND_LINE_AHEAD = ["120 deg", "240 deg", "0 deg"]


def moored(**parameters):
    """A rigid body on a mooring system; what else holds it up does not matter for the loads of the lines."""
    model = Assembly("moored body")
    model.world = World()
    model.motion = FreeMotion()
    model.body = RigidBody(mass=7e6, inertia=np.diag([4e9, 4e9, 2e8]))
    layout = {} if "fairleads" in parameters else {"headings": DOWNWIND_LINE_AHEAD, **LAYOUT}
    model.mooring = MooringSystem(**{**layout, **LINE, **parameters})
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    model.connect(model.body.frame_a, model.mooring.frame)
    return model


@pytest.fixture(scope="module")
def oc3():
    return fw.load(moored(yaw_stiffness="98.34 MN*m/rad")).compile()


@pytest.fixture(scope="module")
def heavy():
    return fw.load(moored(mass_per_length=200.0)).compile()


def force(plant, **position):
    """Force of the lines on the body: minus that into the mooring system."""
    state = plant.initial_state(start={f"motion.{name}": value for name, value in position.items()})
    return -np.ravel(state["mooring.frame.f"])


@pytest.mark.parametrize(
    ("surge", "restoring"), [(5, 196.6), (10, 380.7), (15, 559.9), (20, 741.8), (25, 947.6), (30, 1204.5)]
)
def test_surge_restoring_force_of_oc3(oc3, surge, restoring):
    assert force(oc3, surge=surge)[0] == pytest.approx(-restoring * 1e3, rel=1e-3)


@pytest.mark.parametrize(
    ("surge", "restoring"), [(5, 429.5), (10, 834), (15, 1224), (20, 1610), (25, 2000), (30, 2404)]
)
def test_surge_restoring_force_of_heavy_lines(heavy, surge, restoring):
    assert force(heavy, surge=surge)[0] == pytest.approx(-restoring * 1e3, rel=1e-3)


@pytest.mark.parametrize(
    "position", [{"surge": -60.0}, {"surge": 60.0}, {"sway": 60.0}, {"heave": 15.0, "surge": 20.0}]
)
def test_far_offsets_agree_with_the_bracketed_solver(oc3, position):
    place = [position.get(name, 0.0) for name in ("surge", "sway", "heave")]
    system = MooringSystem(headings=DOWNWIND_LINE_AHEAD, **LAYOUT, **LINE)
    expected, states = system.static_load(place)
    assert force(oc3, **position) == pytest.approx(expected, rel=1e-5, abs=1.0)
    state = oc3.initial_state(start={f"motion.{name}": value for name, value in position.items()})
    for i, line in enumerate(states):
        assert float(state[f"mooring.line_{i + 1}.horizontal_tension"]) == pytest.approx(
            line["horizontal"], rel=1e-5, abs=1
        )
        assert float(state[f"mooring.line_{i + 1}.seabed_length"]) == pytest.approx(line["seabed_length"], abs=1e-2)


@pytest.mark.parametrize("depth", [200.0, 319.0, 320.0])
def test_lines_from_anchors_in_mid_water_in_pre_processing(depth):
    """The seabed of the lines by themselves is that of the World, or given."""
    model = moored(anchor_depth=depth, length=860.0 if depth < 300 else 902.2)
    expected, states = model.mooring.static_load()
    plant = fw.load(model).compile()
    assert force(plant) == pytest.approx(expected, rel=1e-5, abs=1.0)
    assert float(plant.initial_state()["mooring.line_1.seabed_length"]) == pytest.approx(
        states[0]["seabed_length"], abs=1e-2
    )
    alone = MooringSystem(headings=DOWNWIND_LINE_AHEAD, **{**LAYOUT, **LINE, "anchor_depth": depth})
    if depth == 200:
        alone.length = 860.0
    assert alone.static_load(water_depth=320.0)[0][2] == pytest.approx(expected[2], rel=1e-9)


def test_three_lines_make_a_symmetric_system(oc3):
    assert force(oc3) == pytest.approx([0, 0, -1.607e6], rel=1e-3, abs=1.0)
    port, starboard = force(oc3, sway=12.0), force(oc3, sway=-12.0)
    assert port == pytest.approx(starboard * [1, -1, 1], rel=1e-9, abs=1e-3)
    angle = np.radians(120)
    turned = force(oc3, surge=15 * np.cos(angle), sway=15 * np.sin(angle))
    straight = force(oc3, surge=15.0)
    assert turned[:2] == pytest.approx(straight[0] * np.array([np.cos(angle), np.sin(angle)]), rel=1e-9)


def test_yaw_stiffness_of_spring_and_lines(oc3, heavy):
    """The lines add 3 H r (1 + r / l) of their own, with the horizontal pretension H and the fairlead radius r."""

    def moment(plant, yaw):
        return -np.ravel(plant.initial_state(start={"motion.yaw": yaw})["mooring.frame.t"])[2]

    lines = [3 * H * 5.2 * (1 + 5.2 / 848.67) for H in (736.9e3, 1803.8e3)]
    assert moment(heavy, 0.01) == pytest.approx(-0.01 * lines[1], rel=3e-3)
    assert moment(oc3, 0.01) == pytest.approx(-0.01 * (98.34e6 + lines[0]), rel=1e-3)
    assert moment(oc3, -0.2) == pytest.approx(-moment(oc3, 0.2), rel=1e-9)


def test_explicit_layout_with_lines_of_their_own():
    directions = np.radians([120, 240, 0])
    plan = np.column_stack([np.cos(directions), np.sin(directions)])
    fairleads, anchors = (np.column_stack([r * plan, np.full(3, z)]) for r, z in ((5.2, -70), (853.87, -320)))
    properties = {**LINE, "mass_per_length": [77.7066, 77.7066, 200.0]}
    plant = fw.load(moored(fairleads=fairleads, anchors=anchors, **properties)).compile()
    state = plant.initial_state()
    tensions = [float(state[f"mooring.line_{i}.tension"]) for i in (1, 2, 3)]
    assert tensions == pytest.approx([911.1e3, 911.1e3, 2275.8e3], rel=1e-3)


def on_a_rail(start, mass=5e6, **line):
    """One line whose fairlead slides along x."""
    model = Assembly("line on a rail")
    model.world = World()
    model.base = Fixed(r=(0, 0, -70))
    model.slide = Prismatic(s_start=start)
    model.body = RigidBody(mass=mass, inertia=np.eye(3))
    model.line = CatenaryLine(anchor_position=(-848.67, 0, -320), **{**LINE, **line})
    model.other = CatenaryLine(anchor_position=(848.67, 0, -320), **LINE)
    for a, b in (
        (model.base.frame, model.slide.frame_a),
        (model.slide.frame_b, model.body.frame_a),
        (model.body.frame_a, model.line.fairlead),
        (model.body.frame_a, model.other.fairlead),
    ):
        model.connect(a, b)
    return model


@pytest.mark.parametrize("amplitude", [8.0, 30.0])
def test_oscillation_between_two_lines_keeps_its_energy(amplitude):
    """From small motion to lines that lift off, stretch and hang almost slack within one period."""
    plant = fw.load(on_a_rail(amplitude)).compile()
    result = plant.simulate(200.0, 0.05, tolerance=1e-8, outputs=["slide.s", "line.seabed_length"])
    s = result["slide.s"].to_numpy()
    turning = np.abs(s[1:-1][(np.diff(s)[:-1] * np.diff(s)[1:]) <= 0])
    assert len(turning) > 3
    assert turning == pytest.approx(amplitude, rel=1e-4)
    assert (float(result["line.seabed_length"].min()) == 0) == (amplitude > 10)


def test_friction_takes_up_tension_on_the_seabed():
    with_friction = fw.load(on_a_rail(0.0, friction=1.0)).compile().initial_state()
    H, anchor, seabed = (
        float(with_friction[f"line.{x}"]) for x in ("horizontal_tension", "anchor_tension", "seabed_length")
    )
    weight = float(with_friction["line.weight"])
    assert anchor == pytest.approx(H - weight * seabed, rel=1e-9)
    without = fw.load(on_a_rail(0.0)).compile().initial_state()
    assert H > float(without["line.horizontal_tension"]) == pytest.approx(float(without["line.anchor_tension"]))


def test_anchor_on_a_frame():
    model = on_a_rail(0.0)
    model.ground = Fixed(r=(0, -848.67, -320))
    model.third = CatenaryLine(**LINE)
    model.connect(model.ground.frame, model.third.anchor)
    model.connect(model.body.frame_a, model.third.fairlead)
    state = fw.load(model).compile().initial_state()
    assert float(state["third.tension"]) == pytest.approx(float(state["line.tension"]), rel=1e-9)
    assert np.ravel(state["third.anchor.f"]) == pytest.approx(
        [0, -float(state["third.horizontal_tension"]), 0], abs=1e-3
    )


def test_a_parameter_that_the_layout_does_not_use_is_no_tunable_one(heavy):
    with pytest.raises(ParameterError, match=r"there is no tunable parameter 'mooring\.yaw_stiffness'"):
        heavy.initial_state(parameters={"mooring.yaw_stiffness": 1e8})
    with pytest.raises(ParameterError, match=r"there is no tunable parameter 'mooring\.line_1\.weight_per_length'"):
        heavy.initial_state(parameters={"mooring.line_1.weight_per_length": 700.0})


def test_yaw_spring_is_a_pure_moment():
    model = Assembly()
    model.world = World()
    model.motion = FreeMotion(yaw_start="10 deg", pitch_start="5 deg")
    model.body = RigidBody(mass=1.0, inertia=np.eye(3))
    model.spring = YawSpring(stiffness=100.0)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    model.connect(model.body.frame_a, model.spring.frame)
    state = fw.load(model).compile().initial_state()
    assert float(state["spring.yaw"]) == pytest.approx(np.radians(10))
    assert np.ravel(state["spring.frame.t"]) == pytest.approx([0, 0, 100 * np.radians(10)])


def test_the_run_stops_when_a_fairlead_sinks_into_the_seabed():
    model = on_a_rail(0.0)
    model.world.water_depth = 69.5
    model.line.anchor_position = (-848.67, 0, -69.5)
    model.other.anchor_position = (848.67, 0, -69.5)
    with pytest.raises(SimulationError, match=r"line: the fairlead is at -70 m, below the seabed at -69\.5 m"):
        fw.load(model).compile().simulate(1.0, 0.1)


@pytest.mark.parametrize(("depth", "anchor"), [(320, -400), (200, -320), (320, -320.02)])
def test_an_anchor_below_the_seabed_is_refused(depth, anchor):
    model = on_a_rail(0.0)
    model.world.water_depth = depth
    model.line.anchor_position = (-848.67, 0, anchor)
    said = rf"line has its anchor at z = {anchor} m, below the seabed: World\.water_depth is {depth} m"
    with pytest.raises(ParameterError, match=said):
        fw.load(model).compile()


def test_an_anchor_that_is_moved_below_the_seabed_stops_the_run():
    plant = fw.load(on_a_rail(0.0)).compile()
    with pytest.raises(SimulationError, match="line: the anchor is at -330 m, below the seabed at -320 m"):
        plant.simulate(1.0, 0.1, parameters={"line.anchor_position": (-848.67, 0, -330)})


@pytest.mark.parametrize("part", [CatenaryLine, Tendon])
def test_an_anchor_above_the_water_is_refused(part):
    """A sign that was forgotten; also where it is given to a compiled model."""
    model = Assembly("a line")
    model.world, model.end = World(water_depth=100.0), Fixed(r=(30, 0, -10))
    model.line = part(length=100.0, axial_stiffness=1e8, weight_per_length=500.0, anchor_position=(0, 0, 100))
    model.connect(model.end.frame, model.line.fairlead)
    with pytest.raises(ParameterError, match=r"anchor at z = 100 m, above the water, .* seabed z is -100 m"):
        fw.load(model).compile()
    model.line.anchor_position = (0, 0, -100)
    plant = fw.load(model).compile()
    with pytest.raises(SimulationError, match="line: the anchor is at 5 m, above the water; on the seabed"):
        plant.simulate(1.0, 0.5, parameters={"line.anchor_position": (0, 0, 5)})


def test_slack_and_overstretched_lines_warn():
    model = on_a_rail(-205.0)
    model.other.greatest_strain = 0.3
    plant = fw.load(model).compile()
    with pytest.warns(UserWarning) as caught:
        plant.simulate(0.02, 0.01)
    said = "\n".join(str(warning.message) for warning in caught)
    assert "line: the line is slack: it hangs vertically, its excess on the seabed" in said
    assert "other: the line is stretched by 0.200506 of its length, more than half of greatest_strain" in said


@pytest.mark.parametrize(("limit", "start"), [(0.1, -205.0), (0.15, -205.0), (0.01, -30.0)])
def test_a_line_is_not_stretched_beyond_the_range_of_its_stiffness(limit, start):
    model = on_a_rail(start)
    model.other.greatest_strain = limit
    with pytest.raises(SimulationError, match=rf"other: the line is stretched by 0\.\d+ of its length; .* = {limit}\."):
        fw.load(model).compile().simulate(0.02, 0.01)


def test_a_tension_above_the_breaking_load_warns_with_its_time():
    model = on_a_rail(0.0)
    model.line.breaking_load = "900 kN"
    with pytest.warns(UserWarning, match=r"line: the tension of 911\d\d\d N is above the breaking load \(t = 0 s\)"):
        fw.load(model).compile().simulate(0.02, 0.01)


def between(left, right, depth=320.0, **line):
    """A line between two fixed points."""
    model = Assembly("line between two points")
    model.world = World(water_depth=depth)
    model.left, model.right = Fixed(r=left), Fixed(r=right)
    model.line = CatenaryLine(**line)
    model.connect(model.left.frame, model.line.anchor)
    model.connect(model.right.frame, model.line.fairlead)
    return fw.load(model).compile().initial_state()


SHARED = {"length": 520, "axial_stiffness": 7.5e8, "weight_per_length": 1000}


@pytest.mark.parametrize(
    ("left", "right", "depth", "expected"),
    [
        ((0, 0, -30), (500, 0, -14), 320.0, (511.428, 277.646, -242.354, 0)),
        ((0, 0, -14), (500, 0, -14), 320.0, (508.396, 260.0, -260.0, 0)),
        ((0, 0, -14), (300, 400, -30), 320.0, (511.428, 242.354, -277.646, 0)),
    ],
)
def test_a_line_between_two_bodies_floats_free_of_the_seabed(left, right, depth, expected):
    """Horizontal and vertical tension, and the pull of the line on the lower end: MoorPy 1.3.0."""
    state = between(left, right, depth, **SHARED)
    values = [float(state[f"line.{name}"]) for name in ("horizontal_tension", "vertical_tension")]
    assert [*values, float(-state["line.anchor.f[2]"])] == pytest.approx(np.array(expected[:3]) * 1e3, rel=1e-5)
    assert float(state["line.seabed_length"]) == expected[3]
    f = np.ravel(state["line.anchor.f"]) + np.ravel(state["line.fairlead.f"])
    assert f == pytest.approx([0, 0, 520e3], abs=1e-3)  # the weight of the line, and nothing else


def test_a_line_between_two_bodies_touches_the_seabed_where_it_hangs_down_to_it():
    state = between((0, 0, -30), (500, 0, -14), 130.0 + 0.01, **{**SHARED, "length": 620})
    assert float(state["line.horizontal_tension"]) == pytest.approx(47.4529e3, rel=1e-4)  # MoorPy 1.3.0
    assert float(state["line.seabed_length"]) == pytest.approx(324.01, abs=0.02)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ({"mass_per_length": 10, "diameter": 0.2}, (830.8, 297.9)),
        ({"weight_per_length": -0.023}, (733.2, 366.6)),
        ({"weight_per_length": 0.0}, (733.2, 366.6)),
    ],
)
def test_a_line_that_does_not_sink(line, expected):
    """MoorPy 1.3.0; a line without weight is straight."""
    state = between((0, 0, 0), (1000, 0, 500), 2000.0, length=1100, axial_stiffness=50e6, **line)
    values = [float(state[f"line.{name}"]) for name in ("horizontal_tension", "vertical_tension")]
    assert values == pytest.approx(np.array(expected) * 1e3, rel=1e-4)
    assert float(state["line.seabed_length"]) == 0


def test_a_line_that_would_float_at_the_surface_is_refused():
    model = on_a_rail(0.0)
    model.rope = CatenaryLine(length=700, axial_stiffness=50e6, weight_per_length=-200, anchor_position=(-500, 0, -100))
    model.connect(model.body.frame_a, model.rope.fairlead)
    with pytest.raises(SimulationError, match="rope: the line rises to the surface between its ends"):
        fw.load(model).compile().simulate(1.0, 0.1)


def tendon(**parameters):
    """A buoyant mass on one vertical tendon."""
    model = Assembly("tendon")
    model.world = World(water_depth=200)
    model.motion = FreeMotion(**parameters)
    model.body = RigidBody(mass=1e6, inertia=np.diag([1e8, 1e8, 1e8]))
    model.lift, model.force = Constant(value=(0, 0, 15e6)), WorldForce()
    model.line = CatenaryLine(length=199.4, axial_stiffness=1.5e9, weight_per_length=1000, anchor_position=(0, 0, -200))
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.lift.y, model.force.force)
    for frame in (model.body.frame_a, model.force.frame, model.line.fairlead):
        model.connect(model.motion.frame_b, frame)
    return model


def test_a_vertical_tendon_swings_as_a_string():
    """Surge 0.0254 Hz: the square root of (T - w L / 2) / (length m), also at the point where it stands upright."""
    plant = fw.load(tendon()).compile()
    state = plant.equilibrium()
    tension, length = float(state["line.tension"]), float(state["line.rise"])
    assert tension == pytest.approx(15e6 - 1e6 * 9.80665, rel=1e-9)
    expected = np.sqrt((tension - 199.4e3 / 2) / length / 1e6) / (2 * np.pi)
    assert expected == pytest.approx(0.0254, abs=2e-5)
    modes = [mode.frequency_hz for mode in plant.linearize(state).modes() if 0 < mode.frequency_hz < 0.1]
    assert modes == pytest.approx([expected, expected], rel=1e-4)


@pytest.mark.parametrize("offset", [0.1, 0.5, 2.0])
def test_a_tendon_swings_through_the_vertical(offset):
    """Half a period is the time from one turning point to the other; 39.38 s, and 39.37 s at 2 m."""
    plant = fw.load(tendon(surge_start=offset)).compile()
    heave = float(plant.equilibrium()["motion.heave"])
    result = plant.simulate(40.0, 0.05, start={"motion.heave": heave}, tolerance=1e-8, outputs=["motion.surge"])
    time, surge = result.time, result["motion.surge"].to_numpy()
    zeros = [np.interp(0, [b, a], [t + 0.05, t]) for t, a, b in zip(time, surge, surge[1:], strict=False) if a > 0 >= b]
    rises = [np.interp(0, [a, b], [t, t + 0.05]) for t, a, b in zip(time, surge, surge[1:], strict=False) if a < 0 <= b]
    assert 2 * (rises[0] - zeros[0]) == pytest.approx(39.38, abs=0.05)


@pytest.mark.parametrize(("further_out", "yaw"), [(0.0, 0.10106), (1.0, 0.1029)])
def test_a_hull_on_four_tendons(further_out, yaw):
    """Surge near 0.0243 Hz: 4 (T - w L / 2) / (length m); yaw that, times the radius squared, over the inertia."""
    model = Assembly("hull on four tendons")
    model.world = World(water_depth=200)
    model.motion = FreeMotion()
    model.body = RigidBody(mass=8.6e6, r_cm=(0, 0, -40), inertia=np.diag([5.7e8, 5.7e8, 3.6e8]))
    model.lift, model.force = Constant(value=(0, 0, 1.15e8)), WorldForce()
    model.mooring = MooringSystem(
        headings=["0 deg", "90 deg", "180 deg", "270 deg"], fairlead_radius=27, fairlead_depth=48, anchor_depth=200,
        anchor_radius=27 + further_out, length=151.7, axial_stiffness=1.5e9, mass_per_length=116, diameter=0.127,
    )  # fmt: skip
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.lift.y, model.force.force)
    for frame in (model.body.frame_a, model.force.frame, model.mooring.frame):
        model.connect(model.motion.frame_b, frame)
    plant = fw.load(model).compile()
    modes = plant.linearize(plant.equilibrium()).modes()
    slow = sorted(mode.frequency_hz for mode in modes if mode.frequency_hz > 0)
    assert slow[:2] == pytest.approx([0.0243, 0.0243], rel=5e-3)
    assert slow[2] == pytest.approx(yaw, rel=1e-3)


def test_a_line_without_weight():
    model = on_a_rail(0.0)
    model.bare = CatenaryLine(length=900, axial_stiffness=4e8, anchor_position=(0, 848, -320))
    model.connect(model.body.frame_a, model.bare.fairlead)
    with pytest.raises(
        ParameterError, match=r"bare needs its weight once: give mass_per_length and diameter, or weight"
    ):
        fw.load(model).compile()


def test_a_line_without_an_anchor():
    model = on_a_rail(0.0)
    model.loose = CatenaryLine(length=900, axial_stiffness=4e8, weight_per_length=698)
    model.connect(model.body.frame_a, model.loose.fairlead)
    with pytest.raises(ParameterError, match=r"loose has no anchor: give anchor_position, or connect a frame"):
        fw.load(model).compile()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (
            {"headings": ["0 deg"], "fairlead_radius": 5},
            r"fairlead_depth is needed with headings: depth of the fairleads",
        ),
        (
            {"fairleads": [(5, 0, -70)], "anchors": [(850, 0, -320)], "anchor_radius": 853.0},
            r"MooringSystem.anchor_radius goes with headings, and there are none",
        ),
        (
            {"fairleads": [(5, 0, -70)], "anchors": []},
            r"needs its layout once: give headings, or fairleads and anchors",
        ),
        (
            {"headings": ["0 deg", "180 deg"], **LAYOUT, "length": [900, 900, 900]},
            r"MooringSystem.length has 3 values for 2 lines",
        ),
    ],
)
def test_incomplete_layouts(parameters, message):
    with pytest.raises(ParameterError, match=message):
        MooringSystem(**{**LINE, **parameters})
