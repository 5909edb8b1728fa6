"""Every number of a mooring is tunable: a changed run is that of a fresh build, derivatives are those of the model."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import FreeMotion, RigidBody, World, WorldForce
from fowtlib.components.mooring import CatenaryLine, MooringSystem
from fowtlib.components.mooring.lumped_system import LumpedSystem
from fowtlib.language import Assembly

LINES = {"length": [902.2, 900.0, 905.0], "axial_stiffness": 384.243e6, "friction": 0.5}
ROUND = {
    "headings": np.radians([120.0, 245.0, 3.0]), "fairlead_radius": 5.2, "fairlead_depth": 70.0,
    "anchor_radius": 853.87, "anchor_depth": 320.0, "yaw_stiffness": 2e7,
    "mass_per_length": [77.7066, 80.0, 90.0], "diameter": 0.09,
}  # fmt: skip
PLAN = np.column_stack([np.cos(ROUND["headings"]), np.sin(ROUND["headings"])])
POINTS = {
    "fairleads": np.column_stack([5.2 * PLAN, np.full(3, -70.0)]),
    "anchors": np.column_stack([853.87 * PLAN, np.full(3, -320.0)]),
    "weight_per_length": [698.0, 710.0, 720.0], "yaw_stiffness": 2e7,
}  # fmt: skip
LAYOUTS = {"round": {**LINES, **ROUND}, "points": {**LINES, **POINTS}}


def moored(**mooring):
    """A body that its lines and a pendulum's weight hold, pushed to one side and turned."""
    model = Assembly("moored body")
    model.world = World()
    model.motion = FreeMotion()
    model.body = RigidBody(mass=7e6, r_cm=(0, 0, -70), inertia=np.diag([8e9, 8e9, 2e8]))
    model.lift, model.force = Constant(value=(3e5, 1e5, 7e6 * 9.80665 + 1.8e6)), WorldForce()
    model.mooring = MooringSystem(**mooring)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.lift.y, model.force.force)
    for frame in (model.body.frame_a, model.force.frame, model.mooring.frame):
        model.connect(model.motion.frame_b, frame)
    return model


PLANTS = {}


def plant_of(layout):
    if layout not in PLANTS:
        PLANTS[layout] = fw.load(moored(**LAYOUTS[layout])).compile()
    return PLANTS[layout]


MOTIONS = [f"motion.{name}" for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")]


def position(state):
    return np.array([float(state[name]) for name in MOTIONS])


def moved(linear):
    """Derivative of the outputs at rest by the inputs: D - C A^-1 B."""
    A, B, C, D = (np.asarray(matrix) for matrix in (linear.A, linear.B, linear.C, linear.D))
    return D - C @ np.linalg.solve(A, B)


NUMBERS = [(layout, name) for layout in LAYOUTS for name in LAYOUTS[layout]]


def test_every_number_is_covered():
    plain = {"greatest_strain", "breaking_load", "drag_coefficient", "added_mass_coefficient"}  # move nothing at rest
    declared = {name for name, field in MooringSystem.parameters.items() if field.tunable}
    lumped = {name for name, field in LumpedSystem.parameters.items() if field.tunable}  # of lines with dynamics only
    assert declared == plain | lumped | {name for _, name in NUMBERS}
    assert [name for name, field in CatenaryLine.parameters.items() if not field.tunable] == ["dynamics"]
    chosen = {name for name, field in MooringSystem.parameters.items() if not field.tunable}
    assert chosen == {"dynamics", "elements", "waves"}


@pytest.mark.parametrize(("layout", "name"), NUMBERS)
def test_a_changed_number_is_that_of_a_fresh_build(layout, name):
    value = np.array(LAYOUTS[layout][name], dtype=float)
    changed = value + np.radians(2.0) if name == "headings" else value * 1.01
    if name == "anchor_depth":
        changed = value * 0.99
    if name == "anchors":
        changed = value * [1.01, 1.01, 0.99]
    changed_state = plant_of(layout).equilibrium(parameters={f"mooring.{name}": changed})
    fresh = fw.load(moored(**{**LAYOUTS[layout], name: changed})).compile().equilibrium()
    assert position(changed_state) == pytest.approx(position(fresh), rel=1e-9, abs=1e-10)
    for line in ("line_1", "line_2", "line_3"):
        a, b = (float(state[f"mooring.{line}.tension"]) for state in (changed_state, fresh))
        assert a == pytest.approx(b, rel=1e-9)
    assert np.abs(position(changed_state) - position(plant_of(layout).equilibrium())).max() > 1e-7


@pytest.mark.parametrize(("layout", "name"), NUMBERS)
def test_the_derivative_of_the_equilibrium_is_a_difference(layout, name):
    """The parameter is an input of the linear model."""
    plant, path = plant_of(layout), f"mooring.{name}"
    state = plant.equilibrium()
    value = np.array(LAYOUTS[layout][name], dtype=float)
    linear = plant.linearize(state, inputs=[path], outputs=MOTIONS)
    slopes = moved(linear)
    elements = list(np.ndindex(value.shape)) if name not in ("fairleads", "anchors") else [(0, 0), (1, 1), (2, 2)]
    for index in elements:
        number = np.ravel_multi_index(index, value.shape, order="F") if index else 0
        step = np.zeros_like(value)
        share = 1e-2 if name == "yaw_stiffness" else 1e-4  # it turns the body by 1e-5 rad
        step[index] = 1e-3 if name in ("anchors", "anchor_depth") else share * abs(value[index])
        ahead, behind = (position(plant.equilibrium(parameters={path: value + sign * step})) for sign in (1, -1))
        difference = (ahead - behind) / (2 * step[index])
        assert slopes[:, number] == pytest.approx(difference, rel=2e-4, abs=2e-5 * np.abs(difference).max())


def hung(**line):
    """A body on one line of its own."""
    model = moored(**LAYOUTS["round"])
    own = {"length": 880.0, "axial_stiffness": 3e8, "weight_per_length": 500.0, "anchor_position": (0, -815, -320.0)}
    model.own = CatenaryLine(**{**own, **line})
    model.connect(model.motion.frame_b, model.own.fairlead)
    return model


@pytest.mark.parametrize(
    ("name", "value", "step"),
    [("length", 880.0, 0.05), ("axial_stiffness", 3e8, 3e4), ("weight_per_length", 500.0, 0.05),
     ("anchor_position", (0.0, -815.0, -320.0), 1e-3)],
)  # fmt: skip
def test_a_line_by_itself(name, value, step):
    plant = fw.load(hung()).compile()
    linear = plant.linearize(plant.equilibrium(), inputs=[f"own.{name}"], outputs=MOTIONS)
    slopes = moved(linear)
    for i in range(np.size(value)):
        change = np.zeros(np.shape(value))
        change.flat[i] = step
        ends = [position(plant.equilibrium(parameters={f"own.{name}": value + sign * change})) for sign in (1, -1)]
        difference = (ends[0] - ends[1]) / (2 * step)
        assert slopes[:, i] == pytest.approx(difference, rel=2e-4, abs=2e-5 * np.abs(difference).max())
    other = plant.equilibrium(parameters={f"own.{name}": np.multiply(value, 0.999)})
    fresh = fw.load(hung(**{name: np.multiply(value, 0.999)})).compile().equilibrium()
    assert position(other) == pytest.approx(position(fresh), rel=1e-9, abs=1e-10)
