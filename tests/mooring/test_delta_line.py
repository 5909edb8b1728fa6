"""DeltaLine and CrowFoot: the node by an independent search, yaw stiffness by a closed form, the spring of OC3."""

import numpy as np
import pytest
from scipy.optimize import root

import fowtlib as fw
from fowtlib.components.mechanics import FreeMotion, RigidBody, World
from fowtlib.components.mooring import DeltaLine, MooringSystem
from fowtlib.components.mooring.catenary import Line, fairlead_tension, weight_in_water
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError

EA, WEIGHT = 384.243e6, weight_in_water(77.7066, 0.09)
CHAIN = {"axial_stiffness": EA, "mass_per_length": 77.7066, "diameter": 0.09}
HEADINGS = np.radians([60, 180, 300])


def body():
    model = Assembly("a spar on its lines")
    model.world = World(water_depth=320)
    model.motion = FreeMotion()
    model.body = RigidBody(mass=7e6, inertia=np.diag([4e9, 4e9, 2e8]))
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    return model


def spar(leg=50.0, spread=60.0, **changes):
    """The lines of OC3-Hywind, their last `leg` metres doubled, to fairleads `spread` degrees off their headings."""
    model = body()
    for i, heading in enumerate(HEADINGS):
        angles = heading + np.radians([spread, -spread])
        fairleads = np.column_stack([5.2 * np.cos(angles), 5.2 * np.sin(angles), [-70, -70]])
        anchor = (853.87 * np.cos(heading), 853.87 * np.sin(heading), -320)
        line = DeltaLine(**{"fairleads": fairleads, "leg_length": leg, "length": 902.2 - leg, "anchor_position": anchor,
                            **CHAIN, **changes})  # fmt: skip
        setattr(model, f"line_{i + 1}", line)
        model.connect(model.motion.frame_b, line.frame)
    return model


def moment(state):
    """Moment of the lines on the body about z."""
    return -sum(np.ravel(state[f"line_{i + 1}.frame.t"])[2] for i in range(3))


@pytest.fixture(scope="module")
def oc3():
    return fw.load(spar()).compile()


@pytest.mark.parametrize("motion", [{}, {"surge": 20.0, "yaw": 0.1}, {"surge": -15.0, "sway": 10.0, "pitch": 0.05},
                                    {"yaw": 0.5}])  # fmt: skip
def test_the_node_is_where_an_independent_search_finds_it(oc3, motion):
    state = oc3.initial_state(start={f"motion.{name}": value for name, value in motion.items()})
    anchor = np.array([853.87 * np.cos(HEADINGS[0]), 853.87 * np.sin(HEADINGS[0]), -320])
    ends = [np.ravel(state[f"line_1.delta.{side}.r"]) for side in ("left", "right")]
    line = Line(852.2, WEIGHT, EA)

    def balance(node):
        way = node - anchor
        reach = np.hypot(*way[:2])
        H, V = fairlead_tension(reach, way[2], line)
        total = np.array([*(-H * way[:2] / reach), -V]) - [0, 0, 50 * WEIGHT]
        for end in ends:
            size = np.linalg.norm(end - node)
            T = EA * (size / 50 - 1)
            total = total + (T + np.hypot(T, 1000)) / 2 * (end - node) / size
        return total / 1e5

    guess = np.ravel(state["line_1.delta.node.r"]) + [0.01, -0.02, 0.03]
    found = root(balance, guess, tol=1e-12)
    assert found.success
    assert np.ravel(state["line_1.delta.node.r"]) == pytest.approx(found.x, abs=1e-6)


@pytest.mark.parametrize(("leg", "spread"), [(50.0, 30.0), (50.0, 60.0), (30.0, 60.0), (80.0, 45.0)])
def test_yaw_stiffness_by_a_closed_form(leg, spread):
    """Minus the second derivative of the potential of legs and line by yaw, the node moved out of it."""
    plant = fw.load(spar(leg, spread)).compile()
    state = plant.initial_state()
    H, node = state["line_1.line.horizontal_tension"], np.ravel(state["line_1.delta.node.r"])
    R, far = np.hypot(*node[:2]), state["line_1.line.distance"]
    way = np.ravel(state["line_1.delta.left.r"]) - node
    size = np.linalg.norm(way)
    aside = (way @ [-np.sin(HEADINGS[0]), np.cos(HEADINGS[0]), 0] / size) ** 2
    k = 2 * (EA / leg * aside + state["line_1.delta.left_tension"] / size * (1 - aside))
    expected = 3 * H * (1 + R / far) * (k * R - H) / (k + H / far)
    ends = [moment(plant.initial_state(start={"motion.yaw": yaw})) for yaw in (1e-4, -1e-4)]
    assert (ends[1] - ends[0]) / 2e-4 == pytest.approx(expected, rel=1e-3)


def test_against_the_yaw_spring_of_oc3():
    """Legs of 50 m do about what the spring of 98.34 MN m/rad and the lines at their single fairleads do together."""
    model = body()
    model.mooring = MooringSystem(headings=HEADINGS, fairlead_radius=5.2, fairlead_depth=70, anchor_radius=853.87,
                                  anchor_depth=320, length=902.2, yaw_stiffness="98.34 MN*m/rad", **CHAIN)  # fmt: skip
    model.connect(model.motion.frame_b, model.mooring.frame)
    states = [fw.load(one).compile().initial_state(start={"motion.yaw": 0.1}) for one in (model, spar())]
    substitute, delta = np.ravel(states[0]["mooring.frame.t"])[2], -moment(states[1])
    assert substitute == pytest.approx(11.0e6, rel=0.01)
    assert delta / substitute == pytest.approx(0.90, abs=0.01)


def test_both_engines_turn_a_spar_until_legs_are_slack(oc3):
    start, names = {"motion.yaw": 0.25, "motion.heave": 0.0}, ["motion.yaw", "line_1.delta.right_tension"]
    results = []
    for solver in ("idas", "fixed"):
        with pytest.warns(UserWarning, match=r"line_\d.delta: a leg is slack"):
            results.append(oc3.simulate(2.0, 0.1, solver=solver, start=start, outputs=names))
    for name in names:
        a, b = (result[name].to_numpy() for result in results)
        assert b == pytest.approx(a, abs=2e-3 * np.abs(a).max())
    assert results[0]["line_1.delta.right_tension"][0] < 1000


def test_stiff_legs_start_from_every_span_and_guess():
    """Legs of 150 kN at 1:45 are 15 um longer under their load; one of 15 MN ends where they do, to that."""
    plant = fw.load("dtif_model_scale_delta").compile()
    random = np.random.default_rng(4)
    for span in (*np.linspace(4.95, 5.05, 11), *random.uniform(4.9, 5.08, 10)):
        guess = np.array([0.21, 0, -0.3587]) * random.uniform(0.5, 1.5, 3) + [0, random.uniform(-0.05, 0.05), 0]
        state = plant.initial_state({"span": span, "delta_1.node_start": guess})
        stiffer = plant.initial_state({"span": span, **{f"delta_{k}.axial_stiffness": 15e6 for k in (1, 2, 3)}})
        apart = np.ravel(state["delta_1.offset"]) - np.ravel(stiffer["delta_1.offset"])
        assert np.abs(apart).max() < 5e-5 and state["delta_1.left_tension"] > 4.0
        assert state["line_1.tension"] == pytest.approx(state["line_2.tension"], rel=1e-8)  # from another guess


def test_legs_and_line_are_tunable(oc3):
    state = oc3.initial_state({"line_1.leg_length": 49.0})
    assert state["line_1.delta.left_tension"] > 1.03 * oc3.initial_state()["line_1.delta.left_tension"]


def test_a_delta_has_two_fairleads():
    with pytest.raises(ParameterError, match="fairleads"):
        fw.load(spar(fairleads=[(0, 0, 0)] * 3)).compile()


def test_dimensions_agree():
    assert "nothing wrong" in str(fw.load(spar()).check())
